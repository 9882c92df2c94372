"""Setup of all tests: a temporary state folder, failure flags, samples of many cases, and Python's handler of Ctrl-C.

Tests send SIGINT. A program that runs them in the background (nohup) may ignore SIGINT, and commands inherit that.
"""

import atexit
import os
import shutil
import signal
import tempfile
from collections import defaultdict

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


@pytest.hookimpl(tryfirst=True)  # before -m selects
def pytest_collection_modifyitems(items):
    """Of the slow cases of a test marked `sample(n)`, mark all but n, which are evenly spread, as `long`."""
    cases = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sample") and item.get_closest_marker("slow"):
            cases[item.nodeid.split("[")[0]].append(item)
    for alike in cases.values():
        count = alike[0].get_closest_marker("sample").args[0]
        kept = {k * len(alike) // count for k in range(count)}
        for k, item in enumerate(alike):
            if k not in kept:
                item.add_marker(pytest.mark.long)


signal.signal(signal.SIGINT, signal.default_int_handler)
