"""The arrays that hold mazes. Their sizes are not compiled in, so the same machine code runs mazes of any size.

A maze of S x S cells is stored in a flat grid of W x W entries, W = S + 2 BORDER. Cell (y, x) is entry
`(y + BORDER) W + x + BORDER`. The border of walls is as wide as the view, and agents never leave the cells, so kernels
need not check indices. Directions are MiniGrid's: 0 right, 1 down, 2 left, 3 up.

Letters: `N` environments, `K` mazes, `S` cells per side, `W` entries per side. Read next: `view`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

UNSEEN, EMPTY, WALL, GOAL = 0, 1, 2, 8  # MiniGrid's OBJECT_TO_IDX
GREY, GREEN = 5, 1  # MiniGrid's COLOR_TO_IDX: of walls, of the goal
LEFT, RIGHT, FORWARD = 0, 1, 2  # actions
DIRECTIONS = 4
VIEW = 5  # cells per side
BORDER = VIEW - 1


class Layouts(NamedTuple):
    """Mazes: the content of their grids, and the start of the agents."""

    grid: np.ndarray  # [K, W * W] uint8: EMPTY, WALL or GOAL
    start: np.ndarray  # [K] int64, an entry of the grid
    direction: np.ndarray  # [K] int64


class Agents(NamedTuple):
    """Positions and directions of the agents, and the steps since their episodes began."""

    at: np.ndarray  # [N] int64, an entry of the grid
    direction: np.ndarray  # [N] int64
    clock: np.ndarray  # [N] int64


class Settings(NamedTuple):
    """Settings that all environments of a batch share."""

    width: int  # W
    max_steps: int
    see_through: bool  # walls hide nothing
    as_image: bool  # the representation is "image"


class Outcome(NamedTuple):
    """The results of a step."""

    reward: np.ndarray  # [N] float64
    terminated: np.ndarray  # [N] bool
    truncated: np.ndarray  # [N] bool


def width_of(side: int) -> int:
    """Return W of mazes of S x S cells."""
    return side + 2 * BORDER


def entry_of(cells: np.ndarray, side: int) -> np.ndarray:
    """Return the entries of the grid at which cells, `S y + x`, lie: of the same shape."""
    return (cells // side + BORDER) * width_of(side) + cells % side + BORDER


def empty_layouts(count: int, side: int) -> Layouts:
    """Allocate `count` mazes that are all walls, with agents in the first cell."""
    grid = np.full((count, width_of(side) ** 2), WALL, np.uint8)
    return Layouts(grid, entry_of(np.zeros(count, np.int64), side), np.zeros(count, np.int64))


def layouts_of(walls: np.ndarray, start: np.ndarray, goal: np.ndarray, direction: np.ndarray) -> Layouts:
    """Return mazes with these walls, bool `[K, S, S]`, starts and goals as cells `S y + x` `[K]`, directions `[K]`."""
    count, side, _ = walls.shape
    made, width = empty_layouts(count, side), width_of(side)
    inner = made.grid.reshape(count, width, width)[:, BORDER:-BORDER, BORDER:-BORDER]
    inner[:] = np.where(walls, np.uint8(WALL), np.uint8(EMPTY))
    rows = np.arange(count)
    made.grid[rows, entry_of(start, side)] = EMPTY
    made.grid[rows, entry_of(goal, side)] = GOAL
    made.start[:], made.direction[:] = entry_of(start, side), direction
    return made
