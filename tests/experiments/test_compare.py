"""Comparisons: what is kept, what is continued, what the table says."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from envs.football.config import FootballConfig
from experiments import build, compare
from experiments.__main__ import main
from experiments.config import TrainConfig
from experiments.results import Result, advantage, goal_rate, mean_return, render_table
from experiments.run import RunFolder
from experiments.stopping import StopRequest
from experiments.table import read_rows
from experiments.testing import TestScenes
from experiments.train import train

ROOT = Path(__file__).parents[2]
SHORT = ["--total-env-steps", "5000", "--eval-every", "2000", "--eval-episodes", "8", "--episodes", "20", "--no-record"]


@pytest.fixture
def in_process(probe, monkeypatch):
    """Train in this process: the probe cannot be seen from another."""

    def train_all(runs, processes, stop):
        for run in runs:
            train(RunFolder.open(run.path), stop)

    monkeypatch.setattr(compare, "train_all", train_all)
    monkeypatch.setattr(compare, "draw", lambda found, folder: None)


def test_a_comparison_trains_tests_and_tabulates(in_process, tmp_path, capsys):
    folder = tmp_path / "demo"
    assert main(["compare", "1v1Restricted", "--seeds", "2", *SHORT, "--out", str(folder)]) == 0
    out = capsys.readouterr().out
    with open(folder / "results.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == (2 * 2 + 2) * 4
    assert {row["method"] for row in rows} == {"dr", "paired", "shoot", "random"}
    assert all(int(row["env_steps"]) == 5000 for row in rows if row["method"] == "paired")
    assert "paired − dr" in out and (folder / "table.txt").read_text().strip() in out


def test_a_second_call_keeps_finished_runs_and_extends_them(in_process, tmp_path, capsys):
    folder = tmp_path / "demo"
    command = ["compare", "1v1Restricted", "--seeds", "1", *SHORT, "--out", str(folder)]
    assert main(command) == 0
    before = (folder / "dr-0" / "metrics.csv").read_bytes()
    capsys.readouterr()
    assert main(command) == 0
    assert "at a time" not in capsys.readouterr().out
    assert (folder / "dr-0" / "metrics.csv").read_bytes() == before
    command[command.index("5000")] = "7000"
    assert main(command) == 0
    assert (folder / "dr-0" / "metrics.csv").read_bytes().startswith(before)


def test_other_settings_are_not_mixed_in(in_process, tmp_path, capsys):
    command = ["compare", "1v1Restricted", "--seeds", "1", *SHORT, "--out", str(tmp_path / "demo")]
    assert main(command) == 0
    assert main([*command, "--gamma", "0.5"]) == 1
    assert (
        f"was trained with ppo.gamma = {TrainConfig().ppo.gamma}; it cannot continue with 0.5"
        in capsys.readouterr().err
    )


def test_evaluate_prints_a_table_and_writes_csv(in_process, tmp_path, capsys):
    path = tmp_path / "run"
    assert main(["train", "1v1Restricted", *SHORT[:6], "--out", str(path), "--no-record"]) == 0
    assert main(["evaluate", str(path), "--episodes", "50", "--csv", str(tmp_path / "r.csv")]) == 0
    out = capsys.readouterr().out
    assert "hard" in out and "shoot" in out and "5_000" in out
    assert len((tmp_path / "r.csv").read_text().splitlines()) == 1 + 3 * 4


def test_goals_are_what_counts_whatever_pays_in_training(in_process, monkeypatch):
    paid, make = [], build.make_upomdp
    monkeypatch.setattr(
        build, "make_upomdp", lambda path, n, env, *rest: paid.append(env.rewards) or make(path, n, env, *rest)
    )
    TestScenes(TrainConfig(env=FootballConfig(rewards="scoring,checkpoints")), 4)
    assert paid == ["scoring"] * 4


def test_a_run_without_checkpoint_cannot_be_evaluated(in_process, tmp_path, capsys):
    RunFolder.create(tmp_path / "run", TrainConfig())
    assert main(["evaluate", str(tmp_path / "run")]) == 1
    assert "has no checkpoint yet" in capsys.readouterr().err


# ---------------------------------------------------------------- numbers


def row(method, seed, goals, scene="easy", trained=(1000, 10)):
    return Result(method, seed, scene, 100, goals / 100, 0.4, goals, 30.0, *trained)


def test_a_single_run_has_wilson_and_several_have_the_bootstrap():
    single = goal_rate([row("dr", 0, 50)])
    assert single == pytest.approx((0.5, 0.4038, 0.5962), abs=1e-3)
    several = goal_rate([row("dr", seed, goals) for seed, goals in enumerate((36, 40, 44))])
    assert several.estimate == pytest.approx(0.4)
    assert several.low == pytest.approx(0.4 - 4.303 * 0.04 / 3**0.5, abs=0.05)  # Student's t, a little more for luck
    assert several.high == pytest.approx(0.4 + 4.303 * 0.04 / 3**0.5, abs=0.05)
    assert mean_return([row("dr", 0, 50)]).high == pytest.approx(0.5 + 1.96 * 0.04)


def test_runs_that_agree_by_chance_are_not_certain():
    for interval in (
        goal_rate([row("dr", 0, 50), row("dr", 1, 50)]),
        mean_return([row("dr", 0, 50), row("dr", 1, 50)]),
    ):
        assert interval.estimate == 0.5
        assert 0.03 < interval.high - interval.estimate < 0.12  # 1.96 standard errors of 200 episodes are 0.07
    always = goal_rate([row("dr", 0, 100), row("dr", 1, 100)])
    assert 0.97 < always.low < 0.99 and always.estimate == always.high == 1.0


def test_the_advantage_of_a_better_method_is_positive():
    better = [row("paired", seed, 80 + seed) for seed in range(3)]
    worse = [row("dr", seed, 40 - seed) for seed in range(3)]
    gain = advantage(better, worse)
    assert gain.estimate == pytest.approx(0.42) and gain.low > 0.3


def test_the_table_has_scenes_and_methods():
    results = [
        row(method, seed, 50, scene) for method in ("dr", "paired") for seed in (0, 1) for scene in ("easy", "hard")
    ]
    results += [row("shoot", 0, goals, scene, trained=(0, 0)) for goals, scene in ((10, "easy"), (0, "hard"))]
    text = render_table(results)
    lines = text.splitlines()
    assert lines[0].split()[:4] == ["scene", "dr", "paired", "shoot"]
    assert lines[2].startswith("easy       return  +0.50 [+0.4")
    assert "0% [0%, 4%]" in text
    assert lines[-4].split() == ["runs", "2", "2", "1"]
    assert lines[-3].split() == ["env_steps", "1_000", "1_000", "–"]
    assert np.unique([len(line.rstrip()) > 0 for line in lines]).tolist() == [True]


# ---------------------------------------------------------------- for real


@pytest.mark.slow
def test_a_small_comparison_stopped_and_continued(tmp_path):
    folder = tmp_path / "demo"
    command = [sys.executable, "-m", "experiments", "compare", "1v1Restricted", "--seeds", "2", "--out", str(folder)]
    command += ["--total-env-steps", "20000", "--num-envs", "16", "--num-steps", "32", "--hidden-size", "16"]
    command += ["--eval-every", "10000", "--eval-episodes", "16", "--episodes", "32"]
    options = {"cwd": ROOT, "env": os.environ | {"PYTHONPATH": str(ROOT)}, "text": True}
    first = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
    deadline = time.monotonic() + 300
    while not list(folder.glob("*/metrics.csv")) and time.monotonic() < deadline:
        time.sleep(0.05)
    first.send_signal(signal.SIGINT)
    out, error = first.communicate(timeout=120)
    assert first.returncode == 130, error
    assert "finished runs are kept" in out
    done = subprocess.run(command, capture_output=True, timeout=600, **options)
    assert done.returncode == 0, done.stderr
    for name in ("results.csv", "table.txt", "overview.png", "learning_curves.png", "levels.png"):
        assert (folder / name).stat().st_size > 100
    for run in [folder / f"{method}-{seed}" for method in ("dr", "paired") for seed in range(2)]:
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
