"""The state of the compiler during one pass over a program: the compilation, and frames of inlined bodies.

Name lookup works as in the evaluator; the values of names are fixed or in registers. Read next:
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

Key = tuple[str, str, str]  # key of an attribute: "object", the object's label, the attribute's name
DEEPEST = 40  # maximum nesting of behaviors and functions
OWN = "behavior or function"
SHARED = "what several share is an attribute of an object: ego.count = 0"


@dataclass(eq=False)
class Loop:
    """The targets of `break` and `continue` in one loop."""

    exit: Label
    again: Label
    parts: int = 0  # number of scenarios that the compose block has started before the loop


@dataclass(eq=False)
class InlinedBody:
    """One inlined behavior or function, without its names."""

    path: tuple  # the calls and iterations that lead to the body; it identifies the body in all passes
    end: Label
    behavior: Behavior | None = None
    result: Variable | None = None  # the result of a function with several returns
    loops: list[Loop] = field(default_factory=list)
    aborts: list[Label] = field(default_factory=list)
    live: int = 0  # number of enclosing constructs whose execution depends on the match


class CompiledScope(Scope):
    """A scope whose variables may be in registers."""

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
        self.unset: set[str] = set()  # variables that have no value at this point in some matches

    def run(self, statements: Iterable[ast.stmt]) -> None:
        """Compile statements up to the last reachable statement."""
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
        """Write a row that stops a match in which a variable has no value yet. Raises ScenicError if it cannot."""
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
        """Put these variables into registers from this point on, since their assignments depend on the match."""
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
        """Mark statements inside the context as reached in some matches only."""
        self.inlined.live += 1
        before = set(self.unset)
        try:
            yield
        finally:
            self.inlined.live -= 1
            self.unset |= before


@dataclass(eq=False)
class Thread:
    """A part of the program that resumes at the row in its slot, a register; the slot is 0 while it does not run.

    `number`: the index of the thread within its scenario, or the value that selects this behavior in its agent's
    register.
    """

    title: str
    slot: int
    call: BehaviorCall | None = None
    agent: Instance | None = None
    number: int = 0
    entry: Label = field(default_factory=Label)


class WatchedItem(NamedTuple):
    """A statement that monitors a scenario while it runs.

    For a requirement, `register` holds the state of its automaton. `scope` is the frame of its names; None means the
    scope of the statement.
    """

    watched: EpisodeStatement
    register: int | None = None
    automaton: Any = None
    scope: CompiledScope | None = None


class ScenarioInstance:
    """A scenario at one place of the program that runs it; the program itself has no parent.

    The scenario runs while the register `running` is not 0. Labels: `stop` is a routine that returns to the row in the
    register `back`. The step jumps to `over` at the end of the scenario, and to `kill` at its `terminate simulation`.
    The compose block jumps to `after` when time passes. `progress` is the step of the temporal requirements. The
    register `halted` records that one of the scenario's monitors has ended the simulation; this takes precedence over
    a monitor that ends the scenario.
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
        self.overridden: dict[Key, tuple[int, Variable]] = {}  # key -> (register: is overridden, previous value)
        self.resets: list[tuple[int, float]] = []  # (register, value while the scenario does not run)

    def family(self) -> Iterator[ScenarioInstance]:
        """Yield this scenario and all inner scenarios, outer scenarios first."""
        yield self
        for part in self.parts:
            yield from part.family()

    def call_stop(self, code: Assembler) -> None:
        """Write rows that call the scenario's `stop` routine."""
        on = Label()
        code.row(op.SET_SLOT, self.back, c=on)
        code.row(op.JUMP, c=self.stop)
        code.put(on)

    def register(self, code: Assembler, at_rest: float = 0.0) -> int:
        """Return a register that is reset to this value at each end of the scenario."""
        register = code.fixed.take()
        code.begin_with(register, at_rest)
        self.resets.append((register, at_rest))
        return register


@dataclass(frozen=True)
class Site:
    """The present place of a pass in the program."""

    path: tuple = ()  # the calls and iterations that lead to the place
    calls: tuple[tuple[Behavior | Function, SourceSpan], ...] = ()  # the callees with the places of the calls
    inside: tuple = ()  # bodies of the behaviors and functions that are being inlined
    agent: Instance | None = None  # the value of `self`
    slot: int = 0  # register with the row at which the innermost block resumes
    repeating: int = 0  # number of enclosing constructs that may repeat it
    part: ScenarioInstance | None = None  # the enclosing scenario
    composing: bool = False  # in the compose block of `part`
    setting_up: bool = False  # in the setup of `part`, which runs during the match


@dataclass(eq=False)
class Output:
    """The results of a pass, besides rows."""

    diagnostics: list[ScenicError] = field(default_factory=list)  # statements that would stop a match, and warnings
    commands: list[tuple[Value, ...]] = field(default_factory=list)
    end_reasons: list[str] = field(default_factory=list)  # reasons for the end of the match
    rejections: list[str] = field(default_factory=list)  # the requirements that reject a match
    records: list[Record] = field(default_factory=list)
    overridden: list[tuple[int, int, bool]] = field(default_factory=list)  # see `Compiled`
    sets_reward: bool = False
    starting: dict[int, Label] = field(default_factory=dict)  # slot -> its initial row
    titles: dict[Label, str] = field(default_factory=dict)  # entry row -> title
    counts: tuple[int, int, int, int] = (0, 0, 0, 0)  # numbers of threads: scenario, behaviors, records, monitors


@dataclass(eq=False)
class WorldRegisters:
    """The location of the world in the registers of a match."""

    base: int = 0  # first register of the table [O, F]
    facts: int = 0
    clock: RegisterValue | None = None  # steps since the start of the match
    names: frozenset[str] = frozenset()  # names of the properties that the world provides


@dataclass(eq=False)
class Compilation:
    """One pass over a program's behaviors, monitors and conditions."""

    program: Program
    world: World
    code: Assembler
    types: TypeTable
    simulation: Namespace  # the value of `simulation()`; all passes share it, since variables hold it
    mode: Mode = field(init=False)  # the mode in which the compiler evaluates nodes
    site: Site = field(default_factory=Site)
    output: Output = field(default_factory=Output)
    shown: WorldRegisters = field(default_factory=WorldRegisters)
    overrides: dict[str, list[Thread]] = field(default_factory=dict)  # object label -> behaviors that scenarios assign
    shared: dict[tuple, Variable] = field(default_factory=dict)  # attributes that the program sets, by key
    remembering: bool = False  # whether the program reads `lastActions`

    @property
    def state(self) -> LoadState:
        """The state that the statements of this pass create, including `ego`."""
        return self.mode.state

    # ------------------------------------------------------------ the place of the pass

    @contextmanager
    def at(self, site: Site | None = None, **changes: Any) -> Iterator[None]:
        """Use another site inside the context, given as a whole or by its changes."""
        outside, self.site = self.site, replace(site or self.site, **changes)
        try:
            yield
        finally:
            self.site = outside

    @contextmanager
    def entered(self, thing: Behavior | Function, node: ast.AST, place: SourceSpan) -> Iterator[None]:
        """Inline a behavior or function inside the context; `place` is its call. Raises ScenicError for recursion."""
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
        """Add notes about the callers to an error of the present statement."""
        for thing, place in reversed(self.site.calls):
            error = seen_from(self.state, thing, place, error)
        return error

    def round(self, node: ast.AST, *number: int | str | None) -> AbstractContextManager[None]:
        """Compile one iteration of an unrolled loop, or one of several uses of a node, inside the context."""
        return self.at(path=(*self.site.path, id(node), *number))

    def repeated(self) -> AbstractContextManager[None]:
        """Mark statements inside the context as possibly repeated."""
        return self.at(repeating=self.site.repeating + 1)

    @contextmanager
    def within(self, part: ScenarioInstance, **changes: Any) -> Iterator[None]:
        """Compile statements inside the context as part of a scenario, with its own `ego`."""
        ego, self.state.ego = self.state.ego, part.ego
        with self.at(part.site, **changes):
            try:
                yield
            except ScenicError as error:
                raise self.seen_from_calls(error) from None
            finally:
                part.ego, self.state.ego = self.state.ego, ego

    # ------------------------------------------------------------ state shared by all behaviors of a match

    def keep(self, key: Key, value: Value) -> None:
        """Assign an attribute for the rest of the match."""
        variable = self.shared_variable(key)
        variable.store(value)
        self.table_of(key)[key[2]] = variable.load()

    def table_of(self, key: Key) -> dict[str, Value]:
        """Return the dictionary in which an attribute is looked up."""
        owner = next(instance for instance in self.program.instances if instance.label == key[1])
        return owner.properties if key[2] in owner.properties else owner.attributes

    def shared_variable(self, key: Key) -> Variable:
        """Return the variable of an attribute; a match starts with the value that the program has loaded."""
        if key in self.shared:
            return self.shared[key]
        table, name = self.table_of(key), key[2]
        if key not in self.types.types:  # earlier reads treated the attribute as fixed
            self.types.changed_types.add(key)
        variable = self.shared[key] = Variable(self.code, self.types, key, shared=True)
        if name in table:
            place = variable.declare(table[name])
            for register, first in moves_to(place.type, iter(place.registers), table[name]):
                self.code.begin_with(register, first)
        return variable

    def refuse_live(self, owner: Instance, name: str) -> None:
        """Raise ScenicError if the world controls an attribute."""
        if name in ("x", "y") or name in self.shown.names:
            hint = "players move by what they do: take an action"
            raise ScenicError("type", f"the {name} of {owner.title()} belongs to the world", hint=hint)

    def scenarios_begun(self) -> int:
        """Return the number of scenarios that the present compose block runs in the text so far."""
        return len(self.site.part.parts) if self.site.part is not None and self.site.composing else 0

    def stop_scenarios(self, since: int) -> None:
        """Write rows that end the scenarios which a statement of the compose block has begun and left."""
        if self.site.part is not None and self.site.composing:
            for part in self.site.part.parts[since:]:
                part.call_stop(self.code)

    def forget_scenarios(self, since: int) -> None:
        """Remove the scenarios of a statement whose rows are deleted."""
        if self.site.part is not None and self.site.composing:
            del self.site.part.parts[since:]

    def time(self) -> Any:
        """Return the number of steps since the start. Raises ScenicError if the world does not provide the time."""
        if self.shown.clock is None:
            raise ScenicError("unsupported", f"the world {self.world.name} does not tell the time")
        return self.shown.clock

    def stop_with(self, error: ScenicError) -> None:
        """Write a row that stops every match that reaches it; an error of kind `rejection` rejects the match."""
        if error.kind == "rejection":
            return self.reject(error.message)
        message = f"{error.message} ({error.hint})" if error.hint else error.message
        self.code.row(op.FAULT, note=message, place=error.place)

    def reject(self, message: str) -> None:
        self.output.rejections.append(message)
        self.code.row(op.REJECT, c=len(self.output.rejections))

    def reason(self, message: str) -> int:
        """Return the register with the number of an end reason."""
        if message not in self.output.end_reasons:
            self.output.end_reasons.append(message)
        return self.code.constant(1 + self.output.end_reasons.index(message))
