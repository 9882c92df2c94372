"""A scenario at one place of the program that runs it: its registers, its labels, and what it watches while it runs.

The program's own scenario is the part that has no parent. Every `do` of a compose block makes a part for each
scenario that it names, as a `do` of a behavior makes rows of its own. Read next: `dynamics.compiler.scenarios`, which
writes the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from scenic_lite.core.state import Watched
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.machine import opcodes as op


@dataclass(eq=False)
class WatchedItem:
    """A statement of a setup that watches the scenario; `flag`: the register that says whether it was come to."""

    watched: Watched
    flag: int | None = None


@dataclass(eq=False)
class Temporal:
    """A temporal requirement: the frame that its names have, its automaton, and the register of its state."""

    watched: Watched
    scope: Any  # CompiledScope; None: that of the statement
    automaton: Any
    state: int


@dataclass(eq=False)
class Monitor:
    """A monitor of a scenario; its slot is 0 while it does not run."""

    call: BehaviorCall
    slot: int
    entry: Label
    flag: int | None = None


@dataclass(eq=False)
class BehaviorOverride:
    """A behavior that an `override` gives an object; `number` is what the object's register says while it has it."""

    agent: Instance
    call: BehaviorCall
    slot: int
    entry: Label
    number: int
    part: ScenarioInstance | None  # None: the behavior that the object begins with


@dataclass(eq=False)
class Overridden:
    """A property in a scenario that overrides it: `flag` says whether it has; what writes the rows of the rest."""

    flag: int
    save: Callable[[], object]
    restore: Callable[[], object]


@dataclass(eq=False)
class ScenarioInstance:
    """One scenario where it is run. It runs while the register `running` is not 0.

    Labels: `stop`, a routine that returns to the register `back`; `over`, where its own step goes when it ends; `kill`,
    where a `terminate simulation` in it goes; `after`, where its compose block goes when it lets time pass.
    """

    name: str
    parent: ScenarioInstance | None
    call: BehaviorCall | None
    running: int
    back: int
    slot: int  # of the compose block
    ending: int  # asked for by a monitor of its own: the reason
    ego: Instance | None = None
    scope: Any = None  # the CompiledScope of its variables
    limit: tuple[int, int] | None = None  # registers: steps taken, steps allowed
    stop: Label = field(default_factory=Label)
    over: Label = field(default_factory=Label)
    kill: Label = field(default_factory=Label)
    after: Label = field(default_factory=Label)
    beginning: Label = field(default_factory=Label)  # of the compose block
    progress: Label = field(default_factory=Label)  # a routine: its temporal requirements see a step
    parts: list[ScenarioInstance] = field(default_factory=list)
    monitors: list[Monitor] = field(default_factory=list)
    terminations: list[WatchedItem] = field(default_factory=list)
    records: list[WatchedItem] = field(default_factory=list)
    temporal: list[Temporal] = field(default_factory=list)
    overridden: dict[tuple[str, str], Overridden] = field(default_factory=dict)
    resets: list[tuple[int, float]] = field(default_factory=list)  # what its registers are while it does not run

    def family(self) -> Iterator[ScenarioInstance]:
        """Yield this scenario and all inside it, outer ones first."""
        yield self
        for part in self.parts:
            yield from part.family()

    def lists(self) -> list[list]:
        """Return what grows while the part is written."""
        return [self.parts, self.monitors, self.terminations, self.records, self.temporal, self.resets]

    def call_routine(self, code: Assembler, routine: Label) -> None:
        """Write rows that run `stop` or `progress` and come back."""
        on = Label()
        code.row(op.SET_SLOT, self.back, c=on)
        code.row(op.JUMP, c=routine)
        code.put(on)

    def flagged(self, code: Assembler, at_rest: float = 0.0) -> int:
        """Return a register that has a value of its own again whenever the scenario has ended."""
        register = code.fixed.take()
        code.begin_with(register, at_rest)
        self.resets.append((register, at_rest))
        return register


def part_of(code: Assembler, name: str, parent: ScenarioInstance | None, call: BehaviorCall | None) -> ScenarioInstance:
    """Return a part with registers of its own, noted in its parent."""
    first = code.fixed.take(4)
    for i, word in enumerate(("running", "back", "compose", "ending")):
        code.notes[first + i] = f"{name}.{word}"
    part = ScenarioInstance(name, parent, call, first, first + 1, first + 2, first + 3)
    if parent is None:
        code.begin_with(part.running, 1)
    else:
        parent.parts.append(part)
    return part
