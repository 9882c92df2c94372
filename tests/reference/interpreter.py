"""The reference: an episode of a program played by Python's generators, which defines what the language means.

Compiled programs must agree with it, command by command. The order within one step of time is Scenic 3's:

`watch`: 1. the scenario and, inside its compose block, its sub-scenarios take a step (`scenarios`), after the first of
which `record initial` values are taken; 2. `record` values are taken; 3. monitors run, each to its next `wait`, in
Scenic 2 also if the scenario has just ended (in Scenic 3 they end with it); 4. if it has, or a monitor terminates, the
episode ends, else if a `terminate simulation when` is true.
`act`: 5. the behaviors run (`threads`).

A simulator calls `watch`, then `act`, then moves the world on; one whose monitors look at what an action has led to
calls `act` first, and then number 1 of the first step is part of `act`: scenarios take one step at each time, by
whatever they are asked for first. Draws take numbers from the match's stream at the moment when they are evaluated, so
their order is the order of evaluation: left to right, statement by statement, thread by thread.

The episode starts when it is first asked for anything: the main scenario's guards, then the behaviors of the objects
in the order of the scene with their guards, then the monitors in the order of the text. Everything at an instant sees
the same world; only `lastActions`, attributes that programs assign, and global variables change within it. A
program's fault at run time is a ScenicError with its place. Read next: `dynamics.reference.scenarios`,
`dynamics.reference.threads`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from scenic_lite.core.types import Instance
from scenic_lite.core.world import Commands, Verdict, World
from scenic_lite.errors import ScenicError
from scenic_lite.scene.program import Program
from scenic_lite.syntax import nodes
from tests.reference.episode import Episode, Rejected
from tests.reference.scenarios import Scenario
from tests.reference.statements import SUSPENDING, instant_statements, making_objects
from tests.reference.threads import Agents, End


class Reference:
    """One episode of a program in a world.

    Args:
        program: whose episode it is.
        theta: [D], the scene.
        world: the simulator's side of the seam.
        seed: of the draws at run time.
    """

    def __init__(self, program: Program, theta: np.ndarray, world: World, seed: int = 0) -> None:
        self.episode = Episode(program, theta, world, seed)
        self.episode.install(
            instant_statements(self.episode),
            {nodes.New: making_objects(self.episode, program.mode.handlers.expressions[nodes.New])},
            SUSPENDING,
        )
        self._agents = Agents(self.episode)
        main = program.main
        call = None if main is None else replace(main, names={})  # its variables are those of its setup
        self._scenario = self.episode.scenario = Scenario(self.episode, self._agents, call, None)
        self._stepped_at: int | None = None  # None: not begun
        self._complete: str | None = None  # why the scenario has ended in this step
        self._terminated: str | None = None
        self._rejected: str | None = None

    @property
    def records(self) -> dict[str, Any]:
        """Return what `record` has kept by name: a list of (time, value), or the value at the start or end."""
        return self.episode.records

    @property
    def objects(self) -> list[Instance]:
        """Return the rows of the world table: the program's objects, then those that scenarios have made so far."""
        return self.episode.objects

    def act(self, world: np.ndarray, facts: np.ndarray) -> Commands:
        """Return the actions of this step, from the world [O, F] and the facts [G]. Raises ScenicError at a fault."""
        actions: list = []
        if not self._over():
            with self.episode.playing(), self._rejecting():
                self._see(world, facts)
                if self._complete is not None:
                    self._end(f"scenarioComplete: {self._complete}")
                else:
                    actions = self._behaviors()
        return self._commands(actions)

    def watch(self, world: np.ndarray, facts: np.ndarray) -> Verdict:
        """Return what monitors and conditions say of this step. Raises ScenicError at a fault."""
        if self._over():
            return Verdict(0.0, self._terminated, self._rejected)
        with self.episode.playing():
            with self._rejecting():
                self._see(world, facts)
                self._judge()
            reward = self.episode.take_reward()
        return Verdict(reward, None if self._rejected else self._terminated, self._rejected)

    def finish(self) -> str | None:
        """End the episode because its time is over; return which requirement that leaves unsatisfied, if any."""
        if not self._over():
            with self.episode.playing(), self._rejecting():
                self._end("timeLimit: the time of the episode is over")
        return self._rejected

    @contextmanager
    def _rejecting(self) -> Iterator[None]:
        """End the episode by whatever rejects it inside."""
        try:
            yield
        except Rejected as reason:
            self._rejected = str(reason)
            self.episode.active = False
        except ScenicError as error:
            if error.kind != "rejection":
                raise
            self._rejected = error.message

    def _over(self) -> bool:
        return self._terminated is not None or self._rejected is not None

    def _see(self, world: np.ndarray, facts: np.ndarray) -> None:
        """Take in the state; the first time start, and once at each time let the scenario take its step."""
        episode, first = self.episode, self._stepped_at is None
        episode.refresh(world, facts, first)
        if first:
            self._scenario.import_loaded()
            self._scenario.start()
            episode.show()
        if self._stepped_at is None or self._stepped_at < episode.time:
            self._stepped_at = episode.time
            reason = self._scenario.step()
            self._complete = reason.reason() if isinstance(reason, End) else reason
        if first:
            self.records.update(self._scenario.own_records("initial"))

    def _behaviors(self) -> list:
        with self._scenario.current():
            actions, end = self._agents.step()
        if end is None:
            return actions
        self._end(f"terminatedByBehavior: {end.reason()}")
        return []

    def _judge(self) -> None:
        """Take records, run monitors, look at the conditions that end the episode."""
        for name, value in self._scenario.records():
            self.records.setdefault(name, []).append((self.episode.time, value))
        end = self._scenario.run_monitors()
        if end is not None:
            self._end(f"terminatedByMonitor: {end.reason()}")
        elif self._complete is not None:
            self._end(f"scenarioComplete: {self._complete}")
        elif label := self._scenario.simulation_ends():
            self._end(f"simulationTerminationCondition: {label}")

    def _end(self, how: str) -> None:
        """End all scenarios. Raises Rejected if that leaves a requirement unsatisfied."""
        self._terminated = how
        if self._scenario.running:
            self._scenario.stop()
        self.records.update(self._scenario.own_records("final"))

    def _commands(self, actions: list) -> Commands:
        agents = tuple(i for i, taken in enumerate(actions) if taken is not None)
        none = [()] * (len(self.objects) - len(actions))
        terminated = None if self._rejected else self._terminated
        return Commands(tuple(taken or () for taken in [*actions, *none]), agents, terminated, self._rejected)
