"""NCC (Monette et al. 2025): gradient ascent learns a distribution y over a buffer of levels, on a step budget.

    fill a buffer with random levels; y is uniform
    repeat
        the student plays levels drawn from y, and learns
        score the levels of the buffer; random levels with higher scores replace levels with the lowest scores
        ascend E_y[score] + alpha H(y) by TiAda's step; project y to the truncated simplex    (`levels.simplex`)

The paper scores all 4,000 levels before every step of y, which costs 84 simulated steps for each step of training. In
this implementation, a level keeps its score until it is played again. Levels drawn from y are scored by the episodes
that the student learns from. A share of further levels is only evaluated: random candidates, and the levels of the
buffer with the oldest scores. All steps count.

There are four other differences. The student learns from the first levels while they fill the buffer. PPO uses Adam
instead of TiAda. A level is drawn from the y of the last update. Step size and smallest probability are relative to the
size of the buffer. A level that enters the buffer has the y of the level that it replaces, as in the authors' code.
Read next: `levels.simplex`, then `methods.alp_gmm`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import BufferConfig, NCCConfig
from ued.core.curriculum import LevelSpace, RandomLevelPool
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.levels import scores
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer, smallest
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records
from ued.levels.simplex import SimplexAscent
from ued.methods.method import Method


class NCC(Method):
    """Trains one student on levels from a learned distribution; see `Method` for the arguments."""

    curriculum: NCCCurriculum

    def setup(self, config: NCCConfig | None, seed: int) -> None:
        self.curriculum = NCCCurriculum(self.upomdp, config or NCCConfig(), seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play levels from y, candidates and stale levels; score all; ascend; learn from the levels from y."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)

    @property
    def buffer(self) -> LevelBuffer:
        return self.curriculum.buffer


class NCCCurriculum(Resumable):
    """A `Curriculum` that proposes levels from a learned distribution over a buffer.

    Args:
        space: the space of levels.
        config: capacity, score, shares of evaluated levels, and the ascent.
        seed: seed of the choice of levels.
        budget: budget of the run, which determines when the buffer is ready; see `NCCConfig.min_fill`.
    """

    state_fields = ("buffer", "pool", "rng")

    def __init__(self, space: LevelSpace, config: NCCConfig, seed: int = 0, budget: Budget | None = None) -> None:
        self.space, self.config = space, config
        level, episodes = level_dtype(space.theta_dim), config.episodes_per_level
        self.dtype = level_record_dtype(level, episodes=episodes, extra=scores.fields(config.score, episodes))
        scores.rehearse(config.score, space, self.dtype)
        self.buffer = LearnedBuffer(space, config, budget or Budget.of(space))
        self.pool = RandomLevelPool(space)
        self.rng = np.random.default_rng(seed)

    def propose(self, count: int) -> np.ndarray:
        """Return levels drawn from y, candidates, and levels with old scores, shuffled; initially random levels."""
        if not self.buffer.is_ready(self.config.min_fill):
            return self._random(count)
        shares = self.config.candidate_share, self.config.rescore_share
        candidates, stale, drawn = self.rng.multinomial(count, [*shares, 1 - sum(shares)]).tolist()
        evaluated = np.concatenate([self._random(candidates), self.buffer.stalest(self.dtype, stale)])
        evaluated["train"] = False
        records = np.concatenate([evaluated, self.buffer.replay(self.dtype, drawn, self.rng)])
        return records[self.rng.permutation(len(records))]

    def _random(self, count: int) -> np.ndarray:
        return make_records(self.dtype, self.pool.take(count), Origin.RANDOM)

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score the levels, see `levels.scores`; replace the levels with the lowest scores; take one ascent step."""
        self.buffer.remember(records)
        records["score"] = scores.score(self.config.score, records, records["best"])
        metrics = self.buffer.store(records)
        metrics["ncc/evaluated"] = float((~records["train"]).sum())
        return metrics | (self.buffer.ascend() if self.buffer.is_ready(self.config.min_fill) else {})


class LearnedBuffer(LevelBuffer):
    """A buffer with a learned distribution over its levels; levels with the lowest scores are replaced."""

    state_fields = (*LevelBuffer.state_fields, "ascent")

    def __init__(self, space: LevelSpace, config: NCCConfig, budget: Budget) -> None:
        super().__init__(space, BufferConfig(capacity=config.capacity), budget)
        self.ascent = SimplexAscent(config)

    def weights(self) -> np.ndarray:
        """Return y, the probability `[n]` of each level."""
        return self.ascent.y

    def ascend(self) -> dict[str, float]:
        """Take one ascent step; return the expected score and exp(entropy), the effective number of levels."""
        score = self.slots["score"]
        self.ascent.step(score)
        return {"ncc/score": float(self.ascent.y @ score), "ncc/levels": float(np.exp(self.ascent.entropy))}

    def stalest(self, dtype: np.dtype, count: int) -> np.ndarray:
        """Return `count` records of the least recently played levels, which then count as played now.

        A buffer with fewer than `count` levels repeats them.
        """
        rows = np.resize(smallest(self.slots["last_played"], count), count)
        self.touch(rows)
        return self.as_records(dtype, rows)

    def _weakest(self, count: int) -> np.ndarray:
        return smallest(self.slots["score"], count)

    def _put(self, place: int, row: np.void) -> bool:
        before = len(self)
        kept = super()._put(place, row)
        if len(self) > before:
            self.ascent.add()
        return kept

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        Raises:
            ValueError: if y has another number of levels.
        """
        super().load_state_dict(state)
        for name in ("y", "mean", "square"):
            if len(getattr(self.ascent, name)) != len(self):
                raise ValueError(f"{name} has {len(getattr(self.ascent, name))} numbers for {len(self)} levels")
