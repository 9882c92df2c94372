"""Where evaluation stands: the session (one load), and the frames (one module, function or class body each).

`Scope.value` and `Scope.run` dispatch on the type of a node through the tables of `expressions` and `statements`; every
error raised below passes through here and is given its place in the program. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenic_lite.core.budget import Budget, exceeded
from scenic_lite.core.checks import RuntimeChecks
from scenic_lite.core.domain import Domain
from scenic_lite.core.exceptions import from_python, named_fault
from scenic_lite.core.types import (
    Behavior,
    BehaviorCall,
    Instance,
    Namespace,
    RandomChoice,
    ScenicClass,
    Stream,
    describe_kind,
)
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax import nodes
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, columns_of
from scenic_lite.values.regions import Region

if TYPE_CHECKING:
    from scenic_lite.core.paths import Way

PYTHON_FAULTS = (ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError, MemoryError)
CONTAINERS = (list, tuple, set, dict, str, bytes, range)
LARGEST_NAMED = 100  # elements of a container
WORDS: dict[type, str] = {nodes.TryInterrupt: "interrupt when"}


@dataclass(frozen=True)
class Source:
    """One file of program text."""

    file: str
    lines: tuple[str, ...]
    folder: Path | None  # where modules named by the program are looked for
    library: bool  # of the domain, not of the user

    def line(self, number: int) -> str:
        return self.lines[number - 1] if 0 < number <= len(self.lines) else ""


@dataclass
class Requirement:
    """One `require`: its condition over the samples."""

    label: str
    place: SourceSpan
    condition: Value
    probability: float = 1.0


class DrawnPoint(NamedTuple):
    """A point drawn from one region, and the columns of θ that it was made of: how to go back is the region's.

    `whole` is the region that the program names, where only a part of it is drawn from.
    """

    region: Region
    columns: tuple[ThetaColumn, ...]
    point: Vector
    whole: Region | None = None


class Sight(NamedTuple):
    """What an object's specifier demands: that `viewer` sees it, or that it does not."""

    viewer: Instance
    wanted: bool


class Watched(NamedTuple):
    """A statement that is about the whole episode, with the names it sees: `terminate`, `record`, `require always`."""

    tree: Any  # nodes.TerminateWhen, TerminateAfter, Record or Require
    place: SourceSpan
    scope: Scope
    label: str = ""  # its name, or its text
    bindings: Any = None  # `Bindings` of a requirement, which means its names as they were


@dataclass(eq=False)
class InterpreterState:
    """Everything that loading one program has made so far."""

    domain: Domain | None
    dialect: int
    expressions: dict[type, Callable[[Scope, Any], Value]]
    statements: dict[type, Callable[[Scope, Any], Value]]
    builtins: dict[str, Value]
    call: Callable[[Scope, Value, list, dict[str, Value], ast.AST], Value]
    unpack: Callable[[Scope, ast.expr, Value], None]
    budget: Budget = field(default_factory=Budget)
    objects: list[Instance] = field(default_factory=list)
    params: dict[str, Value] = field(default_factory=dict)
    requirements: list[Requirement] = field(default_factory=list)
    sights: list[tuple[Instance, Sight]] = field(default_factory=list)
    conditions: list[Callable[[], None]] = field(default_factory=list)  # evaluate the requirements again
    columns: list[ThetaColumn] = field(default_factory=list)
    points: list[DrawnPoint] = field(default_factory=list)
    behaviors: dict[str, Behavior] = field(default_factory=dict)
    monitors: list[BehaviorCall] = field(default_factory=list)
    terminations: list[Watched] = field(default_factory=list)
    records: list[Watched] = field(default_factory=list)
    temporal: list[Watched] = field(default_factory=list)
    scenarios: list[Behavior] = field(default_factory=list)
    main: BehaviorCall | None = None  # the modular scenario that the program is
    main_frame: Scope | None = None
    library_params: set[str] = field(default_factory=set)
    param_places: dict[str, SourceSpan] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    modules: dict[str, Namespace] = field(default_factory=dict)
    importing: list[str] = field(default_factory=list)
    root: Path | None = None  # the program's folder
    model: str | None = None  # the world model that the caller wants instead of the program's
    modelling: int = 0  # `model` statements that are being executed
    fixed_params: frozenset[str] = frozenset()  # set by the caller, whatever the program says
    handled: list[ScenicError] = field(default_factory=list)  # by the `except` blocks that run now
    warnings: list[ScenicError] = field(default_factory=list)
    doubts: list[ScenicError] = field(default_factory=list)  # warnings of those who do not know the classes
    declared: set[SourceSpan] = field(default_factory=set)  # `with` specifiers of properties that the class declares
    watching: RuntimeChecks = field(default_factory=RuntimeChecks)
    ego: Instance | None = None
    workspace: Value = None
    owner: tuple[Instance, str] | None = None  # whose specifier is being evaluated
    in_requirement: int = 0
    path: Way | None = None  # the way that is taken where a function branches on random values
    row: dict[RandomExpr, Value] | None = None  # of one sample: the value of each random node
    drawn: Callable[[ThetaColumn], ThetaColumn] | None = (
        None  # while an episode runs: gives each new draw its value at once
    )

    def column(self, kind: str, place: SourceSpan, offset: float = 0.0, span: float = 1.0) -> ThetaColumn:
        """Draw a new random value. Raises ScenicError inside a requirement, where nothing can be drawn."""
        if self.in_requirement:
            raise ScenicError(
                "type",
                "a requirement cannot draw a random value",
                hint="draw it before the requirement and give it a name",
            )
        if len(self.columns) >= self.budget.limits.draws:
            raise exceeded(f"more than {self.budget.limits.draws:,} random values are drawn")
        column = ThetaColumn(kind, place, offset, span)
        if self.drawn is not None:
            return self.drawn(column)
        column.owner = self.owner
        self.columns.append(column)
        return column

    @contextmanager
    def owned(self, instance: Instance, name: str):
        """Random values drawn inside belong to `instance.name`."""
        before, self.owner = self.owner, (instance, name)
        try:
            yield
        finally:
            self.owner = before

    @contextmanager
    def own_ego(self):
        """Inside, a module has no ego yet; the one that it sets is the program's where that has none (dialect 3)."""
        before, self.ego = self.ego, None
        try:
            yield
        finally:
            self.ego = before if before is not None or self.dialect == 2 else self.ego

    @contextmanager
    def requiring(self):
        """Inside, comparisons and `and`, `or`, `not` of random values are allowed, draws are not."""
        self.in_requirement += 1
        try:
            yield
        finally:
            self.in_requirement -= 1


class Scope:
    """The names visible at one point of the program, and the way to evaluate nodes there."""

    __slots__ = (
        "assigned",
        "globals",
        "locals",
        "method",
        "module_names",
        "nonlocals",
        "outer",
        "session",
        "source",
        "transparent",
        "yields",
    )

    def __init__(
        self, session: InterpreterState, source: Source, names: dict[str, Value], outer: Scope | None = None
    ) -> None:
        self.session = session
        self.source = source
        self.locals = names
        self.outer = outer
        self.globals: set[str] = set()  # declared `global` here
        self.nonlocals: set[str] = set()
        self.assigned: frozenset[str] = frozenset()  # the names of a function that it has before they have a value
        self.transparent = False  # of a comprehension, whose `:=` binds outside
        self.method: tuple[ScenicClass, Value] | None = None  # of a method: its class and its first argument
        self.yields: list[Value] | None = None  # of a generator: what it has given so far
        self.module_names: dict[str, Value] = outer.module_names if outer else names

    def inner(self, names: dict[str, Value]) -> Scope:
        """A frame for a function, comprehension or class body inside this one."""
        return Scope(self.session, self.source, names, self)

    # ------------------------------------------------------------ evaluation

    def value(self, node: ast.expr) -> Value:
        """Evaluate an expression; every error leaves with a place."""
        self.session.budget.step()
        handler = self.session.expressions.get(type(node))
        if handler is None:
            raise self.error("unsupported", f"{type(node).__name__} expressions are not supported", node)
        try:
            value = handler(self, node)
            if self.session.watching.unplaced:
                self.note_places(node)
            return value if self.session.row is None else in_row(value, self.session.row)
        except ScenicError as error:
            raise self.placed(error, node) from None
        except PYTHON_FAULTS as fault:
            raise self.placed(from_python(fault), node) from None

    def run(self, statements: Iterable[ast.stmt]) -> None:
        """Execute statements in order."""
        for node in statements:
            self.session.budget.step()
            handler = self.session.statements.get(type(node))
            if handler is None:
                word = WORDS.get(type(node), type(node).__name__.lower())
                raise self.error("unsupported", f"`{word}` is not supported outside behaviors", node)
            try:
                handler(self, node)
                if self.session.watching.unplaced:
                    self.note_places(node)
            except ScenicError as error:
                raise self.placed(error, node) from None
            except PYTHON_FAULTS as fault:
                raise self.placed(from_python(fault), node) from None

    def truth(self, node: ast.expr) -> bool:
        """The truth of a condition that decides what is evaluated next; it must not be random."""
        return self.certain_truth(self.value(node), node)

    def certain_truth(self, value: Value, node: ast.AST) -> bool:
        if self.session.path is not None and isinstance(value, RandomExpr):
            return self.session.path.turn(value)
        self.refuse_random(value, node, "control flow cannot depend on a random value")
        return bool(value)

    def refuse_random(self, value: Value, node: ast.AST, message: str) -> None:
        """Raise the error for control flow on a random value, naming the branch and the draw."""
        if isinstance(value, RandomChoice):
            value = value.index
        if not isinstance(value, RandomExpr):
            return
        hint = "write it in `require`, or decide in a behavior"
        raise self.error("random-control-flow", message, node, hint, self.drawn_notes(value))

    def drawn_notes(self, value: RandomExpr) -> list[str]:
        first = next(columns_of(value), None)
        if first is None or first.place.file not in self.session.sources:
            return []
        line = self.session.sources[first.place.file].line(first.place.line)
        return [str(ScenicError("value", "the random value is drawn here", first.place, source_line=line))]

    def call(self, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
        """Call a function of the program or of the language."""
        return self.session.call(self, function, arguments, keywords, node)

    def elements(self, value: Value, node: ast.AST) -> list:
        """The elements of a container that is not random."""
        self.refuse_random(value, node, "cannot iterate through a random value")
        if isinstance(value, Vector):
            return [value.x, value.y]
        if isinstance(value, Stream):
            value = value.rest()
        if isinstance(value, Region) and (points := value.vertices()) is not None:
            value = [Vector(x, y) for x, y in points]
        if not isinstance(value, CONTAINERS):
            raise self.error("type", f"{describe_kind(value)} has no elements", node)
        self.session.budget.container(len(value))
        row = self.session.row
        return list(value) if row is None else [in_row(each, row) for each in value]

    def bindings(self, generators: list[ast.comprehension]) -> Iterator[Scope]:
        """A frame for each round of a comprehension."""
        first, *rest = generators
        for element in self.elements(self.value(first.iter), first.iter):
            inner = self.inner({})
            inner.transparent = True
            self.session.unpack(inner, first.target, element)
            self.session.budget.step()
            if all(inner.truth(test) for test in first.ifs):
                if rest:
                    yield from inner.bindings(rest)
                else:
                    yield inner

    # ------------------------------------------------------------ places and errors

    def place(self, node: ast.AST) -> SourceSpan:
        if not isinstance(node, ast.expr | ast.stmt):
            return SourceSpan(self.source.file, 1, 0, 1, 1)
        end_line, end_column = node.end_lineno or node.lineno, node.end_col_offset or node.col_offset + 1
        return SourceSpan(self.source.file, node.lineno, node.col_offset, end_line, end_column)

    def watch(self, result: Value) -> None:
        """Note a result that some scenes may be unable to compute."""
        session = self.session
        if session.row is None and session.drawn is None:
            path = session.path
            ways = () if path is None else zip(path.conditions, path.decisions, strict=False)
            session.watching.note(result, ways)

    def note_places(self, node: ast.AST) -> None:
        if "lineno" in vars(node):
            place = self.place(node)
            self.session.watching.place(place, self.source.line(place.line))

    def error(self, kind: str, message: str, node: ast.AST, hint: str = "", notes: Iterable[str] = ()) -> ScenicError:
        """An error at `node`."""
        return self.placed(ScenicError(kind, message, hint=hint, notes=notes), node)

    def placed(self, error: ScenicError, node: ast.AST) -> ScenicError:
        """Give an error its place, unless it has one. A node that no text made leaves that to whoever is above."""
        if error.place is None and "lineno" in vars(node):
            error.place = self.place(node)
            error.source_line = self.source.line(error.place.line)
        return error

    def warn(self, message: str, node: ast.AST, hint: str = "") -> None:
        if not self.source.library:
            self.session.warnings.append(self.error("warning", message, node, hint))

    # ------------------------------------------------------------ names

    def lookup(self, name: str) -> Value:
        """The value of a name. Raises ScenicError of kind `name` with the nearest spelling."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.globals:
                break
            if name in scope.locals:
                return scope.locals[name]
            if name in scope.assigned:
                error = ScenicError("name", f"'{name}' has no value yet in this function")
                raise named_fault("UnboundLocalError", error)
            scope = scope.outer
        if name in self.module_names:
            return self.module_names[name]
        if name in self.session.builtins:
            return self.session.builtins[name]
        raise ScenicError("name", f"name '{name}' is not defined", hint=near(name, self.visible_names()))

    def visible_names(self) -> list[str]:
        names = [*self.session.builtins, "ego", "workspace"]
        scope: Scope | None = self
        while scope is not None:
            names += scope.locals
            scope = scope.outer
        return names

    def assign(self, name: str, value: Value) -> None:
        self.names_of(name)[name] = value
        name_draws(name, value)

    def names_of(self, name: str) -> dict[str, Value]:
        """Where an assignment to the name goes."""
        if name in self.globals:
            return self.module_names
        scope: Scope | None = self.outer if name in self.nonlocals else None
        while scope is not None:
            if name in scope.locals:
                return scope.names_of(name)
            scope = scope.outer
        return self.locals


def in_row(value: Value, row: dict[RandomExpr, Value]) -> Value:
    """What a value is in one sample."""
    if isinstance(value, Vector) and not value.fixed:
        return Vector(in_row(value.x, row), in_row(value.y, row))
    if isinstance(value, RandomChoice):
        return in_row(value.options[in_row(value.index, row)], row)
    if not isinstance(value, RandomExpr):
        return value
    if value not in row:
        assert value.operation is not None, "a draw that the condition was not known to depend on"
        inputs = [in_row(each, row) for each in value.inputs]
        result = value.operation(*(one_row(each) for each in inputs))
        row[value] = tuple(part[0] for part in result) if isinstance(result, tuple) else result[0]
    found = row[value]
    return found.item() if isinstance(found, np.generic) else found


def one_row(value: Value) -> Any:
    """A value of one sample as an operation wants it: an array of one, or several where it has parts."""
    if isinstance(value, tuple):
        return tuple(np.array([part]) for part in value)
    return np.array([value], dtype=object if isinstance(value, str) else None)


def name_draws(name: str, value: Value, inside: bool = False) -> None:
    """The first variable that holds a draw or an object names it; `inside` a container only draws that no one owns."""
    if isinstance(value, RandomChoice):
        value = value.index
    if isinstance(value, RandomExpr):
        for column in [each for each in (value, *near_inputs(value)) if isinstance(each, ThetaColumn)]:
            if column.shown is value and not (inside and column.owner):  # of `Range(0, 1)`, `Uniform(1, 2)` ...
                column.name = column.name or name
    elif isinstance(value, Instance):
        value.name = value.name or ("" if inside else name)
    elif not inside or isinstance(value, Vector):  # a container may hold itself
        for part, each in parts_by_name(name, value):
            name_draws(part, each, inside=True)


def parts_by_name(name: str, value: Value) -> list[tuple[str, Value]]:
    """The parts of a vector or container, named as a program would; not all of a large one."""
    if isinstance(value, Vector):
        return [(f"{name}.x", value.x), (f"{name}.y", value.y)]
    if isinstance(value, dict):
        return [(f"{name}[{key!r}]", value[key]) for key in list(value)[:LARGEST_NAMED] if isinstance(key, str | int)]
    return [(f"{name}[{i}]", each) for i, each in enumerate(value[:LARGEST_NAMED])] if is_sequence(value) else []


def is_sequence(value: Value) -> bool:
    return isinstance(value, list | tuple)


def near_inputs(value: RandomExpr) -> list[RandomExpr]:
    """The inputs of a value, theirs and so on: a draw is never far from the value that it shows."""
    found: list[RandomExpr] = []
    level = [value]
    for _ in range(4):
        level = [each for node in level for each in node.inputs if isinstance(each, RandomExpr)][:16]
        found += level
    return found


def near(name: str, names: Iterable[str]) -> str:
    """A hint with the nearest spelling, or nothing."""
    public = [each for each in names if not each.startswith("_")]
    same = [each for each in public if sorted(each.lower()) == sorted(name.lower())]  # or two letters swapped
    close = same or difflib.get_close_matches(name, public, 1, 0.7)
    return f"did you mean '{close[0]}'?" if close else ""
