"""Mazes as levels: random ones, edits, codes.

Random mazes are those of DCD's domain randomization, an adversary with uniformly random actions
(`AdversarialEnv.step_adversary` with `choose_goal_last`). It places walls in uniform cells, with repetition, then the
goal and the agent, which remove the walls in their cells. "25 blocks" means 25 such walls, "60 blocks, uniform" means 0
to 59 (`resample_n_clutter`). JaxUED samples walls in the same way, minimax without repetition. The direction of the
agent is uniform. As in these sources, some mazes have no path to the goal.

An edit is one of ACCEL's in DCD (`AdversarialEnv.mutate_level`, editor "walls_none_goal"): a uniform cell becomes a
wall, an empty cell or the goal. Our edits are applied one after the other; DCD applies all edits at once, in different
cells.

An adversary builds mazes step by step (see `builder`), or chooses all cells at once. Read next: `builder`; `env`.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from regista.envs.maze.builder import MazeBuilder, bins
from regista.envs.maze.grid import DIRECTIONS, Layouts, layouts_of, width_of
from regista.envs.maze.paths import UNREACHABLE, path_lengths
from ued.core.cells import bin_center, index_in
from ued.core.parameters import Choice, Integer

ARROWS = ">v<^"  # the agent in drawings, by direction
EDITS = ("wall", "empty", "goal")
MOST_OPTIONS = 400  # cells of a maze up to which an adversary that chooses all cells at once may prefer single cells


class Maze(NamedTuple):
    """One maze of S x S cells."""

    walls: np.ndarray  # [S, S] bool
    start: tuple[int, int]  # row, column
    goal: tuple[int, int]
    direction: int  # that the agent faces: 0 right, 1 down, 2 left, 3 up


class MazeFamily:
    """Mazes of S x S cells: a `ued.LevelFamily`.

    A code has one entry for each cell (wall or not), then start, goal and direction. [-1, 1] is divided into as many
    equal parts as an entry has values; the entry is the center of its part (see `ued.core.cells`). Any vector in
    [-1, 1] is a valid code if start and goal differ; walls in these two cells are removed.

    Args:
        side: S.
        num_walls: walls placed in random mazes.
        random_count: place a uniform number of walls below `num_walls` instead.
        goal_last: let an adversary place goal and agent after the walls; see `builder`.
    """

    def __init__(
        self, side: int = 13, num_walls: int = 25, random_count: bool = False, goal_last: bool = False
    ) -> None:
        self.side, self.num_walls, self.random_count = side, num_walls, random_count
        self.size = side * side + 3
        self.builder = MazeBuilder(side, num_walls, random_count, goal_last)
        self._bins = bins(side)

    @cached_property
    def parameters(self) -> dict[str, Choice | Integer]:
        """The columns of codes: cells, walls as likely as in random mazes; then start, goal, direction."""
        cells, counts = self.side**2, np.arange(self.num_walls) if self.random_count else np.array([self.num_walls])
        share = 1 - ((1 - 1 / cells) ** counts).mean() if self.num_walls else 0.0
        share = float(np.clip(share, 0.5 / cells, 1 - 0.5 / cells))  # exclude 0 and 1
        names = [f"wall[{row}, {column}]" for row in range(self.side) for column in range(self.side)]
        place = Choice(*range(cells)) if cells <= MOST_OPTIONS else Integer(0, cells - 1)
        rest = {"start": place, "goal": place, "direction": Choice(*ARROWS)}
        return dict.fromkeys(names, Choice("empty", "wall", weights=(1 - share, share))) | rest

    def draw_codes(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Sample the codes of `count` mazes at once: `[count, size]`."""
        cells, most = self.side**2, self.num_walls
        indices = np.zeros((count, self.size), np.int64)
        walls = rng.integers(cells, size=(count, most))
        placed = rng.integers(max(most, 1), size=(count, 1)) if self.random_count else most
        rows, order = np.nonzero(np.broadcast_to(np.arange(most) < placed, walls.shape))
        indices[rows, walls[rows, order]] = 1
        goal, start = rng.integers(cells, size=count), rng.integers(cells - 1, size=count)
        start += start >= goal
        indices[np.arange(count), goal] = indices[np.arange(count), start] = 0
        indices[:, cells], indices[:, cells + 1] = start, goal
        indices[:, cells + 2] = rng.integers(DIRECTIONS, size=count)
        return bin_center(indices, self._bins)

    def sample(self, rng: np.random.Generator) -> Maze:
        """Sample a maze."""
        return self.decode(self.draw_codes(rng, 1)[0])

    def simplest(self, rng: np.random.Generator) -> Maze:
        """Sample a maze without walls, with which ACCEL begins in DCD (`GoalLastEmptyAdversarialEnv`)."""
        cells = self.side**2
        start, goal = (divmod(int(cell), self.side) for cell in rng.choice(cells, 2, replace=False))
        return Maze(np.zeros((self.side, self.side), bool), start, goal, int(rng.integers(DIRECTIONS)))

    def mutate(self, level: Maze, rng: np.random.Generator) -> Maze:
        """Return the maze after one edit. An agent or a goal that loses its cell moves to a random empty one.

        The maze stays unchanged if no empty cell is left for it.
        """
        place, edit = divmod(int(rng.integers(self.side**2)), self.side), EDITS[rng.integers(len(EDITS))]
        walls = level.walls.copy()
        walls[place] = edit == "wall"
        goal = place if edit == "goal" else level.goal
        lost_goal, lost_start = goal == place and edit != "goal", level.start == place
        taken = walls.copy()
        taken[place] = True
        for kept, lost in ((goal, lost_goal), (level.start, lost_start)):
            taken[kept] |= not lost
        free = rng.permutation(np.flatnonzero(~taken))[:2].tolist()
        if len(free) < lost_goal + lost_start:
            return level
        goal = divmod(free.pop(), self.side) if lost_goal else goal
        start = divmod(free.pop(), self.side) if lost_start else level.start
        return Maze(walls, start, goal, level.direction)

    def encode(self, level: Maze) -> np.ndarray:
        """Return the code `[size]` of a maze."""
        places = [row * self.side + column for row, column in (level.start, level.goal)]
        return bin_center(np.concatenate([level.walls.ravel(), places, [level.direction]]), self._bins)

    def decode(self, code: np.ndarray) -> Maze:
        """Return the maze of a code `[size]`."""
        walls, start, goal, direction = self._parts(code[None])
        walls[0, [start[0], goal[0]]] = False
        first, last = (divmod(int(cell[0]), self.side) for cell in (start, goal))
        return Maze(walls.reshape(self.side, self.side), first, last, int(direction[0]))

    def layouts(self, codes: np.ndarray) -> Layouts:
        """Return the mazes of codes `[K, size]` as arrays."""
        walls, start, goal, direction = self._parts(codes)
        return layouts_of(walls.reshape(-1, self.side, self.side), start, goal, direction)

    def valid(self, codes: np.ndarray) -> np.ndarray:
        """Return which codes `[K, size]` describe mazes, with start and goal in different cells: bool `[K]`."""
        _, start, goal, _ = self._parts(codes)
        return start != goal

    def _parts(self, codes: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return walls, bool `[K, S * S]`, and starts, goals, directions `[K]` of codes `[K, size]`."""
        indices, cells = index_in(codes, self._bins), self.side**2
        return indices[:, :cells] > 0, *indices[:, cells:].T


def maze_from(drawing: str) -> Maze:
    """Return the maze of a drawing: `#` a wall, `.` an empty cell, `G` the goal, `>`, `v`, `<` or `^` the agent.

    Raises ValueError unless the drawing is square, has only these characters, exactly one goal and one agent, and a
    path to the goal.
    """
    rows = drawing.split()
    text = "".join(rows)
    agents = [(place, mark) for place, mark in enumerate(text) if mark in ARROWS]
    if any(len(row) != len(rows) for row in rows) or set(text) - set("#.G" + ARROWS):
        raise ValueError(f"a maze is as many rows of '#', '.', 'G' and one of '{ARROWS}' as each has, got {rows}")
    if text.count("G") != 1 or len(agents) != 1:
        raise ValueError(f"a maze has one goal 'G' and one agent, got {text.count('G')} and {len(agents)}")
    walls = np.array([mark == "#" for mark in text]).reshape(len(rows), len(rows))
    (start, mark), goal = agents[0], text.index("G")
    maze = Maze(walls, divmod(start, len(rows)), divmod(goal, len(rows)), ARROWS.index(mark))
    cells = (np.array([place]) for place in (start, goal, maze.direction))
    if path_lengths(layouts_of(walls[None], *cells), width_of(len(rows))) == [UNREACHABLE]:
        raise ValueError(f"walls separate the agent in {maze.start} from the goal in {maze.goal} (row, column): {rows}")
    return maze


def check_maze(maze: Maze, side: int) -> None:
    """Raise ValueError unless this is a maze of S x S cells with start and goal in different cells."""
    if np.shape(maze.walls) != (side, side):
        raise ValueError(f"these mazes have {side} x {side} cells, got walls of shape {np.shape(maze.walls)}")
    for name, place in (("start", maze.start), ("goal", maze.goal)):
        if np.shape(place) != (2,) or not all(int(entry) == entry and 0 <= entry < side for entry in place):
            raise ValueError(f"the {name} of a maze is a row and a column from 0 to {side - 1}, got {place}")
    if tuple(maze.start) == tuple(maze.goal):
        raise ValueError(f"start and goal of a maze are different cells, both are {maze.start}")
    if maze.direction not in range(DIRECTIONS):
        raise ValueError(f"the direction of an agent is from 0 to {DIRECTIONS - 1}, got {maze.direction}")
