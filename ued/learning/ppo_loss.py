"""The loss of PPO: as a formula, and for categorical policies with its gradient in closed form.

Autograd needs 78 operations for `losses` and their gradient; `categorical_losses` returns the same numbers in 33.
Read next: `learning.ppo`, which uses the gradient.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from ued.config import PPOConfig
from ued.learning.minibatches import Batch
from ued.learning.networks import Policy

MEANS = ("policy_loss", "value_loss", "entropy", "approx_kl", "clip_fraction")  # metrics, in the order of `means`
BY_AGENT = ("entropy", "approx_kl")  # also reported for each agent of a team


class Losses(NamedTuple):
    """The parts of the loss at each of B steps, `[B]`, for a team `[B, A]`; see `total`."""

    surrogate: Tensor  # to be maximized: equation 7 of Schulman et al. 2017
    error: Tensor  # half the squared error of the value
    entropy: Tensor
    log_ratio: Tensor  # log of the ratio of new to old probability

    def total(self, config: PPOConfig) -> Tensor:
        """Return the loss `[]`, to be minimized (equation 9)."""
        return (config.vf_coef * self.error - self.surrogate - config.ent_coef * self.entropy).mean()

    def detach(self) -> Losses:
        """Return the same numbers without their gradient."""
        return Losses(*(part.detach() for part in self))


def losses(policy: Policy, value: Tensor, old: Batch, config: PPOConfig) -> Losses:
    """Return the losses of a policy and of values `[B]`, for a team `[B, A]`."""
    log_ratio = policy.log_prob(old.action) - old.log_prob  # [B]
    ratio = log_ratio.exp()  # [B]
    clipped = ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef)  # [B]
    surrogate = torch.min(old.advantage * ratio, old.advantage * clipped)  # [B]
    error = (value - old.target) ** 2 / 2  # [B]
    if config.clip_vloss:
        moved = (value - old.value).clamp(-config.clip_coef, config.clip_coef)  # [B]
        error = torch.max(error, (old.value + moved - old.target) ** 2 / 2)
    return Losses(surrogate, error, policy.entropy(), log_ratio)


@torch.no_grad()
def categorical_losses(logits: Tensor, value: Tensor, old: Batch, config: PPOConfig) -> tuple[Losses, Tensor, Tensor]:
    """Return the losses, and the gradients of their total with respect to logits and values.

    Logits z are `[B, n]`, or `[B, K, n]` for K choices; for a team `[B, A, ...]`. The gradient of the surrogate of a
    step with p = softmax(z), action a, ratio r and advantage A is

        A r ([i = a] - p_i), or 0 if the clipped term is smaller

    and the gradient of the entropy H = -Σ p_i log p_i of one choice is -p_i (log p_i + H).
    """
    old_log_prob, _, advantage, _ = old.numbers  # [B] each
    several, share = logits.ndim > value.ndim + 1, 1 / value.numel()
    log_probs, taken = torch.log_softmax(logits, -1), old.action.unsqueeze(-1)
    probs = log_probs.exp()
    weighted = probs * log_probs  # p_i log p_i
    negative, chosen = weighted.sum(-1), log_probs.gather(-1, taken).squeeze(-1)  # -H and log p_a, [B (, K)]
    log_ratio = (chosen.sum(-1) if several else chosen) - old_log_prob  # [B]
    ratio = log_ratio.exp()  # [B]
    plain = advantage * ratio  # [B]
    clipped = ratio.clamp_(1 - config.clip_coef, 1 + config.clip_coef).mul_(advantage)  # [B]
    surrogate = torch.min(plain, clipped)  # [B]
    by_log_prob = plain.masked_fill_(plain > clipped, 0.0).mul_(-share)  # [B], -A r / B; nan stays nan
    by_log_prob = by_log_prob.unsqueeze(-1) if several else by_log_prob
    # p_i (bonus (log p_i + H) - by_log_prob) + [i = a] by_log_prob
    bonus = config.ent_coef * share
    gradient = probs.mul_((negative * -bonus).sub_(by_log_prob).unsqueeze(-1)).add_(weighted, alpha=bonus)
    gradient.scatter_add_(-1, taken, by_log_prob.unsqueeze(-1).expand(taken.shape))
    error, by_value = _value_errors(value, old, config)
    entropy = -(negative.sum(-1) if several else negative)  # [B]
    return Losses(surrogate, error, entropy, log_ratio), gradient, by_value.mul_(config.vf_coef * share)


def _value_errors(value: Tensor, old: Batch, config: PPOConfig) -> tuple[Tensor, Tensor]:
    """Return half the squared errors `[B]` of values, and their derivatives `[B]`."""
    off = value - old.target
    error = off.square().div_(2)
    if not config.clip_vloss:
        return error, off
    moved = value - old.value
    inside = moved.clamp(-config.clip_coef, config.clip_coef)
    clipped = (old.value + inside).sub_(old.target).square_().div_(2)
    constant = (clipped > error) & (inside != moved)  # where the loss does not depend on the value
    return torch.max(error, clipped), off.masked_fill(constant, 0.0)


def approx_kl(log_ratio: Tensor) -> Tensor:
    """Return Schulman's k3 estimator of the divergence of the new policy from the old one: never negative."""
    return log_ratio.expm1().sub_(log_ratio)


def means(logs: Sequence[tuple[Losses, Tensor]], clip_coef: float) -> dict[str, float]:
    """Return the means of the minibatches' means, by name, and for a team also those of each agent.

    `logs` has the losses and the norm `[]` of the gradient of each minibatch. All numbers are read at once, since each
    read from a device waits for it.
    """
    minibatches, grad_norms = zip(*logs, strict=True)
    count = len(minibatches)
    share = torch.cat([each.error.new_full((len(each.error),), 1 / len(each.error) / count) for each in minibatches])
    surrogate, error, entropy, log_ratio = map(torch.cat, zip(*minibatches, strict=True))  # [S], for a team [S, A]
    clipped = (log_ratio.expm1().abs() > clip_coef).float()
    steps = torch.stack([-surrogate, error, entropy, approx_kl(log_ratio), clipped])
    numbers = share @ steps.view(len(steps), len(share), -1)  # [5, A]
    logged = dict(zip(MEANS, numbers.mean(1).tolist(), strict=True))
    logged["grad_norm"] = torch.stack(grad_norms).mean().item()
    if log_ratio.ndim > 1:
        rows = dict(zip(MEANS, numbers.tolist(), strict=True))
        for name in BY_AGENT:
            logged |= {f"agent_{agent}/{name}": number for agent, number in enumerate(rows[name])}
    return logged
