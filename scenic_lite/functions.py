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
from scenic_lite.geometry import TURN, Vector, as_vector, normalised
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


def lifted(operation: Operation, kind: str = "number") -> Callable[..., Value]:
    """A function of numbers that also takes random ones."""
    return lambda *operands: apply(operation, *operands, kind=kind)


def least(frame: Frame, node: ast.AST, *values: Value) -> Value:
    return reduced(frame, node, MINIMUM, values)


def greatest(frame: Frame, node: ast.AST, *values: Value) -> Value:
    return reduced(frame, node, MAXIMUM, values)


def reduced(frame: Frame, node: ast.AST, operation: Operation, values: tuple) -> Value:
    items = frame.elements(values[0], node) if len(values) == 1 else list(values)
    if not items:
        raise ScenicError("value", "the least or greatest of no values")
    return reduce(lambda a, b: apply(operation, a, b), items)


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
    return apply(INTEGER, value)


def text(frame: Frame, node: ast.AST, value: Value = "") -> Value:
    return frame.text_of(value, "")


def make_list(frame: Frame, node: ast.AST, values: Value = ()) -> list:
    return kept(frame, list(frame.elements(values, node)))


def make_tuple(frame: Frame, node: ast.AST, values: Value = ()) -> tuple:
    return kept(frame, tuple(frame.elements(values, node)))


def make_set(frame: Frame, node: ast.AST, values: Value = ()) -> set:
    return kept(frame, set(frame.elements(values, node)))


def make_dictionary(frame: Frame, node: ast.AST, values: Value = ()) -> dict:
    return kept(frame, dict(values) if isinstance(values, dict) else dict(frame.elements(values, node)))


def numbered(frame: Frame, node: ast.AST, values: Value, start: int = 0) -> list:
    return kept(frame, list(enumerate(frame.elements(values, node), start)))


def zipped(frame: Frame, node: ast.AST, *several: Value) -> list:
    return kept(frame, list(zip(*(frame.elements(values, node) for values in several), strict=False)))


def backwards(frame: Frame, node: ast.AST, values: Value) -> list:
    return kept(frame, list(reversed(frame.elements(values, node))))


def ordered(frame: Frame, node: ast.AST, values: Value, key: Value = None, reverse: bool = False) -> list:
    items = frame.elements(values, node)
    keys = [frame.call(key, [item], {}, node) for item in items] if key is not None else items
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
    return RectangularRegion(vector(position), number(heading), number(width), number(length))


def disc(center: Value, radius: Value) -> Region:
    return SectorRegion(vector(center), number(radius))


def sector(center: Value, radius: Value, heading: Value, angle: Value) -> Region:
    return SectorRegion(vector(center), number(radius), number(heading), number(angle))


def polygon(frame: Frame, node: ast.AST, points: Value, orientation: Value = None) -> Region:
    corners = fixed_points(frame, node, points)
    if len(corners) < 3 or abs(signed_area(corners)) == 0:
        raise ScenicError("value", "a polygon needs three points that do not lie on a line")
    return PolygonalRegion(triangulated(corners), orientation)


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


def elementwise(scalar: Callable[..., Any], array: Callable[..., Any]) -> Callable[..., Value]:
    return lifted(Operation(scalar, array))


MATH: dict[str, Value] = {
    name: plain(name, elementwise(scalar, array))
    for name, scalar, array in (
        ("sin", math.sin, np.sin),
        ("cos", math.cos, np.cos),
        ("tan", math.tan, np.tan),
        ("asin", math.asin, np.arcsin),
        ("acos", math.acos, np.arccos),
        ("atan", math.atan, np.arctan),
        ("atan2", math.atan2, np.arctan2),
        ("sqrt", math.sqrt, np.sqrt),
        ("exp", math.exp, np.exp),
        ("log", math.log, np.log),
        ("log2", math.log2, np.log2),
        ("log10", math.log10, np.log10),
        ("fabs", math.fabs, np.abs),
        ("floor", math.floor, lambda a: INTEGER.array(np.floor(a))),
        ("ceil", math.ceil, lambda a: INTEGER.array(np.ceil(a))),
        ("hypot", math.hypot, np.hypot),
        ("radians", math.radians, np.radians),
        ("degrees", math.degrees, np.degrees),
        ("copysign", math.copysign, np.copysign),
        ("fmod", math.fmod, np.fmod),
    )
} | {"pi": math.pi, "tau": TURN, "e": math.e, "inf": math.inf, "nan": math.nan}

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
    "abs": plain("abs", lifted(ABSOLUTE)),
    "round": plain("round", lifted(ROUND)),
    "int": plain("int", integer, int),
    "float": plain("float", lifted(FLOAT), float),
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
    "Vector": plain("Vector", Vector, Vector),
    "sin": plain("sin", lifted(SINE)),
    "cos": plain("cos", lifted(COSINE)),
    "hypot": plain("hypot", lifted(HYPOTENUSE)),
    "sqrt": plain("sqrt", lifted(SQUARE_ROOT)),
    "atan2": plain("atan2", lifted(ARC_TANGENT)),
    "normalizeAngle": plain("normalizeAngle", normalised),
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
