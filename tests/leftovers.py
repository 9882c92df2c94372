"""A fixture for tests that start processes: a test that leaves one behind fails, and the process is killed.

Read next: `tests/experiments/conftest.py`, which imports it.
"""

from __future__ import annotations

import gc
import os
import signal
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

PATIENCE = 3.0  # seconds that processes have to end after their test
SHARED = (b"resource_tracker", b"forkserver")  # Python's helper processes: each process keeps one of each


@pytest.fixture(autouse=True)
def nobody_left(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that leaves a child or another descendant behind; kill all such processes, also of failed tests."""
    before = started_in(request.node.nodeid)
    yield
    left = {}
    until = time.monotonic() + PATIENCE
    while left := {pid: what for pid, what in started_in(request.node.nodeid).items() if pid not in before}:
        gc.collect()
        if time.monotonic() > until:
            break
        time.sleep(0.02)
    for pid in left:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    for pid in left:
        with suppress(ChildProcessError):
            os.waitpid(pid, 0)
    assert not left or getattr(request.node, "failed", False), f"left behind: {', '.join(left.values())}"


def started_in(test: str) -> dict[int, str]:
    """Return the command lines, by process ID, of live children and of other live processes that a test started.

    A child may end before the processes that it started. All inherit `PYTEST_CURRENT_TEST`, which names the test.
    """
    tag, found = f"PYTEST_CURRENT_TEST={test} ".encode(), {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdecimal() or int(folder.name) == os.getpid():
            continue
        try:
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            ours = int(parent) == os.getpid() or tag in (folder / "environ").read_bytes()
            command = (folder / "cmdline").read_bytes()
        except OSError:  # the process has ended, or belongs to another user
            continue
        if ours and state != "Z" and not any(word in command for word in SHARED):
            found[int(folder.name)] = command.replace(b"\0", b" ").decode(errors="replace")
    return found
