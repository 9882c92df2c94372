"""PAIRED (Dennis et al. 2020, Algorithm 1): an adversary proposes levels on which one student beats another.

    repeat
        the adversary proposes levels θ
        the protagonist plays them, and so does the antagonist
        regret of a level = return of the antagonist - return of the protagonist
        the adversary learns to maximize regret; both students learn from the rewards of the environment

Regret is 0 on unsolvable levels and on levels that both students solve; it is high at the limit of the protagonist's
abilities. Students learn from their own rewards, as in DCD, minimax and JaxUED: for each student the other's return is
a constant. The literal algorithm is `methods.paired_literal`.
Read next: `levels.teacher` and `levels.adversary`; `method`, for `collect_rollouts`; `methods.repaired`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ued.config import PairedConfig
from ued.core.curriculum import LevelSpace
from ued.learning.kl import KLRegularizer
from ued.learning.learner import Learner
from ued.levels import scores
from ued.levels.budget import Budget
from ued.levels.diagnostics import regret_split
from ued.levels.queue import LevelQueue
from ued.levels.teacher import Teacher
from ued.methods.method import Method


class Paired(Method):
    """Trains a protagonist and an antagonist on the levels of an adversary; see `Method` for the arguments.

    By default regret is that of a population (appendix of the paper): the best episode of any student minus the mean of
    all.
    The regret of Algorithm 1, the best episode of the antagonist minus the mean of the protagonist, is
    `roles="dennis2020"`; docs/methods.md compares the roles. The antagonist plays in a copy of the environments.

    Raises:
        ValueError: if the environment has no free parameters.
        NotImplementedError: a scripted antagonist, if the environment has no scripted policy.
    """

    def setup(self, config: PairedConfig | None, seed: int) -> None:
        self.config = config or PairedConfig()
        self.curriculum = PairedCurriculum(self.upomdp, self.config, seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        add_students(self, self.config)

    def update(self) -> dict[str, float]:
        """Play the adversary's levels with all students; let the adversary learn from regret, then the students."""
        levels = self.collect_rollouts()  # [L], finished by both protagonist and antagonist
        metrics = self.curriculum.update(levels)  # the adversary learns from the regret of each level
        metrics |= regret_split(levels, has_antagonist(self.config))
        for learner in self.learners:
            metrics |= learner.learn(self.env_steps, kl_target(self.config, self.learners, learner, self.updates))
        return self.report(levels, metrics)


# ---------------------------------------------------------------- regret

# The antagonist need not be the better student. If it is worse, regret is negative on levels that the protagonist has
# just learned to solve, and the adversary learns to avoid them. So the default is the regret of a population: the best
# student's return minus the mean of all.


def paired_regret(levels: np.ndarray, config: PairedConfig) -> np.ndarray:
    """Return the regret `[L]` of level records `[L]`, by `config.roles` and `config.regret`."""
    returns = levels["returns"]  # [L, S, n]
    if has_antagonist(config):
        regret = scores.regret(returns[:, 0], returns[:, 1], config.regret)
    elif config.roles == "flexible":
        regret = scores.regret(returns[:, 0], returns[:, 1], config.regret, flexible=True)
    else:
        regret = scores.population_regret(returns, config.regret)
    return np.maximum(regret, 0.0) if config.clip_regret else regret


def has_antagonist(config: PairedConfig) -> bool:
    """Return whether the second student is always the antagonist, as a scripted antagonist is."""
    return config.roles == "dennis2020" or config.antagonist == "scripted"


class PairedCurriculum(Teacher):
    """A `Curriculum` of levels of high regret for two or more students; see `Teacher` for the arguments."""

    config: PairedConfig

    def __init__(self, space: LevelSpace, config: PairedConfig, seed: int = 0, budget: Budget | None = None) -> None:
        super().__init__(space, config, len(student_names(config)), config.episodes_per_level, seed, budget)

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Reward the adversary with the regret of its levels."""
        regret = paired_regret(records, self.config)  # [L]
        return self.learn(records, regret)


# ---------------------------------------------------------------- students

NAMES = ("protagonist", "antagonist")


def student_names(config: PairedConfig) -> tuple[str, ...]:
    """Return the names of the students: protagonist and antagonist, or numbered names for more than two."""
    return NAMES if config.students == 2 else tuple(f"student{k}" for k in range(config.students))


def add_students(method: Method, config: PairedConfig) -> None:
    """Add the students to a method; a scripted antagonist is the scripted policy of the environment."""
    first, *others = student_names(config)
    method.add_learner(first, method.upomdp)
    if config.antagonist == "scripted":
        method.add_learner(others.pop(), method.upomdp.with_scripted_policy(), scripted=True)
    for name in others:
        method.add_learner(name, method.upomdp.copy())


def kl_target(
    config: PairedConfig, learners: Sequence[Learner], learner: Learner, updates: int
) -> KLRegularizer | None:
    """Return the KL regularizer toward the other student's policy, every few updates (Mediratta et al. 2023)."""
    index = learners.index(learner)
    regularized = config.kl == "both_ways" or (config.kl == "one_way" and index == 0)
    other = learners[(index + 1) % len(learners)].student
    if not regularized or updates % config.kl_every or other is None:
        return None
    return KLRegularizer(other, config.kl_coef)
