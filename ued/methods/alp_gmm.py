"""ALP-GMM (Portelas et al. 2019, Algorithm 1): levels are sampled in regions of high learning progress.

    repeat
        with probability 0.2, or at the start: draw θ uniformly
        else: draw a Gaussian of the mixture in proportion to its mean progress, and θ from it
        play an episode; absolute learning progress ALP(θ) = |return - return of the nearest previous θ|
        every 250 episodes: fit Gaussian mixtures to the last 250 (θ, ALP), keep the best by Akaike's criterion

In a fit, ALP is divided by half the range of these returns, so that it has the scale of θ. (The authors scale returns
by user-specified bounds.) The nearest θ is searched in the last 10,000 episodes. An invalid θ is drawn again.
Read next: `levels.gaussian_mixture`, then `methods.paired`.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ued.config import ALPGMMConfig
from ued.core.curriculum import LevelSpace, RandomLevelPool, need_vector
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.levels.gaussian_mixture import GaussianMixture, aic, fit
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records
from ued.methods.method import Method

TRIES = 32  # attempts to draw a valid θ from a Gaussian before a uniform draw
REMEMBERED = 10_000  # previous episodes in the search for the nearest θ
BLOCK = 8  # episodes whose distances are computed together, so that they fit into the cache
LATER = np.triu(np.ones((BLOCK, BLOCK), bool))  # [BLOCK, BLOCK] whether an episode is no earlier than another


class ALPGMM(Method):
    """Trains one student on levels of high learning progress; see `Method` for the arguments.

    Raises:
        ValueError: if the environment has no free parameters.
    """

    curriculum: ALPGMMCurriculum

    def setup(self, config: ALPGMMConfig | None, seed: int) -> None:
        self.curriculum = ALPGMMCurriculum(self.upomdp, config or ALPGMMConfig(), seed)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play levels of the mixture and random levels; compute progress; refit the mixture if due; learn."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # progress of each episode; refit the mixture if due
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class ALPGMMCurriculum(Resumable):
    """A `Curriculum` that proposes levels of high learning progress.

    Args:
        space: the space of levels.
        config: interval between fits, and share of random levels.
        seed: seed of all draws.

    Raises:
        ValueError: if the environment has no free parameters.
    """

    state_fields = ("pool", "rng", "theta", "returns", "progress", "unfitted", "mixture")
    optional_fields: ClassVar = {"mixture": dict}

    def __init__(self, space: LevelSpace, config: ALPGMMConfig, seed: int = 0) -> None:
        need_vector(space)
        self.space, self.config = space, config
        self.dtype = level_record_dtype(level_dtype(space.theta_dim))
        self.pool = RandomLevelPool(space)
        self.rng = np.random.default_rng(seed)
        self.theta = np.zeros((0, space.theta_dim))  # θ of the episodes so far, in their order
        self.returns = np.zeros(0)
        self.progress = np.zeros(0)  # ALP of each episode
        self.unfitted = 0  # episodes since the last fit
        self.mixture: dict[str, np.ndarray] | None = None  # weights, means and covariances

    def propose(self, count: int) -> np.ndarray:
        """Draw levels from the mixture, some uniformly."""
        levels, focused = np.zeros(count, self.dtype["level"]), np.zeros(count, bool)
        if self.mixture is not None:
            focused = self.rng.random(count) >= self.config.random_share
            theta, valid = self._from_mixture(int(focused.sum()))
            focused[focused] = valid
            levels[focused] = self.space.make_levels(theta[valid])
        levels[~focused] = self.pool.take(int((~focused).sum()))
        records = make_records(self.dtype, levels, Origin.RANDOM)
        records["origin"][focused] = Origin.PROPOSED
        return records

    def _progress_of(self, records: np.ndarray) -> np.ndarray:
        """Return the absolute learning progress `[L]` of the episodes on these levels, and store them."""
        theta = np.concatenate([self.theta, records["level"]["theta"]])  # [n + L, D]
        returns = np.concatenate([self.returns, records["returns"][:, 0, 0]])  # [n + L]
        progress = np.abs(returns[len(self.theta) :] - returns[_nearest(theta, len(self.theta))])
        self.theta, self.returns = theta[-REMEMBERED:], returns[-REMEMBERED:]
        self.progress = np.concatenate([self.progress, progress])[-REMEMBERED:]
        self.unfitted += len(records)
        return progress

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score each level by its progress; refit the mixture after `fit_every` new episodes."""
        records["score"] = self._progress_of(records)
        if self.unfitted >= self.config.fit_every:
            self._fit()
        components = 0 if self.mixture is None else len(self.mixture["weights"])
        return {
            "alp/components": float(components),
            "alp/progress": float(self.progress[-250:].mean()) if len(self.progress) else 0.0,
        }

    def _fit(self) -> None:
        """Fit mixtures of 2 and more Gaussians to (θ, ALP) of the last episodes; keep the best."""
        last, most = slice(-self.config.fit_every, None), self.config.max_components
        reach = max(float(np.ptp(self.returns[last])), 1e-6)
        data = np.column_stack([self.theta[last], 2 * self.progress[last] / reach])
        mixtures = fit(data, range(min(2, most), most + 1), self.rng)
        best = mixtures[aic(mixtures, data).argmin()]
        weight = np.maximum(best.means[:, -1], 0.0)
        weight = weight / weight.sum() if weight.sum() > 0 else np.full(len(weight), 1 / len(weight))
        self.mixture = vars(best.marginal(self.space.theta_dim)) | {"weights": weight}
        self.unfitted = 0

    def _from_mixture(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Draw θ `[count, D]` within the box; return it with the mask of valid rows, bool `[count]`."""
        assert self.mixture is not None
        theta, valid = np.zeros((count, self.space.theta_dim)), np.zeros(count, bool)
        mixture = GaussianMixture(**self.mixture)
        for _ in range(TRIES):
            rows = np.flatnonzero(~valid)
            if not len(rows):
                break
            theta[rows] = np.clip(mixture.sample(len(rows), self.rng), -1.0, 1.0)
            valid[rows] = self.space.valid(theta[rows])
        return theta, valid


def _nearest(theta: np.ndarray, first: int) -> np.ndarray:
    """Return for each episode from `first` on the previous episode with the nearest θ `[n, D]`: int `[n - first]`.

    Only the last REMEMBERED episodes count; the very first episode is its own. float32 halves the time.
    """
    nearest, last = [np.zeros(0, np.int64)], theta[first:]
    others = np.column_stack([theta, 0.5 * (theta**2).sum(1)]).astype(np.float32).T.copy()  # [D + 1, n]
    rows = np.column_stack([-last, np.ones(len(last))]).astype(np.float32)  # [n - first, D + 1]
    for start in range(first, len(theta), BLOCK):
        end = min(start + BLOCK, len(theta))
        oldest, count = max(0, end - REMEMBERED), end - start
        # half its square, up to a constant of the row
        distance = rows[start - first : end - first] @ others[:, oldest:end]
        np.copyto(distance[:, -count:], np.inf, where=LATER[:count, :count])
        nearest.append(oldest + distance.argmin(1))
    return np.concatenate(nearest)
