"""Fixtures of the command line's tests, and the settings of all tests; see `tests/conftest.py`."""

from tests.conftest import pytest_runtest_makereport
from tests.experiments.conftest import begun, engine, nobody_left, trained_here, undrawn

__all__ = ["begun", "engine", "nobody_left", "pytest_runtest_makereport", "trained_here", "undrawn"]
