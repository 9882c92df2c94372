"""The experience of a student in T steps of N environments, and its advantages by GAE.

Read next: `learning.worker`, which fills rollouts, then `learning.ppo`, which learns from them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import torch
from gymnasium.spaces import Discrete, Space
from torch import Tensor

from ued.learning.networks import choices_of


@dataclass
class Rollout:
    """T steps of N environments. Episodes continue from one rollout to the next.

    With several agents, observations, actions and values have an axis of agents, `[T, N, A, ...]`. Agents share their
    episodes and, unless they are opponents, their reward.

    Attributes:
        observation: `[T, N, size]`, uint8 or float32, before the action.
        action: `[T, N]` or flat `[T, N, K]`, as sampled from the policy.
        log_prob, value: `[T, N]`, for each agent.
        reward: `[T, N]` for the team; for opponents `[T, N, A]`, one for each agent.
        terminated: `[T, N]` whether the episode terminated in this step.
        truncated: `[T, N]` whether the episode was truncated in this step.
        final_value: `[T, N]` value of the last observation of a truncated episode, else 0, for each agent.
        train: `[T, N]` whether the student learns from this step; otherwise the level is only evaluated.
        last_value: `[N]` value of the observation after the last step, for each agent.
        memory: `[N, W]` state of the student's memory before the first step; see `learning.memory`.
    """

    observation: Tensor
    action: Tensor
    log_prob: Tensor
    value: Tensor
    reward: Tensor
    terminated: Tensor
    truncated: Tensor
    final_value: Tensor
    train: Tensor
    last_value: Tensor
    memory: Tensor

    @classmethod
    def empty(
        cls,
        num_steps: int,
        num_envs: int,
        observation_space: Space,
        action_space: Space,
        agents: int = 1,
        apart: bool = False,
        memory_width: int = 0,
    ) -> Rollout:
        """Allocate a rollout for the spaces of one agent; `apart`: agents have individual rewards."""
        assert observation_space.shape is not None and action_space.shape is not None
        shape = (num_steps, num_envs)
        by_agent = shape if agents == 1 else (*shape, agents)
        seen = torch.uint8 if observation_space.dtype == np.uint8 else torch.float32
        kind = torch.int64 if len(choices_of(action_space)) else torch.float32
        size = () if isinstance(action_space, Discrete) else (math.prod(action_space.shape),)
        return cls(
            observation=torch.zeros(*by_agent, *observation_space.shape, dtype=seen),
            action=torch.zeros(*by_agent, *size, dtype=kind),
            log_prob=torch.zeros(by_agent),
            value=torch.zeros(by_agent),
            reward=torch.zeros(by_agent if apart else shape),
            terminated=torch.zeros(shape, dtype=torch.bool),
            truncated=torch.zeros(shape, dtype=torch.bool),
            final_value=torch.zeros(by_agent),
            train=torch.ones(shape, dtype=torch.bool),
            last_value=torch.zeros(by_agent[1:]),
            memory=torch.zeros(num_envs, memory_width),
        )

    @property
    def episode_starts(self) -> Tensor:
        """Steps that start an episode, bool `[T, N]`; False at the first step, whose memory is in `memory`."""
        ended = self.terminated | self.truncated
        return torch.cat([torch.zeros_like(ended[:1]), ended[:-1]])

    def columns(self, envs: Tensor) -> Rollout:
        """Return a copy with only the environments `envs` (bool `[N]`)."""
        arrays = {item.name: getattr(self, item.name) for item in fields(self)}
        once = {name: arrays.pop(name)[envs] for name in ("last_value", "memory")}
        return Rollout(**{name: array[:, envs] for name, array in arrays.items()}, **once)


def gae(rollout: Rollout, gamma: float, gae_lambda: float) -> Tensor:
    """Return generalized advantage estimates `[T, N]` for each agent (Schulman et al. 2016, equation 16).

    The value after a step is the next value within an episode, 0 after a termination, and the value of the final
    observation after a truncation. The sum over later steps stops at either.
    """
    delta, done = _errors(rollout, gamma)
    decay = gamma * gae_lambda * (~done).float()
    advantage = torch.zeros_like(delta)
    running = torch.zeros_like(rollout.last_value)
    for t in reversed(range(len(delta))):
        running = delta[t] + decay[t] * running
        advantage[t] = running
    return advantage


def negative_advantages(rollout: Rollout, gamma: float, gae_lambda: float) -> Tensor:
    """Return maximized negative advantages `[T, N]` for each agent, none above 0 (Mead et al. 2026, MNA).

    GAE is the mean, with weights (1 - lambda) lambda^(n - 1), of advantages over n steps. For MNA, the advantage over n
    steps is c_n = min(0, c_(n - 1) + gamma^(n - 1) delta), c_0 = 0: the loss relative to the highest value so far, not
    to the value at the first step.
    """
    delta, done = _errors(rollout, gamma)
    steps = len(delta)
    total, advantage, open_ = torch.zeros_like(delta), torch.zeros_like(delta), torch.ones_like(done)
    for lag in range(steps):
        later = steps - lag  # number of starts with a step at this lag in the rollout
        total = (total[:later] + gamma**lag * delta[lag:]).clamp(max=0.0)
        open_, ends = open_[:later], done[lag:].clone()
        ends[-1] = True  # end of the rollout
        weight = gae_lambda**lag * torch.where(ends, 1.0, 1 - gae_lambda)
        advantage[:later] += torch.where(open_, weight * total, 0.0)
        open_ = open_ & ~ends
        if not open_.any():
            break
    return advantage


def _errors(rollout: Rollout, gamma: float) -> tuple[Tensor, Tensor]:
    """Return the one-step TD errors of the values `[T, N]` for each agent, and whether the episode ended."""
    by_agent = rollout.value.ndim
    reward, terminated, truncated = (
        column if column.ndim == by_agent else column[..., None]
        for column in (rollout.reward, rollout.terminated, rollout.truncated)
    )
    done = terminated | truncated
    next_value = torch.cat([rollout.value[1:], rollout.last_value[None]])
    next_value = torch.where(done, rollout.final_value.masked_fill(terminated, 0.0), next_value)
    return reward + gamma * next_value - rollout.value, done
