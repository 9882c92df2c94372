"""Environments with known optimal curricula, on which methods can be compared in minutes.

    regista compare ued.probes:frontier --methods dr plr accel paired --seeds 10

In `Frontier`, domain randomization wastes most of its steps: the levels that can be learned next are a thin shell,
which moves outward as the student learns. The success rate on the test "every length" is the share of turns that the
student has learned. Read next: `core.task`; `methods`, the methods.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from ued.core.cells import bin_center
from ued.core.level_space import check_theta
from ued.core.parameters import Column, Range
from ued.core.task import Task
from ued.core.upomdp import UPOMDP

ACTIONS = 4


class Frontier(UPOMDP):
    """A path of hidden turns; θ determines its length.

    At each place k of the path one of four actions is correct, the same one on every level. The reward at the end of a
    path of length L is 1 if all L actions were correct, else 0; after a wrong action the episode continues to the end.
    A student that has learned the first K turns solves every path of length up to K. It solves a path of length K + 1,
    the frontier, with probability 1/4. Much longer paths give no reward; shorter paths are already solved.

    The length grows with the largest of the first D - 1 columns of θ. A share of (K / longest)^(D - 1) of all levels is
    no longer than K, so short paths are rare. If the last column exceeds `blocked_above`, the path is blocked,
    and the reward is always 0; a minimax adversary converges to such levels.

    Observation `[longest + 2]`: one-hot of the place, whether an action was wrong, and L / longest. A student that has
    learned K turns solves the open levels with L <= K, so its success rate on `test_levels` is K / longest.

    Args:
        num_envs: N.
        longest: maximum length of a path.
        dim: D.
        blocked_above: a path is blocked if the last column of θ exceeds this number; 1: no path is blocked.
        turns: seed of the hidden turns.
    """

    seed_is_luck = True  # the environment is deterministic

    def __init__(
        self, num_envs: int = 32, longest: int = 20, dim: int = 4, blocked_above: float = 0.8, turns: int = 0
    ) -> None:
        if longest < 1 or dim < 2:
            raise ValueError(f"longest must be at least 1 and dim at least 2, got {longest} and {dim}")
        self.longest, self.blocked_above = longest, blocked_above
        self.turns = np.random.default_rng(turns).integers(0, ACTIONS, longest)
        draws = [Column(f"length{i}", Range(0.0, float(longest))) for i in range(dim - 1)] + [
            Column("block", Range(0.0, 1.0))
        ]
        super().__init__(num_envs, Box(0.0, 1.0, (longest + 2,), np.float32), Discrete(ACTIONS), draws)
        self.place = np.zeros(num_envs, np.int64)
        self.lost = np.zeros(num_envs, bool)
        self.knowing = False  # whether the environment plays the correct actions instead of those passed to it

    def length(self, theta: np.ndarray) -> np.ndarray:
        """Return the length `[n]` of the paths of levels θ `[n, D]`: 1 .. longest."""
        theta = check_theta(theta, self.theta_dim)
        return np.clip(np.ceil((theta[:, :-1].max(1) + 1) / 2 * self.longest), 1, self.longest).astype(np.int64)

    def blocked(self, theta: np.ndarray) -> np.ndarray:
        """Return which levels are unsolvable: bool `[n]`."""
        return check_theta(theta, self.theta_dim)[:, -1] > self.blocked_above

    def test_levels(self) -> np.ndarray:
        """Return one open level of each length: `[longest]` records."""
        theta = np.zeros((self.longest, self.theta_dim))
        theta[:, :-1] = bin_center(np.arange(self.longest), self.longest)[:, None]
        return self.make_levels(theta)

    def _observe(self) -> np.ndarray:
        seen = np.zeros((self.num_envs, self.longest + 2), np.float32)
        seen[np.arange(self.num_envs), np.minimum(self.place, self.longest - 1)] = 1.0
        seen[:, -2] = self.lost
        seen[:, -1] = self.length(self.levels["theta"]) / self.longest
        return seen

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        self.place[where], self.lost[where] = 0, False
        return self._observe()

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        theta = self.levels["theta"]
        at_end = self.place >= self.length(theta)  # the episode has ended and was not restarted
        if not self.knowing:
            self.lost |= np.asarray(actions) != self.turns[np.minimum(self.place, self.longest - 1)]
        self.place += ~at_end
        ended = self.place >= self.length(theta)
        reward = (ended & ~self.lost & ~self.blocked(theta)).astype(float)
        return self._observe(), reward, ended, np.zeros_like(ended), {}

    def with_scripted_policy(self) -> Frontier:
        """Return a copy that plays the correct actions: the scripted antagonist."""
        twin = self.copy()
        twin.knowing = True
        return twin

    def get_state(self) -> dict[str, Any]:
        return {**self.level_state(), "place": self.place.copy(), "lost": self.lost.copy()}

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        place = np.asarray(state["place"]) if isinstance(state, dict) and "place" in state else self.place
        if not (place.shape == (self.num_envs,) and ((place >= 0) & (place <= self.longest)).all()):
            raise ValueError(f"place must be {self.num_envs} integers from 0 to {self.longest}, got {place}")
        self.set_level_state(state, "place", "lost")
        self.place[:], self.lost[:] = place, state["lost"]
        return self._observe()

    def copy(self) -> Frontier:
        return copy.deepcopy(self)


LONGEST = 15  # path of the task `frontier`
# Short episodes, small networks and buffers. PAIRED trains on no random levels, since they give no reward.
DEFAULTS = {
    "total_env_steps": 200_000,
    "num_envs": 32,
    "eval_every": 10_000,
    "eval_episodes": 5 * LONGEST,
    "ppo.num_steps": 64,
    "ppo.learning_rate": 2e-3,
    "ppo.gamma": 0.99,
    "ppo.num_minibatches": 4,
    "ppo.update_epochs": 4,
    "ppo.ent_coef": 0.05,
    "ppo.hidden_size": 64,
    "paired.dr_fraction": 0.0,
    "repaired.dr_fraction": 0.0,
    **{f"{method}.buffer.capacity": 256 for method in ("plr", "accel", "cenie", "repaired")},
}


def _frontier(num_envs: int) -> Frontier:
    return Frontier(num_envs, LONGEST)


frontier = Task(_frontier, {"every length": Frontier(1, LONGEST).test_levels()["theta"]}, defaults=DEFAULTS)
