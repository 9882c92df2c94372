"""Mixtures of Gaussians, fitted by expectation maximisation (Dempster et al. 1977), several mixtures at a time.

The steps are those of scikit-learn, which takes a dozen calls for each Gaussian; for a few hundred rows these calls are
nearly all of the time. Densities are quadratic forms of a row, and moments are sums over rows: with the products of a
row's entries at hand, each of the two is one product of matrices. Read next: `methods.alp_gmm`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
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

    def __getitem__(self, which: np.ndarray) -> GaussianMixture:
        """Return these of its Gaussians: bool `[K]`."""
        return GaussianMixture(self.weights[which], self.means[which], self.covariances[which])

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
        likelihood = _share(self.log_densities(products_of(data)), np.zeros(count, np.int64))[1][0] * len(data)
        return 2 * parameters - 2 * float(likelihood)


def products_of(data: np.ndarray) -> np.ndarray:
    """Return the products of all pairs of entries of (1, row) for each row of data `[n, D]`: `[n, (1 + D)²]`."""
    rows = np.concatenate([np.ones((len(data), 1)), data], 1)
    return (rows[:, :, None] * rows[:, None]).reshape(len(data), -1)


def fit(data: np.ndarray, counts: Sequence[int], rng: np.random.Generator) -> list[GaussianMixture]:
    """Fit a mixture of each of these numbers of Gaussians to data `[n, D]`, from clusters on.

    They take their steps together, K Gaussians in all, each mixture until it is good enough.
    """
    products = products_of(data)
    share = np.concatenate([np.eye(count)[:, _clusters(data, count, rng)] for count in counts])  # [K, n]
    owner = np.repeat(np.arange(len(counts)), counts)  # [K] the mixture that each belongs to
    fitted, before, mixtures = dict[int, GaussianMixture](), np.full(len(counts), -math.inf), _maximise(products, share)
    for step in range(1, MOST_STEPS + 1):
        share, likelihood = _share(mixtures.log_densities(products), owner)
        mixtures = _maximise(products, share)
        good = abs(likelihood - before[np.unique(owner)]) < TOLERANCE
        for k in np.unique(owner)[good | (step == MOST_STEPS)]:
            fitted[k] = mixtures[owner == k]
        before[np.unique(owner)] = likelihood
        left = ~np.isin(owner, list(fitted))
        mixtures, owner = mixtures[left], owner[left]
        if not len(owner):
            break
    return [fitted[k] for k in range(len(counts))]


def _share(parts: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share `[K, n]` of each Gaussian in the density of each row under its mixture, from what it adds
    `[K, n]`, and the mean logarithm of that density, for each of the mixtures that occur in `owner` `[K]`.
    """
    starts, sizes = np.unique(owner, return_index=True, return_counts=True)[1:]
    largest = np.maximum.reduceat(parts, starts)
    share = np.exp(np.maximum(parts - np.repeat(largest, sizes, 0), LEAST_LOG_SHARE))
    total = np.add.reduceat(share, starts)
    return share / np.repeat(total, sizes, 0), (largest + np.log(total)).mean(1)


def _maximise(products: np.ndarray, share: np.ndarray) -> GaussianMixture:
    """Return the likeliest mixtures where each Gaussian has this share `[K, n]` of the rows with these products."""
    size = math.isqrt(products.shape[1])  # 1 + D
    moments = (share @ products).reshape(-1, size, size)  # [K, 1 + D, 1 + D]
    total = moments[:, 0, 0] + 10 * np.finfo(float).eps  # [K]
    moments = moments / total[:, None, None]
    means = moments[:, 0, 1:]
    covariances = moments[:, 1:, 1:] - means[:, :, None] * means[:, None]
    return GaussianMixture(total / len(products), means, covariances + REGULARISER * np.eye(size - 1))


def _clusters(data: np.ndarray, components: int, rng: np.random.Generator) -> np.ndarray:
    """Return to which of so many clusters each row of data `[n, D]` belongs: k-means from k-means++, int `[n]`."""
    squares, centres = (data**2).sum(1), data[rng.integers(len(data), size=1)]
    far = np.full(len(data), math.inf)
    while len(centres) < components:  # each new one is likely far from those that are there (Arthur et al. 2007)
        far = np.minimum(far, squares - data @ (2 * centres[-1]) + (centres[-1] ** 2).sum())  # [n]
        likely = np.maximum(far, np.finfo(float).tiny)
        centres = np.concatenate([centres, data[rng.choice(len(data), 1, p=likely / likely.sum())]])
    nearest = _nearest(data, centres)
    for _ in range(MOST_STEPS):
        mine = np.eye(components)[:, nearest]  # [K, n]
        count = mine.sum(1)[:, None]
        centres = np.where(count > 0, mine @ data / np.maximum(count, 1), centres)
        before, nearest = nearest, _nearest(data, centres)
        if (nearest == before).all():
            break
    return nearest


def _nearest(data: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return which of these centres `[K, D]` is the nearest to each row of data `[n, D]`: int `[n]`."""
    return (0.5 * (centres**2).sum(1)[:, None] - centres @ data.T).argmin(0)
