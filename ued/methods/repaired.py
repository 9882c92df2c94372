"""REPAIRED (Jiang et al. 2021a, Algorithm 2): PAIRED's adversary as the generator of a robust replay buffer.

    repeat
        with probability 1 - p:
            the adversary proposes levels; both students play them without learning
            the adversary learns from their regret; the levels are offered to the buffer
        else:
            both students play levels of the buffer and learn; the levels get their new regret

Two defects of the reference implementation are not repeated: the adversary learns from its own proposals alone, never
from the regret of replayed levels, and both students replay the same level, so that its regret means something.
Read next: `methods.minimax`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import PPOConfig, RepairedConfig
from ued.curriculum import LevelSpace
from ued.levels.buffer import LevelBuffer
from ued.levels.record import NONE, Origin
from ued.methods.paired import Paired, PairedLevels
from ued.upomdp import UPOMDP, level_dtype


class RepairedLevels(PairedLevels):
    """Proposes levels that cause regret, and replays those that caused most. A `Curriculum`."""

    config: RepairedConfig

    def __init__(self, space: LevelSpace, config: RepairedConfig, seed: int = 0) -> None:
        super().__init__(space, config, seed)
        self.buffer = LevelBuffer(level_dtype(space.theta_dim), config.buffer)
        self.rng = np.random.default_rng(seed)

    def propose(self, count: int) -> np.ndarray:
        """Give levels of the buffer with probability `replay_prob` each, the adversary's otherwise."""
        ready = len(self.buffer) > 0 and self.buffer.fill >= self.config.min_fill
        replays = self.rng.binomial(count, self.config.replay_prob) if ready else 0
        again = self.buffer.replays(self.dtype, replays, self.rng)
        new = self.teacher.propose(count - replays)
        new["train"] = False
        return np.concatenate([again, new])[self.rng.permutation(count)]

    def update(self, trials: np.ndarray) -> dict[str, float]:
        """Pay the adversary for its own levels; offer these to the buffer; score the replayed ones anew."""
        replayed = trials["origin"] == Origin.REPLAYED
        metrics = super().update(trials)
        best = np.nanmax(trials["returns"], (1, 2), initial=-np.inf)
        rows = self.buffer.find(trials["slot"][replayed])
        kept = rows != NONE
        self.buffer.rescore(rows[kept], trials["score"][replayed][kept], best[replayed][kept])
        new = trials[~replayed]
        entered = self.buffer.offer(new["level"], new["score"], best[~replayed])
        return metrics | {"buffer/fill": self.buffer.fill, "buffer/entered": float(entered)}

    def state_dict(self) -> dict[str, Any]:
        """Give everything that changes."""
        return super().state_dict() | {"buffer": self.buffer.state_dict(), "rng": self.rng.bit_generator.state}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        super().load_state_dict(state)
        self.buffer.load_state_dict(state["buffer"])
        self.rng.bit_generator.state = state["rng"]


class Repaired(Paired):
    """Trains two students on replayed levels of an adversary. A `Method`; see `Paired` for the arguments."""

    config: RepairedConfig

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: RepairedConfig | None = None, seed: int = 0
    ) -> None:
        super().__init__(upomdp, ppo, config or RepairedConfig(), seed)

    def make_curriculum(self, space: LevelSpace, seed: int) -> RepairedLevels:
        return RepairedLevels(space, self.config, seed)
