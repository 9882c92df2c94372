"""Several runs at a time, each in a process of its own that is nothing but `regista train --resume RUN`.

A run is a folder, so processes need no other channel: what they have done is in their tables. Read next:
`commands.compare`.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from experiments.run.errors import CommandError
from experiments.run.folder import RunFolder
from experiments.run.progress import Progress
from experiments.run.signals import PARENT, StopRequest, end_with

POLL_SECONDS = 1.0  # the tables are read each time, on a core that might train


def count_processes(asked: int, threads: int) -> int:
    """Return how many runs are trained at a time: as many as asked for, or as cores have room for, if that is 0."""
    return asked or max(1, (os.cpu_count() or 1) // threads)


def train_unfinished(runs: Sequence[RunFolder], processes: int, stop: StopRequest) -> None:
    """Train those of these runs that are not finished, so many at a time (0: see `count_processes`), and say it."""
    unfinished = [run for run in runs if not run.finished()]
    if unfinished:
        most = min(count_processes(processes, unfinished[0].config.threads), len(unfinished))
        print(f"{len(runs)} runs, {len(runs) - len(unfinished)} finished; {most} at a time", flush=True)
        train_all(unfinished, most, stop)


def train_all(runs: Sequence[RunFolder], processes: int, stop: StopRequest) -> None:
    """Train these runs to their ends, `processes` at a time; return early if somebody asks to stop.

    Raises `CommandError` when one fails, after the others were asked to save and end.
    """
    waiting, active = list(runs), dict[subprocess.Popen, RunFolder]()
    begun = {run.path: run.env_steps() for run in runs}
    total = sum(run.config.total_env_steps for run in runs)
    progress = Progress(total, sum(begun.values()))
    try:
        while (waiting and not stop) or active:
            while waiting and len(active) < processes and not stop:
                run = waiting.pop(0)
                active[_start(run)] = run
            if stop:
                _ask(active, signal.SIGTERM)
            time.sleep(POLL_SECONDS)
            for process in [process for process in active if process.poll() is not None]:
                _check(process, active.pop(process), stop, len(active))
            done = sum(min(run.env_steps(), run.config.total_env_steps) for run in runs)
            progress.show(done, {})
    except KeyboardInterrupt:  # the second one
        _ask(active, signal.SIGKILL)
        raise
    finally:  # nobody is left behind
        _ask(active, signal.SIGTERM)
        for process in active:
            process.wait()
    progress.finish(f"{len(runs)} runs trained" if not stop else "stopped")


def _start(run: RunFolder) -> subprocess.Popen:
    """Start one run in its own session: a Ctrl-C reaches us, and we pass it on."""
    threads = str(run.config.threads)
    environment = os.environ | {"OMP_NUM_THREADS": threads, "PYTHONUNBUFFERED": "1", PARENT: str(os.getpid())}
    with open(run.path / "train.log", "a") as log:
        command = [sys.executable, "-m", "regista", "train", "--resume", str(run.path)]
        return subprocess.Popen(command, stdout=log, stderr=log, env=environment, start_new_session=True)


def _ask(active: dict[subprocess.Popen, RunFolder], number: int) -> None:
    for process in active:
        if process.poll() is None:
            process.send_signal(number)


def _check(process: subprocess.Popen, run: RunFolder, stop: StopRequest, others: int) -> None:
    """Raise `CommandError` with the last words of a run that failed; say it at once where others are still to end."""
    if process.returncode == 0 or stop:
        return
    lines = [line for line in (run.path / "train.log").read_text(errors="replace").splitlines() if line.strip()]
    words = lines[-1].removeprefix("regista: ") if lines else "it left no word"
    if process.returncode < 0:
        words = f"it was killed by {signal.Signals(-process.returncode).name}"
    if others:
        print(f"regista: {run.path} failed; {others} others save and end", file=sys.stderr, flush=True)
    raise CommandError(f"{run.path} failed: {words} (see {run.path / 'train.log'})")


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of so many fresh processes, which end with us; fill it while a Ctrl-C is `held_back`.

    Raises `CommandError` where one of them is killed; on any error the others are, too: nobody waits for their work.
    """
    context = multiprocessing.get_context("spawn")  # torch's threads do not survive a fork
    pool = ProcessPoolExecutor(count, context, _join, (os.getpid(),))
    try:
        yield pool
    except BrokenProcessPool as error:
        raise CommandError("a process that played for us was killed; was there enough memory?") from error
    finally:
        for process in multiprocessing.active_children():
            process.kill()
        pool.shutdown(cancel_futures=True)


def _join(parent: int) -> None:
    """Begin as one of a pool, which ends when its parent does."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with(parent)
