"""Unimodal distributions over θ: the tanh Gaussian of the thesis (section 4.3), and the Beta policy of CLUTR.

Both treat every column as a real number, including choices. An option is then an interval of θ, and its position in
the program's list matters. Options at an end are easy to reach by moving the mean; options in the middle are hard to
reach. These distributions are a baseline for `levels.theta_distribution`. Read next: `levels.adversary`.
"""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import softplus

from ued.learning.networks import LOG_2_PI, linear

# tanh of a logistic variable with scale 1/2 is uniform on [-1, 1]; a normal with the same deviation is close to it.
UNIFORM_LOG_STD = math.log(math.pi / math.sqrt(12))
LOG_STD_RANGE = (-5.0, 1.0)
BETA_EDGE = 1 - 1e-6  # bound of θ under a Beta, which keeps its density finite
MEAN_RANGE = 3.0  # tanh(3) = 0.995; gradients vanish beyond


class TanhGaussian:
    """θ = tanh(raw) with Gaussian raw. The parameters are its mean and log standard deviation."""

    def __init__(self, one: Tensor, other: Tensor) -> None:
        self.mean = MEAN_RANGE * torch.tanh(one / MEAN_RANGE)
        self.log_std = (UNIFORM_LOG_STD + other).clamp(*LOG_STD_RANGE)

    def sample(self, generator: torch.Generator) -> Tensor:
        return self.mean + self.log_std.exp() * torch.empty_like(self.mean).normal_(generator=generator)

    def log_prob(self, raw: Tensor) -> Tensor:
        """Return the log-density `[B]` of θ, relative to the uniform: log(1 - tanh²) = 2 (log 2 - logaddexp(x, -x))."""
        standard = (raw - self.mean) / self.log_std.exp()
        gaussian = -0.5 * (standard.square() + LOG_2_PI) - self.log_std
        return (gaussian + 2 * torch.logaddexp(raw, -raw) - math.log(2)).sum(-1)

    @staticmethod
    def theta(raw: np.ndarray) -> np.ndarray:
        return np.tanh(raw.astype(np.float64))


class Beta:
    """θ = raw = 2 b - 1 with b from a Beta distribution, both parameters above 1: unimodal (Chou et al. 2017)."""

    def __init__(self, one: Tensor, other: Tensor) -> None:
        # Both parameters are initially close to 1, the uniform distribution.
        alpha, beta = (1 + softplus(4 * x - 3) for x in (one, other))
        self.beta = torch.distributions.Beta(alpha, beta, validate_args=False)

    def sample(self, generator: torch.Generator) -> Tensor:
        one, other = (
            torch._standard_gamma(c, generator=generator) for c in (self.beta.concentration1, self.beta.concentration0)
        )
        return (2 * one / (one + other) - 1).clamp(-BETA_EDGE, BETA_EDGE)

    def log_prob(self, raw: Tensor) -> Tensor:
        """Return the log-density `[B]` of θ, relative to the uniform."""
        return self.beta.log_prob((raw + 1) / 2).sum(-1)

    @staticmethod
    def theta(raw: np.ndarray) -> np.ndarray:
        return raw.astype(np.float64)


UNIMODAL: dict[str, type[TanhGaussian] | type[Beta]] = {"tanh_gaussian": TanhGaussian, "beta": Beta}


class Unimodal(nn.Module):
    """z `[B, Z]` -> a unimodal distribution for each of D columns, and the expected score; as `ThetaDistribution`."""

    def __init__(self, name: str, dim: int, context_size: int, hidden: int, generator: torch.Generator) -> None:
        super().__init__()
        self.family, self.dim = UNIMODAL[name], dim
        self.first, self.second = (linear(size, hidden, math.sqrt(2), generator) for size in (context_size, hidden))
        self.hump = linear(hidden, 2 * dim, 0.01, generator)
        self.value = linear(hidden, 1, 1.0, generator)

    def sample(self, z: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Sample `raw` `[B, D]`; return it with its relative log-density `[B]`."""
        policy, _ = self._humps(z)
        raw = policy.sample(generator)
        return raw, policy.log_prob(raw)

    def forward(self, z: Tensor, raw: Tensor) -> tuple[Tensor, Tensor]:
        """Return the relative log-density `[B]` of `raw` `[B, D]`, and the expected score `[B]`."""
        policy, value = self._humps(z)
        return policy.log_prob(raw), value

    def theta(self, raw: np.ndarray) -> np.ndarray:
        """Return θ float64 `[n, D]` of samples."""
        return self.family.theta(raw)

    def _humps(self, z: Tensor) -> tuple[TanhGaussian | Beta, Tensor]:
        h = torch.tanh(self.second(torch.tanh(self.first(z))))
        return self.family(*self.hump(h).split(self.dim, -1)), self.value(h)[:, 0]
