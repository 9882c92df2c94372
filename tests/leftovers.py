"""A fixture for tests that start processes: whoever leaves one behind fails, and it is ended in any case.

Read next: `tests/experiments/conftest.py`, which asks for it.
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

PATIENCE = 3.0  # s for processes that are about to end
SHARED = (b"resource_tracker", b"forkserver")  # Python's own, of which a process keeps one


@pytest.fixture(autouse=True)
def nobody_left(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that leaves a process behind, its own child or a child's; end them all, whatever came of the test."""
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
    """Return the command lines, by number, of our children and of what else was started in a test; dead ones are none.

    Children may start others and end; what pytest says of the test is in the environment of all of them.
    """
    tag, found = f"PYTEST_CURRENT_TEST={test} ".encode(), {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdecimal() or int(folder.name) == os.getpid():
            continue
        try:
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            ours = int(parent) == os.getpid() or tag in (folder / "environ").read_bytes()
            command = (folder / "cmdline").read_bytes()
        except OSError:  # it has ended, or is somebody else's
            continue
        if ours and state != "Z" and not any(word in command for word in SHARED):
            found[int(folder.name)] = command.replace(b"\0", b" ").decode(errors="replace")
    return found
