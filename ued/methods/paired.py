"""PAIRED (Dennis et al. 2020, Algorithm 1): an adversary proposes levels on which one student beats another.

    repeat
        the adversary proposes levels θ
        the protagonist plays them, and so does the antagonist
        regret of a level = what the antagonist reached - what the protagonist reached
        the adversary learns to cause regret; both students learn from the rewards of the environment

A level that nobody can solve causes no regret, nor does one that both solve: what is left lies at the edge of what the
protagonist can do. Students learn from their own rewards, as in every implementation that works: from each student's
view the other's return is a constant. `student_reward="regret"` is the letter of the algorithm instead.
Nothing makes the antagonist the better student. Where it is not, regret is negative on levels that the protagonist has
just learned to solve, and the adversary is taught to avoid them: so the default is the regret of a population, the best
of both students against the mean of both (`roles`). The other settings are further stabilisers: random levels among the
adversary's, mean-mean regret, students drawn to each other, and an antagonist that is no student but what the
environment itself does with the learner's part (a Scenic behavior), the yardstick from the first update on.
Read next: `levels.teacher` and `levels.adversary`; `training`, who plays what; `methods.repaired`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor

from ued.config import PairedConfig, PPOConfig
from ued.curriculum import LevelSpace
from ued.learning.ppo import Guide
from ued.levels.diagnostics import regret_split
from ued.levels.record import Origin
from ued.levels.scores import population_regret, regret
from ued.levels.teacher import Teacher
from ued.training import Seat, Training
from ued.upomdp import UPOMDP

NAMES = ("protagonist", "antagonist")


def student_names(config: PairedConfig) -> tuple[str, ...]:
    """Give the names of the students: those of the two parts, or numbers where there are more."""
    return NAMES if config.students == 2 else tuple(f"student{k}" for k in range(config.students))


class PairedLevels:
    """Proposes levels that cause regret. A `Curriculum` for two students, or more; see `Teacher` for the arguments."""

    def __init__(self, space: LevelSpace, config: PairedConfig, seed: int = 0) -> None:
        self.config = config
        self.teacher = Teacher(space, config, len(student_names(config)), config.episodes_per_level, seed)
        self.dtype = self.teacher.dtype

    def propose(self, count: int) -> np.ndarray:
        """Ask the adversary."""
        return self.teacher.propose(count)

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Pay the adversary the regret that its levels caused."""
        trials["score"] = self.regret(trials)
        split = regret_split(trials[trials["origin"] == Origin.PROPOSED], self.roles == "fixed")
        return self.teacher.learn(trials) | split

    @property
    def roles(self) -> str:
        """Say whose regret it is; a scripted antagonist is nothing else."""
        return "fixed" if self.config.antagonist == "scripted" else self.config.roles

    def regret(self, trials: np.ndarray) -> np.ndarray:
        """Give the regret of each level `[L]`."""
        config, returns = self.config, trials["returns"]  # [L, S, n]
        if self.roles == "population":
            found = population_regret(returns, config.regret)
        else:
            found = regret(returns[:, 0], returns[:, 1], config.regret, self.roles == "flexible")
        return np.maximum(found, 0.0) if config.clip_regret else found

    def state_dict(self) -> dict[str, Any]:
        return self.teacher.state_dict()

    def load_state_dict(self, state: dict[str, Any]) -> None:
        self.teacher.load_state_dict(state)


class Paired(Training):
    """Trains a protagonist and an antagonist on the levels of an adversary. A `Method`.

    Args:
        upomdp: the environments; they are reset and belong to this object from then on. The antagonist plays in a
            copy of them.
        ppo: how both students learn.
        config: the adversary, what counts as regret, and who plays the antagonist.
        seed: of every random stream.

    Raises `ValueError` where the environment has no free parameters, `NotImplementedError` for a scripted antagonist
    where the environment has none.
    """

    curriculum: PairedLevels

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: PairedConfig | None = None, seed: int = 0
    ) -> None:
        self.config = config = config or PairedConfig()
        self.paid_by_regret = config.student_reward == "regret"
        super().__init__(
            upomdp, self.make_curriculum, ppo, seed, student_names(config), max_lead=0 if self.paid_by_regret else None
        )

    def make_curriculum(self, space: LevelSpace, seed: int) -> PairedLevels:
        """Give the adversary with its regret."""
        return PairedLevels(space, self.config, seed)

    def place_of(self, index: int) -> UPOMDP:
        return self.upomdp.scripted() if self.is_scripted(index) else self.upomdp.copy()

    def is_scripted(self, index: int) -> bool:
        """Say whether the environment plays this student's part itself."""
        return index == 1 and self.config.antagonist == "scripted"

    def update(self) -> dict[str, float]:
        """Play the adversary's levels with both students; let all three learn."""
        if self.paid_by_regret:
            self._begin_together()
        return super().update()

    def guide_of(self, seat: Seat) -> Guide | None:
        """Draw a student to the other one's policy every few updates (Mediratta et al. 2023)."""
        config, index = self.config, self.seats.index(seat)
        drawn = config.kl == "both_ways" or (config.kl == "one_way" and index == 0)
        if not drawn or self.updates % config.kl_every:
            return None
        return Guide(self.students[self.seats[(index + 1) % len(self.seats)].name], config.kl_coef)

    # ------------------------------------------------------------ the letter of the algorithm

    def _begin_together(self) -> None:
        """Give every environment of both students a new level at once; its unfinished episode is lost.

        Regret as a reward must be known when students learn, so here a level lives in one rollout, which should be
        long enough for its episodes: environments in which it is not contribute nothing.
        """
        self.queue.clear()
        for index, seat in enumerate(self.seats):
            seat.player.start(self.queue.first(index))
            seat.values.forget()

    def _take_settled(self) -> np.ndarray:
        self._counting = torch.as_tensor(self.queue.settled())  # [N]: one level for each environment, when it matters
        self._settled = super()._take_settled()
        return self._settled

    def _learn(self, seat: Seat, advantages: Tensor) -> dict[str, float]:
        if not self.paid_by_regret or seat.ppo is None:
            return super()._learn(seat, advantages)
        rollout = seat.player.rollout.columns(self._counting)
        if not rollout.reward.numel():
            return {}
        ended = rollout.terminated | rollout.truncated
        sign = -1.0 if seat is self.seats[0] else 1.0
        rollout.reward = torch.where(ended, sign * torch.tensor(self._settled["score"].tolist()), 0.0)
        rollout.terminated, rollout.truncated = ended, torch.zeros_like(ended)  # regret is all there is
        return seat.ppo.learn(rollout, self.env_steps)
