"""The memory of a student within an episode: none, or a GRU.

Only this module distinguishes feed-forward and recurrent students. A memory is a layer between a torso and its
heads. Its `width` is the size of its state per environment (0 without memory). It also determines the sequences of
minibatches: single steps, or the sequences that backpropagation through time needs.
Read next: `learning.student`, which has one for its actor and one for its critic; `learning.minibatches`.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn

from ued.learning.networks import Team, linear
from ued.learning.recurrence import Recurrence, segments


class Past(NamedTuple):
    """The sequences that rows of a batch form: L steps of B environments, step by step.

    Attributes:
        memory: `[B, W]` the state before the first of these steps.
        episode_starts: bool `[L, B]`, steps that start an episode, at which the state is reset; None: none, and L is 1.
        mask: bool, rows whose outputs are returned; None: all.
        kept: bool `[L, B]`, steps that have a row in the batch, the first ones of each episode; None: all. Steps after
            the last training step of an episode need none.
    """

    memory: Tensor
    episode_starts: Tensor | None = None
    mask: Tensor | None = None
    kept: Tensor | None = None


class NoMemory(nn.Module):
    """An empty memory, for feed-forward students."""

    width = 0

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return features and memory unchanged."""
        return features, memory

    def sequences(self, train: Tensor, bptt_steps: int = 0) -> Tensor:
        """Return the sequences of minibatches, for a rollout with the mask `train` `[T, N]` of steps to learn from.

        Each of the S sequences holds the indices of its L rows in the flat rollout `[T * N]`: `[S, L]`.
        """
        return train.flatten().nonzero()


class GRU(nn.Module):
    """A gated recurrent unit (Cho et al. 2014, in cuDNN's form) for each agent, reset where episodes start.

    Backpropagation through time covers a whole rollout or pieces of it, each from the state at its first step; see
    `Batch.add_memories`. The GRU has `size` units and, by default, as many inputs.
    """

    def __init__(self, size: int, generator: torch.Generator, team: Team, inputs: int | None = None) -> None:
        super().__init__()
        self.size, self.width = size, team.agents * size
        self.policies = team.policies
        self.read = linear(size if inputs is None else inputs, 3 * size, 1.0, generator, team.policies)
        self.recall = linear(size, 3 * size, 1.0, generator, team.policies)

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return features `[mask, (A,) size]` for `[L * B, (A,) inputs]`, and the state after them, `[B, W]`.

        If steps are left out (`past.kept`), the state is returned unchanged.
        """
        state = memory.view(len(memory), *features.shape[1:-1], self.size)  # [B, (A,) size]
        begins = past.episode_starts
        if len(features) == len(state) and past.kept is None:
            states = self._step(features, state if begins is None else _masked(state, begins[0], 0))
        else:
            states = self._steps(features, state, begins, past.kept)
        after = states[-len(state) :].flatten(1) if past.kept is None else memory
        return states if past.mask is None else states[past.mask], after

    def _step(self, features: Tensor, state: Tensor) -> Tensor:
        """Return the states `[B, (A,) size]` after one step."""
        parts = 2 * state.shape[-1], state.shape[-1]  # sizes of both gates and of the candidate
        gates, candidate = self.read(features).split(parts, -1)
        recalled_gates, recalled = self.recall(state).split(parts, -1)
        reset, keep = torch.sigmoid(gates + recalled_gates).chunk(2, -1)
        return torch.lerp(torch.tanh(torch.addcmul(candidate, reset, recalled)), state, keep)

    def _steps(self, features: Tensor, state: Tensor, begins: Tensor | None, kept: Tensor | None) -> Tensor:
        """Return the states `[L * B, (A,) size]` after each of L (kept) steps; see `learning.recurrence`."""
        envs, agents = len(state), state.shape[1:-1].numel()
        begins = state.new_zeros(len(features) // envs, envs, dtype=torch.bool) if begins is None else begins
        if self.policies > 1:  # a leading policy axis
            by_row, state = features.transpose(0, 1), state.transpose(0, 1)
        else:  # agents of a policy are like environments
            by_row, state = features.flatten(0, -2), state.flatten(0, -2)
            begins, envs = begins.repeat_interleave(agents, 1), envs * agents
            kept = None if kept is None else kept.repeat_interleave(agents, 1)
        packed = segments(begins, kept)
        env = packed.first % envs
        start = _masked(state.index_select(-2, env), (packed.first >= envs) | begins[0, env], -2)
        weights = (part for layer in (self.read, self.recall) for part in self._by_policy(layer))
        states = Recurrence.apply(by_row, start, *weights, packed)
        return states.transpose(0, 1) if self.policies > 1 else states.unflatten(0, features.shape[:-1])

    def _by_policy(self, layer: nn.Linear) -> tuple[Tensor, Tensor]:
        """Return the weights `[3 size, size]` and `[1, 3 size]`; for several policies `[P, ...]`."""
        if self.policies == 1:
            return layer.weight, layer.bias[None]
        return layer.weight.view(self.policies, -1, layer.in_features), layer.bias.view(self.policies, 1, -1)

    def sequences(self, train: Tensor, bptt_steps: int = 0) -> Tensor:
        """Return the rows of each piece of `bptt_steps` steps of an environment with a step to learn from.

        0: pieces are whole rollouts. See `NoMemory.sequences`.
        """
        num_steps, num_envs = train.shape  # N may be 0
        length = bptt_steps or num_steps
        count = num_steps // length
        rows = torch.arange(train.numel()).view(count, length, num_envs)  # [T / L, L, N]
        rows = rows.transpose(1, 2).reshape(count * num_envs, length)  # [T / L * N, L]
        return rows[train.flatten()[rows].any(1)]


def _masked(state: Tensor, begins: Tensor, axis: int) -> Tensor:
    """Return states with 0 where an episode begins, bool for each index of an axis."""
    shape = [1] * state.ndim
    shape[axis] = len(begins)
    return state.masked_fill(begins.view(shape), 0.0)


Memory = NoMemory | GRU


def make_memory(kind: Literal["none", "gru"], size: int, generator: torch.Generator, team: Team, inputs: int) -> Memory:
    """Return a memory of `size` units for a torso with `inputs` features."""
    return GRU(size, generator, team, inputs) if kind == "gru" else NoMemory()
