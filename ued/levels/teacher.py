"""A learned teacher: an adversary that proposes levels, with a share of random levels, and learns from their scores.

PAIRED, minimax and self-regret differ only in the score. Read next: `levels.adversary`, the policy; `methods.minimax`,
the shortest use.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import TeacherConfig
from ued.core.level_space import LevelSpace, as_void_view, level_dtype
from ued.core.parameters import quantize
from ued.core.resumable import Resumable
from ued.core.seeding import SeedStream, torch_generator
from ued.core.sparse_image import as_dense, dense_space
from ued.core.upomdp import UPOMDP
from ued.levels.budget import Budget
from ued.levels.diagnostics import choice_metrics
from ued.levels.proposer import Proposer, make_adversary
from ued.levels.record import Origin, level_record_dtype, make_records


class Teacher(Resumable):
    """Proposes levels and learns from the scores of the adversary's own proposals.

    Args:
        space: the space of levels.
        config: settings of the adversary, share of random levels, penalty for invalid proposals.
        students, episodes: S and n of the level records.
        seed: seed of its random streams.
        budget: budget of the run, which determines when it learns; see `AdversaryConfig.min_batch`.

    Raises `ValueError` if the environment has no free parameters, or if an adversary cannot choose its levels.
    """

    state_fields: tuple[str, ...] = ("adversary", "pending_proposals", "mix", "learned_at")

    def __init__(
        self,
        space: LevelSpace,
        config: TeacherConfig,
        students: int,
        episodes: int,
        seed: int,
        budget: Budget | None = None,
    ) -> None:
        self.space, self.config, self.budget = space, config, budget or Budget.of(space)
        seeds = SeedStream(seed)
        self.view = self._view()
        size = None if self.view is None else int(np.prod(dense_space(self.view.single_observation_space).shape or ()))
        self.adversary: Proposer = make_adversary(space, config.adversary, torch_generator(seeds.next()), size)
        self.mix = np.random.default_rng(seeds.next())
        own = self.adversary.record_fields
        self.dtype = level_record_dtype(level_dtype(space.theta_dim), students, episodes, own)
        self.pending_proposals = np.zeros(0, self.dtype)  # scored proposals, too few for an update
        self.learned_at = 0  # env_steps at the last update

    def propose(self, count: int) -> np.ndarray:
        """Return `count` level records: proposals of the adversary, and a share of random levels."""
        if not count:  # a buffer may replay all levels
            return np.zeros(0, self.dtype)
        proposals = self.adversary.propose(count, self._context(count))
        theta = quantize(self.adversary.theta(proposals), self.space.parameters)  # [count, D]
        records = make_records(self.dtype, self.space.make_levels(theta), Origin.PROPOSED)
        for name, column in proposals._asdict().items():
            records[name] = column
        records["origin"][~self.space.valid(theta)] = Origin.REPLACED
        records["origin"][self.mix.random(count) < self.config.dr_fraction] = Origin.RANDOM
        random = records["origin"] != Origin.PROPOSED
        if random.any():
            records["level"][random] = self.space.sample_levels(int(random.sum()))
        return records

    def _view(self) -> UPOMDP | None:
        """Return separate environments whose observations are the adversary's context; None for a random context."""
        if self.config.adversary.context == "random":
            return None
        if not isinstance(self.space, UPOMDP):
            raise ValueError("the context 'observation' needs a UPOMDP; use 'random'")
        return self.space.copy()

    def _context(self, count: int) -> np.ndarray | None:
        """Return the first observations of `count` random levels (thesis, section 4.3): `[count, size]`."""
        if self.view is None:
            return None
        batches: list[np.ndarray] = []
        while sum(map(len, batches)) < count:  # no step is simulated
            levels = self.space.sample_levels(self.view.num_envs)
            seen, _ = self.view.reset_to_levels(levels)
            batches.append(as_dense(self.view.single_observation_space, seen).reshape(len(levels), -1))
        return np.concatenate(batches)[:count]

    def learn(self, levels: np.ndarray, score: np.ndarray) -> dict[str, float]:
        """Set the score `[L]` of these levels `[L]`; update the adversary on its own proposals among them.

        The adversary waits until it has enough proposals. It does not learn from levels without a finite score, such as
        partly played levels. Returns `choice_metrics`, the number of gradient steps, and the means of the losses, which
        are missing while the adversary waits. Raises `ValueError` if no level has a finite score.
        """
        if len(levels) and not np.isfinite(score).any():
            raise ValueError("no level has a finite score: every student must finish an episode on it")
        levels["score"] = score
        metrics = choice_metrics(levels, self.space.parameters)
        proposals = as_void_view(levels)[(levels["origin"] == Origin.PROPOSED) & np.isfinite(score)].view(levels.dtype)
        if self.config.invalid_penalty:
            refused = levels[levels["origin"] == Origin.REPLACED]  # their θ is that of the random replacement
            refused["score"] = -self.config.invalid_penalty
            proposals = np.concatenate([proposals, refused])
        self.pending_proposals = np.concatenate([as_void_view(self.pending_proposals), as_void_view(proposals)]).view(
            self.dtype
        )
        if not self._is_enough(len(self.pending_proposals)):
            return metrics | {"adversary/gradient_steps": 0.0}
        self.learned_at = self.budget.spent
        batch, self.pending_proposals = self.pending_proposals, self.pending_proposals[:0]
        losses = self.adversary.learn(self.adversary.read(batch), batch["score"])
        return metrics | {f"adversary/{name}": value for name, value in losses.items()}

    def _is_enough(self, waiting: int) -> bool:
        """Return whether the adversary learns from `waiting` levels."""
        least = self.config.adversary.min_batch
        return self.budget.allows_lesson(waiting, self.learned_at) if least is None else waiting >= least

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`; older states lack `learned_at`."""
        super().load_state_dict({"learned_at": 0} | state)
