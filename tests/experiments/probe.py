"""A one-step world with known answers, a method that learns it without a network, and a painter: stand-ins for tests.

A level is a point θ; the student guesses its first coordinate's side (action 0 or 1) and is paid 1 or 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from gymnasium.spaces import Box, Discrete

from ued.core.level_space import level_dtype
from ued.core.upomdp import UPOMDP
from ued.levels.batch import LevelBatch
from ued.levels.record import level_record_dtype, make_records


class ThetaColumn(NamedTuple):
    name: str
    low: float
    high: float


DRAWS = (ThetaColumn("place.x", -50.0, 50.0), ThetaColumn("place.y", -30.0, 30.0), ThetaColumn("depth", 0.0, 10.0))


class ProbeUPOMDP(UPOMDP):
    """Episodes of one step; the observation is θ."""

    def __init__(self, num_envs: int = 1) -> None:
        super().__init__(num_envs, Box(-1.0, 1.0, (3,), np.float32), Discrete(2), DRAWS)

    def _start(self, levels, where):
        return self.levels["theta"].astype(np.float32)

    def _advance(self, actions):
        reward = (actions == (self.levels["theta"][:, 0] > 0)).astype(float)
        observation = self.levels["theta"].astype(np.float32)
        ended = np.ones(self.num_envs, bool)
        return observation, reward, ended, np.zeros(self.num_envs, bool), {}

    def resized(self, num_envs):
        return ProbeUPOMDP(num_envs)

    def get_state(self):
        return self.level_state()

    def set_state(self, state):
        self.set_level_state(state)
        return self.levels["theta"].astype(np.float32)


def batch(update: int, rng: np.random.Generator, levels: int = 32) -> LevelBatch:
    """Return levels whose first column drifts from low to high within 100 updates, with a regret that falls."""
    middle = np.array([-0.7 + 1.4 * update / 100, 0.0, 0.5])
    theta = np.clip(rng.normal(middle, [0.15, 0.4, 0.2], (levels, 3)), -1, 1)
    skill = update / 100
    protagonist = np.clip(rng.normal(skill * 0.8, 0.1, levels), 0, 1)
    antagonist = np.clip(rng.normal(min(1.2 * skill, 0.9), 0.1, levels), 0, 1)
    made = np.zeros(levels, level_dtype(3))
    made["theta"] = theta
    records = make_records(level_record_dtype(made.dtype, 2, 1), made)
    records["id"], records["num_played"] = levels * update + np.arange(levels), 1
    records["returns"] = np.stack([protagonist, antagonist], 1)[..., None]
    records["score"] = antagonist - protagonist
    return LevelBatch(records, ["protagonist", "antagonist"])


class ProbePainter:
    """A meadow with a hedge; a level is a walker and a tree."""

    bounds = reach = (-60.0, 60.0, -40.0, 40.0)
    background = (24, 58, 36)
    line_color = (214, 226, 214)
    markers = (("walker", (66, 165, 245), 1.2), ("tree", (239, 83, 80), 1.5))
    classes = np.array([0, 1])
    focus = 0

    def lines(self):
        return [np.array([[-55.0, -36.0], [55.0, -36.0], [55.0, 36.0], [-55.0, 36.0], [-55.0, -36.0]])]

    def positions(self, theta):
        walker = theta[:, :2] * (50.0, 30.0)
        return np.stack([walker, walker + (5.0, 0.0)], 1)

    def frame(self, upomdp):
        return self.positions(upomdp.levels["theta"])[0]


class ProbePolicy:
    """Answers right with a skill between 0 and 1."""

    def __init__(self) -> None:
        self.skill = 0.0

    def empty_memory(self, num_envs):
        import torch

        return torch.zeros(num_envs, 0)

    def play(self, observation, generator, greedy=False, memory=None):
        import torch

        right = torch.rand(len(observation), generator=generator).numpy() < 0.5 + self.skill / 2
        return np.where(right, observation[:, 0] > 0, observation[:, 0] <= 0).astype(int)


class ProbeMethod:
    """Grows more skilful with every update, in a way that depends on all of its state."""

    def __init__(self, config, upomdp) -> None:
        self.upomdp, self.rng = upomdp, np.random.default_rng(config.seed)
        self.student = ProbePolicy()
        self.students = {"protagonist": self.student, "antagonist": ProbePolicy()}
        self.updates = self.env_steps = 0
        self.last, self.buffer, self.learners = None, None, []

    def keep_tapes(self):
        """Keep none: nobody's episodes are seen again."""

    def update(self):
        self.updates += 1
        self.env_steps += 1000
        self.student.skill = min(1.0, self.student.skill + 0.02 * self.rng.random())
        self.last = batch(self.updates, self.rng, 8)
        metrics = {"return/protagonist": self.student.skill, "regret": float(self.last.score.mean()), "time/sim": 0.01}
        return metrics | ({"late": 1.0} if self.updates > 3 else {})

    def state_dict(self):
        return {
            "rng": self.rng.bit_generator.state,
            "skill": self.student.skill,
            "updates": self.updates,
            "env_steps": self.env_steps,
            "upomdp": self.upomdp.get_state(),
        }

    def load_state_dict(self, state):
        self.rng.bit_generator.state = state["rng"]
        self.student.skill, self.updates, self.env_steps = state["skill"], state["updates"], state["env_steps"]
        self.upomdp.set_state(state["upomdp"])

    def load_students(self, state):
        self.student.skill = state["skill"]
