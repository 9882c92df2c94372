"""Untrained policies as baselines: a student that does not beat them has learned nothing.

Read next: `core.task`, which lists them as `baselines`; `evaluation`, which plays them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete, Space


class Policy(Protocol):
    """The interface of policies that `evaluate` plays: a student, or one of these."""

    def empty_memory(self, num_envs: int) -> Any: ...
    def play(self, observation: Any, generator: Any, greedy: bool = False, memory: Any = None) -> Any:
        """Return the actions for N observations `[N, ...]`; `generator` is torch's."""


def within(policy: Any, upomdp: Any) -> Any:
    """Return a policy bound to the environments that it plays in.

    A policy that reads the state of the environments, not only observations, has a method `within(upomdp)`. Other
    policies are returned unchanged.
    """
    return policy.within(upomdp) if hasattr(policy, "within") else policy


def stage_of(policy: Any, upomdp: Any) -> Any:
    """Return the environments that a policy plays in: for a `ScriptedPolicy`, a copy that plays its script."""
    return upomdp.with_scripted_policy() if isinstance(policy, ScriptedPolicy) else upomdp


class Untrained:
    """A policy without memory."""

    def empty_memory(self, num_envs: int) -> Any:
        """Return the memory of N environments: `[N, 0]`."""
        import torch

        return torch.zeros(num_envs, 0)


class ScriptedPolicy(Untrained):
    """The environment's scripted policy, see `UPOMDP.with_scripted_policy`; `evaluate` plays it.

    Args:
        agents: () for one agent, (A,) for a team.
    """

    def __init__(self, agents: tuple[int, ...] = ()) -> None:
        self.agents = agents

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return zeros `[N]`, or `[N, A]` for a team: the environments of `stage_of` ignore them."""
        return np.zeros((len(observation), *self.agents), np.int64)


class SampledPolicy(Untrained):
    """Sample actions from any action space; uniform where the space is bounded."""

    def __init__(self, action_space: Space) -> None:
        self.space = action_space

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, ...]`."""
        import torch

        self.space.seed(int(torch.randint(2**31, (), generator=generator)))
        return np.stack([self.space.sample() for _ in range(len(observation))])


class UniformPolicy(Untrained):
    """Take each of `count` discrete actions with the same probability, for each of the agents `agents`: () or (A,)."""

    def __init__(self, action_space: Discrete, agents: tuple[int, ...] = ()) -> None:
        self.count, self.start, self.agents = int(action_space.n), int(action_space.start), agents

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`; for a team `[N, A]`."""
        import torch

        return self.start + torch.randint(self.count, (len(observation), *self.agents), generator=generator).numpy()
