"""`train --seeds`: runs trained in parallel, stopped and continued; what is refused; the same policies evaluated."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from regista.experiments.__main__ import main
from regista.experiments.run import build, evaluator, trust
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch import seeds, workers
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.workers import LaunchConfig, train_all
from regista.experiments.run.table import read_rows
from ued.config import LARGEST_SEED

ROOT = Path(__file__).parents[2]
TASK = ["ued.probes:frontier", "--method", "plr", "--num-envs", "8", "--num-steps", "32", "--no-record"]
LENGTH = ["--total-env-steps", "20000", "--eval-every", "10000", "--eval-episodes", "4"]
SEEDS = ["--seeds", "2", "--seed", "3"]


def start(words: list[str]) -> subprocess.Popen[str]:
    """Start a command."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "regista", *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=ROOT, env=environment, stdout=pipe, stderr=pipe, text=True)


def finish(words: list[str]) -> str:
    """Run a command to its end and return what it prints."""
    process = start(words)
    out, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    return out


def assert_equal(one: Any, other: Any) -> None:
    """Compare nested states bit for bit, but for the time they took."""
    assert type(one) is type(other)
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one.keys() - {"elapsed"}:
            assert_equal(one[name], other[name])
    elif isinstance(one, list | tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_equal(a, b)
    elif isinstance(one, torch.Tensor):
        assert torch.equal(one, other)
    elif isinstance(one, np.ndarray):
        assert one.tobytes() == other.tobytes() and one.dtype == other.dtype
    else:
        assert one == other or one != one


def assert_same_runs(folder: Path, other: Path) -> None:
    """Compare the tables and checkpoints of the runs in two folders."""
    assert [run.path.name for run in seeds.opened(folder)] == ["plr-3", "plr-4"]
    for run in seeds.opened(folder):
        same = RunFolder.open(other / run.path.name)
        assert run.config == same.config
        for table in ("metrics.csv", "levels.csv"):
            mine, its = read_rows(run.path / table), read_rows(same.path / table)
            timed = {name for name in mine[0] if name.startswith("time/")}
            assert len(mine) > 1
            assert [{k: v for k, v in row.items() if k not in timed} for row in mine] == [
                {k: v for k, v in row.items() if k not in timed} for row in its
            ]
        assert_equal(run.load(), same.load())


@pytest.fixture(scope="module")
def apart(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of the runs of two seeds, trained one after the other by `train --seed`."""
    folder = tmp_path_factory.mktemp("apart")
    for seed in ("3", "4"):
        words = ["train", *TASK, *LENGTH, "--seed", seed, "--out", str(folder / f"plr-{seed}")]
        assert main(words) == 0
    return folder


@pytest.mark.slow
@pytest.mark.long
def test_seeds_trained_in_parallel_equal_those_trained_one_by_one(apart: Path, tmp_path: Path) -> None:
    out = finish(["train", *TASK, *LENGTH, *SEEDS, "--out", str(tmp_path / "together")])
    assert f"regista evaluate {tmp_path / 'together' / 'plr'}-*" in out
    assert_same_runs(tmp_path / "together", apart)


def killed(words: list[str], folder: Path, number: int) -> int:
    """Start a command, send it a signal when both runs have trained further, and wait for all of its processes."""
    before = [len(read_rows(run.path / "metrics.csv")) for run in seeds.opened(folder)] or [0, 0]
    process, until = start(words), time.monotonic() + 120
    while process.poll() is None and time.monotonic() < until:
        runs = seeds.opened(folder)
        if len(runs) == 2 and all(
            run.metrics.path.exists() and len(read_rows(run.metrics.path)) > rows + 3
            for run, rows in zip(runs, before, strict=True)
        ):
            break
        time.sleep(0.02)
    process.send_signal(number)
    process.communicate(timeout=60)
    while any((run.path / "owner.json").exists() for run in seeds.opened(folder)) and time.monotonic() < until:
        time.sleep(0.1)  # the runs of a killed command save and end by themselves
    return process.returncode


@pytest.mark.slow
@pytest.mark.long
def test_runs_that_are_stopped_or_killed_go_on_to_the_same_numbers(apart: Path, tmp_path: Path) -> None:
    folder = tmp_path / "together"
    words = ["train", *TASK, *LENGTH, *SEEDS, "--out", str(folder)]
    assert killed(words, folder, signal.SIGINT) == 130
    assert not all(run.finished() for run in seeds.opened(folder))
    assert killed(words, folder, signal.SIGKILL) == -signal.SIGKILL
    assert not all(run.finished() for run in seeds.opened(folder))
    finish(["train", "--resume", str(folder)])
    assert_same_runs(folder, apart)


@pytest.fixture
def two(trained_here: None, tmp_path: Path) -> Path:
    """Return a folder of two short runs."""
    words = ["train", *TASK, *SEEDS, "--total-env-steps", "256", "--eval-every", "0", "--out", str(tmp_path / "two")]
    assert main(words) == 0
    return tmp_path / "two"


@pytest.mark.slow
def test_a_comparison_finds_the_runs_finished(two: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = ["ued.probes:frontier", *TASK[3:], "--total-env-steps", "256", "--eval-every", "0"]
    words = ["compare", *task, "--methods", "plr", "--seeds", "2", "--first-seed", "3", "--out", str(two)]
    capsys.readouterr()
    assert main([*words, "--levels", "0", "--episodes", "5"]) == 0
    out = capsys.readouterr().out
    assert "evaluating 2 runs" in out and "at a time" not in out


@pytest.mark.slow
def test_resumed_runs_are_all_trained_further(two: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "--resume", str(two), "--total-env-steps", "512"]) == 0
    assert [run.load()["env_steps"] for run in seeds.opened(two)] == [512, 512]
    assert "2 runs finished" in capsys.readouterr().out
    for words, message in (
        (["--seeds", "3"], "--seeds and --resume exclude each other"),
        (["--connect", "localhost:1"], "--connect shows one run"),
        (["--preset", "thesis"], "--preset and --resume exclude each other"),
        (["--num-envs", "9"], "was trained with num_envs = 8"),
    ):
        assert main(["train", "--resume", str(two), *words]) in (1, 2)
        assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--processes", "2"], "--processes needs --seeds"),
        (["--launcher", "commands"], "--launcher needs --seeds"),
        (["--seeds", "0"], "--seeds: must be at least 1"),
        (["--seeds", "2", "--connect", "localhost:1"], "without --seeds"),
        (["--seeds", "2", "--seed", str(LARGEST_SEED)], "the largest"),
        (["--seeds", "2", "--kl-to-clone", "1"], "need --from"),
    ],
)
def test_what_several_runs_cannot_do_is_refused(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", *TASK, "--out", str(tmp_path / "out"), *words]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_run_is_no_folder_of_runs(two: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", *TASK, *SEEDS, "--out", str(two / "plr-3")]) == 1
    assert "plr-3 is a run folder" in capsys.readouterr().err


def test_lines_for_a_queue_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", *TASK, *SEEDS, "--launcher", "commands", "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr()
    assert [f"plr-{seed}" in line for seed, line in zip((3, 4), printed.out.splitlines(), strict=True)] == [True, True]
    assert "2 of 2 runs to train" in printed.err


# ---------------------------------------------------------------- the launcher


class Instant:
    """A pool whose runs end at once, in the order in which they were started."""

    def __init__(self) -> None:
        self.started: list[Any] = []

    def start(self, job: Any) -> Any:
        self.started.append(job.done)
        return job.done

    def ended(self, active: Any) -> Any:
        return [next(iter(active))] if active else []

    def failure(self, task: Any, job: Any) -> None:
        return None

    def ask(self, active: Any) -> None: ...
    def close(self, active: Any) -> None: ...


def test_the_longest_run_starts_first(monkeypatch: pytest.MonkeyPatch) -> None:
    pool = Instant()
    monkeypatch.setattr(workers, "_make_pool", lambda launcher: pool)
    jobs = [SimpleNamespace(done=n, config=SimpleNamespace(total_env_steps=100)) for n in (50, 10, 90, 0)]
    for job in jobs:
        job.env_steps = lambda job=job: job.done
    over: list[Any] = []
    train_all(jobs, 2, StopRequest(), over=over.append)
    assert pool.started == [0, 10, 50, 90]
    assert sorted(job.done for job in over) == [0, 10, 50, 90]


def test_what_a_stop_has_ended_is_not_over(monkeypatch: pytest.MonkeyPatch) -> None:
    stop, over = StopRequest(), list[Any]()
    pool = Instant()
    pool.failure = lambda task, job: "it was killed" if stop else None  # type: ignore[method-assign]
    monkeypatch.setattr(workers, "_make_pool", lambda launcher: pool)
    job = SimpleNamespace(done=0, config=SimpleNamespace(total_env_steps=100), env_steps=lambda: 0)

    def ended(active: Any) -> list[Any]:
        stop.signal = 2
        return list(active)

    pool.ended = ended  # type: ignore[method-assign]
    train_all([job], 1, stop, over=over.append)
    assert over == []


def test_runs_have_the_cores_that_this_process_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {1, 4, 7}, raising=False)
    assert LaunchConfig().at_a_time(1, 10) == 3
    assert LaunchConfig().at_a_time(2, 10) == 1
    assert LaunchConfig(processes=2).at_a_time(1, 10) == 2


# ---------------------------------------------------------------- evaluation


@pytest.mark.long
def test_policies_evaluated_in_parallel_have_the_same_numbers(apart: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trust.allow(TASK[0])
    runs = seeds.opened(apart)
    reports, pools = [], []
    usual = evaluator.apart
    monkeypatch.setattr(evaluator, "apart", lambda *words: pools.append(words[2]) or usual(*words))
    for seconds in (1e9, 0.0):
        monkeypatch.setattr(evaluator, "SHARED_SECONDS", seconds)
        scenes = evaluator.EvalScenes(runs[0].config, build.find_game(TASK[0]), 20)
        reports.append(evaluator.Evaluator(scenes, 20, 4, alike=True, processes=2).report(runs))
    assert pools == [2]
    one, other = reports
    assert repr(one.results) == repr(other.results) and len(one.results) > 2
    assert repr(one.levels) == repr(other.levels) and len(one.levels) > 2


@pytest.mark.slow
def test_runs_of_one_folder_start_from_one_student_in_one_way(
    trained_here: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start, tuned, length = tmp_path / "start", tmp_path / "tuned", ["--total-env-steps", "256", "--eval-every", "0"]
    assert main(["train", *TASK, *length, "--out", str(start)]) == 0
    command = ["train", *TASK, *length, "--from", str(start), "--out", str(tuned), "--seeds"]
    assert main([*command, "1"]) == 0
    capsys.readouterr()
    assert main([*command, "2", "--kl-to-clone", "1"]) == 1
    said = f"{tuned}/plr-0 started with --kl-to-clone 0.0 --kl-share 0.5; it cannot continue with 1.0 and 0.5"
    assert said in capsys.readouterr().err
    assert main(["train", "--resume", str(start), "--total-env-steps", "512"]) == 0
    assert main([*command, "1"]) == 0  # it keeps its student
    capsys.readouterr()
    assert main([*command, "2"]) == 1
    assert f"{start} has been trained since other runs started from it" in capsys.readouterr().err
    assert not (tuned / "plr-1" / "metrics.csv").exists()
