"""The minimax adversary (Dennis et al. 2020, section 3): a teacher that is paid what the student loses.

    repeat
        the adversary proposes levels; the student plays them and learns
        the adversary learns to lower the student's mean return

It ends at levels that nobody can solve; it is here to be compared with. Read next: `methods.self_regret`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import MinimaxConfig, PPOConfig
from ued.curriculum import LevelSpace
from ued.levels.record import mean_returns
from ued.levels.teacher import Teacher
from ued.training import Training
from ued.upomdp import UPOMDP


class MinimaxLevels:
    """Proposes levels on which the student fails. A `Curriculum`; see `Teacher` for the arguments."""

    def __init__(self, space: LevelSpace, config: MinimaxConfig, seed: int = 0) -> None:
        self.teacher = Teacher(space, config, 1, config.episodes_per_level, seed)
        self.dtype = self.teacher.dtype

    def propose(self, count: int) -> np.ndarray:
        """Ask the adversary."""
        return self.teacher.propose(count)

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Pay the adversary the student's return, negated: the mean over episodes, as the paper has it."""
        trials["score"] = -mean_returns(trials)[:, 0]
        return self.teacher.learn(trials)

    def state_dict(self) -> dict[str, Any]:
        return self.teacher.state_dict()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        self.teacher.load_state_dict(state)


class Minimax(Training):
    """Trains one student against an adversary. A `Method`; see `Training` for the arguments.

    Raises `ValueError` where the environment has no free parameters.
    """

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: MinimaxConfig | None = None, seed: int = 0
    ) -> None:
        config = config or MinimaxConfig()
        super().__init__(upomdp, lambda space, seed: MinimaxLevels(space, config, seed), ppo, seed)
