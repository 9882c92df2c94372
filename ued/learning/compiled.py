"""A worker whose rollouts a simulator plays in a kernel: many steps of `learning.worker` in one call.

The weights are copied once per rollout; learning stays in torch. The worker's generator draws the random numbers of
actions in the same order as single steps do, so both ways take the same actions.
Read next: `core.compiled`, the records; `kernels.rollout`, the kernels; `learning.packing`, the weights.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any, Protocol, runtime_checkable

import numpy as np
import torch
from gymnasium.spaces import Discrete

from ued.core.compiled import COUNTERS, LANES, CompiledRollout, Envs, Events, Levels, Steps
from ued.core.own_code import is_name
from ued.core.upomdp import PREFETCH, UPOMDP, steps_as_it_plays
from ued.learning import worker
from ued.learning.packing import empty_policy, fill_policy
from ued.learning.rollout import Rollout
from ued.learning.student import Normaliser, Student
from ued.learning.worker import RolloutWorker, visits_of

BY_AGENT = "action", "log_prob", "value", "final_value"
SHARED = "returns", "lengths", "training"  # arrays of a worker that the kernel changes


@runtime_checkable
class LevelsAhead(Protocol):
    """Levels for rollouts that start episodes on their own; see `levels.queue.StudentQueue`."""

    def at_hand(self) -> np.ndarray:
        """Return the next level records `[K]`, in the order in which environments are to take them."""

    def most(self) -> int:
        """Return how many levels may be taken now; other environments repeat their levels."""

    def due(self) -> list[int]:
        """Return the episodes left on the level of each environment `[N]`."""

    def apply(self, events: Events, due: list[int]) -> None:
        """Record the episodes that ended, the levels taken, and the current `due`."""


class CompiledWorker(RolloutWorker):
    """A worker whose simulator plays its rollouts if possible; see `is_compiled`. For arguments see `RolloutWorker`."""

    record: CompiledRollout | None = None  # None until the first rollout

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "record": None}  # its arrays belong to this rollout, not to a copy

    @property
    def is_compiled(self) -> bool:
        """Whether the simulator plays the rollouts.

        The simulator must support it, and no subclass may override its steps. Observations must be float32 vectors
        without images, actions discrete, and levels from a queue. The student must be on the host, with a built-in
        network.
        """
        return (
            worker.COMPILED
            and self.upomdp.plays_rollouts
            and steps_as_it_plays(self.upomdp)
            and self.student is not None
            and self.student.device.type == "cpu"
            and isinstance(self.student.normaliser, Normaliser)
            and not is_name(self.student.network)
            and not (self.student.shared and len(self.student.actor_hidden))  # heads must be single layers
            and isinstance(self.student.action_space, Discrete)
            and self.rollout.observation.dtype == torch.float32
            and isinstance(self.on_episode_end, LevelsAhead)
        )

    def begin(self) -> None:
        """Start a rollout: copy the weights and draw the random numbers of its actions."""
        super().begin()
        if not self.is_compiled:
            return
        if self.record is None:
            self.record = self._empty_record()
        steps, envs = self.record.steps, self.record.envs
        fill_policy(self.record.policy, self._student)
        torch.from_numpy(steps.uniform).uniform_(generator=self.generator)
        for name in SHARED:  # `load_state_dict` replaces these arrays
            array = getattr(envs, name)
            array[:] = getattr(self, name)
            setattr(self, name, array)
        envs.memory[:] = self.memory.numpy()
        self.memory = torch.from_numpy(envs.memory)
        self._show(envs)
        self.record.counters["step"] = 0

    def play(self, until: int) -> None:
        """Play the rollout up to this step."""
        assert self.record is not None
        record, counters = self.record, self.record.counters[0]
        while counters.step < until:
            began, first = perf_counter(), int(counters.step)
            records = self._levels.at_hand()
            self._announce(record, records)
            counters.until = until
            self.upomdp.play(record, records["level"])
            self.seconds["sim"] += perf_counter() - began
            self._look(record.envs)
            self._note(record, first, records)
            if counters.failed:
                self.upomdp.report_failure()
            if counters.needs_level:
                self.end_episodes(record.envs.ended.copy(), {"success": record.envs.success})
                self._show(record.envs)
                counters.step += 1

    @property
    def _student(self) -> Student:
        assert self.student is not None
        return self.student

    @property
    def _levels(self) -> LevelsAhead:
        assert isinstance(self.on_episode_end, LevelsAhead)
        return self.on_episode_end

    def _empty_record(self) -> CompiledRollout:
        size, count = self.rollout.observation.shape[-1], self.rollout.terminated.numel()
        return CompiledRollout(
            empty_policy(self._student, size),
            steps_of(self.rollout, self.upomdp.num_agents),
            empty_envs(self.upomdp, size, self.memory.shape[1]),
            Levels(*(np.zeros(PREFETCH, kind) for kind in ("i8", "u8", "i8", "i8", "?"))),
            Events(*(np.zeros(count, kind) for kind in ("i8", "i8", "i8", "f8", "i8", "f8", "i8"))),
            np.zeros(1, COUNTERS).view(np.recarray),
        )

    def _show(self, envs: Envs) -> None:
        """Pass the observations to the simulator."""
        assert self.observation is not None
        envs.observation[:] = self.observation.reshape(envs.observation.shape)

    def _look(self, envs: Envs) -> None:
        """Copy the observations back, also after an error, since the next rollout starts with them."""
        seen = envs.observation.copy()
        self.observation = seen if self.upomdp.num_agents > 1 else seen[:, 0]

    def _announce(self, record: CompiledRollout, records: np.ndarray) -> None:
        """Write the next levels to the record, and the number of episodes left on the current levels."""
        levels, counters, count = record.levels, record.counters[0], len(records)
        levels.seed[:count] = records["level"]["seed"]
        levels.visit[:count] = visits_of(records)
        levels.num_episodes[:count] = records["num_episodes"]
        levels.train[:count] = records["train"]
        levels.start[count:] = -1
        record.envs.due[:] = self._levels.due()
        counters.taken, counters.most, counters.events = 0, self._levels.most(), 0
        counters.needs_level = counters.failed = False

    def _note(self, record: CompiledRollout, first: int, records: np.ndarray) -> None:
        """Record the results of the steps from `first` on."""
        counters = record.counters[0]
        last = int(counters.step) + bool(counters.needs_level or counters.failed)  # end of the steps that were played
        ended = Events(*(column[: counters.events] for column in record.events))
        self.env_steps += (last - first) * self.upomdp.num_envs
        if self.tape is not None:
            self.tape.extend(self._student.to_environment(self.rollout.action[first:last]))
            for k in np.flatnonzero(ended.taken >= 0):
                visit, ago = records["visit"][ended.taken[k]], last - 1 - int(ended.step[k])
                self.tape.begin(ended.env[k : k + 1], visit[None], ago)
        self.note_episodes(ended.returns, ended.length)
        self._levels.apply(ended, record.envs.due.tolist())


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
