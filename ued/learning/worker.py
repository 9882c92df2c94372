"""A rollout worker: runs a policy in its own N environments; episodes continue from one rollout to the next.

`collect` steps several workers in turn, so that the students of PAIRED play about the same levels at the same time.
Read next: `learning.ppo`.
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
from ued.learning.rounding import Rounding
from ued.learning.student import Student
from ued.learning.tape import ActionTape
from ued.learning.upload import write

COMPILED = True  # False: all rollouts step by step in torch, the reference for compiled ones
STRIDE = 16  # steps that a worker plays before the next worker plays
# Called with the environments `[k]` whose episodes have just ended, their returns, and their success `[k]` (1, 0, nan:
# unknown); returns the environments `[c]` that change their level, and their new level records `[c]`.
OnEpisodeEnd = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Episodes:
    """Finished episodes, in the order in which they ended: `returns` `[E]`, `lengths` `[E]`."""

    returns: np.ndarray
    lengths: np.ndarray


class RolloutWorker(Resumable):
    """Steps N environments and fills its rollout.

    Args:
        student: the policy; None for environments that ignore actions (see `UPOMDP.with_scripted_policy`): values and
            log-probabilities are then 0.
        upomdp: N environments of this worker only. Sets its `level_sampler` to None: `on_episode_end` selects levels.
        num_steps: T of the rollout.
        generator: random stream of the actions.
        on_episode_end: selects the levels; see `OnEpisodeEnd`.
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
        upomdp.level_sampler = None
        spaces = upomdp.agent_observation_space, upomdp.agent_action_space
        self.memory = torch.zeros(upomdp.num_envs, 0) if student is None else student.empty_memory(upomdp.num_envs)
        agents = upomdp.num_agents, upomdp.individual_rewards
        self.rollout = Rollout.empty(num_steps, upomdp.num_envs, *spaces, *agents, self.memory.shape[1])
        self.observation: np.ndarray | None = None  # None until `start`
        self.training = np.ones(upomdp.num_envs, bool)  # [N] whether the student learns from the step
        self.returns = np.zeros(upomdp.num_envs)  # [N] returns of the open episodes
        self.lengths = np.zeros(upomdp.num_envs, np.int64)  # [N]
        self.env_steps = 0
        self.seconds = {"sim": 0.0, "forward": 0.0, "levels": 0.0}
        self.tape: ActionTape | None = None  # set if episodes will be replayed
        self.send: Callable[[np.ndarray, torch.Tensor], None] = write  # sends to the device of the student
        self.rounding = Rounding()
        self._ended: tuple[list[float], list[int]] = [], []  # returns and lengths of ended episodes

    def start(self, records: np.ndarray) -> None:
        """Start an episode on the level of each record `[N]`."""
        self.observation, _ = self.upomdp.reset_to_levels(records["level"], None, visits_of(records))
        self.training[:] = records["train"]
        if self.tape is not None:
            self.tape.begin(np.arange(len(records)), records["visit"])
        self.returns[:] = 0.0
        self.lengths[:] = 0
        self.memory[:] = 0.0

    def begin(self) -> None:
        """Start a rollout: store the memory of the student at its first step."""
        self.rollout.memory.copy_(self.memory)
        self.rounding.note(self.observation)

    @property
    def is_compiled(self) -> bool:
        """Whether `play` plays many steps in one call; see `learning.compiled`. Otherwise use `observe` and `step`."""
        return False

    def play(self, until: int) -> None:
        """Play the rollout up to this step."""
        raise NotImplementedError("rollouts of this worker are played step by step")

    def observe(self, t: int) -> None:
        """Compute the policy and values at the observations of step t; a GPU works while the host continues."""
        assert self.observation is not None
        began, seen = perf_counter(), self.rollout.observation[t]
        self.send(self.observation, seen)
        if self.student is not None:
            self.inferred = self.student.infer(seen, self.memory)
        self.seconds["forward"] += perf_counter() - began

    def step(self, t: int) -> None:
        """Take step t of the rollout in all environments, after `observe`."""
        rollout, began = self.rollout, perf_counter()
        actions = self._act(t)
        rollout.train[t] = torch.as_tensor(self.training)
        if self.tape is not None:
            self.tape.note(actions)
        acted = perf_counter()
        self.observation, reward, terminated, truncated, info = self.upomdp.advance(actions)
        self.seconds["forward"] += acted - began
        self.seconds["sim"] += perf_counter() - acted
        rollout.reward[t] = torch.as_tensor(info["agent_rewards"] if self.upomdp.individual_rewards else reward)
        rollout.terminated[t] = torch.as_tensor(terminated)
        rollout.truncated[t] = torch.as_tensor(truncated)
        self._value_final_observations(t, truncated & ~terminated)
        self.returns += reward
        self.lengths += 1
        self.env_steps += self.upomdp.num_envs
        ended = terminated | truncated
        if ended.any():
            self.end_episodes(ended, info)

    def _act(self, t: int) -> np.ndarray:
        """Sample the actions of step t, store them in the rollout, and return them for the environments."""
        if self.student is None:
            space = self.upomdp.agent_action_space
            return self.rollout.action[t].numpy() + (space.start if isinstance(space, Discrete) else 0)
        action, log_prob, value = self.student.draw(*self.inferred, self.generator)
        self.rollout.action[t], self.rollout.log_prob[t], self.rollout.value[t] = action, log_prob, value
        return self.student.to_environment(action)

    def _value_final_observations(self, t: int, cut: np.ndarray) -> None:
        """Store the value of the last observations of the episodes truncated in step t: `cut` bool `[N]`."""
        self.rollout.final_value[t] = 0.0
        if cut.any() and self.student is not None:
            final = torch.as_tensor(np.asarray(self.observation)[cut], dtype=torch.float32)
            where = torch.as_tensor(cut)
            self.rollout.final_value[t, where] = self.student.value(final, self.memory[where])

    def note_episodes(self, returns: np.ndarray, lengths: np.ndarray) -> None:
        """Record the returns and lengths of episodes that ended, `[k]`, in their order."""
        self._ended[0].extend(returns.tolist())
        self._ended[1].extend(lengths.tolist())

    def end_episodes(self, mask: np.ndarray, info: dict[str, Any]) -> None:
        """Record the episodes that ended, `mask` bool `[N]`, and start the next ones."""
        ended = np.flatnonzero(mask)
        returns = self.returns[ended]
        self.note_episodes(returns, self.lengths[ended])
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
        """Start episodes where episodes ended, bool `[N]`: in `envs` `[c]` on new levels, else on the same levels."""
        changing = np.zeros(self.upomdp.num_envs, bool)
        changing[envs] = True
        again = ended & ~changing
        if again.any():
            self.observation = self.upomdp.play_again(again)
        if len(envs):
            self.training[envs] = records["train"]
            if self.tape is not None:
                self.tape.begin(envs, records["visit"])
            order = np.argsort(envs)
            levels, visits = records["level"][order], visits_of(records)[order]
            self.observation, _ = self.upomdp.reset_to_levels(levels, changing, visits)

    def finish(self) -> None:
        """Finish the rollout: store the values of the observations after its last step."""
        self.rounding.note(self.observation)
        if self.student is not None:
            last = torch.as_tensor(self.observation, dtype=torch.float32)
            self.rollout.last_value[:] = self.student.value(last, self.memory)

    def pop_episodes(self) -> Episodes:
        """Return the episodes that ended since the last call."""
        (returns, lengths), self._ended = self._ended, ([], [])
        return Episodes(np.array(returns, np.float64), np.array(lengths, np.int64))

    def pop_seconds(self) -> dict[str, float]:
        """Return the seconds since the last call, by activity: simulation, network, choice of levels."""
        seconds, self.seconds = self.seconds, dict.fromkeys(self.seconds, 0.0)
        return seconds

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return the whole state except the student's weights.

        `episodes=False` leaves out the state of the environments, which checkpoints may not support (`GymUPOMDP`); a
        resumed run then restarts their episodes on the same levels.
        """
        return super().state_dict() | {
            "upomdp": self.upomdp.get_state() if episodes else None,
            **self.upomdp.level_state(),
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`. Raises ValueError for another number of environments."""
        super().load_state_dict({"memory": self.memory} | state)  # older states have no memory
        for name in ("training", "returns", "lengths", "memory"):
            if len(getattr(self, name)) != self.upomdp.num_envs:
                raise ValueError(f"{name} must have {self.upomdp.num_envs} rows, one per environment")
        self._ended = [], []  # drop episodes of an interrupted update
        if state["upomdp"] is None:
            self.upomdp.set_level_state(state)
            numbers = state["visits"], state["episodes"]
            self.observation, _ = self.upomdp.reset_to_levels(state["levels"], None, *numbers)
            self.returns[:], self.lengths[:], self.memory[:] = 0.0, 0, 0.0
        else:
            self.observation = self.upomdp.set_state(state["upomdp"])


def visits_of(records: np.ndarray) -> np.ndarray:
    """Return the numbers of these visits of levels `[k]`; 0 for records without a number."""
    return np.maximum(records["visit"], 0)


def collect(workers: Sequence[RolloutWorker]) -> None:
    """Fill the workers' rollouts, some steps of each in turn."""
    for worker in workers:
        worker.begin()
    num_steps, alone = len(workers[0].rollout.reward), len(workers) == 1
    compiled = [worker for worker in workers if worker.is_compiled]
    others = [worker for worker in workers if not worker.is_compiled]
    stride = (num_steps if alone else STRIDE) if compiled else 1
    for first in range(0, num_steps, stride):
        until = min(first + stride, num_steps)
        for worker in compiled:
            worker.play(until)
        play_in_turn(others, first, until)
    for worker in workers:
        worker.finish()


def play_in_turn(workers: Sequence[RolloutWorker], first: int, until: int) -> None:
    """Play steps `first` to `until` of the rollouts, one step of each worker in turn.

    All networks are evaluated before the first worker steps: a GPU evaluates other networks during the simulation.
    """
    for t in range(first, until):
        for worker in workers:
            worker.observe(t)
        for worker in workers:
            worker.step(t)
