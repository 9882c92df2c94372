"""Building mazes step by step: the adversary's side of PAIRED's mazes, with the rules of DCD.

The rules are those of `AdversarialEnv.step_adversary` in DCD's `envs/multigrid/adversarial.py`, which is PAIRED's own
code. An action is a cell. The first action places the goal, the second one the agent, and the others place walls
(`choose_goal_last=False`). With `goal_last` walls come first, as in DCD's `GoalLast` environments, which DCD used for
its published PAIRED results.

- A wall in the cell of a wall, the goal or the agent has no effect, so a maze may have fewer walls than steps.
- A goal or an agent in the cell of a wall removes the wall.
- An agent in the cell of the goal goes to a random free cell instead.
- With a random number of walls, the first action also determines that number: cell c of C allows c M / C of M walls
  (`resample_n_clutter`). The remaining actions then have no effect.
- The direction of the agent is random, not chosen.

An observation holds walls, goal and agent, one plane of cells each, and the direction. Read next: `levels`, the family.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from regista.envs.maze.grid import DIRECTIONS
from ued.core.cells import bin_center

NOWHERE = -1  # the cell of a goal or an agent that is not placed yet


@dataclass
class Sites:
    """n mazes under construction, all after the same number of steps; cells are numbered row by row."""

    walls: np.ndarray  # [n, C] bool
    goal: np.ndarray  # [n] the cell of the goal, or NOWHERE
    start: np.ndarray  # [n] the cell of the agent, or NOWHERE
    limit: np.ndarray  # [n] number of steps; later steps place nothing
    luck: np.ndarray  # [n] int64: determines the direction, and the free cell of an agent placed on the goal
    step: int = 0


class MazeBuilder:
    """The steps in which an adversary builds mazes of S x S cells: a `ued.LevelBuilder`.

    Args:
        side: S.
        num_walls: the maximum number of walls.
        random_count: let the first action limit their number.
        goal_last: place goal and agent in the last two steps, instead of the first two.
    """

    def __init__(self, side: int, num_walls: int, random_count: bool = False, goal_last: bool = False) -> None:
        self.side, self.num_walls = side, num_walls
        self.random_count, self.goal_last = random_count, goal_last
        self.steps, self.actions = num_walls + 2, side**2

    def begin(self, luck: np.ndarray) -> Sites:
        """Return n mazes without walls, goal and agent."""
        count, luck = len(luck), np.asarray(luck, np.int64)
        walls, nowhere = np.zeros((count, self.actions), bool), np.full(count, NOWHERE)
        return Sites(walls, nowhere, nowhere.copy(), np.full(count, self.steps), luck)

    def apply(self, levels: Sites, actions: np.ndarray) -> Sites:
        """Place the next wall, goal or agent of each maze in the cells `actions` `[n]`, in place."""
        if self.random_count and levels.step == 0:
            levels.limit = actions * self.num_walls // self.actions + 2
        first = levels.limit - 2 if self.goal_last else np.zeros_like(levels.limit)
        goal, agent = levels.step == first, levels.step == first + 1
        wall = ~goal & ~agent & (levels.step < levels.limit) & (actions != levels.goal) & (actions != levels.start)
        levels.walls[np.flatnonzero(wall), actions[wall]] = True
        levels.walls[np.flatnonzero(goal | agent), actions[goal | agent]] = False
        levels.goal = np.where(goal, actions, levels.goal)
        elsewhere = agent & (actions == levels.goal)
        levels.start = np.where(agent, actions, levels.start)
        levels.start[elsewhere] = _random_free(levels, elsewhere)
        levels.walls[np.flatnonzero(elsewhere), levels.start[elsewhere]] = False
        levels.step += 1
        return levels

    def observe(self, levels: Sites) -> np.ndarray:
        """Return walls, goal, agent and direction: `[n, 3 C + 4]`, 0 or 1."""
        cells = np.arange(self.actions)
        places = (place[:, None] == cells for place in (levels.goal, levels.start))
        facing = direction(levels)[:, None] == np.arange(DIRECTIONS)
        return np.concatenate([levels.walls, *places, facing], 1).astype(np.float32)

    def codes(self, levels: Sites) -> np.ndarray:
        """Return the codes `[n, C + 3]` of finished mazes; see `levels.MazeFamily`."""
        rest = np.stack([levels.start, levels.goal, direction(levels)], 1)
        return bin_center(np.concatenate([levels.walls, rest], 1), bins(self.side))


def direction(levels: Sites) -> np.ndarray:
    """Return the directions that the agents face: int `[n]`."""
    return levels.luck % DIRECTIONS


def bins(side: int) -> np.ndarray:
    """Return the number of values of each entry of a code, int `[S * S + 3]`."""
    cells = side * side
    return np.array([2] * cells + [cells, cells, DIRECTIONS])


def _random_free(levels: Sites, where: np.ndarray) -> np.ndarray:
    """Return a random cell without wall or goal for each maze of `where`; if all are walls, any cell but the goal's."""
    other = np.arange(levels.walls.shape[1]) != levels.goal[where][:, None]
    free = ~levels.walls[where] & other
    free = np.where(free.any(1, keepdims=True), free, other)
    chosen = levels.luck[where] // DIRECTIONS % free.sum(1)
    return (free.cumsum(1) > chosen[:, None]).argmax(1)
