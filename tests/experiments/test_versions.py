"""What is of another version of the simulator can be evaluated, and nothing else."""

import json
import shutil

import pytest

from lab.studies import page, rows
from regista.__main__ import main
from regista.envs.football.config import FootballConfig
from regista.experiments.pictures import results_page
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
    program = build.load_scenes(config)[build.TRAINING_SCENE]
    upomdp = build.make_upomdp(program, 2, config.env, 0, 1)
    RunRecorder(RunFolder(tmp_path, config), program, build.make_method(config, upomdp))
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
    assert f"{old} was trained on {UNNUMBERED}; on version 1 no run can begin with it" in capsys.readouterr().err
    assert not (tmp_path / "new" / "config.json").exists()


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
    told = f"different simulators: {run} on simulator version 1, {old} on {UNNUMBERED}; evaluate them apart"
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
    assert versions.kept_version(real, {"simulator": 3}, "here") is None
    assert versions.kept_version(TaskTrainConfig(), {}, "here") is None


@pytest.mark.parametrize("version", [-1, True, 1.0, [1], None])
def test_what_is_no_version_is_refused(version):
    with pytest.raises(CommandError, match="here: 'simulator' must be a whole number from 0 on, got"):
        versions.kept_version(TrainConfig(), {"simulator": version}, "here")


# ---------------------------------------------------------------- tables


def row(simulator):
    return rows.Row("defense/2vs2", "ppo", "closest1", "train", 0, 100, 50, 0.1, 0.5, 20, 10, 30.0, 1.0, "a", simulator)


def without_version(path):
    """Leave away what the rows of a file say of the version."""
    lines = [line.rpartition(",")[0] for line in path.read_text().splitlines()]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(("study", "file"), [("tuning", "curricula"), ("curricula", "curricula"), ("single", "fast")])
def test_unnumbered_rows_are_neither_published_nor_added_to(tmp_path, capsys, study, file):
    """Not even by a study that writes another file: one page shows both."""
    table = tmp_path / "results" / f"{file}.csv"
    table.parent.mkdir()
    rows.add(table, [row("1")])
    without_version(table)
    before = table.read_text()
    assert main(["study", study, "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    told = f"rows of {table} were measured on {UNNUMBERED}; on version 1 they can be neither published nor added to"
    assert told in said and "move the file away" in said
    assert table.read_text() == before and sorted(path.name for path in tmp_path.rglob("*")) == [table.name, "results"]


def test_a_file_without_versions_is_of_an_unnumbered_simulator(tmp_path):
    rows.add(tmp_path / "fast.csv", [row("1")])
    assert rows.load(tmp_path / "fast.csv") == [row("1")] == page.read(tmp_path, "fast")
    without_version(tmp_path / "fast.csv")
    assert rows.load(tmp_path / "fast.csv") == [row("0")]
    with pytest.raises(CommandError, match=f"fast.csv were measured on {UNNUMBERED}; on version 1 they can be neither"):
        page.read(tmp_path, "fast")
    rows.add(tmp_path / "rows.csv", [row("none")])
    rows.check_present(tmp_path / "rows.csv", rows.load(tmp_path / "rows.csv"))
    assert rows.played_on([row("1"), row("0"), row("none")]) == (
        f"simulator version 1 and {UNNUMBERED} and no simulator of ours"
    )
    with pytest.raises(CommandError, match="damaged: simulator is 'one'"):
        rows.add(tmp_path / "rows.csv", [row("one")]) and rows.load(tmp_path / "rows.csv")


@pytest.mark.parametrize("simulator", [1, 2, None, "unnumbered"])
def test_a_page_of_another_version_is_not_published(tmp_path, simulator):
    folder, into = tmp_path / "folder", tmp_path / "RESULTS.md"
    folder.mkdir()
    results_page.write_page(folder, "a", ["compare"], "| a |", {}, 1 if simulator == "unnumbered" else simulator)
    text = (folder / "page.md").read_text()
    assert text.startswith(f"<!-- simulator {simulator or 'none'} -->\n## a") or simulator == "unnumbered"
    if simulator == "unnumbered":
        (folder / "page.md").write_text(text.partition("\n")[2])
    if simulator in (1, None):
        assert results_page.main([str(folder), "--into", str(into)]) == 0 and "## a" in into.read_text()
        return
    with pytest.raises(CommandError, match=r"page\.md was measured on .*; on version 1 it cannot be published"):
        results_page.main([str(folder), "--into", str(into)])
    assert not into.exists()
