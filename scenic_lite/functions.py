"""The built-in functions: Python's useful ones on random values too, distributions, regions, `math`, `random`.

Nothing of Python's own is reachable but what these tables hold. Read next: `expressions`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite import distributions as draw
from scenic_lite.budget import exceeded
from scenic_lite.classes import OBJECT, ORIENTED_POINT, POINT, as_heading
from scenic_lite.errors import ScenicError
from scenic_lite.frame import Frame
from scenic_lite.geometry import NORMALISE, TURN, Vector, as_vector
from scenic_lite.graph import (
    ABSOLUTE,
    AND,
    ARC_TANGENT,
    COSINE,
    FLOAT,
    HYPOTENUSE,
    INTEGER,
    MAXIMUM,
    MINIMUM,
    OR,
    ROUND,
    SINE,
    SQUARE_ROOT,
    Operation,
    Random,
    Value,
    apply,
    as_number,
    is_number,
    kind_of,
    to_integers,
)
from scenic_lite.polygons import Point2, signed_area, triangulated
from scenic_lite.regions import (
    Everywhere,
    Nowhere,
    PointSetRegion,
    PolygonalRegion,
    PolylineRegion,
    RectangularRegion,
    Region,
    SectorRegion,
    VectorField,
)
from scenic_lite.values import Builtin, Choice, Instance, Namespace, ScenicClass, describe_kind


def of_one(operation: Operation) -> Callable[[Value], Value]:
    """A function of one number that also takes a random one."""
    return lambda x: numeric(operation, x)


def of_two(operation: Operation) -> Callable[[Value, Value], Value]:
    return lambda x, y: numeric(operation, x, y)


def numeric(operation: Operation, *operands: Value) -> Value:
    for operand in operands:
        if kind_of(operand) not in ("number", "truth"):
            raise ScenicError("type", f"a number is needed here, not {describe_kind(operand)}")
    return apply(operation, *(as_number(operand) for operand in operands))


def rounded(value: Value, digits: Value = None) -> Value:
    if digits is None:
        return numeric(ROUND, value)
    if not isinstance(digits, int) or abs(digits) > 300:
        raise ScenicError("type", f"the number of digits must be a fixed integer, not {describe_kind(digits)}")
    return numeric(Operation(lambda x: round(x, digits), lambda x: np.round(x, digits)), value)


def least(frame: Frame, node: ast.AST, *values: Value) -> Value:
    return reduced(frame, node, MINIMUM, values)


def greatest(frame: Frame, node: ast.AST, *values: Value) -> Value:
    return reduced(frame, node, MAXIMUM, values)


def reduced(frame: Frame, node: ast.AST, operation: Operation, values: tuple) -> Value:
    items = frame.elements(values[0], node) if len(values) == 1 else list(values)
    if not items:
        raise ScenicError("value", "the least or greatest of no values")
    if all(isinstance(item, str) for item in items):
        return operation.scalar(items)
    return reduce(lambda a, b: numeric(operation, a, b), items)


def total(frame: Frame, node: ast.AST, values: Value, start: Value = 0) -> Value:
    items = frame.elements(values, node)
    if isinstance(start, list | tuple):
        frame.session.budget.container(len(start) + sum(len(item) for item in items))
    return reduce(lambda a, b: a + b, items, start)


def every(frame: Frame, node: ast.AST, values: Value) -> Value:
    return reduce(lambda a, b: apply(AND, a, b, kind="truth"), frame.elements(values, node), True)


def some(frame: Frame, node: ast.AST, values: Value) -> Value:
    return reduce(lambda a, b: apply(OR, a, b, kind="truth"), frame.elements(values, node), False)


def length(frame: Frame, node: ast.AST, value: Value) -> Value:
    if isinstance(value, Choice):
        return value.merged([length(frame, node, option) for option in value.options])
    return len(frame.elements(value, node) if not isinstance(value, str | dict | set | range) else value)


def integer_range(frame: Frame, node: ast.AST, *ends: Value) -> range:
    for end in ends:
        frame.refuse_random(end, node, "a range cannot have random ends")
    numbers = range(*ends)
    try:
        length = len(numbers)
    except OverflowError:
        raise exceeded("a range of more elements than can be counted") from None
    if length > frame.session.budget.limits.elements:
        frame.session.budget.container(length)
    return numbers


def integer(value: Value) -> Value:
    if isinstance(value, str) and len(value) > 1000:
        raise ScenicError("budget", "evaluation budget exceeded: a text of more than 1000 digits for one integer")
    if isinstance(value, str):
        return int(value)
    return numeric(INTEGER, value)


def decimal(value: Value) -> Value:
    return float(value) if isinstance(value, str) else numeric(FLOAT, value)


def text(frame: Frame, node: ast.AST, value: Value = "") -> Value:
    return frame.text_of(value, "")


def make_list(frame: Frame, node: ast.AST, values: Value = ()) -> list:
    return kept(frame, list(frame.elements(values, node)))


def make_tuple(frame: Frame, node: ast.AST, values: Value = ()) -> tuple:
    return kept(frame, tuple(frame.elements(values, node)))


def make_set(frame: Frame, node: ast.AST, values: Value = ()) -> set:
    elements = frame.elements(values, node)
    frame.session.budget.whole(elements)
    return kept(frame, set(elements))


def make_dictionary(frame: Frame, node: ast.AST, values: Value = ()) -> dict:
    if isinstance(values, dict):
        return kept(frame, dict(values))
    pairs = frame.elements(values, node)
    frame.session.budget.whole(pairs)
    return kept(frame, dict(pairs))


def numbered(frame: Frame, node: ast.AST, values: Value, start: int = 0) -> list:
    return kept(frame, list(enumerate(frame.elements(values, node), start)))


def zipped(frame: Frame, node: ast.AST, *several: Value) -> list:
    return kept(frame, list(zip(*(frame.elements(values, node) for values in several), strict=False)))


def backwards(frame: Frame, node: ast.AST, values: Value) -> list:
    return kept(frame, list(reversed(frame.elements(values, node))))


def ordered(frame: Frame, node: ast.AST, values: Value, key: Value = None, reverse: bool = False) -> list:
    items = frame.elements(values, node)
    keys = [frame.call(key, [item], {}, node) for item in items] if key is not None else items
    frame.session.budget.whole(keys)
    for each in keys:
        frame.refuse_random(each, node, "random values cannot be sorted")
    order = sorted(range(len(items)), key=lambda i: keys[i], reverse=bool(reverse))
    return kept(frame, [items[i] for i in order])


def mapped(frame: Frame, node: ast.AST, function: Value, values: Value) -> list:
    return kept(frame, [frame.call(function, [item], {}, node) for item in frame.elements(values, node)])


def filtered(frame: Frame, node: ast.AST, function: Value, values: Value) -> list:
    items = frame.elements(values, node)
    return [item for item in items if frame.certain_truth(frame.call(function, [item], {}, node), node)]


def kept(frame: Frame, value: Any) -> Any:
    frame.session.budget.keep(value)
    return value


def is_instance(value: Value, types: Value) -> bool:
    for each in types if isinstance(types, tuple) else (types,):
        if isinstance(each, ScenicClass) and isinstance(value, Instance) and value.cls.derives_from(each):
            return True
        if isinstance(each, Builtin) and each.types and isinstance(value, each.types):
            return True
        if not isinstance(each, ScenicClass) and not (isinstance(each, Builtin) and each.types):
            raise ScenicError("type", f"isinstance needs a class, not {describe_kind(each)}")
    return False


def truth(frame: Frame, node: ast.AST, value: Value = False) -> Value:
    if frame.session.in_requirement and isinstance(value, Random):
        return apply(Operation(bool, lambda array: np.asarray(array) != 0), value, kind="truth")
    return frame.certain_truth(value, node)


def nothing(*values: Value) -> None:
    """`print`: a program that is loaded has nobody to talk to."""


def outside_behavior(frame: Frame, node: ast.AST) -> None:
    raise ScenicError("type", "simulation() has a meaning only while a behavior runs", hint="use it inside a behavior")


# ------------------------------------------------------------ regions


def rectangle(position: Value, heading: Value, width: Value, length: Value) -> Region:
    return RectangularRegion(vector(position), number(heading), size("width", width), size("length", length))


def disc(center: Value, radius: Value) -> Region:
    return SectorRegion(vector(center), size("radius", radius))


def sector(center: Value, radius: Value, heading: Value, angle: Value) -> Region:
    return SectorRegion(vector(center), size("radius", radius), number(heading), number(angle))


def size(name: str, value: Value) -> Value:
    """A length of a region; 0 is a region of one point or line."""
    extent = number(value)
    if is_number(extent) and not 0 <= extent < math.inf:
        raise ScenicError("value", f"the {name} of a region must be finite and not negative, not {extent}")
    return extent


def polygon(frame: Frame, node: ast.AST, points: Value, orientation: Value = None) -> Region:
    corners = fixed_points(frame, node, points)
    if len(corners) < 3 or abs(signed_area(corners)) == 0:
        raise ScenicError("value", "a polygon needs three points that do not lie on a line")
    return PolygonalRegion(triangulated(corners), orientation, corners)


def polyline(frame: Frame, node: ast.AST, points: Value) -> Region:
    return PolylineRegion(fixed_points(frame, node, points))


def point_set(frame: Frame, node: ast.AST, name: str, points: Value) -> Region:
    return PointSetRegion(fixed_points(frame, node, points))


def workspace(region: Value = None) -> Region:
    if region is None:
        return Everywhere()
    if not isinstance(region, Region):
        raise ScenicError("type", f"a workspace is made of a region, not {describe_kind(region)}")
    return region


def vector_field(frame: Frame, node: ast.AST, name: str, function: Value) -> VectorField:
    return VectorField(name, lambda point: number(frame.call(function, [point], {}, node)))


def vector(value: Value) -> Vector:
    result = as_vector(value)
    if result is None:
        raise ScenicError("type", f"a vector is needed here, not {describe_kind(value)}")
    return result


def number(value: Value) -> Value:
    heading = as_heading(value)
    if heading is None:
        raise ScenicError("type", f"a number is needed here, not {describe_kind(value)}")
    return heading


def fixed_points(frame: Frame, node: ast.AST, points: Value) -> list[Point2]:
    vectors = [vector(point) for point in frame.elements(points, node)]
    if not all(each.fixed for each in vectors):
        raise ScenicError("unsupported", "the points of this region must not be random")
    return [(float(each.x), float(each.y)) for each in vectors]


# ------------------------------------------------------------ the tables


def plain(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    return Builtin(name, function, types=types)


def sited(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    return Builtin(name, function, sited=True, types=types, lifted=False)


MATH_OF_ONE: tuple[tuple[Callable[[float], Any], Callable[[Any], Any]], ...] = (
    (math.sin, np.sin),
    (math.cos, np.cos),
    (math.tan, np.tan),
    (math.asin, np.arcsin),
    (math.acos, np.arccos),
    (math.atan, np.arctan),
    (math.sqrt, np.sqrt),
    (math.exp, np.exp),
    (math.log, np.log),
    (math.log2, np.log2),
    (math.log10, np.log10),
    (math.fabs, np.abs),
    (math.floor, lambda x: to_integers(np.floor(x))),
    (math.ceil, lambda x: to_integers(np.ceil(x))),
    (math.radians, np.radians),
    (math.degrees, np.degrees),
)
MATH_OF_TWO: tuple[tuple[Callable[[float, float], Any], Callable[[Any, Any], Any]], ...] = (
    (math.atan2, np.arctan2),
    (math.hypot, np.hypot),
    (math.copysign, np.copysign),
    (math.fmod, np.fmod),
)
MATH: dict[str, Value] = {
    **{scalar.__name__: plain(scalar.__name__, of_one(Operation(scalar, array))) for scalar, array in MATH_OF_ONE},
    **{scalar.__name__: plain(scalar.__name__, of_two(Operation(scalar, array))) for scalar, array in MATH_OF_TWO},
    "pi": math.pi,
    "tau": TURN,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
}

DISTRIBUTIONS: dict[str, Value] = {
    name: sited(name, function)
    for name, function in (
        ("Range", draw.draw_range),
        ("VerifaiRange", draw.draw_range),
        ("Uniform", draw.draw_uniform),
        ("Discrete", draw.draw_discrete),
        ("Options", draw.draw_discrete),
        ("VerifaiOptions", draw.draw_discrete),
        ("DiscreteRange", draw.draw_integers),
        ("VerifaiDiscreteRange", draw.draw_integers),
        ("Normal", draw.draw_normal),
        ("TruncatedNormal", draw.draw_truncated_normal),
        ("resample", draw.resample),
    )
}
REGIONS: dict[str, Value] = {
    "RectangularRegion": plain("RectangularRegion", rectangle, RectangularRegion),
    "CircularRegion": plain("CircularRegion", disc, SectorRegion),
    "SectorRegion": plain("SectorRegion", sector, SectorRegion),
    "PolygonalRegion": sited("PolygonalRegion", polygon, PolygonalRegion),
    "PolylineRegion": sited("PolylineRegion", polyline, PolylineRegion),
    "PointSetRegion": sited("PointSetRegion", point_set, PointSetRegion),
    "Region": plain("Region", workspace, Region),
    "Workspace": plain("Workspace", workspace, Region),
    "VectorField": sited("VectorField", vector_field, VectorField),
    "everywhere": Everywhere(),
    "nowhere": Nowhere(),
}
# Python's `random` where a program imports it: each call is one more draw.
RANDOM: dict[str, Value] = {
    "uniform": sited("uniform", draw.draw_range),
    "randint": sited("randint", draw.draw_integers),
    "gauss": sited("gauss", draw.draw_normal),
    "normalvariate": sited("normalvariate", draw.draw_normal),
    "random": sited("random", lambda frame, node: draw.draw_range(frame, node, 0, 1)),
    "choice": sited("choice", lambda frame, node, items: draw.draw_uniform(frame, node, *frame.elements(items, node))),
}
PYTHON: dict[str, Value] = {
    "abs": plain("abs", of_one(ABSOLUTE)),
    "round": plain("round", rounded),
    "int": plain("int", integer, int),
    "float": plain("float", decimal, float),
    "bool": sited("bool", truth, bool),
    "str": sited("str", text, str),
    "min": sited("min", least),
    "max": sited("max", greatest),
    "sum": sited("sum", total),
    "all": sited("all", every),
    "any": sited("any", some),
    "len": sited("len", length),
    "range": sited("range", integer_range, range),
    "list": sited("list", make_list, list),
    "tuple": sited("tuple", make_tuple, tuple),
    "set": sited("set", make_set, set),
    "dict": sited("dict", make_dictionary, dict),
    "enumerate": sited("enumerate", numbered),
    "zip": sited("zip", zipped),
    "reversed": sited("reversed", backwards),
    "sorted": sited("sorted", ordered),
    "map": sited("map", mapped),
    "filter": sited("filter", filtered),
    "isinstance": Builtin("isinstance", is_instance, lifted=False),
    "print": Builtin("print", nothing, lifted=False),
}
SCENIC: dict[str, Value] = {
    "Point": POINT,
    "OrientedPoint": ORIENTED_POINT,
    "Object": OBJECT,
    "Vector": plain("Vector", lambda x, y: Vector(number(x), number(y)), Vector),
    "sin": plain("sin", of_one(SINE)),
    "cos": plain("cos", of_one(COSINE)),
    "hypot": plain("hypot", of_two(HYPOTENUSE)),
    "sqrt": plain("sqrt", of_one(SQUARE_ROOT)),
    "atan2": plain("atan2", of_two(ARC_TANGENT)),
    "normalizeAngle": plain("normalizeAngle", of_one(NORMALISE)),
    "simulation": sited("simulation", outside_behavior),
}
BUILTINS: dict[str, Value] = SCENIC | DISTRIBUTIONS | REGIONS | PYTHON
MODULES: dict[str, Namespace] = {
    "math": Namespace("math", MATH),
    "random": Namespace("random", RANDOM),
    "pdb": Namespace("pdb", {}),
    "scenic.core.geometry": Namespace("scenic.core.geometry", {"normalizeAngle": SCENIC["normalizeAngle"]} | MATH),
    "scenic.core.regions": Namespace("scenic.core.regions", REGIONS),
}
