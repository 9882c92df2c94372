"""Self-regret: PAIRED's adversary with one student, whose later episodes on a level replace the antagonist's.

    repeat
        the adversary proposes levels; the student plays 2 n episodes on each, and learns
        self-regret of a level = the best of the last n episodes - the mean of the first n
        the adversary learns to maximize self-regret

For outcomes 0 and 1, success rate p and n = 2 its expectation is p (1 - p), the learnability of the level. It costs as
many steps as domain randomization, since no antagonist is simulated.
Read next: `methods.paired`.
"""

from __future__ import annotations

import numpy as np

from ued.config import SelfRegretConfig
from ued.core.curriculum import LevelSpace
from ued.levels import scores
from ued.levels.budget import Budget
from ued.levels.queue import LevelQueue
from ued.levels.teacher import Teacher
from ued.methods.method import Method


class SelfRegret(Method):
    """Trains one student on the levels of an adversary that maximizes self-regret; see `Method` for the arguments.

    Raises:
        ValueError: if the environment has no free parameters.
    """

    def setup(self, config: SelfRegretConfig | None, seed: int) -> None:
        self.curriculum = SelfRegretCurriculum(self.upomdp, config or SelfRegretConfig(), seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play the adversary's levels; let the adversary and the student learn."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # the adversary learns from the student's self-regret
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class SelfRegretCurriculum(Teacher):
    """A `Curriculum` that proposes levels on which the student improves; see `Teacher` for the arguments."""

    def __init__(
        self, space: LevelSpace, config: SelfRegretConfig, seed: int = 0, budget: Budget | None = None
    ) -> None:
        super().__init__(space, config, 1, 2 * config.episodes_per_level, seed, budget)
        self.rule = config.regret

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Reward the adversary with self-regret: the gain of the later episodes over the earlier ones."""
        earlier, later = np.split(records["returns"][:, 0], 2, axis=1)  # [L, n] each
        return self.learn(records, scores.regret(earlier, later, self.rule))
