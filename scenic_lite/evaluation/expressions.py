"""Evaluate expressions: what each node of the tree means for numbers, containers and random values alike.

Read next: `evaluation.calls`, functions and instances; `evaluation.comparisons`; `evaluation.statements`.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from scenic_lite.core.checks import FallibleOperation, from_python
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import (
    Builtin,
    Function,
    LazyValue,
    Namespace,
    RandomChoice,
    broadcasts_over_choices,
    choose,
    describe_kind,
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.comparisons import comparison
from scenic_lite.evaluation.strings import concatenate, text_of
from scenic_lite.language.regions import item_of as element_of
from scenic_lite.language.scenic_operators import OPERATORS, ego_of
from scenic_lite.syntax import nodes
from scenic_lite.values.geometry import Vector, as_vector
from scenic_lite.values.graph import RandomExpr, Value, apply, is_number, kind_of
from scenic_lite.values.lines import PolylineRegion
from scenic_lite.values.operations import ADD, AND, MULTIPLY, NOT, OR, WHERE, Operation, real_power
from scenic_lite.values.regions import Region, VectorField

BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: real_power,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
SIGNS: dict[type, str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**",
    ast.LShift: "<<", ast.RShift: ">>", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^",
}  # fmt: skip
OPERANDS = (int, float, str, list, tuple, dict, Vector, RandomExpr, PolylineRegion)


def constant(scope: Scope, node: ast.Constant) -> Value:
    scope.mode.budget.keep(node.value)
    if isinstance(node.value, complex) or node.value is Ellipsis:
        raise ScenicError("unsupported", f"{type(node.value).__name__} constants are not supported")
    if isinstance(node.value, float) and math.isinf(node.value):
        raise ScenicError("value", "this number is too large", hint="write math.inf for what is endless")
    return node.value


def name_value(scope: Scope, node: ast.Name) -> Value:
    if node.id == "ego":
        return ego_of(scope)
    if node.id == "workspace" and scope.state.workspace is not None:
        return scope.state.workspace
    return scope.lookup(node.id)


def binary(scope: Scope, node: ast.BinOp) -> Value:
    left, right = scope.value(node.left), scope.value(node.right)
    return combine(scope, node.op, left, right)


@broadcasts_over_choices(2, 3)
def combine(scope: Scope, sign: ast.operator, left: Value, right: Value) -> Value:
    """Return the result of `left sign right`, within the budget."""
    if isinstance(sign, ast.MatMult):
        return at_sign(left, right)
    if isinstance(sign, ast.Mod) and kind_of(left) == "text":
        raise ScenicError("unsupported", "`%` does not format texts here", hint='write f"...{x}..."')
    check_size(scope, sign, left, right)
    for operand in (left, right):
        if not isinstance(operand, OPERANDS):
            pointed = as_vector(operand)
            if pointed is None or not isinstance(sign, ast.Add | ast.Sub | ast.Mult | ast.Div):
                raise mismatch(sign, left, right)
    left, right = as_operand(left), as_operand(right)
    try:
        result = BINARY[type(sign)](left, right)
    except TypeError:
        raise mismatch(sign, left, right) from None
    scope.mode.budget.keep(result)
    scope.watch(result)
    return result


def as_operand(value: Value) -> Value:
    """Objects stand for their positions in arithmetic."""
    return value if isinstance(value, OPERANDS) else as_vector(value)


def mismatch(sign: ast.operator, left: Value, right: Value) -> ScenicError:
    sides = f"{describe_kind(left)} and {describe_kind(right)}"
    hint = ""
    if isinstance(left, Vector) != isinstance(right, Vector):
        hint = "`@` binds as tightly as `*`: write (x + y) @ z"
    return ScenicError("type", f"`{SIGNS[type(sign)]}` of {sides}", hint=hint)


def at_sign(x: Value, y: Value) -> Value:
    """`x @ y`, a vector."""
    for part in (x, y):
        if not (is_number(part) or (isinstance(part, RandomExpr) and part.kind == "number")):
            hint = NUMBERS_FROM.get(type(part), "")
            raise ScenicError("type", f"`@` needs two numbers, not {describe_kind(part)}", hint=hint)
    return Vector(x, y)


NUMBERS_FROM: dict[type, str] = {
    range: "a random number is drawn by Range(low, high)",
    list: "Uniform(*values) draws one of them",
}


def check_size(scope: Scope, sign: ast.operator, left: Value, right: Value) -> None:
    """Refuse what would be huge before it is made."""
    budget = scope.mode.budget
    if isinstance(left, int) and isinstance(right, int):
        if isinstance(sign, ast.Pow) and right > 0:
            budget.integer(left.bit_length() * right)
        elif isinstance(sign, ast.LShift) and right > 0:
            budget.integer(left.bit_length() + right)
    elif isinstance(sign, ast.Mult):
        for sequence, count in ((left, right), (right, left)):
            if isinstance(sequence, str | list | tuple) and isinstance(count, int):
                budget.repeated(sequence, count)


def unary(scope: Scope, node: ast.UnaryOp) -> Value:
    value = scope.value(node.operand)
    if isinstance(node.op, ast.Not):
        return negation(scope, node, value)
    return apply_sign(node.op, value)


@broadcasts_over_choices(1)
def apply_sign(sign: ast.unaryop, value: Value) -> Value:
    if isinstance(sign, ast.Invert) and isinstance(value, int):
        return ~value
    if isinstance(sign, ast.Invert) or not isinstance(value, int | float | Vector | RandomExpr):
        raise ScenicError("type", f"{describe_kind(value)} has no sign")
    return -value if isinstance(sign, ast.USub) else +value


def negation(scope: Scope, node: ast.UnaryOp, value: Value) -> Value:
    if isinstance(value, RandomExpr) and scope.mode.symbolic:
        return apply(NOT, value, kind="truth")
    return not scope.certain_truth(value, node.operand)


def boolean(scope: Scope, node: ast.BoolOp) -> Value:
    """`and`, `or`: with Python's short circuit, except over random values inside requirements."""
    is_and = isinstance(node.op, ast.And)
    pending: Value = None
    value: Value = None
    for operand in node.values:
        with scope.state.watching.under(*(() if pending is None else ((pending, is_and),))):
            value = scope.value(operand)
        if isinstance(value, RandomExpr) and scope.mode.symbolic:
            pending = value if pending is None else apply(AND if is_and else OR, pending, value, kind="truth")
            value = pending
        elif scope.certain_truth(value, operand) != is_and:
            return value
        elif pending is not None:
            value = pending
    return value if pending is None else pending


def conditional(scope: Scope, node: ast.IfExp) -> Value:
    test = scope.value(node.test)
    if isinstance(test, RandomExpr) and scope.mode.symbolic:
        with scope.state.watching.under((test, True)):
            yes = scope.value(node.body)
        with scope.state.watching.under((test, False)):
            return either(test, yes, scope.value(node.orelse))
    return scope.value(node.body if scope.certain_truth(test, node.test) else node.orelse)


def either(test: RandomExpr, yes: Value, no: Value) -> Value:
    """yes where the test holds, else no."""
    if isinstance(yes, Vector) and isinstance(no, Vector):
        return Vector(either(test, yes.x, no.x), either(test, yes.y, no.y))
    if kind_of(yes) == "other" or kind_of(no) == "other":
        return choose(RandomExpr(lambda truth: 1 - truth.astype(int), (test,)), [yes, no])
    return RandomExpr(WHERE.array, (test, yes, no), kind_of(yes) if kind_of(yes) == kind_of(no) else "any")


def attribute_of(scope: Scope, node: ast.Attribute) -> Value:
    return attribute(scope, scope.value(node.value), node.attr)


def subscript(scope: Scope, node: ast.Subscript) -> Value:
    container, index = scope.value(node.value), scope.value(node.slice)
    return item_of(scope, container, index)


def item_of(scope: Scope, container: Value, index: Value) -> Value:
    if isinstance(container, RandomChoice):
        pick = item_at if isinstance(index, RandomExpr) else slice_at if has_random_ends(index) else item_of
        return container.map_options([pick(scope, option, index) for option in container.options])
    if isinstance(container, Region | VectorField):
        return element_of(container, index)
    if isinstance(index, RandomExpr | RandomChoice):
        hint = "write Uniform(*items) for a random element"
        raise ScenicError("random-control-flow", "the index of a list must not be random", hint=hint)
    if isinstance(container, Vector):
        container = (container.x, container.y)
    if isinstance(container, Namespace):
        container = container.names
    if not isinstance(container, list | tuple | dict | str | range):
        hint = "it is called with round brackets" if isinstance(container, Builtin | Function) else ""
        raise ScenicError("type", f"{describe_kind(container)} has no elements to index", hint=hint)
    scope.mode.budget.whole(index)
    result = container[index]
    scope.mode.budget.keep(result) if isinstance(index, slice) else None
    return result


def item_at(scope: Scope, container: Value, index: RandomExpr) -> Value:
    """Return an item of a list at a random place; scenes where it has no such place are rejected."""
    items = scope.elements(container, ast.Pass())
    if isinstance(container, dict) or not items:
        raise ScenicError("type", f"{describe_kind(container)} has no elements at random places")
    place = RandomExpr(Within(len(items)), (index,))
    scope.watch(place)
    return choose(place, items)


def has_random_ends(index: Value) -> bool:
    return isinstance(index, slice) and any(isinstance(end, RandomExpr) for end in (index.start, index.stop))


def slice_at(scope: Scope, container: Value, index: slice) -> Value:
    """Return a slice with random ends: one of all that the list has."""
    items = scope.elements(container, ast.Pass())
    count = len(items)
    scope.mode.budget.container((count + 1) ** 2)
    start, stop = (
        default if end is None else apply(Operation(partial(clip_end, count), partial(clip_end, count)), end)
        for end, default in ((index.start, 0), (index.stop, count))
    )
    place = apply(ADD, apply(MULTIPLY, start, count + 1), stop)
    slices = [items[i : j : index.step] for i in range(count + 1) for j in range(count + 1)]
    return choose(place, slices)


def clip_end(count: int, end: Any) -> Any:
    """Return the end of a slice of `count` elements [N], counted from its start."""
    return np.clip(np.where(np.asarray(end) < 0, end + count, end), 0, count)


class Within(FallibleOperation):
    """Places [N] in a list of `count` elements, counted from its end where negative."""

    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self, index: Any) -> Any:
        return np.clip(np.where(index < 0, index + self.count, index), 0, self.count - 1)

    def fails(self, index: Any) -> Any:
        return (index < -self.count) | (index >= self.count)

    def error(self, row: int) -> ScenicError:
        return from_python(IndexError("list index out of range"))


def slice_of(scope: Scope, node: ast.Slice) -> slice:
    parts = [None if part is None else scope.value(part) for part in (node.lower, node.upper, node.step)]
    return slice(*parts)


def sequence(scope: Scope, node: ast.List | ast.Tuple) -> Value:
    items: list[Value] = []
    for element in node.elts:
        if isinstance(element, ast.Starred):
            items += scope.elements(scope.value(element.value), element)
        else:
            items.append(scope.value(element))
    scope.mode.budget.container(len(items))
    return tuple(items) if isinstance(node, ast.Tuple) else items


def key_of(scope: Scope, node: ast.expr) -> Value:
    """Return a key of a dictionary."""
    key = scope.value(node)
    scope.mode.budget.whole(key)
    return key


def dictionary(scope: Scope, node: ast.Dict) -> dict:
    result: dict = {}
    for key, value in zip(node.keys, node.values, strict=True):
        if key is None:
            result.update(mapping(scope, value))
        else:
            result[key_of(scope, key)] = scope.value(value)
    scope.mode.budget.container(len(result))
    return result


def mapping(scope: Scope, node: ast.expr) -> dict:
    """Return what `**` spreads."""
    value = scope.value(node)
    if not isinstance(value, dict):
        raise scope.error("type", f"`**` needs a dictionary, not {describe_kind(value)}", node)
    return value


def formatted_text(scope: Scope, node: ast.JoinedStr) -> Value:
    """Return an f-string; random parts are written row by row."""
    return concatenate(scope, [scope.value(part) for part in node.values])


def formatted(scope: Scope, node: ast.FormattedValue) -> Value:
    spec = "" if node.format_spec is None else scope.value(node.format_spec)
    return text_of(scope, scope.value(node.value), spec)


def comprehension(scope: Scope, node: ast.ListComp | ast.GeneratorExp) -> list:
    result: list[Value] = []
    for inner in scope.bindings(node.generators):
        result.append(inner.value(node.elt))
        scope.mode.budget.spend(1)
    scope.mode.budget.container(len(result))
    return result


def dictionary_comprehension(scope: Scope, node: ast.DictComp) -> dict:
    result = {key_of(inner, node.key): inner.value(node.value) for inner in scope.bindings(node.generators)}
    scope.mode.budget.container(len(result))
    return result


def assign_inside(scope: Scope, node: ast.NamedExpr) -> Value:
    value = scope.value(node.value)
    at = scope
    while at.transparent and isinstance(at.outer, Scope):
        at = at.outer
    at.assign(node.target.id, value)
    return value


def scenic_operator(scope: Scope, node: nodes.Operator) -> Value:
    operation = OPERATORS.get(node.name)
    if operation is None:
        hint = "temporal requirements belong to a later version" if node.name in TEMPORAL else ""
        raise ScenicError("unsupported", f"`{node.name}` is not yet supported", hint=hint)
    operands = [None if operand is None else scope.value(operand) for operand in node.operands]
    if any(isinstance(operand, LazyValue) for operand in operands) and node.name not in ("relative to", "offset by"):
        raise ScenicError("unsupported", f"`{node.name}` of a value that depends on the object being made")
    return operation(scope, *operands)


TEMPORAL = ("always", "eventually", "next", "until", "implies")
EXPRESSIONS: dict[type, Callable[[Scope, Any], Value]] = {
    ast.Constant: constant,
    ast.Name: name_value,
    ast.BinOp: binary,
    ast.UnaryOp: unary,
    ast.BoolOp: boolean,
    ast.IfExp: conditional,
    ast.Compare: comparison,
    ast.Attribute: attribute_of,
    ast.Subscript: subscript,
    ast.Slice: slice_of,
    ast.List: sequence,
    ast.Tuple: sequence,
    ast.Dict: dictionary,
    ast.JoinedStr: formatted_text,
    ast.FormattedValue: formatted,
    ast.ListComp: comprehension,
    ast.GeneratorExp: comprehension,
    ast.DictComp: dictionary_comprehension,
    ast.NamedExpr: assign_inside,
    nodes.Operator: scenic_operator,
}
