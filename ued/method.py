"""What every method gives: one training iteration at a time, with the levels that it was based on.

Read next: `methods`, the table of methods.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ued.learning.student import Student
from ued.learning.worker import Episodes


@dataclass(frozen=True)
class LevelBatch:
    """The L levels on which an update was based.

    Attributes:
        theta: `[L, D]`.
        returns: for each student, mean undiscounted return `[L]` over its whole episodes; nan where it has none.
        episodes: for each student, number of these episodes `[L]`.
        score: `[L]` what the teacher makes of the level (PAIRED: regret); nan where there is no teacher.
    """

    theta: np.ndarray
    returns: dict[str, np.ndarray]
    episodes: dict[str, np.ndarray]
    score: np.ndarray


class Method(Protocol):
    """A way to train students on levels of its choice.

    Attributes:
        student: the policy to evaluate (PAIRED: the protagonist).
        students: all policies in training, by name.
        env_steps: steps simulated so far, for whatever purpose.
        updates: training iterations so far.
        last: the levels that the last update was based on.
    """

    @property
    def student(self) -> Student: ...
    @property
    def students(self) -> Mapping[str, Student]: ...
    @property
    def env_steps(self) -> int: ...
    @property
    def updates(self) -> int: ...
    @property
    def last(self) -> LevelBatch | None: ...

    def update(self) -> dict[str, float]:
        """Do one training iteration; give its metrics."""

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Give everything: a method made anew with the same arguments resumes from it to the same numbers.

        `episodes=False` leaves out the state of the environments, which for a `GymUPOMDP` no checkpoint can hold; open
        episodes then begin anew.
        """

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""


def episode_metrics(name: str, episodes: Episodes) -> dict[str, float]:
    """Give mean return, mean length and number of a student's episodes; the means of none are nan."""
    count = len(episodes.returns)
    return {
        f"return/{name}": float(episodes.returns.mean()) if count else float("nan"),
        f"length/{name}": float(episodes.lengths.mean()) if count else float("nan"),
        f"episodes/{name}": float(count),
    }


def prefixed(prefix: str, metrics: Mapping[str, float]) -> dict[str, float]:
    """Give the metrics with `prefix/` before each name."""
    return {f"{prefix}/{key}": value for key, value in metrics.items()}
