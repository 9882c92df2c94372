"""Domain randomisation (Tobin et al. 2017): the student trains on levels drawn uniformly at random.

The baseline of every comparison. The strong form draws a new level for every episode; the weak one, in which parts of
the literature run it, keeps a level for a rollout. Read next: `methods.paired`.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ued.config import DRConfig, PPOConfig
from ued.methods import LevelBatch, episode_metrics, prefixed
from ued.player import Episodes, Player, collect
from ued.ppo import PPO
from ued.streams import split_seed, torch_stream
from ued.student import Student
from ued.upomdp import UPOMDP


class DR:
    """Trains one student on random levels. A `Method`.

    Args:
        upomdp: the environments; they are reset and belong to this object from then on.
        ppo: how the student learns.
        config: which domain randomisation.
        seed: of every random stream.
    """

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: DRConfig | None = None, seed: int = 0
    ) -> None:
        ppo, config = ppo or PPOConfig(), config or DRConfig()
        levels, weights, actions, minibatches = split_seed(seed, 4)
        self.config, self.upomdp = config, upomdp
        upomdp.reset(seed=levels)
        spaces = upomdp.single_observation_space, upomdp.single_action_space
        self.student = Student(*spaces, ppo, torch_stream(weights))
        self.player = Player(self.student, upomdp, ppo.num_steps, torch_stream(actions), self._renew)
        self.ppo = PPO(self.student, ppo, torch_stream(minibatches))
        self.due = np.ones(upomdp.num_envs, bool)  # for a new level when the episode ends
        self.updates = 0
        self.last: LevelBatch | None = None
        self.player.start(upomdp.sample_levels(upomdp.num_envs))

    @property
    def students(self) -> dict[str, Student]:
        return {"student": self.student}

    @property
    def env_steps(self) -> int:
        return self.player.env_steps

    def update(self) -> dict[str, float]:
        """Play one rollout on random levels and learn from it."""
        self.due[:] = True
        collect([self.player])
        began = perf_counter()
        losses = self.ppo.learn(self.player.rollout, self.env_steps)
        learned = perf_counter() - began
        episodes = self.player.take_episodes()
        self.last = _as_levels(episodes)
        self.updates += 1
        return {
            "env_steps": float(self.env_steps),
            "updates": float(self.updates),
            **episode_metrics("student", episodes),
            **prefixed("student", losses),
            **prefixed("time", self.player.take_seconds() | {"learn": learned}),
        }

    def _renew(self, ended: np.ndarray, returns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        where = ended[self.due[ended]]
        if self.config.new_level == "rollout":
            self.due[where] = False
        return where, self.upomdp.sample_levels(len(where))

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Give everything that changes; without `episodes`, all but the state of the environments."""
        return {"player": self.player.state_dict(episodes), "ppo": self.ppo.state_dict(), "updates": self.updates}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.player.load_state_dict(state["player"])
        self.ppo.load_state_dict(state["ppo"])
        self.updates = state["updates"]


def _as_levels(episodes: Episodes) -> LevelBatch:
    """Give one row for each episode."""
    nothing = np.full(len(episodes.returns), np.nan)
    ones = np.ones(len(episodes.returns), np.int64)
    return LevelBatch(episodes.level["theta"], {"student": episodes.returns}, {"student": ones}, nothing)
