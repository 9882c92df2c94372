"""Minibatches of PPO: a rollout as rows, its sequences in batches, and the gradient of several policies.

The student's memory determines the shuffled units: single steps, or whole sequences of one environment for a recurrent
student (see `learning.memory`). Read next: `learning.ppo`, which learns from minibatches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from ued.learning.fast_adam import Adam, clip_norm
from ued.learning.memory import Past
from ued.learning.recurrence import steps_to_learn
from ued.learning.rollout import Rollout
from ued.learning.student import Student


@dataclass
class Batch:
    """The steps of a rollout, one row each; `[B, A, ...]` for A agents.

    A minibatch of sequences holds the observations of training steps and of the steps before them in their episodes.
    It holds the other columns of training steps only.
    """

    past: Past  # the sequences of the rows; before the split into minibatches, its memory is [pieces, N, W]
    rollout: Tensor  # [T * N, size] observations
    rows: Tensor | None  # [B] of the rollout; None: all
    seen: Tensor | None  # [B, size] normalized observations; None: they are not normalized yet
    action: Tensor  # [B] or [B, K]
    numbers: Tensor  # [4, B] log-probability, value, advantage, and target of the value

    @classmethod
    def of(cls, rollout: Rollout, advantage: Tensor, target: Tensor) -> Batch:
        """Flatten `[T, N, ...]` to `[T * N, ...]`."""
        past = Past(rollout.memory[None], rollout.episode_starts.flatten(), rollout.train.flatten())
        numbers = torch.stack([rollout.log_prob, rollout.value, advantage, target])
        return cls(
            past, rollout.observation.flatten(0, 1), None, None, rollout.action.flatten(0, 1), numbers.flatten(1, 2)
        )

    @property
    def observation(self) -> Tensor:
        """The observations `[B, size]`, copied from the rollout at each access."""
        return self.rollout if self.rows is None else self.rollout.index_select(0, self.rows)

    @property
    def log_prob(self) -> Tensor:
        """The logarithm of the probability of each action, `[B]`."""
        return self.numbers[0]

    @property
    def value(self) -> Tensor:
        """The values, `[B]`."""
        return self.numbers[1]

    @property
    def advantage(self) -> Tensor:
        """The advantages, `[B]`."""
        return self.numbers[2]

    @property
    def target(self) -> Tensor:
        """The targets of the values, `[B]`."""
        return self.numbers[3]

    def to(self, device: torch.device) -> Batch:
        """Return the batch on a device. All columns are copied at once, from pinned memory.

        Observations are already on the device; see `learning.upload`.
        """
        if device.type == "cpu":
            return self
        columns = *filter(torch.is_tensor, self.past), self.action, self.numbers
        *past, action, numbers = (part.pin_memory().to(device, non_blocking=True) for part in columns)
        return Batch(Past(*past), self.rollout.to(device), None, None, action, numbers)

    def add_memories(self, student: Student, length: int, size: int) -> None:
        """Add the memory before each piece of `length` steps, for truncated backpropagation through time.

        Nothing is added without memory, or for pieces as long as the rollout. The memory is computed once, before the
        update, by a pass without gradients over about `size` pieces at a time. So it equals the memory with which the
        student acted (the stored state of Kapturowski et al. 2019, section 3), and pieces can be shuffled and computed
        in parallel. Recomputing the memory for each minibatch would need such a pass each time.
        """
        memory, begins = self.past.memory, self.past.episode_starts  # [1, N, W], [T * N]
        assert begins is not None
        rows = torch.arange(len(begins), device=begins.device).view(-1, memory.shape[1])  # [T, N]
        if not memory.shape[-1] or length in (0, len(rows)):
            return
        before = torch.zeros(len(rows), dtype=torch.bool, device=rows.device)  # [T], steps after which a piece begins
        before[length - 1 : -1 : length] = True
        found = []  # [T / length - 1, some, W] each
        envs = max(1, size * length // len(rows))
        for part, start in zip(rows.split(envs, 1), memory[0].split(envs), strict=True):
            past = Past(start, begins[part], before.repeat_interleave(len(start)))
            found.append(student.remember(self.look(student, part.flatten()), past).unflatten(0, (-1, len(start))))
        self.past = self.past._replace(memory=torch.cat([memory, torch.cat(found, 1)]))

    def look(self, student: Student, rows: Tensor) -> Tensor:
        """Return the normalized observations of these rows of the rollout."""
        if self.seen is None:
            return student.normaliser(self.rollout.index_select(0, rows))
        return self.seen.index_select(0, rows)

    def minibatches(self, sequences: Tensor, size: int, norm_adv: bool = False) -> Iterator[Batch]:
        """Yield minibatches of `size` of these sequences `[S, L]` of row numbers, step by step.

        `norm_adv` normalizes the advantages of each minibatch.
        """
        parts = [part.T for part in sequences.split(size)]  # [L, B] each
        pasts, rows, learned = zip(*map(self._past, parts), strict=True)
        sizes, every = [len(some) for some in learned], torch.cat(learned)
        # once for all minibatches: many small gathers of single numbers take longer than one large gather
        actions, numbers = self.action.index_select(0, every), self.numbers.index_select(1, every)
        if norm_adv:
            normalize(numbers[2], sizes)
        columns = rows, pasts, actions.split(sizes), numbers.split(sizes, 1)
        for row, past, action, number in zip(*columns, strict=True):
            seen = None if self.seen is None else self.seen.index_select(0, row)
            yield Batch(past, self.rollout, row, seen, action, number)

    def _past(self, part: Tensor) -> tuple[Past, Tensor, Tensor]:
        """Return the sequences of the steps `[L, B]`, the rows to compute, and the rows to learn from."""
        memory, begins, train = self.past.memory, self.past.episode_starts, self.past.mask
        assert begins is not None and train is not None
        rows = part.flatten()
        if not memory.shape[-1]:  # single steps, all of them to learn from
            return Past(memory.new_empty(len(rows), 0)), rows, rows
        envs = memory.shape[1]  # row r is step r // envs of environment r % envs
        start = memory[part[0] // (len(part) * envs), part[0] % envs]
        past, mask = Past(start, begins[rows].view(part.shape)), train[rows]
        if mask.all():
            return past, rows, rows
        kept = steps_to_learn(mask.view(part.shape), begins[rows].view(part.shape))
        needed = kept.flatten()
        return past._replace(mask=mask[needed], kept=kept), rows[needed], rows[mask]


def normalize(advantage: Tensor, sizes: Sequence[int]) -> None:
    """Normalize the advantages `[S]` of each minibatch, given their sizes; for a team `[S, A]`, for each agent."""
    one_by_one = len(set(sizes)) > 1
    for part in advantage.split(sizes) if one_by_one else [advantage.unflatten(0, (-1, sizes[0]))]:
        steps = 0 if one_by_one else 1  # the axis
        if part.shape[steps] > 1:
            std, mean = torch.std_mean(part, steps, keepdim=True)
            part.sub_(mean).div_(std.add_(1e-8))


def clip_gradient(student: Student, optimizer: Adam, max_norm: float) -> Tensor:
    """Scale the student's gradient down to this norm; return its original norm `[]`.

    The gradients of several policies are clipped separately, and so is that of a shared critic; the norm returned is
    their mean. Losses are means over agents, so the gradient of each agent's own policy is first multiplied by the
    number of policies: each policy learns as a single agent would.
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
