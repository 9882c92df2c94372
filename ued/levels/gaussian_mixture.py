"""Mixtures of Gaussians, fitted by expectation maximisation (Dempster et al. 1977), all Gaussians of one at a time.

The steps are those of scikit-learn, which takes a dozen calls for each Gaussian; for a few hundred rows these calls are
nearly all of the time. Read next: `methods.alp_gmm`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MOST_STEPS = 100
TOLERANCE = 1e-3  # of the mean log-likelihood, below which another step is not worth it
REGULARISER = 1e-5  # added to variances: none is 0


@dataclass(frozen=True)
class GaussianMixture:
    """K Gaussians in D dimensions: weights `[K]`, means `[K, D]`, covariances `[K, D, D]`."""

    weights: np.ndarray
    means: np.ndarray
    covariances: np.ndarray

    def log_densities(self, data: np.ndarray) -> np.ndarray:
        """Return for each row of data `[n, D]` the logarithm of what each Gaussian adds to its density, `[K, n]`."""
        root = np.linalg.cholesky(self.covariances)  # [K, D, D]
        standard = np.linalg.inv(root) @ (data[None] - self.means[:, None]).mT  # [K, D, n]
        log_det = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(1)
        constant = np.log(self.weights) - log_det - 0.5 * data.shape[1] * math.log(2 * math.pi)
        return constant[:, None] - 0.5 * np.einsum("kdn,kdn->kn", standard, standard)

    def aic(self, data: np.ndarray) -> float:
        """Return Akaike's criterion on data `[n, D]`: the smaller, the better."""
        count, dim = self.means.shape
        parameters = count * dim * (dim + 1) / 2 + count * dim + count - 1
        return 2 * parameters - 2 * float(_share(self.log_densities(data))[1].sum())


def fit(data: np.ndarray, components: int, rng: np.random.Generator) -> GaussianMixture:
    """Fit a mixture of so many Gaussians to data `[n, D]`, from clusters on."""
    mixture, before = _maximise(data, np.eye(components)[:, _clusters(data, components, rng)]), -math.inf
    for _ in range(MOST_STEPS):
        share, density = _share(mixture.log_densities(data))
        mixture = _maximise(data, share)
        if abs(density.mean() - before) < TOLERANCE:
            break
        before = density.mean()
    return mixture


def _share(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share `[K, n]` of each Gaussian in the density of each row, and its logarithm `[n]`, from `[K, n]`."""
    largest = parts.max(0)
    share = np.exp(parts - largest)
    total = share.sum(0)
    return share / total, largest + np.log(total)


def _maximise(data: np.ndarray, share: np.ndarray) -> GaussianMixture:
    """Return the likeliest mixture where each Gaussian has this share `[K, n]` of the rows of data `[n, D]`."""
    total = share.sum(1) + 10 * np.finfo(float).eps  # [K]
    means = share @ data / total[:, None]
    apart = data.T[None] - means[:, :, None]  # [K, D, n]
    covariances = (share[:, None] * apart) @ apart.mT / total[:, None, None]
    return GaussianMixture(total / total.sum(), means, covariances + REGULARISER * np.eye(data.shape[1]))


def _clusters(data: np.ndarray, components: int, rng: np.random.Generator) -> np.ndarray:
    """Return to which of so many clusters each row of data `[n, D]` belongs: k-means from k-means++, int `[n]`."""
    centres = data[rng.integers(len(data), size=1)]
    while len(centres) < components:  # each new one is likely far from those that are there (Arthur et al. 2007)
        far = _distances(data, centres).min(0) + np.finfo(float).tiny  # [n]
        centres = np.concatenate([centres, data[rng.choice(len(data), 1, p=far / far.sum())]])
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
    apart = data.T[None] - centres[:, :, None]  # [K, D, n]
    return np.einsum("kdn,kdn->kn", apart, apart)
