"""Sampling for learnability (Rutherford et al. 2024, Algorithm 1); steps on candidates count as environment steps.

    every `choose_every` updates
        the student plays k episodes on each of many random levels, without learning
        select the levels with the largest p (1 - p)
    repeat
        the student plays levels, a share of them selected and the rest random, and learns

The reference implementation spends several times more steps on candidates than on training, and does not count them.
In this implementation, candidates are played and counted like all other levels. Read next: `methods.ncc`.
"""

from __future__ import annotations

import numpy as np

from ued.config import SFLConfig
from ued.core.curriculum import LevelSpace, RandomLevelPool
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.levels import scores
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records, mean_played, solved
from ued.methods.method import Method

TIE_BREAK = 0.001  # times p: of two levels of learnability 0, prefer the solved one (Kinetix)


class SFL(Method):
    """Trains one student on learnable levels; see `Method` for the arguments."""

    curriculum: SFLCurriculum

    def setup(self, config: SFLConfig | None, seed: int) -> None:
        self.curriculum = SFLCurriculum(self.upomdp, config or SFLConfig(), seed)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play candidates, selected and random levels; select the most learnable; learn from all but candidates."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # p (1 - p) of each candidate; select the largest
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class SFLCurriculum(Resumable):
    """A `Curriculum` that proposes the levels that are solved about half of the time.

    Args:
        space: the space of levels.
        config: number of candidates, interval between selections, and number of selected levels.
        seed: seed of the choice of levels.
    """

    state_fields = ("pool", "rng", "waiting", "looking", "judged", "chosen", "updates")

    def __init__(self, space: LevelSpace, config: SFLConfig, seed: int = 0) -> None:
        self.space, self.config = space, config
        self.dtype = level_record_dtype(level_dtype(space.theta_dim), episodes=config.candidate_episodes)
        scores.rehearse(config.score, space, self.dtype)
        self.pool = RandomLevelPool(space)
        self.rng = np.random.default_rng(seed)
        self.waiting = 0  # candidates yet to be proposed
        self.looking = False  # whether there are candidates to propose or to evaluate
        self.judged = np.zeros(0, self.dtype)  # evaluated candidates
        self.chosen = np.zeros(0, self.dtype)  # selected levels with their scores
        self.updates = 0

    def propose(self, count: int) -> np.ndarray:
        """Return candidates as long as there are any, then selected and random levels."""
        candidates = min(count, self.waiting)
        self.waiting -= candidates
        chosen = self.rng.binomial(count - candidates, self.config.chosen_share) if len(self.chosen) else 0
        new = make_records(self.dtype, self.pool.take(count - chosen))
        again = self.chosen[self.rng.integers(0, len(self.chosen), chosen)] if chosen else self.chosen[:0]
        replayed = make_records(self.dtype, again["level"], Origin.REPLAYED)
        replayed["id"] = again["id"]
        records = np.concatenate([new, replayed])
        records["num_episodes"][candidates:] = 1
        records["train"][:candidates] = False  # candidates are only evaluated
        return records[self.rng.permutation(count)]

    def _learnability(self, candidates: np.ndarray) -> np.ndarray:
        """Return the score `[L]` of these candidates by the rule of the settings."""
        if self.config.score != "learnability":
            return scores.score(self.config.score, candidates)
        return scores.score("learnability", candidates) + TIE_BREAK * mean_played(solved(candidates)[:, 0])

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score candidates; select the most learnable when all are scored; start new candidates when due."""
        candidates = records[~records["train"]]
        candidates["score"] = self._learnability(candidates)
        records["score"] = np.nan
        records["score"][~records["train"]] = candidates["score"]
        self.judged = np.concatenate([self.judged, candidates])
        metrics = {"sfl/candidates": float(len(candidates))}
        if len(self.judged) >= self.config.candidates:
            self.judged["score"] = self._learnability(self.judged)  # a score may depend on all candidates
            self.chosen = self.judged[np.argsort(-self.judged["score"], kind="stable")[: self.config.chosen]]
            metrics["sfl/chosen_score"] = float(self.chosen["score"].mean())
            self.judged, self.looking = self.judged[:0], False
        if self.updates % self.config.choose_every == 0 and not self.looking:  # long episodes may delay this
            self.waiting, self.looking = self.config.candidates, True
        self.updates += 1
        return metrics
