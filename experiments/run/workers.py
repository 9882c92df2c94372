"""Several runs at a time, each in a process of its own that is nothing but `regista train --resume RUN`.

A run is a folder, so processes need no other channel: what they have done is in their tables. Read next:
`commands.compare`.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence

from experiments.run.errors import CommandError
from experiments.run.folder import RunFolder
from experiments.run.progress import Progress
from experiments.run.signals import StopRequest

POLL_SECONDS = 1.0  # the tables are read each time, on a core that might train


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
                _check(process, active.pop(process), stop)
            done = sum(min(run.env_steps(), run.config.total_env_steps) for run in runs)
            progress.show(done, {})
    finally:  # a failed run or a second Ctrl-C: nobody is left behind
        _ask(active, signal.SIGTERM)
        for process in active:
            process.wait()
    progress.finish(f"{len(runs)} runs trained" if not stop else "stopped")


def _start(run: RunFolder) -> subprocess.Popen:
    """Start one run in its own session: a Ctrl-C reaches us, and we pass it on."""
    threads = str(run.config.threads)
    environment = os.environ | {"OMP_NUM_THREADS": threads, "PYTHONUNBUFFERED": "1"}
    with open(run.path / "train.log", "a") as log:
        command = [sys.executable, "-m", "experiments", "train", "--resume", str(run.path)]
        return subprocess.Popen(command, stdout=log, stderr=log, env=environment, start_new_session=True)


def _ask(active: dict[subprocess.Popen, RunFolder], number: int) -> None:
    for process in active:
        if process.poll() is None:
            process.send_signal(number)


def _check(process: subprocess.Popen, run: RunFolder, stop: StopRequest) -> None:
    """Raise `CommandError` with the last words of a run that failed."""
    if process.returncode == 0 or stop:
        return
    lines = [line for line in (run.path / "train.log").read_text().splitlines() if line.strip()]
    words = lines[-1].removeprefix("regista: ") if lines else f"exit code {process.returncode}"
    raise CommandError(f"{run.path} failed: {words} (see {run.path / 'train.log'})")
