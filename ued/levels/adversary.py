"""The adversary: a learned teacher that proposes θ in one step, a bandit with a random vector z as its context.

The vector z lets the same weights propose many different levels. What a proposal earns is its score, and the bonus for
entropy: less, the more often it is proposed than the program would draw it. So without a difference in scores the
program's own distribution is best, for choices as for real numbers, and the bonus needs no formula for the entropy.
Read next: `levels.theta_distribution`, what it draws from; `levels.teacher`, what it is part of.
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

MOST_LOG_RATIO = 20.0  # of thousands of columns together: the exponential stays finite
LOSSES = ("policy_loss", "value_loss", "grad_norm")


class Proposals(NamedTuple):
    """What the adversary proposed, with what it needs in order to learn from it: arrays of float32.

    z `[n, Z]` the context; raw `[n, D]` what was drawn, see `ThetaDistribution`; log_prob `[n]` the logarithm of how
    much denser raw is than in the program's own distribution.
    """

    z: np.ndarray
    raw: np.ndarray
    log_prob: np.ndarray


class Adversary(Resumable):
    """Proposes levels and learns from the score that they caused, by PPO's clipped objective on one-step episodes.

    Args:
        draws: the columns of θ; a number D: as many real numbers.
        config: its distribution, network and learning.
        generator: of its weights and draws.
        context_size: entries of the context where this is no random vector; see `propose`.
        program_parameters: of a mixture, the columns of each program.

    Raises `ValueError` where there is nothing to propose (D = 0).
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
                "there is nothing for an adversary to choose: the environment has no free parameters (theta has 0 "
                "columns); use domain randomization, or give the program a random value"
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

    @torch.inference_mode()
    def propose(self, count: int, context: np.ndarray | None = None) -> Proposals:
        """Draw `count` proposals, from random vectors or from this context `[count, context_size]`."""
        if context is None:
            context = torch.empty(count, self.context_size).normal_(generator=self.generator).numpy()
        z = np.asarray(context, np.float32)
        raw, log_prob = self.network.sample(torch.as_tensor(z), self.generator)
        return Proposals(z, raw.numpy(), log_prob.numpy())

    def theta(self, proposals: Proposals) -> np.ndarray:
        """Return the proposed θ, float64 `[n, D]` in [-1, 1]."""
        return self.network.theta(proposals.raw)

    def learn(self, proposals: Proposals, score: np.ndarray) -> dict[str, float]:
        """Learn from the score `[n]` of these proposals; return losses, means over the epochs, and the entropy of θ.

        The entropy is estimated from the proposals, in nats: D log 2 is the program's own distribution.
        """
        self.scale.track(score)
        earned = self.scale(score) - self.config.ent_coef * proposals.log_prob
        batch = [torch.as_tensor(np.asarray(part, np.float32)) for part in (*proposals, earned)]
        logs = [self._epoch(*batch) for _ in range(self.config.update_epochs)]
        entropy = self.dim * math.log(2) - float(proposals.log_prob.mean(dtype=np.float64))
        return dict(zip(LOSSES, np.mean(logs, 0).tolist(), strict=True)) | {"entropy": entropy}

    def _epoch(self, z: Tensor, raw: Tensor, before: Tensor, earned: Tensor) -> tuple[float, ...]:
        """Take a step down the gradient of: policy_loss + vf_coef * value_loss. `before` `[n]`: as proposed."""
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
        """Take back what `state_dict` returned. Raises `ValueError` for another distribution or other columns."""
        own = {name: tuple(weight.shape) for name, weight in self.network.state_dict().items()}
        saved = {name: tuple(weight.shape) for name, weight in state["network"].items()}
        if own != saved:
            raise ValueError(
                f"the saved adversary has other weights ({', '.join(sorted(saved))}) than the distribution "
                f"{self.config.distribution!r} over these {self.dim} columns of theta ({', '.join(sorted(own))})"
            )
        super().load_state_dict(state)


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
