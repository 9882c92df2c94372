"""Setup of all tests: a temporary state folder, failure flags for fixtures, and Python's default handler of Ctrl-C.

Tests send SIGINT. A program that runs them in the background (nohup) may ignore SIGINT, and commands inherit that.
"""

import atexit
import os
import shutil
import signal
import tempfile

import pytest

# Commands store the state of their user; tests must neither read nor change it
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="regista-tests-")
atexit.register(shutil.rmtree, os.environ["XDG_STATE_HOME"], ignore_errors=True)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Set `item.failed` for fixtures: the traceback of a failed test keeps its objects alive."""
    report = yield
    item.failed = getattr(item, "failed", False) or report.failed
    return report


signal.signal(signal.SIGINT, signal.default_int_handler)
