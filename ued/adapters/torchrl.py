"""A UPOMDP as a batched TorchRL environment, like VMAS: `TorchRLEnv(upomdp).rollout(100)` has `batch_size` `[N]`.

Each episode plays a random level, or one of `upomdp.level_sampler`; "theta" is its level. TorchRL receives the last
observation of an episode, then resets.
Read next: `sb3`, the same for Stable-Baselines3.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete, Space
from tensordict import TensorDict, TensorDictBase
from torch import Tensor
from torchrl.data import Binary, Bounded, Categorical, Composite, MultiCategorical, TensorSpec, Unbounded
from torchrl.envs import EnvBase

from ued.core.sparse_image import as_dense, dense_space
from ued.core.upomdp import UPOMDP


class TorchRLEnv(EnvBase):
    """N environments of one agent for TorchRL; discrete actions start at 0.

    Raises `ValueError` for a team, and for spaces that TorchRL does not support.
    """

    def __init__(self, upomdp: UPOMDP) -> None:
        if upomdp.num_agents > 1:
            raise ValueError(
                f"TorchRLEnv supports one agent, the environments have {upomdp.num_agents}; use TorchRL's wrapper "
                "of the PettingZoo environment for a football team: examples/with_torchrl.py"
            )
        super().__init__(device="cpu", batch_size=torch.Size([upomdp.num_envs]))
        if upomdp.level_sampler is None:
            upomdp.level_sampler = upomdp.sample_levels
        self.upomdp, count = upomdp, upomdp.num_envs
        self.first = getattr(upomdp.single_action_space, "start", 0)
        self.space = upomdp.single_observation_space
        seen, theta = spec_of(dense_space(self.space), count), spec_of(upomdp.theta_space, count)
        self.observation_spec = Composite(observation=seen, theta=theta, shape=[count])
        self.action_spec = spec_of(upomdp.single_action_space, count)
        self.reward_spec = Unbounded([count, 1])
        ends = {
            name: Categorical(2, shape=[count, 1], dtype=torch.bool) for name in ("done", "terminated", "truncated")
        }
        self.done_spec = Composite(ends, shape=[count])

    def _reset(self, tensordict: TensorDictBase | None = None, **_: Any) -> TensorDictBase:
        mask = None if tensordict is None else tensordict.get("_reset", None)
        where = np.ones(self.upomdp.num_envs, bool) if mask is None else mask.flatten().numpy()
        if where.any():
            self._now = self.upomdp.start_next(where)
        return TensorDict(self._observe(self._now, self.upomdp.levels["theta"]), self.batch_size)

    def _step(self, tensordict: TensorDictBase) -> TensorDictBase:
        action = tensordict["action"].numpy() + self.first
        self._now, reward, terminated, truncated, _ = self.upomdp.advance(action)
        ends = {"terminated": terminated, "truncated": truncated, "done": terminated | truncated}
        results = {name: torch.as_tensor(value)[:, None] for name, value in ends.items()}
        results["reward"] = torch.as_tensor(reward, dtype=torch.float32)[:, None]
        return TensorDict(self._observe(self._now, self.upomdp.levels["theta"]) | results, self.batch_size)

    def _observe(self, seen: Any, theta: np.ndarray) -> dict[str, Tensor]:
        return {
            "observation": torch.as_tensor(np.array(as_dense(self.space, seen))),
            "theta": torch.as_tensor(theta.copy()),
        }

    def _set_seed(self, seed: int | None) -> None:
        """Seed the stream of levels; episodes begin with the next reset."""
        self._now, _ = self.upomdp.reset(seed=seed)


def spec_of(space: Space, num_envs: int) -> TensorSpec:
    """Return the TorchRL spec of N environments for the space of one."""
    shape = (num_envs, *(space.shape or ()))
    if isinstance(space, Discrete):
        return Categorical(int(space.n), shape=[num_envs], dtype=torch.int64)
    if isinstance(space, MultiDiscrete) and space.nvec.ndim == 1:
        return MultiCategorical(space.nvec.tolist(), shape=shape, dtype=torch.int64)
    if isinstance(space, MultiBinary):
        return Binary(shape=shape, dtype=torch.int8)
    if isinstance(space, Box):
        low, high = (torch.as_tensor(bound).expand(shape) for bound in (space.low, space.high))
        if not (low.isfinite() & high.isfinite()).all():
            return Unbounded(shape, dtype=low.dtype)
        return Bounded(low, high, shape=shape, dtype=low.dtype)
    raise ValueError(f"TorchRL does not support the space {space}")
