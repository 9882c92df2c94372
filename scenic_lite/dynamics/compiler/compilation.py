"""What the compiler knows while it walks a program: the frames of inlined behaviors and functions, and one compilation.

Names are looked up as everywhere; their values are fixed, or made of registers. Read next:
`dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from scenic_lite.core.checks import PYTHON_FAULTS, from_python
from scenic_lite.core.environment import Environment, Source
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import Behavior, Function, Instance, Namespace
from scenic_lite.core.world import World
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.parts import BehaviorOverride, ScenarioInstance
from scenic_lite.dynamics.compiler.registers import TypeTable, Variable, moves_to, store_in_register
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.compiled import Record
from scenic_lite.errors import ScenicError
from scenic_lite.scene.program import Program
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value

# "object" and its label, "simulation" and "", "global" and its module's number; then the attribute or variable
Key = tuple[str, str | int, str]
DEEPEST = 40  # behaviors and functions inside each other


@dataclass(eq=False)
class Loop:
    """Where `break` and `continue` lead; `leave` stores what the loop's target is when it is left."""

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
    level: int = 0  # intermediate results in use when a function gives its value back
    live: int = 0  # constructs around the present statement that are decided during a match


class CompiledScope(Scope):
    """A frame whose variables may stand in registers."""

    __slots__ = ("compilation", "flags", "inlined", "undecided", "variables")

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
        self.flags: dict[str, int] = {}  # registers that say whether variables have a value yet
        self.undecided: set[str] = set()  # targets of loops that a `break` may have left with any element

    def inner(self, names: dict[str, Value]) -> Scope:
        return Scope(self.mode, self.source, names, self)

    def run(self, statements: Iterable[ast.stmt]) -> None:
        """Compile statements as far as they can be reached."""
        for node in statements:
            if not self.compilation.code.reachable:
                return
            super().run((node,))

    def assign(self, name: str, value: Value) -> None:
        if name in self.globals:
            self.compilation.keep_global(self, name, value)
            return
        if name in self.nonlocals:
            owner = self.owner_of(name)
            owner.assign(name, value)
            return
        self.undecided.discard(name)
        variable, code = self.variables.get(name), self.compilation.code
        if variable is None:
            self.locals[name] = store_in_register(code, value)
            return
        variable.store(value)
        self.locals[name] = variable.load()
        if name in self.flags:
            code.row(op.COPY, self.flags[name], code.constant(1))

    def lookup(self, name: str) -> Value:
        if name in self.undecided:
            message = f"what '{name}' is after a loop with `break` the match decides"
            raise ScenicError("unsupported", message, hint="assign it to a variable of its own before the break")
        return super().lookup(name)

    def owner_of(self, name: str) -> CompiledScope:
        """The frame around this one whose variable it is."""
        scope = self.outer
        while scope is not None and name not in scope.locals:
            scope = scope.outer
        if not isinstance(scope, CompiledScope):
            message = f"'{name}' belongs to a function that is over, and cannot be assigned in a match"
            raise ScenicError("unsupported", message)
        return scope

    def assign_where_it_is(self, name: str, value: Value) -> None:
        """Change what a name stands for, whoever it belongs to."""
        scope: Environment | None = self
        while scope is not None and name not in scope.locals and scope.locals is not scope.module_names:
            scope = scope.outer
        if isinstance(scope, CompiledScope):
            scope.assign(name, value)
        elif name in self.module_names:
            self.compilation.keep_global(self, name, value)
        else:
            message = f"'{name}' belongs to a function that is over, and cannot be changed in a match"
            raise ScenicError("unsupported", message, hint="copy it first: items = list(items)")

    def pin(self, names: Iterable[str]) -> None:
        """From here on these variables stand in registers: what assigns them is decided during a match."""
        for name in sorted(names):
            others = name in self.globals or name in self.nonlocals or name not in self.assigned | self.locals.keys()
            if others or name in self.variables:
                continue
            c = self.compilation
            variable = Variable(c.code, c.types, (*self.inlined.path, name), fluid=True)
            self.variables[name] = variable
            if name in self.locals:
                variable.store(self.locals[name])
            if variable.place is not None:
                self.locals[name] = variable.load()

    @contextmanager
    def in_dynamic_branch(self) -> Iterator[None]:
        """Inside, whether a statement is reached is decided during a match."""
        self.inlined.live += 1
        try:
            yield
        finally:
            self.inlined.live -= 1


@dataclass(eq=False)
class Compilation:
    """One walk over a program's behaviors, monitors and conditions."""

    program: Program
    world: World
    code: Assembler
    types: TypeTable
    simulation: Namespace  # what `simulation()` gives: one for all walks, since variables hold it
    modules: dict[int, dict[str, Value]]  # variables of modules that the program assigns in a match, by the id
    mode: Mode = field(init=False)  # how nodes are evaluated for the compiler
    shared: dict[tuple, Variable] = field(default_factory=dict)  # attributes that the program sets, by owner and name
    path: tuple = ()
    slot: int = 0  # register of the innermost block: where it goes on
    agent: Instance | None = None
    before: dict[int, dict[str, Value]] = field(default_factory=dict)  # what `modules` held before this walk
    inside: list[Any] = field(default_factory=list)  # behaviors and functions that are being inlined
    doubts: list[ScenicError] = field(default_factory=list)  # what would stop a match, and warnings
    commands: list[tuple[Value, ...]] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)  # for the end of a match
    broken: list[str] = field(default_factory=list)  # requirements that reject a match
    remembering: bool = False  # the program reads `lastActions`
    guarding: int = 0  # statements with a scan around the present one: their variables all last
    clock: Any = None  # steps since the start
    counts: tuple[int, int, int, int] = (0, 0, 0, 0)  # threads of the scenario, of behaviors, of records, of monitors
    part: ScenarioInstance | None = None  # the scenario to which the present statements belong
    composing: bool = False  # they are those of its compose block
    setting_up: bool = False  # they are those of its setup, which runs during the match
    repeating: int = 0  # constructs around them that may run them several times
    flags: dict[int, tuple[Any, int]] = field(default_factory=dict)  # by id: what may not be come to, its register
    drivers: dict[str, list[BehaviorOverride]] = field(
        default_factory=dict
    )  # overriding behaviors, by the object's label
    driving: dict[str, int] = field(default_factory=dict)  # register of the driver's number, by label
    starting: dict[int, Label] = field(default_factory=dict)  # slots that begin at a row
    titles: dict[Label, str] = field(default_factory=dict)  # of rows that begin something
    records: list[Record] = field(default_factory=list)
    world_base: int = 0
    fact_base: int = 0
    live_names: frozenset[str] = frozenset()  # properties that the world shows

    @property
    def state(self) -> LoadState:
        """What the statements of the walk make, `ego` among it."""
        return self.mode.state

    @contextmanager
    def entered(self, thing: Behavior | Function, node: ast.AST) -> Iterator[None]:
        """Inside, a behavior or function is inlined. Raises ScenicError for recursion."""
        body = thing.node if isinstance(thing, Behavior) else thing.body
        if any(each is body for each in self.inside) or len(self.inside) >= DEEPEST:
            hint = "write a loop"
            raise ScenicError("unsupported", f"{thing.name} calls itself, which no match can do", hint=hint)
        self.inside.append(body)
        path, self.path = self.path, (*self.path, id(node))
        try:
            yield
        finally:
            self.inside.pop()
            self.path = path

    @contextmanager
    def round(self, node: ast.AST, number: int) -> Iterator[None]:
        """Inside is one round of a loop that is unrolled."""
        path, self.path = self.path, (*self.path, id(node), number)
        try:
            yield
        finally:
            self.path = path

    @contextmanager
    def rounds(self, number: int) -> Iterator[None]:
        """Inside is what belongs to the scenario with this number."""
        path, self.path = self.path, (*self.path, number)
        try:
            yield
        finally:
            self.path = path

    @contextmanager
    def block(self, slot: int) -> Iterator[None]:
        """Inside, time passes in the block with this slot."""
        outer, self.slot = self.slot, slot
        try:
            yield
        finally:
            self.slot = outer

    @contextmanager
    def suspends_others(self) -> Iterator[None]:
        """Inside, blocks are suspended while others run: none of their variables may share a register."""
        self.guarding += 1
        try:
            yield
        finally:
            self.guarding -= 1

    # ------------------------------------------------------------ what all behaviors of a match see

    def keep_global(self, scope: Scope, name: str, value: Value) -> None:
        """Assign a variable of a module."""
        number = id(scope.module_names)
        self.modules[number] = scope.module_names
        self.keep(("global", number, name), value)

    def keep(self, key: Key, value: Value) -> None:
        """Assign an attribute or variable that lasts as long as the match."""
        variable = self.shared_variable(key)
        variable.store(value)
        self.table_of(key)[key[2]] = variable.load()

    def table_of(self, key: Key) -> dict[str, Value]:
        """Return where an attribute is looked up."""
        kind, label, name = key
        if kind == "global":
            assert isinstance(label, int)
            return self.modules[label]
        if kind == "simulation":
            return self.simulation.names
        owner = next(each for each in self.program.instances if each.label == label)
        return owner.properties if name in owner.properties else owner.attributes

    def shared_variable(self, key: Key) -> Variable:
        """Return the variable of an attribute; at the start of a match it holds what the program gave it."""
        if key in self.shared:
            return self.shared[key]
        table, name = self.table_of(key), key[2]
        if key[0] == "global" and name in table:
            assert isinstance(key[1], int)
            self.before.setdefault(key[1], {})[name] = table[name]
        if key not in self.types.types:  # what was read of it before was taken for fixed
            self.types.outdated.add(key)
        variable = self.shared[key] = Variable(self.code, self.types, key, shared=True)
        if name in table:
            place = variable.declare(table[name])
            for register, first in moves_to(place.type, iter(place.registers), table[name]):
                self.code.begin_with(register, first)
        return variable

    def refuse_live(self, owner: Instance, name: str) -> None:
        """Raise the error for an attribute that is the world's."""
        if name in ("x", "y") or name in self.live_names:
            hint = "players move by what they do: take an action"
            raise ScenicError("type", f"the {name} of {owner.title()} belongs to the world", hint=hint)

    def show_shared(self) -> None:
        """Let the attributes that a program is known to set be read from their registers."""
        for key in [key for key in self.types.types if key[0] in ("object", "simulation", "global")]:
            self.table_of(key)[key[2]] = self.shared_variable(key).load()

    def flag_of(self, thing: Any) -> int | None:
        """The register that says whether the statement that made something was come to; None if that is certain."""
        found = self.flags.get(id(thing))
        return None if found is None else found[1]

    @property
    def part_behavior(self) -> Behavior | None:
        """The definition of the present scenario."""
        return None if self.part is None or self.part.call is None else self.part.call.behavior

    def scenarios_begun(self) -> int:
        """How many scenarios the present compose block has run in the text so far."""
        return len(self.part.parts) if self.part is not None and self.composing else 0

    def stop_scenarios(self, since: int) -> None:
        """End the scenarios that the compose block has begun in a statement and not come back to."""
        if self.part is not None and self.composing:
            for part in self.part.parts[since:]:
                part.call_routine(self.code, part.stop)

    @contextmanager
    def within(self, part: ScenarioInstance, composing: bool = False, setting_up: bool = False) -> Iterator[None]:
        """Inside, statements belong to a scenario, and `ego` is its own."""
        outside = self.part, self.composing, self.setting_up, self.repeating, self.state.ego
        self.part, self.composing, self.setting_up, self.repeating = part, composing, setting_up, 0
        self.state.ego = part.ego
        try:
            yield
        finally:
            part.ego = self.state.ego
            self.part, self.composing, self.setting_up, self.repeating, self.state.ego = outside

    @contextmanager
    def repeated(self) -> Iterator[None]:
        """Inside, statements may be executed several times."""
        self.repeating += 1
        try:
            yield
        finally:
            self.repeating -= 1

    def time(self) -> Any:
        """Steps since the start. Raises ScenicError if the world does not tell."""
        if self.clock is None:
            raise ScenicError("unsupported", f"the world {self.world.name} does not tell the time")
        return self.clock

    def reject(self, message: str) -> None:
        self.broken.append(message)
        self.code.row(op.REJECT, c=len(self.broken))

    def reason(self, message: str) -> int:
        """The register of the number of a reason to end."""
        if message not in self.reasons:
            self.reasons.append(message)
        return self.code.constant(1 + self.reasons.index(message))


def with_location(
    compilation: Compilation, handler: Callable[[Compilation, CompiledScope, Any], None]
) -> Callable[[CompiledScope, Any], None]:
    """A handler of statements that notes the place of the rows it writes.

    A statement that cannot be executed as it is found to be (a name that is not there, a region that moves) stops a
    match that comes to it, as in the reference; what cannot be compiled refuses the program.
    """

    def handle(scope: CompiledScope, node: ast.stmt) -> None:
        code = compilation.code
        before, code.place = code.place, scope.place(node)
        start, known = len(code.rows), len(compilation.doubts)
        try:
            with code.statement():
                handler(compilation, scope, node)
        except (ScenicError, *PYTHON_FAULTS) as fault:
            error = scope.placed(fault if isinstance(fault, ScenicError) else from_python(fault), node)
            if error.kind in REFUSALS:
                raise
            inner = [each for each in compilation.doubts[known:] if each.kind != "warning"]
            if inner and not code.reachable:  # a function has failed before, and so this is not come to
                error = inner[0]
            else:
                compilation.doubts.append(error)
            del code.rows[start:]
            code.reachable = True
            code.row(op.FAULT, note=said(error), place=error.place)
        finally:
            code.place = before

    return handle


REFUSALS = frozenset({"unsupported", "budget", "syntax", "import"})


def said(error: ScenicError) -> str:
    return f"{error.message} ({error.hint})" if error.hint else error.message


@lru_cache(maxsize=4096)
def assigned_names(*trees: ast.AST) -> frozenset[str]:
    """The variables that some statements change, loop targets aside: a loop looks after its own."""
    found: set[str] = set()
    for each in nodes.walk_own(*trees):
        if isinstance(each, ast.Assign):
            targets: list[ast.expr] = each.targets
        elif isinstance(each, ast.AugAssign | ast.AnnAssign | ast.NamedExpr):
            targets = [each.target]
        elif isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and each.func.attr == "append":
            targets = [each.func.value]
        else:
            continue
        for target in targets:
            found |= {part.id for part in base_names(target)}
    return frozenset(found)


def base_names(target: ast.expr) -> Iterator[ast.Name]:
    """The variables that assigning to a target changes."""
    if isinstance(target, ast.Name):
        yield target
    elif isinstance(target, ast.Tuple | ast.List):
        for each in target.elts:
            yield from base_names(each)
    elif isinstance(target, ast.Starred | ast.Subscript):
        yield from base_names(target.value)


def suspends(trees: Iterable[ast.AST]) -> bool:
    """Whether time may pass in some statements."""
    kinds = (nodes.Take, nodes.Wait, nodes.Do, nodes.Terminate)
    return any(isinstance(each, kinds) for each in nodes.walk_own(*trees))
