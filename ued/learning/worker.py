"""A student in its own N environments: plays step by step, carries episodes over from one rollout to the next.

`collect` lets several players go through their rollouts side by side, which is what keeps the two students of PAIRED
at about the same level of the same curriculum. Read next: `learning.ppo`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import torch

from ued.learning.rollout import Rollout
from ued.learning.student import Scripted, Student
from ued.upomdp import UPOMDP

# Called with the environments `[k]` whose episodes have just ended and their returns `[k]`; gives the environments that
# change their level and the trials (see `trials`) they get. The others play their level again.
Renew = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Episodes:
    """Finished episodes, in the order in which they ended: `level` `[E]` records, `returns` `[E]`, `lengths` `[E]`."""

    level: np.ndarray
    returns: np.ndarray
    lengths: np.ndarray


class Player:
    """Plays a student in N environments and fills its rollout.

    Args:
        student: what plays.
        upomdp: N environments that nobody else uses. Its `next_levels` is cleared: `renew` decides about levels.
        num_steps: T of the rollout.
        generator: what actions are drawn from.
        renew: supplies the levels; see `Renew`.
    """

    def __init__(
        self, student: Student | Scripted, upomdp: UPOMDP, num_steps: int, generator: torch.Generator, renew: Renew
    ) -> None:
        self.student, self.upomdp, self.generator, self.renew = student, upomdp, generator, renew
        upomdp.next_levels = None
        spaces = upomdp.single_observation_space, upomdp.single_action_space
        self.rollout = Rollout.empty(num_steps, upomdp.num_envs, *spaces)
        self.observation: np.ndarray | None = None  # until `start`
        self.training = np.ones(upomdp.num_envs, bool)  # where the student learns from what it does
        self.returns = np.zeros(upomdp.num_envs)  # of the open episodes
        self.lengths = np.zeros(upomdp.num_envs, np.int64)
        self.env_steps = 0
        self.seconds = {"sim": 0.0, "forward": 0.0, "levels": 0.0}
        self._ended: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def start(self, trials: np.ndarray) -> None:
        """Begin an episode on the level of each of these trials `[N]`."""
        self.observation, _ = self.upomdp.reset_to_levels(trials["level"])
        self.training[:] = trials["train"]
        self.returns[:] = 0.0
        self.lengths[:] = 0

    def step(self, t: int) -> None:
        """Take step t of the rollout in all environments."""
        rollout, began = self.rollout, perf_counter()
        rollout.observation[t] = torch.as_tensor(self.observation)
        action, rollout.log_prob[t], rollout.value[t] = self.student.act(rollout.observation[t], self.generator)
        rollout.action[t] = action
        rollout.train[t] = torch.as_tensor(self.training)
        acted = perf_counter()
        self.observation, reward, terminated, truncated, info = self.upomdp.step(self.student.to_environment(action))
        self.seconds["forward"] += acted - began
        self.seconds["sim"] += perf_counter() - acted
        rollout.reward[t] = torch.as_tensor(reward)
        rollout.terminated[t] = torch.as_tensor(terminated)
        rollout.truncated[t] = torch.as_tensor(truncated)
        self._value_what_was_cut_off(t, truncated & ~terminated, info)
        self.returns += reward
        self.lengths += 1
        self.env_steps += self.upomdp.num_envs
        ended = np.flatnonzero(terminated | truncated)
        if len(ended):
            self._end_episodes(ended)

    def _value_what_was_cut_off(self, t: int, cut: np.ndarray, info: dict[str, Any]) -> None:
        self.rollout.final_value[t] = 0.0
        if cut.any():
            final = torch.as_tensor(np.asarray(info["final_obs"])[cut], dtype=torch.float32)
            self.rollout.final_value[t, torch.as_tensor(cut)] = self.student.value(final)

    def _end_episodes(self, ended: np.ndarray) -> None:
        returns = self.returns[ended]
        self._ended.append((self.upomdp.levels[ended], returns, self.lengths[ended]))
        self.returns[ended] = 0.0
        self.lengths[ended] = 0
        began = perf_counter()
        where, trials = self.renew(ended, returns)
        self.seconds["levels"] += perf_counter() - began
        if len(where):
            began = perf_counter()
            mask = np.zeros(self.upomdp.num_envs, bool)
            mask[where] = True
            self.training[where] = trials["train"]
            self.observation, _ = self.upomdp.reset_to_levels(trials["level"][np.argsort(where)], mask)
            self.seconds["sim"] += perf_counter() - began

    def finish(self) -> None:
        """Close the rollout: value what comes after its last step."""
        self.rollout.last_value[:] = self.student.value(torch.as_tensor(self.observation, dtype=torch.float32))

    def take_episodes(self) -> Episodes:
        """Give the episodes that ended since the last call."""
        ended, self._ended = self._ended, []
        if not ended:
            return Episodes(self.upomdp.levels[:0].copy(), np.zeros(0), np.zeros(0, np.int64))
        level, returns, lengths = (np.concatenate(column) for column in zip(*ended, strict=True))
        return Episodes(level, returns, lengths)

    def take_seconds(self) -> dict[str, float]:
        """Give the seconds spent since the last call, simulating, asking the network, and choosing levels."""
        seconds, self.seconds = self.seconds, dict.fromkeys(self.seconds, 0.0)
        return seconds

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Give everything that changes besides the student's weights.

        `episodes=False` leaves out the environments, whose state may be no data (as in `GymUPOMDP`); their episodes
        then begin anew on the same levels.
        """
        return {
            "upomdp": self.upomdp.get_state() if episodes else None,
            "levels": self.upomdp.levels.copy(),
            "training": self.training.copy(),
            "np_random": self.upomdp.np_random.bit_generator.state,
            "generator": self.generator.get_state(),
            "returns": self.returns.copy(),
            "lengths": self.lengths.copy(),
            "env_steps": self.env_steps,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.returns[:] = state["returns"]
        self.lengths[:] = state["lengths"]
        self.training[:] = state["training"]
        if state["upomdp"] is None:
            self.upomdp.np_random.bit_generator.state = state["np_random"]
            self.observation, _ = self.upomdp.reset_to_levels(state["levels"])
            self.returns[:], self.lengths[:] = 0.0, 0
        else:
            self.observation = self.upomdp.set_state(state["upomdp"])
        self.generator.set_state(state["generator"])
        self.env_steps = state["env_steps"]


def collect(players: Sequence[Player]) -> None:
    """Fill the players' rollouts, one step of each in turn."""
    for t in range(len(players[0].rollout.reward)):
        for player in players:
            player.step(t)
    for player in players:
        player.finish()
