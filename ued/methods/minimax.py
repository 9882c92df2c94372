"""The minimax adversary (Dennis et al. 2020, section 3): an adversary that lowers the student's return.

    repeat
        the adversary proposes levels; the student plays them and learns
        the adversary learns to lower the student's mean return

It converges to unsolvable levels and serves as a baseline. Read next: `methods.self_regret`.
"""

from __future__ import annotations

import numpy as np

from ued.config import MinimaxConfig
from ued.core.curriculum import LevelSpace
from ued.levels.budget import Budget
from ued.levels.queue import LevelQueue
from ued.levels.record import mean_returns
from ued.levels.teacher import Teacher
from ued.methods.method import Method


class Minimax(Method):
    """Trains one student against an adversary; see `Method` for the arguments.

    Raises:
        ValueError: if the environment has no free parameters.
    """

    def setup(self, config: MinimaxConfig | None, seed: int) -> None:
        self.curriculum = MinimaxCurriculum(self.upomdp, config or MinimaxConfig(), seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play the adversary's levels; let the adversary and the student learn."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # the adversary learns from the student's loss
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class MinimaxCurriculum(Teacher):
    """A `Curriculum` that proposes levels on which the student fails; see `Teacher` for the arguments."""

    def __init__(self, space: LevelSpace, config: MinimaxConfig, seed: int = 0, budget: Budget | None = None) -> None:
        super().__init__(space, config, 1, config.episodes_per_level, seed, budget)

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Reward the adversary with the student's loss."""
        loss = -mean_returns(records)[:, 0]  # [L], the mean over episodes, as in the paper
        return self.learn(records, loss)
