"""A UPOMDP as Stable-Baselines3's `VecEnv`: `PPO("MlpPolicy", SB3VecEnv(upomdp)).learn(100_000)`.

Each episode plays a random level, or one of `upomdp.level_sampler`; `info["theta"]` and `info["level_seed"]`
identify the level of an ended episode. Read next: `examples/with_stable_baselines3.py`, which uses a curriculum.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from ued.core.sparse_image import as_dense, dense_space
from ued.core.upomdp import UPOMDP


class SB3VecEnv(VecEnv):
    """N environments for Stable-Baselines3. Attributes and methods of single environments are those of all of them."""

    def __init__(self, upomdp: UPOMDP) -> None:
        if upomdp.num_agents > 1:
            raise ValueError(f"Stable-Baselines3 supports one agent; the environments have {upomdp.num_agents}")
        self.upomdp = upomdp
        self._seed: int | None = None
        if upomdp.level_sampler is None:
            upomdp.level_sampler = upomdp.sample_levels
        super().__init__(upomdp.num_envs, dense_space(upomdp.single_observation_space), upomdp.single_action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the stream of levels at the next reset."""
        self._seed = seed
        return [seed] * self.num_envs

    def reset(self) -> Any:
        """Start an episode in all environments."""
        observations, _ = self.upomdp.reset(seed=self._seed)
        if self.upomdp.level_sampler != self.upomdp.sample_levels:  # a user-defined sampler
            observations = self.upomdp.start_next(np.ones(self.num_envs, bool))
        self._seed, self.returns, self.lengths = None, np.zeros(self.num_envs), np.zeros(self.num_envs, int)
        return as_dense(self.upomdp.single_observation_space, observations)

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all environments; the info of an ended episode has its last observation, return and level."""
        levels = self.upomdp.levels.copy()
        observations, rewards, terminated, truncated, info = self.upomdp.step(self._actions)
        space = self.upomdp.single_observation_space
        self.returns += rewards
        self.lengths += 1
        dones, infos = terminated | truncated, [dict[str, Any]() for _ in range(self.num_envs)]
        for index in np.flatnonzero(dones).tolist():
            infos[index] = {
                "terminal_observation": as_dense(space, info["final_obs"][index]),
                "TimeLimit.truncated": bool(truncated[index] and not terminated[index]),
                "episode": {"r": float(self.returns[index]), "l": int(self.lengths[index]), "t": 0.0},
                "theta": levels["theta"][index],
                "level_seed": int(levels["seed"][index]),
            }
        self.returns[dones], self.lengths[dones] = 0.0, 0
        return as_dense(space, observations), rewards.astype(np.float32), dones, infos

    def close(self) -> None:
        self.upomdp.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.upomdp, attr_name, None)] * len(self._indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        setattr(self.upomdp, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        return [getattr(self.upomdp, method_name)(*args, **kwargs)] * len(self._indices(indices))

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * len(self._indices(indices))

    def _indices(self, indices: Any) -> list[int]:
        return list(self._get_indices(indices))
