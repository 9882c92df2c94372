"""The parts of a method: learners, a curriculum, and a queue that passes its levels to them.

A method's `update()` is the algorithm box of its paper. `collect_rollouts` lets all learners fill a rollout with levels
of the curriculum, and returns those that every learner has finished. Then `curriculum.update(levels)` scores them and
learns from the scores, the learners learn from their rollouts, and `report` ends the update. Rollouts are not aligned
with levels: each environment takes a new level after the episodes of its level (see `levels.queue`). Levels that a
curriculum only evaluates (PLR⊥, children of ACCEL, candidates of SFL) count as simulated steps, but no student learns
from them.
Read next: `methods.dr`, the simplest method; `methods.plr`; `methods.paired`.
"""

from __future__ import annotations

import typing
from collections.abc import Mapping
from contextlib import suppress
from time import perf_counter
from typing import Any

import numpy as np

from ued.config import PPOConfig
from ued.core.curriculum import Curriculum
from ued.core.resumable import restored
from ued.core.room import check_learners
from ued.core.seeding import SeedStream
from ued.core.upomdp import UPOMDP
from ued.learning.learner import Learner
from ued.learning.student import Student
from ued.learning.tape import ActionTape
from ued.learning.worker import collect
from ued.levels.batch import LevelBatch
from ued.levels.budget import Budget
from ued.levels.buffer import LevelBuffer
from ued.levels.diagnostics import level_metrics, program_metrics
from ued.levels.queue import LevelQueue
from ued.levels.record import NEGATIVE


class Method:
    """Chooses levels and trains students on them. Each method is a subclass that defines `setup` and `update`.

    Args:
        upomdp: the environments, for this method only; they are reset.
        ppo: settings of every student.
        config: settings of the method, a dataclass of `ued.config`; None: the defaults.
        seed: seed of all random streams.
        env_steps: length of the run; replay and teachers start earlier in a short run. None: unknown; see
            `levels.budget`.

    Raises:
        ValueError: arguments of the wrong type, and settings of another method.

    Attributes:
        curriculum: chooses the levels.
        queue: passes its levels to the learners.
        learners: learners in the order of the students in level records.
        updates: training iterations so far.
        last: the levels of the last update.
        budget: length of the run, and the steps so far.
    """

    curriculum: Curriculum
    queue: LevelQueue

    def __init__(
        self,
        upomdp: UPOMDP,
        ppo: PPOConfig | None = None,
        config: Any = None,
        seed: int = 0,
        env_steps: int | None = None,
    ) -> None:
        self._check(upomdp, ppo, config)
        self._seeds = SeedStream(seed)
        self.upomdp, self.ppo, self.budget = upomdp, ppo or PPOConfig(), Budget(upomdp.num_envs, env_steps)
        self.learners: list[Learner] = []
        self.updates = 0
        self.last: LevelBatch | None = None
        upomdp.reset(seed=self._seeds.next())
        self._columns = upomdp.parameters if upomdp.level_family is None else ()
        self.setup(config, self._seeds.next())

    def _check(self, upomdp: Any, ppo: Any, config: Any) -> None:
        """Raise `ValueError` for arguments of the wrong type, such as the settings of another method.

        The type of a method's settings is that of the argument of `setup`, or a subclass by a user.
        """
        name = type(self).__name__
        if not isinstance(upomdp, UPOMDP):
            raise ValueError(f"{name} trains on a UPOMDP, such as a ued.GymUPOMDP, got {upomdp!r:.100}")
        if ppo is not None and not isinstance(ppo, PPOConfig):
            raise ValueError(f"{name}(upomdp, ppo, config): ppo must be a PPOConfig, got {ppo!r:.60}")
        own: Any = None
        with suppress(NameError):  # a user's setup may have annotations that exist only for a type checker
            own = next(iter(typing.get_args(typing.get_type_hints(type(self).setup).get("config"))), None)
        if config is None or not hasattr(own, "__dataclass_fields__"):
            return
        of_another = type(config) is not own and type(config).__module__ == own.__module__
        if of_another or not isinstance(config, own):
            raise ValueError(f"{name}(upomdp, ppo, config): config must be a {own.__name__}, got {config!r:.60}")

    def setup(self, config: Any, seed: int) -> None:
        """Create the `curriculum`, with this seed, and the `queue`, and add the learners."""
        raise NotImplementedError(f"{type(self).__name__} must define setup")

    def add_learner(self, name: str, upomdp: UPOMDP, scripted: bool = False) -> Learner:
        """Add a learner with its own environments, which starts on the levels of the queue; see `Learner`.

        Raises:
            RoomError: if the machine has too little memory.
        """
        index = len(self.learners)
        if not scripted:
            check_learners(self.ppo, upomdp.agent_observation_space, upomdp.num_envs, upomdp.num_agents, index + 1)
        self.queue.prefetch[index] = upomdp.prefetch
        if upomdp.plays_rollouts:  # a rollout is interrupted for every block of levels
            self.queue.propose_in_blocks()
        self.learners.append(Learner(name, upomdp, self.ppo, self._seeds, self.queue.of(index), scripted))
        if NEGATIVE in (self.curriculum.dtype.names or ()):
            self.learners[index].follow_negative_advantages()
        self.learners[index].start(self.queue.first(index))
        return self.learners[index]

    # ------------------------------------------------------------ one update

    def update(self) -> dict[str, float]:
        """Do one training iteration; return its metrics."""
        raise NotImplementedError(f"{type(self).__name__} must define update")

    def collect_rollouts(self) -> np.ndarray:
        """Let all learners fill a rollout; return the level records `[L]` that all of them have finished."""
        self.fill_rollouts()
        return self.queue.pop_finished()

    def fill_rollouts(self) -> None:
        """Let all learners fill a rollout with the queue's levels, and compute its advantages."""
        self.budget.spent = self.env_steps
        self.queue.begin_rollout()
        collect([learner.worker for learner in self.learners])
        for index, learner in enumerate(self.learners):
            self.queue.record_value_stats(index, learner.compute_advantages())
        self._played = perf_counter()

    def report(self, levels: np.ndarray, metrics: dict[str, float]) -> dict[str, float]:
        """End an update on these levels `[L]`; return its metrics with those of all methods."""
        by_learner = [learner.pop_seconds() for learner in self.learners]
        seconds = {f"time/{name}": sum(spent[name] for spent in by_learner) for name in by_learner[0]}
        seconds["time/curriculum"] = perf_counter() - self._played - seconds["time/learn"]
        self.last = LevelBatch(levels, [learner.name for learner in self.learners])
        self.updates += 1
        counters = {"env_steps": float(self.env_steps), "updates": float(self.updates)}
        programs = program_metrics(levels, self.upomdp.program_names)
        return counters | metrics | level_metrics(levels, self._columns) | programs | seconds

    def keep_tapes(self) -> None:
        """Record the actions of learners from now on, in `learner.worker.tape`, so that episodes can be replayed."""
        for index, learner in enumerate(self.learners):
            learner.worker.tape = ActionTape(learner.upomdp.num_envs)
            if not learner.worker.env_steps:
                learner.worker.tape.begin(np.arange(learner.upomdp.num_envs), self.queue.visits(index))

    # ------------------------------------------------------------ students and state

    @property
    def student(self) -> Student:
        """The student to evaluate: the first student (PAIRED: the protagonist)."""
        return next(iter(self.students.values()))

    @property
    def students(self) -> dict[str, Student]:
        """All students, by name."""
        return {learner.name: learner.student for learner in self.learners if learner.student is not None}

    @property
    def buffer(self) -> LevelBuffer | None:
        """The buffer of levels to replay; None for a method without a buffer."""
        return None

    @property
    def env_steps(self) -> int:
        """All steps simulated so far, including those of evaluated levels."""
        return sum(learner.worker.env_steps for learner in self.learners)

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return the whole state; a method with the same arguments resumes from it with identical results.

        `episodes=False` leaves out the state of the environments, which no checkpoint can hold for a `GymUPOMDP`; open
        episodes are then restarted.
        """
        return {
            "learners": [learner.state_dict(episodes) for learner in self.learners],
            "curriculum": self.curriculum.state_dict(),
            "queue": self.queue.state_dict(),
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        Raises:
            ValueError: a state with another number of agents.
        """
        for learner, saved in zip(self.learners, state["learners"], strict=True):
            learner.load_state_dict(saved)
        self.curriculum.load_state_dict(state["curriculum"])
        self.queue.load_state_dict(state["queue"])
        self.updates = restored(self.updates, state["updates"], "updates")

    def start_from(self, student: Mapping[str, Any], kl_coef: float = 0.0, kl_env_steps: int = 0) -> None:
        """Let all learners start from this student, a `state_dict`; see `Learner.start_from`."""
        for learner in self.learners:
            learner.start_from(student, kl_coef, kl_env_steps)

    def load_students(self, state: dict[str, Any]) -> None:
        """Restore only the students of a state, to evaluate them; the environments may differ.

        Raises:
            ValueError: students of another number of agents.
            RuntimeError: students for other observations or actions.
        """
        for learner, saved in zip(self.learners, state["learners"], strict=True):
            learner.check_agents(saved)
            if learner.student is not None:
                learner.student.load_state_dict(saved["ppo"]["student"])
