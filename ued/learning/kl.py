"""KL regularizers: a KL divergence in PPO's loss keeps a student close to another policy.

Read next: `learning.ppo`, which adds it; `methods.paired`, which regularizes its students toward each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from ued.learning.minibatches import Batch
from ued.learning.networks import Policy
from ued.learning.student import Student


@dataclass(frozen=True)
class KLRegularizer:
    """A policy toward which a student is regularized (behavior cloning of Mediratta et al. 2023, 4.2)."""

    student: Student
    coef: float

    def divergence(self, batch: Batch, policy: Policy) -> Tensor:
        """Return KL(other ‖ policy) `[]`, the mean over the minibatch; gradients flow only into `policy`.

        A recurrent `student` plays in other environments, so it starts each sequence with an empty memory.
        """
        memory = self.student.empty_memory(len(batch.past.memory)).to(self.student.device)
        with torch.no_grad():
            other, _ = self.student(batch.observation, batch.past._replace(memory=memory))
        return other.kl(policy).mean()


@dataclass(frozen=True)
class AnnealedKL:
    """A regularizer whose coefficient falls linearly to 0 over the first `env_steps`."""

    student: Student
    coef: float
    env_steps: int

    def at(self, env_steps: int) -> KLRegularizer | None:
        """Return the regularizer after `env_steps` steps; None once its coefficient is 0."""
        left = 1.0 - env_steps / self.env_steps if self.env_steps else 0.0
        return KLRegularizer(self.student, self.coef * left) if left > 0 and self.coef else None
