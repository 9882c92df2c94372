"""Mixtures of Gaussians: densities by hand, clusters that are found again, how many there are."""

import numpy as np
import pytest

from ued.levels.gaussian_mixture import GaussianMixture, fit, products_of

CENTRES = np.array([[-1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])


def drawn(count: int = 300) -> np.ndarray:
    """Draw rows around three centres, in turn."""
    rng = np.random.default_rng(5)
    return CENTRES[np.arange(count) % 3] + 0.1 * rng.standard_normal((count, 3)) * [1.0, 2.0, 0.5]


def test_densities_by_hand():
    mixture = GaussianMixture(np.array([0.25, 0.75]), np.array([[0.0], [2.0]]), np.array([[[1.0]], [[4.0]]]))
    root = np.sqrt(2 * np.pi)
    wanted = [0.25 * np.exp(-0.5) / root, 0.75 * np.exp(-1 / 8) / (2 * root)]
    assert np.exp(mixture.log_densities(products_of(np.array([[1.0]]))))[:, 0] == pytest.approx(wanted)
    assert mixture.aic(np.array([[1.0]])) == pytest.approx(2 * 5 - 2 * np.log(sum(wanted)))


def test_what_was_drawn_is_found():
    mixture = fit(drawn(), [3], np.random.default_rng(0))[0]
    order = np.array([np.square(mixture.means - centre).sum(1).argmin() for centre in CENTRES])
    assert sorted(order) == [0, 1, 2]
    assert mixture.means[order] == pytest.approx(CENTRES, abs=0.05)
    assert mixture.weights == pytest.approx(1 / 3, abs=0.01)
    for covariance in mixture.covariances:
        assert covariance == pytest.approx(np.diag([0.01, 0.04, 0.0025]), abs=0.01)


def test_akaike_tells_how_many():
    criterion = [0.0, *(mixture.aic(drawn()) for mixture in fit(drawn(), (1, 2, 3), np.random.default_rng(1)))]
    assert criterion[3] < criterion[2] < criterion[1]


def test_rows_that_are_alike_can_be_fitted():
    mixture = fit(np.repeat([[0.0, 1.0], [0.5, 1.0]], 4, axis=0), [4], np.random.default_rng(0))[0]
    assert np.isfinite(mixture.means).all() and mixture.weights.sum() == pytest.approx(1.0)
