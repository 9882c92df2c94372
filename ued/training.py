"""The training loop, the same for every method: S students play the trials of a curriculum and learn by PPO.

    repeat
        the students play the levels that the curriculum proposes            (collect)
        the curriculum learns what came of the levels that are settled       (curriculum.update)
        the students learn from the steps on levels meant for learning       (ppo.learn)

A method is a curriculum on top of it. A rollout is not cut to levels, see `trial_queue`: each environment takes a new
level when it has played its own often enough. Where a curriculum only looks at a level (robust PLR, ACCEL's children,
candidates of SFL), its steps are simulated and counted, and no student learns from them.
Read next: `methods.dr`, the simplest curriculum; `methods.plr`; `methods.paired`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import torch
from torch import Tensor

from ued.config import PPOConfig
from ued.curriculum import Curriculum
from ued.learning.ppo import PPO, Guide
from ued.learning.rollout import gae
from ued.learning.student import Scripted, Student
from ued.learning.value_stats import EpisodeValues
from ued.learning.worker import Player, collect
from ued.levels.diagnostics import level_metrics
from ued.levels.queue import TrialQueue
from ued.levels.record import mean_returns
from ued.method import LevelBatch, episode_metrics, prefixed
from ued.seeding import split_seed, torch_stream
from ued.upomdp import UPOMDP

BLOCK = 8  # trials that are proposed ahead where a curriculum changes with what it proposes
MakeCurriculum = Callable[[UPOMDP, int], Curriculum]  # from the space of levels and a seed


@dataclass
class Seat:
    """A student with all that plays and teaches it."""

    name: str
    player: Player
    ppo: PPO | None  # None: it plays, but does not learn
    values: EpisodeValues


class Training:
    """Trains students on the levels of a curriculum. A `Method`.

    Args:
        upomdp: the environments; they are reset and belong to this object from then on. Each student after the first
            plays in a copy of them.
        make_curriculum: makes the curriculum, of `upomdp` and a seed.
        ppo: how every student learns.
        seed: of every random stream.
        names: of the students; the first is the one to evaluate.
        block: trials that are asked of the curriculum at a time, all of which are played; None: as many as
            environments, of which those that nobody has begun are forgotten after each update, since the curriculum
            has learned.
        keep: an environment takes a new level when it has played its own often enough ("episode"), or the first time
            that this happens in each rollout ("rollout").
    """

    def __init__(
        self,
        upomdp: UPOMDP,
        make_curriculum: MakeCurriculum,
        ppo: PPOConfig | None = None,
        seed: int = 0,
        names: Sequence[str] = ("student",),
        *,
        block: int | None = None,
        max_lead: int | None = None,
        keep: str = "episode",
    ) -> None:
        ppo = ppo or PPOConfig()
        levels, choices, *each = split_seed(seed, 2 + 3 * len(names))
        self.upomdp, self.config_ppo, self.keep, self.forget = upomdp, ppo, keep, block is None
        upomdp.reset(seed=levels)
        self.curriculum = make_curriculum(upomdp, choices)
        self.queue = TrialQueue(
            self.curriculum.propose,
            self.curriculum.dtype,
            upomdp.num_envs,
            2 * upomdp.num_envs if max_lead is None else max_lead,
            upomdp.num_envs if block is None else block,
        )
        self.due = np.ones((len(names), upomdp.num_envs), bool)  # for a new level
        self.updates = 0
        self.last: LevelBatch | None = None
        self.seats: list[Seat] = []
        for index, name in enumerate(names):
            place = self.place_of(index) if index else upomdp
            self.seats.append(self._seat(index, name, place, each[3 * index : 3 * index + 3]))
            self.seats[index].player.start(self.queue.first(index))

    def place_of(self, index: int) -> UPOMDP:
        """Give the environments of student `index` after the first."""
        return self.upomdp.copy()

    def is_scripted(self, index: int) -> bool:
        """Say whether the environments of student `index` need no actions: nobody learns there."""
        return False

    def _seat(self, index: int, name: str, upomdp: UPOMDP, seeds: Sequence[int]) -> Seat:
        weights, actions, minibatches = map(torch_stream, seeds)
        student = Scripted(upomdp.single_action_space) if self.is_scripted(index) else self._student(upomdp, weights)

        def renew(ended: np.ndarray, returns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return self._renew(index, ended, returns)

        player = Player(student, upomdp, self.config_ppo.num_steps, actions, renew)
        ppo = PPO(student, self.config_ppo, minibatches) if isinstance(student, Student) else None
        return Seat(name, player, ppo, EpisodeValues(upomdp.num_envs))

    def _student(self, upomdp: UPOMDP, weights: torch.Generator) -> Student:
        return Student(upomdp.single_observation_space, upomdp.single_action_space, self.config_ppo, weights)

    @property
    def student(self) -> Student:
        return next(iter(self.students.values()))

    @property
    def students(self) -> dict[str, Student]:
        return {seat.name: seat.ppo.student for seat in self.seats if seat.ppo is not None}

    @property
    def env_steps(self) -> int:
        return sum(seat.player.env_steps for seat in self.seats)

    # ------------------------------------------------------------ one update

    def update(self) -> dict[str, float]:
        """Let the students play, the curriculum look at what came of it, and the students learn."""
        self.due[:] = True
        collect([seat.player for seat in self.seats])
        advantages = [self._look_back(seat) for seat in self.seats]
        began = perf_counter()
        for index, advantage in enumerate(advantages):
            self._note_values(index, advantage)
        settled = self._take_settled()
        metrics = self.curriculum.update(settled)
        judged = perf_counter()
        for seat, advantage in zip(self.seats, advantages, strict=True):
            metrics |= episode_metrics(seat.name, seat.player.take_episodes())
            metrics |= prefixed(seat.name, self._learn(seat, advantage))
        learned = perf_counter()
        self.last = self._as_levels(settled)
        self.updates += 1
        return {
            "env_steps": float(self.env_steps),
            "updates": float(self.updates),
            **metrics,
            **level_metrics(settled),
            **prefixed("time", self._seconds() | {"curriculum": judged - began, "learn": learned - judged}),
        }

    def _take_settled(self) -> np.ndarray:
        """Give the trials that all students have played; forget those that nobody has begun if they are outdated."""
        settled = self.queue.take_settled()
        if self.forget:
            self.queue.drop_untaken()
        return settled

    def _renew(self, index: int, ended: np.ndarray, returns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.keep == "rollout":  # the others play on, and what they play is not counted
            ended, returns = ended[self.due[index, ended]], returns[self.due[index, ended]]
        where, trials = self.queue.renew(index, ended, returns)
        self.due[index, where] = False
        return where, trials

    def _look_back(self, seat: Seat) -> Tensor:
        return gae(seat.player.rollout, self.config_ppo.gamma, self.config_ppo.gae_lambda)

    def _note_values(self, index: int, advantages: Tensor) -> None:
        """Note in the trials of student `index` what its critic thought during the episodes."""
        seat = self.seats[index]
        values = seat.values.track(seat.player.rollout, advantages)
        if self.keep == "episode":
            self.queue.note(index, values)

    def _learn(self, seat: Seat, advantages: Tensor) -> dict[str, float]:
        if seat.ppo is None:
            return {}
        return seat.ppo.learn(seat.player.rollout, self.env_steps, advantages, self.guide_of(seat))

    def guide_of(self, seat: Seat) -> Guide | None:
        """Give the policy that a student is drawn to in this update, if any."""
        return None

    # ------------------------------------------------------------ what is told

    def _as_levels(self, settled: np.ndarray) -> LevelBatch:
        means = mean_returns(settled)
        names = [seat.name for seat in self.seats]
        return LevelBatch(
            theta=settled["level"]["theta"],
            returns={name: means[:, s] for s, name in enumerate(names)},
            episodes={name: settled["played"][:, s].astype(np.int64) for s, name in enumerate(names)},
            score=settled["score"],
        )

    def _seconds(self) -> dict[str, float]:
        each = [seat.player.take_seconds() for seat in self.seats]
        return {name: sum(seconds[name] for seconds in each) for name in each[0]}

    # ------------------------------------------------------------ save and resume

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Give everything that changes; without `episodes`, all but the state of the environments."""
        return {
            "players": [seat.player.state_dict(episodes) for seat in self.seats],
            "ppos": [None if seat.ppo is None else seat.ppo.state_dict() for seat in self.seats],
            "values": [seat.values.state_dict() for seat in self.seats],
            "curriculum": self.curriculum.state_dict(),
            "queue": self.queue.state_dict(),
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        for seat, player, ppo, values in zip(self.seats, state["players"], state["ppos"], state["values"], strict=True):
            seat.player.load_state_dict(player)
            if seat.ppo is not None:
                seat.ppo.load_state_dict(ppo)
            seat.values.load_state_dict(values)
            if player["upomdp"] is None:  # its episodes have begun anew
                seat.values.forget()
        self.curriculum.load_state_dict(state["curriculum"])
        self.queue.load_state_dict(state["queue"])
        self.updates = state["updates"]
