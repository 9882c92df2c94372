"""A signal ends every command within ten seconds, wherever it is, and what was finished before is whole."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from regista.experiments.__main__ import main
from regista.experiments.run.launch.signals import Watchdog, interruptible
from regista.experiments.run.table import read_rows
from tests.attacks.interrupts import children, started

pytestmark = pytest.mark.slow

BUSY = 3.0  # s of processor time of one process, of which imports take 1 to 1.5: it is at work
TASK = f"{Path(__file__).parent / 'slow_task.py'}:walk"
LIMIT = 10.0  # s from the signal to the end of all processes
TRAIN = ["--method", "plr", "--num-envs", "4", "--num-steps", "16", "--total-env-steps", "2_000", "--no-record"]
TRAIN += ["--eval-every", "0", "--checkpoint-seconds", "0"]
COMPARE = ["compare", TASK, *TRAIN[2:], "--seeds", "1", "--methods", "dr"]


class Command:
    """A command that is running, and the folder by which it is told where to block."""

    def __init__(self, folder: Path, words: list[str]) -> None:
        self.folder, self.tag = folder, f"stopping-{os.getpid()}-{time.monotonic_ns()}"
        folder.mkdir(exist_ok=True)
        told = {"REGISTA_TEST_STUCK": str(folder), "REGISTA_TORTURE": self.tag, "OMP_NUM_THREADS": "1"}
        self.process = started(words, env=os.environ | told)

    def wait_for(self, file: Path, seconds: float = 120.0) -> None:
        """Wait until a file is there."""
        until = time.monotonic() + seconds
        while not file.exists():
            assert self.process.poll() is None and time.monotonic() < until, self.process.communicate()[0]
            time.sleep(0.02)

    def wait_for_steps(self, steps: int, seconds: float = 120.0) -> None:
        """Wait until a process has made so many steps of its environments."""
        self.wait_for(self.folder / "played", seconds)
        until = time.monotonic() + seconds
        while int((self.folder / "played").read_text() or 0) < steps:
            assert self.process.poll() is None and time.monotonic() < until, self.process.communicate()[0]
            time.sleep(0.02)

    def wait_for_work(self, seconds: float = 120.0) -> None:
        """Wait until one of the processes has had `BUSY` seconds of processor time, or the command has ended."""
        until = time.monotonic() + seconds
        while self.process.poll() is None and max(map(spent, children(self.tag)), default=0.0) < BUSY:
            assert time.monotonic() < until, "it does not work"
            time.sleep(0.1)

    def stop(self, number: int = signal.SIGTERM) -> str:
        """Send a signal to the command alone; return what it said. All of its processes must end in time."""
        began = time.monotonic()
        self.process.send_signal(number)
        try:
            said = self.process.communicate(timeout=60)[0].decode()
            while children(self.tag) and time.monotonic() < began + LIMIT:
                time.sleep(0.05)
            spent, left = time.monotonic() - began, children(self.tag)
        finally:
            for pid in children(self.tag):
                os.kill(pid, signal.SIGKILL)
        assert not left and spent < LIMIT, f"{len(left)} processes are left after {spent:.1f} s: {said}"
        assert self.process.returncode == 128 + number and "Traceback" not in said, said
        return said


def spent(pid: int) -> float:
    """Return the processor seconds of a process, 0 if it has ended."""
    try:
        told = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")


def rows_of(run: Path) -> list[dict[str, str]]:
    """Return the rows of a run's table but for wall-clock time."""
    rows = read_rows(run / "metrics.csv")
    return [{name: cell for name, cell in row.items() if not name.startswith("time/")} for row in rows]


def train(out: Path) -> list[str]:
    return ["train", TASK, *TRAIN, "--out", str(out)]


@pytest.fixture(name="alone", scope="module")
def _alone(tmp_path_factory):
    """Return a run that nobody stopped."""
    run = tmp_path_factory.mktemp("alone") / "run"
    assert main(train(run)) == 0
    return run


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.long
def test_a_run_that_blocks_ends_and_is_resumed_to_the_same_numbers(tmp_path, alone, number):
    run = tmp_path / "run"
    command = Command(tmp_path / "told", train(run))
    command.wait_for(run / "checkpoint.pt")
    (tmp_path / "told" / "step").touch()
    command.wait_for(tmp_path / "told" / "stuck")
    word = {signal.SIGTERM: "terminated", signal.SIGINT: "interrupted"}[number]
    assert f"regista: {word}" in command.stop(number)
    assert 0 < len(rows_of(run)) < len(rows_of(alone))
    assert main(["train", "--resume", str(run)]) == 0
    assert rows_of(run) == rows_of(alone)


@pytest.mark.long
def test_learning_with_very_many_minibatches_ends_and_is_resumed_to_the_same_numbers(tmp_path):
    words = ["train", TASK, "--method", "dr", "--num-envs", "16", "--num-steps", "64", "--total-env-steps", "1"]
    words += ["--no-record", "--eval-every", "0"]
    run = tmp_path / "run"
    long = ["--num-minibatches", "1024", "--update-epochs", "1000", "--out", str(run)]
    command = Command(tmp_path / "told", [*words, *long])
    command.wait_for_steps(64)
    time.sleep(2.0)  # it has finished the rollout, and learns for minutes
    command.stop()
    assert not (run / "metrics.csv").exists() and (run / "config.json").exists()
    alone = tmp_path / "alone"
    words += ["--num-minibatches", "128", "--update-epochs", "1"]
    assert main([*words, "--out", str(alone)]) == main([*words, "--out", str(run)]) == 0  # the name is free
    assert rows_of(run) == rows_of(alone)


@pytest.mark.long
@pytest.mark.parametrize("place", ["make", "step"])
def test_an_evaluation_that_blocks_ends(tmp_path, alone, place):
    command = Command(tmp_path, ["evaluate", str(alone), "--episodes", "10", "--levels", "0"])
    (tmp_path / place).touch()
    command.wait_for(tmp_path / "stuck")
    command.stop()


@pytest.mark.long
def test_an_evaluation_within_training_ends(tmp_path):
    run = tmp_path / "run"
    words = ["train", TASK, *TRAIN, "--eval-every", "100", "--eval-episodes", "1000000", "--out", str(run)]
    command = Command(tmp_path / "told", words)
    command.wait_for_steps(1_000)  # training makes 500
    command.stop()


@pytest.mark.long
def test_a_comparison_ends_with_its_processes(tmp_path):
    command = Command(tmp_path, [*COMPARE, "plr", "--out", str(tmp_path / "all")])
    command.wait_for(tmp_path / "all" / "dr-0" / "checkpoint.pt")
    (tmp_path / "step").touch()
    command.wait_for(tmp_path / "stuck")
    command.stop()


@pytest.mark.long
def test_a_comparison_whose_runs_are_not_heard_ends(tmp_path):
    (tmp_path / "make").touch()
    command = Command(tmp_path, [*COMPARE, "--out", str(tmp_path / "all")])
    command.wait_for(tmp_path / "stuck")
    command.stop()


@pytest.mark.parametrize(
    "words",
    [
        ["inspect", "{scene}", "--n", "10000", "--show", "scenes"],  # one of a million draws is valid
        ["inspect", "1v1Free", "--png", "{out}.png", "--n", "3000"],
        ["compare", "ued.probes:frontier", "--seeds", "2", "--total-env-steps", "1e9", "--out", "{out}"],
        ["list", "--solved", "1v1Free", "--levels", "100000"],
        ["demonstrate", "3v2FourBehaviors", "--episodes", "100000", "--out", "{out}"],
        ["benchmark", "--seconds", "1000"],
    ],
    ids=lambda words: " ".join(words[:1]),
)
@pytest.mark.long
def test_long_work_ends(tmp_path, words):
    scene = tmp_path / "rare.scenic"
    scene.write_text("x = Range(0, 1)\nego = Object at x @ 0\nrequire x < 0.000001\n")
    words = [word.format(scene=scene, out=tmp_path / "out") for word in words]
    command = Command(tmp_path / "told", words)
    command.wait_for_work()
    if command.process.poll() is None:  # a program that cannot be drawn may be refused by then
        command.stop()


@pytest.mark.long
def test_the_compilation_of_kernels_ends(tmp_path):
    told = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)}
    process = started(["play", "1v1Free"], env=told)
    while process.poll() is None and spent(process.pid) < BUSY:
        time.sleep(0.1)
    began = time.monotonic()
    process.send_signal(signal.SIGTERM)
    said = process.communicate(timeout=60)[0].decode()
    assert time.monotonic() - began < LIMIT and process.returncode == 143 and "Traceback" not in said, said


def test_a_process_that_is_forked_meanwhile_does_not_wake_the_watchdog():
    with Watchdog(0.5):
        before = signal.signal(signal.SIGTERM, lambda *_: None)
        pid = os.fork()
        if not pid:
            time.sleep(5)
            os._exit(0)
        os.kill(pid, signal.SIGTERM)  # its handler is a copy of ours
        time.sleep(1.0)
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        signal.signal(signal.SIGTERM, before)


def test_sigterm_ends_a_process_that_is_forked_meanwhile():
    """The workers of a user's AsyncVectorEnv, which would otherwise report our handler's error as their own."""
    with interruptible():
        pid = os.fork()
        if not pid:
            time.sleep(60)
            os._exit(0)
        os.kill(pid, signal.SIGTERM)
        _, status = os.waitpid(pid, 0)
    assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGTERM


def test_a_command_that_is_left_in_time_goes_on():
    before = signal.signal(signal.SIGTERM, lambda *_: None)
    with Watchdog(0.2):
        os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.4)
    signal.signal(signal.SIGTERM, before)
    assert subprocess.run(["true"]).returncode == 0
