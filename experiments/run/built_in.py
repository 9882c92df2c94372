"""Built-in tasks other than football, by their short names. Read next: `run.tasks`."""

from __future__ import annotations

from typing import NamedTuple


class BuiltIn(NamedTuple):
    """A built-in task: its full name and a one-line description."""

    name: str
    about: str


BUILT_IN = {  # by short name
    "maze": BuiltIn(
        "regista.envs.maze.task:maze",
        "the maze benchmark of PAIRED and DCD, with a partial view",
    ),
    "maze60": BuiltIn("regista.envs.maze.task:maze60", 'the same with 0 to 59 walls, DCD\'s "60 blocks, uniform"'),
}
