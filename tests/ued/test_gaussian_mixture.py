"""Mixtures of Gaussians: densities by hand, clusters that are found again, how many there are."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from ued.levels.gaussian_mixture import GaussianMixture, _clusters, _far_apart, aic, fit, products_of

CENTERS = np.array([[-1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])


def drawn(count: int = 300) -> np.ndarray:
    """Draw rows around three centers, in turn."""
    rng = np.random.default_rng(5)
    return CENTERS[np.arange(count) % 3] + 0.1 * rng.standard_normal((count, 3)) * [1.0, 2.0, 0.5]


def test_densities_by_hand():
    mixture = GaussianMixture(np.array([0.25, 0.75]), np.array([[0.0], [2.0]]), np.array([[[1.0]], [[4.0]]]))
    root = np.sqrt(2 * np.pi)
    wanted = [0.25 * np.exp(-0.5) / root, 0.75 * np.exp(-1 / 8) / (2 * root)]
    assert np.exp(mixture.log_densities(products_of(np.array([[1.0]]), True)))[:, 0] == pytest.approx(wanted)
    assert aic([mixture], np.array([[1.0]])) == pytest.approx(2 * 5 - 2 * np.log(sum(wanted)))


def test_what_was_drawn_is_found():
    mixture = fit(drawn(), [3], np.random.default_rng(0))[0]
    order = np.array([np.square(mixture.means - center).sum(1).argmin() for center in CENTERS])
    assert sorted(order) == [0, 1, 2]
    assert mixture.means[order] == pytest.approx(CENTERS, abs=0.05)
    assert mixture.weights == pytest.approx(1 / 3, abs=0.01)
    for covariance in mixture.covariances:
        assert covariance == pytest.approx(np.diag([0.01, 0.04, 0.0025]), abs=0.01)


def test_akaike_tells_how_many():
    one, two, three = aic(fit(drawn(), (1, 2, 3), np.random.default_rng(1)), drawn())
    assert three < two < one


def test_diagonal_covariances_are_full_ones_without_the_rest():
    rng = np.random.default_rng(2)
    variances = rng.uniform(0.1, 2.0, (3, 4))
    diagonal = GaussianMixture(np.array([0.2, 0.3, 0.5]), rng.standard_normal((3, 4)), variances)
    full = replace(diagonal, covariances=variances[:, :, None] * np.eye(4))
    data = rng.standard_normal((5, 4))
    densities = [mixture.log_densities(products_of(data, mixture.full)) for mixture in (diagonal, full)]
    assert densities[0] == pytest.approx(densities[1])
    assert aic([full], data) - aic([diagonal], data) == pytest.approx(2 * 3 * 6)  # of 4 columns 6 pairs
    assert full.marginal(2).covariances == pytest.approx(diagonal.marginal(2).covariances[:, :, None] * np.eye(2))


@pytest.mark.parametrize("full", [True, False])
def test_rows_that_are_drawn_have_its_moments(full):
    covariances = np.array([[[1.0, 0.6], [0.6, 0.5]], [[0.1, 0.0], [0.0, 0.2]]])
    covariances = covariances if full else np.diagonal(covariances, axis1=1, axis2=2)
    mixture = GaussianMixture(np.array([0.7, 0.3]), np.array([[0.0, 0.0], [50.0, 50.0]]), covariances)
    rows = mixture.sample(40_000, np.random.default_rng(3))
    near = rows[:, 0] < 25
    assert near.mean() == pytest.approx(0.7, abs=0.01)
    assert np.cov(rows[near].T) == pytest.approx(np.array([[1.0, 0.6 * full], [0.6 * full, 0.5]]), abs=0.03)


def test_covariances_are_diagonal_where_a_gaussian_has_fewer_rows_than_columns():
    def fitted(rows: int, columns: int) -> GaussianMixture:
        data = np.random.default_rng(0).standard_normal((rows, columns))
        return fit(data, (1, 2), np.random.default_rng(0))[1]

    assert fitted(20, 10).full and not fitted(20, 11).full and not fitted(500, 65).full


def test_a_thousand_columns_take_megabytes():
    data = np.random.default_rng(0).uniform(-1, 1, (250, 1001))
    tracemalloc.start()
    mixtures = fit(data, range(2, 11), np.random.default_rng(0))
    aic(mixtures, data)
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()
    assert all(np.isfinite(mixture.sample(3, np.random.default_rng(0))).all() for mixture in mixtures)


def test_clusters_begin_at_rows_drawn_by_the_square_of_their_distance_for_each_mixture_apart():
    first, second = (
        _far_apart(np.array([[0.0], [1.0], [3.0]]), (2,) * 20_000, np.random.default_rng(0)).reshape(-1, 2).T
    )
    assert [np.mean(first == x) for x in (0, 1, 3)] == pytest.approx([1 / 3] * 3, abs=0.015)
    assert np.mean(second[first == 0] == 3) == pytest.approx(0.9, abs=0.015)  # 9 of 1 + 9
    assert np.mean(second[first == 1] == 3) == pytest.approx(0.8, abs=0.015)  # 4 of 1 + 4


def test_rows_as_near_to_two_clusters_belong_to_both():
    shares = _clusters(np.array([[0.0], [0.0], [1.0]]), (3,), np.random.default_rng(0))
    assert shares.sum(0) == pytest.approx(1.0)
    assert sorted(shares[:, 0]) == [0.0, 0.5, 0.5] and sorted(shares[:, 2]) == [0.0, 0.0, 1.0]


def test_rows_that_are_alike_can_be_fitted():
    mixture = fit(np.repeat([[0.0, 1.0], [0.5, 1.0]], 4, axis=0), [4], np.random.default_rng(0))[0]
    assert np.isfinite(mixture.means).all() and mixture.weights.sum() == pytest.approx(1.0)
