"""The seam between a curriculum and a trainer, ours or yours: who chooses levels, and who trains on them.

    records = curriculum.propose(num_envs)     # which levels to play, and whether to learn from them
    ...                                        # play them; fill in records["returns"] and the like
    metrics = curriculum.update(records)       # the curriculum learns what came of them

A curriculum owns no environment, no network of a student and no rollout: DR, PLR, ACCEL, SFL, ALP-GMM, minimax,
self-regret and PAIRED's teacher all are curricula. Read next: `methods.method`, our trainer; `methods`, the curricula;
`examples` for other people's trainers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ued.core.level_space import LevelSpace, check_theta, level_dtype
from ued.core.parameters import Theta, ThetaMap
from ued.core.resumable import Resumable


class Curriculum(Protocol):
    """Chooses levels and learns from what students make of them.

    Attributes:
        dtype: of its level records, see `levels.record.level_record_dtype`.
    """

    @property
    def dtype(self) -> np.dtype: ...

    def propose(self, count: int) -> np.ndarray:
        """Return `count` level records with their results open."""

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Take records with their results, write their scores, learn from them; return metrics.

        Records may come back in any order and any number; one without a finished episode must not come back.
        """

    def state_dict(self) -> dict[str, Any]:
        """Return everything: a curriculum made anew with the same arguments resumes from it."""

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned."""


def need_vector(space: LevelSpace) -> None:
    """Raise `ValueError` for a space of levels among which no θ can be chosen: none at all, or levels of a family."""
    if not space.theta_dim:
        raise ValueError("there is nothing to choose: the environment has no free parameters; use dr")
    if space.family is not None:
        raise ValueError(
            f"levels of {type(space.family).__name__} can be drawn and mutated, but not placed; "
            "use dr, plr, robust_plr, accel or sfl"
        )


class ThetaSpace(LevelSpace, Resumable):
    """Levels θ in [-1, 1]^D for a trainer of one's own, which needs no `UPOMDP`.

    Args:
        dim: D, or what the columns are, as `GymUPOMDP` takes `theta`.
        valid: says which rows of θ `[n, D]` can be played; None: all.
        seed: of the stream from which levels and their seeds are drawn.
    """

    state_fields = ("stream",)

    def __init__(self, dim: Theta, valid: Callable[[np.ndarray], np.ndarray] | None = None, seed: int = 0) -> None:
        self.theta_map = ThetaMap(dim)
        self.draws, self.family = self.theta_map.draws, self.theta_map.family
        self.stream = np.random.default_rng(seed)
        self._valid = valid

    @property
    def _stream(self) -> np.random.Generator:
        return self.stream

    def valid(self, theta: Any) -> np.ndarray:
        if self._valid is None:
            return super().valid(theta)
        return np.asarray(self._valid(check_theta(theta, self.theta_dim)), bool)


class RandomLevelPool(Resumable):
    """Random levels in reserve, drawn in blocks: checking a block of them costs hardly more than checking one."""

    state_fields = ("levels",)

    def __init__(self, space: LevelSpace, block: int = 64) -> None:
        self.space, self.block = space, block
        self.levels = np.zeros(0, level_dtype(space.theta_dim))

    def take(self, count: int) -> np.ndarray:
        """Return `count` levels drawn uniformly."""
        if count > len(self.levels):
            self.levels = np.concatenate([self.levels, self.space.sample_levels(max(count, self.block))])
        taken, self.levels = self.levels[:count], self.levels[count:]
        return taken
