"""Policies that need no training, for scale: a student that does not beat them has learnt nothing.

Read next: `commands.evaluate`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.constants import DIRECTION_RIGHT, SHOT
from regista.experiments.run.mixed import MixedProgram
from regista.experiments.run.tasks import TaskScene

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete, Space

    from ued.core.upomdp import UPOMDP


class Untrained:
    """A policy that remembers nothing of an episode."""

    def empty_memory(self, num_envs: int) -> Any:
        """Return what it remembers of N environments: `[N, 0]`."""
        import torch

        return torch.zeros(num_envs, 0)


class SampledPolicy(Untrained):
    """Draw actions of any kind from their space, uniformly where it has bounds."""

    def __init__(self, action_space: Space) -> None:
        self.space = action_space

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, ...]`."""
        import torch

        self.space.seed(int(torch.randint(2**31, (), generator=generator)))
        return np.stack([self.space.sample() for _ in range(len(observation))])


class RandomPolicy(Untrained):
    """Take every action with the same probability."""

    def __init__(self, action_space: Discrete, agents: tuple[int, ...]) -> None:
        self.count, self.agents = int(action_space.n), agents

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`; of a team one for each agent, `[N, A]`."""
        import torch

        return torch.randint(self.count, (len(observation), *self.agents), generator=generator).numpy()


class ShootPolicy(Untrained):
    """Shoot at once: towards the goal and the shot in turns, for a kick leaves the foot when its button is released."""

    def __init__(self, agents: tuple[int, ...]) -> None:
        self.shot, self.agents = False, agents

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`; of a team one for each agent, `[N, A]`."""
        self.shot = not self.shot
        return np.full((len(observation), *self.agents), SHOT if self.shot else DIRECTION_RIGHT)


def make_baselines(upomdp: UPOMDP, program: Any) -> dict[str, Any]:
    """Return the baselines for the agents of the environments of a program, by name; shooting is for one of football,
    not for a mixture or a task.
    """
    if isinstance(program, TaskScene | MixedProgram):
        return {"random": SampledPolicy(upomdp.single_action_space)}
    agents = () if upomdp.num_agents == 1 else (upomdp.num_agents,)
    space: Any = upomdp.agent_action_space
    return {"shoot": ShootPolicy(agents), "random": RandomPolicy(space, agents)}
