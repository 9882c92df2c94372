"""Fixtures of the command line's tests, and the settings of all tests; see `tests/conftest.py`."""

from tests.conftest import pytest_collection_modifyitems, pytest_runtest_makereport
from tests.experiments.conftest import begun, engine, nobody_left, trained_here, undrawn

__all__ = ["begun", "engine", "nobody_left", "trained_here", "undrawn"]
__all__ += ["pytest_collection_modifyitems", "pytest_runtest_makereport"]
