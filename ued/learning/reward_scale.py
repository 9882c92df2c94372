"""Reward normalization, for the student's learning only: tables, scores of levels and regret use raw returns.

Rewards are divided by the running standard deviation of discounted returns, as Gymnasium's vector wrapper
`NormalizeReward` does, and then limited to [-10, 10], as in CleanRL's `ppo_continuous_action.py` (Engstrom et al. 2020,
"reward scaling"). Episodes do not depend on rewards, so a rollout is normalized after it ends, and compiled rollouts
need no other kernel.
Read next: `learning.learner`, whose critic then predicts normalized returns.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from ued.core.resumable import Resumable
from ued.learning.rollout import Rollout

EPSILON = 1e-8  # added to the variance (Gymnasium)
LIMIT = 10.0  # limit of normalized rewards (CleanRL)
FIRST = 1e-4  # weight of the initial variance of 1 (Gymnasium)


class RewardScale(Resumable):
    """The running standard deviation of discounted returns over all training steps of the student.

    Args:
        shape: shape of the rewards of one step: `(N,)`, for opponents `(N, A)`.
        gamma: discount per step.
    """

    state_fields = ("returns", "mean", "variance", "count")

    def __init__(self, shape: tuple[int, ...], gamma: float) -> None:
        self.gamma = gamma
        self.returns = np.zeros(shape)  # discounted, of the open episodes: later rewards have the larger weights
        self.mean, self.variance, self.count = 0.0, 1.0, FIRST

    @property
    def scale(self) -> float:
        """The current divisor of rewards."""
        return float(np.sqrt(self.variance + EPSILON))

    def reset(self) -> None:
        """Discard the open episodes, after a reset of all environments."""
        self.returns[:] = 0.0

    def normalize(self, rollout: Rollout) -> Rollout:
        """Return a rollout with normalized rewards, step by step; each step first updates the statistics."""
        rewards = rollout.reward.numpy()  # [T, N] or [T, N, A]
        train, terminated, ended = (
            flags.numpy().reshape(*flags.shape, *[1] * (rewards.ndim - 2))
            for flags in (rollout.train, rollout.terminated, rollout.terminated | rollout.truncated)
        )
        scaled = np.empty_like(rewards)
        for t, reward in enumerate(rewards):
            self.returns *= self.gamma * ~terminated[t]
            self.returns += reward
            self._track(self.returns[np.broadcast_to(train[t], reward.shape)])
            scaled[t] = np.clip(reward / self.scale, -LIMIT, LIMIT)
            self.returns *= ~ended[t]
        return replace(rollout, reward=torch.from_numpy(scaled))

    def _track(self, returns: np.ndarray) -> None:
        """Update mean and variance with returns `[n]` (Chan et al. 1979, parallel form)."""
        rows = len(returns)
        if not rows:
            return
        total, delta = self.count + rows, float(returns.mean()) - self.mean
        squares = self.variance * self.count + float(returns.var()) * rows + delta**2 * self.count * rows / total
        self.mean += delta * rows / total
        self.variance, self.count = squares / total, total

    def with_raw_rewards(self, rollout: Rollout) -> Rollout:
        """Return a rollout with its own rewards, and with the critic's values in their unit: scores have no limit."""
        names = ("value", "final_value", "last_value")
        return replace(rollout, **{name: getattr(rollout, name) * self.scale for name in names})
