"""A student's weights in the form of compiled rollouts: one row of numbers per policy, and a table of layers.

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
    """One row of the table: linear modules side by side on the same inputs."""

    modules: tuple[nn.Linear, ...]
    tanh: bool = False
    gru: bool = False


def layers_of(torso: nn.Sequential, memory: Memory, hidden: nn.Sequential, heads: Sequence[nn.Linear]) -> list[Layer]:
    """Return the layers of an MLP torso, a memory, a hidden layer, and heads that are evaluated as one layer."""
    layers, last = (
        [Layer((one,), tanh=True) for one in part if isinstance(one, nn.Linear)] for part in (torso, hidden)
    )
    layers += [Layer((memory.read,), gru=True), Layer((memory.recall,))] if isinstance(memory, GRU) else []
    return [*layers, *last, Layer(tuple(heads))]


def student_layers(student: Student) -> tuple[list[Layer], list[Layer]]:
    """Return the layers of actor and critic; with a shared torso the critic has none, see `Network`."""
    heads = (student.actor.layer, student.critic) if student.shared else (student.actor.layer,)
    actor = layers_of(student.actor_torso, student.actor_memory, student.actor_hidden, heads)
    if student.shared:
        return actor, []
    critic = layers_of(student.critic_torso, student.critic_memory, student.critic_hidden, (student.critic,))
    return actor, critic


def empty_policy(student: Student, size: int) -> Policy:
    """Allocate the record of a student whose agents observe vectors of this size."""
    actor, critic = student_layers(student)
    policies, critics = student.policies, 1 if student.central else student.policies
    table, critic_table = table_of(actor, policies), table_of(critic, critics)
    every = np.concatenate([table, critic_table])
    widest = int(max(every["inputs"].max(), every["outputs"].max()))
    width = student.actor_memory.width // student.agents
    critic_width = 0 if student.shared else student.critic_memory.width // (1 if student.central else student.agents)
    return Policy(
        actor=Network(np.zeros((policies, weights_of(actor, policies)), np.float32), table.view(np.recarray)),
        critic=Network(np.zeros((critics, weights_of(critic, critics)), np.float32), critic_table.view(np.recarray)),
        mean=np.zeros((policies, size), np.float32),
        deviation=np.ones((policies, size), np.float32),
        limit=np.full(1, CLIP, np.float32),
        numbered=student.numbered,
        central=student.central,
        actor_width=width,
        critic_width=critic_width,
        scratch=np.zeros((SCRATCH, LANES * widest), np.float32),
        state=np.zeros(LANES * max(1, width), np.float32),
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
    """Return the weights of a layer in their order, `[P, k]` each: modules side by side are one matrix and one bias."""
    matrices = [module.weight.view(policies, -1) for module in layer.modules]
    return [*matrices, *(module.bias.view(policies, -1) for module in layer.modules)]


def weights_of(layers: Sequence[Layer], policies: int) -> int:
    """Return the number of weights of each policy."""
    return sum(part.shape[1] for layer in layers for part in flat(layer, policies))


def table_of(layers: Sequence[Layer], policies: int) -> np.ndarray:
    """Return the table of layers, LAYER `[L]`."""
    table, at = np.zeros(len(layers), LAYER), 0
    for row, layer in zip(table, layers, strict=True):
        inputs = layer.modules[0].in_features
        outputs = sum(module.out_features for module in layer.modules) // policies
        row["tanh"], row["gru"], row["matrix"], row["bias"] = layer.tanh, layer.gru, at, at + inputs * outputs
        row["inputs"], row["outputs"] = inputs, outputs
        at += (inputs + 1) * outputs
    return table
