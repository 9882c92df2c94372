"""The interface between a simulator and the behaviors and monitors of programs.

A step of the world consists of two tables of numbers: one row per object of the program, and a row of facts about the
match. Functions compute the values that a program reads (`ball.position`, `simulation()`) from these tables. These
functions never branch on a number, so they also work on the compiler's registers. Read next:
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
    """The interface of a simulator to programs.

    Attributes:
        name: the name of the simulator in messages.
        fields: the F columns of the world table [O, F] (float64), one row per object in the order of the scene.
        facts: the G numbers of the match as a whole, table [G] (float64), such as "time": steps since the start.
        timestep: seconds per step.
        properties: computes the live properties of an object from its fields, by name: {"position": Vector(...), ...}.
            Field values may be registers of the compiler: arithmetic works on them, branching on them does not.
        simulation: computes the value of `simulation()` from the objects in the order of the scene and the facts by
            name. A program may set its attribute `scenic_reward`, the reward of this step (default 0).
        command: checks one action of a `take` by an object, and converts it to the simulator's format. Raises
            ScenicError for an action that does not exist or is not available to this object.
        actions: the number of actions if actions are integers from 0; action 0 must have no effect.
            `packed` then combines an object's actions in a step into one number. None: actions are values of any kind.
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
        """Return the error message for a number that is not an action."""
        assert self.actions is not None
        return f"there is no action {number}; actions are 0 to {self.actions - 1}"


@dataclass(frozen=True)
class Domain:
    """The domain of a program.

    `library` maps each dotted module name, including aliases, to its `.scenic` file. A program file without a `model`
    line and without imports from the library imports `default_model`. `params` are the program parameters that the
    world uses; similar names cause a warning. `world` is the interface of the simulator to behaviors; None if the
    domain has none.
    """

    name: str
    library: Mapping[str, Path] = field(default_factory=dict)
    default_model: str | None = None
    params: frozenset[str] = frozenset()
    world: World | None = None

    def home_of(self, name: str) -> str | None:
        """Return the library module that defines a name, or None."""
        word = re.compile(rf"^((behavior|monitor|scenario|class|def) +{re.escape(name)}\b|{re.escape(name)} *=)", re.M)
        homes = (module for module, path in self.library.items() if word.search(path.read_text(encoding="utf-8")))
        return next(homes, None)


MOST_AT_ONCE = 8  # maximum number of actions of one `take`, if actions are integers


def packed(actions: Sequence[Value], base: int) -> Value:
    """Return the actions of one `take` as one number in the given base, with the first action as the highest digit."""
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
    behavior has ended, or that has no behavior. `agents`: the objects with a behavior. `terminated`: the reason for the
    end of the episode, if it has ended (see `Verdict`); objects then do not act. `rejected`: the violated requirement,
    if any.
    """

    actions: tuple[tuple[Value, ...], ...]
    agents: tuple[int, ...]
    terminated: str | None = None
    rejected: str | None = None


class Verdict(NamedTuple):
    """The results of monitors and conditions in one step.

    `reward`: the value of `simulation().scenic_reward` set since the last verdict, or 0. `terminated`: the reason for
    the end, in Scenic's words: "scenarioComplete: reason", "terminatedByMonitor: reason", "terminatedByBehavior:
    reason" or "simulationTerminationCondition: reason". `rejected`: the violated requirement.
    """

    reward: float
    terminated: str | None = None
    rejected: str | None = None
