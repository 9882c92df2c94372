"""Prioritized level replay (Jiang et al. 2021b), and its robust form (Jiang et al. 2021a, Algorithm 1).

    repeat
        with probability 1 - p, or while the buffer is not filled:
            draw a level uniformly; the student plays it  (robust: without learning); offer it to the buffer
        else:
            draw a level from the buffer by score and staleness; the student plays it and learns; update its score

A level without a finished episode has no score yet and does not change the buffer. Read next: `levels.buffer`,
`levels.scores`; then `methods.accel`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import PLRConfig
from ued.core.curriculum import LevelSpace, RandomLevelPool
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.levels import scores
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records
from ued.methods.method import Method


class PLR(Method):
    """Trains one student on new and on replayed levels; see `Method` for the arguments."""

    curriculum: PLRCurriculum
    robust = False

    def setup(self, config: PLRConfig | None, seed: int) -> None:
        self.curriculum = PLRCurriculum(self.upomdp, config or PLRConfig(), seed, self.robust, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play new and replayed levels; score them and store them in the buffer; learn."""
        levels = self.collect_rollouts()  # [L], each new or replayed, as sampled in `propose`
        metrics = self.curriculum.update(levels)  # score each level and store it
        metrics |= self.learner.learn(self.env_steps)  # robust: new levels are not training levels
        return self.report(levels, metrics)

    @property
    def buffer(self) -> LevelBuffer:
        return self.curriculum.buffer


class RobustPLR(PLR):
    """Trains one student on replayed levels only; new levels are only evaluated (PLR⊥)."""

    robust = True


class PLRCurriculum(Resumable):
    """A `Curriculum` that replays levels with high scores.

    Args:
        space: the space of levels.
        config: score, buffer and probability of replay.
        seed: seed of the choice between replayed and new levels, and among levels.
        robust: whether students learn from replayed levels only.
        budget: budget of the run, which determines the start of replay; see `PLRConfig.min_fill`.
    """

    state_fields: tuple[str, ...] = ("buffer", "pool", "rng")

    def __init__(
        self, space: LevelSpace, config: PLRConfig, seed: int = 0, robust: bool = True, budget: Budget | None = None
    ) -> None:
        self.space, self.config, self.robust = space, config, robust
        level, episodes = level_dtype(space.theta_dim), config.episodes_per_level
        self.dtype = level_record_dtype(level, episodes=episodes, extra=self._fields())
        scores.rehearse(config.score, space, self.dtype)
        self.buffer = LevelBuffer(space, config.buffer, budget or Budget.of(space))
        self.pool = RandomLevelPool(space)
        self.rng = np.random.default_rng(seed)

    def _fields(self) -> list[tuple[Any, ...]]:
        """Return the additional fields of its level records."""
        return scores.fields(self.config.score, self.config.episodes_per_level)

    def propose(self, count: int) -> np.ndarray:
        """Return levels of the buffer with probability `replay_prob` each, otherwise new levels."""
        return self.buffer.replay_or_new(self.dtype, count, self.config, self.rng, self._new)

    def _new(self, count: int) -> np.ndarray:
        """Return random levels."""
        records = make_records(self.dtype, self.pool.take(count), Origin.RANDOM)
        records["train"] = not self.robust
        return records

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score the levels by the rule of the settings, see `levels.scores`; store them in the buffer."""
        self.buffer.remember(records)
        records["score"] = scores.score(self.config.score, records, records["best"])
        return self.buffer.store(records)  # new levels are offered, replayed levels get their new scores
