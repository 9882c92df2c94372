"""One episode: what is true of it now, put where the evaluator looks.

An episode has a `Mode` of its own, which the scopes of its threads carry: the values of everything random in this
scene, the draws, and what some statements and functions mean at run time. While its statements run,
`Episode.playing` gives objects, variables and containers their contents in this episode. Outside of it the program is
as it was loaded, so that many episodes of one program can be played in turns. Read next: `dynamics.reference.threads`.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from regista.kernels.rng import streams, uniform
from scenic_lite.core.budget import Budget
from scenic_lite.core.scope import Scope, in_row
from scenic_lite.core.state import EPISODE, Mode
from scenic_lite.core.types import Builtin, Environment, Instance, Namespace, describe_kind, parts_of
from scenic_lite.core.world import World
from scenic_lite.dynamics.machine.bytecode import MAX_LOOP_ITERATIONS
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.program import Program
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, is_number

Handlers = dict[type, Callable[..., Any]]
FORGETTING = 0.99  # what share of all that programs make is counted on when the next behavior runs
STEPS = 20_000_000  # nodes of the tree that a behavior may evaluate before it lets time pass


class Rejected(Exception):
    """The episode breaks a requirement of the program: it is none of its episodes."""


class Patience(Budget):
    """What one behavior may spend in one step.

    Rounds of `while`, of `for` over a range, and handlers that end count, as in the machine; a loop over a list ends.
    """

    rounds = 0

    def step(self) -> None:
        self.steps += 1
        if self.steps > STEPS:
            raise ScenicError("budget", f"more than {STEPS:,} steps of evaluation without an action")

    def round(self) -> None:
        self.rounds += 1
        if self.rounds > MAX_LOOP_ITERATIONS:
            hint = "is a take or wait missing in a loop?"
            message = f"more than {MAX_LOOP_ITERATIONS:,} rounds of loops without an action"
            raise ScenicError("budget", message, hint=hint)


class Episode:
    """The state of one episode.

    Attributes:
        time: steps since the start. timestep: seconds per step.
        objects: those of the program in the order of the scene, then those that scenarios made.
    """

    def __init__(self, program: Program, theta: np.ndarray, world: World, seed: int) -> None:
        self.program, self.world = program, world
        self._rng = np.zeros(1, dtype=[("random", "u8")]).view(np.recarray)[0]
        self._rng.random = streams([seed])[0]
        self.time, self.timestep = 0, world.timestep
        self.active = False  # its statements run: it is being played, and not rejected
        self.objects = list(program.instances)
        self._scene: dict[RandomExpr, Value] = dict(program.row(theta))
        self.row = dict(self._scene)
        self.simulation: Namespace | None = None
        self._facts: dict[str, float] = {}
        self._table: list[dict[str, float]] = []
        self.suspending: dict[type, Callable[..., Any]] = {}
        self.records: dict[str, Any] = {}  # what `record` has kept, by name
        self.scenario: Any = None  # the one whose statements run now
        self._own = [(container, container.copy()) for container in changeable(program)]
        for instance in program.instances:
            own = {name: sampled(value, self.row) for name, value in instance.properties.items()}
            self._own.append((instance.properties, own | {"lastActions": ()}))
        self.mode = self._mode()
        self.state = self.mode.state

    def _mode(self) -> Mode:
        """Return how the nodes of this episode are evaluated; what its statements make is its own."""
        loaded = self.program.mode
        state = replace(loaded.state.copy_to_play(), objects=self.objects)
        simulation = Builtin("simulation", lambda: self.simulation, over_choices=False)
        handlers = replace(loaded.handlers, builtins=loaded.handlers.builtins | {"simulation": simulation})
        return Mode(EPISODE, state, handlers, Patience(state.budget.limits), self._draw, row=self.row)

    def scope(self, environment: Environment) -> Scope:
        """Return a scope with the same names, as they are in this episode."""
        return Scope.at(self.mode, environment)

    def install(self, statements: Handlers, expressions: Handlers, suspending: Handlers) -> None:
        """Say what nodes mean in an episode: statements of an instant, expressions, statements in which time passes."""
        handlers = self.mode.handlers
        handlers = replace(
            handlers, statements=handlers.statements | statements, expressions=handlers.expressions | expressions
        )
        self.mode = replace(self.mode, handlers=handlers)
        self.suspending = suspending

    def take_reward(self) -> float:
        """Return what `simulation().scenic_reward` says, and clear it."""
        assert self.simulation is not None
        value, self.simulation.names["scenic_reward"] = self.simulation.names["scenic_reward"], 0.0
        return float(value)

    @contextmanager
    def playing(self) -> Iterator[None]:
        """Let the program mean this episode inside: all that it may change has the contents that it has here."""
        loaded = [container.copy() for container, _ in self._own]
        for container, own in self._own:
            fill(container, own)
        self.active = True
        try:
            yield
        finally:
            self.active = False
            self._own = [(container, container.copy()) for container, _ in self._own]
            for (container, _), contents in zip(self._own, loaded, strict=True):
                fill(container, contents)

    def rested(self) -> None:
        """Give what runs next its own patience; most of what was made before counts as forgotten."""
        budget = self.mode.budget
        assert isinstance(budget, Patience)
        budget.steps = budget.rounds = budget.calls = budget.scenes = 0
        budget.memory = int(budget.memory * FORGETTING)

    def refresh(self, table: np.ndarray, facts: np.ndarray, first: bool) -> None:
        """Take in the world [O, F] and the facts [G] of this step, inside `playing`.

        While the episode starts, guards still see the properties that the scene gives the objects, until `show`.
        """
        self.rested()
        self.row.clear()
        self.row.update(self._scene)
        known = dict(zip(self.world.facts, map(float, facts), strict=True))
        self.time = int(known["time"])
        self._facts = known | {"time": self.time}
        self._table = [dict(zip(self.world.fields, map(float, row), strict=True)) for row in table]
        if not first:
            self.show()
        self._see_simulation()

    def show(self) -> None:
        """Give the objects their live properties."""
        for instance, fields in zip(self.objects, self._table, strict=False):
            instance.properties.update(self.world.properties(instance, fields))

    def _see_simulation(self) -> None:
        seen = self.world.simulation(self.objects, self._facts)
        if self.simulation is None:
            self.simulation = Namespace(seen.name, {"scenic_reward": 0.0, **seen.names}, open=True)
        else:
            update(self.simulation, seen, ("scenic_reward",))

    def in_steps(self, duration: Value, scope: Scope, node: ast.expr, unit: str | None) -> float:
        """Return how many steps a duration takes that is given in steps or in seconds."""
        if not is_number(duration):
            raise scope.error("type", f"a duration is a number, not {describe_kind(duration)}", node)
        return duration if unit == "steps" else duration / self.timestep

    def uniform(self) -> float:
        """Draw the next number in [0, 1) of the match's stream, the one that a compiled program draws too."""
        return float(uniform(self._rng))

    def _draw(self, kind: str, place: SourceSpan, offset: float, span: float) -> ThetaColumn:
        """Make a draw with its value at once."""
        column = ThetaColumn(kind, place, offset, span)
        self.row[column] = column.offset + column.span * self.uniform()
        return column


def update(old: Namespace, new: Namespace, kept: tuple[str, ...] = ()) -> None:
    """Let a namespace that a program may hold on to show what is new."""
    for name, value in new.names.items():
        before = old.names.get(name)
        if isinstance(before, Namespace) and isinstance(value, Namespace):
            update(before, value)
        elif name not in kept:
            old.names[name] = value


def sampled(value: Value, row: dict[RandomExpr, Value]) -> Value:
    """Return a value as it is in one sample; a container without anything random stays the same."""
    value = in_row(value, row)
    if isinstance(value, list | tuple):
        parts = [sampled(element, row) for element in value]
        return value if all(map(operator.is_, parts, value)) else type(value)(parts)
    if isinstance(value, dict):
        pairs = {key: sampled(element, row) for key, element in value.items()}
        return value if all(element is value[key] for key, element in pairs.items()) else pairs
    return value


# ------------------------------------------------------------ what an episode may change
def fill(container: Any, contents: Any) -> None:
    container.clear()
    if isinstance(container, list):
        container.extend(contents)
    else:
        container.update(contents)


def changeable(program: Program) -> list[Any]:
    """Return what loading has made and an episode may change, but for the properties of objects.

    So a list that behaviors add to begins every episode as the program wrote it.
    """
    attributes = [instance.attributes for instance in program.instances]
    return list({id(own): own for own in (*variables(program), *containers(program), *attributes)}.values())


def variables(program: Program) -> list[dict[str, Value]]:
    """Return the names that an episode may assign: those of the main scenario, and of modules by `global`."""
    modules = [behavior.scope.module_names for behavior in program.behaviors.values()]
    return modules if program.main_frame is None else [*modules, program.main_frame.locals]


def containers(program: Program) -> list[Any]:
    """Return the lists, dictionaries and sets that behaviors, monitors and conditions can reach."""
    pending: list[Value] = [*program.read_in_episodes, *program.instances, program.mode.state.params]
    if program.main_frame is not None:
        pending += program.main_frame.locals.values()
    mutable: list[Any] = []
    seen: set[int] = set()
    while pending:
        value = pending.pop()
        parts = parts_within(value)
        if parts and id(value) not in seen:
            pending += parts
        if isinstance(value, list | dict | set) and id(value) not in seen:
            mutable.append(value)
        seen.add(id(value))
    return mutable


def parts_within(value: Value) -> tuple[Value, ...]:
    """Return what can be reached through a value."""
    if isinstance(value, Instance):
        return (*value.properties.values(), *value.attributes.values())
    return tuple(value.names.values()) if isinstance(value, Namespace) else parts_of(value)
