"""Behavior cloning (Pomerleau 1991): a student learns to do what was done in demonstrations.

    repeat until the loss on held-out episodes has not fallen for a while
        for each minibatch of shuffled steps
            one step of Adam on  - log π(what was done | what was seen)  +  the error of the value
    keep the student of the best epoch

Of several agents each has its own policy, and the loss is over all of them. The critic learns what came of the
demonstrations, so that PPO need not begin with one that knows nothing. Demonstrations come in chunks, which are read
again in every epoch: they need not fit into memory. Read next: `learning.student`; `learning.ppo`, which goes on.
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
        told: bool, like `action`: False where the action is unknown; such steps are not learned from.
        returns: `[B]`, discounted, from this step on.
    """

    observation: Tensor
    action: Tensor
    told: Tensor
    returns: Tensor

    def rows(self, rows: Tensor) -> Demonstrated:
        """Return some of the steps."""
        return Demonstrated(*(column[rows] for column in vars(self).values()))


@dataclass(frozen=True)
class Agreement:
    """What a student makes of demonstrations that it has not learned from.

    Attributes:
        loss: mean of - log π, in nats.
        value_loss: half the squared error of the value.
        counts: `[n, n]`, how often which action was done (row) and which one the student thinks most likely (column).
    """

    loss: float
    value_loss: float
    counts: np.ndarray

    @property
    def accuracy(self) -> float:
        """Share of the steps in which the student would have done the same; nan of none."""
        return float(np.trace(self.counts) / self.counts.sum()) if self.counts.sum() else float("nan")

    @property
    def recall(self) -> np.ndarray:
        """The same for each action `[n]`; nan of those that were never done."""
        return self._agreed(self.counts.sum(1))

    @property
    def precision(self) -> np.ndarray:
        """Share of the steps in which the student would do an action where it was done `[n]`; nan if it never would."""
        return self._agreed(self.counts.sum(0))

    def _agreed(self, steps: np.ndarray) -> np.ndarray:
        """Return in which share of the steps of each action `[n]` both were it; nan of no step."""
        return np.divide(np.diag(self.counts), steps, out=np.full(len(steps), np.nan), where=steps > 0)

    @property
    def balanced_accuracy(self) -> float:
        """Mean of the recalls of all actions that were done: what most steps are does not decide it."""
        recall = self.recall
        return float(np.nanmean(recall)) if np.isfinite(recall).any() else float("nan")


class Cloner(Resumable):
    """Lets a student learn from demonstrations, an epoch at a time; `generator` shuffles.

    Attributes:
        epoch: epochs so far; `best_epoch` is the one with the smallest loss on held-out steps, `best` its student.
    """

    state_fields = ("student", "optimizer", "generator", "epoch", "best_epoch", "best_loss", "best")

    def __init__(self, student: Student, config: CloningConfig, generator: torch.Generator) -> None:
        if student.memory_width:
            raise ValueError("cloning teaches single steps: it needs a student that remembers nothing, memory = none")
        self.student, self.config, self.generator = student, config, generator
        self.optimizer = Adam(student.parameters(), config.learning_rate, 1e-5)
        self.weights = torch.ones(num_actions(student))
        self.epoch, self.best_epoch, self.best_loss = 0, 0, float("inf")
        self.best: dict[str, Any] = {}

    def look_through(self, chunks: Iterable[Demonstrated]) -> None:
        """Go through the demonstrations once before the first epoch: how they look, and how often what was done."""
        counts = torch.zeros(num_actions(self.student), dtype=torch.float64)
        for chunk in chunks:
            if self.epoch == 0:  # a student that goes on has seen them
                self.student.normaliser.track(chunk.observation)
            counts += torch.bincount(chunk.action[chunk.told], minlength=len(counts))
        power = {"none": 0.0, "sqrt": 0.5, "balanced": 1.0}[self.config.class_weights]
        share = counts / counts.sum().clamp(min=1)
        weights = torch.where(counts > 0, share.clamp(min=1e-4) ** -power, 0.0)
        self.weights = (weights / (weights * share).sum().clamp(min=1e-12)).float()  # 1 in the mean

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
                raise FloatingPointError("the gradient of cloning is not finite: look for observations that are not")
            self.optimizer.step()
            sums += len(batch.returns) * np.array([loss.item(), value_loss.item()])
            steps += len(batch.returns)
        self.epoch += 1
        return dict(zip(("loss", "value_loss"), map(float, sums / max(steps, 1)), strict=True))

    @torch.inference_mode()
    def evaluate(self, chunks: Iterable[Demonstrated]) -> Agreement:
        """Compare the student with demonstrations; all actions count the same."""
        size = num_actions(self.student)
        counts, sums, told, steps = torch.zeros(size * size, dtype=torch.int64), np.zeros(2), 0, 0
        for chunk in chunks:
            for rows in torch.arange(len(chunk.returns)).split(4 * self.config.batch_size):
                batch = chunk.rows(rows)
                policy, value = self.student(batch.observation)
                log_prob, known = policy.log_prob(batch.action), batch.told
                pairs = batch.action[known] * size + policy.mode()[known]
                counts += torch.bincount(pairs, minlength=size * size)
                sums += [-float(log_prob[known].sum()), float(value_error(value, batch.returns).sum())]
                told, steps = told + int(known.sum()), steps + value.numel()
        loss, value_loss = sums / np.maximum([told, steps], 1)
        return Agreement(float(loss), float(value_loss), counts.reshape(size, size).numpy())

    def keep_if_best(self, loss: float) -> bool:
        """Keep the student if its loss is the smallest so far; return whether to go on."""
        if loss < self.best_loss or not self.best:
            self.best_loss, self.best_epoch = loss, self.epoch
            self.best = {name: value.clone() for name, value in self.student.state_dict().items()}
        return self.epoch < self.config.epochs and self.epoch - self.best_epoch < self.config.patience

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned. Raises ValueError, KeyError, or RuntimeError for another student."""
        super().load_state_dict(state)
        if self.best or self.epoch:
            copy.deepcopy(self.student).load_state_dict(self.best)

    def _minibatches(self, chunks: Iterable[Demonstrated]) -> Iterator[Demonstrated]:
        for chunk in chunks:
            order = torch.randperm(len(chunk.returns), generator=self.generator)
            for rows in order.split(self.config.batch_size):
                yield chunk.rows(rows)

    def _losses(self, batch: Demonstrated) -> tuple[Tensor, Tensor]:
        """Return the weighted loss of the policy and the loss of the value."""
        policy, value = self.student(batch.observation)
        weight = self.weights[batch.action] * batch.told
        loss = -(policy.log_prob(batch.action) * weight).sum() / weight.sum().clamp(min=1e-8)
        return loss, value_error(value, batch.returns).mean()


def value_error(value: Tensor, returns: Tensor) -> Tensor:
    """Return half the squared errors of values `[B]` or `[B, A]` for returns `[B]` of all agents."""
    return 0.5 * (value - returns.reshape(-1, *(1,) * (value.ndim - 1))) ** 2


def num_actions(student: Student) -> int:
    """Return how many actions each agent of a student chooses among. Raises ValueError where they are no choice."""
    space = student.action_space
    if not isinstance(space, Discrete):
        raise ValueError(f"cloning needs actions that are a choice, got {space}")
    return int(space.n)


def discounted(rewards: np.ndarray, gamma: float) -> np.ndarray:
    """Return for each step of an episode with these rewards `[T]` the discounted return from there on `[T]`."""
    returns, running = np.zeros(len(rewards)), 0.0
    for step in reversed(range(len(rewards))):
        running = rewards[step] + gamma * running
        returns[step] = running
    return returns
