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
from scenic_lite.core.types import Builtin, RandomChoice, choose, describe_kind
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
    MULTIPLY,
    OPERATIONS,
    ROUND,
    Operation,
    real_power,
    to_integers,
)


def numeric(operation: Operation, *operands: Value) -> Value:
    """An operation on numbers, random or not. Raises ScenicError for anything else."""
    for operand in operands:
        if kind_of(operand) not in ("number", "truth", "any"):
            raise ScenicError("type", f"a number is needed here, not {describe_kind(operand)}")
    return apply(operation, *(as_number(operand) for operand in operands))


def of_one(operation: Operation) -> Callable[[Value], Value]:
    """A function of one number that also takes a random one."""
    return lambda x: numeric(operation, x)


def of_two(operation: Operation) -> Callable[[Value, Value], Value]:
    return lambda x, y: numeric(operation, x, y)


def rounded(number: Value, ndigits: Value = None) -> Value:
    if ndigits is None:
        return numeric(ROUND, number)
    if not isinstance(ndigits, int) or abs(ndigits) > 300:
        raise ScenicError("type", f"the number of digits must be a fixed integer, not {describe_kind(ndigits)}")
    return numeric(Operation(lambda x: round(x, ndigits), lambda x: np.round(x, ndigits)), number)


def quotient_and_rest(scope: Scope, node: ast.AST, a: Value, b: Value) -> tuple[Value, Value]:
    """`divmod(a, b)`."""
    for each in (a, b):
        numeric(ABSOLUTE, each)  # refuses what is no number
    return (a // b, a % b)


def power(scope: Scope, node: ast.AST, base: Value, exp: Value, mod: Value = None) -> Value:
    """`pow(base, exp[, mod])`."""
    if mod is not None:
        if not all(isinstance(each, int) for each in (base, exp, mod)):
            raise ScenicError("type", "pow() with three arguments takes fixed integers")
        return pow(base, exp, mod)
    if isinstance(base, int) and isinstance(exp, int) and exp > 0:
        scope.mode.budget.integer(base.bit_length() * exp)
    numeric(ABSOLUTE, base)
    numeric(ABSOLUTE, exp)
    return real_power(base, exp)


def integer(value: Value = 0, base: Value = None) -> Value:
    """`int(value)`, `int(text, base)`; of a random text row by row."""
    if isinstance(value, str):
        if len(value) > 1000:
            raise exceeded("a text of more than 1000 digits for one integer")
        return int(value) if base is None else int(value, base)
    if base is not None:
        raise ScenicError("type", "int() takes a base only with a text")
    if kind_of(value) == "text":
        return RandomExpr(each_integer, (value,))
    return numeric(INTEGER, value)


def decimal(value: Value = 0.0) -> Value:
    if isinstance(value, str):
        return float(value)
    return RandomExpr(each_decimal, (value,)) if kind_of(value) == "text" else numeric(FLOAT, value)


def each_integer(texts: Any) -> Any:
    return np.array([int(each) for each in texts], dtype=np.int64)


def each_decimal(texts: Any) -> Any:
    return np.array([float(each) for each in texts], dtype=float)


def in_base(convert: Callable[[int], str]) -> Callable[[Value], str]:
    """`hex`, `oct`, `bin`."""

    def written(number: Value) -> str:
        if not isinstance(number, int):
            raise ScenicError("type", f"an integer is needed here, not {describe_kind(number)}")
        return convert(number)

    return written


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
        if any(isinstance(each, RandomExpr) for each in keys) and all(kind_of(each) == "number" for each in keys):
            best = np.argmin if self.operation is MINIMUM else np.argmax
            return choose(RandomExpr(BestOf(best), tuple(keys)), items)
        return items[self.operation.scalar(range(len(items)), key=keys.__getitem__)]


class BestOf:
    """The index of the least or greatest of several arrays [N]."""

    def __init__(self, best: Callable[..., Any]) -> None:
        self.best = best

    def __call__(self, *keys: Any) -> Any:
        return self.best(np.stack(np.broadcast_arrays(*keys)), axis=0)


def total(scope: Scope, node: ast.AST, values: Value, start: Value = 0) -> Value:
    """`sum(values, start)`."""
    if isinstance(values, RandomChoice):
        return values.map_options([total(scope, node, option, start) for option in values.options])
    items = scope.elements(values, node)
    if isinstance(start, str):
        raise ScenicError("type", "texts are not added by sum()", hint="write ''.join(texts)")
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


def are_close(a: Value, b: Value, rel_tol: Value = 1e-9, abs_tol: Value = 0.0) -> Value:
    operation = Operation(
        lambda x, y: math.isclose(x, y, rel_tol=rel_tol, abs_tol=abs_tol),
        lambda x, y: np.abs(x - y) <= np.maximum(rel_tol * np.maximum(np.abs(x), np.abs(y)), abs_tol),
    )
    return apply(operation, a, b, kind="truth")


def product(scope: Scope, node: ast.AST, values: Value, start: Value = 1) -> Value:
    result = start
    for each in scope.elements(values, node):
        result = numeric(MULTIPLY, result, each)
        scope.mode.budget.keep(result)
    return result


def exact_sum(scope: Scope, node: ast.AST, values: Value) -> Value:
    items = scope.elements(values, node)
    if any(isinstance(item, RandomExpr) for item in items):
        return total(scope, node, items, 0.0)
    return math.fsum(items)


def distance(scope: Scope, node: ast.AST, p: Value, q: Value) -> Value:
    """`math.dist`."""
    ends = scope.elements(p, node), scope.elements(q, node)
    if len(ends[0]) != len(ends[1]):
        raise ScenicError("value", "both points must have the same number of coordinates")
    return hypotenuse(scope, node, *(a - b for a, b in zip(*ends, strict=True)))


def parts_of_number(x: Value) -> tuple[Value, Value]:
    """`math.modf`."""
    whole = numeric(Operation(lambda v: float(math.trunc(v)), np.trunc), x)
    return (x - whole, whole)


def factorial(n: Value) -> int:
    if isinstance(n, int) and n > 500:
        raise exceeded("the factorial of more than 500")
    return math.factorial(n)


def combinations(n: Value, k: Value) -> int:
    if isinstance(n, int) and n > 4096:
        raise exceeded("combinations of more than 4096")
    return math.comb(n, k)


TRUNCATION = Operation(math.trunc, to_integers)
INTEGERS_ONLY = (math.gcd, math.lcm, math.isqrt)


def fixed_integers(function: Callable[..., int]) -> Callable[..., int]:
    """A function of integers that are not random."""

    def computed(*numbers: Value) -> int:
        for number in numbers:
            if not isinstance(number, int):
                raise ScenicError("type", f"a fixed integer is needed here, not {describe_kind(number)}")
        return function(*numbers)

    return computed


def of_table(operation: Operation) -> Builtin:
    """Return the function of the module `math` that a row of the table of operations is."""
    if operation.kind == "truth":
        return Builtin(operation.name, lambda x: apply(operation, x))
    return Builtin(operation.name, of_one(operation) if operation.arity == 1 else of_two(operation))


MATH: dict[str, Value] = {
    **{row.name: of_table(row) for row in OPERATIONS if vars(math).get(row.name) is row.scalar},
    **{function.__name__: Builtin(function.__name__, fixed_integers(function)) for function in INTEGERS_ONLY},
    "trunc": Builtin("trunc", of_one(TRUNCATION)),
    "log": Builtin("log", logarithm),
    "hypot": Builtin("hypot", hypotenuse, needs_context=True),
    "dist": Builtin("dist", distance, needs_context=True),
    "isclose": Builtin("isclose", are_close),
    "prod": Builtin("prod", product, needs_context=True),
    "fsum": Builtin("fsum", exact_sum, needs_context=True),
    "modf": Builtin("modf", parts_of_number),
    "factorial": Builtin("factorial", factorial),
    "comb": Builtin("comb", combinations),
    "pi": math.pi,
    "tau": TURN,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
}
NUMBERS: dict[str, Value] = {
    "abs": Builtin("abs", of_one(ABSOLUTE)),
    "round": Builtin("round", rounded),
    "divmod": Builtin("divmod", quotient_and_rest, needs_context=True),
    "pow": Builtin("pow", power, needs_context=True),
    "int": Builtin("int", integer, types=(int,)),
    "float": Builtin("float", decimal, types=(float,)),
    "hex": Builtin("hex", in_base(hex)),
    "oct": Builtin("oct", in_base(oct)),
    "bin": Builtin("bin", in_base(bin)),
    "min": Builtin("min", Extreme(MINIMUM), needs_context=True, over_choices=False),
    "max": Builtin("max", Extreme(MAXIMUM), needs_context=True, over_choices=False),
    "sum": Builtin("sum", total, needs_context=True, over_choices=False),
}
