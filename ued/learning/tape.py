"""The actions on each visit of a level, from which its episodes can be replayed bit for bit.

A replayed level has several visits, possibly at the same time. The level and the number of the visit determine all
random numbers of the environment, so the actions complete the episodes. Read next: `learning.worker`, which fills a
tape on request.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

NONE = -1  # no turn; turns are numbered from 0
MOST_TURNS = 4096  # kept if nobody calls `pop`


class ActionTape:
    """The actions in each of N environments since its turn began, and those of ended turns.

    Checkpoints do not include it, so a turn that started before the tape, or before a resumed run, has no actions.
    """

    def __init__(self, num_envs: int) -> None:
        self._turn = np.full(num_envs, NONE)  # [N] the one that each environment plays
        self._began = np.zeros(num_envs, np.int64)  # [N] step of the tape at which it started
        self._steps = 0  # on the tape
        self._actions: np.ndarray | None = None  # [capacity, N, ...]
        self._over: OrderedDict[int, np.ndarray] = OrderedDict()  # by turn

    def begin(self, envs: np.ndarray, turns: np.ndarray) -> None:
        """Start these turns `[k]` in the environments `[k]`."""
        for env in envs:
            self._keep(int(env))
        self._turn[envs], self._began[envs] = turns, self._steps

    def note(self, actions: np.ndarray) -> None:
        """Append the actions `[N, ...]` of a step."""
        if self._actions is None:
            self._actions = np.empty((64, *actions.shape), actions.dtype)
        if self._steps == len(self._actions):
            self._make_room()
        self._actions[self._steps] = actions
        self._steps += 1

    def pop(self, turns: np.ndarray) -> dict[int, np.ndarray]:
        """Remove and return the actions `[T, ...]` of these turns, by their numbers, if known.

        A turn that continues, because its environment waits for others, has its actions so far.
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
