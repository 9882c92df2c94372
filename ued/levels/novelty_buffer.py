"""A buffer that replays levels by the ranks of two scores: a level's score, and its novelty (Teoh et al. 2024).

    P_score = (1 - novelty_coef) P_regret + novelty_coef P_novelty,  each ~ rank^(-1 / temperature)

Read next: `methods.cenie`.
"""

from __future__ import annotations

import numpy as np

from ued.config import BufferConfig
from ued.core.level_space import LevelSpace
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer, slot_dtype
from ued.levels.record import NONE, Origin, mean_played


def novelty_slot_dtype(level: np.dtype) -> np.dtype:
    """Return `slot_dtype` with the novelty of the level when it was last played; inf: before the first mixture."""
    return np.dtype([*slot_dtype(level).descr, ("novelty", np.float64)])


class NoveltyBuffer(LevelBuffer):
    """A `LevelBuffer` whose levels also have a novelty. The field `novelty` `[1, n]` of a level record is per episode.

    Args:
        space, config, budget: see `LevelBuffer`.
        share: share of P_novelty in the replay priority, from 0 to 1.
    """

    slot_dtype = staticmethod(novelty_slot_dtype)

    def __init__(self, space: LevelSpace, config: BufferConfig, share: float, budget: Budget | None = None) -> None:
        super().__init__(space, config, budget)
        self.share = share

    def store(self, records: np.ndarray) -> dict[str, float]:
        """See `LevelBuffer.store`; a replayed level also gets its new novelty."""
        replayed = records[records["origin"] == Origin.REPLAYED]
        rows = self.find(replayed["id"])
        self.slots["novelty"][rows[rows != NONE]] = novelty_of(replayed[rows != NONE])
        return super().store(records)

    def _by_score(self) -> np.ndarray:
        if not len(self):
            return super()._by_score()
        return (1 - self.share) * super()._by_score() + self.share * self._ranks(self.slots["novelty"])

    def _ranks(self, values: np.ndarray) -> np.ndarray:
        """Return weights `[n]`, which sum to 1, by the rank of values `[n]`."""
        weight = np.empty(len(values))
        weight[np.argsort(-values, kind="stable")] = np.arange(1.0, len(values) + 1) ** (-1 / self.config.temperature)
        return weight / weight.sum()

    def _as_slots(self, records: np.ndarray, best: np.ndarray) -> np.ndarray:
        rows = super()._as_slots(records, best)
        rows["novelty"] = novelty_of(records)
        return rows

    def _is_kept(self, row: np.void) -> bool:
        kept = super()._is_kept(row)
        if kept:
            self.slots["novelty"][self._rows[self.space.key_of(row["level"])]] = row["novelty"]
        return kept

    def _worth(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the priority of new levels `[k]` and of those in the buffer `[n]`, ranked together."""
        score = np.concatenate([self.slots["score"], rows["score"]])
        novelty = np.concatenate([self.slots["novelty"], rows["novelty"]])
        by_score = self._ranks(score) if self.config.priority == "rank" else self._powers(score)
        worth = (1 - self.share) * by_score / by_score.sum() + self.share * self._ranks(novelty)
        return worth[len(self) :], worth[: len(self)]


def novelty_of(records: np.ndarray) -> np.ndarray:
    """Return the novelty of level records `[L]`, the mean over their episodes."""
    return mean_played(records["novelty"][:, 0])
