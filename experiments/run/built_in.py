"""The tasks of this toolkit that are no football games, by their short names. Read next: `run.tasks`."""

from __future__ import annotations

from typing import NamedTuple


class BuiltIn(NamedTuple):
    """A task of this toolkit: its full name, and what it is."""

    name: str
    about: str


BUILT_IN = {  # by short name
    "maze": BuiltIn(
        "regista.envs.maze.task:maze",
        "the maze benchmark of PAIRED, DCD, JaxUED and minimax: walk to a goal by what lies ahead",
    )
}
