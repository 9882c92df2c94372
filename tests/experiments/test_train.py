"""Runs: what is in the folder, how they stop and go on, what is refused. On a probe, with football at the end."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import scenic_lite
from regista.experiments.__main__ import main
from regista.experiments.calls import train as train_in_python
from regista.experiments.run import build
from regista.experiments.run.config import ProgramConfig, TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import football_game
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.table import read_columns, read_rows
from tests.experiments.probe import ProbeMethod

ROOT = Path(__file__).parents[2]
SHORT = ["--total-env-steps", "20000", "--eval-every", "5000", "--eval-episodes", "16", "--no-record"]


def without_time(path):
    """Return the rows of a table without its wall-clock columns."""
    return [{name: cell for name, cell in row.items() if not name.startswith("time/")} for row in read_rows(path)]


@pytest.mark.slow
@pytest.mark.drawn
def test_a_run_leaves_what_the_folder_promises(probe, tmp_path, capsys):
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT, "--record"]) == 0
    names = {path.name for path in (tmp_path / "run").iterdir()}
    wanted = {"config.json", "metrics.csv", "levels.csv", "checkpoint.pt", "curriculum.rrd"}
    wanted |= {"program.scenic", "learning_curve.png", "replays.csv"}
    assert names == wanted
    metrics = read_columns(tmp_path / "run" / "metrics.csv")
    assert metrics["update"].tolist() == list(range(1, 21))
    assert metrics["env_steps"].tolist() == list(range(1000, 20001, 1000))
    evaluated = [
        update for update, value in zip(metrics["update"], metrics["eval/easy"], strict=True) if value == value
    ]
    assert evaluated == [1, 5, 10, 15, 20]
    spent = metrics["eval_env_steps"][metrics["update"] == 5]
    assert spent == [16 * 4]  # 16 episodes of one step on each of four scenes, beside env_steps
    levels = read_columns(tmp_path / "run" / "levels.csv")
    assert len(levels["update"]) == 20 * 8
    assert {"theta/place.x", "return/protagonist", "score"} <= set(levels)
    assert "20k env_steps, 20 updates" in capsys.readouterr().out


def test_a_run_that_tests_nothing_makes_no_environments_for_it(probe, tmp_path, monkeypatch):
    made, make = [], build.make_upomdp
    monkeypatch.setattr(build, "make_upomdp", lambda *args: made.append(args) or make(*args))
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT, "--eval-every", "0"]) == 0
    assert len(made) == 1


@pytest.mark.slow
def test_every_program_is_read_once(monkeypatch):
    read = []
    load = scenic_lite.load
    monkeypatch.setattr(scenic_lite, "load", lambda path, *settings: read.append(path) or load(path, *settings))
    game, config = football_game("1v1Restricted"), TrainConfig()
    game.source(config)
    for settings in (config, config.scored()):
        for scene in game.task(settings).scenes().values():
            scene(1).close()
    assert len(read) == len(set(read)) == 4


def test_the_settings_of_a_program_are_part_of_the_run(probe, tmp_path, capsys):
    program, path = tmp_path / "mine.scenic", tmp_path / "run"
    program.write_text("param far = 3\nego = LeftCM at 0 @ globalParameters.far\n")
    assert main(["train", str(program), "-p", "far=5", "--param", "name=dusk", "--out", str(path), *SHORT]) == 0
    settings = RunFolder.open(path).config
    assert settings.program == ProgramConfig(param=("far=5", "name=dusk"))
    params = football_game(str(program)).program(settings).params
    assert (params["far"], params["name"]) == (5, "dusk")
    capsys.readouterr()
    assert main(["train", "--resume", str(path), "-p", "far=6", "--total-env-steps", "22000"]) == 1
    assert "was trained with program.param = ('far=5', 'name=dusk')" in capsys.readouterr().err


@pytest.mark.long
def test_a_mixture_is_trained_and_recorded_by_program(tmp_path):
    """22 players beside 2: observations are padded, and each test is one program seen as in the mixture."""
    names = "grf/empty_goal_close+1v1Restricted"
    flags = ["--num-envs", "8", "--eval-episodes", "2", "--num-steps", "128", "--total-env-steps", "6000"]
    command = ["train", names, "--method", "paired", "--record-rollouts", "1", "--out", str(tmp_path / "run"), *flags]
    assert main(command) == 0
    run = RunFolder.open(tmp_path / "run")
    rows = read_rows(run.metrics.path)
    assert run.config.minigame == names
    shares = [(row["program/grf/empty_goal_close"], row["program/1v1Restricted"]) for row in rows]
    assert [float(one) + float(other) for one, other in shares if one]
    assert all(float(one) + float(other) == pytest.approx(1) for one, other in shares if one)
    assert {"eval/grf/empty_goal_close", "eval/grf/empty_goal_close/test", "eval/1v1Restricted/hard"} <= set(rows[0])
    assert (tmp_path / "run" / "curriculum.rrd").stat().st_size > 10_000
    assert main(["inspect", names]) == 2


def test_points_of_a_mixture_are_those_of_its_programs():
    import numpy as np

    game, config = football_game("1v1Free+ChoosePassing"), TrainConfig()
    programs, mixed = [part.program(config) for part in game.games], game.task(config)
    painter = mixed.painter(mixed.make(1))
    own = [task.painter(task.make(1)) for task in (part.task(config) for part in game.games)]
    theta = np.zeros((2, 1 + max(program.dim for program in programs)))
    theta[:, 0] = [-0.5, 0.5]
    places = painter.positions(theta)
    for k, program in enumerate(programs):
        drawn = ~np.isnan(places[k, :, 0])
        assert sorted(painter.classes[drawn]) == sorted(own[k].classes)
        expected = own[k].positions(np.zeros((1, program.dim)))[0]
        assert np.allclose(np.sort(places[k, drawn], 0), np.sort(expected, 0))
        assert np.allclose(places[k, painter.focus], expected[-1])  # the ball


@pytest.mark.slow
def test_an_existing_run_is_not_overwritten(probe, tmp_path, capsys):
    command = ["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT]
    assert main(command) == 0
    before = (tmp_path / "run" / "metrics.csv").read_bytes()
    assert main(command) == 1
    path = f"{tmp_path}/run"
    sentence = f"regista: {path} already holds a run; continue it with --resume {path}, or choose another --out\n"
    assert capsys.readouterr().err == sentence
    assert (tmp_path / "run" / "metrics.csv").read_bytes() == before


@pytest.mark.slow
def test_a_run_that_never_began_leaves_the_name_free(probe, tmp_path, monkeypatch, capsys):
    from regista.experiments.run import build
    from regista.experiments.run.errors import CommandError

    make_method = build.make_method

    def fail(*_):
        raise CommandError("no such luck")

    monkeypatch.setattr(build, "make_method", fail)
    command = ["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT]
    assert main(command) == 1
    monkeypatch.setattr(build, "make_method", make_method)
    assert main([*command, "--seed", "4"]) == 0
    assert RunFolder.open(tmp_path / "run").config.seed == 4


def test_a_foreign_folder_is_left_alone(probe, tmp_path, capsys):
    (tmp_path / "thesis.txt").write_text("ten years of work")
    assert main(["train", "1v1Restricted", "--out", str(tmp_path), *SHORT]) == 1
    assert capsys.readouterr().err == f"regista: {tmp_path} exists and is not a run folder; choose another --out\n"
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


@pytest.mark.slow
def test_a_stopped_run_continues_to_the_same_numbers(probe, tmp_path, monkeypatch, capsys):
    from tests.experiments.probe import ProbeMethod

    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "whole"), *SHORT]) == 0
    update = ProbeMethod.update

    def interrupted(self):
        if self.updates == 7:
            os.kill(os.getpid(), signal.SIGINT)
        return update(self)

    monkeypatch.setattr(ProbeMethod, "update", interrupted)
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "cut"), *SHORT]) == 130
    assert f"continue with: regista train --resume {tmp_path}/cut" in capsys.readouterr().out
    assert len(read_rows(tmp_path / "cut" / "metrics.csv")) == 8
    monkeypatch.setattr(ProbeMethod, "update", update)
    assert main(["train", "--resume", str(tmp_path / "cut")]) == 0
    for name in ("metrics.csv", "levels.csv"):
        assert without_time(tmp_path / "cut" / name) == without_time(tmp_path / "whole" / name)


@pytest.mark.slow
def test_sigterm_ends_well_with_143(probe, tmp_path, monkeypatch):
    from tests.experiments.probe import ProbeMethod

    update = ProbeMethod.update

    def interrupted(self):
        os.kill(os.getpid(), signal.SIGTERM)
        return update(self)

    monkeypatch.setattr(ProbeMethod, "update", interrupted)
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT]) == 143
    assert (tmp_path / "run" / "checkpoint.pt").exists()


@pytest.mark.slow
def test_a_killed_run_resumes_from_its_checkpoint(probe, tmp_path, monkeypatch, capsys):
    """A kill after the checkpoint leaves rows too many; a kill before the first leaves no checkpoint at all."""
    from tests.experiments.probe import ProbeMethod

    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "whole"), *SHORT]) == 0
    update = ProbeMethod.update

    class Killed(Exception):
        pass

    for updates, seconds in ((7, "0"), (7, "1000")):
        path = tmp_path / f"killed{seconds}"

        def killed(self, updates=updates):
            if self.updates == updates:
                raise Killed
            return update(self)

        monkeypatch.setattr(ProbeMethod, "update", killed)
        with pytest.raises(Killed):
            main(["train", "1v1Restricted", "--out", str(path), *SHORT, "--checkpoint-seconds", seconds])
        with open(path / "metrics.csv", "a") as file:
            file.write("8,80")
        monkeypatch.setattr(ProbeMethod, "update", update)
        assert main(["train", "--resume", str(path)]) == 0
        said = f"{path} stopped at 7k env_steps, before its first checkpoint: it restarts from zero"
        assert (said in capsys.readouterr().err) == (seconds == "1000")
        assert without_time(path / "metrics.csv") == without_time(tmp_path / "whole" / "metrics.csv")
        assert without_time(path / "levels.csv") == without_time(tmp_path / "whole" / "levels.csv")


@pytest.mark.slow
def test_a_resumed_recording_is_a_second_part(probe, tmp_path):
    command = ["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT, "--record"]
    assert main(command) == 0
    assert main(["train", "--resume", str(tmp_path / "run"), "--total-env-steps", "24000"]) == 0
    parts = sorted(path.name for path in (tmp_path / "run").glob("*.rrd"))
    assert parts == ["curriculum.2.rrd", "curriculum.rrd"]


@pytest.mark.slow
def test_what_a_resumed_run_may_not_change(probe, tmp_path, capsys):
    path = str(tmp_path / "run")
    assert main(["train", "1v1Restricted", "--out", path, *SHORT]) == 0
    assert main(["train", "--resume", path, "--seed", "3"]) == 1
    assert capsys.readouterr().err == f"regista: {path} was trained with seed = 0; it cannot continue with 3\n"
    assert main(["train", "--resume", path, "--out", "elsewhere"]) == 2


@pytest.mark.slow
def test_a_program_of_ones_own_must_stay_the_same(probe, tmp_path, monkeypatch, capsys):
    program, path = tmp_path / "mine.scenic", tmp_path / "run"
    program.write_text("ego = LeftCM\n")
    monkeypatch.chdir(tmp_path)
    assert main(["train", "mine.scenic", "--out", str(path), *SHORT]) == 0
    monkeypatch.chdir("/")  # the run knows where its program is
    assert main(["train", "--resume", str(path), "--total-env-steps", "21000"]) == 0
    program.write_text("ego = LeftCF\n")
    capsys.readouterr()
    assert main(["train", "--resume", str(path), "--total-env-steps", "22000"]) == 1
    assert capsys.readouterr().err.startswith(f"regista: {program} has changed since {path} was started")


@pytest.mark.slow
def test_a_recorder_that_fails_stops_no_training(probe, tmp_path, monkeypatch, capsys):
    from ued.recorder.recorder import CurriculumRecorder

    def fail(*_):
        raise RuntimeError("the viewer is on strike")

    monkeypatch.setattr(CurriculumRecorder, "record", fail)
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT, "--record"]) == 0
    warnings = [line for line in capsys.readouterr().err.splitlines() if line.startswith("regista: ")]
    assert warnings == ["regista: no more updates are recorded: RuntimeError: the viewer is on strike"]


@pytest.mark.slow
def test_a_full_disk_is_one_sentence_and_keeps_the_checkpoint(probe, tmp_path, monkeypatch, capsys):
    path = tmp_path / "run"
    assert main(["train", "1v1Restricted", "--out", str(path), *SHORT]) == 0
    before = (path / "checkpoint.pt").read_bytes()

    fsync = os.fsync

    def full(handle):  # the configuration and the tables, which are written first, still found room
        if "checkpoint.pt" in os.readlink(f"/proc/self/fd/{handle}"):
            raise OSError(errno.ENOSPC, "No space left on device")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", full)
    assert main(["train", "--resume", str(path), "--total-env-steps", "24000"]) == 1
    problem = f"cannot write {path}/checkpoint.pt: No space left on device (the previous checkpoint is kept)"
    assert capsys.readouterr().err == f"regista: {problem}\n"
    assert (path / "checkpoint.pt").read_bytes() == before
    assert len(read_rows(path / "metrics.csv")) == 24


def test_a_training_that_diverges_is_one_sentence(probe, tmp_path, monkeypatch, capsys):
    def diverge(self):
        raise FloatingPointError("the gradient is not finite (loss nan): try a smaller learning_rate")

    monkeypatch.setattr(ProbeMethod, "update", diverge)
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT]) == 1
    problem = "the gradient is not finite (loss nan): try a smaller learning_rate"
    assert capsys.readouterr().err == f"regista: {problem}\n"


@pytest.mark.parametrize("kept", [[], ["runs"], ["runs", "runs/a"]])
def test_a_refused_run_leaves_no_folder(kept, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for folder in kept:
        (tmp_path / folder).mkdir()
    assert main(["train", "maze", "--method", "lessons", "--out", "runs/a", *SHORT]) == 2
    assert "lessons cannot train on regista.envs.maze.task:maze" in capsys.readouterr().err
    with pytest.raises(UsageError, match="lessons cannot train"):
        train_in_python("maze", "lessons", out="runs/a")
    assert [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")] == kept


@pytest.mark.slow
def test_an_existing_run_and_files_of_others_stay(probe, tmp_path, monkeypatch):
    def fail(*_):
        raise UsageError("refused")

    path = tmp_path / "run"
    flags = ["1v1Restricted", "--out", str(path), *SHORT]
    assert main(["train", *flags]) == 0
    files = sorted(path.iterdir())
    monkeypatch.setattr(build, "make_method", fail)
    assert main(["train", "--resume", str(path)]) == 2 and sorted(path.iterdir()) == files
    for file in files:
        if file.name not in ("config.json", "program.scenic"):
            file.unlink()
    assert main(["train", "--resume", str(path)]) == 2 and (path / "config.json").exists()


@pytest.mark.slow
def test_an_open_run_is_locked(probe, tmp_path, capsys):
    path = str(tmp_path / "run")
    assert main(["train", "1v1Restricted", "--out", path, *SHORT]) == 0
    with RunFolder.open(Path(path)).locked():
        assert main(["train", "--resume", path]) == 1
    assert capsys.readouterr().err == f"regista: {path} is being trained by another process\n"


def regista(*argv, **options):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "regista", *argv]
    return subprocess.Popen(
        command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
    )


FOOTBALL = ["1v1Restricted", "--num-envs", "16", "--num-steps", "32", "--hidden-size", "16", "--eval-episodes", "2"]
BUDGET = ["--total-env-steps", "15000", "--eval-every", "10000", "--checkpoint-seconds", "0.5", "--no-record"]


SMALL_BUFFER = {  # so that levels are replayed within a short run
    "accel": ["--accel.buffer.capacity", "8"],
    "repaired": ["--repaired.buffer.capacity", "4", "--repaired.episodes-per-level", "1"],
}


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("method", "form"), [("paired", "csv"), ("accel", "csv"), ("accel", "parquet")]
)  # an adversary, a buffer of levels
def test_sigkill_and_resume_end_with_the_numbers_of_a_run_left_alone(tmp_path, method, form):
    flags = [*FOOTBALL, *BUDGET, "--method", method, *SMALL_BUFFER.get(method, []), "--levels-format", form]
    assert main(["train", *flags, "--out", str(tmp_path / "whole")]) == 0
    killed = regista("train", *flags, "--out", str(tmp_path / "killed"))
    deadline = time.monotonic() + 300
    while not (tmp_path / "killed" / "checkpoint.pt").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    assert main(["train", "--resume", str(tmp_path / "killed")]) == 0
    rows = without_time(tmp_path / "killed" / "metrics.csv")
    assert rows == without_time(tmp_path / "whole" / "metrics.csv") and len(rows) > 10
    name = "levels.csv" if form == "csv" else "levels.parquet/part-00000.parquet"
    assert (tmp_path / "killed" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert len(read_levels(tmp_path / "killed")["id"]) > 10
    if method in SMALL_BUFFER:
        replayed = read_columns(tmp_path / "killed" / "metrics.csv")["levels/replayed"]
        assert replayed[-10:].sum() > 0


@pytest.mark.long
def test_ctrl_c_on_a_real_run(tmp_path):
    process = regista(
        "train", *FOOTBALL, "--total-env-steps", "100_000_000", "--no-record", "--out", str(tmp_path / "run")
    )
    deadline = time.monotonic() + 300
    while not (tmp_path / "run" / "metrics.csv").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=60)
    assert process.returncode == 130, error.decode()
    assert f"continue with: regista train --resume {tmp_path}/run" in out.decode()
    assert read_rows(tmp_path / "run" / "metrics.csv")
