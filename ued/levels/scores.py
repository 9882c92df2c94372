"""Scores of levels for a teacher or a buffer, from the results of students.

Returns are undiscounted sums over whole episodes; nan marks an episode that was not played, which means exclude it.
Read next: `levels.buffer`, which replays by scores; `methods.paired`, whose score is regret.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ued.core.level_space import LevelSpace
from ued.core.own_code import FAILURES, OwnCodeError, is_name, line_in, load
from ued.levels.record import NEGATIVE, make_records, mean_played, solved

Score = Callable[[np.ndarray, np.ndarray], np.ndarray]
REHEARSED = 8  # levels with synthetic results, on which a user's score is tested before training


def max_mc(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return MaxMC `[L]`: the mean over steps of R_max - V(s_t) (Jiang et al. 2021a, section 5.2).

    R_max is `best` `[L]`, the highest return ever on the level, so a student that forgets a level raises its score.
    """
    return best - mean_played(records["mean_value"][:, 0])


def positive_value_loss(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return the positive value loss `[L]`: the mean over steps of max(A_t, 0), A_t by GAE (Jiang et al. 2021a)."""
    return mean_played(records["positive_advantage"][:, 0])


def l1_value_loss(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return the L1 value loss `[L]`: the mean over steps of |A_t|, A_t by GAE (Jiang et al. 2021b, table 1)."""
    return mean_played(records["absolute_advantage"][:, 0])


def learnability(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return p (1 - p) `[L]`, p the share of episodes that succeed (Rutherford et al. 2024, section 4).

    It is 0 for a single episode, so several are needed. The estimate of the variance is unbiased, n / (n - 1) times the
    naive estimate, so that levels with more episodes do not appear more learnable.
    """
    success = solved(records)[:, 0]
    count, p = (~np.isnan(success)).sum(1), mean_played(success)
    return p * (1 - p) * count / np.maximum(count - 1, 1)


def generalized_learnability(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return learnability for returns that are not binary `[L]` (Monette et al. 2025, "generalised learnability").

    It is the standard deviation of a level's returns, times the normal density of their mean among the means of all L
    levels. So the score is high if the returns vary and their mean is typical. The density is scaled to at most 1, so
    levels with equal means have a score. As in `learnability`, the variance is unbiased. Adding a constant to all
    returns changes no score; a factor scales all scores. The density uses the standard deviation of the means; the
    authors' code uses their variance, which depends on the unit of returns.
    """
    returns = records["returns"][:, 0]
    count, mean = (~np.isnan(returns)).sum(1), mean_played(returns)
    variance = mean_played((returns - mean[:, None]) ** 2) * count / np.maximum(count - 1, 1)
    deviation = mean.std() if len(mean) else 0.0
    distance = (mean - mean.mean()) / deviation if deviation > 0 else np.zeros(len(mean))
    return np.sqrt(variance) * np.exp(-0.5 * distance**2)


def mna(records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return the maximized negative advantage `[L]` (Mead et al. 2026); 0 for a level that was never solved.

    It is the sum over the steps of an episode of -A_t, A_t by `learning.rollout.negative_advantages`, and the mean of
    this sum over episodes. The authors' code sums over rollouts of 256 steps, in which a short episode is repeated.
    """
    return mean_played(records[NEGATIVE][:, 0]) * records["ever_solved"]


SCORES: dict[str, Score] = {
    "max_mc": max_mc,
    "positive_value_loss": positive_value_loss,
    "l1_value_loss": l1_value_loss,
    "learnability": learnability,
    "generalized_learnability": generalized_learnability,
    "mna": mna,
}
NEEDS = {
    "max_mc": "mean_value",
    "positive_value_loss": "positive_advantage",
    "l1_value_loss": "absolute_advantage",
    "mna": NEGATIVE,
}


def find(rule: str) -> Score:
    """Return the score function of this name: one of `SCORES`, or user code `module:name` or `file.py:name`.

    Raises `OwnCodeError` if the user's function is missing or not callable.
    """
    if not is_name(rule):
        return SCORES[rule]
    own = load(rule)
    if not callable(own):
        raise OwnCodeError(f"the score {rule} must be a function of level records and best returns, got {own!r:.100}")
    return partial(_own, rule, own)


def _own(rule: str, own: Score, records: np.ndarray, best: np.ndarray) -> np.ndarray:
    """Return the user's score `[L]`. Raises `OwnCodeError` if it fails, or is not a finite number for each level."""
    try:
        given = own(records.copy(), best.copy())
        found = np.asarray(given)
    except FAILURES as error:
        raise OwnCodeError(f"the score {rule} failed{line_in(own, error)}: {type(error).__name__}: {error}") from error
    wrong = f"the score {rule} must be a finite number for each of {len(best)} levels, got"
    numeric = found.dtype.kind in "biuf" and not np.ma.is_masked(given)  # the value below a mask is no score
    if found.shape != best.shape or not numeric:
        got = f"shape {list(found.shape)} of {found.dtype}" if found.shape != best.shape else f"{given!r:.100}"
        raise OwnCodeError(f"{wrong} {got}")
    if len(bad := np.flatnonzero(~np.isfinite(found))):
        count = f" and {len(bad) - 1} others" * (len(bad) > 1)
        raise OwnCodeError(f"{wrong} {found[bad[0]]} for {_in_words(records[bad[0]])}{count}")
    return found.astype(np.float64)


def _in_words(record: np.void) -> str:
    """Return a level record as a text for an error: enough to play the level again."""
    theta, returns = record["level"]["theta"], record["returns"][0]
    row = ", ".join(f"{x:.6g}" for x in theta[:32]) + ", …" * (len(theta) > 32)
    played = ", ".join(f"{x:.6g}" for x in returns[:8]) + ", …" * (len(returns) > 8)
    return f"level {record['id']} (theta [{row}], seed {record['level']['seed']}, returns [{played}])"


def rehearse(rule: str, space: LevelSpace, dtype: np.dtype) -> None:
    """Test a user's score on random levels with synthetic results, so that errors are found before training.

    The stream of levels is unchanged. Raises `OwnCodeError` as `find`, and if the score fails, has another shape than
    the levels, or is not finite.
    """
    if not is_name(rule):
        return
    state = space._stream.bit_generator.state
    records = make_records(dtype, space.sample_levels(REHEARSED))
    space._stream.bit_generator.state = state
    rng = np.random.default_rng(0)
    for name in set(dtype.names or ()) - {"score"}:
        if dtype[name].base == np.float64:
            records[name] = rng.uniform(0.1, 0.9, records[name].shape)
    records["success"] = records["returns"] > 0.5
    records["id"], records["visit"] = np.arange(REHEARSED), 0
    records["num_played"] = records["num_episodes"][:, None]
    if "best" in (dtype.names or ()):
        records["best"] = records["returns"].max((1, 2))
    score(rule, records)


def fields(rule: str, episodes: int) -> list[tuple[Any, ...]]:
    """Return the additional fields that level records of one student need for a score.

    best: the highest return ever on the level. The score mna needs two more fields. negative_advantage `[1, n]`: the
    sum of the maximized negative advantages over the steps of an episode, which the trainer fills in. ever_solved:
    whether an episode on the level ever succeeded. Raises `OwnCodeError` as `find`.
    """
    find(rule)  # raises before training if the score is missing
    more = [(NEGATIVE, np.float64, (1, episodes)), ("ever_solved", np.bool_)] if rule == "mna" else []
    return [("best", np.float64), *more]


def score(rule: str, records: np.ndarray, best: np.ndarray | None = None) -> np.ndarray:
    """Return the score `[L]` of level records by a rule of `SCORES` or by user code; see `find`.

    `best` `[L]` are the highest returns on these levels so far; the returns of the records are included. Without levels
    the user's score is not called, since functions such as `max()` would fail.
    Raises `ValueError` if the records lack the field that the score requires, or if a record has no finished episode.
    """
    if not len(records):
        return np.zeros(0)
    returns = records["returns"][:, 0]
    empty = np.isnan(returns).all(1)
    if empty.any():
        raise ValueError(f"level {int(np.flatnonzero(empty)[0])} has no finished episode, so it has no score")
    field = NEEDS.get(rule)
    missing = field is not None and field not in (records.dtype.names or ())
    if field and (missing or np.isnan(mean_played(records[field][:, 0])).any()):
        raise ValueError(
            f'the score {rule} needs records["{field}"], which the trainer has not filled in; '
            "the score learnability needs only returns"
        )
    now = np.nanmax(returns, 1)
    return find(rule)(records, now if best is None else np.fmax(now, best))


def regret(protagonist: np.ndarray, antagonist: np.ndarray, rule: str, flexible: bool = False) -> np.ndarray:
    """Return the regret `[L]` of the protagonist on L levels, from both students' returns `[L, n]` of n episodes.

    rule: "max_mean" is the maximum of the antagonist's returns minus the mean of the protagonist's (Dennis et al. 2020,
    section 4.1, as implemented by its authors); "mean_mean" takes means of both. With random outcomes the mean_mean
    regret of equally good students is 0 on average, while max_mean is positive by luck.
    flexible: on each level, the better student (by the rule's first term) is the antagonist.
    """
    best, other = _best(antagonist, rule), _best(protagonist, rule)
    gap = best - np.nanmean(protagonist, 1)
    return np.where(best >= other, gap, other - np.nanmean(antagonist, 1)) if flexible else gap


def population_regret(returns: np.ndarray, rule: str) -> np.ndarray:
    """Return the regret `[L]` of a population of S students, from their returns `[L, S, n]`.

    It is the maximum (or mean) of the best student minus the mean over all students; there is no antagonist (Dennis
    et al. 2020, appendix, "population PAIRED").
    """
    best = (np.nanmax(returns, 2) if rule == "max_mean" else np.nanmean(returns, 2)).max(1)
    return best - np.nanmean(returns, (1, 2))


def _best(returns: np.ndarray, rule: str) -> np.ndarray:
    return np.nanmax(returns, 1) if rule == "max_mean" else np.nanmean(returns, 1)
