"""Mazes as pictures: walls, the goal, the agent as an arrowhead, and the cells that it sees.

Read next: `painter`, mazes in recordings and on plots.
"""

from __future__ import annotations

import numpy as np

from regista.envs.maze.grid import BORDER, DIRECTIONS, GOAL, VIEW, WALL
from regista.envs.maze.view import CELLS, MIDDLE

WALL_COLOR, FLOOR, SEEN_FLOOR = (58, 62, 72), (236, 234, 228), (255, 241, 190)
SEEN_WALL = (92, 88, 84)
GOAL_COLOR, AGENT_COLOR = (213, 94, 0), (31, 119, 208)  # orange and blue: distinct with red-green color blindness
PIXELS = 320  # side of a small maze's picture, rounded down to whole cells
LEAST_CELL = 8  # pixels, minimum side of a cell


def view_entries(at: int, direction: int, width: int) -> np.ndarray:
    """Return the entries of the grid in the view of an agent at an entry, in the order of `view`: int `[25]`."""
    strides = (1, width, -1, -width)
    ahead, aside = strides[direction], strides[(direction + 1) % DIRECTIONS]
    column, row = np.divmod(np.arange(CELLS), VIEW)
    return at + (BORDER - row) * ahead + (column - MIDDLE) * aside


def draw_maze(grid: np.ndarray, at: int, direction: int, seen: np.ndarray) -> np.ndarray:
    """Draw the inner cells of a maze with one row of border on each side: uint8 `[pixels, pixels, 3]`.

    Args:
        grid: `[W * W]`, see `grid`.
        at: the agent's entry of the grid.
        direction: the direction that the agent faces.
        seen: the entries that the agent sees.
    """
    width = int(len(grid) ** 0.5)
    cells = np.where((grid == WALL)[:, None], WALL_COLOR, FLOOR).astype(np.uint8)
    cells[seen] = np.where((grid[seen] == WALL)[:, None], SEEN_WALL, SEEN_FLOOR)
    cells[grid == GOAL] = GOAL_COLOR
    inside = slice(BORDER - 1, 1 - BORDER)
    shown = cells.reshape(width, width, 3)[inside, inside]
    size = max(LEAST_CELL, PIXELS // len(shown))
    picture = shown.repeat(size, 0).repeat(size, 1)
    row, column = (size * (place - BORDER + 1) for place in divmod(at, width))
    corner = picture[row : row + size, column : column + size]
    corner[arrow_head(size, direction)] = AGENT_COLOR
    return picture


def arrow_head(size: int, direction: int) -> np.ndarray:
    """Return the pixels of an arrowhead that points in a direction: bool `[size, size]`."""
    place = (np.arange(size) + 0.5) / size
    along, across = place[None, :], np.abs(place[:, None] - 0.5)
    right = (along > 0.15) & (across < 0.42 * (0.9 - along) / 0.75)
    return np.rot90(right, -direction)
