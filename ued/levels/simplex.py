"""The distribution over levels that NCC learns: gradient ascent on the truncated simplex.

    g_i = score_i - alpha (log y_i + 1)                            gradient of E_y[score] + alpha H(y)
    m = 0.9 m + 0.1 g,  v = 0.999 v + 0.001 g^2                    its moments
    y = project(y + eta m / (1 - 0.9^t) / (v^0.4 / sqrt(1 - 0.999^t) + 1e-5))

This is the step of TiAda for the maximizing player (Li et al. 2023) in its form with moments, as in the code of NCC.
Step size and smallest probability are relative to 1 / K: 28 / K and 0.04 / K are those of the authors for K = 4,000.
Fixed scores lead to y ~ exp(score / alpha). Where second moments differ, y is biased; this bias fades by a factor of e
in 5,000 steps.
Read next: `methods.ncc`.
"""

from __future__ import annotations

import numpy as np

from ued.config import NCCConfig
from ued.core.resumable import Resumable

DECAY, SQUARE_DECAY = 0.9, 0.999  # decays of the moments
POWER = 0.4  # exponent of the second moment, as for the maximizing player in TiAda
STEP_EPSILON, LOG_EPSILON = 1e-5, 1e-6
ROUNDING = 1e-9


def project_to_simplex(point: np.ndarray, least: float) -> np.ndarray:
    """Return the nearest point `[K]` to `point` `[K]` whose entries are at least `least` and add up to 1.

    It is max(point + shift, least), where the largest entries determine the shift (Held et al. 1974).
    Raises `ValueError` if K entries of at least `least` add up to more than 1.
    """
    free = 1 - least * len(point)  # the rest to distribute
    if free < -ROUNDING:
        raise ValueError(f"{len(point)} numbers of at least {least} add up to more than 1")
    falling = np.sort(point - least)[::-1]
    shifts = (max(free, 0.0) - np.cumsum(falling)) / np.arange(1, len(point) + 1)
    above = max(1, int(np.count_nonzero(falling + shifts > 0)))  # number of entries above `least`
    return np.asarray(np.maximum(point - least + shifts[above - 1], 0.0) + least)


class SimplexAscent(Resumable):
    """A distribution y over K levels that maximizes E_y[score] + alpha H(y) by gradient ascent.

    Args:
        config: step size, alpha, and the uniform share of the probability.
    """

    state_fields = ("y", "mean", "square", "steps")

    def __init__(self, config: NCCConfig) -> None:
        self.config = config
        self.y = np.zeros(0)  # [K]
        self.mean, self.square = np.zeros(0), np.zeros(0)  # [K] moments of the gradient
        self.steps = 0

    def add(self) -> None:
        """Add a level with the mean probability and the mean moments of the others."""
        count = len(self.y) + 1
        self.y = np.append(self.y * (1 - 1 / count), 1 / count)
        for name in ("mean", "square"):
            moments = getattr(self, name)
            setattr(self, name, np.append(moments, moments.mean() if len(moments) else 0.0))

    def gradient(self, score: np.ndarray) -> np.ndarray:
        """Return the gradient `[K]` of the objective for these scores `[K]`."""
        y = self.y
        return score - self.config.ent_coef * (np.log(y + LOG_EPSILON) + y / (y + LOG_EPSILON))

    def step(self, score: np.ndarray) -> None:
        """Take one ascent step, given the scores `[K]` of all levels."""
        gradient = self.gradient(score)
        self.steps += 1
        self.mean = DECAY * self.mean + (1 - DECAY) * gradient
        self.square = SQUARE_DECAY * self.square + (1 - SQUARE_DECAY) * gradient**2
        scale = self.square**POWER / np.sqrt(1 - SQUARE_DECAY**self.steps) + STEP_EPSILON
        rate, least = self.config.learning_rate / len(self.y), self.config.floor / len(self.y)
        self.y = project_to_simplex(self.y + rate * self.mean / (1 - DECAY**self.steps) / scale, least)

    @property
    def entropy(self) -> float:
        """The entropy of y in nats."""
        y = self.y[self.y > 0]
        return float(-(y * np.log(y)).sum())
