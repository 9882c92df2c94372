"""Engines for these tests are processes: none may outlive the test that started it."""

from tests.leftovers import nobody_left

__all__ = ["nobody_left"]
