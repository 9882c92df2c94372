"""What a simulator shows of itself to behaviors and monitors, and what it takes from them.

A step of the world is seen as two tables of numbers: one row per object of the program, and a row of facts about the
match as a whole. What a program reads (`ball.position`, `simulation()`) is made from these by functions that never look
at a number, so that the same functions serve numbers and the compiler's registers. Read next: `toy`, the smallest
world; `reference`, which runs programs in one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from scenic_lite.graph import Value
from scenic_lite.values import Instance, Namespace


@dataclass(frozen=True)
class World:
    """A kind of simulator, as programs see it.

    Attributes:
        name: of the simulator, for messages.
        fields: the F columns of the world table [O, F] (float64), one row per object in the order of the scene.
        facts: the G numbers of the match as a whole, table [G] (float64), such as "time": steps since the start.
        timestep: seconds per step.
        properties: the live properties of an object from its fields, by name: {"position": Vector(...), ...}. The
            values of the fields may be numbers or registers of the compiler: they may be computed with, not looked at.
        simulation: what `simulation()` gives, from the objects in the order of the scene and the facts by name. A
            program may set its attribute `scenic_reward`: the reward of this step, 0 unless set in it.
        command: checks one action of a `take` by an object, and gives it the form that the simulator wants. Raises
            ScenicError for what is no action of this world, or none of this object.
        several: whether an object can do several things at once, of any kind. If not, its action is a number, and of a
            `take` of several the first counts.
    """

    name: str
    fields: tuple[str, ...]
    facts: tuple[str, ...]
    timestep: float
    properties: Callable[[Instance, dict[str, Value]], dict[str, Value]]
    simulation: Callable[[list[Instance], dict[str, Value]], Namespace]
    command: Callable[[Value, Instance], Value]
    several: bool = False


class Commands(NamedTuple):
    """What the behaviors of one step want.

    `actions`: a tuple of actions for each object, in the order of the scene; () for one that waits, whose behavior has
    ended, or that has none. `agents`: the objects that have a behavior. `terminated`: how the episode has ended, if it
    has (see `Verdict`); nobody acts then. `rejected`: which requirement is broken, if one is.
    """

    actions: tuple[tuple[Value, ...], ...]
    agents: tuple[int, ...]
    terminated: str | None = None
    rejected: str | None = None


class Verdict(NamedTuple):
    """What monitors and conditions say of one step.

    `reward`: what the program has set `simulation().scenic_reward` to since the last verdict, or 0. `terminated`: how
    the episode has ended, in Scenic's words: "scenarioComplete: reason", "terminatedByMonitor: reason",
    "terminatedByBehavior: reason" or "simulationTerminationCondition: reason". `rejected`: which requirement is broken.
    """

    reward: float
    terminated: str | None = None
    rejected: str | None = None
