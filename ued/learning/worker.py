"""A rollout worker: plays a policy in its own N environments and carries episodes over from one rollout to the next.

`collect` lets several workers go through their rollouts side by side, which is what keeps the two students of PAIRED
at about the same level of the same curriculum. Read next: `learning.ppo`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Discrete

from ued.core.resumable import Resumable
from ued.core.upomdp import UPOMDP
from ued.learning.rollout import Rollout
from ued.learning.student import Student
from ued.learning.tape import ActionTape
from ued.learning.upload import write

# Called with the environments `[k]` whose episodes have just ended, their returns and success `[k]` (1, 0, nan: not
# known); returns the environments `[c]` that change their level and the level records `[c]` that they get. The others
# play on.
OnEpisodeEnd = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Episodes:
    """Finished episodes, in the order in which they ended: `returns` `[E]`, `lengths` `[E]`."""

    returns: np.ndarray
    lengths: np.ndarray


class RolloutWorker(Resumable):
    """Plays in N environments and fills its rollout.

    Args:
        student: what plays; None where the environment plays the learner's part itself and heeds no action (see
            `UPOMDP.with_scripted_policy`): values and log-probabilities are 0 then.
        upomdp: N environments that nobody else uses. Its `next_levels` is cleared: `on_episode_end` decides on levels.
        num_steps: T of the rollout.
        generator: what actions are drawn from.
        on_episode_end: supplies the levels; see `OnEpisodeEnd`.
    """

    state_fields = ("training", "generator", "returns", "lengths", "memory", "env_steps")

    def __init__(
        self,
        student: Student | None,
        upomdp: UPOMDP,
        num_steps: int,
        generator: torch.Generator,
        on_episode_end: OnEpisodeEnd,
    ) -> None:
        self.student, self.upomdp, self.generator, self.on_episode_end = student, upomdp, generator, on_episode_end
        upomdp.next_levels = None
        spaces = upomdp.agent_observation_space, upomdp.agent_action_space
        self.memory = torch.zeros(upomdp.num_envs, 0) if student is None else student.empty_memory(upomdp.num_envs)
        agents = upomdp.num_agents, upomdp.paid_apart
        self.rollout = Rollout.empty(num_steps, upomdp.num_envs, *spaces, *agents, self.memory.shape[1])
        self.observation: np.ndarray | None = None  # until `start`
        self.training = np.ones(upomdp.num_envs, bool)  # [N] where the student learns from what it does
        self.returns = np.zeros(upomdp.num_envs)  # [N] of the open episodes
        self.lengths = np.zeros(upomdp.num_envs, np.int64)  # [N]
        self.env_steps = 0
        self.seconds = {"sim": 0.0, "forward": 0.0, "levels": 0.0}
        self.tape: ActionTape | None = None  # until somebody wants to see episodes again
        self.send: Callable[[np.ndarray, torch.Tensor], None] = write  # to where the student is
        self._ended: tuple[list[float], list[int]] = [], []  # returns and lengths of episodes, a few in each step

    def start(self, records: np.ndarray) -> None:
        """Begin an episode on the level of each of these records `[N]`."""
        self.observation, _ = self.upomdp.reset_to_levels(records["level"], None, visits_of(records))
        self.training[:] = records["train"]
        if self.tape is not None:
            self.tape.begin(np.arange(len(records)), records["turn"])
        self.returns[:] = 0.0
        self.lengths[:] = 0
        self.memory[:] = 0.0

    def begin(self) -> None:
        """Begin a rollout: note what the student remembers of the open episodes."""
        self.rollout.memory.copy_(self.memory)

    def look(self, t: int) -> None:
        """Let the student begin to judge what it sees before step t; on a GPU it does so while the host goes on."""
        assert self.observation is not None
        began, seen = perf_counter(), self.rollout.observation[t]
        self.send(self.observation, seen)
        if self.student is not None:
            self.judged = self.student.judge(seen, self.memory)
        self.seconds["forward"] += perf_counter() - began

    def step(self, t: int) -> None:
        """Take step t of the rollout in all environments, at which the student has looked."""
        rollout, began = self.rollout, perf_counter()
        actions = self._act(t)
        rollout.train[t] = torch.as_tensor(self.training)
        if self.tape is not None:
            self.tape.note(actions)
        acted = perf_counter()
        self.observation, reward, terminated, truncated, info = self.upomdp.advance(actions)
        self.seconds["forward"] += acted - began
        self.seconds["sim"] += perf_counter() - acted
        rollout.reward[t] = torch.as_tensor(info["agent_rewards"] if self.upomdp.paid_apart else reward)
        rollout.terminated[t] = torch.as_tensor(terminated)
        rollout.truncated[t] = torch.as_tensor(truncated)
        self._value_final_observations(t, truncated & ~terminated)
        self.returns += reward
        self.lengths += 1
        self.env_steps += self.upomdp.num_envs
        ended = terminated | truncated
        if ended.any():
            self._end_episodes(ended, info)

    def _act(self, t: int) -> np.ndarray:
        """Return the actions of step t for the environments; note what the policy drew."""
        if self.student is None:
            space = self.upomdp.agent_action_space
            return self.rollout.action[t].numpy() + (space.start if isinstance(space, Discrete) else 0)
        action, log_prob, value = self.student.draw(*self.judged, self.generator)
        self.rollout.action[t], self.rollout.log_prob[t], self.rollout.value[t] = action, log_prob, value
        return self.student.to_environment(action)

    def _value_final_observations(self, t: int, cut: np.ndarray) -> None:
        """Note what would have followed the episodes that were cut off in step t: bool `[N]`."""
        self.rollout.final_value[t] = 0.0
        if cut.any() and self.student is not None:
            final = torch.as_tensor(np.asarray(self.observation)[cut], dtype=torch.float32)
            where = torch.as_tensor(cut)
            self.rollout.final_value[t, where] = self.student.value(final, self.memory[where])

    def _end_episodes(self, mask: np.ndarray, info: dict[str, Any]) -> None:
        """Note the episodes that ended, bool `[N]`, and start others in their places."""
        ended = np.flatnonzero(mask)
        returns = self.returns[ended]
        self._ended[0].extend(returns.tolist())
        self._ended[1].extend(self.lengths[ended].tolist())
        self.returns[ended] = 0.0
        self.lengths[ended] = 0
        self.memory.numpy()[ended] = 0.0
        began = perf_counter()
        success = np.asarray(info["success"], float)[ended] if "success" in info else np.full(len(ended), np.nan)
        envs, records = self.on_episode_end(ended, returns, success)
        chosen = perf_counter()
        self._start_episodes(mask, envs, records)
        self.seconds["levels"] += chosen - began
        self.seconds["sim"] += perf_counter() - chosen

    def _start_episodes(self, ended: np.ndarray, envs: np.ndarray, records: np.ndarray) -> None:
        """Start episodes where some ended, bool `[N]`: in `envs` `[c]` on new levels, elsewhere on the old ones."""
        changing = np.zeros(self.upomdp.num_envs, bool)
        changing[envs] = True
        again = ended & ~changing
        if again.any():
            self.observation = self.upomdp.play_again(again)
        if len(envs):
            self.training[envs] = records["train"]
            if self.tape is not None:
                self.tape.begin(envs, records["turn"])
            order = np.argsort(envs)
            levels, visits = records["level"][order], visits_of(records)[order]
            self.observation, _ = self.upomdp.reset_to_levels(levels, changing, visits)

    def finish(self) -> None:
        """Close the rollout: value what comes after its last step."""
        if self.student is not None:
            last = torch.as_tensor(self.observation, dtype=torch.float32)
            self.rollout.last_value[:] = self.student.value(last, self.memory)

    def pop_episodes(self) -> Episodes:
        """Return the episodes that ended since the last call."""
        (returns, lengths), self._ended = self._ended, ([], [])
        return Episodes(np.array(returns, np.float64), np.array(lengths, np.int64))

    def pop_seconds(self) -> dict[str, float]:
        """Return the seconds spent since the last call, simulating, asking the network, and choosing levels."""
        seconds, self.seconds = self.seconds, dict.fromkeys(self.seconds, 0.0)
        return seconds

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return everything that changes besides the student's weights.

        `episodes=False` leaves out the environments, whose state may be no data (as in `GymUPOMDP`); their episodes
        then begin anew on the same levels.
        """
        return super().state_dict() | {
            "upomdp": self.upomdp.get_state() if episodes else None,
            **self.upomdp.level_state(),
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned. Raises ValueError if it is of another number of environments."""
        super().load_state_dict({"memory": self.memory} | state)  # those of before there were any have none
        for name in ("training", "returns", "lengths", "memory"):
            if len(getattr(self, name)) != self.upomdp.num_envs:
                raise ValueError(f"{name} must be of {self.upomdp.num_envs} environments")
        self._ended = [], []  # of an update that broke off
        if state["upomdp"] is None:
            self.upomdp.set_level_state(state)
            numbers = state["visits"], state["episodes"]
            self.observation, _ = self.upomdp.reset_to_levels(state["levels"], None, *numbers)
            self.returns[:], self.lengths[:], self.memory[:] = 0.0, 0, 0.0
        else:
            self.observation = self.upomdp.set_state(state["upomdp"])


def visits_of(records: np.ndarray) -> np.ndarray:
    """Return the numbers of these visits of levels `[k]`; 0 for records that nobody has numbered."""
    return np.maximum(records["turn"], 0)


def collect(workers: Sequence[RolloutWorker]) -> None:
    """Fill the workers' rollouts, one step of each in turn.

    All look before the first one acts: on a GPU the others' networks are at work while its environments are simulated.
    """
    for worker in workers:
        worker.begin()
    for t in range(len(workers[0].rollout.reward)):
        for worker in workers:
            worker.look(t)
        for worker in workers:
            worker.step(t)
    for worker in workers:
        worker.finish()
