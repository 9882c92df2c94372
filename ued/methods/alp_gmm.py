"""ALP-GMM (Portelas et al. 2019, Algorithm 1): levels are drawn where returns have been changing.

    repeat
        with probability 0.2, or in the beginning: draw θ uniformly
        else: draw a Gaussian of the mixture in proportion to its mean progress, and θ from it
        play an episode; absolute learning progress ALP(θ) = |return - return of the nearest θ before|
        every 250 episodes: fit Gaussian mixtures to the last 250 (θ, ALP), keep the best by Akaike's criterion

The mixtures are scikit-learn's: `pip install 'regista[gmm]'`. Read next: `methods.paired`.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from ued.config import ALPGMMConfig, PPOConfig
from ued.curriculum import LevelSpace, LevelStock
from ued.levels.record import Origin, make_trials, trial_dtype
from ued.training import BLOCK, Training
from ued.upomdp import UPOMDP, level_dtype

TRIES = 32  # to draw a valid θ from a Gaussian before it is drawn uniformly
REMEMBERED = 10_000  # episodes among which the nearest is sought


class ALPLevels:
    """Proposes levels of high learning progress. A `Curriculum`.

    Args:
        space: what levels there are.
        config: how often mixtures are fitted, how much is random.
        seed: of all draws.

    Raises `ImportError` without scikit-learn, `ValueError` where the environment has no free parameters.
    """

    def __init__(self, space: LevelSpace, config: ALPGMMConfig, seed: int = 0) -> None:
        if not space.theta_dim:
            raise ValueError("there is nothing to choose: the environment has no free parameters; use dr")
        try:
            import sklearn.mixture  # noqa: F401
        except ImportError as error:
            raise ImportError("alp_gmm needs scikit-learn: pip install 'regista[gmm]'") from error
        self.space, self.config = space, config
        self.dtype = trial_dtype(level_dtype(space.theta_dim))
        self.stock = LevelStock(space)
        self.rng = np.random.default_rng(seed)
        self.theta = np.zeros((0, space.theta_dim))  # of the episodes so far, in their order
        self.returns = np.zeros(0)
        self.progress = np.zeros(0)  # ALP of each
        self.unfitted = 0  # episodes since the last fit
        self.mixture: dict[str, np.ndarray] | None = None  # weights [K], means [K, D], covariances [K, D, D]

    def propose(self, count: int) -> np.ndarray:
        """Draw levels from the mixture, some uniformly."""
        levels = self.stock.take(count)
        if self.mixture is not None:
            focused = self.rng.random(count) >= self.config.random_share
            theta, found = self._from_mixture(int(focused.sum()))
            levels[np.flatnonzero(focused)[found]] = self.space.make_levels(theta[found])
        else:
            focused = np.zeros(count, bool)
        trials = make_trials(self.dtype, levels, Origin.RANDOM)
        trials["origin"][focused] = Origin.PROPOSED
        return trials

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Note the progress of each episode; fit the mixture when enough are new."""
        for theta, value in zip(trials["level"]["theta"], trials["returns"][:, 0, 0], strict=True):
            self._note(theta, value)
        trials["score"] = self.progress[len(self.progress) - len(trials) :]
        if self.unfitted >= self.config.fit_every:
            self._fit()
        components = 0 if self.mixture is None else len(self.mixture["weights"])
        return {
            "alp/components": float(components),
            "alp/progress": float(self.progress[-250:].mean()) if len(self.progress) else 0.0,
        }

    def _note(self, theta: np.ndarray, value: float) -> None:
        nearest = np.argmin(((self.theta - theta) ** 2).sum(1)) if len(self.theta) else None
        alp = 0.0 if nearest is None else abs(value - self.returns[nearest])
        self.theta = np.concatenate([self.theta, theta[None]])[-REMEMBERED:]
        self.returns = np.append(self.returns, value)[-REMEMBERED:]
        self.progress = np.append(self.progress, alp)[-REMEMBERED:]
        self.unfitted += 1

    def _fit(self) -> None:
        """Fit mixtures of 2 and more Gaussians to (θ, ALP) of the last episodes; keep the best."""
        from sklearn.mixture import GaussianMixture
        from threadpoolctl import threadpool_limits

        last = slice(-self.config.fit_every, None)
        reach = max(float(np.ptp(self.returns[last])), 1e-6)
        data = np.column_stack([self.theta[last], 2 * self.progress[last] / reach])
        fits = []
        with warnings.catch_warnings(), threadpool_limits(1):  # so little data: threads only get in each other's way
            warnings.simplefilter("ignore")  # of fits that have not converged: Akaike's criterion judges them
            for components in range(min(2, self.config.max_components), self.config.max_components + 1):
                seed = int(self.rng.integers(2**31))
                fits.append(GaussianMixture(components, random_state=seed, reg_covar=1e-5).fit(data))
        best = min(fits, key=lambda fit: fit.aic(data))
        weight = np.maximum(best.means_[:, -1], 0.0)
        weight = weight / weight.sum() if weight.sum() > 0 else np.full(len(weight), 1 / len(weight))
        self.mixture = {"weights": weight, "means": best.means_[:, :-1], "covariances": best.covariances_[:, :-1, :-1]}
        self.unfitted = 0

    def _from_mixture(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Draw θ `[count, D]` within the box; say which rows are valid."""
        assert self.mixture is not None
        theta, found = np.zeros((count, self.space.theta_dim)), np.zeros(count, bool)
        for _ in range(TRIES):
            rows = np.flatnonzero(~found)
            if not len(rows):
                break
            which = self.rng.choice(len(self.mixture["weights"]), len(rows), p=self.mixture["weights"])
            draws = [
                self.rng.multivariate_normal(self.mixture["means"][k], self.mixture["covariances"][k], method="eigh")
                for k in which
            ]
            theta[rows] = np.clip(np.array(draws), -1.0, 1.0)
            found[rows] = self.space.valid(theta[rows])
        return theta, found

    def state_dict(self) -> dict[str, Any]:
        """Give everything that changes."""
        names = "theta", "returns", "progress"
        state: dict[str, Any] = {name: getattr(self, name).copy() for name in names}
        mixture = None if self.mixture is None else {name: value.copy() for name, value in self.mixture.items()}
        return state | {
            "stock": self.stock.levels.copy(),
            "rng": self.rng.bit_generator.state,
            "unfitted": self.unfitted,
            "mixture": mixture,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        for name in ("theta", "returns", "progress"):
            setattr(self, name, state[name].copy())
        self.stock.levels, self.rng.bit_generator.state = state["stock"].copy(), state["rng"]
        self.unfitted, self.mixture = state["unfitted"], state["mixture"]


class ALPGMM(Training):
    """Trains one student on levels of high learning progress. A `Method`; see `Training` for the arguments."""

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: ALPGMMConfig | None = None, seed: int = 0
    ) -> None:
        config = config or ALPGMMConfig()
        super().__init__(upomdp, lambda space, seed: ALPLevels(space, config, seed), ppo, seed, block=BLOCK)
