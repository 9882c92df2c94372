"""Domain randomization (Tobin et al. 2017): the student trains on levels drawn uniformly at random.

    repeat
        draw levels uniformly
        the student plays them and learns

This is the baseline of every comparison. The strong form draws a new level for every episode. The weak form, which
parts of the literature use, keeps a level for a rollout. Read next: `methods.plr`.
"""

from __future__ import annotations

import numpy as np

from ued.config import DRConfig
from ued.core.curriculum import LevelSpace
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records
from ued.methods.method import Method


class DR(Method):
    """Trains one student on random levels; see `Method` for the arguments."""

    def setup(self, config: DRConfig | None, seed: int) -> None:
        every = (config or DRConfig()).resample_level_every
        self.curriculum = RandomCurriculum(self.upomdp)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, resample_level_every=every)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play levels drawn uniformly, and learn from all of them."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # does nothing: random levels have no score
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class RandomCurriculum(Resumable):
    """A `Curriculum` that proposes uniform levels and learns nothing."""

    def __init__(self, space: LevelSpace) -> None:
        self.space = space
        self.dtype = level_record_dtype(level_dtype(space.theta_dim))

    def propose(self, count: int) -> np.ndarray:
        """Draw `count` levels uniformly."""
        return make_records(self.dtype, self.space.sample_levels(count), Origin.RANDOM)

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Learn nothing."""
        return {}
