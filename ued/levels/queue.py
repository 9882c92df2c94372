"""Which student plays which trial: all play the same levels in the same order, the same number of whole episodes each.

A student's environment that has played its level often enough takes the next one from the queue, on its own, while the
others go on. So no episode is cut off by a change of level, none is lost or counted as 0, long episodes are not left
out, and no environment waits for the longest. A student whose episodes are shorter would run ahead; when it is
`max_lead` levels ahead of the slowest, it plays its level again until the others have caught up, and those episodes
train it but do not count. Read next: `training`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ued.levels.record import NONE

Supply = Callable[[int], np.ndarray]


class TrialQueue:
    """Hands trials to S students with N environments each, and keeps the results until all have played.

    Args:
        supply: gives k new trials.
        dtype: their record, see `trials.trial_dtype`.
        num_envs: N.
        max_lead: levels that one student may be ahead of another, at least N; 0: no new level before `clear`.
        block: trials that are fetched at a time, where one request of many costs hardly more than one of one.
    """

    def __init__(self, supply: Supply, dtype: np.dtype, num_envs: int, max_lead: int, block: int = 1) -> None:
        if 0 < max_lead < num_envs:
            raise ValueError(f"max_lead must be at least the number of environments ({num_envs}), got {max_lead}")
        self.supply, self.num_envs, self.max_lead, self.block = supply, num_envs, max_lead, block
        self.students, self.episodes = dtype["returns"].shape
        self.trials = np.zeros(0, dtype)  # in the order of play; settled ones leave in `take_settled`
        self.taken = np.zeros(self.students, np.int64)  # [S] trials that each student has begun: a prefix
        self.playing = np.full((self.students, num_envs), NONE)  # [S, N] which trial each environment plays
        self._places: list[list[np.ndarray]] = [[] for _ in range(self.students)]  # where ended episodes are noted

    def first(self, student: int) -> np.ndarray:
        """Give the trials `[N]` that a student starts with."""
        return self._take(student, np.arange(self.num_envs))

    def renew(self, student: int, ended: np.ndarray, returns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Note the returns `[k]` of episodes that ended; give which environments change level, and their trials."""
        trial = self.playing[student, ended]
        counts = trial != NONE
        counts[counts] = self.trials["played"][trial[counts], student] < self.trials["wanted"][trial[counts]]
        rows = trial[counts]
        episode = self.trials["played"][rows, student]
        self.trials["returns"][rows, student, episode] = returns[counts]
        self.trials["played"][rows, student] += 1
        place = np.full((len(ended), 2), NONE)
        place[counts] = np.stack([rows, episode], 1)
        self._places[student].append(place)
        free = ended[~counts]
        through = ended[counts][self.trials["played"][rows, student] == self.trials["wanted"][rows]]
        waiting = np.concatenate([free, through])
        others = np.delete(self.taken, student)
        lead = int(self.taken[student] - others.min()) if len(others) else 0
        waiting = waiting[: max(0, self.max_lead - lead)]
        return waiting, self._take(student, waiting)

    def _take(self, student: int, envs: np.ndarray) -> np.ndarray:
        start = int(self.taken[student])
        missing = start + len(envs) - len(self.trials)
        if missing > 0:
            self.trials = np.concatenate([self.trials, self.supply(max(missing, self.block))])
        rows = np.arange(start, start + len(envs))
        self.playing[student, envs] = rows
        self.taken[student] += len(envs)
        return self.trials[rows]

    def note(self, student: int, values: dict[str, np.ndarray]) -> None:
        """Note more about the episodes `[E]` that `renew` was told of since the last call, in their order."""
        places, self._places[student] = self._places[student], []
        if not places:
            return
        place = np.concatenate(places)
        counts = place[:, 0] != NONE
        rows, episode = place[counts].T
        for name, column in values.items():
            self.trials[name][rows, student, episode] = column[counts]

    def settled(self) -> np.ndarray:
        """Say for each trial whether every student has played it often enough."""
        return np.all(self.trials["played"] >= self.trials["wanted"][:, None], axis=1)

    def take_settled(self) -> np.ndarray:
        """Remove and give the settled trials, in the order of play."""
        settled = self.settled()
        done, before = self.trials[settled], np.cumsum(settled) - settled
        index = np.where(settled, NONE, np.arange(len(self.trials)) - before)
        index = np.append(index, NONE)  # so that NONE, the last, stays NONE
        self.playing = index[self.playing]
        self.taken = self.taken - np.array([settled[:count].sum() for count in self.taken])
        self.trials = self.trials[~settled]
        self._places = [[] for _ in range(self.students)]
        return done

    def clear(self) -> None:
        """Forget all trials, settled or not; students begin again with `first`."""
        self.trials = self.trials[:0]
        self.taken[:] = 0
        self.playing[:] = NONE
        self._places = [[] for _ in range(self.students)]

    def drop_untaken(self) -> None:
        """Forget the trials that nobody has begun, so that the next are proposed by the teacher as it is now."""
        self.trials = self.trials[: int(self.taken.max())]

    def state_dict(self) -> dict[str, Any]:
        """Give the trials and who plays what, as they are between two updates."""
        return {"trials": self.trials.copy(), "taken": self.taken.copy(), "playing": self.playing.copy()}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.trials, self.taken = state["trials"].copy(), state["taken"].copy()
        self.playing = state["playing"].copy()
        self._places = [[] for _ in range(self.students)]
