"""Demonstrations as training data: chunks of steps, with some episodes held out.

Parts of a folder are merged into chunks that fit into memory; if all of them fit, they are read once. Read next:
`ued.learning.cloning`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch

from regista.envs.football.constants import NUM_ACTIONS
from regista.experiments.imitation.demonstrations import Demonstrations, Summary
from regista.experiments.run.errors import CommandError
from ued.learning.cloning import Demonstrated, discounted

CHUNK_BYTES = 256 * 2**20


class CloningData:
    """The steps of all saved episodes. `validation` is the held-out share of episodes, sampled with `seed`.

    Attributes:
        opponents: whether agents are opponents with individual returns; see `UPOMDP.individual_rewards`.

    Raises `CommandError` for a folder with missing or damaged files, or with fewer than two episodes.
    """

    def __init__(self, demos: Demonstrations, gamma: float, validation: float, seed: int) -> None:
        self.demos, self.gamma, self.opponents = demos, gamma, False
        self.episodes = demos.num_episodes()
        summaries = list(demos.summaries())
        saved = sum(int(summary.kept.sum()) for summary in summaries)
        if saved < self.episodes:
            raise CommandError(
                f"{demos.path} is incomplete: it holds {saved} of its {self.episodes} episodes; run the same regista "
                "demonstrate command to play the missing ones"
            )
        if self.episodes < 2:
            raise CommandError(f"{demos.path} has {self.episodes} episodes; cloning needs at least two")
        held_out = min(max(round(validation * self.episodes), 1), self.episodes - 1)
        order = np.random.default_rng(seed).permutation(self.episodes)
        self.is_held_out = np.isin(np.arange(self.episodes), order[:held_out])
        self._parts = _parts_of(summaries, self.episodes)
        self._groups = self._grouped(summaries)
        self._whole: dict[bool, Demonstrated] = {}  # cached demonstrations that fit into memory; key: whether held out

    @property
    def observation_shape(self) -> tuple[int, ...]:
        """The shape of one observation, including all agents."""
        return self._shapes[0]

    @property
    def action_shape(self) -> tuple[int, ...]:
        """The shape of one step's actions: () for one agent, (A,) for several."""
        return self._shapes[1]

    def chunks(self, held_out: bool, generator: torch.Generator | None = None) -> Iterator[Demonstrated]:
        """Yield chunks of the training or held-out steps; with a generator they are shuffled."""
        if len(self._groups) == 1:
            if held_out not in self._whole:
                self._whole[held_out] = self._read(self._groups[0], held_out)
            yield self._whole[held_out]
            return
        order = (
            range(len(self._groups)) if generator is None else torch.randperm(len(self._groups), generator=generator)
        )
        for number in order:
            chunk = self._read(self._groups[int(number)], held_out)
            if len(chunk.returns):
                yield chunk

    def _grouped(self, summaries: Sequence[Summary]) -> list[list[int]]:
        """Return the parts in groups of at most CHUNK_BYTES of observations in memory."""
        first = next(part for part, episodes in enumerate(self._parts) if episodes)
        with self.demos.reading(first) as file:
            seen, actions = (file[f"episode_{self._parts[first][0]}/{name}"] for name in ("observations", "actions"))
            size = seen.dtype.itemsize * int(np.prod(seen.shape[1:]))
            self._shapes = tuple(seen.shape[1:]), tuple(actions.shape[1:])
        groups: list[list[int]] = [[]]
        room = CHUNK_BYTES
        for part, summary in enumerate(summaries):
            needed = size * int(summary.lengths[summary.kept].sum())
            if groups[-1] and needed > room:
                groups.append([])
                room = CHUNK_BYTES
            groups[-1].append(part)
            room -= needed
        return groups

    def _read(self, parts: Sequence[int], held_out: bool) -> Demonstrated:
        columns: list[list[np.ndarray]] = [[], [], [], []]
        for part in parts:
            with self.demos.reading(part) as file:
                for episode in self._parts[part]:
                    if self.is_held_out[episode] == held_out:
                        for column, array in zip(columns, self._steps(file, episode), strict=True):
                            column.append(array)
        if not columns[0]:
            nothing = torch.zeros(0)
            return Demonstrated(nothing, nothing.long(), nothing.bool(), nothing)
        seen, actions, mask, returns = (torch.from_numpy(np.concatenate(column)) for column in columns)
        return Demonstrated(seen, actions.long(), mask, returns.float())

    def _steps(self, file: Any, episode: int) -> tuple[np.ndarray, ...]:
        """Return observations, actions, mask of known actions, and returns of an episode.

        Raises `ValueError` for arrays of inconsistent shapes or invalid values.
        """
        group = file[f"episode_{episode}"]
        paid, by_agent = ("infos/agent_rewards", self._shapes[1]) if self.opponents else ("rewards", ())
        actions, mask, rewards = (group[name][()] for name in ("actions", "infos/told", paid))
        seen = group["observations"][: len(actions)]
        shapes = seen.shape == (len(actions), *self._shapes[0]) and rewards.shape == (len(actions), *by_agent)
        if not shapes or actions.shape[1:] != self._shapes[1] or mask.shape != actions.shape:
            raise ValueError("its arrays have inconsistent shapes")
        whole = mask.dtype == bool and actions.dtype.kind == "i" and ((actions >= 0) & (actions < NUM_ACTIONS)).all()
        if not whole or not (np.isfinite(rewards).all() and np.isfinite(seen).all()):
            raise ValueError("observations must be finite and actions in [0, 19)")
        return seen, actions, mask, discounted(rewards, self.gamma)


def _parts_of(summaries: Sequence[Summary], episodes: int) -> list[list[int]]:
    """Return the numbers of saved episodes of each part, among the first `episodes` ones."""
    parts, first = [], 0
    for summary in summaries:
        after = first + int(summary.kept.sum())
        parts.append([number for number in range(first, after) if number < episodes])
        first = after
    return parts
