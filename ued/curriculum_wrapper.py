"""A curriculum inside single Gymnasium environments, for trainers that reset environments as they please.

Stable-Baselines3 and many others know nothing of levels: they call `reset()` when an episode is over. So the
environment itself asks the curriculum what to play, and tells it what came of it. All environments must live in the
trainer's process (`DummyVecEnv`, `SyncVectorEnv`). Read next: `examples/with_stable_baselines3.py`.
"""

from __future__ import annotations

from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from ued.curriculum import Curriculum
from ued.gym_upomdp import UPOMDPWrapper


class CurriculumFeed:
    """Hands a curriculum's trials to environments one at a time, and brings it those that are through.

    The trainer's critic is not known here, so scores that need values are out of reach; and the trainer learns from
    all that it plays, so robust methods and candidates only looked at are not what their papers describe.

    Args:
        curriculum: what chooses the levels.
        batch: trials that are collected before the curriculum learns from them.
    """

    def __init__(self, curriculum: Curriculum, batch: int = 16) -> None:
        if batch < 1:
            raise ValueError(f"batch must be at least 1, got {batch}")
        self.curriculum, self.batch = curriculum, batch
        self.settled: list[np.ndarray] = []
        self.metrics: dict[str, float] = {}

    def next(self) -> np.ndarray:
        """Give one new trial, `[1]`."""
        return self.curriculum.propose(1)

    def give_back(self, trial: np.ndarray) -> None:
        """Take a trial `[1]` with its returns; let the curriculum learn when there are enough."""
        self.settled.append(trial)
        if len(self.settled) >= self.batch:
            self.metrics = self.curriculum.update(np.concatenate(self.settled))
            self.settled = []


class CurriculumWrapper(gymnasium.Wrapper):
    """An environment that plays the levels of a feed: each for as many whole episodes as its trial wants.

    `env` is a `UPOMDPWrapper`, bare: whatever wraps it comes on the outside. An episode that the trainer abandons by
    an early `reset` does not count.
    """

    def __init__(self, env: UPOMDPWrapper, feed: CurriculumFeed) -> None:
        super().__init__(env)
        self.feed = feed
        self.trial: np.ndarray | None = None
        self.total = 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode on the level whose turn it is; `options["theta"]` overrules the curriculum."""
        self.total = 0.0
        if options and "theta" in options:
            self.trial = None
            return self.env.reset(seed=seed, options=options)
        if self.trial is None:
            self.trial = self.feed.next()
        theta = self.trial["level"]["theta"][0]
        return self.env.reset(seed=seed, options={**(options or {}), "theta": theta})

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Step; note the return when the episode is over."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self.total += float(reward)
        if (terminated or truncated) and self.trial is not None:
            played = int(self.trial["played"][0, 0])
            self.trial["returns"][0, 0, played] = self.total
            self.trial["played"][0, 0] = played + 1
            if played + 1 == self.trial["wanted"][0]:
                self.feed.give_back(self.trial)
                self.trial = None
        return observation, reward, terminated, truncated, info
