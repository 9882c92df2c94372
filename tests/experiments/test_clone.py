"""From demonstrations to a clone to a training that begins with it, by the command line."""

import json
import shutil

import numpy as np
import pytest
import torch

from regista.experiments.__main__ import main
from regista.experiments.imitation.cloning_data import CloningData
from regista.experiments.imitation.demonstrations import Demonstrations
from regista.experiments.run.build import find_game
from regista.experiments.run.evaluator import load_method
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.table import read_columns, read_rows
from tests.experiments.test_demonstrate import PAIR, RUN
from ued.core import checkpoint

pytestmark = pytest.mark.slow

FEW = ["--epochs", "4", "--ppo.hidden-size", "16"]
SHORT = ["--total-env-steps", "2048", "--num-envs", "16", "--eval-every", "0", "--no-record"]


@pytest.fixture(scope="module")
def demos(tmp_path_factory):
    """Return demonstrations of one agent and of two, in a folder with their programs."""
    folder = tmp_path_factory.mktemp("demos")
    for name, program, control in (("one", RUN, "1"), ("two", PAIR, "2")):
        (folder / f"{name}.scenic").write_text(program)
        command = ["demonstrate", str(folder / f"{name}.scenic"), "--episodes", "100", "--out", str(folder / name)]
        assert main([*command, "--control", control]) == 0
    return folder


def student_of(run):
    return checkpoint.load(run / "checkpoint.pt")["method"]["learners"][0]["ppo"]["student"]


def untimed(path):
    return [{name: cell for name, cell in row.items() if not name.startswith("time/")} for row in read_rows(path)]


@pytest.mark.long
@pytest.mark.drawn
@pytest.mark.parametrize("name", ["one", "two"])
def test_a_clone_is_a_run_that_can_be_evaluated_and_trained_on(demos, tmp_path, capsys, name):
    clone, run = tmp_path / "clone", tmp_path / "run"
    assert main(["clone", str(demos / name), "--out", str(clone), "--epochs", "30", "--ppo.hidden-size", "16"]) == 0
    names = {"config.json", "clone.json", "program.scenic", "cloning.csv", "cloning.png", "cloning.pt"}
    assert {path.name for path in clone.iterdir()} == names | {"accuracy.csv", "checkpoint.pt"}
    table, actions = read_columns(clone / "cloning.csv"), read_rows(clone / "accuracy.csv")
    assert table["held_out/accuracy"][-1] > 0.9 and table["held_out/loss"][-1] < table["held_out/loss"][0]
    done = {row["name"]: int(row["done"]) for row in actions}
    assert done["sprint"] > 0 and done["right"] > 0 and sum(done.values()) == done["sprint"] + done["right"]
    capsys.readouterr()
    assert main(["evaluate", str(clone), "--episodes", "300", "--levels", "0", "--json"]) == 0
    rows = {row["method"]: row for row in json.loads(capsys.readouterr().out)["results"]}
    assert rows["clone"]["env_steps"] == 0 and rows["clone"]["goals"] > rows["random"]["goals"] + 9
    assert (
        main(
            ["train", str(demos / f"{name}.scenic"), "--method", "dr", "--from", str(clone), "--out", str(run), *SHORT]
        )
        == 0
    )
    settings = RunFolder.open(run).config
    assert settings.ppo.hidden_size == 16 and settings.env.control == RunFolder.open(clone).config.env.control
    assert RunFolder.open(run).label == "dr fine-tuned"
    seen = student_of(run)["normaliser.count"] - student_of(clone)["normaliser.count"]
    assert int(np.max(np.asarray(seen))) == 2048  # it goes on counting


def test_a_training_begins_with_the_clone_and_stays_close_to_it_if_told(demos, tmp_path, capsys):
    clone = tmp_path / "clone"
    assert main(["clone", str(demos / "one"), "--out", str(clone), *FEW]) == 0
    moved = {}
    for name, flags in (("free", []), ("held", ["--kl-to-clone", "100", "--kl-share", "1"])):
        run = tmp_path / name
        command = ["train", "--method", "dr", "--from", str(clone), "--out", str(run), "--seed", "3", *SHORT, *flags]
        assert main(command) == 0
        weights = [student_of(path)["actor.layer.weight"] for path in (run, clone)]
        moved[name] = float((weights[0] - weights[1]).abs().mean())
    assert RunFolder.open(tmp_path / "free").config.minigame == RunFolder.open(clone).config.minigame
    assert 0 < moved["held"] < moved["free"]


@pytest.mark.long
def test_a_killed_training_from_a_clone_goes_on_to_the_same_numbers(demos, tmp_path, monkeypatch):
    from ued.methods.dr import DR

    clone, whole, killed = (tmp_path / name for name in ("clone", "whole", "killed"))
    assert main(["clone", str(demos / "one"), "--out", str(clone), *FEW]) == 0
    flags = ["--method", "dr", "--from", str(clone), "--kl-to-clone", "1", "--checkpoint-seconds", "0", *SHORT]
    flags += ["--total-env-steps", "4096"]
    assert main(["train", "--out", str(whole), *flags]) == 0
    update = DR.update

    def kill(self):
        if self.updates == 2:
            raise KeyboardInterrupt
        return update(self)

    def kill_at_once(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("regista.experiments.run.origin.save", kill_at_once)
        assert main(["train", "--out", str(killed), *flags]) == 130
    assert main(["train", "--resume", str(killed)]) == 1  # for it has not yet what it is to begin with
    monkeypatch.setattr(DR, "update", kill)
    assert main(["train", "--out", str(killed), *flags]) == 130
    monkeypatch.setattr(DR, "update", update)
    (clone / "checkpoint.pt").unlink()  # a run keeps what it began with
    assert main(["train", "--resume", str(killed)]) == 0
    assert untimed(whole / "metrics.csv") == untimed(killed / "metrics.csv")
    assert len(untimed(whole / "metrics.csv")) == 4


@pytest.mark.long
def test_cloning_goes_on_where_it_was_killed(demos, tmp_path, monkeypatch, capsys):
    from ued.learning.cloning import Cloner

    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert main(["clone", str(demos / "one"), "--out", str(whole), *FEW]) == 0
    learn = Cloner.learn

    def kill(self, chunks):
        if self.epoch == 2:
            raise KeyboardInterrupt
        return learn(self, chunks)

    monkeypatch.setattr(Cloner, "learn", kill)
    assert main(["clone", str(demos / "one"), "--out", str(killed), *FEW]) == 130
    monkeypatch.setattr(Cloner, "learn", learn)
    assert main(["clone", str(demos / "one"), "--out", str(killed), *FEW]) == 0
    assert untimed(whole / "cloning.csv") == untimed(killed / "cloning.csv")
    assert (whole / "accuracy.csv").read_text() == (killed / "accuracy.csv").read_text()
    ours, theirs = student_of(whole), student_of(killed)
    assert all(torch.equal(ours[name], theirs[name]) for name in ours)
    capsys.readouterr()
    assert main(["clone", str(demos / "one"), "--out", str(killed), *FEW, "--seed", "4"]) == 1
    assert "holds a clone with other settings" in capsys.readouterr().err


def test_a_clone_of_fewer_episodes_is_not_continued_on_more(demos, tmp_path, capsys):
    grown, clone = tmp_path / "demos", tmp_path / "clone"
    shutil.copytree(demos / "one", grown)
    words = ["clone", str(grown), "--out", str(clone), *FEW]
    assert main(words) == 0
    before = (clone / "accuracy.csv").read_text()
    more = ["demonstrate", str(demos / "one.scenic"), "--control", "1", "--episodes", "120", "--out", str(grown)]
    assert main(more) == 0
    said = refused(capsys, *words)
    assert f"{clone} was cloned from 100 episodes, {grown} now has 120; choose another --out" in said
    assert (clone / "accuracy.csv").read_text() == before


def test_critics_of_opponents_learn_the_returns_of_their_own_side(tmp_path):
    program, out = tmp_path / "against.scenic", tmp_path / "demos"
    program.write_text(RUN + "RightCB at -80 @ 30\n")
    play = ["demonstrate", str(program), "--control", "1", "--right-control", "1", "--episodes", "30"]
    assert main([*play, "--out", str(out)]) == 0
    assert main(["clone", str(out), "--out", str(tmp_path / "clone"), "--epochs", "30", "--ppo.hidden-size", "16"]) == 0
    method, _ = load_method(RunFolder.open(tmp_path / "clone"), find_game(str(program)))
    data = CloningData(Demonstrations.open(out), 0.995, 0.1, 0)
    value = method.student(next(data.chunks(held_out=False)).observation)[1].mean(0)  # [2] in successful episodes
    assert value[0] > 0.5 and value[1] < -0.5


@pytest.mark.long
def test_demonstrations_that_do_not_fit_into_memory_are_read_in_chunks(demos, tmp_path, monkeypatch):
    from regista.experiments.imitation import cloning_data

    one = tmp_path / "one"
    more = ["demonstrate", str(demos / "one.scenic"), "--control", "1", "--episodes", "150", "--out", str(one)]
    assert main(more) == 0
    monkeypatch.setattr(cloning_data, "CHUNK_BYTES", 1)
    data = cloning_data.CloningData(cloning_data.Demonstrations.open(one), 0.99, 0.1, 0)
    chunks = [len(chunk.returns) for chunk in data.chunks(held_out=False)]
    held_out = sum(len(chunk.returns) for chunk in data.chunks(held_out=True))
    assert len(chunks) > 1 and data.is_held_out.sum() == 15
    steps = json.loads((one / "data" / "metadata.json").read_text())["total_steps"]
    assert sum(chunks) + held_out == steps
    assert main(["clone", str(one), "--out", str(tmp_path / "clone"), *FEW]) == 0


def refused(capsys, *command):
    capsys.readouterr()
    assert main(list(map(str, command))) == 1
    text = capsys.readouterr().err
    assert text.count("\n") == 1
    return text


def test_what_does_not_fit_is_refused_in_a_sentence(demos, tmp_path, capsys):
    clone, run = tmp_path / "clone", tmp_path / "run"
    assert "holds no demonstrations: it has no" in refused(capsys, "clone", tmp_path, "--out", clone)
    text = refused(capsys, "clone", demos / "one", "--minigame", "1v1Free", "--out", clone)
    assert "the demonstrations belong to another game" in text and not clone.exists()
    assert main(["clone", str(demos / "one"), "--out", str(clone), *FEW]) == 0
    one, two = demos / "one.scenic", demos / "two.scenic"
    begin = ["train", "--method", "dr", "--from", clone, "--out", run, *SHORT]
    gru = ("--ppo.memory", "gru")
    assert "--ppo.memory must be none, got gru" in refused(capsys, "clone", demos / "one", "--out", clone, *gru)
    assert "a student with ppo.hidden_size = 16; this run cannot" in refused(capsys, *begin, "--hidden-size", "32")
    text = refused(capsys, *begin, "--representation", "simple115")
    assert "a student with env.representation = features; this run cannot start from it, since it has simple115" in text
    assert "a student with env.control = 1" in refused(capsys, *begin, two, "--control", "2")
    assert not run.exists()
    assert "which observes something other than" in refused(capsys, *begin, "1v1Free")
    assert main([*map(str, begin), str(one)]) == 0  # the name is still free
    assert "is a clone; start a new run from it" in refused(capsys, "train", "--resume", clone)
    assert "is not a checkpoint" in refused(capsys, "train", "--from", demos / "one.scenic")
    assert main(["train", str(one), "--kl-to-clone", "1"]) == 2


def test_a_truncated_data_set_is_refused(demos, tmp_path, capsys):
    import h5py

    for number, damage in enumerate(("cut", "part", "unfinished", "actions", "summary")):
        copy = tmp_path / damage
        shutil.copytree(demos / "one", copy)
        part = copy / "data" / "part-0000.hdf5"
        if damage == "cut":
            part.write_bytes(part.read_bytes()[:3000])
        elif damage in ("actions", "summary"):
            with h5py.File(part, "r+") as file:
                if damage == "actions":
                    file["episode_0/actions"][0] = 99
                else:
                    file["summary/kept"][0], file["summary/lengths"][0] = True, -3
        else:
            (part if damage == "part" else copy / "data" / "metadata.json").unlink()
        words = (
            "is damaged or incomplete; delete it",
            "is incomplete: it holds",
            "is not finished",
        )
        out = tmp_path / f"clone of {damage}"
        assert (*words, words[0], words[0])[number] in refused(capsys, "clone", copy, "--out", out)
        assert damage == "actions" or not out.exists()


def test_a_clone_whose_table_is_damaged_is_refused_and_left_alone(demos, tmp_path, capsys):
    out = tmp_path / "clone"
    words = ["clone", str(demos / "one"), "--out", str(out), *FEW]
    assert main(words) == 0
    table = out / "cloning.csv"
    table.write_text(table.read_text().replace("\n1,", "\nx,"))
    (out / "program.scenic").unlink()
    assert main(words) == 1 and "cloning.csv" in capsys.readouterr().err
    assert not (out / "program.scenic").exists()


@pytest.mark.long
def test_parameters_of_the_program_are_kept_by_clones_and_missed_by_others(tmp_path, capsys):
    program = tmp_path / "run.scenic"
    program.write_text(RUN)
    run, demos, clone = tmp_path / "run", tmp_path / "demos", tmp_path / "clone"
    first = ["train", str(program), "--method", "dr", *SHORT, "--control", "1", "--param", "game_duration=7"]
    assert main([*first, "--out", str(run)]) == 0
    assert main(["demonstrate", "--run", str(run), "--episodes", "20", "--keep", "all", "--out", str(demos)]) == 0
    assert main(["clone", str(demos), "--out", str(clone), *FEW]) == 0
    assert RunFolder.open(clone).config.program.param == ("game_duration=7",)
    capsys.readouterr()
    second = ["train", str(program), "--method", "dr", *SHORT, "--from", str(clone)]
    assert main([*second, "--param", "game_duration=7", "--out", str(tmp_path / "same")]) == 0
    assert "other settings of the program" not in capsys.readouterr().err
    assert main([*second, "--out", str(tmp_path / "other")]) == 0
    said = (
        f"warning: {clone} was trained with other settings of the program: param = game_duration=7 there and none here"
    )
    assert said in capsys.readouterr().err
