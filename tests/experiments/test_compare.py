"""Comparisons: what is kept, what is continued, what the table says."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from regista.envs.football.config import FootballConfig
from regista.experiments.__main__ import main
from regista.experiments.commands import compare
from regista.experiments.pictures.plots import color
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.evaluator import EvalScenes
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import football_game
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.table import read_rows

ROOT = Path(__file__).parents[2]
SHORT = ["--total-env-steps", "5000", "--eval-every", "2000", "--eval-episodes", "8", "--episodes", "20", "--no-record"]
LEVELS = ["--levels", "20", "--level-episodes", "4"]


@pytest.fixture
def in_process(probe, trained_here, monkeypatch):
    """Train probes in this process, and draw nothing."""
    monkeypatch.setattr(compare, "draw", lambda found, folder, kind: None)


@pytest.mark.slow
def test_a_comparison_trains_tests_and_tabulates(in_process, tmp_path, capsys):
    folder = tmp_path / "demo"
    assert main(["compare", "1v1Restricted", "--seeds", "2", *SHORT, *LEVELS, "--out", str(folder)]) == 0
    out = capsys.readouterr().out
    with open(folder / "results.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == (2 * 2 + 2) * 4
    assert {row["method"] for row in rows} == {"dr", "paired", "shoot", "random"}
    assert all(int(row["env_steps"]) == 5000 for row in rows if row["method"] == "paired")
    assert "− dr" in out and "CVaR10" in out and (folder / "table.txt").read_text().strip() in out
    assert "played on simulator version 1" in (folder / "table.md").read_text()
    with open(folder / "levels.csv") as file:
        levels = list(csv.DictReader(file))
    assert len(levels) == 2 * 2 + 2 and {row["levels"] for row in levels} == {"20"}
    rates = {row["method"]: float(row["goal_rate"]) for row in levels}
    assert 0.3 < rates["random"] < 0.7 and rates["shoot"] < 1  # the probe pays the right side


@pytest.mark.slow
def test_a_second_call_keeps_finished_runs_and_extends_them(in_process, tmp_path, capsys):
    folder = tmp_path / "demo"
    command = ["compare", "1v1Restricted", "--seeds", "1", *SHORT, *LEVELS, "--out", str(folder)]
    assert main(command) == 0
    before = (folder / "dr-0" / "metrics.csv").read_bytes()
    capsys.readouterr()
    assert main(command) == 0
    assert "at a time" not in capsys.readouterr().out
    assert (folder / "dr-0" / "metrics.csv").read_bytes() == before
    picture = folder / "dr-0" / "learning_curve.png"
    picture.unlink()  # by a kill while it was drawn
    assert main(command) == 0
    assert (folder / "dr-0" / "metrics.csv").read_bytes() == before and picture.exists()
    command[command.index("5000")] = "7000"
    assert main(command) == 0
    assert (folder / "dr-0" / "metrics.csv").read_bytes().startswith(before)


@pytest.mark.slow
def test_other_settings_are_not_mixed_in(in_process, tmp_path, capsys):
    command = ["compare", "1v1Restricted", "--seeds", "1", *SHORT, *LEVELS, "--out", str(tmp_path / "demo")]
    assert main(command) == 0
    assert main([*command, "--gamma", "0.5"]) == 1
    assert (
        f"was trained with ppo.gamma = {TrainConfig().ppo.gamma}; it cannot continue with 0.5"
        in capsys.readouterr().err
    )


@pytest.mark.slow
def test_a_method_is_compared_with_itself(in_process, tmp_path, capsys):
    folder = tmp_path / "demo"
    command = ["compare", "1v1Restricted", "--methods", "dr", "--seeds", "1", *SHORT, *LEVELS, "--out", str(folder)]
    variants = ["--variants", "slow: --learning-rate 1e-5", "edits: --method accel --accel.num-edits 7"]
    assert main([*command, *variants]) == 0
    runs = {path.name: RunFolder.open(path) for path in folder.iterdir() if path.is_dir()}
    assert set(runs) == {"dr-0", "slow-0", "edits-0"}
    assert {name: run.config.method for name, run in runs.items()} == {"dr-0": "dr", "slow-0": "dr", "edits-0": "accel"}
    rates = [runs[name].config.ppo.learning_rate for name in ("dr-0", "slow-0", "edits-0")]
    assert rates[1] == 1e-5 and rates[0] == rates[2] != 1e-5
    assert runs["edits-0"].config.accel.num_edits == 7
    assert [row["method"] for row in read_rows(folder / "results.csv")[::4]] == [
        "dr",
        "slow",
        "edits",
        "shoot",
        "random",
    ]
    assert runs["slow-0"].label == "slow" and "slow" in capsys.readouterr().out
    assert len({color(name) for name in ("dr", "slow", "edits")}) == 3
    before = (folder / "slow-0" / "metrics.csv").read_bytes()
    assert main([*command, *variants]) == 0 and (folder / "slow-0" / "metrics.csv").read_bytes() == before
    assert main([*command, "--variants", "slow: --learning-rate 1e-4"]) == 1
    assert "was trained with ppo.learning_rate = 1e-05; it cannot continue with 0.0001" in capsys.readouterr().err


@pytest.mark.slow
def test_variants_alone_are_of_dr_or_of_their_own_method(in_process, tmp_path):
    command = ["compare", "1v1Restricted", "--seeds", "1", *SHORT, "--levels", "0", "--out", str(tmp_path / "demo")]
    assert main([*command, "--variants", "a: --gamma 0.9", "b: --method plr"]) == 0
    kinds = {path.name: RunFolder.open(path).config.method for path in (tmp_path / "demo").iterdir() if path.is_dir()}
    assert kinds == {"a-0": "dr", "b-0": "plr"}


@pytest.mark.parametrize(
    ("variant", "told"),
    [
        ("slow --learning-rate 1", 'is not "NAME: FLAGS"'),
        ("a/b: --gamma 0.9", "names have letters, digits"),
        ("plr: --gamma 0.9", "plr is the name of a method"),
        ("a: --gama 0.9", "--gama"),
        ("a: --gamma 9", "--gamma: must be between 0 and 1"),
        ("a: --method plrr", "plrr"),
        ("a: --seed 3", "--seed"),
        ("a: --accel.num-edits 3", "--accel.num-edits is a setting of accel; dr would not use it"),
        ("a: --method plr --accel.num-edits 3", "--accel.num-edits is a setting of accel; plr would not use it"),
        ("a: --device 'cpu", "No closing quotation"),
        ("a: --representation simple115", "share the environment"),
        ("b: --gamma 0.9", "two rows of the comparison are called 'b'"),
    ],
)
def test_what_is_no_variant_is_refused(variant, told, tmp_path, capsys):
    folder = tmp_path / "demo"
    assert main(["compare", "1v1Restricted", "--variants", "b: --gamma 0.5", variant, "--out", str(folder)]) == 2
    assert told in capsys.readouterr().err and not folder.exists()


@pytest.mark.slow
def test_evaluate_prints_a_table_and_writes_csv(in_process, tmp_path, capsys):
    path = tmp_path / "run"
    assert main(["train", "1v1Restricted", *SHORT[:6], "--out", str(path), "--no-record"]) == 0
    files = ["--csv", str(tmp_path / "r.csv"), "--markdown", str(tmp_path / "r.md")]
    assert main(["evaluate", str(path), "--episodes", "50", *LEVELS, *files]) == 0
    out = capsys.readouterr().out
    assert "hard" in out and "shoot" in out and "5_000" in out
    assert len((tmp_path / "r.csv").read_text().splitlines()) == 1 + 3 * 4
    assert (tmp_path / "r.md").read_text().startswith("| method |  | training distribution |")
    assert main(["evaluate", str(path), "--episodes", "50", *LEVELS, "--json", "--no-baselines"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["results"]) == 4 and len(found["levels"]) == 1
    (mean,) = [entry for entry in found["tables"] if entry["measure"] == "mean"]
    assert 0 < mean["estimate"] <= 1 and mean["low"] is None  # one run says nothing of the next
    assert main(["evaluate", str(path), "--episodes", "20", "--levels", "0", "--json", "--held-out"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {row["scene"] for row in found["results"]} == {"training distribution", "in", "near", "clear"}


def test_goals_are_what_counts_whatever_pays_in_training(in_process, monkeypatch):
    config, game, rewards = TrainConfig(env=FootballConfig(rewards="scoring,checkpoints")), football_game("1v1Free"), []
    task = game.task
    monkeypatch.setattr(game, "task", lambda config: rewards.append(config.env.rewards) or task(config))
    EvalScenes(config, game, 4)
    assert rewards == ["scoring"]


def test_a_run_without_checkpoint_cannot_be_evaluated(in_process, tmp_path, capsys):
    RunFolder.create(tmp_path / "run", TrainConfig())
    assert main(["evaluate", str(tmp_path / "run")]) == 1
    assert "has no checkpoint yet" in capsys.readouterr().err


@pytest.mark.parametrize("flags", [["--levels", "5"], ["--level-episodes", "3"], ["--level-episodes", "0"]])
def test_levels_that_give_no_cvar_are_refused(flags, capsys):
    assert main(["compare", *flags]) == 2
    said = capsys.readouterr().err.replace("--level-episodes:", "level_episodes")
    assert f"{flags[0][2:].replace('-', '_')} must be" in said


# ---------------------------------------------------------------- for real


@pytest.mark.drawn
@pytest.mark.long
def test_a_small_comparison_stopped_and_continued(tmp_path):
    folder = tmp_path / "demo"
    command = [sys.executable, "-m", "regista", "compare", "1v1Restricted", "--seeds", "1", "--out", str(folder)]
    command += ["--total-env-steps", "4096", "--num-envs", "8", "--num-steps", "64", "--hidden-size", "16"]
    command += ["--eval-every", "2500", "--eval-episodes", "2", "--episodes", "4", "--processes", "1"]
    command += ["--levels", "10", "--level-episodes", "2"]
    options = {"cwd": ROOT, "env": os.environ | {"PYTHONPATH": str(ROOT)}, "text": True}
    first = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
    deadline = time.monotonic() + 300
    while not list(folder.glob("*/metrics.csv")) and time.monotonic() < deadline:
        time.sleep(0.05)
    first.send_signal(signal.SIGINT)
    out, error = first.communicate(timeout=120)
    assert first.returncode == 130, error
    assert "finished runs are skipped" in out
    assert main(command[3:]) == 0
    for name in (
        "results.csv",
        "table.txt",
        "table.md",
        "table.csv",
        "overview.png",
        "learning_curves.png",
        "levels.png",
    ):
        assert (folder / name).stat().st_size > 100
    for run in (folder / "dr-0", folder / "paired-0"):
        updates = [int(row["update"]) for row in read_rows(run / "metrics.csv")]
        assert updates == list(range(1, len(updates) + 1)) and updates
        assert (run / "curriculum.rrd").stat().st_size > 10_000


def test_stop_requests_are_counted():
    with StopRequest() as stop:
        assert not stop and stop.exit_code == 0
        os.kill(os.getpid(), signal.SIGINT)
        assert stop and stop.exit_code == 130
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
