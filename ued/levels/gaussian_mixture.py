"""Gaussian mixtures, fitted by expectation maximization (Dempster et al. 1977), several mixtures at once.

The algorithm is that of scikit-learn, where many small calls per Gaussian dominate the time for a few hundred rows. Log
densities are quadratic forms of a row, and moments are sums over rows. So both are single matrix products, given the
precomputed products of each row's entries.

Covariances are full, as in the paper's code, if a Gaussian has at least as many rows as columns. Otherwise full
covariances would be singular, and diagonal ones are used (scikit-learn's "diag"). They need D instead of D² products of
a row.
Read next: `methods.alp_gmm`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

MOST_STEPS = 100
TOLERANCE = 1e-3  # minimum change of the mean log-likelihood per step
REGULARISER = 1e-5  # added to variances to keep them positive
LEAST_LOG_SHARE = -50.0  # lower limit, since numpy's exponential is ten times slower below
MOST_FULL = 64  # maximum number of columns for full covariances: 4,225 products of a row


@dataclass(frozen=True)
class GaussianMixture:
    """K Gaussians in D dimensions: weights `[K]`, means `[K, D]`, covariances `[K, D, D]`, or diagonals `[K, D]`."""

    weights: np.ndarray
    means: np.ndarray
    covariances: np.ndarray

    def __getitem__(self, which: np.ndarray) -> GaussianMixture:
        """Select Gaussians by a mask: bool `[K]`."""
        return GaussianMixture(self.weights[which], self.means[which], self.covariances[which])

    @property
    def full(self) -> bool:
        """Whether covariances are full."""
        return self.covariances.ndim == 3

    def marginal(self, dim: int) -> GaussianMixture:
        """Return the marginal distribution of the first columns."""
        inner = (slice(None), *[slice(dim)] * (self.covariances.ndim - 1))
        return GaussianMixture(self.weights, self.means[:, :dim], self.covariances[inner])

    @cached_property
    def _roots(self) -> np.ndarray:
        return np.linalg.cholesky(self.covariances) if self.full else np.sqrt(self.covariances)

    def sample(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Sample rows `[count, D]`."""
        which = rng.choice(len(self.weights), count, p=self.weights)
        noise, roots = rng.standard_normal((count, self.means.shape[1])), self._roots[which]
        return self.means[which] + ((roots @ noise[:, :, None])[:, :, 0] if self.full else roots * noise)

    def log_densities(self, products: np.ndarray) -> np.ndarray:
        """Return the log weighted density `[K, n]` of each Gaussian for each row, given the rows' products `[n, P]`."""
        count, dim = self.means.shape
        if self.full:
            root = self._roots
            inverse = np.linalg.inv(root)
            standard = np.concatenate([-inverse @ self.means[:, :, None], inverse], 2)  # [K, D, 1 + D], of (1, row)
            form, scales = (standard.mT @ standard).reshape(count, -1), np.diagonal(root, axis1=1, axis2=2)
        else:
            form, scales = 1 / self.covariances, self._roots
            slope = -2 * form * self.means
            form = np.concatenate([-0.5 * (slope * self.means).sum(1, keepdims=True), slope, form], 1)
        constant = np.log(self.weights) - np.log(scales).sum(1) - 0.5 * dim * math.log(2 * math.pi)
        return constant[:, None] - 0.5 * form @ products.T


def products_of(data: np.ndarray, full: bool) -> np.ndarray:
    """Return the products of entries of (1, row) for each row of data `[n, D]`.

    All pairs `[n, (1 + D)²]`, or for diagonal covariances 1, row and row²: `[n, 1 + 2 D]`.
    """
    rows = np.concatenate([np.ones((len(data), 1)), data], 1)
    if not full:
        return np.concatenate([rows, data**2], 1)
    return (rows[:, :, None] * rows[:, None]).reshape(len(data), -1)


def aic(mixtures: Sequence[GaussianMixture], data: np.ndarray) -> np.ndarray:
    """Return Akaike's criterion `[M]` of mixtures with one type of covariance on data `[n, D]`; smaller is better."""
    counts, dim = np.array([len(mixture.weights) for mixture in mixtures]), data.shape[1]
    together = _joined(mixtures)
    parameters = counts * (dim * (dim + 1) // 2 if together.full else dim) + counts * dim + counts - 1
    densities = together.log_densities(products_of(data, together.full))
    return 2 * parameters - 2 * len(data) * _share(densities, np.repeat(np.arange(len(counts)), counts))[1]


def fit(
    data: np.ndarray,
    counts: Sequence[int],
    rng: np.random.Generator,
    full: bool | None = None,
    regulariser: float = REGULARISER,
) -> list[GaussianMixture]:
    """Fit one mixture for each of these numbers of Gaussians to data `[n, D]`, initialized by clusters.

    All mixtures, with K Gaussians in total, are updated together; each stops when it has converged. Covariances are
    full or diagonal (`full`); None: full if there are enough rows. `regulariser` is added to variances.
    """
    if full is None:
        full = data.shape[1] <= min(MOST_FULL, len(data) // max(counts))
    products = products_of(data, full)
    share, dim = _clusters(data, counts, rng), data.shape[1]  # [K, n]
    owner = np.repeat(np.arange(len(counts)), counts)  # [K] the mixture of each Gaussian
    fitted, before = dict[int, GaussianMixture](), np.full(len(counts), -math.inf)
    mixtures = _maximize(products, share, dim, regulariser)
    for step in range(1, MOST_STEPS + 1):
        share, likelihood = _share(mixtures.log_densities(products), owner)
        mixtures = _maximize(products, share, dim, regulariser)
        left = np.unique(owner)
        good = abs(likelihood - before[left]) < TOLERANCE
        before[left] = likelihood
        if not good.any() and step < MOST_STEPS:
            continue
        for k in left[good | (step == MOST_STEPS)]:
            fitted[k] = mixtures[owner == k]
        goes_on = ~np.isin(owner, list(fitted))
        mixtures, owner = mixtures[goes_on], owner[goes_on]
        if not len(owner):
            break
    return [fitted[k] for k in range(len(counts))]


def _joined(mixtures: Sequence[GaussianMixture]) -> GaussianMixture:
    parts = ("weights", "means", "covariances")
    return GaussianMixture(*(np.concatenate([getattr(mixture, part) for mixture in mixtures]) for part in parts))


def _share(parts: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the responsibilities `[K, n]` of Gaussians for rows, and the mean log-likelihood of each mixture.

    `parts` `[K, n]` are the log weighted densities; `owner` `[K]` is the mixture of each Gaussian.
    """
    starts, sizes = np.unique(owner, return_index=True, return_counts=True)[1:]
    largest = np.maximum.reduceat(parts, starts)
    share = parts - np.repeat(largest, sizes, 0)
    np.exp(np.maximum(share, LEAST_LOG_SHARE, out=share), out=share)
    total = np.add.reduceat(share, starts)
    share /= np.repeat(total, sizes, 0)
    return share, (largest + np.log(total)).mean(1)


def _maximize(products: np.ndarray, share: np.ndarray, dim: int, regulariser: float) -> GaussianMixture:
    """Return the maximum-likelihood mixtures for responsibilities `[K, n]` and products of rows of `dim` columns."""
    moments = share @ products  # [K, P]
    total = moments[:, 0] + 10 * np.finfo(float).eps  # [K]
    moments = moments / total[:, None]
    means, squares = moments[:, 1 : 1 + dim], moments[:, 1 + dim :]
    if products.shape[1] == 1 + 2 * dim:
        return GaussianMixture(total / len(products), means, squares - means**2 + regulariser)
    squares = moments.reshape(-1, 1 + dim, 1 + dim)[:, 1:, 1:]
    covariances = squares - means[:, :, None] * means[:, None] + regulariser * np.eye(dim)
    return GaussianMixture(total / len(products), means, covariances)


def _clusters(data: np.ndarray, counts: Sequence[int], rng: np.random.Generator) -> np.ndarray:
    """Return the membership `[K, n]` of rows of data `[n, D]` in clusters, for each of these numbers of clusters.

    k-means with k-means++ initialization. Rows equally close to two clusters belong to both.
    """
    centers, starts = _far_apart(data, counts, rng), np.array([0, *counts]).cumsum()[:-1]  # [K, D]
    share = np.zeros((len(centers), len(data)))
    for _ in range(MOST_STEPS):
        distance = 0.5 * (centers**2).sum(1)[:, None] - centers @ data.T  # half the squared distance + a row constant
        mine = distance == np.repeat(np.minimum.reduceat(distance, starts), counts, 0)
        before, share = share, mine / np.repeat(np.add.reduceat(mine, starts, dtype=float), counts, 0)
        if (share == before).all():
            break
        total = share.sum(1)[:, None]
        centers = np.where(total > 0, share @ data / np.maximum(total, 1), centers)
    return share


def _far_apart(data: np.ndarray, counts: Sequence[int], rng: np.random.Generator) -> np.ndarray:
    """Return initial centers `[K, D]` from the rows of data `[n, D]` by k-means++ (Arthur and Vassilvitskii 2007).

    They are sampled separately for each number of clusters.
    """
    squares, chosen = (data**2).sum(1), [rng.integers(len(data), size=len(counts))]  # [M] rows
    far = np.full((len(counts), len(data)), math.inf)
    while len(chosen) < max(counts):
        last = chosen[-1]
        far = np.minimum(far, squares - 2 * data[last] @ data.T + squares[last, None])  # [M, n]
        likely = np.maximum(far, np.finfo(float).tiny).cumsum(1)
        chosen.append((likely <= rng.random((len(counts), 1)) * likely[:, -1:]).sum(1))
    return np.concatenate([data[rows[:count]] for rows, count in zip(np.transpose(chosen), counts, strict=True)])
