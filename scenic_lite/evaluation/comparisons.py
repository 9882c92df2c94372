"""Comparisons: chains of them, equality, membership in containers and regions.

Outside requirements nothing random may be compared, as in real Scenic. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope, in_row
from scenic_lite.core.types import RandomChoice, broadcasts_over_choices, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import is_object, outline
from scenic_lite.values.geometry import Vector, as_vector
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import (
    AND,
    EQUAL,
    GREATER,
    GREATER_EQUAL,
    LESS,
    LESS_EQUAL,
    NOT,
    NOT_EQUAL,
    OR,
    Operation,
)
from scenic_lite.values.regions import Region

PARTS = (RandomExpr, Vector, list, tuple, RandomChoice)  # what a list may hold that Python's own `==` does not compare
COMPARISONS: dict[type, Operation] = {
    ast.Lt: LESS,
    ast.LtE: LESS_EQUAL,
    ast.Gt: GREATER,
    ast.GtE: GREATER_EQUAL,
    ast.Eq: EQUAL,
    ast.NotEq: NOT_EQUAL,
}


def each_holds(parts: Any, texts: Any) -> Any:
    """Return whether each text holds the part beside it; arrays [N] or single texts."""
    return np.array([part in text for part, text in np.broadcast(parts, texts)], dtype=bool)


HOLDS = Operation(lambda part, text: part in text, each_holds)


def comparison(scope: Scope, node: ast.Compare) -> Value:
    """Return a chain of comparisons; random ones are allowed in requirements only."""
    left = scope.value(node.left)
    result: Value = True
    for sign, operand in zip(node.ops, node.comparators, strict=True):
        with scope.state.watching.under(*(((result, True),) if isinstance(result, RandomExpr) else ())):
            right = scope.value(operand)
        link = compared(scope, node, sign, left, right)
        if isinstance(link, RandomExpr) or isinstance(result, RandomExpr):
            result = apply(AND, result, link, kind="truth") if result is not True else link
        else:
            result = bool(link)
        if result is False:
            return False
        left = right
    return result


def compared(scope: Scope, node: ast.Compare, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """Return one link of a chain of comparisons."""
    if isinstance(sign, ast.Is | ast.IsNot):
        return identity(scope, left, right, isinstance(sign, ast.Is))
    if isinstance(sign, ast.In | ast.NotIn):
        inside = membership(scope, node, left, right)
        return inside if isinstance(sign, ast.In) else apply(NOT, inside, kind="truth")
    for side in (left, right):
        scope.mode.budget.whole(side)
        if not scope.mode.symbolic:
            scope.refuse_random(side, node, "random values cannot be compared here")
    if isinstance(left, RandomChoice):
        return left.map_options([compared(scope, node, sign, option, right) for option in left.options])
    if isinstance(right, RandomChoice):
        return right.map_options([compared(scope, node, sign, left, option) for option in right.options])
    if isinstance(sign, ast.Eq | ast.NotEq):
        return equality(scope, sign, left, right)
    for side in (left, right):
        if not isinstance(side, int | float | str | RandomExpr | list | tuple):
            raise ScenicError("type", f"{describe_kind(side)} cannot be ordered")
    if kind_of(left) != kind_of(right) and not {kind_of(left), kind_of(right)} <= {"number", "truth"}:
        raise ScenicError("type", f"{describe_kind(left)} and {describe_kind(right)} cannot be ordered")
    return apply(COMPARISONS[type(sign)], left, right, kind="truth")


def identity(scope: Scope, left: Value, right: Value, same: bool) -> Value:
    """`left is right`; outside requirements a random choice is itself and none of its options, as in real Scenic."""
    if left is right or not scope.mode.symbolic:
        return (left is right) == same
    if isinstance(left, RandomChoice):
        return left.map_options([identity(scope, option, right, same) for option in left.options])
    if isinstance(right, RandomChoice):
        return identity(scope, right, left, same)
    return not same


def equality(scope: Scope, sign: ast.cmpop, left: Value, right: Value) -> Value:
    if alike(left, right) and any(isinstance(part, PARTS) for part in (*left, *right)):
        return part_by_part(scope, sign, left, right)
    if isinstance(left, Vector) and isinstance(right, Vector):
        same = apply(
            AND, apply(EQUAL, left.x, right.x, kind="truth"), apply(EQUAL, left.y, right.y, kind="truth"), kind="truth"
        )
        return same if isinstance(sign, ast.Eq) else apply(NOT, same, kind="truth")
    if isinstance(left, RandomExpr) or isinstance(right, RandomExpr):
        kinds = {kind_of(left), kind_of(right)}
        if len(kinds - {"truth", "number", "any"}) and "any" not in kinds and len(kinds) > 1:
            return isinstance(sign, ast.NotEq)
    return apply(COMPARISONS[type(sign)], left, right, kind="truth")


def alike(left: Value, right: Value) -> bool:
    """Return whether these are two lists or two tuples of one length."""
    return isinstance(left, list | tuple) and type(left) is type(right) and len(left) == len(right)


def part_by_part(scope: Scope, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """Equality of two collections of the same length, with random parts."""
    result: Value = True
    for a, b in zip(left, right, strict=True):
        if scope.mode.row is not None:
            a, b = in_row(a, scope.mode.row), in_row(b, scope.mode.row)
        for part in (a, b):
            if not scope.mode.symbolic:
                scope.refuse_random(part, ast.Pass(), "random values cannot be compared here")
        same = True if a is b else equality(scope, ast.Eq(), a, b)
        result = apply(AND, result, same, kind="truth")
    return result if isinstance(sign, ast.Eq) else apply(NOT, result, kind="truth")


@broadcasts_over_choices(3)
def membership(scope: Scope, node: ast.Compare, item: Value, container: Value) -> Value:
    """`item in container`: a region holds points and objects, other containers elements."""
    if isinstance(container, Region):
        inside = in_region(container, item)
        if isinstance(inside, RandomExpr) and not scope.mode.symbolic:
            scope.refuse_random(inside, node, "random values cannot be compared here")
        return inside
    if kind_of(container) == "text":
        if kind_of(item) != "text":
            raise ScenicError("type", f"a text holds texts, not {describe_kind(item)}")
        for value in (item, container):
            if not scope.mode.symbolic:
                scope.refuse_random(value, node, "random values cannot be compared here")
        return apply(HOLDS, item, container, kind="truth")
    elements = scope.elements(container, node)
    if not scope.mode.symbolic:
        for value in (item, *elements):
            scope.refuse_random(value, node, "random values cannot be compared here")
    result: Value = False
    for element in elements:
        same = element is item or compared(scope, node, ast.Eq(), item, element)
        result = apply(OR, result, same, kind="truth")
    return result


@broadcasts_over_choices(1)
def in_region(region: Region, item: Value) -> Value:
    if is_object(item):
        return region.contains_corners(outline(item))
    point = as_vector(item)
    if point is None:
        raise ScenicError("type", f"a region holds points and objects, not {describe_kind(item)}")
    return region.contains(point)
