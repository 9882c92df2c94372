"""Sampling for learnability (Rutherford et al. 2024, Algorithm 1), with its looking around counted and budgeted.

    every `choose_every` updates
        the student plays k episodes on each of many random levels, without learning
        choose those of the largest p (1 - p)
    repeat
        the student plays levels, a share of them chosen ones and the rest random, and learns

The reference implementation spends several times more steps on looking than on training, and does not count them. Here
candidates are trials like all others. Read next: `methods.alp_gmm`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import PPOConfig, SFLConfig
from ued.curriculum import LevelSpace, LevelStock
from ued.levels.record import NONE, Origin, make_trials, trial_dtype
from ued.levels.scores import score
from ued.training import BLOCK, Training
from ued.upomdp import UPOMDP, level_dtype

TIE_BREAK = 0.001  # times p: of two levels that teach nothing the one that can be solved (Kinetix)
CANDIDATE = 0  # slot of a trial that is a candidate


class SFLLevels:
    """Proposes the levels that are solved about half of the time. A `Curriculum`.

    Args:
        space: what levels there are.
        config: how many are looked at, how often, and how many are chosen.
        seed: of the choices.
    """

    def __init__(self, space: LevelSpace, config: SFLConfig, seed: int = 0) -> None:
        self.space, self.config = space, config
        self.dtype = trial_dtype(level_dtype(space.theta_dim), episodes=config.candidate_episodes)
        self.stock = LevelStock(space)
        self.rng = np.random.default_rng(seed)
        self.waiting = 0  # candidates yet to be proposed
        self.looking = False  # whether there are candidates to be proposed or to be judged
        self.judged = np.zeros(0, self.dtype)
        self.chosen = np.zeros(0, level_dtype(space.theta_dim))
        self.updates = 0

    def propose(self, count: int) -> np.ndarray:
        """Give candidates while there are any, then chosen levels and random ones."""
        candidates = min(count, self.waiting)
        self.waiting -= candidates
        chosen = self.rng.binomial(count - candidates, self.config.chosen_share) if len(self.chosen) else 0
        levels = self.stock.take(count - chosen)
        again = self.chosen[self.rng.integers(0, len(self.chosen), chosen)] if chosen else self.chosen[:0]
        again = again.copy()
        again["seed"] = self.rng.integers(0, 2**63, chosen, dtype=np.uint64)
        trials = make_trials(self.dtype, np.concatenate([levels, again]))
        trials["origin"][len(levels) :] = Origin.REPLAYED
        trials["wanted"][candidates:] = 1
        trials["slot"][:candidates], trials["train"][:candidates] = CANDIDATE, False
        return trials[self.rng.permutation(count)]

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Judge candidates; choose the most learnable when all are judged; ask for new ones when it is time."""
        looked_at = trials["slot"] != NONE
        trials["score"][looked_at] = self._learnability(trials[looked_at])
        self.judged = np.concatenate([self.judged, trials[looked_at]])
        metrics = {"sfl/candidates": float(looked_at.sum())}
        if len(self.judged) >= self.config.candidates:
            order = np.argsort(-self.judged["score"], kind="stable")
            self.chosen = self.judged["level"][order[: self.config.chosen]]
            metrics["sfl/chosen_score"] = float(self.judged["score"][order[: self.config.chosen]].mean())
            self.judged, self.looking = self.judged[:0], False
        if self.updates % self.config.choose_every == 0 and not self.looking:  # long episodes may take it longer
            self.waiting, self.looking = self.config.candidates, True
        self.updates += 1
        return metrics

    def _learnability(self, trials: np.ndarray) -> np.ndarray:
        solved = (trials["returns"][:, 0] > 0).mean(1) if len(trials) else np.zeros(0)
        return score("learnability", trials) + TIE_BREAK * solved

    def state_dict(self) -> dict[str, Any]:
        """Give everything that changes."""
        return {
            "stock": self.stock.levels.copy(),
            "rng": self.rng.bit_generator.state,
            "waiting": self.waiting,
            "looking": self.looking,
            "judged": self.judged.copy(),
            "chosen": self.chosen.copy(),
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.stock.levels, self.rng.bit_generator.state = state["stock"].copy(), state["rng"]
        self.judged, self.chosen = state["judged"].copy(), state["chosen"].copy()
        self.waiting, self.looking, self.updates = state["waiting"], state["looking"], state["updates"]


class SFL(Training):
    """Trains one student on learnable levels. A `Method`; see `Training` for the arguments."""

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: SFLConfig | None = None, seed: int = 0
    ) -> None:
        config = config or SFLConfig()
        super().__init__(upomdp, lambda space, seed: SFLLevels(space, config, seed), ppo, seed, block=BLOCK)
