"""A student's weights in the form that compiled rollouts read: one row of numbers per policy, and a table of layers.

Read next: `core.compiled`, the records; `learning.compiled`, which copies the weights before each rollout.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from ued.core.compiled import LANES, LAYER, SCRATCH, Network, Policy
from ued.learning.memory import GRU, Memory
from ued.learning.student import CLIP, Normaliser, Student


class Layer(NamedTuple):
    """One layer: linear modules side by side on the same inputs, or what a GRU reads and what it recalls."""

    modules: tuple[nn.Linear, ...]
    tanh: bool = False
    gru: bool = False


def layers_of(torso: nn.Sequential, memory: Memory, heads: Sequence[nn.Linear]) -> list[Layer]:
    """Return the layers of an MLP torso, a memory, and heads that are evaluated as one layer."""
    layers = [Layer((module,), tanh=True) for module in torso if isinstance(module, nn.Linear)]
    layers += [Layer((memory.read, memory.recall), gru=True)] if isinstance(memory, GRU) else []
    return [*layers, Layer(tuple(heads))]


def student_layers(student: Student) -> tuple[list[Layer], list[Layer]]:
    """Return the layers of actor and critic; with a shared torso the critic has none, see `Network`."""
    heads = (student.actor.layer, student.critic) if student.shared else (student.actor.layer,)
    actor = layers_of(student.actor_torso, student.actor_memory, heads)
    if student.shared:
        return actor, []
    return actor, layers_of(student.critic_torso, student.critic_memory, (student.critic,))


def empty_policy(student: Student, size: int) -> Policy:
    """Allocate the record of a student whose agents observe vectors of this size."""
    actor, critic = student_layers(student)
    policies, critics = student.policies, 1 if student.central else student.policies
    table, critic_table = table_of(actor, policies), table_of(critic, critics)
    every = np.concatenate([table, critic_table])
    widest = int(max(every["inputs"].max(), every["outputs"].max(), 3 * every["outputs"][every["gru"]].max(initial=0)))
    agents = student.agents
    width, critic_width = student.actor_memory.width, 0 if student.shared else student.critic_memory.width
    return Policy(
        actor=Network(np.zeros((policies, weights_of(actor, policies)), np.float32), table.view(np.recarray)),
        critic=Network(np.zeros((critics, weights_of(critic, critics)), np.float32), critic_table.view(np.recarray)),
        mean=np.zeros((policies, size), np.float32),
        deviation=np.ones((policies, size), np.float32),
        limit=np.full(1, CLIP, np.float32),
        numbered=student.numbered,
        central=student.central,
        actor_width=width // agents,
        critic_width=critic_width if student.central else critic_width // agents,
        scratch=np.zeros((SCRATCH, LANES * widest), np.float32),
        state=np.zeros(LANES * max(1, width, critic_width), np.float32),
    )


@torch.no_grad()
def fill_policy(policy: Policy, student: Student) -> None:
    """Copy the weights and the statistics of the normalizer into a record."""
    assert isinstance(student.normaliser, Normaliser)
    for network, layers in zip((policy.actor, policy.critic), student_layers(student), strict=True):
        if layers:
            parts = [part for layer in layers for part in flat(layer, len(network.weights))]
            torch.cat(parts, 1, out=torch.from_numpy(network.weights))
    policy.mean[:] = student.normaliser.mean.numpy()
    policy.deviation[:] = student.normaliser.deviation().numpy()


def flat(layer: Layer, policies: int) -> list[Tensor]:
    """Return the weights of a layer in their order, `[P, k]` each; heads side by side are one matrix and one bias."""
    matrices = [module.weight.view(policies, -1) for module in layer.modules]
    biases = [module.bias.view(policies, -1) for module in layer.modules]
    if layer.gru:
        return [part for pair in zip(matrices, biases, strict=True) for part in pair]
    return [*matrices, *biases]


def weights_of(layers: Sequence[Layer], policies: int) -> int:
    """Return the number of weights of each policy."""
    return sum(part.shape[1] for layer in layers for part in flat(layer, policies))


def table_of(layers: Sequence[Layer], policies: int) -> np.ndarray:
    """Return the table of layers, LAYER `[L]`."""
    table, at = np.zeros(len(layers), LAYER), 0
    for row, layer in zip(table, layers, strict=True):
        matrices = sum(module.weight.numel() for module in layer.modules) // policies
        first = layer.modules[0]
        outputs = sum(module.out_features for module in layer.modules) // policies
        size = first.in_features if layer.gru else outputs
        row["tanh"], row["gru"], row["matrix"], row["bias"] = layer.tanh, layer.gru, at, at + matrices
        row["inputs"], row["outputs"] = first.in_features, size
        at += sum(part.shape[1] for part in flat(layer, policies))
    return table
