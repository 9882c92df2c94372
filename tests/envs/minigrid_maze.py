"""Mazes of ours, played by the `minigrid` package: the reference of `envs/maze`.

python -m tests.envs.minigrid_maze      # write `minigrid_plays.npz`, which tests compare where minigrid is missing
"""

from pathlib import Path

import numpy as np
from minigrid.core.grid import Grid
from minigrid.core.mission import MissionSpace
from minigrid.core.world_object import Goal, Wall
from minigrid.minigrid_env import MiniGridEnv

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.levels import Maze
from tests.envs.minigrid_plays import RECORDED, vectors_of

PLAYS = Path(__file__).with_name("minigrid_plays.npz")


class MiniGridMaze(MiniGridEnv):
    """A maze in MiniGrid, set by `maze` before each reset."""

    def __init__(self, config):
        super().__init__(
            mission_space=MissionSpace(lambda: "reach the goal"),
            grid_size=config.side + 2,
            max_steps=config.max_steps,
            see_through_walls=config.see_through,
            agent_view_size=5,
        )
        self.maze = None

    def _gen_grid(self, width, height):
        self.grid = Grid(width, height)
        self.grid.wall_rect(0, 0, width, height)
        for y, x in np.argwhere(self.maze.walls):
            self.put_obj(Wall(), int(x) + 1, int(y) + 1)
        self.put_obj(Goal(), self.maze.goal[1] + 1, self.maze.goal[0] + 1)
        self.agent_pos = np.array([self.maze.start[1] + 1, self.maze.start[0] + 1])
        self.agent_dir = self.maze.direction


def compare(config: MazeConfig, num_mazes: int, num_steps: int, seed: int) -> dict[str, int]:
    """Play random mazes in both, random actions with twice as many forward; raise AssertionError at a difference.

    Each maze is played for `num_steps`; an episode that ends begins again. Returns what was compared: steps, episodes
    terminated and truncated, moves, and cells that walls hid.
    """
    ours = Mazes(num_mazes, config)
    ours.reset(seed=seed)
    theirs = [MiniGridMaze(config) for _ in range(num_mazes)]
    seen = [_begin(env, level) for env, level in zip(theirs, ours.levels, strict=True)]
    _assert_same(ours, seen)
    rng, counts = np.random.default_rng(seed), dict.fromkeys(("steps", "terminated", "truncated", "hidden"), 0)
    for _ in range(num_steps):
        actions = rng.choice([0, 1, 2, 2], num_mazes)
        vectors, reward, terminated, truncated, info = ours.advance(actions)
        results = [env.step(int(action)) for env, action in zip(theirs, actions, strict=True)]
        seen, *others = zip(*(result[:4] for result in results), strict=True)
        seen = list(seen)
        for name, mine, other in zip(
            ("reward", "terminated", "truncated"), (reward, terminated, truncated), others, strict=True
        ):
            np.testing.assert_array_equal(mine, np.array(other), name)
        np.testing.assert_array_equal(info["success"], np.array(others[0]) > 0)
        _assert_same(ours, seen, vectors)
        counts["steps"] += num_mazes
        counts["terminated"] += int(terminated.sum())
        counts["truncated"] += int(truncated.sum())
        counts["hidden"] += int((ours.images()[..., 0] == 0).sum())
        ended = terminated | truncated
        if ended.any():
            ours.play_again(ended)
            for index in np.flatnonzero(ended):
                seen[index] = _begin(theirs[index], ours.levels[index])
            _assert_same(ours, seen)
    return counts


def _begin(env, level):
    env.maze = level_maze(env, level)
    return env.reset()[0]


def level_maze(env, level):
    """Return the maze of a level record, decoded cell by cell and so not as the batch decodes it."""
    side = env.width - 2
    walls = level["theta"][: side * side].reshape(side, side) > 0
    places = [int((code + 1) / 2 * side * side) for code in level["theta"][-3:-1]]
    start, goal = (divmod(place, side) for place in places)
    return Maze(walls, start, goal, int((level["theta"][-1] + 1) / 2 * 4))


def _assert_same(ours, seen, vectors=None):
    images, directions = np.stack([one["image"] for one in seen]), np.array([one["direction"] for one in seen])
    np.testing.assert_array_equal(ours.images(), images, "image")
    np.testing.assert_array_equal(ours.directions(), directions, "direction")
    if vectors is not None:
        np.testing.assert_array_equal(vectors, vectors_of(images, directions, ours.config), "observation")


def record(config: MazeConfig, num_mazes: int, num_steps: int) -> dict[str, np.ndarray]:
    """Play random mazes in MiniGrid; return what `minigrid_plays` compares. Episodes that end begin again."""
    sampled = Mazes(num_mazes, config)
    sampled.reset(seed=0)
    theirs = [MiniGridMaze(config) for _ in range(num_mazes)]
    actions = np.random.default_rng(1).choice([0, 1, 2, 2], (num_steps, num_mazes))
    found = {name: [] for name in ("image", "direction", "reward", "terminated", "truncated")}
    for env, level in zip(theirs, sampled.levels, strict=True):
        _begin(env, level)
    for row in actions:
        results = [env.step(int(action)) for env, action in zip(theirs, row, strict=True)]
        seen, *others = zip(*(result[:4] for result in results), strict=True)
        for name, values in zip(("reward", "terminated", "truncated"), others, strict=True):
            found[name].append(values)
        for name in ("image", "direction"):
            found[name].append([one[name] for one in seen])
        for index, ended in enumerate(np.logical_or(*others[1:])):
            if ended:
                _begin(theirs[index], sampled.levels[index])
    return {"theta": sampled.levels["theta"], "actions": actions} | {
        name: np.array(rows) for name, rows in found.items()
    }


if __name__ == "__main__":
    plays = {}
    for name, (config, *size) in RECORDED.items():
        plays |= {f"{name} {key}": values for key, values in record(config, *size).items()}
    np.savez_compressed(PLAYS, **plays)
