"""Intervals against published numbers and against what they should cover."""

from statistics import NormalDist

import numpy as np
import pytest

from ued.statistics import (
    bootstrap,
    cvar,
    detectable,
    holm,
    iqm,
    of_episodes,
    probability_of_improvement,
    rank_correlation,
    spearman,
    stratified,
    student_t,
    t_quantile,
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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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


def test_a_rank_correlation_has_an_interval_over_pairs():
    rng = np.random.default_rng(1)
    x = rng.normal(size=40)
    y = x + rng.normal(size=40)
    found = rank_correlation(x, y)
    assert found.low < found.estimate == spearman(x, y) < found.high
    assert 0.2 < found.high - found.low < 0.6  # about 2 * 1.96 * 0.75 / sqrt(37), after Fisher
    assert not rank_correlation([1, 1], [1, 2]).known


def test_rank_correlation_is_that_of_the_ranks():
    assert spearman([1, 2, 3, 4], [10, 20, 30, 4000]) == pytest.approx(1.0)
    assert spearman([1, 2, 3], [3, 2, 1]) == pytest.approx(-1.0)
    assert spearman([1, 2, 3, 4, 5], [5, 6, 7, 8, 7]) == pytest.approx(0.8208, abs=1e-4)
    assert np.isnan(spearman([1, 1], [1, 2]))
    with pytest.raises(ValueError, match="needs pairs"):
        spearman([1], [1, 2])


# ---------------------------------------------------------------- several differences, and small ones


def test_holm_as_in_its_paper_and_on_ties():
    """0.01, 0.013 and 0.014 of four tests: 4 x 0.01, 3 x 0.013, 2 x 0.014, each at least as large as the one before."""
    assert holm([0.014, 0.5, 0.01, 0.013]) == pytest.approx([0.04, 0.5, 0.04, 0.04])
    assert holm([0.02, 0.02]) == pytest.approx([0.04, 0.04])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []
    found = holm([0.03, np.nan, 0.01])
    assert found[::2] == pytest.approx([0.03, 0.02]) and np.isnan(found[1])


def differ(one, other, rng, samples=4000):
    return (bootstrap(one, rng, samples=samples) - bootstrap(other, rng, samples=samples)).difference()


def test_a_p_value_below_5_percent_is_an_interval_without_0():
    rng = np.random.default_rng(5)
    found = [differ(rng.normal(gap, size=6), rng.normal(size=6), rng, 400) for gap in np.linspace(0, 2.5, 60)]
    assert all(one.excludes_zero == (one.p < 0.05) for one in found if abs(one.p - 0.05) > 0.006)
    assert {one.excludes_zero for one in found} == {True, False}


def test_p_values_of_clear_differences_of_none_and_of_few_runs():
    rng = np.random.default_rng(6)
    assert differ(np.full(5, 1.0), np.zeros(5), rng).p == pytest.approx(2 / 4001)
    assert differ(np.zeros(5), np.zeros(5), rng).p == 1.0
    few = differ(np.zeros(4), np.ones(5), rng)
    assert np.isnan(few.p) and not few.known and not few.excludes_zero


@pytest.mark.parametrize("runs", [5, 10])
def test_holm_claims_a_false_difference_in_few_tables(runs):
    """Of tables with six differences to one reference, none of them real: at most 5% have a mark, up to chance."""
    rng, wrong = np.random.default_rng(7), 0
    for _ in range(120):
        base, *others = (bootstrap(rng.normal(size=runs), rng, samples=400) for _ in range(7))
        wrong += min(holm([(one - base).difference().p for one in others])) <= 0.05
    assert wrong / 120 < 0.05 + 2.5 * (0.05 * 0.95 / 120) ** 0.5


@pytest.mark.parametrize(("runs", "size"), [(3, 4.303 + 0.941), (5, 2.776 + 0.889), (10, 2.262 + 0.862)])
def test_detectable_differences_by_the_table_of_student(runs, size):
    """Of n runs with deviation 1: the quantiles for 97.5% and n - 1 degrees and for 80% and 2n - 2."""
    values = np.arange(runs) - (runs - 1) / 2
    values /= values.std(ddof=1)
    assert detectable([values, values + 9]) == pytest.approx(size * (2 / runs) ** 0.5, rel=0.01)


@pytest.mark.parametrize("runs", [5, 10])
def test_four_of_five_detectable_differences_are_detected(runs):
    rng, values = np.random.default_rng(8), np.arange(runs) - (runs - 1) / 2
    size = detectable([values / values.std(ddof=1)] * 2)
    found = [differ(rng.normal(size, size=runs), rng.normal(size=runs), rng, 400).excludes_zero for _ in range(150)]
    assert np.mean(found) == pytest.approx(0.8, abs=0.1)


def test_what_can_be_detected_depends_on_the_smallest_groups_and_on_luck_within_runs():
    spread = np.array([-1.0, 0.0, 1.0])
    three, many = detectable([spread, spread]), detectable([np.tile(spread, 9), np.tile(spread, 9)])
    assert many < three and detectable([spread, np.tile(spread, 9)]) < three
    assert detectable([spread, spread, np.tile(spread, 9)]) < three  # more degrees of freedom, the same two groups
    assert np.isnan(detectable([spread, spread[:2]])) and np.isnan(detectable([]))
    same, errors = [np.zeros(5)] * 2, [np.full(5, 0.1)] * 2
    assert detectable(same) == 0.0 and detectable(same, errors) == pytest.approx(2.318 * 0.1, rel=0.01)


@pytest.mark.parametrize(("degrees", "expected"), [(2, 4.303), (4, 2.776), (8, 2.306), (30, 2.042)])
def test_quantiles_of_student(degrees, expected):
    assert t_quantile(1.959964, degrees) == pytest.approx(expected, rel=0.01 if degrees < 4 else 4e-4)
