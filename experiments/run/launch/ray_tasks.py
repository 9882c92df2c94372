"""Runs as tasks of a Ray cluster: each is trained inside a worker of some node, and again where that node has died.

Run folders lie on storage that all nodes see, and Regista is installed on each. Read next: `run.launch.workers`.
"""

from __future__ import annotations

import os
import platform
import signal
import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from typing import Any

from regista.experiments.run.errors import CommandError
from regista.experiments.run.launch.owner import SILENT_SECONDS, BusyError

POLL_SECONDS = 1.0
RETRIES = 5  # of a run whose worker or node has died, or was asked to end


class InterruptedRun(CommandError):
    """Somebody asked the worker of a run to end, and it has saved: the run goes on elsewhere."""


class RayTasks:
    """A Ray cluster: that of RAY_ADDRESS, or the one that was started last on this machine, or a new one here."""

    def __init__(self) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        import ray

        before = signal.getsignal(signal.SIGTERM)  # ours: Ray would end at once
        self._ray: Any = ray
        self._mine = not ray.is_initialized()
        if self._mine:
            try:
                ray.init(log_to_driver=False, logging_level="WARNING")
            except ConnectionError as error:
                raise CommandError(f"no Ray cluster answers: {str(error).partition(chr(10))[0]}") from error
        if before is not None:
            signal.signal(signal.SIGTERM, before)
        self._task = ray.remote(max_retries=RETRIES, retry_exceptions=[InterruptedRun])(train_here)
        self._asked: set[Any] = set()

    def start(self, job: Any) -> Any:
        """Submit a run; return the reference by which it is known."""
        gpus = int(job.config.device.startswith("cuda"))  # Ray hides those that nobody has asked for
        task = self._task.options(num_cpus=job.config.threads, num_gpus=gpus)
        return task.remote(job.argv, str(job.path.resolve()))

    def ended(self, active: Collection[Any]) -> Sequence[Any]:
        """Wait a moment; return the tasks that have ended."""
        return self._ray.wait(list(active), timeout=POLL_SECONDS)[0] if active else []

    def failure(self, task: Any, job: Any) -> str | None:
        """Return why a task that has ended did not train its run, None if it did."""
        from ray.exceptions import RayError, RayTaskError

        try:
            self._ray.get(task)
        except RayTaskError as error:
            return str(error.cause)
        except RayError as error:
            return str(error).partition("\n")[0]
        return None

    def ask(self, active: Mapping[Any, Any]) -> None:
        """Ask tasks to save and end, once: a second time would end them at once."""
        for task in active.keys() - self._asked:
            self._ray.cancel(task)
        self._asked |= active.keys()

    def kill(self, active: Mapping[Any, Any]) -> None:
        """End tasks at once."""
        for task in active:
            self._ray.cancel(task, force=True)

    def close(self, active: Mapping[Any, Any]) -> None:
        """Wait for these to end, and let the cluster go."""
        if active:
            self._ray.wait(list(active), num_returns=len(active), timeout=SILENT_SECONDS)
        if self._mine:
            self._ray.shutdown()


def train_here(words: Sequence[str], folder: str) -> None:
    """Train one run in this process; what it says goes to its train.log.

    Raises `InterruptedRun` where the process is asked to end, and what the command raises.
    """
    path = Path(folder)
    if not path.is_dir():
        raise CommandError(f"node {platform.node()} sees no {folder}: runs must lie on storage that all nodes share")
    command, patience = import_module(f"regista.experiments.commands.{words[0]}"), time.monotonic() + 2 * SILENT_SECONDS
    with open(path / "train.log", "a", buffering=1) as log, redirect_stdout(log), redirect_stderr(log):
        while True:
            try:
                code = command.main(list(words[1:]))
                break
            except BusyError:  # a node that was lost may be silent for a while before it counts as dead
                if time.monotonic() > patience:
                    raise
                time.sleep(POLL_SECONDS)
    if code:
        raise InterruptedRun(f"{folder} was asked to end, with code {code}")
