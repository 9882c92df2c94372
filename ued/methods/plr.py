"""Prioritised level replay (Jiang et al. 2021b), and its robust form (Jiang et al. 2021a, Algorithm 1).

    repeat
        with probability 1 - p, or while the buffer is not filled:
            draw a level uniformly; the student plays it  (robust: without learning); offer it to the buffer
        else:
            draw a level from the buffer by score and staleness; the student plays it and learns; score it anew

A level on which no episode has finished has no score, and is neither kept nor dropped for it. Read next:
`levels.buffer`, `levels.scores`; then `methods.accel`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import PLRConfig, PPOConfig
from ued.curriculum import LevelSpace, LevelStock
from ued.levels.buffer import LevelBuffer
from ued.levels.record import NONE, Origin, make_trials, trial_dtype
from ued.levels.scores import score
from ued.training import BLOCK, Training
from ued.upomdp import UPOMDP, level_dtype


class PLRLevels:
    """Replays the levels that were worth it. A `Curriculum`.

    Args:
        space: what levels there are.
        config: what makes a level worth it, and how often it is replayed.
        seed: of the choices between replay and new, and among levels.
        robust: students learn from replayed levels alone.
    """

    def __init__(self, space: LevelSpace, config: PLRConfig, seed: int = 0, robust: bool = True) -> None:
        self.space, self.config, self.robust = space, config, robust
        level = level_dtype(space.theta_dim)
        self.dtype = trial_dtype(level, episodes=config.episodes_per_level)
        self.buffer = LevelBuffer(level, config.buffer)
        self.stock = LevelStock(space)
        self.rng = np.random.default_rng(seed)

    def propose(self, count: int) -> np.ndarray:
        """Give levels of the buffer with probability `replay_prob` each, new ones otherwise."""
        ready = len(self.buffer) > 0 and self.buffer.fill >= self.config.min_fill
        replays = self.rng.binomial(count, self.config.replay_prob) if ready else 0
        trials = np.concatenate([self.buffer.replays(self.dtype, replays, self.rng), self._new(count - replays)])
        return trials[self.rng.permutation(count)]

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Score the levels; offer the new ones to the buffer."""
        replayed = trials["origin"] == Origin.REPLAYED
        rows = np.full(len(trials), NONE)
        rows[replayed] = self.buffer.find(trials["slot"][replayed])  # one may have been displaced meanwhile
        kept = rows != NONE
        best = np.nanmax(trials["returns"][:, 0], 1, initial=-np.inf)
        best[kept] = np.fmax(best[kept], self.buffer.slots["best"][rows[kept]])
        trials["score"] = score(self.config.score, trials, best)
        self.buffer.rescore(rows[kept], trials["score"][kept], best[kept])
        new, parents = trials[~replayed], np.where(trials["origin"] == Origin.EDITED, trials["slot"], NONE)[~replayed]
        entered = self.buffer.offer(new["level"], new["score"], best[~replayed], parents)
        return self._metrics(trials, entered)

    def _new(self, count: int) -> np.ndarray:
        trials = make_trials(self.dtype, self.stock.take(count), Origin.RANDOM)
        trials["train"] = not self.robust
        return trials

    def _metrics(self, trials: np.ndarray, entered: int) -> dict[str, float]:
        slots = self.buffer.slots
        metrics = {"buffer/fill": self.buffer.fill, "buffer/entered": float(entered)}
        if len(slots):
            metrics["buffer/score"] = float(slots["score"].mean())
            metrics["buffer/age"] = float((self.buffer.now - slots["stamp"]).mean())
            metrics["buffer/generation"] = float(slots["generation"].mean())
        return metrics

    def state_dict(self) -> dict[str, Any]:
        """Give everything that changes."""
        return {
            "buffer": self.buffer.state_dict(),
            "stock": self.stock.levels.copy(),
            "rng": self.rng.bit_generator.state,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.buffer.load_state_dict(state["buffer"])
        self.stock.levels = state["stock"].copy()
        self.rng.bit_generator.state = state["rng"]


class PLR(Training):
    """Trains one student on new and on replayed levels. A `Method`; see `Training` for the arguments."""

    robust = False

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: PLRConfig | None = None, seed: int = 0
    ) -> None:
        config = config or PLRConfig()
        super().__init__(
            upomdp, lambda space, seed: PLRLevels(space, config, seed, self.robust), ppo, seed, block=BLOCK
        )


class RobustPLR(PLR):
    """Trains one student on replayed levels alone; new ones are only looked at (PLR⊥). A `Method`."""

    robust = True
