"""A trial: a level that students are to play, and, once they have, what they made of it.

It is the one record between whoever chooses levels and whoever trains on them: `Curriculum.propose(n)` gives trials
with their results open, a trainer fills these in, `Curriculum.update(trials)` learns from them. Read next:
`curriculum`, the protocol; `levels.queue`, which hands trials to students.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

NONE = -1  # no slot of a buffer, no trial


class Origin(IntEnum):
    """Where the level of a trial comes from."""

    RANDOM = 0  # drawn uniformly: domain randomisation
    PROPOSED = 1  # by a learned teacher
    REPLACED = 2  # random, in the place of a proposal that describes no valid level
    REPLAYED = 3  # from a buffer of levels
    EDITED = 4  # a changed copy of a replayed level


def trial_dtype(
    level: np.dtype, students: int = 1, episodes: int = 1, extra: Sequence[tuple[Any, ...]] = ()
) -> np.dtype:
    """Give the record of a trial with S students who play up to n whole episodes each.

    Chosen by the curriculum:
        level: a record of `upomdp.level_dtype`; origin: an `Origin`; slot: id of the buffer's level that it is, or was
        made from, or NONE; train: whether students learn from it; wanted: episodes that each student is to play.
    Filled in by the trainer:
        played `[S]`: whole episodes so far; returns `[S, n]`: undiscounted, nan where not played; mean_value,
        positive_advantage, absolute_advantage `[S, n]`: means over the steps of an episode of V, max(A, 0) and |A|,
        nan where the trainer knows no values.
    Written by the curriculum in `update`:
        score: what the level is worth to it, nan if it rates none.
    `extra` are fields of its own.
    """
    results = (students, episodes)
    return np.dtype(
        [
            ("level", level),
            ("origin", np.int8),
            ("slot", np.int64),
            ("train", np.bool_),
            ("wanted", np.int32),
            ("played", np.int32, (students,)),
            ("returns", np.float64, results),
            ("mean_value", np.float64, results),
            ("positive_advantage", np.float64, results),
            ("absolute_advantage", np.float64, results),
            ("score", np.float64),
            *extra,
        ]
    )


RESULTS = ("returns", "mean_value", "positive_advantage", "absolute_advantage")


def make_trials(dtype: np.dtype, levels: np.ndarray, origin: int = Origin.RANDOM) -> np.ndarray:
    """Give trials `[k]` of these levels that students learn from, with all results open."""
    trials = np.zeros(len(levels), dtype)
    trials["level"], trials["origin"], trials["train"] = levels, origin, True
    trials["slot"] = NONE
    trials["wanted"] = dtype["returns"].shape[1]
    for name in (*RESULTS, "score"):
        trials[name] = np.nan
    return trials


def mean_returns(trials: np.ndarray) -> np.ndarray:
    """Give the mean return of each student on each trial `[L, S]`; nan where none was played."""
    return mean_played(trials["returns"])


def mean_played(values: np.ndarray) -> np.ndarray:
    """Give the mean over the episodes that were played: `[..., n]` with nan for the others -> `[...]`."""
    counts = (~np.isnan(values)).sum(-1)
    total = np.nansum(values, -1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)
