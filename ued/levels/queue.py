"""The queue of levels: all students play the same levels in the same order, for the same number of whole episodes.

An environment that has finished the episodes of its level takes the next level from the queue while the others
continue. So a change of level interrupts no episode, long episodes count like short ones, and no environment waits for
the longest episode. A student with shorter episodes gets ahead. Once it is `max_lead` levels ahead of the slowest
student, it repeats levels until the others have caught up. It learns from these episodes, but they are not results.
Read next: `methods.method`, whose `collect_rollouts` uses this queue.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from typing import Any

import numpy as np

from ued.core.compiled import Events
from ued.core.curriculum import Curriculum
from ued.core.level_space import SEEDS, as_void_view
from ued.core.resumable import Resumable
from ued.core.upomdp import PREFETCH
from ued.levels.record import NONE, number

# Levels proposed ahead if all proposals are played: at least this many, and for many environments a share of their
# number, since proposing many levels takes little longer than proposing one.
PROPOSAL_BATCH, PROPOSAL_SHARE = 8, 4
# The same for environments that prepare levels in blocks, see `propose_in_blocks`. If all proposals are played, there
# is at most one per environment.
BLOCK, PLAYED_BLOCK = 64, 16


class LevelQueue(Resumable):
    """Passes level records to S students with N environments each, and stores results until all have played a level.

    Args:
        curriculum: proposes the levels.
        num_envs: N.
        max_lead: maximum lead of one student over another in levels, at least N; 0: no new level before `clear`.
        drop_stale_proposals: after each update, drop the proposals that no student has started, so that the updated
            curriculum proposes the next levels. Not for a curriculum whose proposals change its state, such as replay.
        resample_level_every: an environment takes a new level each time it has finished the episodes of its level
            ("episode"), or only the first time in each rollout ("rollout").

    Attributes:
        prefetch: for each student, the function that announces to its environments which levels it will play next,
            `[k]` of them; see `UPOMDP.prefetch`.

    Raises `ValueError` for a `max_lead` between 0 and N.
    """

    state_fields = ("records", "taken", "playing", "next_id", "next_visit")

    def __init__(
        self,
        curriculum: Curriculum,
        num_envs: int,
        max_lead: int | None = None,
        drop_stale_proposals: bool = True,
        resample_level_every: str = "episode",
    ) -> None:
        self.max_lead = 2 * num_envs if max_lead is None else max_lead
        if 0 < self.max_lead < num_envs:
            raise ValueError(f"max_lead must be at least the number of environments ({num_envs}), got {max_lead}")
        self.curriculum, self.num_envs = curriculum, num_envs
        self.drop_stale_proposals, self.once_per_rollout = drop_stale_proposals, resample_level_every == "rollout"
        self.proposal_batch = num_envs if drop_stale_proposals else max(PROPOSAL_BATCH, num_envs // PROPOSAL_SHARE)
        self.students = curriculum.dtype["returns"].shape[0]
        self.records = np.zeros(0, curriculum.dtype)  # in the order of play; `pop_finished` removes finished ones
        self.taken = np.zeros(self.students, np.int64)  # [S] number of records that each student has started
        self.playing = np.full(
            (self.students, num_envs), NONE
        )  # [S, N] index of the record that each environment plays
        self.next_id = self.next_visit = 0  # next numbers of a level and of a visit
        self.needs_new_level = np.ones((self.students, num_envs), bool)  # [S, N], used for one level per rollout
        self.prefetch: list[Callable[[np.ndarray], None]] = [lambda levels: None] * self.students
        self._announced = [NONE] * self.students  # the last visit announced to each student's environments
        self._forget_ended()

    def first(self, student: int) -> np.ndarray:
        """Return the first records `[N]` of a student, a view that is valid until the next call."""
        return self._take(student, np.arange(self.num_envs))

    def begin_rollout(self) -> None:
        """Allow each environment to take a new level again, if it may do so once per rollout."""
        self.needs_new_level[:] = True

    def on_episode_end(
        self, student: int, ended: np.ndarray, returns: np.ndarray, success: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Store returns and success `[k]` of the episodes that ended in the environments `ended` `[k]`.

        Return the environments `[c]` that change their level, and their new records `[c]`, a view as in `first`. The
        others repeat their level.
        """
        if self.once_per_rollout:  # only the first episode counts
            first = self.needs_new_level[student, ended]
            ended, returns, success = ended[first], returns[first], success[first]
        envs, due = ended.tolist(), self._due[student]  # lists: faster for few environments
        left = [due[env] for env in envs]  # includes the episode that ended
        self._ended[student].append((self.playing[student, ended], left, returns, success))
        for env in envs:
            due[env] -= 1
        waiting = [env for env in envs if due[env] < 0] + [env for env in envs if not due[env]]
        taken = self.taken.tolist()
        waiting = waiting[: max(0, self.max_lead - (taken[student] - min(taken)))]
        changing = np.array(waiting, np.int64)
        if self.once_per_rollout:
            self.needs_new_level[student, changing] = False
        return changing, self._take(student, changing)

    def propose_in_blocks(self) -> None:
        """Propose more levels at a time, for environments that prepare many levels in little more time than one.

        Other environments would prepare levels that are not played, since an update may drop the rest of a block.
        Without a lead, students play only the first levels.
        """
        if self.max_lead:
            block = BLOCK if self.drop_stale_proposals else min(PLAYED_BLOCK, self.num_envs)
            self.proposal_batch = max(self.proposal_batch, block)

    def of(self, student: int) -> StudentQueue:
        """Return the part of the queue that belongs to one student."""
        return StudentQueue(self, student)

    def _take(self, student: int, envs: np.ndarray) -> np.ndarray:
        start = int(self.taken[student])
        missing = start + len(envs) - len(self.records)
        if missing > 0:
            proposals = self.curriculum.propose(max(missing, self.proposal_batch))
            self.next_id = number(proposals, self.next_id)
            proposals["visit"] = self.next_visit + np.arange(len(proposals))
            self.next_visit += len(proposals)
            joined = np.concatenate([as_void_view(self.records), as_void_view(proposals)])
            self.records = joined.view(self.records.dtype)
        records = self.records[start : start + len(envs)]
        if len(envs):
            self.playing[student, envs] = np.arange(start, start + len(envs))
            for env, episodes in zip(envs.tolist(), records["num_episodes"].tolist(), strict=True):
                self._due[student][env] = episodes
            self.taken[student] += len(envs)
            self.announce_if_new(student)
        return records

    def announce_if_new(self, student: int) -> None:
        """Announce the next levels to a student's environments, once it has started all announced ones."""
        start = int(self.taken[student])
        if not start or self.records["visit"][start - 1] <= self._announced[student]:
            return
        coming = self.records[start : start + PREFETCH]
        self._announced[student] = int(coming["visit"][-1] if len(coming) else self.records["visit"][start - 1])
        self.prefetch[student](coming["level"])

    def visits(self, student: int) -> np.ndarray:
        """Return the visit that each of a student's environments plays `[N]`; NONE without a level."""
        return np.append(self.records["visit"], NONE)[self.playing[student]]  # NONE, -1, is the last index

    def record_value_stats(self, student: int, stats: dict[str, np.ndarray]) -> None:
        """Store the critic's statistics of the E episodes that ended since the last call, in their order: `[E]` each.

        With one level per rollout they are dropped, since they include episodes that do not count.
        """
        self._write_results(student, {} if self.once_per_rollout else stats)

    def _write_results(self, student: int, stats: dict[str, np.ndarray]) -> None:
        """Write the results of the E episodes that ended since the last call, and stats `[E]`, into their records.

        This happens once per rollout: writing into a few records takes as long as into all.
        """
        if not self._ended[student]:
            return
        playing, left, *results = zip(*self._ended[student], strict=True)
        self._ended[student] = []
        rows, returns, success = map(np.concatenate, (playing, *results))  # [E]
        due = np.array([*chain.from_iterable(left)], np.int64)  # [E]
        counted = due > 0
        rows, due = rows[counted], due[counted]
        for name, column in ({"returns": returns, "success": success} | stats).items():
            self.records[name][rows, student, self.records["num_episodes"][rows] - due] = column[counted]
        np.add.at(self.records["num_played"][:, student], rows, 1)

    def _forget_ended(self) -> None:
        self._due = [
            [0] * self.num_envs for _ in range(self.students)
        ]  # [S][N] episodes left on the level of each environment
        # for the episodes that ended in each step [k]: record, episodes left, returns, success
        self._ended: list[list[tuple[Any, ...]]] = [[] for _ in range(self.students)]

    def finished(self) -> np.ndarray:
        """Return which records every student has finished: bool `[R]`."""
        for student in range(self.students):
            self._write_results(student, {})
        return np.all(self.records["num_played"] >= self.records["num_episodes"][:, None], axis=1)

    def pop_finished(self) -> np.ndarray:
        """Remove and return the finished records `[L]`, in the order of play; drop stale proposals."""
        finished = self.finished()
        records, before = as_void_view(self.records), np.cumsum(finished) - finished
        index = np.where(finished, NONE, np.arange(len(self.records)) - before)
        index = np.append(index, NONE)  # so that NONE, the last index, stays NONE
        self.playing = index[self.playing]
        self.taken = self.taken - np.array([finished[:count].sum() for count in self.taken])
        self.records = records[~finished].view(self.curriculum.dtype)
        if self.drop_stale_proposals:
            self.records = self.records[: int(self.taken.max())]
        return records[finished].view(self.curriculum.dtype)

    def clear(self) -> None:
        """Drop all records, finished or not; students start again with `first`."""
        self.records = self.records[:0]
        self.taken[:] = 0
        self.playing[:] = NONE
        self._forget_ended()

    def state_dict(self) -> dict[str, Any]:
        """Return a copy of the whole state."""
        self.finished()
        return super().state_dict()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        Raises ValueError if its level records have other fields, or if an environment plays a missing record.
        """
        expected, stored = self.records.dtype.names or (), state["records"].dtype.names or ()
        if expected != stored:
            raise ValueError(f"level records have the fields {', '.join(expected)}, these {', '.join(stored)}")
        super().load_state_dict(state)
        rows, (students, episodes) = len(self.records), self.records.dtype["returns"].shape
        _check_range("playing", self.playing, (students, self.num_envs), NONE, rows - 1)
        _check_range("taken", self.taken, (students,), 0, rows)
        _check_range("num_episodes", self.records["num_episodes"], (rows,), 0, episodes)
        _check_range("num_played", self.records["num_played"], (rows, students), 0, episodes)
        self._forget_ended()  # episodes of an interrupted update
        self._announced = [NONE] * self.students
        due = self.records["num_episodes"][:, None] - self.records["num_played"]  # [R, S]
        due = np.concatenate([due, np.zeros((1, students), np.int64)])  # NONE, -1, is the last index
        self._due = due[self.playing, np.arange(students)[:, None]].tolist()


class StudentQueue:
    """One student's part of a queue: an `OnEpisodeEnd`, and the `LevelsAhead` of compiled rollouts."""

    def __init__(self, queue: LevelQueue, student: int) -> None:
        self.queue, self.student = queue, student

    def __call__(self, ended: np.ndarray, returns: np.ndarray, success: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LevelQueue.on_episode_end`."""
        return self.queue.on_episode_end(self.student, ended, returns, success)

    def at_hand(self) -> np.ndarray:
        """Return the next records, at most PREFETCH; none with one level per rollout: each end then needs a call."""
        start = int(self.queue.taken[self.student])
        return self.queue.records[start : start + (0 if self.queue.once_per_rollout else PREFETCH)]

    def most(self) -> int:
        """Return how many levels the student may take before its lead over the slowest other student is `max_lead`."""
        taken = self.queue.taken.tolist()
        others = taken[: self.student] + taken[self.student + 1 :]
        if not others:
            return SEEDS if self.queue.max_lead else 0
        return max(0, min(others) + self.queue.max_lead - taken[self.student])

    def due(self) -> list[int]:
        """Return the episodes left on the level of each environment `[N]`."""
        due = self.queue._due[self.student]
        return [1] * len(due) if self.queue.once_per_rollout else due

    def apply(self, events: Events, due: list[int]) -> None:
        """Record the episodes that ended, the levels taken, and the current `due`."""
        if not len(events.env):
            return
        queue, start = self.queue, int(self.queue.taken[self.student])
        playing, rows = queue.playing[self.student].tolist(), []
        for env, taken in zip(events.env.tolist(), events.taken.tolist(), strict=True):
            rows.append(playing[env])
            playing[env] = start + taken if taken >= 0 else playing[env]
        ended = np.array(rows), events.left.tolist(), events.returns.copy(), events.success.copy()
        queue._ended[self.student].append(ended)
        queue._due[self.student], queue.playing[self.student] = due, playing
        queue.taken[self.student] += int((events.taken >= 0).sum())
        queue.announce_if_new(self.student)


def _check_range(name: str, numbers: np.ndarray, shape: tuple[int, ...], low: int, high: int) -> None:
    if numbers.shape != shape or (numbers.size and (numbers.min() < low or numbers.max() > high)):
        raise ValueError(f"{name} must have shape {list(shape)} and values from {low} to {high}")
