"""Proximal policy optimisation (Schulman et al. 2017), flat: the order on the page is the order of execution.

Written once, for every method. Read next: `methods.dr`, the simplest use of it.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.learning.networks import Policy
from ued.learning.rollout import Rollout, gae
from ued.learning.student import Student


class PPO:
    """Improves one student from its rollouts. `generator` shuffles the minibatches."""

    def __init__(self, student: Student, config: PPOConfig, generator: torch.Generator) -> None:
        self.student, self.config, self.generator = student, config, generator
        self.optimizer = torch.optim.Adam(student.parameters(), config.learning_rate, eps=config.adam_eps)
        self.updates = 0

    def learn(
        self, rollout: Rollout, env_steps: int = 0, advantages: Tensor | None = None, guide: Guide | None = None
    ) -> dict[str, float]:
        """Learn from the steps of a rollout that are meant for it; give the means of the losses over all minibatches.

        Minibatches are as large as if all steps were; where none is, nothing changes and there are no losses.

        Args:
            env_steps: simulated so far, for the annealing of the learning rate.
            advantages: `[T, N]` where they are known already.
            guide: another policy to stay close to.
        """
        config = self.config
        self._anneal(env_steps)
        if advantages is None:
            advantages = gae(rollout, config.gamma, config.gae_lambda)  # [T, N]
        targets = advantages + rollout.value
        old = Batch.of(rollout, advantages, targets)  # B = T * N rows
        minibatch_size = -(-len(old.value) // config.num_minibatches)
        if not rollout.train.all():
            old = old.rows(rollout.train.flatten().nonzero()[:, 0])
        if not len(old.value):
            return {}
        logs: list[dict[str, float]] = []
        for _ in range(config.update_epochs):
            order = torch.randperm(len(old.value), generator=self.generator)
            for rows in order.split(minibatch_size):
                logs.append(self._minibatch(old.rows(rows), guide))
            if config.target_kl and logs[-1]["approx_kl"] > config.target_kl:
                break
        self.student.normaliser.track(old.observation)  # after learning: a rollout is learned from as it was seen
        self.updates += 1
        metrics = {name: sum(log[name] for log in logs) / len(logs) for name in logs[0]}
        metrics["explained_variance"] = explained_variance(old.value, old.target)
        metrics["learning_rate"] = self.optimizer.param_groups[0]["lr"]
        return metrics

    def _anneal(self, env_steps: int) -> None:
        if self.config.anneal_env_steps:
            left = max(0.0, 1.0 - env_steps / self.config.anneal_env_steps)
            self.optimizer.param_groups[0]["lr"] = self.config.learning_rate * left

    def _minibatch(self, old: Batch, guide: Guide | None) -> dict[str, float]:
        """Take one gradient step on one minibatch."""
        config = self.config
        policy, value = self.student(old.observation)
        log_ratio = policy.log_prob(old.action) - old.log_prob
        ratio = log_ratio.exp()
        advantage = old.advantage
        if config.norm_adv and len(advantage) > 1:
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        clipped = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)
        policy_loss = -torch.min(advantage * ratio, advantage * clipped).mean()
        value_loss = self._value_loss(value, old)
        entropy = policy.entropy().mean()
        loss = policy_loss - config.ent_coef * entropy + config.vf_coef * value_loss
        if guide is not None:
            loss = loss + guide.coef * guide.divergence(old.observation, policy)
        self.optimizer.zero_grad()
        loss.backward()
        grad_norm = nn.utils.clip_grad_norm_(self.student.parameters(), config.max_grad_norm)
        if not torch.isfinite(grad_norm):  # before it spoils the weights
            raise FloatingPointError(
                f"the gradient is not finite (loss {loss.item():g}): look for rewards or observations that are not, or "
                "try a smaller learning_rate"
            )
        self.optimizer.step()
        with torch.no_grad():
            return {
                "policy_loss": policy_loss.item(),
                "value_loss": value_loss.item(),
                "entropy": entropy.item(),
                "approx_kl": ((ratio - 1) - log_ratio).mean().item(),  # Schulman's k3 estimator
                "clip_fraction": ((ratio - 1).abs() > config.clip_coef).float().mean().item(),
                "grad_norm": grad_norm.item(),
            }

    def _value_loss(self, value: Tensor, old: Batch) -> Tensor:
        error = (value - old.target) ** 2
        if self.config.clip_vloss:
            moved = (value - old.value).clamp(-self.config.clip_coef, self.config.clip_coef)
            error = torch.max(error, (old.value + moved - old.target) ** 2)
        return 0.5 * error.mean()

    def state_dict(self) -> dict[str, Any]:
        """Give the student's weights and statistics, the optimiser and the generator."""
        return {
            "student": copy.deepcopy(self.student.state_dict()),  # torch gives its own tensors, which learning changes
            "optimizer": copy.deepcopy(self.optimizer.state_dict()),
            "generator": self.generator.get_state(),
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.student.load_state_dict(state["student"])
        self.optimizer.load_state_dict(copy.deepcopy(state["optimizer"]))
        self.generator.set_state(state["generator"])
        self.updates = state["updates"]


@dataclass(frozen=True)
class Guide:
    """A policy that a student is drawn to while it learns (behavior cloning of Mediratta et al. 2023, section 4.2)."""

    student: Student
    coef: float

    def divergence(self, observation: Tensor, policy: Policy) -> Tensor:
        """Give KL(guide ‖ policy), the mean over the minibatch; gradients flow into `policy` alone."""
        with torch.no_grad():
            theirs, _ = self.student(observation)
        return theirs.kl(policy).mean()


@dataclass
class Batch:
    """The steps of a rollout in one row each: every field is `[B, ...]`."""

    observation: Tensor
    action: Tensor
    log_prob: Tensor
    value: Tensor
    advantage: Tensor
    target: Tensor

    @classmethod
    def of(cls, rollout: Rollout, advantage: Tensor, target: Tensor) -> Batch:
        """Flatten `[T, N, ...]` to `[T * N, ...]`."""
        fields = rollout.observation, rollout.action, rollout.log_prob, rollout.value, advantage, target
        return cls(*(field.flatten(0, 1) for field in fields))

    def rows(self, rows: Tensor) -> Batch:
        """Give some of the rows."""
        fields = self.observation, self.action, self.log_prob, self.value, self.advantage, self.target
        return Batch(*(field[rows] for field in fields))


def explained_variance(value: Tensor, target: Tensor) -> float:
    """Give 1 - Var(target - value) / Var(target): 1 for perfect values, nan where the targets do not vary."""
    variance = target.var().item()
    return 1.0 - (target - value).var().item() / variance if variance > 0 else float("nan")
