"""Drawings of mazes in recordings, galleries and plots of levels: a `ued.core.painter.ScenePainter`.

Read next: `picture`, mazes as images.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.maze.grid import BORDER, GOAL, VIEW, WALL, width_of
from regista.envs.maze.picture import AGENT_COLOR, GOAL_COLOR, SEEN_FLOOR

if TYPE_CHECKING:
    from regista.envs.maze.env import Mazes

CELL = 4.0  # m: recordings have lines and dots of fixed size, made for a football pitch
MARKERS = (
    ("walls", (120, 126, 140), 0.5 * CELL),
    ("seen cells", SEEN_FLOOR, 0.12 * CELL),
    ("goal", GOAL_COLOR, 0.42 * CELL),
    ("agent", AGENT_COLOR, 0.36 * CELL),
    ("its front", (255, 255, 255), 0.14 * CELL),
)
WALLS, SEEN, GOALS, AGENT, FRONT = range(5)
FORWARD_OF = np.array([(1, 0), (0, -1), (-1, 0), (0, 1)])  # x right, y up, by direction


class MazePainter:
    """Draws walls as squares, and the goal, the agent and its front as discs; during an episode also the cells in view.

    Points without a position, such as walls that a maze does not have, are NaN.
    """

    background = (24, 26, 32)
    line_color = (200, 204, 214)
    markers = MARKERS

    def __init__(self, mazes: Mazes) -> None:
        self.side = side = mazes.config.side
        self.bounds = self.reach = (0.0, CELL * side, 0.0, CELL * side)
        self.classes = np.array([WALLS] * side**2 + [SEEN] * VIEW**2 + [GOALS, AGENT, FRONT])
        self.tiles, self.details = self.classes == WALLS, np.isin(self.classes, (SEEN, FRONT))
        self.focus = side**2 + VIEW**2  # the goal
        self._layouts = mazes.layouts_of

    def lines(self) -> list[np.ndarray]:
        """Return the border."""
        low, high = 0.0, CELL * self.side
        return [np.array([(low, low), (high, low), (high, high), (low, high), (low, low)])]

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the points of the mazes of θ `[L, D]` at the start of an episode: `[L, K, 2]`."""
        layouts = self._layouts(theta)
        return self._points(layouts.grid, layouts.start, layouts.direction)

    def frame(self, env: Any) -> np.ndarray:
        """Return the current points of the first environment of `env`: `[K, 2]`."""
        points = self._points(env.layouts.grid[:1], env.agents.at[:1], env.agents.direction[:1])[0]
        seen = self._places(env.seen()[0])
        inside = seen[((seen > 0) & (seen < CELL * self.side)).all(1)]
        points[self.side**2 : self.side**2 + len(inside)] = inside
        return points

    def _points(self, grid: np.ndarray, at: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Return the points of L mazes, without what the agent sees: `[L, K, 2]`."""
        points = np.full((len(grid), len(self.classes), 2), np.nan)
        width = width_of(self.side)
        inner = grid.reshape(-1, width, width)[:, BORDER:-BORDER, BORDER:-BORDER]
        maze, wall = np.nonzero(inner.reshape(len(grid), self.side**2) == WALL)
        points[maze, wall] = CELL * np.stack([wall % self.side + 0.5, self.side - 0.5 - wall // self.side], 1)
        agent = self._places(at)
        points[:, self.classes == GOALS] = self._places((grid == GOAL).argmax(1))[:, None]
        points[:, self.classes == AGENT] = agent[:, None]
        points[:, self.classes == FRONT] = (agent + 0.3 * CELL * FORWARD_OF[direction])[:, None]
        return points

    def _places(self, entries: np.ndarray) -> np.ndarray:
        """Return the centers of entries of the grid `[n]`: `[n, 2]` m."""
        row, column = np.divmod(entries, width_of(self.side))
        return CELL * np.stack([column - BORDER + 0.5, self.side - 0.5 - (row - BORDER)], 1)
