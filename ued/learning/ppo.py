"""Proximal policy optimization (Schulman et al. 2017), flat: the order on the page is the order of execution.

    learning rate; advantages of the rollout by GAE, targets of the values                   (PPO.learn)
    for each epoch, for each minibatch of shuffled steps, or sequences
        ratio of new to old probability, clipped; loss of policy, value and entropy          (PPO._minibatch)
        gradient, clipped to a norm; one step of Adam                                        (PPO._step)

Written once, for every method, for one agent and for teams: observations, actions and values then have a further axis
of agents, `[B, A]`, and losses are means over them. Names are CleanRL's. Read next: `learning.minibatches`, how a
rollout becomes minibatches; `methods.dr`, the simplest use of PPO.
"""

from __future__ import annotations

import torch
from torch import Tensor

from ued.config import PPOConfig
from ued.core.resumable import Resumable
from ued.learning.fast_adam import Adam
from ued.learning.kl import KLRegularizer
from ued.learning.minibatches import Batch, by_agent, clip_gradient
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
        """Update on the steps whose `train` mask is set; return the means of the losses over all minibatches.

        The mask does not change the size of minibatches; if it is empty, nothing changes and `gradient_steps` is 0.
        `env_steps` so far anneal the learning rate; `advantages` default to `gae`; `regularizer` is another policy to
        stay close to. Raises `FloatingPointError` for a gradient that is not finite.
        """
        config, device = self.config, self.student.device
        self._anneal(env_steps)
        if advantages is None:
            advantages = gae(rollout, config.gamma, config.gae_lambda)  # [T, N]
        old = Batch.of(rollout, advantages, target=advantages + rollout.value).to(device)  # T * N rows
        sequences = self.student.actor_memory.sequences(rollout.train).to(device)  # [S, L] of these rows
        if not len(sequences):
            return {"gradient_steps": 0.0}
        minibatch_size = -(-len(old.value) // sequences.shape[1] // config.num_minibatches)
        logs = []
        for _ in range(config.update_epochs):
            shuffled = sequences[torch.randperm(len(sequences), generator=self.generator)]
            for minibatch in old.minibatches(shuffled, minibatch_size):
                logs.append(self._minibatch(minibatch, regularizer))
            if config.target_kl and logs[-1]["approx_kl"] > config.target_kl:
                break
        learned = rollout.train.flatten().to(device)  # [T * N]
        # After learning, which normalizes as the rollout did; steps without `train` would shift what the weights see.
        self.student.normaliser.track(old.observation if learned.all() else old.observation[learned])
        self.updates += 1
        return {
            **{name: sum(log[name] for log in logs) / len(logs) for name in logs[0]},
            "gradient_steps": float(len(logs)),
            "explained_variance": explained_variance(old.value[learned], old.target[learned]),
            "learning_rate": self.optimizer.param_groups[0]["lr"],
        }

    def _anneal(self, env_steps: int) -> None:
        """Set the learning rate, which falls linearly to 0 over `anneal_env_steps` unless that is 0."""
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
        if config.norm_adv and len(advantage) > 1:  # for each agent alone
            advantage = (advantage - advantage.mean(0)) / (advantage.std(0) + 1e-8)
        clipped = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)  # [B]
        policy_loss = -torch.min(advantage * ratio, advantage * clipped).mean()  # [], equation 7 of the paper
        error = (value - old.target) ** 2  # [B]
        if config.clip_vloss:
            moved = (value - old.value).clamp(-config.clip_coef, config.clip_coef)  # [B]
            error = torch.max(error, (old.value + moved - old.target) ** 2)
        value_loss = 0.5 * error.mean()  # []
        entropy = policy.entropy()  # [B]
        loss = policy_loss - config.ent_coef * entropy.mean() + config.vf_coef * value_loss
        if regularizer is not None:
            loss = loss + regularizer.coef * regularizer.divergence(old, policy)
        grad_norm = self._step(loss)
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

    def _step(self, loss: Tensor) -> Tensor:
        """Take a step down the gradient of the loss `[]`; return the norm `[]` of the gradient before clipping."""
        self.optimizer.zero_grad()
        loss.backward()
        grad_norm = clip_gradient(self.student, self.optimizer, self.config.max_grad_norm)
        if not torch.isfinite(grad_norm):
            raise FloatingPointError(
                f"the gradient is not finite (loss {loss.item():g}): look for rewards or observations that are not "
                "finite, or try a smaller learning_rate"
            )
        self.optimizer.step()
        return grad_norm


def explained_variance(value: Tensor, target: Tensor) -> float:
    """Return 1 - Var(target - value) / Var(target): 1 for perfect values, nan where the targets do not vary."""
    variance = target.var().item()
    return 1.0 - (target - value).var().item() / variance if variance > 0 else float("nan")
