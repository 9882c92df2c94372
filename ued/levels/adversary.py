"""The adversary: a learned teacher that proposes θ in one step, a bandit with a random vector z as its context.

A Gaussian squashed by tanh draws θ in [-1, 1]^D (thesis, section 4.3), or a Beta distribution does, as in CLUTR. The
vector z lets the same weights propose many different levels; the entropy bonus is measured in θ's own space, because
the entropy of the Gaussian before squashing is largest where tanh saturates, and would drive all levels into the
corners. Columns of finitely many values are chosen by a categorical each (`Mixed`). On a mixture of programs it first
chooses one, and has a distribution over θ for each (`Composed`). Read next: `levels.teacher`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import softplus

from ued.config import AdversaryConfig
from ued.learning.adam import Adam, clip_norm
from ued.learning.networks import Gaussian, MultiCategorical, linear, mlp
from ued.parameters import index_in, middle_of
from ued.resumable import Resumable

# tanh of a logistic variable of scale 1/2 is uniform on [-1, 1]; a normal of the same deviation comes close.
UNIFORM_LOG_STD = math.log(math.pi / math.sqrt(12))
LOG_STD_RANGE = (-5.0, 1.0)
BETA_EDGE = 1 - 1e-6  # θ of a Beta stays inside, where its density is finite
MOST_LOG_RATIO = 20.0  # of thousands of columns together: the exponential stays finite
MEAN_RANGE = 3.0  # tanh(3) = 0.995: beyond, θ hardly moves and gradients vanish


class Proposals(NamedTuple):
    """What the adversary proposed, with what it needs in order to learn from it: arrays of float32.

    z `[n, Z]` the context; raw `[n, D]` what was drawn: θ before tanh, or θ itself, or the index of a value; log_prob
    `[n]` of raw.
    """

    z: np.ndarray
    raw: np.ndarray
    log_prob: np.ndarray


class Squashed(Gaussian):
    """θ = tanh(raw), raw from a Gaussian. Its parameters are mean and log deviation before tanh."""

    def __init__(self, one: Tensor, other: Tensor) -> None:
        mean = MEAN_RANGE * torch.tanh(one / MEAN_RANGE)
        super().__init__(mean, (UNIFORM_LOG_STD + other).clamp(*LOG_STD_RANGE))
        self.dim = mean.shape[-1]

    def theta_entropy(self, generator: torch.Generator) -> Tensor:
        """Estimate the entropy `[B]` of θ from one sample each that gradients flow through.

        H(θ) = H(raw) + E[Σ log(1 - tanh² raw)]; the largest value is D log 2, of the uniform distribution.
        """
        raw = self.sample(generator)
        return self.entropy() + (2 * (math.log(2) - raw - softplus(-2 * raw))).sum(-1)

    @staticmethod
    def theta(raw: np.ndarray) -> np.ndarray:
        """Return θ `[n, D]` for what was drawn."""
        return np.tanh(raw.astype(np.float64))


class Beta:
    """θ = raw = 2 b - 1, each b from a Beta distribution with both parameters above 1: one hump (Chou et al. 2017)."""

    def __init__(self, one: Tensor, other: Tensor) -> None:
        # Both parameters begin near 1, which is uniform.
        alpha, beta = (1 + softplus(4 * x - 3) for x in (one, other))
        self.beta = torch.distributions.Beta(alpha, beta, validate_args=False)
        self.dim = one.shape[-1]

    def sample(self, generator: torch.Generator) -> Tensor:
        one, other = (
            torch._standard_gamma(c, generator=generator) for c in (self.beta.concentration1, self.beta.concentration0)
        )
        return (2 * one / (one + other) - 1).clamp(-BETA_EDGE, BETA_EDGE)

    def log_prob(self, raw: Tensor) -> Tensor:
        return (self.beta.log_prob((raw + 1) / 2) - math.log(2)).sum(-1)

    def theta_entropy(self, generator: torch.Generator) -> Tensor:
        """Return the entropy `[B]` of θ, exactly."""
        return (self.beta.entropy() + math.log(2)).sum(-1)

    @staticmethod
    def theta(raw: np.ndarray) -> np.ndarray:
        """Return θ `[n, D]` for what was drawn."""
        return raw.astype(np.float64)


DISTRIBUTIONS: dict[str, type[Squashed] | type[Beta]] = {"squashed": Squashed, "beta": Beta}


class Mixed:
    """θ of real numbers and of values: one distribution for the columns of each sort."""

    def __init__(self, real: Squashed | Beta | None, values: MultiCategorical, cells: np.ndarray) -> None:
        self.real, self.values, self.some = real, values, torch.as_tensor(cells > 0)
        self.excess = float(np.log(2 / cells[cells > 0]).sum())  # of the entropy in θ's space over that of the values

    def sample(self, generator: torch.Generator) -> Tensor:
        chosen = self.values.sample(generator).float()
        raw = chosen.new_empty(len(chosen), len(self.some))
        raw[:, self.some] = chosen
        if self.real is not None:
            raw[:, ~self.some] = self.real.sample(generator)
        return raw

    def log_prob(self, raw: Tensor) -> Tensor:
        log_prob = self.values.log_prob(raw[:, self.some].long())
        return log_prob if self.real is None else log_prob + self.real.log_prob(raw[:, ~self.some])

    def theta_entropy(self, generator: torch.Generator) -> Tensor:
        """Return the entropy `[B]` of θ, of values as if each was spread over its cell: D log 2 at most."""
        entropy = self.values.entropy() + self.excess
        return entropy if self.real is None else entropy + self.real.theta_entropy(generator)


class Composed:
    """θ of a mixture of K programs: column 0 says which, then come that program's own columns; see `ued.mixture`.

    `raw` is the same: θ's column 0 as it is, the middle of the program's share, and what was drawn for the others, 0
    where the program has none. Entropies are of both choices: at most log K and the mean of the programs' D log 2.

    Args:
        logits: `[B, K]` of the programs.
        parts: the K programs' distributions over their own columns.
        width: of `raw`.
    """

    def __init__(self, logits: Tensor, parts: Sequence[Squashed | Beta], width: int) -> None:
        self.log_share = logits.log_softmax(-1)
        self.parts, self.width = parts, width

    def sample(self, generator: torch.Generator) -> Tensor:
        program = torch.multinomial(self.log_share.exp(), 1, generator=generator)  # [B, 1]
        raw = torch.zeros(len(program), self.width)
        raw[:, :1] = middle_of(program, len(self.parts))
        for k, part in enumerate(self.parts):
            own = part.sample(generator)  # [B, D_k]
            raw[:, 1 : 1 + own.shape[1]] = torch.where(program == k, own, raw[:, 1 : 1 + own.shape[1]])
        return raw

    def log_prob(self, raw: Tensor) -> Tensor:
        program = torch.as_tensor(index_in(raw[:, :1].numpy(), len(self.parts)))  # [B, 1]
        own = [part.log_prob(raw[:, 1 : 1 + part.dim]) for part in self.parts]
        return (self.log_share + torch.stack(own, 1)).gather(1, program)[:, 0]

    def theta_entropy(self, generator: torch.Generator) -> Tensor:
        """Return the entropy `[B]` of the choice, and of θ given it."""
        within = torch.stack([part.theta_entropy(generator) for part in self.parts], 1)  # [B, K]
        return (self.log_share.exp() * (within - self.log_share)).sum(1)


ThetaPolicy = Squashed | Beta | Mixed | Composed  # a distribution over θ for each row of a batch, drawn as `raw` [B, D]


class AdversaryNetwork(nn.Module):
    """z `[B, Z]` -> a distribution over θ, and the regret to expect `[B]`, in normalised units.

    `cells` `[D]` says of how many values each column is chosen, 0: a real number. On a mixture, `program_dims` are its
    programs' numbers of columns: each has heads of its own, and one chooses.
    """

    def __init__(
        self,
        cells: np.ndarray,
        config: AdversaryConfig,
        generator: torch.Generator,
        context_size: int,
        program_dims: Sequence[int] = (),
    ) -> None:
        super().__init__()
        self.distribution, hidden = DISTRIBUTIONS[config.distribution], config.hidden_size
        self.cells, self.program_dims = cells, tuple(program_dims)
        self.torso = mlp(context_size, hidden, 2, generator)
        real = sum(self.program_dims) if self.program_dims else int((cells == 0).sum())
        self.heads = nn.ModuleList(linear(hidden, real, 0.01, generator) for _ in range(2 if real else 0))
        self.value = linear(hidden, 1, 1.0, generator)
        choices = len(self.program_dims) or int(cells.sum())
        self.choice = linear(hidden, choices, 0.01, generator) if choices else None

    def forward(self, z: Tensor) -> tuple[ThetaPolicy, Tensor]:
        """Return the distributions and the regret to expect `[B]` for contexts `[B, Z]`."""
        features = self.torso(z)
        policy = self._policy(features, [head(features) for head in self.heads])
        return policy, self.value(features)[:, 0]

    def _policy(self, features: Tensor, heads: list[Tensor]) -> ThetaPolicy:
        if self.program_dims:
            assert self.choice is not None
            nothing = [features[:, :0]] * 2  # programs without free parameters: there is only which to choose
            halves = (half.split(self.program_dims, -1) for half in heads or nothing)
            parts = [self.distribution(*own) for own in zip(*halves, strict=True)]
            return Composed(self.choice(features), parts, len(self.cells))
        if self.choice is None:
            return self.distribution(*heads)
        values = MultiCategorical(self.choice(features), self.cells[self.cells > 0])
        return Mixed(self.distribution(*heads) if heads else None, values, self.cells)

    def theta(self, raw: np.ndarray) -> np.ndarray:
        """Return θ `[n, D]` for what was drawn: of values the middle of the cell."""
        theta, some = self.distribution.theta(raw), self.cells > 0
        if self.program_dims:
            theta[:, 0] = raw[:, 0]
            return theta
        theta[:, some] = middle_of(raw[:, some].astype(np.float64), self.cells[some])
        return theta


class Adversary(Resumable):
    """Proposes levels and learns from the regret that they caused, by PPO's clipped objective on one-step episodes.

    Args:
        dim: D, or for each of the D columns how many values it has, 0 for a real number; see `categories_of`.
        config: its network and its learning.
        generator: of its weights and draws.
        context_size: entries of the context where this is no random vector; see `propose`.
        program_dims: of a mixture, the number of columns of each program.

    Raises `ValueError` where there is nothing to propose (D = 0).
    """

    state_fields = ("network", "optimizer", "generator", "scale")

    def __init__(
        self,
        dim: int | np.ndarray,
        config: AdversaryConfig,
        generator: torch.Generator,
        context_size: int | None = None,
        program_dims: Sequence[int] = (),
    ) -> None:
        cells = np.zeros(dim, np.int64) if isinstance(dim, int) else dim
        if not len(cells):
            raise ValueError(
                "there is nothing for an adversary to choose: the environment has no free parameters (theta has 0 "
                "columns); use domain randomisation, or give the program a random value"
            )
        self.dim, self.config, self.generator = len(cells), config, generator
        self.context_size = context_size or config.context_size
        self.network = AdversaryNetwork(cells, config, generator, self.context_size, program_dims)
        self.optimizer = Adam(self.network.parameters(), config.learning_rate, config.adam_eps)
        self.scale = RunningScale()

    @torch.inference_mode()
    def propose(self, count: int, context: np.ndarray | None = None) -> Proposals:
        """Draw `count` proposals, from random vectors or from this context `[count, context_size]`."""
        if context is None:
            z = torch.empty(count, self.context_size).normal_(generator=self.generator)
        else:
            z = torch.as_tensor(context, dtype=torch.float32)
        policy, _ = self.network(z)
        raw = policy.sample(self.generator)
        return Proposals(z.numpy(), raw.numpy(), policy.log_prob(raw).numpy())

    def theta(self, proposals: Proposals) -> np.ndarray:
        """Return the proposed θ, float64 `[n, D]` in [-1, 1]."""
        return self.network.theta(proposals.raw)

    def learn(self, proposals: Proposals, regret: np.ndarray) -> dict[str, float]:
        """Learn from the regret `[n]` of these proposals; return the means of the losses over the epochs."""
        self.scale.track(regret)
        target = torch.as_tensor(self.scale(regret), dtype=torch.float32)
        z, raw, log_prob = (torch.as_tensor(a) for a in (proposals.z, proposals.raw, proposals.log_prob))
        logs = [self._epoch(z, raw, log_prob, target) for _ in range(self.config.update_epochs)]
        return {name: sum(log[name] for log in logs) / len(logs) for name in logs[0]}

    def _epoch(self, z: Tensor, raw: Tensor, log_prob: Tensor, target: Tensor) -> dict[str, float]:
        config = self.config
        policy, value = self.network(z)
        log_ratio = policy.log_prob(raw) - log_prob  # tanh's Jacobian is the same above and below
        ratio = log_ratio.clamp(-MOST_LOG_RATIO, MOST_LOG_RATIO).exp()
        advantage = target - value.detach()
        clipped = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)
        policy_loss = -torch.min(advantage * ratio, advantage * clipped).mean()
        value_loss = 0.5 * ((value - target) ** 2).mean()
        entropy = policy.theta_entropy(self.generator).mean()
        loss = policy_loss - config.ent_coef * entropy + config.vf_coef * value_loss
        self.optimizer.zero_grad()
        loss.backward()
        grad_norm = clip_norm(self.optimizer.weights, config.max_grad_norm)
        self.optimizer.step()
        return {
            "policy_loss": policy_loss.item(),
            "value_loss": value_loss.item(),
            "entropy": entropy.item(),
            "grad_norm": grad_norm.item(),
        }


class RunningScale(Resumable):
    """Shift and scale numbers by mean and deviation of the recent past, which forgets as students change."""

    DECAY = 0.9  # per batch
    state_fields = ("mean", "square", "weight")

    def __init__(self) -> None:
        self.mean = self.square = self.weight = 0.0  # of an average that starts at 0 and is corrected for that

    def track(self, values: np.ndarray) -> None:
        """Take a batch into the statistics."""
        self.mean = self.DECAY * self.mean + (1 - self.DECAY) * float(values.mean())
        self.square = self.DECAY * self.square + (1 - self.DECAY) * float((values**2).mean())
        self.weight = self.DECAY * self.weight + (1 - self.DECAY)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        mean, square = self.mean / self.weight, self.square / self.weight
        return (values - mean) / (max(square - mean**2, 0.0) ** 0.5 + 1e-3)
