"""Parallel runs: each is a repeatable command line and a folder that holds its progress.

`--launcher` selects where runs execute: processes of this machine (`Processes`), a Ray cluster
(`run.launch.ray_tasks`), or command lines printed for the user (`commands`). A run communicates only through its
folder, so all launchers give the same tables. Read next: `commands.compare`.
"""

from __future__ import annotations

import multiprocessing
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, TextIO

from regista.experiments.run.errors import CommandError
from regista.experiments.run.launch.signals import PARENT, StopRequest, end_with, held_back
from regista.experiments.run.progress import Progress, counted
from ued.config import Checked, most_threads, setting

POLL_SECONDS = 1.0  # between reads of tables, since reading takes CPU time from training
EXIT_SECONDS = 0.05  # between checks for ended processes; until then their core is idle


class Job(Protocol):
    """A run to train: a `RunFolder` or a compatible object.

    `argv` are the arguments of `regista` that train it, in any working directory; `config` has its `threads` and
    `total_env_steps`.
    """

    @property
    def path(self) -> Path: ...
    @property
    def config(self) -> Any: ...
    @property
    def argv(self) -> list[str]: ...
    def finished(self) -> bool: ...
    def env_steps(self) -> int: ...


class Pool(Protocol):
    """A launcher of runs. `start` returns a handle of the run."""

    def start(self, job: Any) -> Any: ...
    def ended(self, active: Collection[Any]) -> Sequence[Any]: ...
    def failure(self, task: Any, job: Any) -> str | None: ...
    def ask(self, active: Mapping[Any, Any]) -> None: ...
    def kill(self, active: Mapping[Any, Any]) -> None: ...
    def close(self, active: Mapping[Any, Any]) -> None: ...


@dataclass(frozen=True)
class LaunchConfig(Checked):
    """Where the runs of a command execute, and how many in parallel."""

    launcher: Literal["local", "ray", "commands"] = setting(
        "local", "where runs execute; commands prints a command line for each"
    )
    processes: int = setting(0, "parallel runs; 0: one per core, on a cluster as many as fit", ">=0", most=100_000)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.launcher == "local" and self.processes > most_threads():
            raise ValueError(
                f"processes must be at most {most_threads()} on this machine, whose cores share them, got "
                f"{self.processes}"
            )

    def at_a_time(self, threads: int, runs: int) -> int:
        """Return the number of parallel runs: the requested number, or as many as the cores allow."""
        cores = _usable_cores() // threads if self.launcher == "local" else runs
        return min(self.processes or max(1, cores), runs)

    @property
    def messages(self) -> TextIO:
        """Stream of messages; stderr if command lines are printed to stdout."""
        return sys.stderr if self.launcher == "commands" else sys.stdout


def _usable_cores() -> int:
    """Return the number of cores that this process may use; in a batch job, the machine may have more."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


Over = Callable[[Any], None]  # callback for a finished run


def _pass(run: Any) -> None:
    """Do nothing with a finished run."""


def train_unfinished(runs: Sequence[Job], how: LaunchConfig, stop: StopRequest, over: Over = _pass) -> bool:
    """Train the unfinished runs and print the progress; return whether all runs are finished.

    Some are unfinished after a stop request, or if only command lines were printed. `over` is called with each run
    that this call has trained, while other runs continue.
    """
    unfinished = [run for run in runs if not run.finished()]
    if not unfinished or stop:
        return not unfinished
    if how.launcher == "commands":
        print("\n".join(map(command_line, unfinished)))
        say = f"{len(unfinished)} of {counted(len(runs), 'run')} to train; then run the same command again"
        print(say, file=how.messages, flush=True)
        return False
    most = how.at_a_time(unfinished[0].config.threads, len(unfinished))
    print(f"{counted(len(runs), 'run')}, {len(runs) - len(unfinished)} finished; {most} at a time", flush=True)
    train_all(unfinished, most, stop, how.launcher, over)
    if stop:
        print("continue with the same command; finished runs are skipped")
    return not stop


def command_line(run: Job) -> str:
    """Return the shell command that trains this run."""
    words = [sys.executable, "-m", "regista", *run.argv]
    return f"OMP_NUM_THREADS={run.config.threads} {shlex.join(words)}"


def train_all(runs: Sequence[Job], most: int, stop: StopRequest, launcher: str = "local", over: Over = _pass) -> None:
    """Train these runs, a limited number in parallel; return early after a stop request.

    `over` is called with each trained run. If a run fails, requests the others to save and end, and raises
    `CommandError`.
    """
    pool = _make_pool(launcher)
    done = {id(run): _trained(run) for run in runs}
    # The longest runs first, since the last run occupies one core while the others are idle.
    waiting = sorted(runs, key=lambda run: done[id(run)] - run.config.total_env_steps)
    active = dict[Any, Job]()
    progress = Progress(sum(run.config.total_env_steps for run in runs), sum(done.values()))
    try:
        while (waiting and not stop) or active:
            while waiting and len(active) < most and not stop:
                run = waiting.pop(0)
                active[pool.start(run)] = run
            if stop:
                pool.ask(active)
            ended, before = pool.ended(active), list(active.values())
            for task in ended:
                run = active.pop(task)
                words = pool.failure(task, run)
                if words is None:
                    over(run)
                elif not stop:
                    raise _failed(run, words, len(active))
            done |= {id(run): _trained(run) for run in before}  # only active runs: reading a long table takes time
            progress.show(sum(done.values()), {})
    except KeyboardInterrupt:  # the second Ctrl-C
        pool.kill(active)
        raise
    finally:  # end all child processes
        pool.ask(active)
        pool.close(active)
    progress.finish(f"{counted(len(runs), 'run')} trained" if not stop else "stopped")


def _trained(run: Job) -> int:
    """Return the env_steps that count as progress of the run."""
    return int(min(run.env_steps(), run.config.total_env_steps))


def _make_pool(launcher: str) -> Pool:
    if launcher == "local":
        return Processes()
    from regista.experiments.run.launch.ray_tasks import RayTasks

    return RayTasks()


def _failed(run: Job, words: str, others: int) -> CommandError:
    """Return the error of a failed run; print it at once if other runs still have to end."""
    if others:
        print(f"regista: {run.path} failed; {others} other runs save and end", file=sys.stderr, flush=True)
    return CommandError(f"{run.path} failed: {words} (see {run.path / 'train.log'})")


class Processes:
    """Processes of this machine, each running `regista train --resume RUN`."""

    def start(self, job: Job) -> subprocess.Popen:
        """Start one run in its own process group; this process receives Ctrl-C and forwards it.

        In the same session: Linux groups processes by session (autogroup), so `nice` of this process also holds for it.
        """
        threads = str(job.config.threads)
        environment = os.environ | {"OMP_NUM_THREADS": threads, "PYTHONUNBUFFERED": "1", PARENT: str(os.getpid())}
        with open(job.path / "train.log", "a") as log:
            command = [sys.executable, "-m", "regista", *job.argv]
            streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": log, "stderr": log}
            return subprocess.Popen(command, env=environment, process_group=0, **streams)

    def ended(self, active: Collection[subprocess.Popen]) -> Sequence[subprocess.Popen]:
        """Wait briefly for a process to end; return the finished processes."""
        until = time.monotonic() + POLL_SECONDS
        while not (over := [process for process in active if process.poll() is not None]):
            if time.monotonic() >= until:
                break
            time.sleep(EXIT_SECONDS)
        return over

    def failure(self, task: subprocess.Popen, job: Job) -> str | None:
        """Return the error message of a failed process, None for a successful one."""
        if task.returncode == 0:
            return None
        if task.returncode < 0:
            return f"it was killed by {signal.Signals(-task.returncode).name}"
        lines = [line for line in (job.path / "train.log").read_text(errors="replace").splitlines() if line.strip()]
        return lines[-1].removeprefix("regista: ") if lines else "it printed nothing"

    def ask(self, active: Mapping[subprocess.Popen, Job]) -> None:
        """Request processes to save and end."""
        _send(active, signal.SIGTERM)

    def kill(self, active: Mapping[subprocess.Popen, Job]) -> None:
        """Kill processes."""
        _send(active, signal.SIGKILL)

    def close(self, active: Mapping[subprocess.Popen, Job]) -> None:
        """Wait for these processes to end."""
        for process in active:
            process.wait()


def _send(active: Collection[subprocess.Popen], number: int) -> None:
    for process in active:
        if process.poll() is None:
            process.send_signal(number)


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of spawned processes that end with this process; submit work inside `held_back`.

    Raises `CommandError` if one of them is killed; on any error the others are killed too.
    """
    context = multiprocessing.get_context("spawn")  # torch's threads do not survive a fork
    pool = ProcessPoolExecutor(count, context, _join, (os.getpid(),))
    try:
        yield pool
    except BrokenProcessPool as error:
        raise CommandError("a worker process was killed, possibly for lack of memory") from error
    finally:
        for process in multiprocessing.active_children():
            process.kill()
        pool.shutdown(cancel_futures=True)


def apart(function: Callable, items: Sequence[Any], count: int, over: Callable[[list[Any]], None]) -> list[Any]:
    """Return `function(item)` of each item, computed in up to `count` processes; `over` receives new results.

    Raises the errors of the function, and `CommandError` if a process is killed.
    """
    with processes(min(count, len(items))) as pool:
        with held_back():
            futures = [pool.submit(function, item) for item in items]
        waiting = set(futures)
        while waiting:
            ended, waiting = wait(waiting, timeout=POLL_SECONDS)
            over([future.result() for future in ended])
        return [future.result() for future in futures]


def _join(parent: int) -> None:
    """Initialize a process of the pool so that it ends with its parent."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with(parent)
