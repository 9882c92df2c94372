"""The level record: a level that students are to play, and, once they have, what they made of it.

It is the one record between whoever chooses levels and whoever trains on them: `Curriculum.propose(n)` returns records
with their results open, a trainer fills these in, `Curriculum.update(records)` learns from them. Read next:
`core.curriculum`, the protocol; `levels.queue`, which hands records to students.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

NONE = -1  # no level, no record


class Origin(IntEnum):
    """Where the level of a record comes from."""

    RANDOM = 0  # drawn uniformly: domain randomisation
    PROPOSED = 1  # by a learned teacher
    REPLACED = 2  # random, in the place of a proposal that describes no valid level
    REPLAYED = 3  # from a buffer of levels
    EDITED = 4  # a changed copy of a replayed level


RESULTS = ("returns", "success", "mean_value", "positive_advantage", "absolute_advantage")


def level_record_dtype(
    level: np.dtype, students: int = 1, episodes: int = 1, extra: Sequence[tuple[Any, ...]] = ()
) -> np.dtype:
    """Return the dtype of a level record with S students who play up to n whole episodes each.

    Chosen by the curriculum:
        level: a record of `upomdp.level_dtype`; origin: an `Origin`; id: the level's number, which it keeps when it is
        replayed, NONE for a new one, which whoever has it played numbers (see `number`); turn: number of this playing
        of it, likewise; parent: id of the level that it is an edited copy of, or NONE; train: whether students learn
        from it; num_episodes: how many each student is to play.
    Filled in by the trainer:
        num_played `[S]`: whole episodes so far; returns `[S, n]`: undiscounted, nan where not played; success `[S, n]`:
        1 or 0, nan where the trainer does not know (see `solved`); mean_value, positive_advantage, absolute_advantage
        `[S, n]`: means over the steps of an episode of V, max(A, 0) and |A|, nan where the trainer knows no values.
    Written by the curriculum in `update`:
        score: what the level is worth to it, nan if it rates none.
    `extra` are fields of its own.
    """
    return np.dtype(
        [
            ("level", level),
            ("origin", np.int8),
            ("id", np.int64),
            ("turn", np.int64),
            ("parent", np.int64),
            ("train", np.bool_),
            ("num_episodes", np.int32),
            ("num_played", np.int32, (students,)),
            *((name, np.float64, (students, episodes)) for name in RESULTS),
            ("score", np.float64),
            *extra,
        ]
    )


def make_records(dtype: np.dtype, levels: np.ndarray, origin: int = Origin.RANDOM) -> np.ndarray:
    """Return records `[k]` of these levels that students learn from, with all results open."""
    records = np.zeros(len(levels), dtype)
    records["level"], records["origin"], records["train"] = levels, origin, True
    records["id"] = records["turn"] = records["parent"] = NONE
    records["num_episodes"] = dtype["returns"].shape[1]
    for name in (*RESULTS, "score"):
        records[name] = np.nan
    return records


def number(records: np.ndarray, next_id: int) -> int:
    """Give those of these records that have no id the next ones; return the one after them."""
    new = np.flatnonzero(records["id"] == NONE)
    records["id"][new] = next_id + np.arange(len(new))
    return next_id + len(new)


def mean_returns(records: np.ndarray) -> np.ndarray:
    """Return the mean return of each student on each record `[L, S]`; nan where none was played."""
    return mean_played(records["returns"])


def solved(records: np.ndarray) -> np.ndarray:
    """Return whether each student's episodes on each record succeeded `[L, S, n]`: 1 or 0, nan where none was played.

    A trainer that fills in returns alone is taken at its returns: above 0 is a success.
    """
    by_return = np.where(np.isnan(records["returns"]), np.nan, records["returns"] > 0)
    return np.where(np.isnan(records["success"]), by_return, records["success"])


def mean_played(values: np.ndarray) -> np.ndarray:
    """Return the mean over the episodes that were played: `[..., n]` with nan for the others -> `[...]`."""
    counts = (~np.isnan(values)).sum(-1)
    total = np.nansum(values, -1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)
