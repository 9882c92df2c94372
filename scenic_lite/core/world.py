"""The interface between a simulator and the behaviors and monitors of programs.

A step of the world consists of two tables of numbers: one row per object of the program, and a row of facts about the
match. Functions compute the values that a program reads (`ball.position`, `simulation()`) from these tables. They never
inspect a number, so the same functions work on numbers and on the compiler's registers. Read next:
`tests/reference/interpreter.py`, which runs programs in a world; `envs/toy_world.py`, the smallest world.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from scenic_lite.core.types import Instance, Namespace, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import ADD, MULTIPLY


@dataclass(frozen=True)
class World:
    """A kind of simulator, as programs see it.

    Attributes:
        name: of the simulator, for messages.
        fields: the F columns of the world table [O, F] (float64), one row per object in the order of the scene.
        facts: the G numbers of the match as a whole, table [G] (float64), such as "time": steps since the start.
        timestep: seconds per step.
        properties: the live properties of an object from its fields, by name: {"position": Vector(...), ...}. The
            values of the fields may be numbers or registers of the compiler: can be computed with, but not inspected.
        simulation: the value of `simulation()`, from the objects in the order of the scene and the facts by name. A
            program may set its attribute `scenic_reward`: the reward of this step, 0 unless set.
        command: checks one action of a `take` by an object, and converts it to the simulator's format. Raises
            ScenicError for an action that does not exist, or not for this object.
        actions: the number of actions, if they are the numbers from 0 on; 0 must be the action without effect.
            An object's actions in a step are then one number, too (`packed`). None: actions are values of any kind.
    """

    name: str
    fields: tuple[str, ...]
    facts: tuple[str, ...]
    timestep: float
    properties: Callable[[Instance, dict[str, Value]], dict[str, Value]]
    simulation: Callable[[list[Instance], dict[str, Value]], Namespace]
    command: Callable[[Value, Instance], Value]
    actions: int | None = None

    def no_action(self, number: str) -> str:
        """Return the message for a number that is not an action."""
        assert self.actions is not None
        return f"there is no action {number}; actions are 0 to {self.actions - 1}"


@dataclass(frozen=True)
class Domain:
    """The domain of a program.

    `library` maps a dotted module name, aliases included, to its `.scenic` file. `default_model` is imported by a
    program file that has no `model` line and imports nothing from the library. `params` are the parameters of a program
    that the world uses: similar names cause a warning. `world` is the interface of its simulator for behaviors; None if
    it has none.
    """

    name: str
    library: Mapping[str, Path] = field(default_factory=dict)
    default_model: str | None = None
    params: frozenset[str] = frozenset()
    world: World | None = None

    def home_of(self, name: str) -> str | None:
        """Return the module of the library that defines a name."""
        word = re.compile(rf"^((behavior|monitor|scenario|class|def) +{re.escape(name)}\b|{re.escape(name)} *=)", re.M)
        homes = (module for module, path in self.library.items() if word.search(path.read_text(encoding="utf-8")))
        return next(homes, None)


MOST_AT_ONCE = 8  # actions of one `take`, if they are numbers


def packed(actions: Sequence[Value], base: int) -> Value:
    """Return several actions of one `take` as one number, the first as the highest digit in this base."""
    if len(actions) > MOST_AT_ONCE:
        raise ScenicError("value", f"{len(actions)} actions at once; at most {MOST_AT_ONCE} are possible")
    number = actions[0]
    for action in actions[1:]:
        number = apply(ADD, apply(MULTIPLY, number, base), action)
    return number


NOT_FINITE = "a reward is a finite number"


def checked_reward(value: Value) -> Value:
    """Return the reward that a program sets. Raises ScenicError unless it is a finite number."""
    if kind_of(value) not in ("number", "truth"):
        raise ScenicError("type", f"a reward is a number, not {describe_kind(value)}")
    if not isinstance(value, RandomExpr) and not math.isfinite(value):
        raise ScenicError("value", f"{NOT_FINITE}, not {value}")
    return value


class Commands(NamedTuple):
    """The commands of the behaviors in one step.

    `actions`: a tuple of actions for each object, in the order of the scene; () for an object that waits, whose
    behavior has ended, or that has none. `agents`: the objects that have a behavior. `terminated`: the reason why the
    episode has ended, if it has (see `Verdict`); objects then do not act. `rejected`: the violated requirement, if any.
    """

    actions: tuple[tuple[Value, ...], ...]
    agents: tuple[int, ...]
    terminated: str | None = None
    rejected: str | None = None


class Verdict(NamedTuple):
    """The results of monitors and conditions in one step.

    `reward`: the value of `simulation().scenic_reward` set since the last verdict, or 0. `terminated`: how the episode
    has ended, in Scenic's words: "scenarioComplete: reason", "terminatedByMonitor: reason", "terminatedByBehavior:
    reason" or "simulationTerminationCondition: reason". `rejected`: which requirement is violated.
    """

    reward: float
    terminated: str | None = None
    rejected: str | None = None
