"""REPAIRED (Jiang et al. 2021a, Algorithm 2): PAIRED's adversary as the generator of a robust replay buffer.

    repeat
        with probability 1 - p:
            the adversary proposes levels; both students play them without learning
            the adversary learns from their regret; the levels are offered to the buffer
        else:
            both students play levels of the buffer and learn; the levels get their new regret

It differs from the reference implementation in two points. The adversary learns only from its own proposals, never from
the regret of replayed levels. Both students replay the same level, so that its regret is defined.
Read next: `methods.minimax`.
"""

from __future__ import annotations

import numpy as np

from ued.config import RepairedConfig
from ued.core.curriculum import LevelSpace
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer
from ued.levels.diagnostics import regret_split
from ued.levels.queue import LevelQueue
from ued.methods.method import Method
from ued.methods.paired import PairedCurriculum, add_students, has_antagonist, kl_target


class Repaired(Method):
    """Trains two students on replayed levels of an adversary; see `Paired` for the errors raised."""

    curriculum: RepairedCurriculum

    def setup(self, config: RepairedConfig | None, seed: int) -> None:
        self.config = config or RepairedConfig()
        self.curriculum = RepairedCurriculum(self.upomdp, self.config, seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        add_students(self, self.config)

    def update(self) -> dict[str, float]:
        """Play levels of the adversary and of the buffer; score them by regret; learn only from buffer levels."""
        levels = self.collect_rollouts()  # [L], each from the adversary or replayed, as sampled in `propose`
        metrics = self.curriculum.update(levels)  # the adversary learns from its own levels; the buffer stores all
        metrics |= regret_split(levels, has_antagonist(self.config))
        for learner in self.learners:  # from replayed levels: only these are training levels
            metrics |= learner.learn(self.env_steps, kl_target(self.config, self.learners, learner, self.updates))
        return self.report(levels, metrics)

    @property
    def buffer(self) -> LevelBuffer:
        return self.curriculum.buffer


class RepairedCurriculum(PairedCurriculum):
    """A `Curriculum` that proposes levels of high regret, and replays the levels with the highest regret."""

    config: RepairedConfig
    state_fields = (*PairedCurriculum.state_fields, "buffer", "rng")

    def __init__(self, space: LevelSpace, config: RepairedConfig, seed: int = 0, budget: Budget | None = None) -> None:
        super().__init__(space, config, seed, budget)
        self.buffer = LevelBuffer(space, config.buffer, self.budget)
        self.rng = np.random.default_rng(seed)

    def propose(self, count: int) -> np.ndarray:
        """Return levels of the buffer with probability `replay_prob` each, otherwise levels of the adversary."""
        return self.buffer.replay_or_new(self.dtype, count, self.config, self.rng, self._new)

    def _new(self, count: int) -> np.ndarray:
        """Return levels of the adversary."""
        records = super().propose(count)
        records["train"] = False
        return records

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Reward the adversary with the regret of its own levels; store all levels with their regret."""
        metrics = super().update(records)
        return metrics | self.buffer.store(records)
