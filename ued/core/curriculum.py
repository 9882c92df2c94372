"""The interface between a curriculum, which chooses levels, and any trainer, which trains on them.

    records = curriculum.propose(num_envs)     # levels to play, and whether to learn from them
    ...                                        # play them; fill in records["returns"] and other results
    metrics = curriculum.update(records)       # the curriculum learns from the results

A curriculum contains no environment, student network or rollout. DR, PLR, ACCEL, SFL, NCC, ALP-GMM, minimax,
self-regret and PAIRED's teacher are curricula. Read next: `methods.method`, our trainer; `methods`, the curricula;
`examples`, with other trainers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ued.core.level_space import LevelSpace, check_theta, level_dtype
from ued.core.parameters import Theta, ThetaMap
from ued.core.resumable import Resumable


class Curriculum(Protocol):
    """Chooses levels and learns from the results of students on them.

    Attributes:
        dtype: dtype of its level records, see `levels.record.level_record_dtype`.
    """

    @property
    def dtype(self) -> np.dtype: ...

    def propose(self, count: int) -> np.ndarray:
        """Return `count` level records without results."""

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Learn from records with results, and write their scores; return metrics.

        Records may come in any order and number, but each must have a finished episode.
        """

    def state_dict(self) -> dict[str, Any]:
        """Return the whole state, from which a curriculum made with the same arguments resumes."""

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`."""


def need_vector(space: LevelSpace) -> None:
    """Raise `ValueError` for a space without a vector θ of numbers: no parameters, or a family of levels."""
    if not space.theta_dim:
        raise ValueError("the environment has no free parameters for a curriculum to choose; use dr")
    if space.level_family is not None:
        raise ValueError(
            f"levels of {type(space.level_family).__name__} can be sampled and mutated, but not chosen by theta; "
            "use dr, plr, robust_plr, accel, cenie, sfl or ncc"
        )


class ThetaSpace(LevelSpace, Resumable):
    """Levels θ in [-1, 1]^D for your own trainer, without a `UPOMDP`.

    Args:
        dim: D, or the parameters, as for `theta` of `GymUPOMDP`.
        valid: returns which rows of θ `[n, D]` are valid, bool `[n]`; None: all.
        seed: seed of the random stream of levels and their seeds.
    """

    state_fields = ("stream",)

    def __init__(self, dim: Theta, valid: Callable[[np.ndarray], np.ndarray] | None = None, seed: int = 0) -> None:
        self.theta_map = ThetaMap(dim)
        self.parameters, self.level_family = self.theta_map.draws, self.theta_map.level_family
        self.seeds = self.theta_map.seeds
        self.stream = np.random.default_rng([1, seed])  # differs from the stream of a curriculum with the same seed
        self._valid = valid

    @property
    def _stream(self) -> np.random.Generator:
        return self.stream

    def valid(self, theta: Any) -> np.ndarray:
        if self._valid is None:
            return super().valid(theta)
        return np.asarray(self._valid(check_theta(theta, self.theta_dim)), bool)


class RandomLevelPool(Resumable):
    """Random levels, sampled in blocks: validating a block takes little more time than validating one level."""

    state_fields = ("levels",)

    def __init__(self, space: LevelSpace, block: int = 64) -> None:
        self.space, self.block = space, block
        self.levels = np.zeros(0, level_dtype(space.theta_dim))

    def take(self, count: int) -> np.ndarray:
        """Return `count` uniformly sampled levels."""
        if count > len(self.levels):
            self.levels = np.concatenate([self.levels, self.space.sample_levels(max(count, self.block))])
        taken, self.levels = self.levels[:count], self.levels[count:]
        return taken
