"""Mixtures of Gaussians, fitted by expectation maximisation (Dempster et al. 1977), all Gaussians of one at a time.

The steps are those of scikit-learn, which takes a dozen calls for each Gaussian; for a few hundred rows these calls are
nearly all of the time. Densities are quadratic forms of a row, and moments are sums over rows: with the products of a
row's entries at hand, each of the two is one product of matrices. Read next: `methods.alp_gmm`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MOST_STEPS = 100
TOLERANCE = 1e-3  # of the mean log-likelihood, below which another step is not worth it
REGULARISER = 1e-5  # added to variances: none is 0
LEAST_LOG_SHARE = -50.0  # of a Gaussian in a row: below, numpy's exponential takes ten times as long


@dataclass(frozen=True)
class GaussianMixture:
    """K Gaussians in D dimensions: weights `[K]`, means `[K, D]`, covariances `[K, D, D]`."""

    weights: np.ndarray
    means: np.ndarray
    covariances: np.ndarray

    def log_densities(self, products: np.ndarray) -> np.ndarray:
        """Return for each row, given its products `[n, (1 + D)²]`, the logarithm of what each Gaussian adds to its
        density, `[K, n]`.
        """
        count, dim = self.means.shape
        root = np.linalg.cholesky(self.covariances)  # [K, D, D]
        inverse = np.linalg.inv(root)
        standard = np.concatenate([-inverse @ self.means[:, :, None], inverse], 2)  # [K, D, 1 + D], of (1, row)
        log_det = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(1)
        constant = np.log(self.weights) - log_det - 0.5 * dim * math.log(2 * math.pi)
        return constant[:, None] - 0.5 * (standard.mT @ standard).reshape(count, -1) @ products.T

    def aic(self, data: np.ndarray) -> float:
        """Return Akaike's criterion on data `[n, D]`: the smaller, the better."""
        count, dim = self.means.shape
        parameters = count * dim * (dim + 1) / 2 + count * dim + count - 1
        return 2 * parameters - 2 * float(_share(self.log_densities(products_of(data)))[1].sum())


def products_of(data: np.ndarray) -> np.ndarray:
    """Return the products of all pairs of entries of (1, row) for each row of data `[n, D]`: `[n, (1 + D)²]`."""
    rows = np.concatenate([np.ones((len(data), 1)), data], 1)
    return (rows[:, :, None] * rows[:, None]).reshape(len(data), -1)


def fit(data: np.ndarray, components: int, rng: np.random.Generator) -> GaussianMixture:
    """Fit a mixture of so many Gaussians to data `[n, D]`, from clusters on."""
    products, dim = products_of(data), data.shape[1]
    mixture, before = _maximise(products, np.eye(components)[:, _clusters(data, components, rng)], dim), -math.inf
    for _ in range(MOST_STEPS):
        share, density = _share(mixture.log_densities(products))
        mixture = _maximise(products, share, dim)
        if abs(density.mean() - before) < TOLERANCE:
            break
        before = density.mean()
    return mixture


def _share(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share `[K, n]` of each Gaussian in the density of each row, and its logarithm `[n]`, from `[K, n]`."""
    largest = parts.max(0)
    share = np.exp(np.maximum(parts - largest, LEAST_LOG_SHARE))
    total = share.sum(0)
    return share / total, largest + np.log(total)


def _maximise(products: np.ndarray, share: np.ndarray, dim: int) -> GaussianMixture:
    """Return the likeliest mixture where each Gaussian has this share `[K, n]` of the rows with these products."""
    moments = (share @ products).reshape(-1, 1 + dim, 1 + dim)  # [K, 1 + D, 1 + D]
    total = moments[:, 0, 0] + 10 * np.finfo(float).eps  # [K]
    moments = moments / total[:, None, None]
    means = moments[:, 0, 1:]
    covariances = moments[:, 1:, 1:] - means[:, :, None] * means[:, None]
    return GaussianMixture(total / total.sum(), means, covariances + REGULARISER * np.eye(dim))


def _clusters(data: np.ndarray, components: int, rng: np.random.Generator) -> np.ndarray:
    """Return to which of so many clusters each row of data `[n, D]` belongs: k-means from k-means++, int `[n]`."""
    centres, far = data[rng.integers(len(data), size=1)], np.full(len(data), math.inf)
    while len(centres) < components:  # each new one is likely far from those that are there (Arthur et al. 2007)
        far = np.minimum(far, _distances(data, centres[-1:])[0])  # [n]
        likely = far + np.finfo(float).tiny
        centres = np.concatenate([centres, data[rng.choice(len(data), 1, p=likely / likely.sum())]])
    nearest = _distances(data, centres).argmin(0)  # [n]
    for _ in range(MOST_STEPS):
        mine = np.eye(components)[:, nearest]  # [K, n]
        count = mine.sum(1)[:, None]
        centres = np.where(count > 0, mine @ data / np.maximum(count, 1), centres)
        before, nearest = nearest, _distances(data, centres).argmin(0)
        if (nearest == before).all():
            break
    return nearest


def _distances(data: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return the squared distance of each centre `[K, D]` to each row of data `[n, D]`: `[K, n]`."""
    squares = (data**2).sum(1) + (centres**2).sum(1)[:, None]
    return np.maximum(squares - 2 * centres @ data.T, 0.0)
