"""Runs as tasks of a Ray cluster: each trains in a worker on some node, and is retried if that node dies.

Run folders must be on shared storage, and Regista must be installed on each node. Read next: `run.launch.workers`.
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

from regista.experiments.run import trust
from regista.experiments.run.errors import CommandError
from regista.experiments.run.launch.owner import SILENT_SECONDS, BusyError

POLL_SECONDS = 1.0
RETRIES = 5  # for a run whose worker or node died or was stopped


class InterruptedRun(CommandError):
    """The worker of a run was stopped and has saved; another worker continues the run."""


class RayTasks:
    """A Ray cluster: the one at RAY_ADDRESS, the one last started on this machine, or a new local one."""

    def __init__(self) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        import ray

        before = signal.getsignal(signal.SIGTERM)  # keep our handler, since Ray's would exit at once
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
        self._cancelled: set[Any] = set()

    def start(self, job: Any) -> Any:
        """Submit a run; return its Ray reference."""
        gpus = int(job.config.device.startswith("cuda"))  # Ray hides GPUs that were not requested
        task = self._task.options(num_cpus=job.config.threads, num_gpus=gpus)
        return task.remote(job.argv, str(job.path.resolve()))

    def ended(self, active: Collection[Any]) -> Sequence[Any]:
        """Wait briefly; return the finished tasks."""
        return self._ray.wait(list(active), timeout=POLL_SECONDS)[0] if active else []

    def failure(self, task: Any, job: Any) -> str | None:
        """Return the error of a failed task, None if it succeeded."""
        from ray.exceptions import RayError, RayTaskError

        try:
            self._ray.get(task)
        except RayTaskError as error:
            return str(error.cause)
        except RayError as error:
            return str(error).partition("\n")[0]
        return None

    def ask(self, active: Mapping[Any, Any]) -> None:
        """Request tasks to save and end, at most once each, since a second request would kill them."""
        for task in active.keys() - self._cancelled:
            self._ray.cancel(task)
        self._cancelled |= active.keys()

    def kill(self, active: Mapping[Any, Any]) -> None:
        """Kill tasks."""
        for task in active:
            self._ray.cancel(task, force=True)

    def close(self, active: Mapping[Any, Any]) -> None:
        """Wait for these tasks to end, and disconnect from the cluster."""
        if active:
            self._ray.wait(list(active), num_returns=len(active), timeout=SILENT_SECONDS)
        if self._mine:
            self._ray.shutdown()


def train_here(words: Sequence[str], folder: str) -> None:
    """Train one run in this process; its output goes to its train.log.

    Raises `InterruptedRun` if the process is stopped, and the errors of the command.
    """
    path = Path(folder)
    if not path.is_dir():
        raise CommandError(f"node {platform.node()} cannot access {folder}: all nodes must share the storage of runs")
    command, patience = import_module(f"regista.experiments.commands.{words[0]}"), time.monotonic() + 2 * SILENT_SECONDS
    with open(path / "train.log", "a", buffering=1) as log, redirect_stdout(log), redirect_stderr(log):
        while True:
            try:
                with trust.of_command(words) as typed:
                    code = command.main(typed[1:])
                break
            except BusyError:  # a lost node counts as the owner until its heartbeat expires
                if time.monotonic() > patience:
                    raise
                time.sleep(POLL_SECONDS)
    if code:
        raise InterruptedRun(f"{folder} was stopped with exit code {code}")
