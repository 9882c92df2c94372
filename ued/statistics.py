"""What a comparison of methods may claim: intervals that resample whole runs, and intervals for one run's success.

In curriculum learning one trained student is evaluated on all test levels, so the levels of a run are not independent:
resampling them one by one (the stratified bootstrap of rliable) gives intervals that are too narrow. Here a run is
resampled with all its levels. Read next: the comparison in `experiments.compare`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Interval(NamedTuple):
    """An estimate and its confidence interval."""

    estimate: float
    low: float
    high: float


def iqm(values: np.ndarray) -> float:
    """Give the interquartile mean: the mean of the middle half (Agarwal et al. 2021), fractions of a value included."""
    ordered = np.sort(np.asarray(values, float), axis=None)
    if not len(ordered):
        raise ValueError("the interquartile mean of no values is undefined")
    quarter = len(ordered) / 4
    edges = np.arange(len(ordered) + 1)
    weights = np.clip(np.minimum(edges[1:], len(ordered) - quarter) - np.maximum(edges[:-1], quarter), 0.0, 1.0)
    return float((weights * ordered).sum() / weights.sum())


def mean(values: np.ndarray) -> float:
    """Give the mean of all values."""
    return float(np.mean(values))


def bootstrap_interval(
    per_run: np.ndarray,
    rng: np.random.Generator,
    statistic: Callable[[np.ndarray], float] = mean,
    confidence: float = 0.95,
    samples: int = 2000,
) -> Interval:
    """Give a statistic of R runs `[R, ...]` with its percentile bootstrap interval, resampling whole runs.

    One run has no interval: it says nothing about the next. Then low and high are nan; see `wilson` for what one run's
    own episodes say. Raises `ValueError` for no run.
    """
    runs = np.asarray(per_run, float)
    if runs.ndim == 0 or not len(runs):
        raise ValueError("an interval needs at least one run, got none")
    estimate = statistic(runs)
    if len(runs) == 1:
        return Interval(estimate, float("nan"), float("nan"))
    draws = [statistic(runs[rng.integers(0, len(runs), len(runs))]) for _ in range(samples)]
    low, high = np.quantile(draws, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(estimate, float(low), float(high))


def bootstrap_difference(
    one: np.ndarray,
    other: np.ndarray,
    rng: np.random.Generator,
    statistic: Callable[[np.ndarray], float] = mean,
    confidence: float = 0.95,
    samples: int = 2000,
) -> Interval:
    """Give statistic(one) - statistic(other) for runs `[R, ...]` and `[S, ...]`, resampling whole runs of each.

    With a single run on either side low and high are nan. Raises `ValueError` for no run.
    """
    first, second = np.asarray(one, float), np.asarray(other, float)
    if not (first.ndim and len(first) and second.ndim and len(second)):
        raise ValueError("a difference needs at least one run on each side")
    estimate = statistic(first) - statistic(second)
    if min(len(first), len(second)) == 1:
        return Interval(estimate, float("nan"), float("nan"))
    draws = [_resampled(first, rng, statistic) - _resampled(second, rng, statistic) for _ in range(samples)]
    low, high = np.quantile(draws, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(estimate, float(low), float(high))


def _resampled(runs: np.ndarray, rng: np.random.Generator, statistic: Callable[[np.ndarray], float]) -> float:
    return statistic(runs[rng.integers(0, len(runs), len(runs))])


def wilson(successes: int, trials: int, z: float = 1.959964) -> Interval:
    """Give a success rate with Wilson's score interval (1927); `z` is the normal quantile, 1.96 for 95 %.

    It covers the chance in one student's episodes, not the chance in training: for that, use several runs.
    Raises `ValueError` unless 0 <= successes <= trials and trials >= 1.
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"need 0 <= successes <= trials and trials >= 1, got {successes} of {trials}")
    rate, extra = successes / trials, z**2 / trials
    centre = (rate + extra / 2) / (1 + extra)
    reach = z / (1 + extra) * (rate * (1 - rate) / trials + extra / (4 * trials)) ** 0.5
    return Interval(rate, max(0.0, centre - reach), min(1.0, centre + reach))
