"""The buffer of levels that PLR, ACCEL and REPAIRED replay: one structured array, a row per level.

A level is replayed by its score and its staleness, the time since it was last played (Jiang et al. 2021b, 3.2):

    P = (1 - staleness_coef) P_score + staleness_coef P_stale
    P_score ~ rank^(-1 / temperature), or max(score, 0)^(1 / temperature);  P_stale ~ now - last played

Read next: `methods.plr`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ued.config import BufferConfig, PLRConfig, RepairedConfig
from ued.core.level_space import LevelSpace, level_dtype
from ued.core.resumable import Resumable
from ued.levels.budget import Budget
from ued.levels.ranking import Ranking
from ued.levels.record import NONE, Origin, make_records, number, solved_once

EPSILON = 1e-8  # avoids a division by 0 for scores of 0


def slot_dtype(level: np.dtype) -> np.dtype:
    """Return the dtype of a level's record in the buffer.

    id: number of the level, unique in a run; level; score; best: the highest return ever on it; solved: whether an
    episode on it ever succeeded; last_played: time of its last replay, or of insertion; created: time of insertion;
    num_replays: number of replays; parent: id of the level it was edited from, or NONE; generation: edits between it
    and a random level.
    """
    return np.dtype(
        [
            ("id", np.int64),
            ("level", level),
            ("score", np.float64),
            ("best", np.float64),
            ("solved", np.bool_),
            ("last_played", np.int64),
            ("created", np.int64),
            ("num_replays", np.int32),
            ("parent", np.int64),
            ("generation", np.int32),
        ]
    )


class LevelBuffer(Resumable):
    """At most `capacity` levels, those with the highest replay weights so far.

    Args:
        space: the space of levels.
        config: capacity, priorities, staleness.
        budget: budget of the run; see `is_ready`.
    """

    state_fields: tuple[str, ...] = ("slots", "now", "next_id", "replays")
    slot_dtype = staticmethod(slot_dtype)

    def __init__(self, space: LevelSpace, config: BufferConfig, budget: Budget | None = None) -> None:
        self.space, self.config, self.budget = space, config, budget or Budget()
        self._slots = np.zeros(config.capacity, self.slot_dtype(level_dtype(space.theta_dim)))
        self._count = 0
        self._rows: dict[bytes, int] = {}  # row of a level, by its key
        self._rows_by_id: dict[int, int] = {}
        self._score_weights: np.ndarray | None = None  # cached until a score changes
        self._by_rank = np.arange(1.0, config.capacity + 1) ** (-1 / config.temperature)
        self._ranking, self._rescored = Ranking(), set[int]()  # rows whose scores changed since the last ranking
        self.now = 0  # levels played so far: the clock of staleness
        self.next_id = 0
        self.replays = False  # whether replay has started by the budget

    def __len__(self) -> int:
        return self._count

    @property
    def slots(self) -> np.ndarray:
        """A view of the levels `[n]`, records of `slot_dtype`."""
        return self._slots[: self._count]

    @slots.setter
    def slots(self, slots: np.ndarray) -> None:
        self._count = len(slots)
        self._slots[: self._count] = slots
        self._rows = {self.space.key_of(level): row for row, level in enumerate(slots["level"])}
        self._rows_by_id = {number: row for row, number in enumerate(slots["id"].tolist())}
        self._score_weights, self._ranking = None, Ranking()

    @property
    def fill_ratio(self) -> float:
        """Share of the capacity in use."""
        return self._count / self.config.capacity

    def is_ready(self, min_fill: float | None) -> bool:
        """Return whether replay may start: after this share of the capacity was offered; None: by the budget.

        Levels count when they are offered, not when they are stored, since a few programs without parameters never fill
        a buffer. Once replay has started by the budget, it continues even if the budget is extended.
        """
        if not self._count:
            return False
        if min_fill is not None:
            return self.now >= min_fill * self.config.capacity
        self.replays = self.replays or self.budget.allows_replay(self.now, self.config.capacity)
        return self.replays

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`; older states lack `replays`, and `solved` of their levels."""
        super().load_state_dict({"replays": False} | state | {"slots": self._with_solved(state["slots"])})

    def _with_solved(self, slots: Any) -> Any:
        """Return the levels of a state; in older states a level is solved if its best return is above 0."""
        fields = [item for item in self._slots.dtype.descr if item[0] != "solved"]
        if getattr(slots, "dtype", None) != np.dtype(fields):
            return slots
        made: np.ndarray = np.zeros(len(slots), self._slots.dtype)
        for name in slots.dtype.names:
            made[name] = slots[name]
        made["solved"] = slots["best"] > 0
        return made

    # ------------------------------------------------------------ replay

    def weights(self) -> np.ndarray:
        """Return the probability `[n]` with which each level is replayed next."""
        share = self.config.staleness_coef
        if self._score_weights is None:
            self._score_weights = self._by_score()
        age = (self.now - self.slots["last_played"]).astype(float)
        total = age.sum()
        stale = age / total if total > 0 else 1 / max(len(age), 1)
        return (1 - share) * self._score_weights + share * stale

    def _by_score(self) -> np.ndarray:
        score = self.slots["score"]
        if self.config.priority == "rank":
            weight = np.empty(len(score))
            weight[self._ranking.update(score, self._rescored)] = self._by_rank[: len(score)]
            self._rescored.clear()
        else:
            weight = self._powers(score)
        return weight / weight.sum() if len(weight) else weight

    def _powers(self, score: np.ndarray) -> np.ndarray:
        positive = np.maximum(score, 0.0) + EPSILON  # relative to the largest: a small temperature does not overflow
        return (positive / positive.max(initial=EPSILON)) ** (1 / self.config.temperature)

    def sample(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Sample `count` levels to replay; return their rows `[count]`. They count as played now."""
        cumulated = np.cumsum(self.weights())
        rows = np.searchsorted(cumulated, rng.random(count) * cumulated[-1], side="right")
        rows = np.minimum(rows, self._count - 1)
        self.touch(rows)
        return rows

    def touch(self, rows: np.ndarray) -> None:
        """Count the levels of these rows `[k]` as played now, in their order."""
        self.slots["last_played"][rows] = self.now + 1 + np.arange(len(rows))
        np.add.at(self.slots["num_replays"], rows, 1)
        self.now += len(rows)

    def replay(self, dtype: np.dtype, count: int, rng: np.random.Generator) -> np.ndarray:
        """Sample `count` levels to replay; return them as level records of this dtype."""
        return self.as_records(dtype, self.sample(count, rng) if count else np.zeros(0, np.int64))

    def as_records(self, dtype: np.dtype, rows: np.ndarray) -> np.ndarray:
        """Return the levels of these rows `[k]` as level records of this dtype, to be replayed."""
        slots = self.slots[rows]
        records = make_records(dtype, slots["level"], Origin.REPLAYED)
        records["id"] = slots["id"]
        return records

    def replay_or_new(
        self,
        dtype: np.dtype,
        count: int,
        config: PLRConfig | RepairedConfig,
        rng: np.random.Generator,
        new: Callable[[int], np.ndarray],
    ) -> np.ndarray:
        """Return `count` level records in random order.

        Once the buffer `is_ready`, each is replayed with probability `replay_prob`; the others are made by `new`.
        """
        replays = rng.binomial(count, config.replay_prob) if self.is_ready(config.min_fill) else 0
        return np.concatenate([self.replay(dtype, replays, rng), new(count - replays)])[rng.permutation(count)]

    # ------------------------------------------------------------ insertion

    def find(self, ids: np.ndarray) -> np.ndarray:
        """Return the row `[k]` of each id; NONE if the level is not in the buffer."""
        return np.array([self._rows_by_id.get(number, NONE) for number in ids.tolist()], np.int64)

    def best_returns(self, records: np.ndarray) -> np.ndarray:
        """Return the highest return `[L]` ever on the level of each record, by any student."""
        best = np.nanmax(records["returns"], (1, 2), initial=-np.inf)
        known, rows = self._known(records)
        best[known] = np.fmax(best[known], self.slots["best"][rows])
        return best

    def ever_solved(self, records: np.ndarray) -> np.ndarray:
        """Return whether an episode ever succeeded on the level of each record, by any student: bool `[L]`."""
        ever = solved_once(records)
        known, rows = self._known(records)
        ever[known] |= self.slots["solved"][rows]
        return ever

    def remember(self, records: np.ndarray) -> None:
        """Fill in the history of each level that scores need: `best`, and `ever_solved` in records with this field."""
        records["best"] = self.best_returns(records)
        if "ever_solved" in (records.dtype.names or ()):
            records["ever_solved"] = self.ever_solved(records)

    def _known(self, records: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return which records `[k]` replay levels that are still in the buffer, and their rows `[k]`."""
        replayed = np.flatnonzero(records["origin"] == Origin.REPLAYED)
        rows = self.find(records["id"][replayed])
        return replayed[rows != NONE], rows[rows != NONE]

    def store(self, records: np.ndarray) -> dict[str, float]:
        """Store scored level records `[L]`: replayed levels get their new scores, the others are inserted.

        Returns metrics: fill ratio, number of inserted levels, mean score, age and generation; see `insert`.
        """
        best = self.best_returns(records)
        known, rows = self._known(records)
        np.logical_or.at(self.slots["solved"], rows, solved_once(records[known]))
        self.update_scores(rows, records["score"][known], best[known])
        new = records["origin"] != Origin.REPLAYED
        inserted = self.insert(records[new], best[new])
        metrics = {"buffer/fill_ratio": self.fill_ratio, "buffer/inserted": float(inserted)}
        if self._count:
            metrics["buffer/score"] = float(self.slots["score"].mean())
            metrics["buffer/age"] = float((self.now - self.slots["last_played"]).mean())
            metrics["buffer/generation"] = float(self.slots["generation"].mean())
        return metrics

    def update_scores(self, rows: np.ndarray, score: np.ndarray, best: np.ndarray) -> None:
        """Set the new scores `[k]` and best returns `[k]` of replayed levels."""
        self.slots["score"][rows] = score
        np.fmax.at(self.slots["best"], rows, best)
        self._score_weights = None
        self._rescored.update(rows.tolist())

    def insert(self, records: np.ndarray, best: np.ndarray) -> int:
        """Insert scored records `[k]` of new levels, with the best returns `[k]` on them; return how many are kept.

        In a full buffer they replace the levels with the smallest replay weights, if their scores are at least as high.
        A level that is already in the buffer keeps the higher score. An edited level has generation 1 if its parent is
        no longer in the buffer. Levels without an id get one, since some trainers do not number levels.
        """
        self.next_id = number(records, self.next_id)
        rows = self._as_slots(records, best)
        self.now += len(rows)
        rows = rows[[not self._is_kept(row) for row in rows]]
        free = min(len(rows), self.config.capacity - self._count)
        return sum(self._put(self._count, row) for row in rows[:free]) + self._displace(rows[free:])

    def _as_slots(self, records: np.ndarray, best: np.ndarray) -> np.ndarray:
        rows: np.ndarray = np.zeros(len(records), self._slots.dtype)
        for name in ("id", "level", "score", "parent"):
            rows[name] = records[name]
        rows["best"], rows["solved"], parents = best, solved_once(records), rows["parent"]
        rows["last_played"] = rows["created"] = self.now + np.arange(len(rows))
        where = self.find(parents)
        known = (parents != NONE) & (where != NONE)
        rows["generation"][parents != NONE] = 1
        rows["generation"][known] += self._slots["generation"][where[known]]
        return rows

    def _is_kept(self, row: np.void) -> bool:
        twin = self._rows.get(self.space.key_of(row["level"]), NONE) if self.config.no_duplicates else NONE
        if twin == NONE:
            return False
        better = max(row["score"], self._slots["score"][twin])
        self._slots["solved"][twin] |= row["solved"]
        self.update_scores(np.array([twin]), np.array([better]), np.array([row["best"]]))
        return True

    def _displace(self, rows: np.ndarray) -> int:
        """Replace the levels with the smallest replay weights by levels `[k]`, the best first; return their number."""
        if not len(rows):
            return 0
        worth, stored_worth = self._worth(rows)
        best = np.argsort(-worth, kind="stable")
        least = self._weakest(len(rows))
        best = best[: len(least)]
        rows, stronger = rows[best], worth[best] >= stored_worth[least]
        return sum(self._put(int(place), row) for place, row in zip(least[stronger], rows[stronger], strict=True))

    def _worth(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the priorities of levels `[k]` and of those in the buffer `[n]`, on the same scale."""
        return rows["score"], self.slots["score"]

    def _weakest(self, count: int) -> np.ndarray:
        """Return the rows of at most `count` levels that better levels may replace, the weakest first."""
        return smallest(self.weights(), count)

    def _put(self, place: int, row: np.void) -> bool:
        key = self.space.key_of(row["level"])
        if self.config.no_duplicates and key in self._rows:
            return False  # the level occurs twice in one call
        if place < self._count:
            self._rows.pop(self.space.key_of(self._slots["level"][place]), None)
            self._rows_by_id.pop(int(self._slots["id"][place]), None)
        self._slots[place] = row
        self._rows_by_id[int(row["id"])] = place
        self._rows[key] = place
        self._count = max(self._count, place + 1)
        self._score_weights = None
        self._rescored.add(place)
        return True


def smallest(values: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of the `count` smallest values, in increasing order; ties keep their order."""
    count = min(count, len(values))
    if not count:
        return np.zeros(0, np.int64)
    places = np.flatnonzero(values <= np.partition(values, count - 1)[count - 1])
    return places[np.argsort(values[places], kind="stable")][:count]
