"""Statistics of comparisons: confidence intervals that resample whole runs, and intervals for one run's episodes.

Fewer than `LEAST` values have no interval, and its ends are nan: they are too few to estimate the variance.

In curriculum learning one trained student is evaluated on all test levels, so the levels of a run are not independent.
Resampling them one by one (the stratified bootstrap of rliable) gives intervals that are too narrow. The bootstrap of
this module resamples a run with all its levels. Read next: the tables in `regista.experiments.run.results`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

LEAST = 5  # values that an interval needs: runs, or episodes of a single run
# Draws of a bootstrap of the mean: with 4,000 draws, p-values close to 5% would depend on the random seed.
SAMPLES = 100_000
SAMPLES_OF_OTHERS = 4_000  # draws of statistics other than the mean, which are computed one draw at a time
Z = 1.959964  # normal quantile of a 95% interval
POWER_Z = 0.841621  # normal quantile of a power of 80%


class Interval(NamedTuple):
    """An estimate and its confidence interval; low and high are nan without an interval."""

    estimate: float
    low: float
    high: float

    @property
    def known(self) -> bool:
        """Whether there is an interval, not only an estimate."""
        return self.low == self.low and self.high == self.high


class Difference(NamedTuple):
    """A difference with its confidence interval and two-sided p-value of no difference; nan if not available."""

    estimate: float
    low: float
    high: float
    p: float

    @property
    def known(self) -> bool:
        """Whether there is an interval, not only an estimate."""
        return self.low == self.low and self.high == self.high

    @property
    def excludes_zero(self) -> bool:
        """Whether there is an interval, and 0 lies outside."""
        return self.low > 0 or self.high < 0


def iqm(values: np.ndarray) -> float:
    """Return the interquartile mean: the mean of the middle half (Agarwal et al. 2021), with fractional weights."""
    ordered = np.sort(np.asarray(values, float), axis=None)
    if not len(ordered):
        raise ValueError("the interquartile mean of no values is undefined")
    quarter = len(ordered) / 4
    edges = np.arange(len(ordered) + 1)
    weights = np.clip(np.minimum(edges[1:], len(ordered) - quarter) - np.maximum(edges[:-1], quarter), 0.0, 1.0)
    return float((weights * ordered).sum() / weights.sum())


def mean(values: np.ndarray) -> float:
    """Return the mean of all values."""
    return float(np.mean(values))


@dataclass(frozen=True)
class Bootstrap:
    """A statistic of runs and its bootstrap draws `[S]`, nan for fewer than `LEAST` runs.

    The difference of two bootstraps treats the two sets of runs as independent.
    """

    estimate: float
    draws: np.ndarray

    def __sub__(self, other: Bootstrap) -> Bootstrap:
        return Bootstrap(self.estimate - other.estimate, self.draws - other.draws)

    def interval(self, confidence: float = 0.95) -> Interval:
        """Return the estimate with its percentile interval, whose ends are nan for fewer than `LEAST` runs."""
        low, high = np.quantile(self.draws, [(1 - confidence) / 2, (1 + confidence) / 2])
        return Interval(self.estimate, float(low), float(high))

    def difference(self) -> Difference:
        """Return a difference of two bootstraps with its 95% interval and the two-sided p-value of 0.

        The p-value inverts the interval: it is the smallest level at which the percentile interval excludes 0 (Efron
        and Tibshirani 1993, section 15.4). One draw is added to the count, so that it is never 0 (Davison and Hinkley
        1997, equation 4.11). With 100,000 draws the smallest is 0.00002, for any number of runs from `LEAST` on. A
        permutation test of whole runs has p >= 2 / C(2n, n) for n runs of each method: 0.0079 with five runs, which is
        never significant by `holm` over seven differences, and 1.1e-5 with ten. Its null hypothesis is equal
        distributions, not equal means. A limit of the bootstrap: its smallest p-values depend on the tails of Student's
        t (see `bootstrap`), not only on the data of five runs.
        """
        less = min(float((self.draws <= 0).sum()), float((self.draws >= 0).sum()))
        p = min(1.0, 2 * (less + 1) / (len(self.draws) + 1)) if np.isfinite(self.draws).all() else np.nan
        return Difference(*self.interval(), p)


def bootstrap(
    per_run: np.ndarray,
    rng: np.random.Generator,
    statistic: Callable[[np.ndarray], float] = mean,
    errors: np.ndarray | None = None,
    samples: int | None = None,
) -> Bootstrap:
    """Resample whole runs; return a statistic of R runs `[R, ...]` and its bootstrap draws.

    `samples` is the number of draws, by default `SAMPLES` of the mean and `SAMPLES_OF_OTHERS` of other statistics.
    A sample of few runs underestimates their variance: with two runs, the plain bootstrap's 95% interval has a coverage
    of 50%. So deviations are widened as Student's t widens the normal's, by the root of R / chi-squared(R - 1).
    `errors` `[R, ...]` are the standard errors of each run's values, whose noise is resampled: without them, runs that
    agree by chance would have too narrow an interval. Fewer than `LEAST` runs have no interval; see `wilson` and
    `student_t` for the episodes of a single run. Raises `ValueError` without a run.
    """
    runs = np.asarray(per_run, float)
    count = len(runs) if runs.ndim else 0
    if not count:
        raise ValueError("a bootstrap needs at least one run, got none")
    estimate = statistic(runs)
    samples = samples or (SAMPLES if statistic is mean else SAMPLES_OF_OTHERS)
    if count < LEAST:
        return Bootstrap(estimate, np.full(samples, np.nan))
    chosen = rng.integers(0, count, (samples, count))
    wider = np.sqrt(count / rng.chisquare(count - 1, samples))
    if statistic is mean:
        drawn, luck = _means(runs, chosen, errors, rng)
    else:
        drawn = np.array([statistic(runs[rows]) for rows in chosen])
        luck = np.zeros(samples)
        if errors is not None:
            noisy = (runs[rows] + errors[rows] * rng.normal(size=runs.shape) for rows in chosen)
            luck = np.array([statistic(each) for each in noisy]) - drawn
    return Bootstrap(estimate, estimate + wider * (drawn - estimate) + luck)


def _means(
    runs: np.ndarray, chosen: np.ndarray, errors: np.ndarray | None, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of each sample of runs `chosen` `[S, R]`, and its noise due to the errors, `[S]` each.

    The noise of a mean of independent errors is normal, so one random number per sample is enough.
    """
    means = runs.reshape(len(runs), -1).mean(1)
    if errors is None:
        return means[chosen].mean(1), np.zeros(len(chosen))
    variances = (errors.reshape(len(runs), -1) ** 2).mean(1) / (runs.size / len(runs))
    return means[chosen].mean(1), np.sqrt(variances[chosen].mean(1) / len(runs)) * rng.normal(size=len(chosen))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return adjusted p-values of a family of tests (Holm 1979): a value of at most 5% is significant.

    The probability of rejecting any true null hypothesis is then at most 5% under any dependence of the tests, which
    share the runs of a reference. A nan is not a test: it is returned as it is and not counted.
    """
    p = np.asarray(p_values, float)
    adjusted, most = np.full(len(p), np.nan), 0.0
    tests = np.flatnonzero(np.isfinite(p))
    for rank, k in enumerate(tests[np.argsort(p[tests], kind="stable")]):
        most = max(most, min(1.0, (len(tests) - rank) * p[k]))
        adjusted[k] = most
    return adjusted.tolist()


def detectable(groups: Sequence[np.ndarray], errors: Sequence[np.ndarray] | None = None) -> float:
    """Return the smallest true difference of two methods that these numbers of runs detect: power 80%, level 5%.

    It is the sum of two quantiles of Student's t times the standard error of a difference of two means (Bloom 1995).
    The 97.5% quantile has the degrees of freedom of one method's runs, since the bootstrap above widens the deviations
    of each method separately. The 80% quantile has those of the variance, which is pooled over all groups. The two
    smallest groups are compared. So the power is that of this module's intervals. For normal runs that differ by this
    size, the interval excluded 0 in 79%, 81%, 79% and 80% of 1,500 cases each, for 5, 7, 10 and 20 runs. A t test with
    a pooled variance would detect slightly smaller differences. A correction for several differences requires larger
    ones.

    Args:
        groups: values `[R]` of each method's runs; methods with fewer than three runs are ignored.
        errors: their standard errors `[R]`, a lower bound on the deviation of runs.

    Returns nan for fewer than two groups of at least three runs.
    """
    kept = [k for k, values in enumerate(groups) if len(values) > 2]
    if len(kept) < 2:
        return float("nan")
    counts = sorted(len(groups[k]) for k in kept)
    degrees = sum(counts) - len(kept)
    variance = sum(float(((groups[k] - groups[k].mean()) ** 2).sum()) for k in kept) / degrees
    if errors is not None:
        variance = max(variance, float(np.mean(np.concatenate([errors[k] for k in kept]) ** 2)))
    reach = t_quantile(Z, counts[0] - 1) + t_quantile(POWER_Z, degrees)
    return reach * float(np.sqrt(variance * (1 / counts[0] + 1 / counts[1])))


def wilson(successes: int, trials: int, z: float = Z) -> Interval:
    """Return a success rate with Wilson's score interval (1927); `z` is the normal quantile, 1.96 for 95%.

    It covers the randomness of one student's episodes, not that of training, which needs several runs. Fewer than
    `LEAST` trials have no interval.
    Raises `ValueError` unless 0 <= successes <= trials and trials >= 1.
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"need 0 <= successes <= trials and trials >= 1, got {successes} of {trials}")
    rate, extra = successes / trials, z**2 / trials
    if trials < LEAST:
        return Interval(rate, np.nan, np.nan)
    center = (rate + extra / 2) / (1 + extra)
    reach = z / (1 + extra) * (rate * (1 - rate) / trials + extra / (4 * trials)) ** 0.5
    return Interval(rate, max(0.0, center - reach), min(1.0, center + reach))


def student_t(estimate: float, error: float, count: int) -> Interval:
    """Return a mean of `count` values with Student's 95% interval; `error` is its standard error.

    Fewer than `LEAST` values have no interval.
    """
    if count < LEAST:
        return Interval(estimate, np.nan, np.nan)
    reach = t_quantile(Z, count - 1)
    return Interval(estimate, estimate - reach * error, estimate + reach * error)


def t_quantile(z: float, degrees: int) -> float:
    """Return the quantile of Student's t at the probability of the normal quantile `z`.

    It is expanded in the degrees of freedom (Abramowitz and Stegun 1964, 26.7.5). The error is below 0.001 from four
    degrees on, and below 1% from two on, for probabilities up to 97.5%.
    """
    value = z + (z**3 + z) / (4 * degrees)
    value += (5 * z**5 + 16 * z**3 + 3 * z) / (96 * degrees**2)
    value += (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * degrees**3)
    return value + (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / (92160 * degrees**4)


def of_episodes(returns: np.ndarray) -> Interval:
    """Return the mean return of one student's episodes `[E]`, with Wilson's interval for 0 and 1, else Student's t."""
    values = np.asarray(returns, float)
    if np.isin(values, (0.0, 1.0)).all():
        return wilson(int(values.sum()), len(values))
    return student_t(float(values.mean()), float(values.std() / max(len(values) - 1, 1) ** 0.5), len(values))


def probability_of_improvement(one: np.ndarray, other: np.ndarray, z: float = Z) -> Interval:
    """Return the probability that a run of one method scores above a run of another, ties counting half.

    `one` `[R]` and `other` `[Q]` are scores of runs (Agarwal et al. 2021, section 4.3; Mann and Whitney 1947). The
    interval is Newcombe's (2006, method 5): all probabilities for which the observed one lies within `z` standard
    errors. Unlike a bootstrap interval, it keeps a width above 0 if every run of one method beats every run of the
    other. Fewer than `LEAST` runs of either method have no interval.
    """
    gap = np.asarray(one, float)[:, None] - np.asarray(other, float)[None, :]
    observed = float(np.mean((gap > 0) + 0.5 * (gap == 0)))
    if min(gap.shape) < LEAST:
        return Interval(observed, np.nan, np.nan)
    p = np.linspace(0.0, 1.0, 2001)
    overlap = 1 + (sum(gap.shape) / 2 - 1) * ((1 - p) / (2 - p) + p / (1 + p))
    possible = p[np.abs(observed - p) <= z * np.sqrt(p * (1 - p) * overlap / gap.size) + 1e-12]
    return Interval(observed, float(possible.min(initial=observed)), float(possible.max(initial=observed)))


def cvar(values: np.ndarray, share: float, by: np.ndarray | None = None) -> float:
    """Return the conditional value at risk: the mean of the worst `share` of values, with fractional weights.

    For success rates on random levels it measures robustness (Rutherford et al. 2024). Ranking levels by the episodes
    that give their rates confuses luck with difficulty. So `by` ranks the values by estimates from other episodes; ties
    have equal weights. Raises `ValueError` without values, for a share outside (0, 1], and if `by` has another length.
    """
    array = np.asarray(values, float).ravel()
    rank = array if by is None else np.asarray(by, float).ravel()
    if not len(array) or not 0 < share <= 1 or len(rank) != len(array):
        raise ValueError(
            f"cvar needs values, as many ranks and a share in (0, 1], got {len(array)}, {len(rank)} and {share}"
        )
    _, tie, sizes = np.unique(rank, return_inverse=True, return_counts=True)
    before = np.cumsum(sizes) - sizes  # number of values that are worse than the values of this rank
    weights = (np.clip(share * len(array) - before, 0.0, sizes) / sizes)[tie.ravel()]
    return float((weights * array).sum() / weights.sum())


def spearman(one: Sequence[float], other: Sequence[float]) -> float:
    """Return Spearman's rank correlation of paired values; ties have their mean rank; nan if all values are equal.

    Raises `ValueError` if the numbers of values differ.
    """
    if len(one) != len(other):
        raise ValueError(f"a rank correlation needs pairs, got {len(one)} and {len(other)} values")
    first, second = (_ranks(np.asarray(values, float)) for values in (one, other))
    spread = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / spread if spread else float("nan")


def rank_correlation(one: Sequence[float], other: Sequence[float], rng: np.random.Generator | None = None) -> Interval:
    """Return Spearman's rank correlation of paired values, with its 95% percentile bootstrap interval over pairs.

    Raises `ValueError` if the numbers of values differ.
    """
    middle, first, second = spearman(one, other), np.asarray(one, float), np.asarray(other, float)
    rng = rng or np.random.default_rng(0)
    drawn = rng.integers(0, len(first), (SAMPLES_OF_OTHERS, len(first)))
    values = np.array([spearman(first[rows], second[rows]) for rows in drawn])
    known = values[~np.isnan(values)]
    low, high = np.quantile(known, [0.025, 0.975]) if len(known) else (np.nan, np.nan)
    return Interval(middle, float(low), float(high))


def _ranks(values: np.ndarray) -> np.ndarray:
    """Return the number of values below each value minus the number above."""
    return np.sign(values[:, None] - values[None, :]).sum(1)


def stratified(per_run: np.ndarray, rng: np.random.Generator, samples: int = 2000) -> Interval:
    """Return the IQM of scores `[R, tasks]` with rliable's interval, which resamples runs separately for each task.

    It treats the tasks of a run as independent, so it is too narrow if one student is tested on all of them. Use it for
    comparison with published tables (Agarwal et al. 2021, section 4.1). Fewer than `LEAST` runs have no interval.
    """
    runs = np.asarray(per_run, float)
    count, tasks = runs.shape
    if count < LEAST:
        return Interval(iqm(runs), np.nan, np.nan)
    rows = rng.integers(0, count, (samples, count, tasks))
    drawn = [iqm(runs[chosen, np.arange(tasks)]) for chosen in rows]
    low, high = np.quantile(drawn, [0.025, 0.975])
    return Interval(iqm(runs), float(low), float(high))
