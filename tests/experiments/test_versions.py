"""What is of another version of the simulator can be evaluated, and nothing else."""

import json
import shutil

import pytest

from regista.__main__ import main
from regista.envs.football.config import FootballConfig
from regista.experiments.run import build, versions
from regista.experiments.run.config import TaskTrainConfig, TrainConfig
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.recording import RunRecorder
from regista.experiments.run.table import read_rows
from ued.core import checkpoint

SHORT = ["--num-envs", "4", "--num-steps", "16", "--num-minibatches", "1", "--total-env-steps", "64", "--no-record"]
GAME = "academy/empty_goal_close"
UNNUMBERED = "an unnumbered simulator, from before version 1"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return a short run of football."""
    path = tmp_path_factory.mktemp("runs") / "dr-0"
    assert main(["train", GAME, "--method", "dr", "--out", str(path), "--eval-every", "0", *SHORT]) == 0
    return path


def of_version(run, path, version):
    """Return a copy of a run that was trained on another version; None: on one without a number."""
    shutil.copytree(run, path)
    settings, state = json.loads((path / "config.json").read_text()), checkpoint.load(path / "checkpoint.pt")
    for kept in (settings["about"], state):
        del kept["simulator"]
        if version is not None:
            kept["simulator"] = version
    (path / "config.json").write_text(json.dumps(settings))
    checkpoint.save(path / "checkpoint.pt", state)
    return path


def test_a_run_carries_the_version(run):
    assert json.loads((run / "config.json").read_text())["about"]["simulator"] == 1 == RunFolder.open(run).simulator
    assert checkpoint.load(run / "checkpoint.pt")["simulator"] == 1


def test_its_recording_does(tmp_path, monkeypatch):
    recordings = []
    monkeypatch.setattr("regista.experiments.run.recording.CurriculumRecorder", lambda *them: recordings.append(them))
    config = TrainConfig(minigame=GAME, method="dr", num_envs=2)
    task = build.find_game(config.minigame).task(config)
    upomdp = build.make_upomdp(task.make, 2, 0)
    RunRecorder(RunFolder(tmp_path, config), task, build.make_method(config, upomdp))
    ((recording, *_),) = recordings
    assert recording.properties["simulator"] == "1" and recording.properties["minigame"] == GAME


@pytest.mark.parametrize(("version", "named"), [(None, UNNUMBERED), (0, UNNUMBERED), (2, "simulator version 2")])
def test_a_run_of_another_version_is_neither_resumed_nor_compared(run, tmp_path, capsys, version, named):
    old = of_version(run, tmp_path / "dr-0", version)
    told = f"{old} was trained on {named}; on version 1 it can be evaluated, but not resumed or compared"
    assert main(["train", "--resume", str(old), "--total-env-steps", "128"]) == 1
    assert told in capsys.readouterr().err
    flags = ["--methods", "dr", "--seeds", "1", "--out", str(tmp_path), "--eval-every", "0", *SHORT]
    assert main(["compare", GAME, *flags]) == 1
    assert told in capsys.readouterr().err


@pytest.mark.slow
def test_a_checkpoint_of_another_version_is_not_resumed(run, tmp_path, capsys):
    old = of_version(run, tmp_path / "old", None)
    shutil.copy(run / "config.json", old)
    state = checkpoint.load(old / "checkpoint.pt") | {"simulator": "0123456789ab"}  # of its files, once
    checkpoint.save(old / "checkpoint.pt", state)
    assert main(["train", "--resume", str(old), "--total-env-steps", "128"]) == 1
    assert f"{old / 'checkpoint.pt'} was trained on {UNNUMBERED}" in capsys.readouterr().err


def test_no_run_begins_with_a_student_of_another_version(run, tmp_path, capsys):
    old = of_version(run, tmp_path / "old", None)
    command = ["train", GAME, "--method", "dr", "--from", str(old), "--out", str(tmp_path / "new"), *SHORT]
    assert main(command) == 1
    assert f"{old} was trained on {UNNUMBERED}; on version 1 no run can start from it" in capsys.readouterr().err
    assert not (tmp_path / "new" / "config.json").exists()


@pytest.mark.slow
def test_an_old_policy_is_evaluated_with_a_warning(run, tmp_path, capsys):
    old = of_version(run, tmp_path / "old", None)
    flags = ["--episodes", "2", "--levels", "0"]
    assert main(["evaluate", str(old), *flags, "--csv", str(tmp_path / "results.csv")]) == 0
    said = capsys.readouterr()
    assert said.err.count(f"warning: {old} was trained on {UNNUMBERED}; this is version 1") == 1
    assert "played on simulator version 1" in said.out
    assert {row["simulator"] for row in read_rows(tmp_path / "results.csv")} == {"1"}
    assert main(["evaluate", str(run), *flags, "--json"]) == 0
    said = capsys.readouterr()
    assert "warning" not in said.err and json.loads(said.out)["simulator"] == 1
    assert main(["evaluate", str(run), str(old), *flags]) == 1
    told = f"different simulators: {run} on simulator version 1, {old} on {UNNUMBERED}; evaluate them separately"
    assert told in capsys.readouterr().err


def test_a_folder_that_was_never_trained_takes_the_present_version(run, tmp_path):
    old = of_version(run, tmp_path / "old", None)
    (old / "metrics.csv").unlink()
    (old / "checkpoint.pt").unlink()
    folder = RunFolder.create_or_extend(old, RunFolder.open(old).config)
    assert folder.simulator == 1 == RunFolder.open(old).simulator


def test_tasks_and_the_real_engine_have_no_version():
    real = TrainConfig(env=FootballConfig(engine="grf"))
    assert versions.stamp(TaskTrainConfig()) == versions.stamp(real) == {}
    assert versions.saved_version(real, {"simulator": 3}, "here") is None
    assert versions.saved_version(TaskTrainConfig(), {}, "here") is None


@pytest.mark.parametrize("version", [-1, True, 1.0, [1], None])
def test_what_is_no_version_is_refused(version):
    with pytest.raises(CommandError, match="here: 'simulator' must be an integer, 0 or larger, got"):
        versions.saved_version(TrainConfig(), {"simulator": version}, "here")
