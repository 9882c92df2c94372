"""Proximal policy optimisation (Schulman et al. 2017), flat: the order on the page is the order of execution.

    advantages of the rollout by GAE, targets of the values             (PPO.learn)
    for each epoch, for each minibatch of shuffled steps, or sequences  (PPO._minibatch)
        ratio of new to old probability, clipped; loss of policy, value and entropy; one step of Adam

Written once, for every method, for one agent and for teams: what an agent sees, does and expects then has a further
axis of agents, `[B, A]`, and losses are means over them. What is shuffled is the student's business: single steps, or
whole sequences of those of one environment, where it remembers (see `learning.memory`). Names are CleanRL's. Read next:
`methods.dr`, the simplest use of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from ued.config import PPOConfig
from ued.core.resumable import Resumable
from ued.learning.adam import Adam, clip_norm
from ued.learning.memory import Past
from ued.learning.networks import Policy
from ued.learning.rollout import Rollout, gae
from ued.learning.student import Student


class PPO(Resumable):
    """Improves one student from its rollouts. `generator` shuffles the minibatches."""

    state_fields = ("student", "optimizer", "generator", "updates")

    def __init__(self, student: Student, config: PPOConfig, generator: torch.Generator) -> None:
        self.student, self.config, self.generator = student, config, generator
        self.optimizer = Adam(student.parameters(), config.learning_rate, config.adam_eps)
        self.updates = 0

    def learn(
        self,
        rollout: Rollout,
        env_steps: int = 0,
        advantages: Tensor | None = None,
        regularizer: KLRegularizer | None = None,
    ) -> dict[str, float]:
        """Learn from the steps of a rollout that are meant for it; return the means of the losses over all minibatches.

        Minibatches are as large as if all steps were; where none is, nothing changes and `gradient_steps` is 0.
        `env_steps` so far anneal the learning rate; `advantages` (see `gae`) may be known already; `regularizer` is
        another policy to stay close to. Raises `FloatingPointError` for a gradient that is not finite.
        """
        config = self.config
        self._anneal(env_steps)
        if advantages is None:
            advantages = gae(rollout, config.gamma, config.gae_lambda)  # [T, N]
        targets = advantages + rollout.value  # [T, N]
        old = Batch.of(rollout, advantages, targets).to(self.student.device)  # T * N rows
        sequences = self.student.actor_memory.sequences(rollout.train).to(self.student.device)  # [S, L] of these rows
        if not len(sequences):
            return {"gradient_steps": 0.0}
        minibatch_size = -(-len(old.value) // sequences.shape[1] // config.num_minibatches)
        logs: list[dict[str, float]] = []
        for _ in range(config.update_epochs):
            order = torch.randperm(len(sequences), generator=self.generator)
            for minibatch in old.minibatches(sequences[order], minibatch_size):
                logs.append(self._minibatch(minibatch, regularizer))
            if config.target_kl and logs[-1]["approx_kl"] > config.target_kl:
                break
        # After learning: a rollout is learned from as it was seen. And of these steps alone: levels that are only
        # looked at would shift what the policy sees while its weights do not follow.
        learned = rollout.train.flatten().to(self.student.device)
        self.student.normaliser.track(old.observation if learned.all() else old.observation[learned])
        self.updates += 1
        metrics = {name: sum(log[name] for log in logs) / len(logs) for name in logs[0]}
        metrics |= {"gradient_steps": float(len(logs))}
        metrics["explained_variance"] = explained_variance(old.value[learned], old.target[learned])
        metrics["learning_rate"] = self.optimizer.param_groups[0]["lr"]
        return metrics

    def _anneal(self, env_steps: int) -> None:
        if self.config.anneal_env_steps:
            left = max(0.0, 1.0 - env_steps / self.config.anneal_env_steps)
            self.optimizer.param_groups[0]["lr"] = self.config.learning_rate * left

    def _minibatch(self, old: Batch, regularizer: KLRegularizer | None) -> dict[str, float]:
        """Take one gradient step on one minibatch; return its losses."""
        config = self.config
        policy, value = self.student(old.observation, old.past)  # B distributions, [B]
        log_ratio = policy.log_prob(old.action) - old.log_prob  # [B]
        ratio = log_ratio.exp()  # [B]
        advantage = old.advantage  # [B]
        if config.norm_adv and len(advantage) > 1:  # each agent's own
            advantage = (advantage - advantage.mean(0)) / (advantage.std(0) + 1e-8)
        clipped = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)  # [B]
        policy_loss = -torch.min(advantage * ratio, advantage * clipped).mean()  # [], equation 7 of the paper
        value_loss = self._value_loss(value, old)  # []
        entropy = policy.entropy()  # [B]
        loss = policy_loss - config.ent_coef * entropy.mean() + config.vf_coef * value_loss
        if regularizer is not None:
            loss = loss + regularizer.coef * regularizer.divergence(old, policy)
        self.optimizer.zero_grad()
        loss.backward()
        if self.student.policies > 1:
            grad_norm = clip_gradient(self.student, config.max_grad_norm)
        else:
            grad_norm = self.optimizer.clip_norm(config.max_grad_norm)
        if not torch.isfinite(grad_norm):
            raise FloatingPointError(
                f"the gradient is not finite (loss {loss.item():g}): look for rewards or observations that are not, or "
                "try a smaller learning_rate"
            )
        self.optimizer.step()
        with torch.no_grad():
            approx_kl = (ratio - 1) - log_ratio  # [B], Schulman's k3 estimator: never negative
            return {
                "policy_loss": policy_loss.item(),
                "value_loss": value_loss.item(),
                "entropy": entropy.mean().item(),
                "approx_kl": approx_kl.mean().item(),
                "clip_fraction": ((ratio - 1).abs() > config.clip_coef).float().mean().item(),
                "grad_norm": grad_norm.item(),
                **by_agent("entropy", entropy),
                **by_agent("approx_kl", approx_kl),
            }

    def _value_loss(self, value: Tensor, old: Batch) -> Tensor:
        error = (value - old.target) ** 2  # [B]
        if self.config.clip_vloss:
            moved = (value - old.value).clamp(-self.config.clip_coef, self.config.clip_coef)  # [B]
            error = torch.max(error, (old.value + moved - old.target) ** 2)
        return 0.5 * error.mean()


def clip_gradient(student: Student, max_norm: float) -> Tensor:
    """Scale the gradient of each of several policies, and that of a critic in common, down to this norm; return their
    mean norm.

    Losses are means over agents, so a policy that is one agent's alone finds his share of them in its gradient: it is
    multiplied by their number first. So each of them learns as if it were alone.
    """
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
    """Return the means of `[B, A]` by agent, of one agent's `[B]` nothing: the mean over all is his."""
    means = values.mean(0).tolist() if values.ndim > 1 else []
    return {f"agent_{agent}/{name}": mean for agent, mean in enumerate(means)}


@dataclass(frozen=True)
class KLRegularizer:
    """A policy that a student is kept close to while it learns (behavior cloning of Mediratta et al. 2023, 4.2)."""

    student: Student
    coef: float

    def divergence(self, batch: Batch, policy: Policy) -> Tensor:
        """Return KL(other ‖ policy), the mean over the minibatch; gradients flow into `policy` alone.

        A recurrent student that plays elsewhere remembers nothing of what was before the rollout.
        """
        memory = self.student.empty_memory(len(batch.past.memory)).to(self.student.device)
        with torch.no_grad():
            other, _ = self.student(batch.observation, batch.past._replace(memory=memory))
        return other.kl(policy).mean()


@dataclass(frozen=True)
class FadingKL:
    """A policy that a student is kept close to at first: the weight falls linearly to 0 over so many `env_steps`."""

    student: Student
    coef: float
    env_steps: int

    def at(self, env_steps: int) -> KLRegularizer | None:
        """Return the regulariser after so many steps, None when it has faded."""
        left = 1.0 - env_steps / self.env_steps if self.env_steps else 0.0
        return KLRegularizer(self.student, self.coef * left) if left > 0 and self.coef else None


@dataclass
class Batch:
    """The steps of a rollout in one row each; of several agents `[B, A, ...]`.

    Of a minibatch of sequences there are observations of all steps, the rest of those that are to be learned from.
    """

    past: Past  # how the observations hang together
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
        past = Past(rollout.memory, rollout.begins.flatten(), rollout.train.flatten())
        return cls(past, *(column.flatten(0, 1) for column in columns))

    def to(self, device: torch.device) -> Batch:
        """Return it on a device, from pinned memory: the copies of all columns are on their way at once.

        Observations are there already; see `learning.upload`.
        """
        if device.type == "cpu":
            return self
        past, observation, *rest = (getattr(self, field.name) for field in fields(self))
        past, rest = ([part.pin_memory().to(device, non_blocking=True) for part in columns] for columns in (past, rest))
        return Batch(Past(*past), observation.to(device), *rest)

    def minibatches(self, sequences: Tensor, size: int) -> Iterator[Batch]:
        """Yield S sequences of L rows each, `[S, L]`, so many at a time, each minibatch step by step.

        Row r is of environment r modulo N. Rows are gathered once for all: small gathers take as long as large ones.
        """
        memory, begins, told = self.past
        assert begins is not None and told is not None
        parts = [part.T for part in sequences.split(size)]  # [L, B] each
        sizes = [part.numel() for part in parts]
        rows = torch.cat([part.flatten() for part in parts])  # [S * L]
        memories = memory.index_select(0, sequences[:, 0] % len(memory)).split(size)
        begun, answered = (column.index_select(0, rows).split(sizes) for column in (begins, told))
        observation, *rest = (getattr(self, field.name) for field in fields(self)[1:])
        seen = observation.index_select(0, rows).split(sizes)
        learned, counts = rows[told[rows]], [int(part.sum()) for part in answered]
        columns = zip(*(column.index_select(0, learned).split(counts) for column in rest), strict=True)
        pieces = zip(parts, memories, begun, answered, seen, columns, strict=True)
        for part, memory, begins, told, observation, others in pieces:
            yield Batch(Past(memory, begins.view(part.shape), told), observation, *others)


def explained_variance(value: Tensor, target: Tensor) -> float:
    """Return 1 - Var(target - value) / Var(target): 1 for perfect values, nan where the targets do not vary."""
    variance = target.var().item()
    return 1.0 - (target - value).var().item() / variance if variance > 0 else float("nan")
