"""The memory of a student within an episode: none, or a GRU.

Only this module distinguishes feed-forward students from recurrent ones. A memory is a layer between a torso and its
heads. It has the size of its state per environment (`width`, 0 without memory), and determines the sequences of
minibatches: single steps, or the whole sequences that backpropagation through time needs.
Read next: `learning.student`, which has one for its actor and one for its critic; `learning.minibatches`.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn

from ued.learning.networks import Team, linear


class Past(NamedTuple):
    """The sequences that rows of a batch form: L steps of B environments, step by step.

    Attributes:
        memory: `[B, W]` the state before the first of these steps.
        episode_starts: bool `[L, B]`, steps that start an episode, at which the state is reset; None: none, and L is 1.
        mask: bool `[L * B]`, rows whose outputs are returned; None: all.
    """

    memory: Tensor
    episode_starts: Tensor | None = None
    mask: Tensor | None = None


class NoMemory(nn.Module):
    """The memory of a feed-forward student, which has none."""

    width = 0

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return both unchanged."""
        return features, memory

    def sequences(self, train: Tensor) -> Tensor:
        """Return the sequences of minibatches, for a rollout with the mask `train` `[T, N]` of steps to learn from.

        Each of the S sequences holds the indices of its L rows in the flat rollout `[T * N]`: `[S, L]`.
        """
        return train.flatten().nonzero()


class GRU(nn.Module):
    """A gated recurrent unit (Cho et al. 2014, in cuDNN's form) for each agent, reset where episodes start.

    Backpropagation through time goes through a whole rollout, from the state at its first step.
    """

    def __init__(self, size: int, generator: torch.Generator, team: Team) -> None:
        super().__init__()
        self.width = team.agents * size
        self.read = linear(size, 3 * size, 1.0, generator, team.policies)
        self.recall = linear(size, 3 * size, 1.0, generator, team.policies)

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return features `[mask, (A,) size]` for `[L * B, (A,) size]`, and the state after them, `[B, W]`."""
        state = memory.view(len(memory), *features.shape[1:])  # [B, (A,) size]
        parts = 2 * state.shape[-1], state.shape[-1]  # of both gates, of the candidate
        read = self.read(features).unflatten(0, (-1, len(memory)))  # [L, B, (A,) 3 * size]
        goes_on = None
        if past.episode_starts is not None:
            goes_on = (~past.episode_starts).float().view(*read.shape[:2], *(1,) * (read.ndim - 2))
        states = []
        for t, now in enumerate(zip(*(part.unbind() for part in read.split(parts, -1)), strict=True)):
            state = state if goes_on is None else state * goes_on[t]
            recalled_gates, recalled = self.recall(state).split(parts, -1)
            reset, keep = torch.sigmoid(now[0] + recalled_gates).chunk(2, -1)
            candidate = torch.tanh(torch.addcmul(now[1], reset, recalled))
            state = torch.lerp(candidate, state, keep)
            states.append(state)
        remembered = torch.cat(states)
        return remembered if past.mask is None else remembered[past.mask], state.flatten(1)

    def sequences(self, train: Tensor) -> Tensor:
        """Return the rows of each environment with a step to learn from; see `NoMemory.sequences`."""
        rows = torch.arange(train.numel()).view(train.shape).T  # [N, T]
        return rows[train.any(0)]


Memory = NoMemory | GRU


def make_memory(kind: Literal["none", "gru"], size: int, generator: torch.Generator, team: Team) -> Memory:
    """Return a memory for a torso with `size` features."""
    return GRU(size, generator, team) if kind == "gru" else NoMemory()
