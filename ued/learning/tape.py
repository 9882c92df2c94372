"""What was done on each level, so that the very episodes that made its score can be played again.

A turn is one playing of a level; a level that is replayed has several, and may have them at the same time.

A level and the number of its turn, the visit, say all that an environment draws; with the actions they are the episode,
bit for bit. Read next: `learning.worker`, which keeps a tape where somebody has asked for one.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

NONE = -1  # no turn: they are numbers from 0 on
MOST_TURNS = 4096  # kept for somebody who never asks


class ActionTape:
    """The actions in each of N environments since its turn began, and those of turns that are over.

    It is no part of a checkpoint: of a turn that was begun before the tape was, or before a kill, nothing is known.
    """

    def __init__(self, num_envs: int) -> None:
        self._turn = np.full(num_envs, NONE)  # [N] that each plays
        self._began = np.zeros(num_envs, np.int64)  # [N] step of the tape at which that began
        self._steps = 0  # on the tape
        self._actions: np.ndarray | None = None  # [capacity, N, ...]
        self._over: OrderedDict[int, np.ndarray] = OrderedDict()  # by turn

    def begin(self, envs: np.ndarray, turns: np.ndarray) -> None:
        """Note that the environments `[k]` begin these turns `[k]`."""
        for env in envs:
            self._keep(int(env))
        self._turn[envs], self._began[envs] = turns, self._steps

    def note(self, actions: np.ndarray) -> None:
        """Note the actions `[N, ...]` of a step."""
        if self._actions is None:
            self._actions = np.empty((64, *actions.shape), actions.dtype)
        if self._steps == len(self._actions):
            self._make_room()
        self._actions[self._steps] = actions
        self._steps += 1

    def pop(self, turns: np.ndarray) -> dict[int, np.ndarray]:
        """Return the actions `[T, ...]` of these turns, by their numbers, as far as they are known, and forget them.

        A turn that goes on, because its environment waits for others, is told up to now.
        """
        for env in np.flatnonzero(np.isin(self._turn, turns)):
            self._keep(int(env))
            self._turn[env] = NONE
        return {turn: self._over.pop(turn) for turn in turns.tolist() if turn in self._over}

    def _keep(self, env: int) -> None:
        if self._turn[env] != NONE and self._actions is not None:
            self._over[int(self._turn[env])] = self._actions[self._began[env] : self._steps, env].copy()
            if len(self._over) > MOST_TURNS:
                self._over.popitem(last=False)

    def _make_room(self) -> None:
        """Drop the steps before the oldest open turn, and double the tape where that is not half of it."""
        assert self._actions is not None
        known = self._turn != NONE
        first = int(self._began[known].min()) if known.any() else self._steps
        kept = self._actions[first : self._steps].copy()
        capacity = len(self._actions) if 2 * len(kept) <= len(self._actions) else 2 * len(self._actions)
        self._actions = np.empty((capacity, *kept.shape[1:]), kept.dtype)
        self._actions[: len(kept)] = kept
        self._began -= first
        self._steps = len(kept)
