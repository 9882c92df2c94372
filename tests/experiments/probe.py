"""A one-step world with known answers, a method that learns it without a network, and a painter: stand-ins for tests.

A level is a point θ; the student guesses its first coordinate's side (action 0 or 1) and is paid 1 or 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from gymnasium.spaces import Box, Discrete

from ued.upomdp import UPOMDP


class Column(NamedTuple):
    name: str
    low: float
    high: float


DRAWS = (Column("place.x", -50.0, 50.0), Column("place.y", -30.0, 30.0), Column("depth", 0.0, 10.0))


class ProbeUPOMDP(UPOMDP):
    """Episodes of one step; the observation is θ."""

    def __init__(self, num_envs: int = 1) -> None:
        super().__init__(num_envs, Box(-1.0, 1.0, (3,), np.float32), Discrete(2), DRAWS)

    def _start(self, levels, where):
        return self.levels["theta"].astype(np.float32)

    def _step(self, actions):
        reward = (actions == (self.levels["theta"][:, 0] > 0)).astype(float)
        observation = self.levels["theta"].astype(np.float32)
        ended = np.ones(self.num_envs, bool)
        info = {"final_obs": observation.copy(), "_final_obs": ended}
        return observation, reward, ended, np.zeros(self.num_envs, bool), info

    def get_state(self):
        return {"levels": self.levels.copy(), "random": self.np_random.bit_generator.state}

    def set_state(self, state):
        self.levels[:] = state["levels"]
        self.np_random.bit_generator.state = state["random"]
        return self.levels["theta"].astype(np.float32)


@dataclass(frozen=True)
class Batch:
    theta: np.ndarray
    returns: dict[str, np.ndarray]
    episodes: dict[str, np.ndarray]
    score: np.ndarray


def batch(update: int, rng: np.random.Generator, levels: int = 32) -> Batch:
    """Give levels whose first column drifts from low to high within 100 updates, with a regret that falls."""
    middle = np.array([-0.7 + 1.4 * update / 100, 0.0, 0.5])
    theta = np.clip(rng.normal(middle, [0.15, 0.4, 0.2], (levels, 3)), -1, 1)
    skill = update / 100
    protagonist = np.clip(rng.normal(skill * 0.8, 0.1, levels), 0, 1)
    antagonist = np.clip(rng.normal(min(1.2 * skill, 0.9), 0.1, levels), 0, 1)
    returns = {"protagonist": protagonist, "antagonist": antagonist}
    episodes = {name: np.full(levels, 4) for name in returns}
    return Batch(theta, returns, episodes, antagonist - protagonist)


class ProbePainter:
    """A meadow with a hedge; a level is a walker and a tree."""

    bounds = (-60.0, 60.0, -40.0, 40.0)
    background = (24, 58, 36)
    line_colour = (214, 226, 214)
    markers = (("walker", (66, 165, 245), 1.2), ("tree", (239, 83, 80), 1.5))
    classes = np.array([0, 1])
    focus = 0

    def lines(self):
        return [np.array([[-55.0, -36.0], [55.0, -36.0], [55.0, 36.0], [-55.0, 36.0], [-55.0, -36.0]])]

    def positions(self, theta):
        walker = theta[:, :2] * (50.0, 30.0)
        return np.stack([walker, walker + (5.0, 0.0)], 1)
