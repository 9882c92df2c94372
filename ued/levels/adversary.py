"""The adversary: a learned teacher that proposes θ in one step, a bandit with a random vector z as its context.

The vector z lets the same weights propose many different levels. The reward of a proposal is its score plus an entropy
bonus, the negative log-density relative to the program's distribution. If all scores are equal, the program's
distribution is therefore optimal, for choices and real numbers. No closed form of the entropy is needed.
Read next: `levels.theta_distribution`, the distribution; `levels.teacher`, which contains the adversary;
`levels.builder`, an adversary of many steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from ued.config import AdversaryConfig
from ued.core.parameters import Parameter, numbered
from ued.core.resumable import Resumable
from ued.learning.fast_adam import Adam
from ued.levels.theta_distribution import ThetaDistribution
from ued.levels.unimodal import Unimodal

MOST_LOG_RATIO = 20.0  # keeps the exponential finite for thousands of columns
LOSSES = ("policy_loss", "value_loss", "grad_norm")


class Proposals(NamedTuple):
    """Proposals of the adversary with the data for learning: float32 arrays.

    z `[n, Z]`: context; raw `[n, D]`: samples, see `ThetaDistribution`; log_prob `[n]`: log-density of raw relative to
    the program's distribution.
    """

    z: np.ndarray
    raw: np.ndarray
    log_prob: np.ndarray


class Adversary(Resumable):
    """Proposes levels and learns from their scores, by PPO's clipped objective on one-step episodes.

    Args:
        draws: the columns of θ; an integer D means D real numbers.
        config: its distribution, network and learning.
        generator: random generator of weights and samples.
        context_size: size of the context if it is not a random vector; see `propose`.
        program_parameters: for a mixture, the columns of each program.

    Raises:
        ValueError: without free parameters (D = 0).
    """

    state_fields = ("network", "optimizer", "generator", "scale")

    def __init__(
        self,
        draws: int | Sequence[Parameter],
        config: AdversaryConfig,
        generator: torch.Generator,
        context_size: int | None = None,
        program_parameters: Sequence[Sequence[Parameter]] = (),
    ) -> None:
        columns = numbered("theta", draws) if isinstance(draws, int) else draws
        if not columns:
            raise ValueError(
                "an adversary has no parameters to choose: theta has 0 columns; use domain randomization, or give "
                "the program a random value"
            )
        self.dim, self.config, self.generator = len(columns), config, generator
        size, hidden = context_size or config.context_size, config.hidden_size
        self.context_size = size
        self.network: ThetaDistribution | Unimodal = (
            ThetaDistribution(columns, program_parameters, size, hidden, generator)
            if config.distribution == "program"
            else Unimodal(config.distribution, self.dim, size, hidden, generator)
        )
        self.optimizer = Adam(self.network.parameters(), config.learning_rate, config.adam_eps)
        self.scale = RunningScale()

    @property
    def record_fields(self) -> list[tuple[Any, ...]]:
        """The fields of a level record that hold a proposal: the fields of `Proposals`."""
        return [
            ("z", np.float32, (self.context_size,)),
            ("raw", np.float32, (self.dim,)),
            ("log_prob", np.float32),
        ]

    def read(self, records: np.ndarray) -> Proposals:
        """Return the proposals in these fields of level records `[n]`."""
        return Proposals(*(np.ascontiguousarray(records[name]) for name in Proposals._fields))

    @torch.inference_mode()
    def propose(self, count: int, context: np.ndarray | None = None) -> Proposals:
        """Sample `count` proposals, from random vectors or from this context `[count, context_size]`."""
        if context is None:
            context = torch.empty(count, self.context_size).normal_(generator=self.generator).numpy()
        z = np.asarray(context, np.float32)
        raw, log_prob = self.network.sample(torch.as_tensor(z), self.generator)
        return Proposals(z, raw.numpy(), log_prob.numpy())

    def theta(self, proposals: Proposals) -> np.ndarray:
        """Return the proposed θ, float64 `[n, D]` in [-1, 1]."""
        return self.network.theta(proposals.raw)

    def learn(self, proposals: Proposals, score: np.ndarray) -> dict[str, float]:
        """Update on the scores `[n]` of these proposals; return losses, averaged over epochs, and the entropy of θ.

        The entropy is estimated from the proposals, in nats; the program's distribution has D log 2. `gradient_steps`
        is the number of epochs.
        """
        self.scale.track(score)
        earned = self.scale(score) - self.config.ent_coef * proposals.log_prob
        batch = [torch.as_tensor(np.asarray(part, np.float32)) for part in (*proposals, earned)]
        logs = [self._epoch(*batch) for _ in range(self.config.update_epochs)]
        entropy = self.dim * math.log(2) - float(proposals.log_prob.mean(dtype=np.float64))
        losses = dict(zip(LOSSES, np.mean(logs, 0).tolist(), strict=True))
        return losses | {"entropy": entropy, "gradient_steps": float(len(logs))}

    def _epoch(self, z: Tensor, raw: Tensor, before: Tensor, earned: Tensor) -> tuple[float, ...]:
        """Take a gradient step on policy_loss + vf_coef * value_loss. `before` `[n]`: log-densities when proposed."""
        config = self.config
        self.optimizer.zero_grad()
        now, value = self.network(z, raw)
        error = earned - value
        advantage = error.detach()
        ratio = (now - before).clamp(-MOST_LOG_RATIO, MOST_LOG_RATIO).exp()
        bounded = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)
        policy_loss = -torch.minimum(ratio * advantage, bounded * advantage).mean()
        value_loss = 0.5 * error.square().mean()
        (policy_loss + config.vf_coef * value_loss).backward()
        norm = self.optimizer.clip_norm(config.max_grad_norm)
        self.optimizer.step()
        return policy_loss.item(), value_loss.item(), norm.item()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        Raises:
            ValueError: the state of another kind of adversary, distribution, or columns.
        """
        if "network" not in state:
            raise ValueError("the saved adversary builds levels (builder = steps), this one chooses them in one step")
        own = {name: tuple(weight.shape) for name, weight in self.network.state_dict().items()}
        saved = {name: tuple(weight.shape) for name, weight in state["network"].items()}
        if own != saved:
            raise ValueError(
                f"the saved adversary has other weights ({', '.join(sorted(saved))}) than the distribution "
                f"{self.config.distribution!r} over these {self.dim} columns of theta ({', '.join(sorted(own))})"
            )
        super().load_state_dict(state)


class RunningScale(Resumable):
    """Normalize numbers by a decaying mean and standard deviation, which adapts as students change."""

    DECAY = 0.9  # per batch
    state_fields = ("mean", "square", "weight")

    def __init__(self) -> None:
        self.mean = self.square = self.weight = 0.0  # moving averages, initialized at 0 with bias correction

    def track(self, values: np.ndarray) -> None:
        """Update the statistics with a batch."""
        self.mean = self.DECAY * self.mean + (1 - self.DECAY) * float(values.mean())
        self.square = self.DECAY * self.square + (1 - self.DECAY) * float((values**2).mean())
        self.weight = self.DECAY * self.weight + (1 - self.DECAY)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        mean, square = self.mean / self.weight, self.square / self.weight
        return (values - mean) / (max(square - mean**2, 0.0) ** 0.5 + 1e-3)
