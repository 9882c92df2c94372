"""CENIE (Teoh et al. 2024): ACCEL, or robust PLR, that replays levels by regret and by novelty.

    repeat
        with probability 1 - p: draw a level uniformly; evaluate it; offer it to the buffer
        else: replay a level and learn from it; add its state-action pairs to the window
              edit a copy of it; evaluate the copy; offer it to the buffer    (PLR-CENIE: no edits)
        score each level by its regret, and by its novelty: the mean of -log p(observation, action) on it
        fit the mixture of Gaussians, p, to the window of past pairs
    replay a level with probability (1 - c) P_regret + c P_novelty, each by rank, and by staleness as PLR

A level is novel if the student's states or actions on it are rare in its recent training data. Read next:
`levels.novelty`, then `levels.novelty_buffer`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ued.config import CENIEConfig
from ued.core.curriculum import LevelSpace
from ued.core.sparse_image import dense_space
from ued.core.upomdp import UPOMDP
from ued.learning.networks import choices_of
from ued.learning.value_stats import scored_agents
from ued.levels.budget import Budget
from ued.levels.novelty import Coverage, EpisodeNovelty
from ued.levels.novelty_buffer import NoveltyBuffer, novelty_of
from ued.levels.queue import LevelQueue
from ued.methods.accel import ACCELCurriculum
from ued.methods.method import Method

MOST_ENTRIES = 1024  # entries of an observation: a mixture over pixels does not describe states


class CENIE(Method):
    """Trains one student on replayed levels, by regret and novelty; see `Method` for the arguments.

    Raises:
        ValueError: if an observation of an agent has more than 1,024 entries, as images do, and if ACCEL has nothing
            to edit.
    """

    curriculum: CENIECurriculum

    def setup(self, config: CENIEConfig | None, seed: int) -> None:
        config = config or CENIEConfig()
        if config.base == "accel" and not self.upomdp.theta_dim:
            raise ValueError(
                "CENIE needs parameters to edit: the environment has none; use base='plr' (--cenie.base plr)"
            )
        columns = pair_columns(self.upomdp)
        self.curriculum = CENIECurriculum(self.upomdp, config, seed, self.budget, columns)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, drop_stale_proposals=False)
        self.learner = self.add_learner("student", self.upomdp)
        coverage, actions = self.curriculum.coverage, self.upomdp.agent_action_space
        negative = self.learner.values.negative  # needed by the score mna
        self.learner.values = EpisodeNovelty(
            self.upomdp.num_envs, coverage, actions, negative, scored_agents(self.upomdp)
        )

    def update(self) -> dict[str, float]:
        """Play new, replayed and edited levels; score them by regret and novelty; learn from replayed levels."""
        levels = self.collect_rollouts()  # [L] with their novelty
        metrics = self.curriculum.update(levels)  # score and store each; edit the replayed levels; fit the mixture
        metrics |= self.learner.learn(self.env_steps)  # only replayed levels are training levels
        return self.report(levels, metrics)

    @property
    def buffer(self) -> NoveltyBuffer:
        return self.curriculum.buffer


class CENIECurriculum(ACCELCurriculum):
    """A `Curriculum` that replays levels of high regret and novelty, and evaluates edited copies of them.

    Its level records have a field `novelty` `[1, n]`, which the trainer fills in: the mean novelty of the state-action
    pairs of each episode under `coverage`, as `EpisodeNovelty` computes it.

    Args:
        space, config, seed, budget: see `PLRCurriculum`.
        columns: D of a state-action pair; see `levels.novelty.state_actions`.
    """

    config: CENIEConfig
    state_fields = (*ACCELCurriculum.state_fields, "coverage")

    def __init__(
        self, space: LevelSpace, config: CENIEConfig, seed: int = 0, budget: Budget | None = None, columns: int = 0
    ) -> None:
        super().__init__(space, config, seed, budget)
        self.buffer: NoveltyBuffer = NoveltyBuffer(space, config.buffer, config.novelty_coef, self.buffer.budget)
        self.coverage = Coverage(columns, config.coverage, seed)

    def _fields(self) -> list[tuple[Any, ...]]:
        return [*super()._fields(), ("novelty", np.float64, (1, self.config.episodes_per_level))]

    def propose(self, count: int) -> np.ndarray:
        """Return level records as ACCEL does, without a novelty."""
        records = super().propose(count)
        records["novelty"] = np.nan
        return records

    def _parents(self, records: np.ndarray) -> np.ndarray:
        return records[:0] if self.config.base == "plr" else super()._parents(records)

    def update(self, records: np.ndarray) -> dict[str, float]:
        """Score and store levels as ACCEL does, with their novelty; fit the mixture if it is due.

        Raises:
            ValueError: if the trainer has not filled in the novelty.
        """
        novelty = novelty_of(records)
        if np.isnan(novelty).any():
            raise ValueError('cenie needs records["novelty"], which the trainer has not filled in; accel needs none')
        metrics = super().update(records)
        known = novelty[np.isfinite(novelty)]
        metrics["cenie/novelty"] = float(known.mean()) if len(known) else float("nan")
        self.coverage.refit()
        return metrics | {"cenie/components": float(self.coverage.components)}


def pair_columns(upomdp: UPOMDP) -> int:
    """Return the number of columns of a state-action pair of one agent.

    Raises:
        ValueError: for images.
    """
    shape = dense_space(upomdp.agent_observation_space).shape or ()
    size, actions = math.prod(shape), upomdp.agent_action_space
    if size > MOST_ENTRIES:
        raise ValueError(
            f"cenie supports observations of at most {MOST_ENTRIES:,} entries, got {size:,} "
            f"({' x '.join(map(str, shape))}); use accel or robust_plr"
        )
    return size + int(choices_of(actions).sum() or math.prod(actions.shape or ()))
