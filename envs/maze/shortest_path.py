"""A policy that follows shortest paths: an upper bound on the return of students. Read next: `paths`; `task`."""

from __future__ import annotations

from typing import Any

import numpy as np

from regista.envs.maze.env import Mazes
from regista.envs.maze.grid import DIRECTIONS
from regista.envs.maze.paths import UNREACHABLE, choose_shortest, steps_to_goal
from ued.core.baselines import Untrained


class ShortestPath(Untrained):
    """Follow a shortest path to the goal, so no policy is faster. This policy reads the full mazes, unlike agents.

    Args:
        mazes: the environments in which it plays; `within` returns the same policy for other environments.
    """

    def __init__(self, mazes: Mazes) -> None:
        self.mazes = mazes
        grid = mazes.layouts.grid
        self._seen = np.zeros_like(grid)  # [N, W * W], the grids for which the stored steps were computed
        self._steps = np.full((*grid.shape, DIRECTIONS), UNREACHABLE, np.int64)
        self._queue = np.zeros(DIRECTIONS * grid.shape[1], np.int64)

    def within(self, upomdp: Mazes) -> ShortestPath:
        """Return this policy for other environments."""
        return ShortestPath(upomdp)

    def steps(self) -> np.ndarray:
        """Return the number of steps of each agent to its goal, UNREACHABLE without a path: int `[N]`."""
        grid, width = self.mazes.layouts.grid, self.mazes.width
        for e in np.flatnonzero((grid != self._seen).any(1)).tolist():
            steps_to_goal(grid[e], width, self._steps[e], self._queue)
            self._seen[e] = grid[e]
        agents = self.mazes.agents
        return self._steps[np.arange(len(grid)), agents.at, agents.direction]

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each environment `[N]`; `observation` `[N, F]` is not read."""
        actions = np.zeros(len(self.steps()), np.int64)
        choose_shortest(self.mazes.agents, self._steps, self.mazes.width, actions)
        return actions
