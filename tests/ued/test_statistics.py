"""Intervals against published numbers and against what they should cover."""

import numpy as np
import pytest

from ued.statistics import bootstrap_difference, bootstrap_interval, iqm, wilson


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
    interval = bootstrap_interval(runs, np.random.default_rng(1))
    assert interval.high - interval.low > 0.6
    assert interval.low < interval.estimate < interval.high
    assert interval.estimate == pytest.approx(runs.mean())


def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    rng = np.random.default_rng(2)
    hits = 0
    for _ in range(200):
        low, high = bootstrap_interval(rng.normal(size=20), rng, samples=200)[1:]
        hits += low <= 0 <= high
    assert 0.85 < hits / 200 < 0.99


def test_one_run_has_no_interval():
    interval = bootstrap_interval(np.array([[0.5, 0.7]]), np.random.default_rng(0))
    assert interval.estimate == pytest.approx(0.6)
    assert np.isnan(interval.low) and np.isnan(interval.high)
    with pytest.raises(ValueError, match="at least one run"):
        bootstrap_interval(np.zeros((0, 3)), np.random.default_rng(0))


def test_a_difference_of_methods():
    rng = np.random.default_rng(0)
    better, worse = 1 + 0.1 * rng.normal(size=(8, 5)), 0.1 * rng.normal(size=(6, 5))
    interval = bootstrap_difference(better, worse, rng, statistic=iqm)
    assert 0.8 < interval.low < interval.estimate < interval.high < 1.2
    assert np.isnan(bootstrap_difference(better[:1], worse, rng).low)


def test_wilson():
    """Values of Newcombe (1998), Table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29."""
    for successes, trials, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0, 0.1611)):
        interval = wilson(successes, trials)
        assert (interval.low, interval.high) == pytest.approx((low, high), abs=5e-5)
        assert interval.estimate == successes / trials
    with pytest.raises(ValueError, match="got 3 of 2"):
        wilson(3, 2)
