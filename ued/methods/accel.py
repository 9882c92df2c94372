"""ACCEL (Parker-Holder et al. 2022, Algorithm 1): robust replay of levels, whose edited copies also enter the buffer.

    repeat
        with probability 1 - p: draw a level uniformly, or a simplest one; evaluate it; offer it to the buffer
        else: replay a level and learn from it;
              edit a copy of it; evaluate the copy; offer it to the buffer

An edit changes a few columns of θ, depending on their kind, and keeps the seed: a child differs from its parent only by
the edit. (For `Seeds`, the column is the seed.) Neighbors of a level at the limit of the student's abilities have
similar difficulty, so curricula become harder in small steps. Read next: `methods.paired`.
"""

from __future__ import annotations

import numpy as np

from ued.config import ACCELConfig
from ued.core.curriculum import LevelSpace
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, make_records, mean_returns
from ued.methods.method import Method
from ued.methods.plr import PLRCurriculum

TRIES = 8  # attempts to edit a level into a valid one


class ACCEL(Method):
    """Trains one student on replayed levels, which evolve; see `Method` for the arguments.

    Raises:
        ValueError: if the environment has no free parameters, or no simplest levels to begin with.
    """

    curriculum: ACCELCurriculum

    def setup(self, config: ACCELConfig | None, seed: int) -> None:
        if not self.upomdp.theta_dim:
            raise ValueError("ACCEL needs parameters to edit: the environment has no free parameters; use dr")
        self.curriculum = ACCELCurriculum(self.upomdp, config or ACCELConfig(), seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self) -> dict[str, float]:
        """Play new, replayed and edited levels; score and store them; edit replayed levels; learn from these."""
        levels = self.collect_rollouts()  # [L]
        metrics = self.curriculum.update(levels)  # score and store each; edit the replayed levels
        metrics |= self.learner.learn(self.env_steps)  # only replayed levels are training levels
        return self.report(levels, metrics)

    @property
    def buffer(self) -> LevelBuffer:
        return self.curriculum.buffer


class ACCELCurriculum(PLRCurriculum):
    """A `Curriculum` that replays levels and evaluates edited copies of them."""

    config: ACCELConfig
    state_fields = (*PLRCurriculum.state_fields, "children")

    def __init__(self, space: LevelSpace, config: ACCELConfig, seed: int = 0, budget: Budget | None = None) -> None:
        super().__init__(space, config, seed, robust=True, budget=budget)
        self.children = np.zeros(0, self.dtype)  # edited levels that are not yet evaluated
        if config.new_levels == "simplest":
            space.simplest_levels(0)  # raises if there are none

    def propose(self, count: int) -> np.ndarray:
        """Return children of replayed levels first, then levels as PLR does."""
        children, self.children = self.children[:count], self.children[count:]
        return np.concatenate([children, super().propose(count - len(children))])

    def _new(self, count: int) -> np.ndarray:
        if self.config.new_levels == "random":
            return super()._new(count)
        records = make_records(self.dtype, self.space.simplest_levels(count), Origin.RANDOM)
        records["train"] = False
        return records

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score and store the levels as PLR does; edit copies of the replayed levels."""
        metrics = super().update(records)
        children = self._edited(self._parents(records))
        self.children = np.concatenate([self.children, children])  # they are proposed next
        return metrics

    def _parents(self, records: np.ndarray) -> np.ndarray:
        parents = records[records["origin"] == Origin.REPLAYED]
        if self.config.parents == "easy" and len(parents):
            returns = mean_returns(parents)[:, 0]
            parents = parents[returns >= np.median(returns)]
        return parents

    def _edited(self, parents: np.ndarray) -> np.ndarray:
        """Return a child of each level record, except of levels without a valid edit."""
        children = make_records(self.dtype, parents["level"], Origin.EDITED)
        children["parent"], children["train"] = parents["id"], False
        open_ = np.arange(len(children))
        for _ in range(TRIES):
            config = self.config
            theta = self.space.edit_theta(
                parents["level"]["theta"][open_], config.num_edits, config.edit_size, self.rng
            )
            valid = self.space.valid(theta) if len(theta) else np.zeros(0, bool)
            children["level"][open_[valid]] = self._children_of(parents["level"][open_[valid]], theta[valid])
            open_ = open_[~valid]
        return np.delete(children, open_)

    def _children_of(self, parents: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Return levels `[k]` of these θ with the seeds of their parents `[k]`."""
        levels = self.space.make_levels(theta)
        self.space.keep_seeds(levels, parents["seed"])
        return levels
