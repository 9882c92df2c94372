"""Levels that are not vectors of parameters: the interface of a family, and its optional part for adversaries.

Every family can be sampled and mutated, which is enough for DR, PLR, ACCEL and SFL. Adversaries (PAIRED, REPAIRED,
minimax, self-regret) need one of two further attributes:

    parameters      the columns of its codes: an adversary chooses all of them at once
    builder         a `LevelBuilder`: an adversary builds a level step by step

Read next: `parameters`, the kinds of columns; `levels.builder`, the adversary that builds.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class LevelFamily(Protocol):
    """Levels that are not vectors of parameters: mazes, tracks, graphs.

    A level may be any object; its code, numbers in [-1, 1], is stored and compared. Equal levels have equal codes.
    Four attributes are optional:
        parameters: a mapping from the name of each column of a code, in their order, to its `Range`, `LogRange`,
            `Integer`, `Choice` or a pair (low, high). An adversary then chooses a value for each column, and `decode`
            makes a level from the values. A column of K values is set to the center of one of the K equal parts of
            [-1, 1]. The weights of a `Choice` are the adversary's initial probabilities.
        builder: a `LevelBuilder`.
        simplest: `simplest(rng)` samples a level from which edits may begin, such as an empty room (Parker-Holder et
            al. 2022, section 3): `--accel.new-levels simplest`.
        valid: `valid(codes)` returns which codes `[n, size]` describe levels, bool `[n]`; without it, all do.

    Attributes:
        size: length of a code.
    """

    @property
    def size(self) -> int: ...

    def sample(self, rng: np.random.Generator) -> Any:
        """Sample a valid level."""

    def mutate(self, level: Any, rng: np.random.Generator) -> Any:
        """Return a valid level that differs a little from this one."""

    def encode(self, level: Any) -> np.ndarray:
        """Return the code `[size]` of a level."""

    def decode(self, code: np.ndarray) -> Any:
        """Return the level of a code `[size]`."""


@runtime_checkable
class LevelBuilder(Protocol):
    """The steps in which an adversary builds levels, for n levels at a time (Dennis et al. 2020, section 5).

    Levels under construction are one object of any type, which `apply` may change in place. All randomness must follow
    from a level's luck. The adversary stores only the luck and the actions of a level, and rebuilds the level when its
    score is available.

    Attributes:
        steps: number of steps K, the same for all levels.
        actions: number of actions A in each step.
    """

    @property
    def steps(self) -> int: ...

    @property
    def actions(self) -> int: ...

    def begin(self, luck: np.ndarray) -> Any:
        """Return n empty levels; `luck` `[n]` are random integers from 0 to 2^31 - 1."""

    def apply(self, levels: Any, actions: np.ndarray) -> Any:
        """Return the levels after an action in each, int64 `[n]` from 0 to A - 1."""

    def observe(self, levels: Any) -> np.ndarray:
        """Return the adversary's observations of the levels, `[n, F]` in about [-1, 1].

        The step number and a random vector are appended to them.
        """

    def codes(self, levels: Any) -> np.ndarray:
        """Return the codes `[n, size]` of finished levels."""
