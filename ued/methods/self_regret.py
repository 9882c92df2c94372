"""Self-regret: PAIRED's adversary with one student, whose later episodes on a level stand for the antagonist's.

    repeat
        the adversary proposes levels; the student plays 2 n episodes on each, and learns
        self-regret of a level = the best of the later n episodes - the mean of the earlier n
        the adversary learns to cause self-regret

With outcomes 0 and 1 of probability p and n = 2 the expectation is p (1 - p): the objective of learnability by a
learned teacher, at the price of domain randomisation, for there is no antagonist to simulate.
Read next: `methods.paired`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import PPOConfig, SelfRegretConfig
from ued.curriculum import LevelSpace
from ued.levels.scores import regret
from ued.levels.teacher import Teacher
from ued.training import Training
from ued.upomdp import UPOMDP


class SelfRegretLevels:
    """Proposes levels on which the student surpasses itself. A `Curriculum`; see `Teacher` for the arguments."""

    def __init__(self, space: LevelSpace, config: SelfRegretConfig, seed: int = 0) -> None:
        self.config = config
        self.teacher = Teacher(space, config, 1, 2 * config.episodes_per_level, seed)
        self.dtype = self.teacher.dtype

    def propose(self, count: int) -> np.ndarray:
        """Ask the adversary."""
        return self.teacher.propose(count)

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Pay the adversary what the later episodes brought above the earlier ones."""
        earlier, later = np.split(trials["returns"][:, 0], 2, axis=1)
        trials["score"] = regret(earlier, later, self.config.regret)
        return self.teacher.learn(trials)

    def state_dict(self) -> dict[str, Any]:
        return self.teacher.state_dict()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        self.teacher.load_state_dict(state)


class SelfRegret(Training):
    """Trains one student on the levels of an adversary that is paid its self-regret. A `Method`; see `Training`.

    Raises `ValueError` where the environment has no free parameters.
    """

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: SelfRegretConfig | None = None, seed: int = 0
    ) -> None:
        config = config or SelfRegretConfig()
        super().__init__(upomdp, lambda space, seed: SelfRegretLevels(space, config, seed), ppo, seed)
