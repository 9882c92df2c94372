"""Intervals against published numbers and against what they should cover."""

from statistics import NormalDist

import numpy as np
import pytest

from ued.statistics import (
    bootstrap,
    cvar,
    iqm,
    of_episodes,
    probability_of_improvement,
    spearman,
    stratified,
    student_t,
    wilson,
)


def test_iqm_is_the_mean_of_the_middle_half():
    assert iqm(np.array([0.0, 1.0, 2.0, 100.0])) == 1.5
    assert iqm(np.arange(8.0)) == 3.5
    assert iqm(np.array([5.0])) == 5.0
    assert iqm(np.array([1.0, 2.0, 9.0])) == pytest.approx((0.25 * 1 + 2 + 0.25 * 9) / 1.5)
    assert iqm(np.array([[1.0, 2.0], [3.0, 4.0]])) == 2.5
    with pytest.raises(ValueError, match="no values"):
        iqm(np.array([]))


def test_whole_runs_are_resampled():
    """Ten runs of a thousand equal levels say no more than ten numbers."""
    rng = np.random.default_rng(0)
    runs = rng.normal(size=(10, 1)) + np.zeros((10, 1000))
    interval = bootstrap(runs, np.random.default_rng(1)).interval()
    assert interval.high - interval.low > 0.6
    assert interval.low < interval.estimate < interval.high
    assert interval.estimate == pytest.approx(runs.mean())


@pytest.mark.parametrize("runs", [5, 7, 20])
def test_the_interval_covers_the_truth_about_as_often_as_it_says(runs):
    """Plain resampling would cover it in 84% of the cases with five runs."""
    rng = np.random.default_rng(2)
    hits = 0
    for _ in range(200):
        low, high = bootstrap(rng.normal(size=runs), rng, samples=200).interval()[1:]
        hits += low <= 0 <= high
    assert 0.89 < hits / 200 < 0.99


def test_it_is_as_wide_as_student_has_it():
    """Five runs with mean 0 and deviation 1: 2.776 / sqrt(5); the many runs that say the same: 1.96 / sqrt(500)."""
    few = np.array([-1.0, -1.0, 0.0, 1.0, 1.0])
    for runs, reach in ((few, 2.776 / 5**0.5), (np.repeat(few, 100), 1.96 / 500**0.5 * (400 / 499) ** 0.5)):
        _, low, high = bootstrap(runs, np.random.default_rng(3)).interval()
        assert (high - low) / 2 == pytest.approx(reach, rel=0.12)


def test_the_luck_within_runs_counts_too():
    equal, errors = np.full(5, 0.5), np.full(5, 0.1)
    assert bootstrap(equal, np.random.default_rng(0)).interval() == (0.5, 0.5, 0.5)
    _, low, high = bootstrap(equal, np.random.default_rng(0), errors=errors).interval()
    assert (high - low) / 2 == pytest.approx(1.96 * 0.1 / 5**0.5, rel=0.1)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_few_values_have_no_interval(count):
    rng, values = np.random.default_rng(0), np.arange(count) / 10
    intervals = [
        bootstrap(values, rng).interval(),
        wilson(1, count),
        student_t(0.5, 0.1, count),
        of_episodes(values),
        of_episodes(np.ones(count)),
        probability_of_improvement(values, np.arange(9.0)),
        probability_of_improvement(np.arange(9.0), values),
        stratified(values[:, None], rng),
    ]
    assert all(np.isnan([interval.low, interval.high]).all() and not interval.known for interval in intervals)
    assert intervals[0].estimate == pytest.approx(values.mean())
    with pytest.raises(ValueError, match="at least one run"):
        bootstrap(np.zeros((0, 3)), np.random.default_rng(0))


def test_a_difference_of_methods():
    rng = np.random.default_rng(0)
    better, worse = 1 + 0.1 * rng.normal(size=(8, 5)), 0.1 * rng.normal(size=(6, 5))
    interval = (bootstrap(better, rng, iqm) - bootstrap(worse, rng, iqm)).interval()
    assert 0.8 < interval.low < interval.estimate < interval.high < 1.2
    assert np.isnan((bootstrap(better[:1], rng) - bootstrap(worse, rng)).interval().low)


def test_wilson():
    """Values of Newcombe (1998), Table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29."""
    for successes, trials, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0, 0.1611)):
        interval = wilson(successes, trials)
        assert (interval.low, interval.high) == pytest.approx((low, high), abs=5e-5)
        assert interval.estimate == successes / trials
    with pytest.raises(ValueError, match="got 3 of 2"):
        wilson(3, 2)


@pytest.mark.parametrize(("count", "quantile"), [(5, 2.7764), (6, 2.5706), (11, 2.2281), (31, 2.0423), (1001, 1.9623)])
def test_students_t_has_the_published_quantiles(count, quantile):
    interval = student_t(1.0, 0.5, count)
    assert (interval.high - 1.0) / 0.5 == pytest.approx(quantile, abs=2e-3) and interval.estimate == 1.0
    assert interval.high - 1.0 == pytest.approx(1.0 - interval.low)


def test_returns_of_0_and_1_have_wilsons_interval_and_others_students():
    goals = np.array([1.0] * 15 + [0.0] * 133)
    assert of_episodes(goals) == wilson(15, 148)
    returns = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    assert of_episodes(returns) == pytest.approx(student_t(3.0, returns.std(ddof=1) / 5**0.5, 5))


def test_cvar_is_the_mean_of_the_worst():
    values = np.array([0.4, 0.1, 0.2, 0.9, 0.3])
    assert cvar(values, 0.2) == pytest.approx(0.1)
    assert cvar(values, 0.3) == pytest.approx((0.1 + 0.5 * 0.2) / 1.5)  # one value and a half
    assert cvar(values, 1.0) == pytest.approx(values.mean())
    assert cvar(values, 0.01) == pytest.approx(0.1)
    for bad in ((np.array([]), 0.5), (values, 0.0), (values, 1.1), (values, 0.5, values[:2])):
        with pytest.raises(ValueError, match="cvar needs values"):
            cvar(*bad)


def test_cvar_by_the_rank_of_other_estimates():
    values, by = np.array([1.0, 2.0, 3.0, 4.0]), np.array([9.0, 8.0, 7.0, 6.0])
    assert cvar(values, 0.5, by=by) == 3.5
    equal = np.array([0.0, 0.0, 0.0, 1.0])  # three tie for two places: each counts two thirds
    assert cvar(values, 0.5, by=equal) == pytest.approx(2.0)
    assert cvar(values, 0.8, by=equal) == pytest.approx((1 + 2 + 3 + 0.2 * 4) / 3.2)


def test_worst_levels_of_equal_ones_are_not_worse_by_other_episodes():
    """Levels of one success rate 0.5: ten episodes make some look bad, ten others do not."""
    rng = np.random.default_rng(0)
    one, other = rng.binomial(10, 0.5, (2, 1000)) / 10
    assert cvar(one, 0.1) < 0.3
    assert cvar(other, 0.1, by=one) == pytest.approx(0.5, abs=0.05)


def test_the_probability_of_improvement_counts_pairs():
    for one, other, share in [([2, 3], [0, 1], 1.0), ([1, 3], [1, 2, 4], 2.5 / 6), ([1, 1, 1], [1, 1], 0.5)]:
        assert probability_of_improvement(np.array(one), np.array(other)).estimate == pytest.approx(share)


def test_the_probability_of_improvement_of_few_runs_is_uncertain_even_if_all_are_better():
    few = probability_of_improvement(np.arange(5.0) + 5, np.arange(5.0))
    many = probability_of_improvement(np.arange(20.0) + 20, np.arange(20.0))
    assert few.low < 0.65 < many.low < 1.0 == few.high == many.high


@pytest.mark.parametrize("shift", [0.0, 0.7, 1.5])
def test_the_interval_of_the_probability_of_improvement_covers_it(shift):
    """Of two normal distributions `shift` deviations apart it is Phi(shift / root 2)."""
    truth = NormalDist().cdf(shift / 2**0.5)
    rng = np.random.default_rng(1)
    found = [probability_of_improvement(rng.normal(shift, 1, 6), rng.normal(0, 1, 6)) for _ in range(1000)]
    covered = np.mean([low <= truth <= high for _, low, high in found])
    assert 0.92 < covered < 0.995


def test_the_stratified_interval_takes_tasks_of_a_run_for_independent():
    """Runs that are good or bad at all tasks: each task resampled apart evens them out, whole runs do not."""
    runs = np.array([[0.0], [1.0], [0.0], [1.0], [0.0], [1.0]]) + np.zeros((6, 50))
    narrow = stratified(runs, np.random.default_rng(0))
    wide = bootstrap(runs, np.random.default_rng(0), iqm).interval()
    assert narrow.estimate == wide.estimate == iqm(runs) == 0.5
    assert narrow.high - narrow.low < 0.5 < wide.high - wide.low


def test_the_stratified_interval_of_one_task_resamples_its_runs():
    """Half of the runs 0 and half 1: a resample of six has another interquartile mean each time, from 0 to 1."""
    interval = stratified(np.array([[0.0], [1.0]] * 3), np.random.default_rng(0))
    assert interval == (0.5, 0.0, 1.0)


def test_rank_correlation_is_that_of_the_ranks():
    assert spearman([1, 2, 3, 4], [10, 20, 30, 4000]) == pytest.approx(1.0)
    assert spearman([1, 2, 3], [3, 2, 1]) == pytest.approx(-1.0)
    assert spearman([1, 2, 3, 4, 5], [5, 6, 7, 8, 7]) == pytest.approx(0.8208, abs=1e-4)
    assert np.isnan(spearman([1, 1], [1, 2]))
    with pytest.raises(ValueError, match="needs pairs"):
        spearman([1], [1, 2])
