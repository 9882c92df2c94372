"""The novelty of a level: how unlikely the student's state-action pairs on it are, given those that it learned from.

CENIE (Teoh et al. 2024) models past pairs by a mixture of Gaussians and calls the mean of -log p(observation, action)
over the steps on a level its novelty. Read next: `levels.novelty_buffer`, which ranks levels by it.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import torch
from gymnasium.spaces import Space
from torch import Tensor
from torch.nn.functional import one_hot

from ued.config import CoverageConfig
from ued.core.resumable import Resumable
from ued.learning.networks import choices_of
from ued.learning.rollout import Rollout
from ued.learning.value_stats import NAMES, EpisodeValues
from ued.levels.gaussian_mixture import GaussianMixture, fit, products_of

CLIP = 10.0  # of a column's distance from the mean of the window, in its scale
LEAST_SCALE = 0.1  # of the range of a column in the window: rare values of it do not become arbitrarily far
REGULARISER = 0.1  # added to variances, of a window that has about 1: a new value in one cluster does not decide alone
COUNTS = (2, 4, 8, 16, 32, 64)  # of Gaussians, among which the silhouette chooses
LEAST_ROWS = 8  # per Gaussian
JUDGED = 256  # rows whose silhouettes choose
BLOCK = 1 << 20  # numbers of a block of rows whose density is computed together


class Coverage(Resumable):
    """A window of state-action pairs, the first in the first out, and the mixture fitted to it.

    Columns are centered and divided by their deviation in the window when the mixture is fitted. Covariances are
    diagonal, which keeps the cost linear in the number of columns.

    Args:
        columns: D, of a pair.
        config: size of the window, how often the mixture is fitted.
        seed: of the pairs kept and of the clusters that fitting begins with.
    """

    state_fields = ("pairs", "rng", "age", "mixture")
    optional_fields: ClassVar = {"mixture": dict}

    def __init__(self, columns: int, config: CoverageConfig, seed: int) -> None:
        self.config, self.rng = config, np.random.default_rng(seed)
        self.pairs = np.zeros((0, columns), np.float32)  # [n, D]
        self.age = 0  # updates with new pairs since the last fit
        self.mixture: dict[str, np.ndarray] | None = None  # center and scale `[D]`, and fields of a GaussianMixture

    @property
    def components(self) -> int:
        """Number of Gaussians; 0 before the first fit."""
        return 0 if self.mixture is None else len(self.mixture["weights"])

    def choose(self, count: int) -> np.ndarray:
        """Return which of `count` pairs to keep, at most `pairs_per_update` of them: their indices, in order."""
        return np.sort(self.rng.permutation(count)[: self.config.pairs_per_update])

    def remember(self, pairs: np.ndarray) -> None:
        """Put pairs `[m, D]` into the window in the place of the oldest ones."""
        self.pairs = np.concatenate([self.pairs, pairs.astype(np.float32)])[-self.config.window :]
        self.age += len(pairs) > 0

    def novelty(self, pairs: np.ndarray) -> np.ndarray:
        """Return -log p of pairs `[n, D]` in nats, for columns in the scale of the window: `[n]`. Needs a mixture."""
        assert self.mixture is not None
        parts = dict(self.mixture)
        centre, scale = parts.pop("center"), parts.pop("scale")
        mixture, rows = GaussianMixture(**parts), max(1, BLOCK // (1 + 2 * pairs.shape[1]))
        blocks = [pairs[start : start + rows] for start in range(0, len(pairs), rows)]
        return np.concatenate(
            [
                _unlikelihood(mixture.log_densities(products_of(_scaled(block, centre, scale), False)))
                for block in blocks
            ]
        )

    def refit(self) -> None:
        """Fit the mixture to the window if it is due; at first as soon as the window has enough pairs."""
        due = self.config.fit_every if self.mixture is not None else 1
        most = min(self.config.max_components, len(self.pairs) // LEAST_ROWS)
        counts = [count for count in COUNTS if count <= most]
        if self.age < due or not counts:
            return
        centre = self.pairs.mean(0)
        scale = np.maximum(self.pairs.std(0), LEAST_SCALE * np.ptp(self.pairs, 0))
        scale[scale == 0] = 1.0  # it is constant in the window
        rows = _scaled(self.pairs, centre, scale).astype(np.float64)
        mixtures = fit(rows, counts, self.rng, False, REGULARISER)
        judged = rows[self.rng.permutation(len(rows))[:JUDGED]]
        best = max(mixtures, key=lambda mixture: silhouette(judged, _nearest(mixture, judged)))
        found = {name: getattr(best, name) for name in ("weights", "means", "covariances")}
        self.mixture, self.age = found | {"center": centre, "scale": scale}, 0


class EpisodeNovelty(EpisodeValues):
    """Follows episodes as `EpisodeValues`, and the novelty of their state-action pairs; grows the coverage.

    The novelty of an episode is the mean over its steps, and over agents, of that of a pair under the mixture of the
    time; inf for an episode with steps before the first mixture. Afterwards, pairs of the rollout from which students
    learn enter the window.

    Args:
        num_envs: N.
        coverage: of past pairs.
        action_space: of one agent.
    """

    names = (*NAMES, "novelty")

    def __init__(self, num_envs: int, coverage: Coverage, action_space: Space) -> None:
        super().__init__(num_envs)
        self.coverage, self.choices = coverage, choices_of(action_space)

    def per_step(self, rollout: Rollout, advantages: Tensor) -> Tensor:
        """Return the statistics of `EpisodeValues`, and the novelty of each pair; 0 before the first mixture."""
        found, novelty = super().per_step(rollout, advantages), torch.zeros(rollout.value.shape)
        if self.coverage.components:
            pairs = state_actions(rollout, torch.ones(rollout.value.shape, dtype=torch.bool), self.choices)
            novelty = torch.as_tensor(self.coverage.novelty(pairs.numpy()), dtype=torch.float32).view(novelty.shape)
        return torch.cat([found, novelty[None]])

    def track(self, rollout: Rollout, advantages: Tensor) -> dict[str, np.ndarray]:
        """See `EpisodeValues.track`."""
        found = super().track(rollout, advantages)
        if not self.coverage.components:  # nothing was learned from so far, so all is new
            found["novelty"][:] = self.sums[-1] = np.inf
        by_agent = rollout.train if rollout.value.ndim == 2 else rollout.train[..., None].expand_as(rollout.value)
        learned = by_agent.nonzero()
        kept = torch.zeros_like(by_agent)
        kept[tuple(learned[torch.as_tensor(self.coverage.choose(len(learned)))].T)] = True
        self.coverage.remember(state_actions(rollout, kept, self.choices).numpy())
        return found


def state_actions(rollout: Rollout, where: Tensor, choices: np.ndarray) -> Tensor:
    """Return the state-action pairs of agents at steps `where`, bool `[T, N]` or `[T, N, A]`: float32 `[n, D]`.

    Observations are flat; a choice among K values is K columns, of which one is 1.
    """
    seen = rollout.observation[where.to(rollout.observation.device)].flatten(1).float().cpu()
    action = rollout.action[where]
    if not len(choices):
        return torch.cat([seen, action.view(len(seen), -1)], 1)
    columns = action.view(len(seen), len(choices)).unbind(1)
    return torch.cat([seen, *(one_hot(column, int(k)) for column, k in zip(columns, choices, strict=True))], 1)


def silhouette(rows: np.ndarray, labels: np.ndarray) -> float:
    """Return the mean silhouette of rows `[n, D]` in clusters `labels` `[n]` (Rousseeuw 1987); -1 for one cluster.

    The silhouette of a row is (b - a) / max(a, b), with a the mean distance to its own cluster and b that to the
    nearest other one; 0 for a cluster of one row.
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


def _scaled(pairs: np.ndarray, centre: np.ndarray, scale: np.ndarray) -> np.ndarray:
    return np.clip((pairs - centre) / scale, -CLIP, CLIP)


def _unlikelihood(parts: np.ndarray) -> np.ndarray:
    """Return -log of the sum over Gaussians of densities, whose logs are `[K, n]`: `[n]`."""
    most = parts.max(0)
    return -(most + np.log(np.exp(parts - most).sum(0)))
