"""Behavior cloning (Pomerleau 1991): a student learns to imitate demonstrations.

    repeat until the loss on held-out episodes stops falling
        for each minibatch of shuffled steps
            one step of Adam on  - log π(action | observation)  +  value loss
    keep the student of the best epoch

For several agents, the loss is over all of their policies. The critic is trained on the returns of the demonstrations,
so that PPO does not start with an untrained one. Demonstrations are read in chunks in every epoch and need not fit into
memory. Read next: `learning.student`; `learning.ppo`, which continues training.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Discrete
from torch import Tensor

from ued.config import CloningConfig
from ued.core.resumable import Resumable
from ued.learning.fast_adam import Adam
from ued.learning.student import Student


@dataclass(frozen=True)
class Demonstrated:
    """B steps of demonstrations, of one agent or of A.

    Attributes:
        observation: `[B, ...]` or `[B, A, ...]`, images as uint8.
        action: int64 `[B]` or `[B, A]`.
        mask: bool, like `action`: False for unknown actions; these steps are not used.
        returns: discounted return from this step on: `[B]` of all agents, or for opponents `[B, A]`.
    """

    observation: Tensor
    action: Tensor
    mask: Tensor
    returns: Tensor

    def rows(self, rows: Tensor) -> Demonstrated:
        """Return the steps with these indices."""
        return Demonstrated(*(column[rows] for column in vars(self).values()))


@dataclass(frozen=True)
class Agreement:
    """Results of a student on held-out demonstrations.

    Attributes:
        loss: mean of - log π, in nats.
        value_loss: half the squared error of the value.
        counts: `[n, n]`, confusion matrix: demonstrated actions (rows), the student's most likely actions (columns).
    """

    loss: float
    value_loss: float
    counts: np.ndarray

    @property
    def accuracy(self) -> float:
        """Share of the steps in which the student's most likely action is correct; nan without steps."""
        return float(np.trace(self.counts) / self.counts.sum()) if self.counts.sum() else float("nan")

    @property
    def recall(self) -> np.ndarray:
        """The accuracy for each demonstrated action `[n]`; nan for actions without demonstrations."""
        return self._agreed(self.counts.sum(1))

    @property
    def precision(self) -> np.ndarray:
        """Share of correct predictions of each action `[n]`; nan for actions that are never predicted."""
        return self._agreed(self.counts.sum(0))

    def _agreed(self, steps: np.ndarray) -> np.ndarray:
        """Return the diagonal divided by the given number of steps of each action `[n]`; nan for 0 steps."""
        return np.divide(np.diag(self.counts), steps, out=np.full(len(steps), np.nan), where=steps > 0)

    @property
    def balanced_accuracy(self) -> float:
        """Mean recall over all demonstrated actions, independent of their frequencies."""
        recall = self.recall
        return float(np.nanmean(recall)) if np.isfinite(recall).any() else float("nan")


class Cloner(Resumable):
    """Trains a student on demonstrations, one epoch at a time; `generator` shuffles.

    Attributes:
        epoch: number of epochs so far. `best_epoch` had the smallest loss on held-out steps; `best` is its student.
    """

    state_fields = ("student", "optimizer", "generator", "epoch", "best_epoch", "best_loss", "best")

    def __init__(self, student: Student, config: CloningConfig, generator: torch.Generator) -> None:
        if student.memory_width:
            raise ValueError("cloning supports no memory: use a student with memory='none' (--ppo.memory none)")
        self.student, self.config, self.generator = student, config, generator
        self.optimizer = Adam(student.parameters(), config.learning_rate, 1e-5)
        self.weights = torch.ones(num_actions(student))
        self.epoch, self.best_epoch, self.best_loss = 0, 0, float("inf")
        self.best: dict[str, Any] = {}

    def look_through(self, chunks: Iterable[Demonstrated]) -> None:
        """Read the demonstrations once before the first epoch, for observation statistics and action frequencies."""
        counts = torch.zeros(num_actions(self.student), dtype=torch.float64)
        for chunk in chunks:
            if self.epoch == 0:  # a resumed student already has the statistics
                self.student.normaliser.track(chunk.observation)
            counts += torch.bincount(chunk.action[chunk.mask], minlength=len(counts))
        power = {"none": 0.0, "sqrt": 0.5, "balanced": 1.0}[self.config.class_weights]
        share = counts / counts.sum().clamp(min=1)
        weights = torch.where(counts > 0, share.clamp(min=1e-4) ** -power, 0.0)
        self.weights = (weights / (weights * share).sum().clamp(min=1e-12)).float()  # mean 1

    def learn(self, chunks: Iterable[Demonstrated]) -> dict[str, float]:
        """Pass over the demonstrations once; return the mean losses."""
        sums, steps = np.zeros(2), 0
        for batch in self._minibatches(chunks):
            loss, value_loss = self._losses(batch)
            total = loss + self.config.value_coef * value_loss
            self.optimizer.zero_grad()
            total.backward()
            norm = self.optimizer.clip_norm(self.config.max_grad_norm)
            if not torch.isfinite(norm):
                raise FloatingPointError("the gradient of cloning is not finite: check the observations for NaN")
            self.optimizer.step()
            sums += len(batch.returns) * np.array([loss.item(), value_loss.item()])
            steps += len(batch.returns)
        self.epoch += 1
        return dict(zip(("loss", "value_loss"), map(float, sums / max(steps, 1)), strict=True))

    @torch.inference_mode()
    def evaluate(self, chunks: Iterable[Demonstrated]) -> Agreement:
        """Evaluate the student on demonstrations, without weights of actions."""
        size = num_actions(self.student)
        counts, sums, num_known, steps = torch.zeros(size * size, dtype=torch.int64), np.zeros(2), 0, 0
        for chunk in chunks:
            for rows in torch.arange(len(chunk.returns)).split(4 * self.config.batch_size):
                batch = chunk.rows(rows)
                policy, value = self.student(batch.observation)
                log_prob, known = policy.log_prob(batch.action), batch.mask
                pairs = batch.action[known] * size + policy.mode()[known]
                counts += torch.bincount(pairs, minlength=size * size)
                sums += [-float(log_prob[known].sum()), float(value_error(value, batch.returns).sum())]
                num_known, steps = num_known + int(known.sum()), steps + value.numel()
        loss, value_loss = sums / np.maximum([num_known, steps], 1)
        return Agreement(float(loss), float(value_loss), counts.reshape(size, size).numpy())

    def keep_if_best(self, loss: float) -> bool:
        """Store the student if its loss is the smallest so far; return whether to continue."""
        if loss < self.best_loss or not self.best:
            self.best_loss, self.best_epoch = loss, self.epoch
            self.best = {name: value.clone() for name, value in self.student.state_dict().items()}
        return self.epoch < self.config.epochs and self.epoch - self.best_epoch < self.config.patience

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`. Raises ValueError, KeyError or RuntimeError for another student."""
        super().load_state_dict(state)
        if self.best or self.epoch:
            copy.deepcopy(self.student).load_state_dict(self.best)

    def _minibatches(self, chunks: Iterable[Demonstrated]) -> Iterator[Demonstrated]:
        for chunk in chunks:
            order = torch.randperm(len(chunk.returns), generator=self.generator)
            for rows in order.split(self.config.batch_size):
                yield chunk.rows(rows)

    def _losses(self, batch: Demonstrated) -> tuple[Tensor, Tensor]:
        """Return the weighted policy loss and the value loss."""
        policy, value = self.student(batch.observation)
        weight = self.weights[batch.action] * batch.mask
        loss = -(policy.log_prob(batch.action) * weight).sum() / weight.sum().clamp(min=1e-8)
        return loss, value_error(value, batch.returns).mean()


def value_error(value: Tensor, returns: Tensor) -> Tensor:
    """Return half the squared errors of values `[B]` or `[B, A]`, given returns `[B]` of all agents, or `[B, A]`."""
    return 0.5 * (value - (returns if returns.ndim == value.ndim else returns[:, None])) ** 2


def num_actions(student: Student) -> int:
    """Return the number of actions of each agent. Raises ValueError for actions that are not discrete."""
    space = student.action_space
    if not isinstance(space, Discrete):
        raise ValueError(f"cloning needs discrete actions, got {space}")
    return int(space.n)


def discounted(rewards: np.ndarray, gamma: float) -> np.ndarray:
    """Return the discounted return from each step of an episode with these rewards `[T]`, or `[T, A]`."""
    returns, running = np.zeros(rewards.shape), np.zeros(rewards.shape[1:])
    for step in reversed(range(len(rewards))):
        running = rewards[step] + gamma * running
        returns[step] = running
    return returns
