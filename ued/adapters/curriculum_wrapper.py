"""A curriculum inside single Gymnasium environments, for trainers that reset environments on their own.

Stable-Baselines3 and many other trainers do not support levels: they call `reset()` at the end of an episode. So the
environment itself requests levels from the curriculum and reports the results. All environments must run in the
trainer's process (`DummyVecEnv`, `SyncVectorEnv`). Read next: `examples/with_stable_baselines3.py`.
"""

from __future__ import annotations

from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from ued.adapters.gym import UPOMDPWrapper
from ued.adapters.level_env import level_in_words
from ued.adapters.success import SuccessReports
from ued.core.curriculum import Curriculum
from ued.core.level_space import as_void_view
from ued.core.resumable import Resumable


class CurriculumFeed(Resumable):
    """Passes the levels of a curriculum to environments one at a time, and returns the results to the curriculum.

    It has no access to the trainer's critic, so scores that need values are not supported. The trainer learns from
    every episode, so robust methods, and methods with candidates that are only evaluated, differ from their papers.

    Args:
        curriculum: chooses the levels for one student.
        batch: number of level records that are collected before the curriculum learns from them.

    Raises:
        ValueError: a batch below 1, or a curriculum of several students, such as PAIRED's.
    """

    state_fields = ("curriculum", "visits", "finished", "again")

    def __init__(self, curriculum: Curriculum, batch: int = 16) -> None:
        if batch < 1:
            raise ValueError(f"batch must be at least 1, got {batch}")
        if (students := curriculum.dtype["returns"].shape[0]) > 1:
            raise ValueError(f"the trainer has one student, {type(curriculum).__name__} needs {students}")
        self.curriculum, self.batch = curriculum, batch
        self.finished = np.zeros(0, curriculum.dtype)
        self.again = np.zeros(0, curriculum.dtype)  # records that were handed out, but not finished
        self.visits = 0  # number of visits so far
        self.metrics: dict[str, float] = {}
        self._open: dict[int, np.ndarray] = {}  # records in play, by visit, as they were handed out

    def next(self) -> np.ndarray:
        """Return the next level record `[1]`: a visit of a new or replayed level."""
        if len(self.again):
            record, self.again = self.again[:1].copy(), self.again[1:]
        else:
            record = self.curriculum.propose(1)
            record["visit"] = self.visits
            self.visits += 1
        self._open[int(record["visit"][0])] = record.copy()
        return record

    def finish(self, record: np.ndarray) -> None:
        """Store a record `[1]` with its returns; update the curriculum when there are `batch` of them."""
        self._open.pop(int(record["visit"][0]), None)
        self.finished = _joined(self.finished, record)
        if len(self.finished) >= self.batch:
            finished, self.finished = self.finished, self.finished[:0]
            self.metrics = self.curriculum.update(finished)

    def give_back(self, record: np.ndarray) -> None:
        """Take back an unfinished record `[1]`; `next` returns it again."""
        self.again = _joined(self.again, self._open.pop(int(record["visit"][0])))

    def state_dict(self) -> dict[str, Any]:
        """Return a copy of the whole state; a resumed feed hands out the records in play again."""
        return super().state_dict() | {"again": _joined(self.again, *self._open.values())}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`; older states lack the finished and unfinished records."""
        none = np.zeros(0, self.curriculum.dtype)
        super().load_state_dict({"finished": none, "again": none} | state)
        self._open = {}


def _joined(*records: np.ndarray) -> np.ndarray:
    """Return the concatenation of level records `[k]`."""
    return np.concatenate([as_void_view(part) for part in records]).view(records[0].dtype)


class CurriculumWrapper(gymnasium.Wrapper):
    """An environment that plays the levels of a feed: each for as many whole episodes as its record specifies.

    `env` is a bare `UPOMDPWrapper`: put other wrappers around this one. An episode that the trainer abandons by an
    early `reset` does not count.
    """

    env: UPOMDPWrapper

    def __init__(self, env: UPOMDPWrapper, feed: CurriculumFeed) -> None:
        super().__init__(env)
        self.feed = feed
        self.record: np.ndarray | None = None  # [1] of the level being played
        self.total = 0.0
        self._reports = SuccessReports(self._level)

    def _level(self, _: int) -> str:
        return level_in_words(self.env.theta_map, self.env.start.theta, self.env.start.seed)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode on the current level; `options["theta"]` and `["level"]` override the curriculum.

        All episodes of a visit start from the layout of the level's own seed; `seed` applies only to other levels.
        """
        self.total = 0.0
        options = options or {}
        if options.keys() & {"theta", "level"}:
            if self.record is not None:
                self.feed.give_back(self.record)
            self.record = None
            return self.env.reset(seed=seed, options=options)
        if self.record is not None:
            return self.env.play_again(options)
        self.record = self.feed.next()
        level = {"level": self.record["level"], "visit": int(self.record["visit"][0])}
        return self.env.reset(seed=seed, options={**options, **level})

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Step; record the return when the episode is over."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self.total += float(reward)
        if (terminated or truncated) and self.record is not None:
            num_played = int(self.record["num_played"][0, 0])
            self.record["returns"][0, 0, num_played] = self.total
            self.record["success"][0, 0, num_played] = self._reports.read(info, np.ones(1, bool))[0]
            self.record["num_played"][0, 0] = num_played + 1
            if num_played + 1 == self.record["num_episodes"][0]:
                self.feed.finish(self.record)
                self.record = None
        return observation, reward, terminated, truncated, info
