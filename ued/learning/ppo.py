"""Proximal policy optimization (Schulman et al. 2017), in the order of execution.

    learning rate; advantages of the rollout by GAE, targets of the values                   (PPO.learn)
    for each epoch, for each minibatch of shuffled steps, or sequences
        ratio of new to old probability, clipped; loss of policy, value and entropy          (ppo_loss.losses)
        gradient of the loss                                                                 (backprop)
        gradient, clipped to a norm; one step of Adam                                        (PPO._minibatch)

All methods use it, for one agent and for teams. For a team, observations, actions and values have a further axis of
agents, `[B, A]`, and losses are means over agents. Names are CleanRL's. Read next: `learning.minibatches`, which splits
a rollout into minibatches; `methods.dr`, the simplest use of PPO.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from ued.config import PPOConfig
from ued.core.resumable import Resumable
from ued.learning.backprop import backpropagate
from ued.learning.fast_adam import Adam
from ued.learning.kl import KLRegularizer
from ued.learning.minibatches import Batch, clip_gradient
from ued.learning.ppo_loss import Losses, approx_kl, means
from ued.learning.rollout import Rollout, gae
from ued.learning.student import Student


class PPO(Resumable):
    """Improves one student from its rollouts. `generator` shuffles the minibatches.

    Raises:
        FloatingPointError: in `learn`, for gradients that are not finite.
    """

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
        """Update on the steps whose `train` mask is set; return the means of the losses over all minibatches.

        The mask does not change the size of minibatches. `env_steps` so far anneal the learning rate; `advantages`
        default to `gae`; `regularizer` keeps the student close to another policy.
        """
        config, device = self.config, self.student.device
        self._anneal(env_steps)
        advantages = gae(rollout, config.gamma, config.gae_lambda) if advantages is None else advantages  # [T, N]
        old = Batch.of(rollout, advantages, target=advantages + rollout.value).to(device)  # T * N rows
        sequences = self.student.actor_memory.sequences(rollout.train, config.bptt_steps).to(device)  # [S, L] rows
        if not len(sequences):
            return {"gradient_steps": 0.0, "trained_steps": 0.0}
        old.seen = self.student.see(old.observation)
        minibatch_size = -(-len(old.action) // sequences.shape[1] // config.num_minibatches)
        old.add_memories(self.student, config.bptt_steps, minibatch_size)
        logs: list[tuple[Losses, Tensor]] = []
        for _ in range(config.update_epochs):
            shuffled = sequences.index_select(0, torch.randperm(len(sequences), generator=self.generator).to(device))
            for minibatch in old.minibatches(shuffled, minibatch_size, config.norm_adv):
                logs.append(self._minibatch(minibatch, regularizer))
            if config.target_kl and approx_kl(logs[-1][0].log_ratio).mean() > config.target_kl:
                break
        learned = slice(None) if rollout.train.all() else rollout.train.flatten().to(device)  # of T * N
        # Tracked after the update, so that it normalizes as the rollout did; steps without `train` would shift them.
        self.student.normaliser.track(old.observation[learned])
        self.updates += 1
        return {
            **means(logs, config.clip_coef),
            "gradient_steps": float(len(logs)),
            "trained_steps": float(rollout.train.sum()),
            "explained_variance": explained_variance(old.value[learned], old.target[learned]),
            "learning_rate": self.optimizer.param_groups[0]["lr"],
        }

    def _anneal(self, env_steps: int) -> None:
        """Set the learning rate, which falls linearly to 0 over `anneal_env_steps` unless that number is 0."""
        if self.config.anneal_env_steps:
            left = max(0.0, 1.0 - env_steps / self.config.anneal_env_steps)
            self.optimizer.param_groups[0]["lr"] = self.config.learning_rate * left

    def _minibatch(self, old: Batch, regularizer: KLRegularizer | None) -> tuple[Losses, Tensor]:
        """Take one gradient step on one minibatch; return its losses, and the norm `[]` of its gradient."""
        self.optimizer.zero_grad()
        parts = backpropagate(self.student, old, self.config, regularizer)
        grad_norm = clip_gradient(self.student, self.optimizer, self.config.max_grad_norm)
        if not math.isfinite(grad_norm.item()):
            raise FloatingPointError(
                f"the gradient is not finite (loss {parts.total(self.config).item():g}): check for rewards or "
                "observations that are not finite, or use a smaller learning_rate"
            )
        self.optimizer.step()
        return parts, grad_norm


def explained_variance(value: Tensor, target: Tensor) -> float:
    """Return 1 - Var(target - value) / Var(target): 1 for perfect values, nan if the targets do not vary."""
    variance = target.var().item()
    return 1.0 - (target - value).var().item() / variance if variance > 0 else float("nan")
