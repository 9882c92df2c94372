"""Demonstrations: who plays, what is kept, that it plays again bit for bit, and that nothing is lost on the way."""

import errno
import json
import os
import shutil

import minari
import numpy as np
import pytest

from regista.envs.football.replay import load_record, replay
from regista.experiments.__main__ import main
from regista.experiments.imitation import demonstrations
from regista.experiments.imitation.demonstrator import _Steps
from regista.experiments.run.table import read_columns

pytestmark = pytest.mark.slow

# A striker runs at an empty goal from near or far; from far he is too late.
RUN = """
from football.behaviors import *
param game_duration = 30
param end_episode_on_score = True
behavior Run():
    while True:
        take SetDirection(5), Sprint()
ego = LeftCF at Range(50, 90) @ 0, with behavior Run()
Ball ahead of ego by 1.5
"""
PAIR = RUN + "LeftCM at 40 @ Range(5, 20), with behavior Run()\n"


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "run.scenic"
    path.write_text(RUN)
    return path


def demonstrate(program, out, *flags):
    return main(["demonstrate", str(program), "--control", "1", "--out", str(out), *flags])


def same_folder(one, other):
    files = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(other) for path in other.rglob("*") if path.is_file())
    return all((one / path).read_bytes() == (other / path).read_bytes() for path in files if path.suffix != ".npz")


def test_successes_are_kept_as_records_and_as_a_minari_data_set(program, tmp_path, capsys):
    out = tmp_path / "demos"
    assert demonstrate(program, out, "--episodes", "60") == 0
    told = capsys.readouterr().out
    data = minari.MinariDataset(out / "data")
    assert (data.total_episodes, len(list(data))) == (60, 60)
    table = read_columns(out / "episodes.csv")
    kept = ~np.isnan(table["episode"])
    assert kept.sum() == 60 and (table["return"][kept] > 0).all() and (table["length"] == 30).any()
    successes = int((table["return"] > 0).sum())
    assert f"60 episodes, 256 played, success {successes / 256:.2f} [" in told
    record = load_record(out / "records" / "0000.npz")
    moments = list(replay(record))  # raises where it comes out differently
    assert len(moments) == record.lengths.max() + 1 and record.scripted
    assert main(["play", "--replay", str(out / "records" / "0000.npz"), "--match", "7"]) == 0
    steps, matches = record.lengths[7], len(record.lengths)
    words = f"{steps} steps replayed exactly as recorded, match 7 of {matches}; final score 1 : 0\n"
    assert capsys.readouterr().out == words
    assert main(["play", "--replay", str(out / "records" / "0000.npz"), "--match", "999"]) == 2
    metadata = list(data.storage.get_episode_metadata(range(60)))
    for number, episode in enumerate(data):
        length = int(table["length"][kept][number])
        assert episode.observations.shape == (length + 1, *data.observation_space.shape)
        assert episode.terminations[-1] and not episode.terminations[:-1].any() and not episode.truncations.any()
        assert episode.rewards.sum() == table["return"][kept][number] == 1
        assert episode.actions.tolist() == record.actions[:length, number, ...].ravel().tolist()
        assert set(episode.actions.tolist()) == {5, 13} and episode.infos["told"].all()
        assert metadata[number]["options"]["theta"] == record.state["levels"]["theta"][number]
        assert metadata[number]["options"]["theta"] == pytest.approx(table["theta/ego.x"][kept][number])
        assert metadata[number]["seed"] == int(record.state["levels"]["seed"][number])


def test_demonstrations_carry_the_version_and_take_in_no_other(program, tmp_path, capsys):
    out = tmp_path / "demos"
    assert demonstrate(program, out, "--episodes", "4") == 0
    metadata = json.loads((out / "data" / "metadata.json").read_text())
    assert metadata["dataset_id"].endswith("-v1") and json.loads(metadata["env_spec"])["id"].endswith("-v1")
    assert metadata["regista"]["simulator"] == 1
    settings = json.loads((out / "demonstrations.json").read_text())
    assert settings.pop("about") == {"simulator": 1}
    (out / "demonstrations.json").write_text(json.dumps(settings))
    capsys.readouterr()
    for command in (
        ["demonstrate", str(program), "--control", "1", "--episodes", "8", "--out", str(out)],
        ["clone", str(out)],
    ):
        assert main(command) == 1
        said = capsys.readouterr().err
        assert f"{out} was recorded on an unnumbered simulator, from before version 1; on version 1 " in said
        assert "nothing can be added to it" in said or "it cannot be cloned" in said


@pytest.mark.long
def test_what_is_seen_is_what_the_replay_shows(program, tmp_path):
    out = tmp_path / "demos"
    flags = ["--episodes", "5", "--keep", "all", "--representation", "smm_stacked"]
    assert demonstrate(program, out, *flags) == 0
    record, data = load_record(out / "records" / "0000.npz"), minari.MinariDataset(out / "data")
    env = record.make_env()
    seen = env.observe()
    for step in range(8):
        assert all((data[k].observations[step] == seen[k]).all() for k in range(5))
        seen = env.step(record.actions[step])[0]
    assert set(np.unique(data[0].observations)) == {0, 255} and data[0].observations.shape[1:] == (72, 96, 16)


def test_images_are_kept_whole():
    planes = np.random.default_rng(0).integers(0, 2, (6, 3, 7, 5, 4)).astype(np.uint8) * np.uint8(255)
    steps = _Steps(1, planes=True)
    for seen in planes[:5]:
        done = {"agent_actions": np.full((3, 1), 4), "agent_rewards": np.zeros((3, 1))}
        steps.add(seen, done, np.zeros(3), np.zeros(3, bool))
    steps.end(np.array([1]), planes[5])
    assert (steps.episode(1, 5).observations == planes[:, 1]).all()


def test_several_agents_have_data_of_their_own(tmp_path):
    program, out = tmp_path / "pair.scenic", tmp_path / "demos"
    program.write_text(PAIR)
    assert main(["demonstrate", str(program), "--control", "2", "--episodes", "20", "--out", str(out)]) == 0
    episode = minari.MinariDataset(out / "data")[0]
    steps = len(episode.rewards)
    assert episode.actions.shape == (steps, 2) == episode.infos["told"].shape
    assert episode.observations.shape[:2] == (steps + 1, 2)
    assert episode.infos["agent_rewards"].shape == (steps, 2)


@pytest.mark.long
def test_it_goes_on_where_it_was_killed(program, tmp_path, monkeypatch, capsys):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    flags = ["--episodes", "400"]
    assert demonstrate(program, whole, *flags) == 0
    add = demonstrations.Demonstrations.add

    def kill(self, number, *rest):
        if number == 1:
            raise KeyboardInterrupt
        return add(self, number, *rest)

    monkeypatch.setattr(demonstrations.Demonstrations, "add", kill)
    assert demonstrate(program, killed, *flags) == 130
    monkeypatch.setattr(demonstrations.Demonstrations, "add", add)
    assert demonstrate(program, killed, *flags) == 0
    assert same_folder(whole, killed)
    assert demonstrate(program, killed, *flags) == 0  # there is nothing to do
    fewer = tmp_path / "fewer"
    assert demonstrate(program, fewer, "--episodes", "30") == demonstrate(program, fewer, *flags) == 0
    assert same_folder(whole, fewer)


@pytest.mark.long
def test_a_damaged_part_is_named_and_can_be_played_anew(program, tmp_path, capsys):
    out, copy = tmp_path / "demos", tmp_path / "copy"
    assert demonstrate(program, out, "--episodes", "400") == 0
    shutil.copytree(out, copy)
    part = out / "data" / "part-0001.hdf5"
    part.write_bytes(part.read_bytes()[:5000])
    capsys.readouterr()
    assert demonstrate(program, out, "--episodes", "400") == 1
    assert capsys.readouterr().err.startswith(f"regista: {part} is damaged or incomplete; delete it and run")
    part.unlink()
    assert demonstrate(program, out, "--episodes", "400") == 0
    assert same_folder(out, copy)


def test_a_full_disk_loses_nothing(program, tmp_path, monkeypatch, capsys):
    out = tmp_path / "demos"
    assert demonstrate(program, out, "--episodes", "30") == 0
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    fsync, full = os.fsync, []

    def refuse(handle):
        full.append(handle)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", refuse)
    capsys.readouterr()
    assert demonstrate(program, out, "--episodes", "400") == 1
    assert full and capsys.readouterr().err == f"regista: cannot write {out}: No space left on device\n"
    monkeypatch.setattr(os, "fsync", fsync)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (
            ["--representation", "simple115"],
            "was made with env.representation = features; it cannot continue with simple",
        ),
        (["--seed", "3"], "was made with seed = 0; it cannot continue with 3"),
        (["--keep", "all"], "was made with keep = successful; it cannot continue with all"),
    ],
)
def test_a_folder_holds_one_kind(program, tmp_path, capsys, flags, message):
    out = tmp_path / "demos"
    assert demonstrate(program, out, "--episodes", "5") == 0
    assert demonstrate(program, out, "--episodes", "5", *flags) == 1
    assert message in capsys.readouterr().err
    program.write_text(RUN + "RightCB at 0 @ 30\n")
    assert demonstrate(program, out, "--episodes", "5") == 1
    assert "the program has changed since" in capsys.readouterr().err


def test_foreign_folders_are_left_alone(program, tmp_path, capsys):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "text").write_text("ten years")
    assert demonstrate(program, tmp_path / "thesis") == 1
    assert capsys.readouterr().err.endswith("exists and holds no demonstrations; choose another --out\n")


def test_who_never_succeeds_gives_up(tmp_path, capsys):
    program = tmp_path / "away.scenic"
    program.write_text(RUN.replace("SetDirection(5)", "SetDirection(1)"))
    assert demonstrate(program, tmp_path / "demos", "--episodes", "3", "--max-played", "300") == 1
    captured = capsys.readouterr()
    assert "only 0 of 512 episodes were successful, 3 were requested" in captured.err
    assert "0 episodes, 512 played, success 0.00 [0.00, 0.01]" in captured.out
    assert json.loads((tmp_path / "demos" / "data" / "metadata.json").read_text())["total_episodes"] == 0


@pytest.mark.long
def test_a_trained_student_demonstrates(program, tmp_path, capsys):
    run = tmp_path / "run"
    flags = ["--total-env-steps", "512", "--num-envs", "8", "--eval-every", "0", "--no-record", "--control", "1"]
    assert main(["train", str(program), "--method", "dr", "--out", str(run), *flags]) == 0
    out = tmp_path / "demos"
    assert main(["demonstrate", "--run", str(run), "--episodes", "10", "--keep", "all", "--out", str(out)]) == 0
    record = load_record(out / "records" / "0000.npz")
    assert not record.scripted and len(list(replay(record))) == record.lengths.max() + 1
    assert len(np.unique(record.actions)) > 5
    assert main(["train", "--resume", str(run), "--total-env-steps", "1024"]) == 0
    capsys.readouterr()
    more = ["demonstrate", "--run", str(run), "--keep", "all", "--out", str(out), "--episodes"]
    assert main([*more, "300"]) == 1
    said = f"{out} holds episodes of {run} at 512 env_steps, which now has 1024; choose another --out"
    assert said in capsys.readouterr().err
    assert main(["demonstrate", str(program), "--run", str(run)]) == 2
    assert "exclude each other" in capsys.readouterr().err
    assert main(["demonstrate", "--run", str(run), "--control", "all"]) == 2
    assert "--control and --run exclude each other: a run has its training settings" in capsys.readouterr().err


def test_the_environment_is_recovered_from_the_data(program, tmp_path):
    out = tmp_path / "demos"
    flags = ["--keep", "all", "--episodes", "3", "--representation", "simple115"]
    assert demonstrate(program, out, *flags) == 0
    data = minari.MinariDataset(out / "data")
    env = data.recover_environment()
    assert env.observation_space == data.observation_space and env.action_space == data.action_space
    (theta,) = (each["options"]["theta"] for each in data.storage.get_episode_metadata([2]))
    seen, _ = env.reset(options={"theta": theta})
    assert (seen[:22] == data[2].observations[0][:22]).all()  # everybody stands where he stood


@pytest.mark.sample(2)
@pytest.mark.parametrize(("control", "played"), [("closest1", "run"), ("2", "pair"), ("all", "pair")])
def test_one_agent_has_another_semi_expert_than_a_team(program, tmp_path, monkeypatch, control, played):
    from regista.minigames import suites
    from regista.minigames.suites import Minigame

    pair = tmp_path / "pair.scenic"
    pair.write_text(PAIR)
    game = Minigame("game", tmp_path / "none.scenic", (), "", expert=program, team_expert=pair)
    monkeypatch.setitem(suites.NAMED, "game", game)
    out = tmp_path / "demos"
    assert main(["demonstrate", "game", "--control", control, "--episodes", "2", "--out", str(out)]) == 0
    assert (out / "program.scenic").read_text() == {"run": RUN, "pair": PAIR}[played]


def test_a_control_mode_that_does_not_fit_leaves_nothing_behind(program, tmp_path, capsys):
    out = tmp_path / "demos"
    assert main(["demonstrate", str(program), "--control", "3", "--out", str(out)]) == 1
    assert "control '3' needs 3 players in the left team, which has 1" in capsys.readouterr().err
    assert not out.exists()


def test_a_defence_that_concedes_nothing_is_a_success(tmp_path, capsys):
    path, out = tmp_path / "hold.scenic", tmp_path / "demos"
    path.write_text(f"{RUN}param defending = True\n")
    assert demonstrate(path, out, "--episodes", "256") == 0
    table = read_columns(out / "episodes.csv")
    assert (table["success"] == 1).all() and (table["return"] == 0).any()
    assert "256 played, success 1.00" in capsys.readouterr().out
