"""The level record: a level for students to play, and their results on it.

Curricula and trainers exchange these records: `Curriculum.propose(n)` returns records without results, a trainer fills
in the results, and `Curriculum.update(records)` learns from them. Read next: `core.curriculum`, the protocol;
`levels.queue`, which passes records to students.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

NONE = -1  # no level, no record


class Origin(IntEnum):
    """The origin of the level of a record."""

    RANDOM = 0  # sampled uniformly: domain randomization
    PROPOSED = 1  # by a teacher, learned or not
    REPLACED = 2  # random, in place of an invalid proposal
    REPLAYED = 3  # from a buffer of levels
    EDITED = 4  # an edited copy of a replayed level


RESULTS = ("returns", "success", "mean_value", "positive_advantage", "absolute_advantage")
NEGATIVE = "negative_advantage"  # a result in records that have this field, see `scores.fields`


def level_record_dtype(
    level: np.dtype, students: int = 1, episodes: int = 1, extra: Sequence[tuple[Any, ...]] = ()
) -> np.dtype:
    """Return the dtype of a level record for S students that play up to n whole episodes each.

    Set by the curriculum in `propose`:
        level: a record of `level_space.level_dtype`; origin: an `Origin`; id: the level's number, kept by a replayed
        level, NONE for a new one, which the trainer numbers (see `number`); visit: number of this visit, set by the
        trainer; parent: id of the level that was edited, or NONE; train: whether students learn from it; num_episodes:
        number of episodes for each student.
    Filled in by the trainer:
        num_played `[S]`: whole episodes so far; returns `[S, n]`: undiscounted, nan if not played; success `[S, n]`:
        1 or 0, nan if unknown (see `solved`); mean_value, positive_advantage, absolute_advantage `[S, n]`: means over
        the steps of an episode of V, max(A, 0) and |A|, nan for a trainer without values.
    Set by the curriculum in `update`:
        score: score of the level, nan if there is none.
    `extra` holds additional fields of the curriculum.
    """
    return np.dtype(
        [
            ("level", level),
            ("origin", np.int8),
            ("id", np.int64),
            ("visit", np.int64),
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
    """Return records `[k]` of these levels, without results, with `train` set."""
    records = np.zeros(len(levels), dtype)
    records["level"], records["origin"], records["train"] = levels, origin, True
    records["id"] = records["visit"] = records["parent"] = NONE
    records["num_episodes"] = dtype["returns"].shape[1]
    for name in (*RESULTS, "score", *({NEGATIVE} & set(dtype.names or ()))):
        records[name] = np.nan
    return records


def number(records: np.ndarray, next_id: int) -> int:
    """Assign ids to the records without an id, starting at `next_id`; return the next free id."""
    new = np.flatnonzero(records["id"] == NONE)
    records["id"][new] = next_id + np.arange(len(new))
    return next_id + len(new)


def mean_returns(records: np.ndarray) -> np.ndarray:
    """Return the mean return of each student on each record `[L, S]`; nan without an episode."""
    return mean_played(records["returns"])


def solved(records: np.ndarray) -> np.ndarray:
    """Return whether each student's episodes on each record succeeded `[L, S, n]`: 1 or 0, nan if not played.

    If `success` is not filled in, a return above 0 is a success.
    """
    by_return = np.where(np.isnan(records["returns"]), np.nan, records["returns"] > 0)
    return np.where(np.isnan(records["success"]), by_return, records["success"])


def solved_once(records: np.ndarray) -> np.ndarray:
    """Return whether any student's episode on each record succeeded, bool `[L]`."""
    return (solved(records) == 1).any((1, 2))


def mean_played(values: np.ndarray) -> np.ndarray:
    """Return the mean over played episodes: `[..., n]` with nan for the others -> `[...]`."""
    counts = (~np.isnan(values)).sum(-1)
    total = np.nansum(values, -1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)
