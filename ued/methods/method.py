"""What methods are made of: learners, a curriculum, and a queue that brings its levels to them.

A method's `update()` is its paper's algorithm box: `play` lets all learners fill a rollout with levels that the
curriculum proposed, and returns those that every learner has finished; the method scores them, lets its curriculum and
its learners learn, and ends with `report`. A rollout is not cut to levels: each environment takes a new one when it has
played its own often enough (see `levels.queue`). Where a curriculum only looks at a level (PLR⊥, children of ACCEL,
candidates of SFL), its steps are simulated and counted, and no student learns from them.
Read next: `methods.dr`, the simplest method; `methods.plr`; `methods.paired`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
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


class Method:
    """A way to train students on levels of its choice. Every method is one, with a `begin` and an `update` of its own.

    Args:
        upomdp: the environments; they are reset and belong to this object from then on.
        ppo: how every student learns.
        config: the method's own settings, a dataclass of `ued.config`; None: the default ones.
        seed: of every random stream.
        env_steps: how many will be simulated; a method with a buffer or a teacher begins earlier in a short run. None:
            not known; see `levels.budget`.

    Attributes:
        curriculum: what chooses the levels.
        queue: brings its levels to the learners.
        learners: in the order of the students in level records.
        updates: training iterations so far.
        last: the levels that the last update was based on.
        budget: how long the run is, and how much of that is spent.
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
        self._seeds = SeedStream(seed)
        self.upomdp, self.ppo, self.budget = upomdp, ppo or PPOConfig(), Budget(upomdp.num_envs, env_steps)
        self.learners: list[Learner] = []
        self.updates = 0
        self.last: LevelBatch | None = None
        upomdp.reset(seed=self._seeds.next())
        self._columns = upomdp.draws if upomdp.family is None else ()
        self.begin(config, self._seeds.next())

    def begin(self, config: Any, seed: int) -> None:
        """Make the `curriculum`, of this seed, and the `queue`, and add the learners."""
        raise NotImplementedError(f"{type(self).__name__} has no begin")

    def add_learner(self, name: str, upomdp: UPOMDP, scripted: bool = False) -> Learner:
        """Let one more learner begin to play the queue's levels in environments of its own; see `Learner`.

        Raises `RoomError` where the machine has no memory for it.
        """
        index = len(self.learners)
        if not scripted:
            check_learners(self.ppo, upomdp.agent_observation_space, upomdp.num_envs, upomdp.num_agents, index + 1)
        self.queue.prefetch[index] = upomdp.prefetch
        on_episode_end = partial(self.queue.on_episode_end, index)
        self.learners.append(Learner(name, upomdp, self.ppo, self._seeds, on_episode_end, scripted))
        self.learners[index].start(self.queue.first(index))
        return self.learners[index]

    # ------------------------------------------------------------ one update

    def update(self) -> dict[str, float]:
        """Do one training iteration; return its metrics."""
        raise NotImplementedError(f"{type(self).__name__} has no update")

    def play(self) -> np.ndarray:
        """Let all learners fill a rollout; return the level records `[L]` that all of them have now finished."""
        self.roll_out()
        return self.queue.pop_finished()

    def roll_out(self) -> None:
        """Let all learners fill a rollout with the queue's levels and look back on it."""
        self.budget.spent = self.env_steps
        self.queue.begin_rollout()
        collect([learner.worker for learner in self.learners])
        for index, learner in enumerate(self.learners):
            self.queue.record_value_stats(index, learner.compute_advantages())
        self._played = perf_counter()

    def report(self, levels: np.ndarray, metrics: dict[str, float]) -> dict[str, float]:
        """End an update that was based on these levels `[L]`; return its metrics and those that all methods have."""
        by_learner = [learner.pop_seconds() for learner in self.learners]
        seconds = {f"time/{name}": sum(spent[name] for spent in by_learner) for name in by_learner[0]}
        seconds["time/curriculum"] = perf_counter() - self._played - seconds["time/learn"]
        self.last = LevelBatch(levels, [learner.name for learner in self.learners])
        self.updates += 1
        counters = {"env_steps": float(self.env_steps), "updates": float(self.updates)}
        programs = program_metrics(levels, self.upomdp.program_names)
        return counters | metrics | level_metrics(levels, self._columns) | programs | seconds

    def keep_tapes(self) -> None:
        """Keep from now on what is done on each level, `learner.worker.tape`, so that episodes can be played again."""
        for index, learner in enumerate(self.learners):
            learner.worker.tape = ActionTape(learner.upomdp.num_envs)
            if not learner.worker.env_steps:
                learner.worker.tape.begin(np.arange(learner.upomdp.num_envs), self.queue.turns(index))

    # ------------------------------------------------------------ what others ask

    @property
    def student(self) -> Student:
        """The policy to evaluate: the first one (PAIRED: the protagonist)."""
        return next(iter(self.students.values()))

    @property
    def students(self) -> dict[str, Student]:
        """All policies in training, by name."""
        return {learner.name: learner.student for learner in self.learners if learner.student is not None}

    @property
    def buffer(self) -> LevelBuffer | None:
        """The levels that are kept to be replayed; None where none are."""
        return None

    @property
    def env_steps(self) -> int:
        """Steps simulated so far, for whatever purpose."""
        return sum(learner.worker.env_steps for learner in self.learners)

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return everything: a method made anew with the same arguments resumes from it to the same numbers.

        `episodes=False` leaves out the state of the environments, which for a `GymUPOMDP` no checkpoint can hold; open
        episodes then begin anew.
        """
        return {
            "learners": [learner.state_dict(episodes) for learner in self.learners],
            "curriculum": self.curriculum.state_dict(),
            "queue": self.queue.state_dict(),
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned. Raises ValueError if it is of another number of agents."""
        for learner, saved in zip(self.learners, state["learners"], strict=True):
            learner.load_state_dict(saved)
        self.curriculum.load_state_dict(state["curriculum"])
        self.queue.load_state_dict(state["queue"])
        self.updates = restored(self.updates, state["updates"], "updates")

    def start_from(self, student: Mapping[str, Any], kl_coef: float = 0.0, kl_env_steps: int = 0) -> None:
        """Let all learners begin with this student, a `state_dict`; see `Learner.start_from`."""
        for learner in self.learners:
            learner.start_from(student, kl_coef, kl_env_steps)

    def load_students(self, state: dict[str, Any]) -> None:
        """Take back the students alone of what `state_dict` returned, to be played: the environments may have changed.

        Raises ValueError for students of another number of agents, RuntimeError for other observations or actions.
        """
        for learner, saved in zip(self.learners, state["learners"], strict=True):
            learner.check_agents(saved)
            if learner.student is not None:
                learner.student.load_state_dict(saved["ppo"]["student"])
