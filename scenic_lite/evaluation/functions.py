"""The built-in functions: numbers (fixed or random), distributions, regions, `math` and `random`.

Programs can call only the functions in these tables. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast
import math
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import (
    Builtin,
    Namespace,
    RandomChoice,
    broadcasts_over_choices,
    choose,
    describe_kind,
    needs_context,
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.builtins import PYTHON, left_out
from scenic_lite.language import distributions as draw
from scenic_lite.language.classes import OBJECT, ORIENTED_POINT, POINT, number_of
from scenic_lite.language.regions import REGIONS
from scenic_lite.values import operations
from scenic_lite.values.formulas import TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply, as_number, is_number, kind_of


# ------------------------------------------------------------ numbers
def numeric(operation: operations.Operation, *operands: Value) -> Value:
    """Apply an operation to fixed or random numbers. Raises ScenicError for other operands."""
    for operand in operands:
        if kind_of(operand) not in ("number", "truth", "any"):
            raise ScenicError("type", f"a number is needed here, not {describe_kind(operand)}")
    return apply(operation, *(as_number(operand) for operand in operands))


def of_table(operation: operations.Operation, name: str = "", *types: type) -> Builtin:
    """Return the built-in function for an operation of the table."""
    if operation.arity == 1:
        return Builtin(name or operation.name, lambda x: numeric(operation, x), types=types)
    return Builtin(name or operation.name, lambda x, y: numeric(operation, x, y))


def rounded(number: Value, ndigits: Value = None) -> Value:
    if ndigits is None:
        return numeric(operations.ROUND, number)
    if not isinstance(ndigits, int) or abs(ndigits) > 300:
        raise ScenicError("type", f"the number of digits must be a fixed integer, not {describe_kind(ndigits)}")
    return numeric(operations.Operation(lambda x: round(x, ndigits), lambda x: np.round(x, ndigits)), number)


@broadcasts_over_choices(2)
def total(scope: Scope, node: ast.AST, values: Value, start: Value = 0) -> Value:
    """Return `sum(values, start)`."""
    items = scope.elements(values, node)
    if isinstance(start, str):
        raise ScenicError("type", "texts are not added by sum()", hint="write a + b")
    if isinstance(start, list | tuple):
        scope.mode.budget.container(len(start) + sum(len(item) for item in items if isinstance(item, list | tuple)))
    return reduce(lambda a, b: a + b, items, start)


def hypotenuse(scope: Scope, node: ast.AST, *sides: Value) -> Value:
    if len(sides) == 1:
        return numeric(operations.ABSOLUTE, *sides)
    return reduce(lambda a, b: numeric(operations.HYPOTENUSE, a, b), sides, 0.0)


def logarithm(x: Value, base: Value = None) -> Value:
    own = numeric(operations.LOGARITHM, x)
    return own if base is None else own / numeric(operations.LOGARITHM, base)


# ------------------------------------------------------------ minimum and maximum
class Extreme:
    """The functions `min` and `max` of several values or one collection, with `key` and `default`."""

    def __init__(self, operation: operations.Operation) -> None:
        self.operation = operation

    def __call__(self, scope: Scope, node: ast.AST, *values: Value, key: Value = None, default: Value = ...) -> Value:
        if len(values) == 1 and isinstance(values[0], RandomChoice):
            return values[0].each(lambda option: self(scope, node, option, key=key, default=default))
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
        scope.refuse_random_in(items, node, "random values cannot be compared here")
        return items[0] if len(items) == 1 else self.operation.scalar(items)

    def _by_key(self, scope: Scope, node: ast.AST, items: list, key: Value) -> Value:
        keys = [scope.call(key, [item], {}, node) for item in items]
        scope.mode.budget.whole(keys)
        if any(isinstance(value, RandomExpr) for value in keys) and all(kind_of(value) == "number" for value in keys):
            return choose(RandomExpr(self._best_of, tuple(keys)), items)
        return items[self.operation.scalar(range(len(items)), key=keys.__getitem__)]

    def _best_of(self, *keys: Any) -> Any:
        """Return the index of the minimum or maximum of several arrays [N]."""
        best = np.argmin if self.operation is operations.MINIMUM else np.argmax
        return best(np.stack(np.broadcast_arrays(*keys)), axis=0)


# ------------------------------------------------------------ functions of the language
def no_shapely(scope: Scope, node: ast.AST, *shapes: Value) -> None:
    """Reject functions that return Shapely objects; football's libraries import them, but programs do not need them."""
    raise ScenicError("unsupported", "objects of Shapely are not supported", hint="write PolygonalRegion(points)")


def outside_behavior(scope: Scope, node: ast.AST) -> None:
    raise ScenicError("type", "simulation() has a meaning only while a behavior runs", hint="use it inside a behavior")


def vector_of(x: Value, y: Value, z: Value = 0) -> Vector:
    """Return `Vector(x, y)`; programs for three dimensions add a third coordinate, which must be 0."""
    if not is_number(z) or z != 0:
        raise ScenicError("unsupported", "the third coordinate of a vector must be 0 in two dimensions")
    return Vector(number_of(x), number_of(y))


# ------------------------------------------------------------ the tables


NUMBERS: dict[str, Value] = {
    "abs": of_table(operations.ABSOLUTE),
    "round": Builtin("round", rounded),
    "int": of_table(operations.INTEGER, "int", int),
    "float": of_table(operations.FLOAT, "float", float),
    **left_out({"write a ** b": "pow"}),
    **needs_context(min=Extreme(operations.MINIMUM), max=Extreme(operations.MAXIMUM), sum=total),
}
MATH: dict[str, Value] = {
    **{row.name: of_table(row) for row in operations.OPERATIONS if vars(math).get(row.name) is row.scalar},
    "trunc": of_table(operations.INTEGER, "trunc"),
    "log": Builtin("log", logarithm),
    "hypot": Builtin("hypot", hypotenuse, needs_context=True),
    "pi": math.pi,
    "tau": TURN,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
    **left_out(
        {
            "write abs(a - b) < 1e-9": "isclose",
            "write math.floor(math.sqrt(x))": "isqrt",
            "write x - math.trunc(x) and math.trunc(x)": "modf",
            "write sum(...)": "fsum",
            "write distance from a to b": "dist",
            "write a function with a loop": "prod factorial comb gcd lcm",
        }
    ),
}
DISTRIBUTIONS: dict[str, Value] = needs_context(
    Range=draw.draw_range,
    VerifaiRange=draw.draw_range,
    Uniform=draw.draw_uniform,
    Discrete=draw.draw_discrete,
    Options=draw.draw_discrete,
    VerifaiOptions=draw.draw_discrete,
    DiscreteRange=draw.draw_integers,
    VerifaiDiscreteRange=draw.draw_integers,
    Normal=draw.draw_normal,
    TruncatedNormal=draw.draw_truncated_normal,
    resample=draw.resample,
)
RANDOM: dict[str, Value] = {  # replaces Python's module `random`: each call draws from θ
    **needs_context(
        uniform=draw.draw_range,
        random=lambda scope, node: draw.draw_range(scope, node, 0, 1),
        randint=draw.draw_integers,
        choice=draw.draw_element,
        gauss=draw.draw_normal,
        normalvariate=draw.draw_normal,
        seed=lambda scope, node, *seed: None,  # ignored: θ determines all draws
    ),
    **left_out(
        {
            "draw the elements one by one: Uniform(*items)": "shuffle sample",
            "write [Uniform(*items) for i in range(k)]": "choices",
            "write DiscreteRange(low, high)": "randrange",
            "write Range(low, high) or TruncatedNormal(...)": "triangular expovariate",
        }
    ),
}
SCENIC: dict[str, Value] = {
    "Point": POINT,
    "OrientedPoint": ORIENTED_POINT,
    "Object": OBJECT,
    "Vector": Builtin("Vector", vector_of, types=(Vector,)),
    **{name: MATH[name] for name in ("sin", "cos", "hypot", "sqrt", "atan2")},
    "normalizeAngle": of_table(operations.NORMALISE, "normalizeAngle"),
    "simulation": Builtin("simulation", outside_behavior, needs_context=True, over_choices=False),
}
BUILTINS: dict[str, Value] = SCENIC | DISTRIBUTIONS | REGIONS | PYTHON | NUMBERS
MODULES: dict[str, Namespace] = {
    name: Namespace(name, names)
    for name, names in {
        "math": MATH,
        "random": RANDOM,
        "pdb": {},
        "scenic.core.geometry": {"normalizeAngle": SCENIC["normalizeAngle"]} | MATH,
        "scenic.core.regions": REGIONS | needs_context(regionFromShapelyObject=no_shapely),
        "scenic.core.vectors": {"Vector": SCENIC["Vector"]} | REGIONS,
    }.items()
}
