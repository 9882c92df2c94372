"""The novelty of a level: the negative log-likelihood of its state-action pairs under a model of past pairs.

CENIE (Teoh et al. 2024) models past pairs by a mixture of Gaussians. The novelty of a level is the mean of
-log p(observation, action) over the steps on it. Read next: `levels.novelty_buffer`, which ranks levels by it.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
import torch
from gymnasium.spaces import Space
from torch import Tensor

from ued.config import CoverageConfig
from ued.core.resumable import Resumable
from ued.learning.networks import choices_of
from ued.learning.rollout import Rollout
from ued.learning.value_stats import NAMES, EpisodeValues
from ued.levels.gaussian_mixture import GaussianMixture, fit, products_of

CLIP = 10.0  # limit of a column's distance from the mean of the window, in units of its scale
LEAST_SCALE = 0.1  # share of the range of a column in the window: limits the distance of rare values
REGULARISER = 0.1  # added to variances (about 1 in the window): limits the effect of a single new value
COUNTS = (2, 4, 8, 16, 32, 64)  # numbers of Gaussians to select from, by silhouette
LEAST_ROWS = 8  # minimum number of rows per Gaussian
JUDGED = 256  # rows from which the silhouette is computed
BLOCK = 1 << 18  # numbers in a block of rows whose densities are computed together, so that it fits into the cache


class Coverage(Resumable):
    """A first-in-first-out window of state-action pairs, and the mixture fitted to it.

    Columns are centered and divided by their deviation in the window when the mixture is fitted. Covariances are
    diagonal, which keeps the cost linear in the number of columns.

    Args:
        columns: D, the number of columns of a pair.
        config: size of the window, and the interval between fits.
        seed: seed of the choice of stored pairs and of the initial clusters of a fit.
    """

    state_fields = ("pairs", "rng", "updates", "fitted", "mixture")
    optional_fields: ClassVar = {"mixture": dict}

    def __init__(self, columns: int, config: CoverageConfig, seed: int) -> None:
        self.config, self.rng = config, np.random.default_rng(seed)
        self.pairs = np.zeros((0, columns), np.float32)  # [n, D]
        self.updates = self.fitted = 0  # updates with pairs, so far and at the last fit
        self.mixture: dict[str, np.ndarray] | None = None  # center and scale `[D]`, and fields of a GaussianMixture

    @property
    def components(self) -> int:
        """Number of Gaussians; 0 before the first fit."""
        return 0 if self.mixture is None else len(self.mixture["weights"])

    def choose(self, count: int) -> np.ndarray:
        """Return the indices of the pairs to store, ascending: at most `pairs_per_update` of `count`."""
        return np.sort(self.rng.permutation(count)[: self.config.pairs_per_update])

    def remember(self, pairs: np.ndarray) -> None:
        """Add pairs `[m, D]` to the window in place of the oldest pairs."""
        self.pairs = np.concatenate([self.pairs, pairs.astype(np.float32)])[-self.config.window :]
        self.updates += len(pairs) > 0

    def novelty(self, pairs: np.ndarray) -> np.ndarray:
        """Return -log p of pairs `[n, D]` in nats, for columns in the scale of the window: `[n]`. Needs a mixture."""
        assert self.mixture is not None
        parts = {name: part.astype(np.float32) for name, part in self.mixture.items()}  # half the time of float64
        center, scale = parts.pop("center"), parts.pop("scale")
        mixture, rows = GaussianMixture(**parts), max(1, BLOCK // pairs.shape[1])
        blocks = [pairs[start : start + rows] for start in range(0, len(pairs), rows)]
        return np.concatenate([_unlikelihood(_log_densities(mixture, _scaled(each, center, scale))) for each in blocks])

    def refit(self) -> None:
        """Refit the mixture to the window after `fit_every` updates, or when the number of updates has doubled."""
        most = min(self.config.max_components, len(self.pairs) // LEAST_ROWS)
        counts = [count for count in COUNTS if count <= most]
        if not counts or self.updates - self.fitted < max(1, min(self.config.fit_every, self.fitted)):
            return
        center = self.pairs.mean(0)
        scale = np.maximum(self.pairs.std(0), LEAST_SCALE * np.ptp(self.pairs, 0))
        scale[scale == 0] = 1.0  # constant columns
        rows = _scaled(self.pairs, center, scale).astype(np.float64)
        mixtures = fit(rows, counts, self.rng, False, REGULARISER)
        judged = rows[self.rng.permutation(len(rows))[:JUDGED]]
        best = max(mixtures, key=lambda mixture: silhouette(judged, _nearest(mixture, judged)))
        found = {name: getattr(best, name) for name in ("weights", "means", "covariances")}
        self.mixture, self.fitted = found | {"center": center, "scale": scale}, self.updates


class EpisodeNovelty(EpisodeValues):
    """`EpisodeValues` that also follows the novelty of state-action pairs and adds pairs to the coverage.

    The novelty of an episode is the mean novelty of its pairs, over steps and agents, under the mixture at that time;
    inf for an episode with steps before the first mixture. Then the training pairs of the rollout enter the window.

    Args:
        num_envs: N.
        coverage: coverage of past pairs.
        action_space: action space of one agent.
        negative, agents: see `EpisodeValues`.
    """

    names = (*NAMES, "novelty")

    def __init__(
        self,
        num_envs: int,
        coverage: Coverage,
        action_space: Space,
        negative: bool = False,
        agents: int | None = None,
    ) -> None:
        super().__init__(num_envs, negative, agents)
        self.coverage, self.choices = coverage, choices_of(action_space)

    def per_step(self, rollout: Rollout, advantages: Tensor) -> Tensor:
        """Return the statistics of `EpisodeValues`, and the novelty of each pair; 0 before the first mixture."""
        found, novelty = super().per_step(rollout, advantages), torch.zeros(rollout.value.shape)
        if self.coverage.components:
            per_pair = self.coverage.novelty(state_actions(rollout, self.choices))
            novelty = torch.as_tensor(per_pair).view(novelty.shape)
        return torch.cat([found, novelty[None]])

    def track(self, rollout: Rollout, advantages: Tensor, negative: Tensor | None = None) -> dict[str, np.ndarray]:
        """See `EpisodeValues.track`."""
        found = super().track(rollout, advantages, negative)
        if not self.coverage.components:  # no mixture yet, so all pairs are novel
            found["novelty"][:] = self.sums[len(NAMES)] = np.inf
        by_agent = rollout.train if rollout.value.ndim == 2 else rollout.train[..., None].expand_as(rollout.value)
        learned = by_agent.flatten().nonzero()[:, 0]
        kept = learned[torch.as_tensor(self.coverage.choose(len(learned)))]
        self.coverage.remember(state_actions(rollout, self.choices, kept))
        return found


def state_actions(rollout: Rollout, choices: np.ndarray, rows: Tensor | None = None) -> np.ndarray:
    """Return the state-action pairs of all agents at all steps, in the order of `rollout.value`: float32 `[n, D]`.

    Observations are flat; a choice among K values, as in `networks.choices_of`, is a one-hot of K columns. `rows`
    selects among the pairs.
    """
    count = rollout.value.numel()
    seen, action = rollout.observation.reshape(count, -1), rollout.action.reshape(count, -1)
    if rows is not None:
        seen, action = seen[rows.to(seen.device)], action[rows]
    size = seen.shape[1]
    pairs = torch.zeros(len(seen), size + int(choices.sum() or action.shape[1]))
    pairs[:, :size] = seen
    if len(choices):
        first = torch.as_tensor(size + np.cumsum(choices) - choices)
        pairs.scatter_(1, first + action, 1.0)
    else:
        pairs[:, size:] = action
    return pairs.numpy()


def silhouette(rows: np.ndarray, labels: np.ndarray) -> float:
    """Return the mean silhouette of rows `[n, D]` in clusters `labels` `[n]` (Rousseeuw 1987); -1 for one cluster.

    The silhouette of a row is (b - a) / max(a, b); it is 0 for a cluster of one row. a is the mean distance to its
    own cluster, b the mean distance to the nearest other cluster.
    """
    _, which, sizes = np.unique(labels, return_inverse=True, return_counts=True)
    if len(sizes) < 2:
        return -1.0
    squares = (rows**2).sum(1)
    distance = np.sqrt(np.maximum(squares[:, None] + squares - 2 * rows @ rows.T, 0.0))
    total = distance @ np.eye(len(sizes))[which]  # [n, clusters]
    index, own = np.arange(len(rows)), sizes[which]
    inside = total[index, which] / np.maximum(own - 1, 1)
    total[index, which] = np.inf
    outside = (total / sizes).min(1)
    worth = (outside - inside) / np.maximum(np.maximum(outside, inside), np.finfo(float).tiny)
    return float(np.where(own > 1, worth, 0.0).mean())


def _nearest(mixture: GaussianMixture, rows: np.ndarray) -> np.ndarray:
    """Return the Gaussian `[n]` to which each row `[n, D]` most likely belongs."""
    return mixture.log_densities(products_of(rows, False)).argmax(0)


def _scaled(pairs: np.ndarray, center: np.ndarray, scale: np.ndarray) -> np.ndarray:
    rows = pairs - center
    rows *= 1 / scale
    return np.clip(rows, -CLIP, CLIP, out=rows)


def _log_densities(mixture: GaussianMixture, rows: np.ndarray) -> np.ndarray:
    """Return `GaussianMixture.log_densities` `[K, n]` of rows `[n, D]`; the rows are squared in place."""
    precision = 1 / mixture.covariances
    slope = mixture.means * precision
    constant = np.log(mixture.weights) + 0.5 * (np.log(precision) - math.log(2 * math.pi) - mixture.means * slope).sum(
        1
    )
    parts = slope @ rows.T + constant[:, None]
    parts -= 0.5 * precision @ np.square(rows, out=rows).T
    return parts


def _unlikelihood(parts: np.ndarray) -> np.ndarray:
    """Return -log of the sum of densities over Gaussians `[n]`, given the log-densities `[K, n]`."""
    most = parts.max(0)
    return -(most + np.log(np.exp(parts - most).sum(0)))
