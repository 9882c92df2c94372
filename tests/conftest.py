"""Tests send signals: what runs them in the background may have had Ctrl-C ignored, and commands heed that (nohup)."""

import atexit
import os
import shutil
import signal
import tempfile

import pytest

# What commands remember of their user is not of this one
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="regista-tests-")
atexit.register(shutil.rmtree, os.environ["XDG_STATE_HOME"], ignore_errors=True)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Let fixtures know whether their test has failed: its traceback keeps alive what it had."""
    report = yield
    item.failed = getattr(item, "failed", False) or report.failed
    return report


signal.signal(signal.SIGINT, signal.default_int_handler)
