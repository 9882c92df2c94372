"""The adversary: a learned teacher that proposes θ in one step, a bandit with a random vector z as its context.

A Gaussian squashed by tanh draws θ in [-1, 1]^D (thesis, section 4.3), or a Beta distribution does, as in CLUTR. The
vector z lets the same weights propose many different levels; the entropy bonus is measured in θ's own space, because
the entropy of the Gaussian before squashing is largest where tanh saturates, and would drive all levels into the
corners. Columns of finitely many values are chosen by a categorical each (`Mixed`). On a mixture of programs it first
chooses one, and has a distribution over θ for each (`Composed`).

It is small and learns in many steps, so what a step costs are the calls into torch, not the arithmetic. Its gradient is
therefore written out in numpy where that is short: of PPO's loss by what it is made of, and of `Squashed` and the
network; other distributions leave theirs to autograd. Read next: `levels.teacher`.
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
from ued.learning.adam import Adam
from ued.learning.networks import LOG_2_PI, MultiCategorical, linear
from ued.parameters import index_in, middle_of
from ued.resumable import Resumable

# tanh of a logistic variable of scale 1/2 is uniform on [-1, 1]; a normal of the same deviation comes close.
UNIFORM_LOG_STD = math.log(math.pi / math.sqrt(12))
LOG_STD_RANGE = (-5.0, 1.0)
BETA_EDGE = 1 - 1e-6  # θ of a Beta stays inside, where its density is finite
MOST_LOG_RATIO = 20.0  # of thousands of columns together: the exponential stays finite
MEAN_RANGE = 3.0  # tanh(3) = 0.995: beyond, θ hardly moves and gradients vanish
ENTROPY = 0.5 * (1 + LOG_2_PI) + 2 * math.log(2)  # of a normal of deviation 1, and twice the log 2 of log cosh
LOSSES = ("policy_loss", "value_loss", "entropy", "grad_norm")


class Proposals(NamedTuple):
    """What the adversary proposed, with what it needs in order to learn from it: arrays of float32.

    z `[n, Z]` the context; raw `[n, D]` what was drawn: θ before tanh, or θ itself, or the index of a value; log_prob
    `[n]` of raw.
    """

    z: np.ndarray
    raw: np.ndarray
    log_prob: np.ndarray


class Squashed:
    """θ = tanh(raw), raw from a Gaussian. Its parameters are mean and log deviation before tanh."""

    def __init__(self, one: Tensor, other: Tensor) -> None:
        self.mean = MEAN_RANGE * torch.tanh(one / MEAN_RANGE)
        self.log_std = (UNIFORM_LOG_STD + other).clamp(*LOG_STD_RANGE)
        self.std, self.dim = self.log_std.exp(), one.shape[-1]

    def sample(self, generator: torch.Generator) -> Tensor:
        return self.mean + self.std * torch.empty_like(self.mean).normal_(generator=generator)

    def log_prob(self, raw: Tensor) -> Tensor:
        square = ((raw - self.mean) / self.std).square()
        return -0.5 * LOG_2_PI * self.dim - torch.add(self.log_std, square, alpha=0.5).sum(-1)

    def theta_entropy(self, generator: torch.Generator) -> Tensor:
        """Estimate the entropy `[B]` of θ from one sample each that gradients flow through.

        H(θ) = H(raw) + E[Σ log(1 - tanh² raw)]; the largest value is D log 2, of the uniform distribution.
        """
        drawn = self.sample(generator)
        log_cosh = torch.logaddexp(drawn, -drawn)  # + log 2
        return torch.sub(self.log_std, log_cosh, alpha=2).sum(-1) + ENTROPY * self.dim

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
        real = sum(self.program_dims) if self.program_dims else int((cells == 0).sum())
        choices = len(self.program_dims) or int(cells.sum())
        self.heads = [real, real, 1, choices]  # outputs: two of each real number, the value, logits of all choices
        self.first, self.second = (linear(size, hidden, math.sqrt(2), generator) for size in (context_size, hidden))
        self.last = nn.utils.skip_init(nn.Linear, hidden, sum(self.heads))
        for head, gain in zip(self.last.weight.data.split(self.heads), (0.01, 0.01, 1.0, 0.01), strict=True):
            nn.init.orthogonal_(head, gain, generator=generator)
        nn.init.zeros_(self.last.bias)

    def forward(self, z: Tensor) -> tuple[ThetaPolicy, Tensor]:
        """Return the distributions and the regret to expect `[B]` for contexts `[B, Z]`."""
        outputs = self.last(torch.tanh(self.second(torch.tanh(self.first(z)))))
        one, other, value, logits = outputs.split(self.heads, -1)
        return self._policy((one, other), logits), value[:, 0]

    def _policy(self, real: Sequence[Tensor], logits: Tensor) -> ThetaPolicy:
        if self.program_dims:
            halves = (half.split(self.program_dims, -1) for half in real)
            parts = [self.distribution(*own) for own in zip(*halves, strict=True)]
            return Composed(logits, parts, len(self.cells))
        if not self.heads[-1]:
            return self.distribution(*real)
        values = MultiCategorical(logits, self.cells[self.cells > 0])
        return Mixed(self.distribution(*real) if self.heads[0] else None, values, self.cells)

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

    def propose(self, count: int, context: np.ndarray | None = None) -> Proposals:
        """Draw `count` proposals, from random vectors or from this context `[count, context_size]`."""
        if context is None:
            context = torch.empty(count, self.context_size).normal_(generator=self.generator).numpy()
        z = np.asarray(context, np.float32)
        return Proposals(z, *self._passes(z).sample())

    def _passes(self, z: np.ndarray) -> Autograd | WrittenOut:
        written_out = self.network.distribution is Squashed and not self.network.heads[-1]
        return (WrittenOut if written_out else Autograd)(self.network, self.generator, z)

    def theta(self, proposals: Proposals) -> np.ndarray:
        """Return the proposed θ, float64 `[n, D]` in [-1, 1]."""
        return self.network.theta(proposals.raw)

    def learn(self, proposals: Proposals, regret: np.ndarray) -> dict[str, float]:
        """Learn from the regret `[n]` of these proposals; return the means of the losses over the epochs."""
        self.scale.track(regret)
        target = self.scale(regret).astype(np.float32)
        self.optimizer.zero_grad()
        passes = self._passes(proposals.z)
        passes.look_at(proposals.raw)
        logs = np.empty((self.config.update_epochs, len(LOSSES), len(target)), np.float32)
        for log in logs:
            self._epoch(passes, proposals.log_prob, target, log)
        losses = logs.mean((0, 2), np.float64) * np.array([-1.0, 0.5, 1.0, 1.0])
        return dict(zip(LOSSES, losses.tolist(), strict=True))

    def _epoch(self, passes: Autograd | WrittenOut, before: np.ndarray, target: np.ndarray, log: np.ndarray) -> None:
        """Take a step down the gradient of: policy_loss - ent_coef * entropy + vf_coef * value_loss.

        `before` `[B]` are log-densities as proposed. Writes `[4, B]` what LOSSES are means of: -1, 1/2, 1 and 1 times.
        """
        config, count = self.config, len(target)
        now, entropy, value = passes.forward()
        log_ratio = now - before  # tanh's Jacobian is the same above and below
        bounded = log_ratio.clip(-MOST_LOG_RATIO, MOST_LOG_RATIO)
        ratio, advantage = np.exp(bounded), target - value
        gain = advantage * ratio
        worse = np.minimum(gain, advantage * ratio.clip(1 - config.clip_coef, 1 + config.clip_coef))  # [B]
        by_log_prob = gain * (gain == worse) * (bounded == log_ratio) / -count  # 0 where anything is clipped
        passes.backward(by_log_prob, -config.ent_coef / count, advantage * (-config.vf_coef / count))
        norm = self.optimizer.clip_norm(config.max_grad_norm)
        self.optimizer.step()
        log[0], log[1], log[2], log[3] = worse, advantage**2, entropy, norm.item()


class Autograd:
    """What an adversary's network proposes given `z`, what it says of proposals, and the gradient of its weights: for
    any distribution.
    """

    def __init__(self, network: AdversaryNetwork, generator: torch.Generator, z: np.ndarray) -> None:
        self.network, self.generator, self.z = network, generator, torch.as_tensor(z)

    @torch.inference_mode()
    def sample(self) -> tuple[np.ndarray, np.ndarray]:
        """Draw `raw` `[B, D]`; return it and its log-density `[B]`."""
        policy, _ = self.network(self.z)
        raw = policy.sample(self.generator)
        return raw.numpy(), policy.log_prob(raw).numpy()

    def look_at(self, raw: np.ndarray) -> None:
        """Take these `raw` `[B, D]` as proposed."""
        self.raw = torch.as_tensor(raw)

    def forward(self) -> list[np.ndarray]:
        """Return the log-density of `raw`, the entropy of θ and the regret to expect: `[B]` each."""
        policy, value = self.network(self.z)
        self.outputs = policy.log_prob(self.raw), policy.theta_entropy(self.generator), value
        return [output.detach().numpy() for output in self.outputs]

    def backward(self, by_log_prob: np.ndarray, by_entropy: float, by_value: np.ndarray) -> None:
        """Write down the gradient of all weights, given those by what `forward` returned last: of entropy the same for
        each row, of the others `[B]`.
        """
        self.network.zero_grad(set_to_none=False)
        gradients = by_log_prob, np.full_like(by_value, by_entropy), by_value
        torch.autograd.backward(self.outputs, [torch.as_tensor(gradient) for gradient in gradients])


class WrittenOut:
    """The same for `Squashed`, by hand and in numpy, whose calls are a third as long as torch's.

    Each column of θ is a row here, `[D, B]`: over many short rows calls take several times as long.
    """

    def __init__(self, network: AdversaryNetwork, generator: torch.Generator, z: np.ndarray) -> None:
        self.generator, self.layers = generator, (network.first, network.second, network.last)
        self.weights = [(layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in self.layers]
        self.dim, self.z = network.heads[0], z

    def sample(self) -> tuple[np.ndarray, np.ndarray]:
        """See `Autograd` and `Squashed`."""
        mean, log_std, _ = self._outputs()
        raw = mean + self.std * self._noise()
        return np.ascontiguousarray(raw.T), self._log_prob(raw, mean, log_std)

    def look_at(self, raw: np.ndarray) -> None:
        """See `Autograd`."""
        self.raw = np.ascontiguousarray(raw.T)
        parts = [(layer.weight.grad, layer.bias.grad) for layer in self.layers]  # of the optimizer's vector
        self.gradients = [tuple(part.numpy() for part in pair if part is not None) for pair in parts]
        self.ones = np.ones(len(raw), np.float32)  # sums over rows are products with them: a fifth of the time

    def forward(self) -> list[np.ndarray]:
        """See `Autograd` and `Squashed`."""
        mean, log_std, value = self._outputs()
        self.deviation = self.std * self._noise()
        drawn = mean + self.deviation
        self.theta = np.tanh(drawn)
        entropy = (log_std - 2 * np.log(2 * np.cosh(drawn))).sum(0) + ENTROPY * self.dim
        return [self._log_prob(self.raw, mean, log_std), entropy, value]

    def _outputs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return mean and log deviation before tanh `[D, B]` and the regret to expect `[B]`."""
        self.seen = [self.z]  # by each layer
        for weight, bias in self.weights[:-1]:
            free = self.seen[-1] @ weight.T
            free += bias
            self.seen.append(np.tanh(free, out=free))
        weight, bias = self.weights[-1]
        outputs = weight @ self.seen[-1].T + bias[:, None]  # [2 D + 1, B]
        one, other, value = outputs[: self.dim], outputs[self.dim : -1], outputs[-1]
        self.bent, free = np.tanh(one / MEAN_RANGE), UNIFORM_LOG_STD + other
        log_std = free.clip(*LOG_STD_RANGE)
        self.std, self.unclipped = np.exp(log_std), free == log_std
        return MEAN_RANGE * self.bent, log_std, value

    def _noise(self) -> np.ndarray:
        """Draw it as `Squashed` does: `[D, B]`."""
        return torch.empty(len(self.z), self.dim).normal_(generator=self.generator).numpy().T

    def _log_prob(self, raw: np.ndarray, mean: np.ndarray, log_std: np.ndarray) -> np.ndarray:
        self.standard = (raw - mean) / self.std
        return -0.5 * LOG_2_PI * self.dim - (log_std + 0.5 * self.standard**2).sum(0)

    def backward(self, by_log_prob: np.ndarray, by_entropy: float, by_value: np.ndarray) -> None:
        """See `Autograd`.

        The derivatives of log N by mean and log σ are s / σ and s² - 1, s = (raw - mean) / σ. That of log(1 - tanh² x)
        is -2 tanh x, and those of x = mean + σ noise are 1 and σ noise.
        """
        slope = -2 * by_entropy * self.theta
        by_mean = by_log_prob * self.standard / self.std + slope
        by_log_std = by_log_prob * (self.standard**2 - 1) + slope * self.deviation + by_entropy
        by_one = by_mean * (1 - self.bent**2)
        gradient = np.concatenate([by_one, by_log_std * self.unclipped, by_value[None]]).T
        for layer in (2, 1, 0):
            by_weight, by_bias = self.gradients[layer]
            np.matmul(gradient.T, self.seen[layer], out=by_weight)
            np.matmul(self.ones, gradient, out=by_bias)
            if layer:
                gradient = gradient @ self.weights[layer][0] * (1 - self.seen[layer] ** 2)


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
