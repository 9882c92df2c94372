"""Names combined with a mode of evaluation: a Scope computes every value of a program.

`Scope.value` and `Scope.run` dispatch on the type of a node through the tables of the mode's handlers. Every error
passes through this module, which adds its place in the program. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from scenic_lite.core.checks import FAULTS, as_error
from scenic_lite.core.state import LOAD, BranchPath, Mode
from scenic_lite.core.types import BehaviorCall, Environment, Instance, RandomChoice, Source, describe_kind, near
from scenic_lite.errors import ScenicError, SourceSpan, UnsetVariable
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, columns_of
from scenic_lite.values.regions import Region

CONTAINERS = (list, tuple, dict, str, range)
LARGEST_NAMED = 100  # maximum number of named elements of a container


class Scope(Environment):
    """An environment with a mode; it evaluates nodes at one point of the program."""

    __slots__ = ("handlers", "mode", "state")

    def __init__(self, mode: Mode, source: Source, names: dict[str, Value], outer: Environment | None = None) -> None:
        super().__init__(source, names, outer)
        self.mode, self.state, self.handlers = mode, mode.state, mode.handlers

    def inner(self, names: dict[str, Value]) -> Scope:
        """Return a scope for a comprehension or class body inside this scope."""
        return Scope(self.mode, self.source, names, self)

    @staticmethod
    def inside(mode: Mode, around: Environment, names: dict[str, Value]) -> Scope:
        """Return a scope for the body of a definition in the environment `around`."""
        return Scope(mode, around.source, names, around)

    @staticmethod
    def at(mode: Mode, environment: Environment) -> Scope:
        """Return the same names in another mode."""
        scope = Scope(mode, environment.source, environment.locals, environment.outer)
        scope.assigned = environment.assigned
        return scope

    def requiring(self) -> Scope:
        """Return the same names in the mode of a requirement."""
        return self if self.mode.symbolic else Scope.at(self.mode.requiring(), self)

    def along(self, path: BranchPath) -> Scope:
        """Return the same names in a mode whose branches on random values follow a path."""
        return Scope.at(replace(self.mode.requiring(), path=path), self)

    def owning(self, instance: Instance, name: str) -> Scope:
        """Return the same names in a mode whose draws belong to `instance.name`."""
        return Scope.at(self.mode.with_owner(instance, name), self) if self.mode.phase == LOAD else self

    def draw(self, kind: str, place: SourceSpan, offset: float = 0.0, span: float = 1.0) -> ThetaColumn:
        """Draw a new random value. Raises ScenicError inside a requirement, which must not draw."""
        column = self.mode.draw(kind, place, offset, span)
        if self.mode.owner is not None:
            column.owner = self.mode.owner
        return column

    # ------------------------------------------------------------ evaluation

    def value(self, node: ast.expr) -> Value:
        """Evaluate an expression; every error gets a place."""
        self.mode.budget.step()
        handler = self.handlers.expressions.get(type(node))
        if handler is None:
            raise self.error("unsupported", f"{type(node).__name__} expressions are not supported", node)
        try:
            value = handler(self, node)
            if self.state.watching.unplaced:
                self.note_places(node)
            return value if self.mode.row is None else in_row(value, self.mode.row)
        except FAULTS as fault:
            raise self.placed(as_error(fault), node) from None

    def operands(self, nodes: Iterable[ast.expr | None]) -> list[Value]:
        """Return the operand values of a word operator; None for an omitted operand."""
        return [None if node is None else self.value(node) for node in nodes]

    @staticmethod
    def refuse_none(nodes: Iterable[ast.expr | None], values: Iterable[Value]) -> None:
        """Raise ScenicError if a written operand is None, since None denotes an omitted operand."""
        if any(value is None and node is not None for node, value in zip(nodes, values, strict=True)):
            raise ScenicError("type", "None is not an object, a number or a vector")

    def run(self, statements: Iterable[ast.stmt]) -> None:
        """Execute statements in order."""
        for node in statements:
            self.mode.budget.step()
            handler = self.handlers.statements.get(type(node))
            if handler is None:
                word = type(node).__name__.lower()
                raise self.error("unsupported", f"`{word}` is not supported outside behaviors", node)
            try:
                handler(self, node)
                if self.state.watching.unplaced:
                    self.note_places(node)
            except FAULTS as fault:
                raise self.placed(as_error(fault), node) from None

    def truth(self, node: ast.expr) -> bool:
        """Return the truth of a control-flow condition, which must not be random."""
        return self.certain_truth(self.value(node), node)

    def certain_truth(self, value: Value, node: ast.AST) -> bool:
        if self.mode.path is not None and isinstance(value, RandomExpr):
            return self.mode.path.branch(value)
        self.refuse_random(value, node, "control flow cannot depend on a random value")
        if isinstance(value, BehaviorCall):
            raise no_condition(self, node)
        return bool(value)

    def refuse_random(self, value: Value, node: ast.AST, message: str) -> None:
        """Raise ScenicError if the value is random, with a note on each draw; control flow must not depend on it."""
        value = value.index if isinstance(value, RandomChoice) else value
        if isinstance(value, RandomExpr):
            hint = "write it in `require`, or decide in a behavior"
            raise self.error("random-control-flow", message, node, hint, self.drawn_notes(value))

    def refuse_random_in(self, values: Iterable[Value], node: ast.AST, message: str) -> None:
        for value in values:
            self.refuse_random(value, node, message)

    def refuse_comparison(self, node: ast.AST, *values: Value) -> None:
        """Raise ScenicError for a comparison of random values outside a requirement."""
        if not self.mode.symbolic:
            self.refuse_random_in(values, node, "random values cannot be compared here")

    def drawn_notes(self, value: RandomExpr) -> list[str]:
        first = next(columns_of(value), None)
        if first is None or first.place.file not in self.state.sources:
            return []
        line = self.state.sources[first.place.file].line(first.place.line)
        return [str(ScenicError("value", "the random value is drawn here", first.place, source_line=line))]

    def call(self, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
        """Call a function of the program or of the language."""
        return self.handlers.call(self, function, arguments, keywords, node)

    def elements(self, value: Value, node: ast.AST) -> list:
        """Return the elements of a container, which must not be random."""
        self.refuse_random(value, node, "cannot iterate through a random value")
        if isinstance(value, Vector):
            return [value.x, value.y]
        if isinstance(value, Region) and (points := value.vertices()) is not None:
            value = [Vector(x, y) for x, y in points]
        if not isinstance(value, CONTAINERS):
            raise self.error("type", f"{describe_kind(value)} has no elements", node)
        self.mode.budget.container(len(value))
        row = self.mode.row
        return list(value) if row is None else [in_row(element, row) for element in value]

    def bindings(self, generators: list[ast.comprehension]) -> Iterator[Scope]:
        """Yield a scope for each iteration of a comprehension."""
        first, *rest = generators
        for element in self.elements(self.value(first.iter), first.iter):
            inner = self.inner({})
            self.handlers.unpack(inner, first.target, element)
            self.mode.budget.step()
            if all(inner.truth(test) for test in first.ifs):
                if rest:
                    yield from inner.bindings(rest)
                else:
                    yield inner

    # ------------------------------------------------------------ places and errors

    def watch(self, result: Value) -> None:
        """Register a check of a result that may fail in some scenes."""
        if self.mode.row is None:
            path = self.mode.path
            self.state.watching.note(result, () if path is None else zip(path.conditions, path.decisions, strict=False))

    def note_places(self, node: ast.AST) -> None:
        if "lineno" in vars(node):
            place = self.place(node)
            self.state.watching.place(place, self.source.line(place.line))

    def warn(self, message: str, node: ast.AST, hint: str = "") -> None:
        if not self.source.library:
            self.state.warnings.append(self.error("warning", message, node, hint))

    # ------------------------------------------------------------ names

    def lookup(self, name: str) -> Value:
        """Return the value of a name. Raises ScenicError of kind `name`, with the nearest spelling as a hint."""
        for at in self.outwards():
            if name in at.locals:
                return at.locals[name]
            if name in at.assigned:
                raise UnsetVariable("name", f"'{name}' has no value yet in this function")
        if name in self.module_names:
            return self.module_names[name]
        if name in self.handlers.builtins:
            return self.handlers.builtins[name]
        domain = self.state.domain
        home = domain.home_of(name) if domain is not None else None
        hint = f"it lives in {home}: from {home} import {name}" if home else self._where(name)
        raise ScenicError("name", f"name '{name}' is not defined", hint=hint)

    def _where(self, name: str) -> str:
        """Return a hint for an undefined name: its owner, or the nearest spelling."""
        if name in ("wait", "terminate", "abort"):
            return f"write `{name}` without brackets"
        owner = next((scenario for scenario in self.state.scenarios if name in scenario.assigned), None)
        if owner is None:
            return near(name, self.visible_names())
        own = f"it belongs to the scenario {owner.name}: "
        if self.state.main is not None and owner is self.state.main.behavior:
            return f"{own}give it to what needs it as an argument, or set it before all scenarios"
        return f"{own}keep that, part = {owner.name}(), and read part.{name} after do part"

    def visible_names(self) -> list[str]:
        return [*self.handlers.builtins, "ego", "workspace", *(name for at in self.outwards() for name in at.locals)]

    def assign(self, name: str, value: Value) -> None:
        self.locals[name] = value
        name_draws(name, value)


def in_row(value: Value, row: dict[RandomExpr, Value]) -> Value:
    """Return the value that a random value has in one sample."""
    if isinstance(value, Vector) and not value.fixed:
        return Vector(in_row(value.x, row), in_row(value.y, row))
    if isinstance(value, RandomChoice):
        return in_row(value.options[in_row(value.index, row)], row)
    if not isinstance(value, RandomExpr):
        return value
    if value not in row:
        assert value.operation is not None, "a draw that the condition was not known to depend on"
        inputs = [in_row(operand, row) for operand in value.inputs]
        result = value.operation(*(one_row(operand) for operand in inputs))
        row[value] = tuple(part[0] for part in result) if isinstance(result, tuple) else result[0]
    result = row[value]
    return result.item() if isinstance(result, np.generic) else result


def one_row(value: Value) -> Any:
    """Return a value of one sample as an operation's argument: an array of one element, or one array per part."""
    if isinstance(value, tuple):
        return tuple(np.array([part]) for part in value)
    return np.array([value], dtype=object if isinstance(value, str) else None)


def name_draws(name: str, value: Value, inside: bool = False) -> None:
    """Name a draw or object after its first variable; `inside` a container, name only draws without an owner."""
    if isinstance(value, RandomChoice):
        value = value.index
    elif isinstance(value, Vector) and isinstance(value.x, RandomExpr) and is_choice(value.x.inputs[:1]):
        value = value.x.inputs[0]  # the index of `Uniform(1 @ 2, 3 @ 4)`
    if isinstance(value, RandomExpr):
        column = value.drawn  # the column of `Range(0, 1)`, `Uniform(1, 2)` ...
        if column is not None and column.shown is value and not (inside and column.owner):
            column.name = column.name or name
    elif isinstance(value, Instance):
        value.name = value.name or ("" if inside else name)
    elif not inside or isinstance(value, Vector):  # a container may contain itself
        for part, element in parts_by_name(name, value):
            name_draws(part, element, inside=True)


def is_choice(inputs: tuple) -> bool:
    """Return whether the first input of a coordinate is the index of a random choice among vectors."""
    column = inputs[0].drawn if inputs and isinstance(inputs[0], RandomExpr) else None
    return column is not None and bool(column.options)


def parts_by_name(name: str, value: Value) -> list[tuple[str, Value]]:
    """Return the parts of a vector or container with their names in a program; only the first of a large container."""
    if isinstance(value, Vector):
        return [(f"{name}.x", value.x), (f"{name}.y", value.y)]
    if isinstance(value, dict):
        return [(f"{name}[{key!r}]", value[key]) for key in list(value)[:LARGEST_NAMED] if isinstance(key, str | int)]
    return (
        [(f"{name}[{i}]", element) for i, element in enumerate(value[:LARGEST_NAMED])]
        if isinstance(value, list | tuple)
        else []
    )


def no_condition(scope: Scope, node: ast.AST) -> ScenicError:
    """Return the error for a behavior call in a condition."""
    return scope.error("type", "a behavior cannot be called in a condition", node)
