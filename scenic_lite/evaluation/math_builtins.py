"""Functions of numbers, those of Python and of its module `math`; each takes random numbers too.

Read next: `evaluation.builtins`, for containers and texts.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, RandomChoice, broadcasts_over_choices, choose, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.values.formulas import TURN
from scenic_lite.values.graph import RandomExpr, Value, apply, as_number, kind_of
from scenic_lite.values.operations import (
    ABSOLUTE,
    FLOAT,
    HYPOTENUSE,
    INTEGER,
    LOGARITHM,
    MAXIMUM,
    MINIMUM,
    OPERATIONS,
    ROUND,
    Operation,
    real_power,
    to_integers,
)


def numeric(operation: Operation, *operands: Value) -> Value:
    """Return an operation on numbers, random or not. Raises ScenicError for anything else."""
    for operand in operands:
        if kind_of(operand) not in ("number", "truth", "any"):
            raise ScenicError("type", f"a number is needed here, not {describe_kind(operand)}")
    return apply(operation, *(as_number(operand) for operand in operands))


def of_one(operation: Operation) -> Callable[[Value], Value]:
    """Return a function of one number that also takes a random one."""
    return lambda x: numeric(operation, x)


def of_two(operation: Operation) -> Callable[[Value, Value], Value]:
    return lambda x, y: numeric(operation, x, y)


def rounded(number: Value, ndigits: Value = None) -> Value:
    if ndigits is None:
        return numeric(ROUND, number)
    if not isinstance(ndigits, int) or abs(ndigits) > 300:
        raise ScenicError("type", f"the number of digits must be a fixed integer, not {describe_kind(ndigits)}")
    return numeric(Operation(lambda x: round(x, ndigits), lambda x: np.round(x, ndigits)), number)


def power(scope: Scope, node: ast.AST, base: Value, exp: Value) -> Value:
    """`pow(base, exp)`."""
    if isinstance(base, int) and isinstance(exp, int) and exp > 0:
        scope.mode.budget.integer(base.bit_length() * exp)
    numeric(ABSOLUTE, base)  # refuses what is no number
    numeric(ABSOLUTE, exp)
    return real_power(base, exp)


def integer(value: Value = 0) -> Value:
    """`int(value)`, of a number or of a text."""
    if isinstance(value, str) and len(value) > 1000:
        raise exceeded("a text of more than 1000 digits for one integer")
    return int(value) if isinstance(value, str) else numeric(INTEGER, value)


def decimal(value: Value = 0.0) -> Value:
    """`float(value)`, of a number or of a text."""
    return float(value) if isinstance(value, str) else numeric(FLOAT, value)


# ------------------------------------------------------------ the least, the greatest, the sum


class Extreme:
    """`min` or `max`: of several values or of a collection, with `key` and `default`."""

    def __init__(self, operation: Operation) -> None:
        self.operation = operation

    def __call__(self, scope: Scope, node: ast.AST, *values: Value, key: Value = None, default: Value = ...) -> Value:
        if len(values) == 1 and isinstance(values[0], RandomChoice):
            return values[0].map_options([self(scope, node, option, key=key) for option in values[0].options])
        if not values:
            raise ScenicError("type", "min and max need at least one value")
        items = scope.elements(values[0], node) if len(values) == 1 else list(values)
        if not items:
            if default is ...:
                raise ScenicError("value", "the least or greatest of no values")
            return default
        if key is not None:
            return self._by_key(scope, node, items, key)
        if any(isinstance(item, RandomExpr) for item in items) and all(kind_of(item) != "text" for item in items):
            return reduce(lambda a, b: numeric(self.operation, a, b), items)
        scope.mode.budget.whole(items)
        for item in items:
            scope.refuse_random(item, node, "random values cannot be compared here")
        if len(items) == 1:
            return items[0]
        return self.operation.scalar(items)

    def _by_key(self, scope: Scope, node: ast.AST, items: list, key: Value) -> Value:
        keys = [scope.call(key, [item], {}, node) for item in items]
        scope.mode.budget.whole(keys)
        if any(isinstance(item_key, RandomExpr) for item_key in keys) and all(
            kind_of(item_key) == "number" for item_key in keys
        ):
            best = np.argmin if self.operation is MINIMUM else np.argmax
            return choose(RandomExpr(BestOf(best), tuple(keys)), items)
        return items[self.operation.scalar(range(len(items)), key=keys.__getitem__)]


class BestOf:
    """The index of the least or greatest of several arrays [N]."""

    def __init__(self, best: Callable[..., Any]) -> None:
        self.best = best

    def __call__(self, *keys: Any) -> Any:
        return self.best(np.stack(np.broadcast_arrays(*keys)), axis=0)


@broadcasts_over_choices(2)
def total(scope: Scope, node: ast.AST, values: Value, start: Value = 0) -> Value:
    """`sum(values, start)`."""
    items = scope.elements(values, node)
    if isinstance(start, str):
        raise ScenicError("type", "texts are not added by sum()", hint="write a + b")
    if isinstance(start, list | tuple):
        scope.mode.budget.container(len(start) + sum(len(item) for item in items if isinstance(item, list | tuple)))
    return reduce(lambda a, b: a + b, items, start)


# ------------------------------------------------------------ math


def hypotenuse(scope: Scope, node: ast.AST, *sides: Value) -> Value:
    if len(sides) == 1:
        return numeric(ABSOLUTE, *sides)
    return reduce(lambda a, b: numeric(HYPOTENUSE, a, b), sides, 0.0)


def logarithm(x: Value, base: Value = None) -> Value:
    own = numeric(LOGARITHM, x)
    return own if base is None else own / numeric(LOGARITHM, base)


def distance(scope: Scope, node: ast.AST, p: Value, q: Value) -> Value:
    """`math.dist`."""
    ends = scope.elements(p, node), scope.elements(q, node)
    if len(ends[0]) != len(ends[1]):
        raise ScenicError("value", "both points must have the same number of coordinates")
    return hypotenuse(scope, node, *(a - b for a, b in zip(*ends, strict=True)))


TRUNCATION = Operation(math.trunc, to_integers)


def of_table(operation: Operation) -> Builtin:
    """Return the function of the module `math` that a row of the table of operations is."""
    if operation.kind == "truth":
        return Builtin(operation.name, lambda x: apply(operation, x))
    return Builtin(operation.name, of_one(operation) if operation.arity == 1 else of_two(operation))


MATH: dict[str, Value] = {
    **{row.name: of_table(row) for row in OPERATIONS if vars(math).get(row.name) is row.scalar},
    "trunc": Builtin("trunc", of_one(TRUNCATION)),
    "log": Builtin("log", logarithm),
    "hypot": Builtin("hypot", hypotenuse, needs_context=True),
    "dist": Builtin("dist", distance, needs_context=True),
    "pi": math.pi,
    "tau": TURN,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
}
NUMBERS: dict[str, Value] = {
    "abs": Builtin("abs", of_one(ABSOLUTE)),
    "round": Builtin("round", rounded),
    "pow": Builtin("pow", power, needs_context=True),
    "int": Builtin("int", integer, types=(int,)),
    "float": Builtin("float", decimal, types=(float,)),
    "min": Builtin("min", Extreme(MINIMUM), needs_context=True, over_choices=False),
    "max": Builtin("max", Extreme(MAXIMUM), needs_context=True, over_choices=False),
    "sum": Builtin("sum", total, needs_context=True, over_choices=False),
}
