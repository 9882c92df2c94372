"""Lessons: a manual curriculum (Bengio et al. 2009; Elman 1993) with regions of levels in the order of a plan.

    for each lesson of the plan
        repeat
            draw levels uniformly from the region of the lesson
            the student plays them and learns
        until the criterion of the lesson holds: mean success or return of its last episodes, or its length

With `increments` above 1, the ends of the region move to those of the next lesson in that many parts, one part each
time the criterion holds. So a threshold widens a range gradually. A length of k steps is divided among the parts,
which makes a linear schedule. Read next: `lesson_config`, the syntax of lessons; `levels.regions`.
"""

from __future__ import annotations

import numpy as np

from ued.config import LessonsConfig
from ued.core.curriculum import LevelSpace, need_vector
from ued.core.level_space import level_dtype
from ued.core.resumable import Resumable
from ued.lesson_config import MEANS, Criterion
from ued.levels.budget import Budget
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records, mean_returns, solved
from ued.levels.regions import Region, region_of
from ued.methods.method import Method


class Lessons(Method):
    """Trains one student on the lessons of a plan; see `Method` for the arguments.

    Raises:
        ValueError: lessons that do not fit the parameters of the environment.
    """

    curriculum: LessonCurriculum

    def setup(self, config: LessonsConfig | None, seed: int) -> None:
        self.curriculum = LessonCurriculum(self.upomdp, config or LessonsConfig(), seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play levels of the lesson; move on if its criterion holds; learn from all levels."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)
        metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)


class LessonCurriculum(Resumable):
    """A `Curriculum` that proposes levels of the current lesson.

    Its level records have a field `stage`, the number of the part in which they were proposed: results of earlier parts
    do not count for a later part.

    Args:
        space: the space of levels.
        config: the plan.
        seed: seed of the draws.
        budget: budget of the run, whose `spent` counts steps. Your own trainer sets it; criteria in episodes need none.

    Raises:
        ValueError: lessons that do not fit the space, and a share of a run of unknown length.
    """

    state_fields = ("rng", "lesson", "part", "began", "episodes", "recent")

    def __init__(self, space: LevelSpace, config: LessonsConfig, seed: int = 0, budget: Budget | None = None) -> None:
        need_vector(space)
        self.space, self.config, self.budget = space, config, budget or Budget.of(space)
        self.plan = config.lessons()
        shares = [lesson.text for lesson in self.plan if any(end.measure == "share" for end in lesson.until)]
        if shares and self.budget.total is None:
            raise ValueError(f"the lesson {shares[0]!r} is a share of the run, whose length is unknown: give env_steps")
        self.regions = [region_of(space, lesson) for lesson in self.plan]
        self.dtype = level_record_dtype(level_dtype(space.theta_dim), extra=[("stage", np.int64)])
        self.rng = np.random.default_rng(seed)
        self.lesson = self.part = 0  # both are counted from 0
        self.began = self.episodes = 0  # env_steps before this lesson, and its episodes so far
        self.recent = np.zeros((0, len(MEANS)))  # success and return of the last episodes of this part

    @property
    def stage(self) -> int:
        """The number of the current part, over all lessons."""
        return self.lesson * self.config.increments + self.part

    @property
    def region(self) -> Region:
        """The region from which levels are currently drawn."""
        if not self.part:
            return self.regions[self.lesson]
        return self.regions[self.lesson].towards(self.regions[self.lesson + 1], self.part / self.config.increments)

    def propose(self, count: int) -> np.ndarray:
        """Draw `count` levels uniformly from the region.

        Raises:
            ThetaError: if the region has no valid level.
        """
        where = f"the lesson {self.plan[self.lesson].text!r}"
        records = make_records(self.dtype, self.region.sample(self.space, count, self.rng, where), Origin.PROPOSED)
        records["stage"] = self.stage
        return records

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Record the results of the current part; move on as long as a criterion holds.

        The metrics describe the part in which the levels were played.
        """
        now = records[records["stage"] == self.stage]
        results = np.column_stack([solved(now)[:, 0, 0], mean_returns(now)[:, 0]])  # [L, 2]
        self.recent = np.concatenate([self.recent, results])[-self.config.window :]
        self.episodes += len(now)
        success = float(self.recent[:, 0].mean()) if len(self.recent) else float("nan")
        progress = self.part / self.config.increments
        metrics = {"lessons/lesson": self.lesson + 1.0, "lessons/progress": progress, "lessons/success": success}
        while any(self._holds(criterion) for criterion in self.plan[self.lesson].until):
            self._move_on()
        return metrics

    def _holds(self, criterion: Criterion) -> bool:
        if criterion.measure in MEANS:
            mean = self.recent[:, MEANS.index(criterion.measure)].mean() if len(self.recent) else -np.inf
            return len(self.recent) == self.config.window and bool(mean >= criterion.least)
        spent = self.episodes if criterion.measure == "episodes" else self.budget.spent - self.began
        total = (self.budget.total or 0) if criterion.measure == "share" else 1
        return spent >= criterion.least * total * (self.part + 1) / self.config.increments

    def _move_on(self) -> None:
        """Start the next part, or after the last part the next lesson."""
        self.recent, self.part = self.recent[:0], self.part + 1
        if self.part == self.config.increments:
            self.lesson, self.part, self.began, self.episodes = self.lesson + 1, 0, self.budget.spent, 0
