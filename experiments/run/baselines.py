"""Policies that need no training, for scale: a student that does not beat them has learnt nothing.

Read next: `commands.evaluate`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from envs.football.constants import DIRECTION_RIGHT, SHOT

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete


class RandomPolicy:
    """Take every action with the same probability."""

    def __init__(self, action_space: Discrete) -> None:
        self.count = int(action_space.n)

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`."""
        import torch

        return torch.randint(self.count, (len(observation),), generator=generator).numpy()


class ShootPolicy:
    """Shoot at once: towards the goal and the shot in turns, for a kick leaves the foot when its button is released."""

    def __init__(self) -> None:
        self.shot = False

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`."""
        self.shot = not self.shot
        return np.full(len(observation), SHOT if self.shot else DIRECTION_RIGHT)


def make_baselines(action_space: Discrete) -> dict[str, Any]:
    """Return the baselines by name."""
    return {"shoot": ShootPolicy(), "random": RandomPolicy(action_space)}
