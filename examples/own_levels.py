"""Your own levels that are not vectors of numbers: walls, a start and a goal, with PLR, ACCEL and PAIRED.

    python examples/own_levels.py --method accel --env-steps 200000

`Mazes` defines how to sample, mutate and encode a maze; PLR and ACCEL require nothing else. PAIRED also requires
`parameters`, which describe the columns of the code.
"""

import argparse
from typing import ClassVar, NamedTuple

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete

import ued

SIDE = 9
LONGEST = 50  # maximum number of steps
MOST_WALLS = 30
MOVES = np.array([[-1, 0], [1, 0], [0, -1], [0, 1]])  # up, down, left, right


class Maze(NamedTuple):
    """One level: the walls `[SIDE, SIDE]` bool, and the cells of start and goal."""

    walls: np.ndarray
    start: tuple[int, int]
    goal: tuple[int, int]


class Mazes:
    """Mazes as levels: a `ued.LevelFamily`."""

    size = SIDE * SIDE + 2  # one entry per cell, then the positions of start and goal
    parameters: ClassVar = {  # optional, for adversaries: the columns of a code
        **{f"wall {cell}": ued.Choice(False, True, weights=(5, 1)) for cell in range(SIDE * SIDE)},
        "start": ued.Choice(*range(SIDE * SIDE)),
        "goal": ued.Choice(*range(SIDE * SIDE)),
    }

    def sample(self, rng: np.random.Generator) -> Maze:
        """Draw up to MOST_WALLS walls anywhere, and start and goal in free cells."""
        cells = rng.permutation(SIDE * SIDE)
        walls = np.zeros(SIDE * SIDE, bool)
        walls[cells[2 : 2 + rng.integers(MOST_WALLS + 1)]] = True
        return Maze(walls.reshape(SIDE, SIDE), divmod(int(cells[0]), SIDE), divmod(int(cells[1]), SIDE))

    def mutate(self, level: Maze, rng: np.random.Generator) -> Maze:
        """Add or remove one wall, or move the goal to a free cell."""
        walls, cell = level.walls.copy(), tuple(rng.integers(SIDE, size=2).tolist())
        if cell in (level.start, level.goal):
            return level
        if rng.random() < 0.2 and not walls[cell]:
            return level._replace(goal=cell)
        walls[cell] = not walls[cell]
        return level._replace(walls=walls)

    def encode(self, level: Maze) -> np.ndarray:
        """Return the walls as ±1, and both positions in [-1, 1]."""
        places = [(2 * (y * SIDE + x) + 1) / SIDE**2 - 1 for y, x in (level.start, level.goal)]
        return np.concatenate([np.where(level.walls.ravel(), 1.0, -1.0), places])

    def decode(self, code: np.ndarray) -> Maze:
        """Return the maze that a code describes, without walls at start and goal."""
        start, goal = (divmod(int((place + 1) / 2 * SIDE**2), SIDE) for place in code[-2:])
        walls = code[:-2].reshape(SIDE, SIDE) > 0
        walls[start] = walls[goal] = False
        return Maze(walls, start, goal)


class MazeEnv(gymnasium.Env):
    """Reach the goal for a reward of 1 - 0.9 t / LONGEST. The observation has planes for walls, agent and goal."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 8}  # noqa: RUF012
    observation_space = Box(0, 255, (SIDE, SIDE, 3), np.uint8)
    action_space = Discrete(4)
    maze: Maze

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.steps = self.maze.start, 0
        return self._observe(), {}

    def step(self, action):
        y, x = np.clip(np.add(self.at, MOVES[action]), 0, SIDE - 1).tolist()
        if not self.maze.walls[y, x]:
            self.at = (y, x)
        self.steps += 1
        arrived = self.at == self.maze.goal
        reward = 1 - 0.9 * self.steps / LONGEST if arrived else 0.0
        return self._observe(), reward, arrived, self.steps >= LONGEST, {}

    def render(self):
        walls = np.where(self.maze.walls[..., None], (60, 60, 70), (235, 235, 230)).astype(np.uint8)
        walls[self.maze.goal], walls[self.at] = (60, 170, 90), (220, 80, 50)
        return walls.repeat(16, 0).repeat(16, 1)

    def _observe(self) -> np.ndarray:
        seen = np.zeros((SIDE, SIDE, 3), np.uint8)
        seen[..., 0] = 255 * self.maze.walls
        seen[(*self.at, 1)] = seen[(*self.maze.goal, 2)] = 255
        return seen


def put(env: gymnasium.Env, level: Maze) -> None:
    """Apply a level to an environment."""
    env.unwrapped.maze = level


def is_maze(level: Maze) -> bool:
    """Return whether a level is valid; an adversary may propose invalid ones."""
    return level.start != level.goal


def make(num_envs: int = 32) -> ued.GymUPOMDP:
    """Make training environments."""
    return ued.GymUPOMDP(lambda: MazeEnv("rgb_array"), put, Mazes(), num_envs, valid=is_maze)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", choices=["plr", "accel", "paired"], default="accel")
    parser.add_argument("--env-steps", type=int, default=200_000)
    arguments = parser.parse_args()
    buffer = ued.BufferConfig(capacity=256)
    settings = {
        "plr": ued.PLRConfig(buffer=buffer),
        "accel": ued.ACCELConfig(buffer=buffer),
        "paired": ued.PairedConfig(),
    }
    kind = ued.METHODS[arguments.method].load()
    method = kind(make(), ued.PPOConfig(num_steps=64), settings[arguments.method], seed=0)
    while method.env_steps < arguments.env_steps:
        metrics = method.update()
        mean = metrics[f"return/{method.learners[0].name}"]
        print(f"{method.env_steps} env_steps, return {mean:.2f}, {metrics['levels']:.0f} levels")


if __name__ == "__main__":
    main()
