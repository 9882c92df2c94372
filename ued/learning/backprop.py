"""The gradient of PPO's loss on a minibatch, by the fastest of three methods with equal results.

    any policy              autograd, from the formula of the loss
    categorical policies    autograd through the networks; the gradients of logits and values have a closed form
    ... of tanh layers      by hand, for one agent without memory, regularizer or frozen weights: no graph is built

With two layers of 64 units, an update by hand takes 6/7 of the time of the closed form with autograd.
Read next: `learning.ppo_loss`, the loss and its closed form.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.learning.kl import KLRegularizer
from ued.learning.minibatches import Batch
from ued.learning.networks import Categorical
from ued.learning.ppo_loss import Losses, categorical_losses, losses
from ued.learning.recurrence import TANH_BACKWARD
from ued.learning.student import Student


def backpropagate(student: Student, old: Batch, config: PPOConfig, regularizer: KLRegularizer | None = None) -> Losses:
    """Add the gradient of the loss on a minibatch to `grad` of the student's weights, which is 0; return the losses."""
    seen = student.normaliser(old.observation) if old.seen is None else old.seen
    if regularizer is None and has_tanh_layers(student) and learns_all(student):
        return by_hand(student, seen, old, config)
    policy, value = student.policy_and_value(seen, old.past)  # B distributions, [B]
    outputs: list[Tensor]
    gradients: list[Tensor | None]  # of the loss by each output; None: the output is a part of the loss
    if isinstance(policy, Categorical):
        parts, *gradients = categorical_losses(policy.logits, value, old, config)
        outputs = [policy.logits, value]
    else:
        parts = losses(policy, value, old, config)
        outputs, gradients = [parts.total(config)], [None]
    if regularizer is not None:
        outputs.append(regularizer.coef * regularizer.divergence(old, policy))  # []
        gradients.append(None)
    # a frozen actor or critic has an output without gradient
    learned = [place for place, output in enumerate(outputs) if output.requires_grad]
    torch.autograd.backward([outputs[place] for place in learned], [gradients[place] for place in learned])
    return parts.detach()


def has_tanh_layers(student: Student) -> bool:
    """Return whether `by_hand` supports the student's networks."""
    layers = (*student.actor_torso, *student.critic_torso)
    known = all(type(layer) in (nn.Linear, nn.Tanh) for layer in layers) and not len(student.actor_hidden)
    return known and student.agents == 1 and not student.memory_width and student.actor.single


def learns_all(student: Student) -> bool:
    """Return whether no weight of the layers is frozen, for students with `has_tanh_layers`."""
    layers = (*student.actor_torso, *student.critic_torso, student.actor.layer, student.critic)
    return all(layer.weight.requires_grad and layer.bias.requires_grad for layer in layers if type(layer) is nn.Linear)


@torch.no_grad()
def by_hand(student: Student, seen: Tensor, old: Batch, config: PPOConfig) -> Losses:
    """Write the gradient of the loss to `grad` of the weights; return the losses.

    For students with `has_tanh_layers` and `learns_all`: it writes to frozen weights, too.
    """
    actor = _features(student.actor_torso, seen)
    critic = actor if student.shared else _features(student.critic_torso, seen)
    head = student.actor.layer
    logits, value = _linear(head, actor[-1]), _linear(student.critic, critic[-1])
    parts, by_logits, by_value = categorical_losses(logits, value.squeeze(-1), old, config)
    by_value = by_value.unsqueeze(-1)
    _to_weights(head, actor[-1], by_logits)
    _to_weights(student.critic, critic[-1], by_value)
    by_features = by_logits @ head.weight
    if student.shared:
        by_features.addmm_(by_value, student.critic.weight)
    else:
        _backward(student.critic_torso, critic, by_value @ student.critic.weight)
    _backward(student.actor_torso, actor, by_features)
    return parts


def _linear(layer: nn.Linear, features: Tensor) -> Tensor:
    return torch.addmm(layer.bias, features, layer.weight.t())


def _features(torso: nn.Sequential, seen: Tensor) -> list[Tensor]:
    """Return the inputs of each tanh layer and the output of the last layer, `[B, ...]` each."""
    features = [seen]
    for layer in torso:
        if isinstance(layer, nn.Linear):
            features.append(_linear(layer, features[-1]).tanh_())
    return features


def _backward(torso: nn.Sequential, features: Sequence[Tensor], gradient: Tensor) -> None:
    """Write the gradient of the weights of tanh layers, given the gradient `[B, size]` of their last output."""
    layers = [layer for layer in torso if isinstance(layer, nn.Linear)]
    for depth in reversed(range(len(layers))):
        gradient = TANH_BACKWARD(gradient, features[depth + 1])
        _to_weights(layers[depth], features[depth], gradient)
        if depth:
            gradient = gradient @ layers[depth].weight


def _to_weights(layer: nn.Linear, features: Tensor, gradient: Tensor) -> None:
    """Write the gradient of a layer's weights, given its inputs and the gradient of its outputs."""
    assert layer.weight.grad is not None and layer.bias.grad is not None
    torch.mm(gradient.t(), features, out=layer.weight.grad)
    torch.sum(gradient, 0, out=layer.bias.grad)
