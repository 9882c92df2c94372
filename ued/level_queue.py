"""The levels of PAIRED: both students play the same ones in the same order, the same number of whole episodes each.

A student's environment that has played its level often enough takes the next one from the queue, on its own, while the
others go on. So no episode is cut off by a change of level, none is lost or counted as 0, long episodes are not left
out, and no environment waits for the longest. A student whose episodes are shorter would run ahead; when it is
`max_lead` levels ahead of the other, it plays its level again until the other has caught up, and those episodes train
it but do not count. Read next: `methods.paired`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

NONE = -1  # an environment whose level is settled, and which plays on without counting
Supply = Callable[[int], np.ndarray]


def entry_dtype(level: np.dtype, dim: int, context_size: int, students: int, episodes: int) -> np.dtype:
    """Give the record of one level in the queue.

    level; origin (see `methods.paired`); the adversary's z, raw and log_prob; played `[S]` whole episodes of each
    student; returns `[S, n]` of these; score, which the method writes.
    """
    return np.dtype(
        [
            ("level", level),
            ("origin", np.int8),
            ("z", np.float32, (context_size,)),
            ("raw", np.float32, (dim,)),
            ("log_prob", np.float32),
            ("played", np.int32, (students,)),
            ("returns", np.float64, (students, episodes)),
            ("score", np.float64),
        ]
    )


class LevelQueue:
    """Hands levels to S students with N environments each, and keeps the returns until all have played.

    Args:
        supply: gives k new entries, as records of `entry_dtype`.
        dtype: that record.
        num_envs: N.
        max_lead: levels that one student may be ahead of another, at least N; 0: no new level before `clear`.
    """

    def __init__(self, supply: Supply, dtype: np.dtype, num_envs: int, max_lead: int) -> None:
        if 0 < max_lead < num_envs:
            raise ValueError(f"max_lead must be at least the number of environments ({num_envs}), got {max_lead}")
        self.supply, self.num_envs, self.max_lead = supply, num_envs, max_lead
        self.students, self.episodes = dtype["returns"].shape
        self.entries = np.zeros(0, dtype)  # in the order of play; settled ones leave in `take_settled`
        self.taken = np.zeros(self.students, np.int64)  # [S] entries that each student has begun: a prefix
        self.playing = np.full((self.students, num_envs), NONE)  # [S, N] which entry each environment plays

    def first(self, student: int) -> np.ndarray:
        """Give the levels `[N]` that a student starts with."""
        return self._take(student, np.arange(self.num_envs))

    def renew(self, student: int, ended: np.ndarray, returns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Note the returns `[k]` of episodes that ended; give which environments change level, and the levels."""
        entry = self.playing[student, ended]
        counts = entry != NONE
        counts[counts] = self.entries["played"][entry[counts], student] < self.episodes
        rows = entry[counts]
        self.entries["returns"][rows, student, self.entries["played"][rows, student]] = returns[counts]
        self.entries["played"][rows, student] += 1
        free = ended[~counts]
        through = ended[counts][self.entries["played"][rows, student] == self.episodes]
        waiting = np.concatenate([free, through])
        others = np.delete(self.taken, student)
        lead = int(self.taken[student] - others.min()) if len(others) else 0
        waiting = waiting[: max(0, self.max_lead - lead)]
        return waiting, self._take(student, waiting)

    def _take(self, student: int, envs: np.ndarray) -> np.ndarray:
        start = int(self.taken[student])
        missing = start + len(envs) - len(self.entries)
        if missing > 0:  # in blocks: one proposal of many costs hardly more than one of one
            self.entries = np.concatenate([self.entries, self.supply(max(missing, self.num_envs))])
        rows = np.arange(start, start + len(envs))
        self.playing[student, envs] = rows
        self.taken[student] += len(envs)
        return self.entries["level"][rows]

    def settled(self) -> np.ndarray:
        """Say for each entry whether every student has played it often enough."""
        return (self.entries["played"] == self.episodes).all(1)

    def take_settled(self) -> np.ndarray:
        """Remove and give the settled entries, in the order of play."""
        settled = self.settled()
        done, before = self.entries[settled], np.cumsum(settled) - settled
        index = np.where(settled, NONE, np.arange(len(self.entries)) - before)
        index = np.append(index, NONE)  # so that NONE, the last, stays NONE
        self.playing = index[self.playing]
        self.taken = self.taken - np.array([settled[:count].sum() for count in self.taken])
        self.entries = self.entries[~settled]
        return done

    def clear(self) -> None:
        """Forget all levels, settled or not; students begin again with `first`."""
        self.entries = self.entries[:0]
        self.taken[:] = 0
        self.playing[:] = NONE

    def drop_untaken(self) -> None:
        """Forget the entries that nobody has begun, so that the next are proposed by the teacher as it is now."""
        self.entries = self.entries[: int(self.taken.max())]

    def state_dict(self) -> dict[str, Any]:
        """Give the entries and who plays what."""
        return {"entries": self.entries.copy(), "taken": self.taken.copy(), "playing": self.playing.copy()}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.entries, self.taken = state["entries"].copy(), state["taken"].copy()
        self.playing = state["playing"].copy()
