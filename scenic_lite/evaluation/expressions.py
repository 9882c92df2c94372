"""Evaluate expressions: the meaning of each node for numbers, containers and random values.

As in Scenic, random values cannot be compared outside requirements. Read next: `evaluation.access`, attributes and
elements; `evaluation.calls`, functions and instances; `evaluation.statements`.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import LazyValue, RandomChoice, broadcasts_over_choices, choose, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import attribute, item_of
from scenic_lite.evaluation.builtins import text_of
from scenic_lite.language.classes import is_object, outline
from scenic_lite.language.scenic_operators import OPERATORS
from scenic_lite.language.specifier_rules import ego_of
from scenic_lite.syntax import nodes
from scenic_lite.values import operations
from scenic_lite.values.geometry import Vector, as_vector
from scenic_lite.values.graph import RandomExpr, Value, apply, is_number, kind_of
from scenic_lite.values.lines import PolylineRegion
from scenic_lite.values.regions import Region

BINARY: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.FloorDiv: ("//", operator.floordiv),
    ast.Mod: ("%", operator.mod),
    ast.Pow: ("**", operations.real_power),
}
OPERANDS = (int, float, str, list, tuple, dict, Vector, RandomExpr, PolylineRegion)
PARTS = (RandomExpr, Vector, list, tuple, RandomChoice)  # element types of lists that need our own comparison
COMPARISONS: dict[type, operations.Operation] = {
    ast.Lt: operations.LESS,
    ast.LtE: operations.LESS_EQUAL,
    ast.Gt: operations.GREATER,
    ast.GtE: operations.GREATER_EQUAL,
    ast.Eq: operations.EQUAL,
    ast.NotEq: operations.NOT_EQUAL,
}


def constant(scope: Scope, node: ast.Constant) -> Value:
    scope.mode.budget.keep(node.value)
    if isinstance(node.value, float) and math.isinf(node.value):
        raise ScenicError("value", "this number is too large", hint="write math.inf for infinity")
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
    """Return the result of the binary operation `left sign right`, within the budget."""
    if isinstance(sign, ast.MatMult):
        return at_sign(left, right)
    if isinstance(sign, ast.Mod) and kind_of(left) == "text":
        raise ScenicError("unsupported", "`%` does not format texts here", hint='write f"...{x}..."')
    check_size(scope, sign, left, right)
    sides = []
    for operand in (left, right):  # arithmetic on an object uses its position
        if not isinstance(operand, OPERANDS):
            operand = as_vector(operand) if isinstance(sign, ast.Add | ast.Sub | ast.Mult | ast.Div) else None
            if operand is None:
                raise mismatch(sign, left, right)
        sides.append(operand)
    try:
        result = BINARY[type(sign)][1](*sides)
    except TypeError:
        raise mismatch(sign, *sides) from None
    scope.mode.budget.keep(result)
    scope.watch(result)
    return result


def mismatch(sign: ast.operator, left: Value, right: Value) -> ScenicError:
    sides = f"{describe_kind(left)} and {describe_kind(right)}"
    hint = ""
    if isinstance(left, Vector) != isinstance(right, Vector):
        hint = "`@` binds as tightly as `*`: write (x + y) @ z"
    return ScenicError("type", f"`{BINARY[type(sign)][0]}` of {sides}", hint=hint)


def at_sign(x: Value, y: Value) -> Value:
    """Return the vector `x @ y`."""
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
    """Raise ScenicError for a huge result before it is computed."""
    budget = scope.mode.budget
    if isinstance(left, int) and isinstance(right, int):
        if isinstance(sign, ast.Pow) and right > 0:
            budget.integer(left.bit_length() * right)
    elif isinstance(sign, ast.Mult):
        for sequence, count in ((left, right), (right, left)):
            if isinstance(sequence, str | list | tuple) and isinstance(count, int):
                budget.repeated(sequence, count)


def unary(scope: Scope, node: ast.UnaryOp) -> Value:
    value = scope.value(node.operand)
    if not isinstance(node.op, ast.Not):
        return apply_sign(scope, node.op, value)
    if isinstance(value, RandomExpr) and scope.mode.symbolic:
        return apply(operations.NOT, value)
    return not scope.certain_truth(value, node.operand)


@broadcasts_over_choices(2)
def apply_sign(scope: Scope, sign: ast.unaryop, value: Value) -> Value:
    if not isinstance(value, int | float | Vector | RandomExpr):
        raise ScenicError("type", f"{describe_kind(value)} has no sign")
    return -value if isinstance(sign, ast.USub) else +value


def boolean(scope: Scope, node: ast.BoolOp) -> Value:
    """Evaluate `and` and `or` with short circuits as in Python, except for random values inside requirements."""
    is_and = isinstance(node.op, ast.And)
    pending: Value = None
    value: Value = None
    for operand in node.values:
        with scope.state.watching.under(*(() if pending is None else ((pending, is_and),))):
            value = scope.value(operand)
        if isinstance(value, RandomExpr) and scope.mode.symbolic:
            pending = value if pending is None else apply(operations.AND if is_and else operations.OR, pending, value)
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
    """Return `yes` in scenes in which the test holds, otherwise `no`."""
    if isinstance(yes, Vector) and isinstance(no, Vector):
        return Vector(either(test, yes.x, no.x), either(test, yes.y, no.y))
    if kind_of(yes) == "other" or kind_of(no) == "other":
        return choose(RandomExpr(lambda truth: 1 - truth.astype(int), (test,)), [yes, no])
    return RandomExpr(operations.WHERE.array, (test, yes, no), kind_of(yes) if kind_of(yes) == kind_of(no) else "any")


# ------------------------------------------------------------ comparisons
def comparison(scope: Scope, node: ast.Compare) -> Value:
    """Evaluate a chain of comparisons; random values are allowed in requirements only."""
    left = scope.value(node.left)
    result: Value = True
    for sign, operand in zip(node.ops, node.comparators, strict=True):
        with scope.state.watching.under(*(((result, True),) if isinstance(result, RandomExpr) else ())):
            right = scope.value(operand)
        link = compared(scope, node, sign, left, right)
        if isinstance(link, RandomExpr) or isinstance(result, RandomExpr):
            result = apply(operations.AND, result, link) if result is not True else link
        else:
            result = bool(link)
        if result is False:
            return False
        left = right
    return result


def compared(scope: Scope, node: ast.AST, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """Evaluate one comparison of a chain."""
    if isinstance(sign, ast.Is | ast.IsNot):
        return identity(scope, left, right, isinstance(sign, ast.Is))
    if isinstance(sign, ast.In | ast.NotIn):
        inside = membership(scope, node, left, right)
        return inside if isinstance(sign, ast.In) else apply(operations.NOT, inside)
    scope.mode.budget.whole(left)
    scope.mode.budget.whole(right)
    scope.refuse_comparison(node, left, right)
    return related(scope, sign, left, right)


@broadcasts_over_choices(2, 3)
def related(scope: Scope, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """Evaluate the comparison `left sign right`, for all signs except `is` and `in`."""
    if isinstance(sign, ast.Eq | ast.NotEq):
        return equality(scope, sign, left, right)
    for side in (left, right):
        if not isinstance(side, int | float | str | RandomExpr | list | tuple):
            raise ScenicError("type", f"{describe_kind(side)} cannot be ordered")
    if kind_of(left) != kind_of(right) and not {kind_of(left), kind_of(right)} <= {"number", "truth"}:
        raise ScenicError("type", f"{describe_kind(left)} and {describe_kind(right)} cannot be ordered")
    return apply(COMPARISONS[type(sign)], left, right)


def identity(scope: Scope, left: Value, right: Value, same: bool) -> Value:
    """Evaluate `left is right`; outside requirements a random choice is identical only to itself, as in Scenic."""
    if left is right or not scope.mode.symbolic:
        return (left is right) == same
    if isinstance(left, RandomChoice):
        return left.each(lambda option: identity(scope, option, right, same))
    return identity(scope, right, left, same) if isinstance(right, RandomChoice) else not same


def equality(scope: Scope, sign: ast.cmpop, left: Value, right: Value) -> Value:
    both = isinstance(left, list | tuple) and isinstance(right, list | tuple)
    if both and any(isinstance(part, PARTS) for part in (*left, *right)):
        message = "collections of random values, vectors or collections are not compared"
        raise ScenicError("unsupported", message, hint="compare their elements one by one")
    if isinstance(left, Vector) and isinstance(right, Vector):
        same = apply(operations.AND, apply(operations.EQUAL, left.x, right.x), apply(operations.EQUAL, left.y, right.y))
        return same if isinstance(sign, ast.Eq) else apply(operations.NOT, same)
    if isinstance(left, RandomExpr) or isinstance(right, RandomExpr):
        kinds = {kind_of(left), kind_of(right)}
        if len(kinds) > 1 and "any" not in kinds and not kinds <= {"truth", "number"}:
            return isinstance(sign, ast.NotEq)
    return apply(COMPARISONS[type(sign)], left, right)


@broadcasts_over_choices(3)
def membership(scope: Scope, node: ast.AST, item: Value, container: Value) -> Value:
    """Evaluate `item in container`: a region contains points and objects, other containers contain elements."""
    if isinstance(container, Region):
        inside = in_region(scope, container, item)
        if isinstance(inside, RandomExpr):
            scope.refuse_comparison(node, inside)
        return inside
    if kind_of(container) == "text":
        if kind_of(item) != "text":
            raise ScenicError("type", f"a text holds texts, not {describe_kind(item)}")
        scope.refuse_random_in((item, container), node, "a random text cannot be searched")
        return item in container
    elements = scope.elements(container, node)
    scope.refuse_comparison(node, item, *elements)
    result: Value = False
    for element in elements:
        same = element is item or compared(scope, node, ast.Eq(), item, element)
        result = same if result is False else apply(operations.OR, result, same)
    return result


@broadcasts_over_choices(2)
def in_region(scope: Scope, region: Region, item: Value) -> Value:
    if is_object(item):
        return region.contains_corners(outline(item))
    point = as_vector(item)
    if point is None:
        raise ScenicError("type", f"a region holds points and objects, not {describe_kind(item)}")
    return region.contains(point)


# ------------------------------------------------------------ containers and texts
def attribute_of(scope: Scope, node: ast.Attribute) -> Value:
    return attribute(scope, scope.value(node.value), node.attr)


def subscript(scope: Scope, node: ast.Subscript) -> Value:
    container, index = scope.value(node.value), scope.value(node.slice)
    return item_of(scope, container, index)


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
    """Evaluate a key of a dictionary and charge its size."""
    key = scope.value(node)
    scope.mode.budget.whole(key)
    return key


def dictionary(scope: Scope, node: ast.Dict) -> dict:
    result: dict = {}
    for key, value in zip(node.keys, node.values, strict=True):
        assert key is not None, "the parser refuses `**`"
        result[key_of(scope, key)] = scope.value(value)
    scope.mode.budget.container(len(result))
    return result


def formatted_text(scope: Scope, node: ast.JoinedStr) -> Value:
    """Evaluate an f-string; random parts are formatted row by row."""
    result: Value = ""
    for piece in [scope.value(part) for part in node.values]:
        result = piece if result == "" else result + piece
        scope.mode.budget.keep(result)
    return result


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


def scenic_operator(scope: Scope, node: nodes.Operator) -> Value:
    operation = OPERATORS.get(node.name)
    if operation is None:
        raise ScenicError("unsupported", f"`{node.name}` is not yet supported")
    operands = scope.operands(node.operands)
    if any(isinstance(operand, LazyValue) for operand in operands) and node.name not in ("relative to", "offset by"):
        raise ScenicError("unsupported", f"`{node.name}` of a value that depends on the object being made")
    result = operation(scope, *operands)
    scope.refuse_none(node.operands, operands)
    return result


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
    nodes.Operator: scenic_operator,
}
