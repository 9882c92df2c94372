"""What a student remembers of an episode: nothing, or the state of a GRU.

This is the one place that tells a feed-forward student from a recurrent one. A memory sits between a torso and its
heads; it says how many numbers it keeps of each environment (`width`, 0 where it keeps nothing), and of which steps
minibatches are made: of single ones, or of the whole sequences that backpropagation through time needs.
Read next: `learning.student`, which has one for its actor and one for its critic; `learning.ppo`, which looks back.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn

from ued.learning.networks import Team, linear


class Past(NamedTuple):
    """How the rows that a student looks at hang together: L steps of B environments, step by step.

    Attributes:
        memory: `[B, W]` what it remembered before the first of these steps.
        begins: bool `[L, B]`, an episode begins with this step, and what was remembered before is forgotten; None:
            L is 1, and `memory` says all.
        told: bool `[L * B]`, for which rows an answer is wanted; None: for all.
    """

    memory: Tensor
    begins: Tensor | None = None
    told: Tensor | None = None


class NoMemory(nn.Module):
    """Steps have nothing to do with each other: a feed-forward student."""

    width = 0

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return both as they are."""
        return features, memory

    def sequences(self, train: Tensor) -> Tensor:
        """Return what minibatches are made of, for a rollout whose steps `train` `[T, N]` are to be learned from.

        Each of S sequences holds the numbers of its L rows of the flat rollout `[T * N]`: `[S, L]`.
        """
        return train.flatten().nonzero()


class GRU(nn.Module):
    """A gated recurrent unit (Cho et al. 2014, as cuDNN has it) for each agent, reset where episodes begin.

    Truncated backpropagation through time: a rollout is looked back on whole, from what was remembered when it began.
    """

    def __init__(self, size: int, generator: torch.Generator, team: Team) -> None:
        super().__init__()
        self.width = team.agents * size
        self.read = linear(size, 3 * size, 1.0, generator, team.policies)
        self.recall = linear(size, 3 * size, 1.0, generator, team.policies)

    def forward(self, features: Tensor, memory: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        """Return features `[told, (A,) size]` for `[L * B, (A,) size]`, and what is remembered after them, `[B, W]`."""
        state = memory.view(len(memory), *features.shape[1:])  # [B, (A,) size]
        parts = 2 * state.shape[-1], state.shape[-1]  # of both gates, of the candidate
        read = self.read(features).unflatten(0, (-1, len(memory)))  # [L, B, (A,) 3 * size]
        goes_on = None if past.begins is None else (~past.begins).float().view(*read.shape[:2], *(1,) * (read.ndim - 2))
        states = []
        for t, now in enumerate(zip(*(part.unbind() for part in read.split(parts, -1)), strict=True)):
            state = state if goes_on is None else state * goes_on[t]
            recalled_gates, recalled = self.recall(state).split(parts, -1)
            reset, keep = torch.sigmoid(now[0] + recalled_gates).chunk(2, -1)
            candidate = torch.tanh(torch.addcmul(now[1], reset, recalled))
            state = torch.lerp(candidate, state, keep)
            states.append(state)
        remembered = torch.cat(states)
        return remembered if past.told is None else remembered[past.told], state.flatten(1)

    def sequences(self, train: Tensor) -> Tensor:
        """Return the rows of each environment that has something to be learned from; see `NoMemory.sequences`."""
        rows = torch.arange(train.numel()).view(train.shape).T  # [N, T]
        return rows[train.any(0)]


Memory = NoMemory | GRU


def make_memory(kind: Literal["none", "gru"], size: int, generator: torch.Generator, team: Team) -> Memory:
    """Return a memory behind a torso of so many features."""
    return GRU(size, generator, team) if kind == "gru" else NoMemory()
