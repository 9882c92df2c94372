"""Minibatches of PPO: a rollout as rows, its sequences in batches, and the gradient of several policies.

What is shuffled is the student's business: single steps, or whole sequences of one environment for a recurrent student
(see `learning.memory`). Read next: `learning.ppo`, which learns from minibatches.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from ued.learning.fast_adam import Adam, clip_norm
from ued.learning.memory import Past
from ued.learning.rollout import Rollout
from ued.learning.student import Student


@dataclass
class Batch:
    """The steps of a rollout, one row each; `[B, A, ...]` for A agents.

    A minibatch of sequences holds the observations of all their steps, and the other columns of the steps to learn
    from.
    """

    past: Past  # which rows follow each other
    observation: Tensor  # [B, size]
    action: Tensor  # [B] or [B, K]
    log_prob: Tensor  # [B]
    value: Tensor  # [B]
    advantage: Tensor  # [B]
    target: Tensor  # [B]

    @classmethod
    def of(cls, rollout: Rollout, advantage: Tensor, target: Tensor) -> Batch:
        """Flatten `[T, N, ...]` to `[T * N, ...]`."""
        columns = rollout.observation, rollout.action, rollout.log_prob, rollout.value, advantage, target
        past = Past(rollout.memory, rollout.episode_starts.flatten(), rollout.train.flatten())
        return cls(past, *(column.flatten(0, 1) for column in columns))

    def to(self, device: torch.device) -> Batch:
        """Return the batch on a device. All columns are copied at once, from pinned memory.

        Observations are there already; see `learning.upload`.
        """
        if device.type == "cpu":
            return self
        past, observation, *rest = (getattr(self, field.name) for field in fields(self))
        past, rest = ([part.pin_memory().to(device, non_blocking=True) for part in columns] for columns in (past, rest))
        return Batch(Past(*past), observation.to(device), *rest)

    def minibatches(self, sequences: Tensor, size: int) -> Iterator[Batch]:
        """Yield minibatches of `size` of these sequences `[S, L]` of row numbers, step by step.

        Row r belongs to environment r modulo N. Rows are gathered once for all minibatches: many small gathers take
        longer than one large one.
        """
        memory, episode_begins, train = self.past
        assert episode_begins is not None and train is not None
        parts = [part.T for part in sequences.split(size)]  # [L, B] each
        sizes = [part.numel() for part in parts]
        rows = torch.cat([part.flatten() for part in parts])  # [S * L]
        memories = memory.index_select(0, sequences[:, 0] % len(memory)).split(size)  # [B, W] each
        begins, masks = (
            column.index_select(0, rows).split(sizes) for column in (episode_begins, train)
        )  # [L * B] each
        observation, *rest = (getattr(self, field.name) for field in fields(self)[1:])
        observations = observation.index_select(0, rows).split(sizes)
        learned, counts = rows[train[rows]], [int(mask.sum()) for mask in masks]
        columns = zip(*(column.index_select(0, learned).split(counts) for column in rest), strict=True)
        pieces = zip(parts, memories, begins, masks, observations, columns, strict=True)
        for part, start, begin, mask, observation, others in pieces:
            yield Batch(Past(start, begin.view(part.shape), mask), observation, *others)


def clip_gradient(student: Student, optimizer: Adam, max_norm: float) -> Tensor:
    """Scale the student's gradient down to this norm; return its norm `[]` before that.

    The gradients of several policies are clipped one by one, and so is that of a shared critic; the norm returned is
    their mean. Losses are means over agents, so the gradient of one agent's own policy is multiplied by the number of
    policies first: each policy learns as if it were alone.
    """
    if student.policies == 1:
        return optimizer.clip_norm(max_norm)
    own, common = student.parameters_apart
    norms, count = [clip_norm(common, max_norm).view(1)] if common else [], student.policies
    shares = [weight.grad.reshape(count, -1) for weight in own if weight.grad is not None]
    norm = count * torch.stack([share.norm(dim=1) for share in shares]).norm(dim=0)  # [A]
    factor = count * (max_norm / (norm + 1e-6)).clamp(max=1.0)
    for weight in own:
        if weight.grad is not None:
            weight.grad.view(count, -1).mul_(factor[:, None])
    return torch.cat([*norms, norm]).mean()


def by_agent(name: str, values: Tensor) -> dict[str, float]:
    """Return the per-agent means of values `[B, A]` by metric name; nothing for a single agent `[B]`."""
    means = values.mean(0).tolist() if values.ndim > 1 else []
    return {f"agent_{agent}/{name}": mean for agent, mean in enumerate(means)}
