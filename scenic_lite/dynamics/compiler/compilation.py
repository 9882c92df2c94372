"""What the compiler knows while it walks a program: the frames of inlined behaviors and functions, and one compilation.

Names are looked up as everywhere; their values are fixed, or made of registers. Read next:
`dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EpisodeStatement, LoadState, Mode
from scenic_lite.core.types import Behavior, BehaviorCall, Environment, Function, Instance, Namespace, Source
from scenic_lite.core.world import World
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.registers import TypeTable, Variable, moves_to, store_in_register
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.compiled import Record
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.calls import seen_from
from scenic_lite.scene.program import Program
from scenic_lite.values.graph import Value

Key = tuple[str, str, str]  # of an attribute: "object", its label, the name
DEEPEST = 40  # behaviors and functions inside each other
OWN = "behavior or function"
SHARED = "what several share is an attribute of an object: ego.count = 0"


@dataclass(eq=False)
class Loop:
    """Where `break` and `continue` lead."""

    exit: Label
    again: Label
    parts: int = 0  # scenarios in the compose block that are written before it


@dataclass(eq=False)
class InlinedBody:
    """One inlined behavior or function, besides its names."""

    path: tuple  # of calls and rounds that lead here: what it is known by from one walk to the next
    end: Label
    behavior: Behavior | None = None
    result: Variable | None = None  # of a function that returns from several places
    loops: list[Loop] = field(default_factory=list)
    aborts: list[Label] = field(default_factory=list)
    live: int = 0  # constructs around the present statement that are decided during a match


class CompiledScope(Scope):
    """A frame whose variables may stand in registers."""

    __slots__ = ("compilation", "inlined", "unset", "variables")

    def __init__(
        self,
        compilation: Compilation,
        source: Source,
        names: dict[str, Value],
        outer: Environment,
        inlined: InlinedBody,
    ) -> None:
        super().__init__(compilation.mode, source, names, outer)
        self.compilation, self.inlined = compilation, inlined
        self.variables: dict[str, Variable] = {}
        self.unset: set[str] = set()  # variables of which the match decides whether they have a value where the walk is

    def run(self, statements: Iterable[ast.stmt]) -> None:
        """Compile statements as far as they can be reached."""
        for node in statements:
            if not self.compilation.code.reachable:
                return
            super().run((node,))

    def assign(self, name: str, value: Value) -> None:
        """Assign a variable of the behavior or function."""
        self.unset.discard(name)
        variable = self.variables.get(name)
        if variable is None:
            self.locals[name] = store_in_register(self.compilation.code, value)
        else:
            variable.store(value)
            self.locals[name] = variable.load()

    def check_set(self, name: str) -> None:
        """Write the row that stops a match in which a variable has no value yet. Raises ScenicError if none can."""
        c, variable = self.compilation, self.variables.get(name)
        if variable is None or c.site.composing or (variable.mark is not None and variable.place is None):
            message = f"the match decides whether '{name}' has a value here"
            raise ScenicError("unsupported", message, hint=f"give it one before: {name} = None")
        if variable.mark is None:
            c.types.marked.add(variable.key)
            c.types.changed_types.add(variable.key)
        else:
            c.code.fault_unless(variable.mark, f"'{name}' has no value yet in this function")

    def pin(self, names: Iterable[str]) -> None:
        """Put these variables into registers from here on: what assigns them is decided during a match."""
        for name in sorted(names):
            if name in self.variables or name not in self.assigned | self.locals.keys():
                continue
            c = self.compilation
            variable = Variable(c.code, c.types, (*self.inlined.path, name))
            self.variables[name] = variable
            if name in self.locals:
                variable.store(self.locals[name])
            else:
                self.unset.add(name)
                if variable.mark is not None:
                    c.code.row(op.COPY, variable.mark, c.code.constant(0))
            if variable.place is not None:
                self.locals[name] = variable.load()

    @contextmanager
    def in_dynamic_branch(self) -> Iterator[None]:
        """Treat statements inside as ones of which a match decides whether they are reached."""
        self.inlined.live += 1
        before = set(self.unset)
        try:
            yield
        finally:
            self.inlined.live -= 1
            self.unset |= before


@dataclass(eq=False)
class Thread:
    """A part of the program that goes on where its slot says, a register that holds a row; 0 while it does not run.

    `number`: its place among those of its scenario, or what its agent has while it has this behavior.
    """

    title: str
    slot: int
    call: BehaviorCall | None = None
    agent: Instance | None = None
    number: int = 0
    entry: Label = field(default_factory=Label)


class WatchedItem(NamedTuple):
    """A statement that watches a scenario while it runs.

    Of a requirement: `register`, the state of its automaton; `scope`: the frame of its names, None if that is the
    statement's.
    """

    watched: EpisodeStatement
    register: int | None = None
    automaton: Any = None
    scope: CompiledScope | None = None


class ScenarioInstance:
    """A scenario at one place of the program that runs it; the program itself is the one that has no parent.

    It runs while the register `running` is not 0. Labels: `stop`, a routine that returns to the register `back`;
    `over`, where its own step goes when it ends; `kill`, where a `terminate simulation` in it goes; `after`, where its
    compose block goes when it lets time pass; `progress`, where its temporal requirements see a step. `halted`: a
    monitor of its own has ended the simulation, which counts more than one that ends the scenario.
    """

    def __init__(self, code: Assembler, parent: ScenarioInstance | None, call: BehaviorCall | None) -> None:
        self.parent, self.call = parent, call
        self.name = "scenario" if call is None else call.behavior.name
        first = code.fixed.take(4)
        self.running, self.back, self.slot, self.halted = range(first, first + 4)
        for i, word in enumerate(("running", "back", "compose", "halted")):
            code.register_names[first + i] = f"{self.name}.{word}"
        self.stop, self.over, self.kill, self.after, self.beginning, self.progress = (Label() for _ in range(6))
        self.site = Site(part=self)
        self.ego: Instance | None = None
        self.scope: Any = None  # the CompiledScope of its variables
        self.limit: tuple[int, int] | None = None  # registers: steps taken, steps allowed
        self.parts: list[ScenarioInstance] = []
        self.monitors: list[Thread] = []
        self.terminations: list[WatchedItem] = []
        self.records: list[WatchedItem] = []
        self.temporal: list[WatchedItem] = []
        self.overridden: dict[Key, tuple[int, Variable]] = {}  # whether it has, and what was before
        self.resets: list[tuple[int, float]] = []  # what its registers are while it does not run

    def family(self) -> Iterator[ScenarioInstance]:
        """Yield this scenario and all inside it, outer ones first."""
        yield self
        for part in self.parts:
            yield from part.family()

    def call_stop(self, code: Assembler) -> None:
        """Write rows that end the scenario and come back."""
        on = Label()
        code.row(op.SET_SLOT, self.back, c=on)
        code.row(op.JUMP, c=self.stop)
        code.put(on)

    def register(self, code: Assembler, at_rest: float = 0.0) -> int:
        """Return a register that has this value again whenever the scenario has ended."""
        register = code.fixed.take()
        code.begin_with(register, at_rest)
        self.resets.append((register, at_rest))
        return register


@dataclass(frozen=True)
class Site:
    """Where in the program a walk is."""

    path: tuple = ()  # of calls and rounds that lead here
    calls: tuple[tuple[Behavior | Function, SourceSpan], ...] = ()  # the same: what is called, and where
    inside: tuple = ()  # bodies of the behaviors and functions that are being inlined
    agent: Instance | None = None  # which `self` is
    slot: int = 0  # register of the innermost block: where it goes on when time has passed
    repeating: int = 0  # constructs around it that may execute it several times
    part: ScenarioInstance | None = None  # the scenario to which it belongs
    composing: bool = False  # to its compose block
    setting_up: bool = False  # to its setup, which runs during the match


@dataclass(eq=False)
class Output:
    """What a walk gives besides rows."""

    diagnostics: list[ScenicError] = field(default_factory=list)  # what would stop a match, and warnings
    commands: list[tuple[Value, ...]] = field(default_factory=list)
    end_reasons: list[str] = field(default_factory=list)  # for the end of a match
    rejections: list[str] = field(default_factory=list)  # requirements that reject a match
    records: list[Record] = field(default_factory=list)
    overridden: list[tuple[int, int, bool]] = field(default_factory=list)  # as in `Compiled`
    sets_reward: bool = False
    starting: dict[int, Label] = field(default_factory=dict)  # slots that begin at a row
    titles: dict[Label, str] = field(default_factory=dict)  # of rows that begin something
    counts: tuple[int, int, int, int] = (0, 0, 0, 0)  # threads of the scenario, of behaviors, of records, of monitors


@dataclass(eq=False)
class WorldRegisters:
    """Where a match shows the world."""

    base: int = 0  # of the table [O, F]
    facts: int = 0
    clock: RegisterValue | None = None  # steps since the start
    names: frozenset[str] = frozenset()  # properties that the world shows


@dataclass(eq=False)
class Compilation:
    """One walk over a program's behaviors, monitors and conditions."""

    program: Program
    world: World
    code: Assembler
    types: TypeTable
    simulation: Namespace  # what `simulation()` gives: one for all walks, since variables hold it
    mode: Mode = field(init=False)  # how nodes are evaluated for the compiler
    site: Site = field(default_factory=Site)
    output: Output = field(default_factory=Output)
    shown: WorldRegisters = field(default_factory=WorldRegisters)
    overrides: dict[str, list[Thread]] = field(default_factory=dict)  # behaviors that scenarios give objects, by label
    shared: dict[tuple, Variable] = field(default_factory=dict)  # attributes that the program sets, by owner and name
    remembering: bool = False  # the program reads `lastActions`

    @property
    def state(self) -> LoadState:
        """What the statements of the walk make, `ego` among it."""
        return self.mode.state

    # ------------------------------------------------------------ where the walk is

    @contextmanager
    def at(self, site: Site | None = None, **changes: Any) -> Iterator[None]:
        """Walk inside at another site, or at this one but for some of it."""
        outside, self.site = self.site, replace(site or self.site, **changes)
        try:
            yield
        finally:
            self.site = outside

    @contextmanager
    def entered(self, thing: Behavior | Function, node: ast.AST, place: SourceSpan) -> Iterator[None]:
        """Inline a behavior or function inside, which is called at a place. Raises ScenicError for recursion."""
        body = thing.node if isinstance(thing, Behavior) else thing.body
        site = self.site
        if any(outer is body for outer in site.inside) or len(site.inside) >= DEEPEST:
            message = f"{thing.name} calls itself, which no match can do"
            raise ScenicError("unsupported", message, hint="write a loop")
        sources, called = self.state.sources, self.code.called
        if thing.scope.source.library and not sources[place.file].library:
            self.code.called = place
        with self.at(path=(*site.path, id(node)), inside=(*site.inside, body), calls=(*site.calls, (thing, place))):
            try:
                yield
            except ScenicError as error:
                raise seen_from(self.state, thing, place, error) from None
            finally:
                self.code.called = called

    def seen_from_calls(self, error: ScenicError) -> ScenicError:
        """Return an error of the present statement as those see it who have called what it stands in."""
        for thing, place in reversed(self.site.calls):
            error = seen_from(self.state, thing, place, error)
        return error

    def round(self, node: ast.AST, *number: int | str | None) -> AbstractContextManager[None]:
        """Walk inside one round of a loop that is unrolled, or one of several uses of a node."""
        return self.at(path=(*self.site.path, id(node), *number))

    def repeated(self) -> AbstractContextManager[None]:
        """Treat statements inside as ones that may be executed several times."""
        return self.at(repeating=self.site.repeating + 1)

    @contextmanager
    def within(self, part: ScenarioInstance, **changes: Any) -> Iterator[None]:
        """Let statements inside belong to a scenario, and `ego` be its own."""
        ego, self.state.ego = self.state.ego, part.ego
        with self.at(part.site, **changes):
            try:
                yield
            except ScenicError as error:
                raise self.seen_from_calls(error) from None
            finally:
                part.ego, self.state.ego = self.state.ego, ego

    # ------------------------------------------------------------ what all behaviors of a match see

    def keep(self, key: Key, value: Value) -> None:
        """Assign an attribute: it lasts as long as the match."""
        variable = self.shared_variable(key)
        variable.store(value)
        self.table_of(key)[key[2]] = variable.load()

    def table_of(self, key: Key) -> dict[str, Value]:
        """Return where an attribute is looked up."""
        owner = next(instance for instance in self.program.instances if instance.label == key[1])
        return owner.properties if key[2] in owner.properties else owner.attributes

    def shared_variable(self, key: Key) -> Variable:
        """Return the variable of an attribute; at the start of a match it holds what the program gave it."""
        if key in self.shared:
            return self.shared[key]
        table, name = self.table_of(key), key[2]
        if key not in self.types.types:  # what was read of it before was taken for fixed
            self.types.changed_types.add(key)
        variable = self.shared[key] = Variable(self.code, self.types, key, shared=True)
        if name in table:
            place = variable.declare(table[name])
            for register, first in moves_to(place.type, iter(place.registers), table[name]):
                self.code.begin_with(register, first)
        return variable

    def refuse_live(self, owner: Instance, name: str) -> None:
        """Raise the error for an attribute that is the world's."""
        if name in ("x", "y") or name in self.shown.names:
            hint = "players move by what they do: take an action"
            raise ScenicError("type", f"the {name} of {owner.title()} belongs to the world", hint=hint)

    def scenarios_begun(self) -> int:
        """Return how many scenarios the present compose block has run in the text so far."""
        return len(self.site.part.parts) if self.site.part is not None and self.site.composing else 0

    def stop_scenarios(self, since: int) -> None:
        """End the scenarios that the compose block has begun in a statement and not come back to."""
        if self.site.part is not None and self.site.composing:
            for part in self.site.part.parts[since:]:
                part.call_stop(self.code)

    def forget_scenarios(self, since: int) -> None:
        """Let those never have been that a statement has begun whose rows are deleted."""
        if self.site.part is not None and self.site.composing:
            del self.site.part.parts[since:]

    def time(self) -> Any:
        """Return steps since the start. Raises ScenicError if the world does not tell."""
        if self.shown.clock is None:
            raise ScenicError("unsupported", f"the world {self.world.name} does not tell the time")
        return self.shown.clock

    def stop_with(self, error: ScenicError) -> None:
        """Write a row that stops a match which comes to it, or rejects it if it has nothing to draw from."""
        if error.kind == "rejection":
            return self.reject(error.message)
        message = f"{error.message} ({error.hint})" if error.hint else error.message
        self.code.row(op.FAULT, note=message, place=error.place)

    def reject(self, message: str) -> None:
        self.output.rejections.append(message)
        self.code.row(op.REJECT, c=len(self.output.rejections))

    def reason(self, message: str) -> int:
        """Return the register of the number of a reason to end."""
        if message not in self.output.end_reasons:
            self.output.end_reasons.append(message)
        return self.code.constant(1 + self.output.end_reasons.index(message))
