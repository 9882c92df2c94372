"""Rollouts in a simulator's kernel: what `learning.worker` does step by step, in one call for many steps.

The weights are copied once per rollout; learning stays in torch. The numbers that actions are sampled from come from the
worker's generator, in the order in which single steps would draw them, so both ways take the same actions.
Read next: `core.compiled`, the records; `kernels.rollout`, the kernels; `learning.packing`, the weights.
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
import torch
from gymnasium.spaces import Discrete

from ued.core.compiled import COUNTERS, LANES, CompiledRollout, Envs, Events, Levels, Steps
from ued.core.upomdp import PREFETCH, UPOMDP
from ued.learning.packing import empty_policy, fill_policy
from ued.learning.rollout import Rollout
from ued.learning.student import Normaliser

if TYPE_CHECKING:
    from ued.learning.worker import RolloutWorker

SHARED = "returns", "lengths", "training"  # arrays of a worker that the kernel changes


@runtime_checkable
class LevelsAhead(Protocol):
    """Levels for rollouts that start episodes on their own; see `levels.queue.StudentQueue`."""

    def at_hand(self) -> np.ndarray:
        """Return the next level records `[K]`, in the order in which environments are to take them."""

    def most(self) -> int:
        """Return how many levels may be taken now; further environments repeat theirs."""

    def due(self) -> list[int]:
        """Return the episodes left on the level of each environment `[N]`."""

    def apply(self, events: Events, due: list[int]) -> None:
        """Note the episodes that ended and the levels taken; `due` as it is now."""


def can_compile(worker: RolloutWorker) -> bool:
    """Return whether a simulator can play a worker's rollouts: flat float32 observations, discrete actions, on the host,
    and levels from a queue.
    """
    student = worker.student
    return (
        worker.upomdp.plays_rollouts
        and student is not None
        and student.device.type == "cpu"
        and isinstance(student.normaliser, Normaliser)
        and isinstance(student.action_space, Discrete)
        and worker.rollout.observation.dtype == torch.float32
        and isinstance(worker.on_episode_end, LevelsAhead)
    )


class CompiledWorker:
    """Plays the rollouts of a worker, whose arrays it shares; see `can_compile`."""

    def __init__(self, worker: RolloutWorker) -> None:
        assert worker.student is not None and isinstance(worker.on_episode_end, LevelsAhead)
        self.worker, self.ahead, upomdp = worker, worker.on_episode_end, worker.upomdp
        size = worker.rollout.observation.shape[-1]
        count = len(worker.rollout.terminated) * upomdp.num_envs
        self.record = CompiledRollout(
            empty_policy(worker.student, size),
            steps_of(worker.rollout, upomdp.num_agents),
            empty_envs(upomdp, size, worker.memory.shape[1]),
            Levels(*(np.zeros(PREFETCH, kind) for kind in ("i8", "u8", "i8", "i8", "?"))),
            Events(*(np.zeros(count, kind) for kind in ("i8", "i8", "i8", "f8", "i8", "f8", "i8"))),
            np.zeros(1, COUNTERS).view(np.recarray),
        )

    def begin(self) -> None:
        """Start a rollout: copy the weights, draw the random numbers of its actions."""
        worker, steps, envs = self.worker, self.record.steps, self.record.envs
        fill_policy(self.record.policy, worker.student)
        torch.from_numpy(steps.uniform).uniform_(generator=worker.generator)
        for name in SHARED:  # another array after `load_state_dict`
            array = getattr(envs, name)
            array[:] = getattr(worker, name)
            setattr(worker, name, array)
        envs.memory[:] = worker.memory.numpy()
        worker.memory = torch.from_numpy(envs.memory)
        self._show(worker.observation)
        self.record.counters["step"] = 0

    def play(self, until: int) -> None:
        """Play the rollout up to this step."""
        counters = self.record.counters[0]
        while counters.step < until:
            began, first = perf_counter(), int(counters.step)
            records = self.ahead.at_hand()
            self._announce(records, until)
            self.worker.upomdp.play(self.record, records["level"])
            self.worker.seconds["sim"] += perf_counter() - began
            self._note(first, records)
            if counters.failed:
                self.worker.upomdp.report_failure()
            if counters.needs_level:
                self._end_episodes()

    def finish(self) -> None:
        """End the rollout: hand the observations back."""
        seen = self.record.envs.observation.copy()
        self.worker.observation = seen if self.worker.upomdp.num_agents > 1 else seen[:, 0]

    def _show(self, observation: np.ndarray | None) -> None:
        assert observation is not None
        self.record.envs.observation[:] = observation.reshape(self.record.envs.observation.shape)

    def _announce(self, records: np.ndarray, until: int) -> None:
        """Write down the levels at hand and what is left of the present ones."""
        levels, counters, count = self.record.levels, self.record.counters[0], len(records)
        levels.seed[:count] = records["level"]["seed"]
        levels.visit[:count] = np.maximum(records["visit"], 0)
        levels.num_episodes[:count] = records["num_episodes"]
        levels.train[:count] = records["train"]
        levels.start[count:] = -1
        self.record.envs.due[:] = self.ahead.due()
        counters.until, counters.taken, counters.most, counters.events = until, 0, self.ahead.most(), 0
        counters.needs_level = counters.failed = False

    def _note(self, first: int, records: np.ndarray) -> None:
        """Note what happened from step `first` on."""
        worker, events, counters = self.worker, self.record.events, self.record.counters[0]
        last = int(counters.step) + bool(counters.needs_level or counters.failed)  # steps that were played
        worker.env_steps += (last - first) * worker.upomdp.num_envs
        ended = Events(*(column[: counters.events] for column in events))
        if worker.tape is not None:
            worker.tape.extend(self._actions(first, last))
            for k in np.flatnonzero(ended.taken >= 0):
                ago = last - 1 - int(ended.step[k])
                worker.tape.begin(ended.env[k : k + 1], records["visit"][ended.taken[k]][None], ago)
        worker.note_episodes(ended.returns, ended.length)
        self.ahead.apply(ended, self.record.envs.due.tolist())

    def _actions(self, first: int, last: int) -> np.ndarray:
        """Return the environments' actions of these steps, `[k, N]` or `[k, N, A]`."""
        worker = self.worker
        assert worker.student is not None
        return worker.student.to_environment(worker.rollout.action[first:last])

    def _end_episodes(self) -> None:
        """End the episodes of a step after which a level is needed that was not at hand."""
        counters, envs = self.record.counters[0], self.record.envs
        self.worker.end_episodes(envs.ended.copy(), {"success": envs.success})
        self._show(self.worker.observation)
        counters.step += 1


def steps_of(rollout: Rollout, agents: int) -> Steps:
    """Return the columns of a rollout as arrays with an axis of agents, in the same memory."""
    shape = rollout.terminated.shape
    by_agent = {name: getattr(rollout, name).numpy().reshape(*shape, agents) for name in BY_AGENT}
    return Steps(
        observation=rollout.observation.numpy().reshape(*shape, agents, -1),
        reward=rollout.reward.numpy().reshape(*shape, -1),
        terminated=rollout.terminated.numpy(),
        truncated=rollout.truncated.numpy(),
        train=rollout.train.numpy(),
        uniform=np.zeros((*shape, agents), np.float32),
        **by_agent,
    )


BY_AGENT = "action", "log_prob", "value", "final_value"


def empty_envs(upomdp: UPOMDP, size: int, memory_width: int) -> Envs:
    """Allocate the state of environments with observations of this size."""
    count, agents = upomdp.num_envs, upomdp.num_agents
    integers = {name: np.zeros(count, np.int64) for name in ("lengths", "due", "visit", "episode", "start")}
    flags = {name: np.zeros(count, np.bool_) for name in ("training", "ended", "restart")}
    return Envs(
        observation=np.zeros((count, agents, size), np.float32),
        action=np.zeros((count, agents), np.int64),
        memory=np.zeros((count, memory_width), np.float32),
        returns=np.zeros(count),
        seed=np.zeros(count, np.uint64),
        success=np.zeros(count),
        final_observation=np.zeros((LANES, agents, size), np.float32),
        final_memory=np.zeros((LANES, memory_width), np.float32),
        final_value=np.zeros((LANES, agents), np.float32),
        final_env=np.zeros(LANES, np.int64),
        **integers,
        **flags,
    )
