"""Domain randomisation (Tobin et al. 2017): the student trains on levels drawn uniformly at random.

    repeat
        draw levels uniformly
        the student plays them and learns

The baseline of every comparison. The strong form draws a new level for every episode; the weak one, in which parts of
the literature run it, keeps a level for a rollout. Read next: `methods.plr`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import DRConfig, PPOConfig
from ued.curriculum import LevelSpace
from ued.levels.record import Origin, make_trials, trial_dtype
from ued.training import Training
from ued.upomdp import UPOMDP, level_dtype


class RandomLevels:
    """Proposes uniform levels and learns nothing. A `Curriculum`."""

    def __init__(self, space: LevelSpace) -> None:
        self.space = space
        self.dtype = trial_dtype(level_dtype(space.theta_dim))

    def propose(self, count: int) -> np.ndarray:
        """Draw `count` levels uniformly."""
        return make_trials(self.dtype, self.space.sample_levels(count), Origin.RANDOM)

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Learn nothing."""
        return {}

    def state_dict(self) -> dict[str, Any]:
        return {}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        pass


class DR(Training):
    """Trains one student on random levels. A `Method`; see `Training` for the arguments."""

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: DRConfig | None = None, seed: int = 0
    ) -> None:
        keep = (config or DRConfig()).new_level
        super().__init__(upomdp, lambda space, seed: RandomLevels(space), ppo, seed, keep=keep)
