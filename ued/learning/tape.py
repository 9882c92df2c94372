"""The actions on each visit of a level, with which its episodes can be replayed bit for bit.

A replayed level has several visits, possibly at the same time. The level and the number of the visit determine all
random numbers of the environment, so the actions complete the episodes. Read next: `learning.worker`, which fills a
tape on request.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

NONE = -1  # no visit; visits are numbered from 0
MOST_VISITS = 4096  # maximum number stored without calls of `pop`


class ActionTape:
    """The actions in each of N environments since the start of its visit, and the actions of ended visits.

    Checkpoints do not include it, so a visit that started before the tape, or before a resumed run, has no actions.
    """

    def __init__(self, num_envs: int) -> None:
        self._visit = np.full(num_envs, NONE)  # [N] the visit that each environment plays
        self._began = np.zeros(num_envs, np.int64)  # [N] step of the tape at which it started
        self._steps = 0  # number of steps on the tape
        self._actions: np.ndarray | None = None  # [capacity, N, ...]
        self._over: OrderedDict[int, np.ndarray] = OrderedDict()  # by visit

    def begin(self, envs: np.ndarray, visits: np.ndarray, ago: int = 0) -> None:
        """Start these visits `[k]` in the environments `[k]`; the start was `ago` steps ago."""
        for env in envs:
            self._keep(int(env), self._steps - ago)
        self._visit[envs], self._began[envs] = visits, self._steps - ago

    def note(self, actions: np.ndarray) -> None:
        """Append the actions `[N, ...]` of a step."""
        self.extend(actions[None])

    def extend(self, actions: np.ndarray) -> None:
        """Append the actions of several steps, `[k, N, ...]`."""
        if self._actions is None:
            self._actions = np.empty((64, *actions.shape[1:]), actions.dtype)
        while self._steps + len(actions) > len(self._actions):
            self._make_room(len(actions))
        self._actions[self._steps : self._steps + len(actions)] = actions
        self._steps += len(actions)

    def pop(self, visits: np.ndarray) -> dict[int, np.ndarray]:
        """Remove and return the actions `[T, ...]` of these visits, by their numbers, if known.

        For a visit that continues, because its environment waits for others, return its actions so far.
        """
        for env in np.flatnonzero(np.isin(self._visit, visits)):
            self._keep(int(env), self._steps)
            self._visit[env] = NONE
        return {visit: self._over.pop(visit) for visit in visits.tolist() if visit in self._over}

    def _keep(self, env: int, end: int) -> None:
        if self._visit[env] != NONE and self._actions is not None:
            self._over[int(self._visit[env])] = self._actions[self._began[env] : end, env].copy()
            if len(self._over) > MOST_VISITS:
                self._over.popitem(last=False)

    def _make_room(self, steps: int) -> None:
        """Drop the steps before the oldest open visit; double the tape until half of it, and `steps`, are free."""
        assert self._actions is not None
        known = self._visit != NONE
        first = int(self._began[known].min()) if known.any() else self._steps
        kept = self._actions[first : self._steps].copy()
        capacity = len(self._actions)
        while max(2 * len(kept), len(kept) + steps) > capacity:
            capacity *= 2
        self._actions = np.empty((capacity, *kept.shape[1:]), kept.dtype)
        self._actions[: len(kept)] = kept
        self._began -= first
        self._steps = len(kept)
