"""Run rounds in a separate process, so that a crash or an endless loop is reported as harm and does not end the suite.

Read next: `lab.torture.__main__`, which asks for them.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection

MOST = 3_600  # s of processor time for a round; far more than any round takes
Round = Callable[[str, int], dict[str, int]]


class Worker:
    """A forked process that runs rounds and keeps its compiled code; it is replaced if it dies."""

    def __init__(self, run: Round) -> None:
        self.run, self.process = run, None  # type: tuple[Round, Any]

    def do(self, name: str, seed: int) -> dict[str, int]:
        """Return the counts of a round. Raises AssertionError for any harm, including the end of the process."""
        if self.process is None:
            forks = multiprocessing.get_context("fork")
            self.connection, theirs = forks.Pipe()
            self.process = forks.Process(target=serve, args=(theirs, self.connection, self.run), daemon=True)
            self.process.start()
            theirs.close()
        try:
            self.connection.send((name, seed))
            counts, harm = self.connection.recv()
        except (EOFError, OSError):
            self.process.join()
            code, self.process = self.process.exitcode, None
            raise AssertionError(f"the process ended with exit code {code}") from None
        if harm:
            raise AssertionError(harm)
        return counts

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.terminate()
            self.process.join()


def serve(connection: Connection, theirs: Connection, run: Round) -> None:
    """Run rounds until the other end of the pipe closes; `theirs` is the fork's copy of that end, closed first."""
    theirs.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the suite ends the process, regardless of inherited handlers
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    while True:
        try:
            name, seed = connection.recv()
        except (EOFError, OSError):
            return
        resource.setrlimit(resource.RLIMIT_CPU, (MOST + int(sum(os.times()[:2])), resource.RLIM_INFINITY))
        try:
            answer = run(name, seed), ""
        except AssertionError as harm:
            answer = {}, str(harm) or traceback.format_exc()
        except Exception:
            answer = {}, traceback.format_exc()
        try:
            connection.send(answer)
        except OSError:  # the suite was killed
            return
