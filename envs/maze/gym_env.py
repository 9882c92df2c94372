"""One maze as a standard Gymnasium environment, a batch of one, and the batch for `gymnasium.make_vec`.

    env = gymnasium.make("regista/Maze-v0")                       # one maze, a new one in each episode
    envs = gymnasium.make_vec("regista/Maze-v0", num_envs=256)    # a native batch

Read next: `env`, which does the work.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes


class MazeEnv(gymnasium.Env):
    """One maze. Each `reset` samples a new one, or uses θ `[D]` in [-1, 1] from `options={"theta": θ}`.

    Args:
        render_mode: None or "rgb_array".
        settings: the fields of `MazeConfig`.

    After a reset, `info["theta"]` is the θ of the maze, and `info["replaced"]` is true if a valid maze replaces an
    invalid one. After a step, `info["success"]` is 1 if the agent is at the goal. Raises ValueError for another render
    mode or for values of settings outside their bounds.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": Mazes.metadata["render_fps"]}  # noqa: RUF012

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.batch = Mazes(1, MazeConfig(**settings), render_mode)
        self.observation_space = self.batch.single_observation_space
        self.action_space = self.batch.single_action_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start a maze; return the observation, float32 `[F]`. Raises `ThetaError` for an invalid θ."""
        super().reset(seed=seed)
        given = {**(options or {})}
        if "theta" in given:
            given["theta"] = [given["theta"]]
        seen, info = self.batch.reset(seed=seed, options=given)
        return seen[0], {"theta": info["levels"]["theta"][0], "replaced": bool(info["replaced"][0])}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Let the agent act: 0 turn left, 1 turn right, 2 forward."""
        seen, rewards, terminated, truncated, info = self.batch.advance(np.array([action]))
        success = {"success": float(info["success"][0])}
        return seen[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), success

    def render(self) -> np.ndarray | None:
        """Return the maze as a picture, uint8 `[pixels, pixels, 3]`; None without a render mode."""
        images = self.batch.render()
        return None if images is None else images[0]


def make_vec(num_envs: int = 1, render_mode: str | None = None, **settings: Any) -> Mazes:
    """Make the native batch for `gymnasium.make_vec`: a new random maze in every episode.

    `settings` are the fields of `MazeConfig`.
    """
    env = Mazes(num_envs, MazeConfig(**settings), render_mode)
    env.level_sampler = env.sample_levels
    return env
