"""The built-in functions: those of Python, distributions, regions, the modules `math` and `random`.

Nothing of Python's own is reachable but what these tables hold. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, Namespace
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.builtins import PYTHON
from scenic_lite.evaluation.math_builtins import MATH, NUMBERS, of_one, of_two
from scenic_lite.evaluation.random_module import RANDOM
from scenic_lite.language import distributions as draw
from scenic_lite.language.classes import OBJECT, ORIENTED_POINT, POINT
from scenic_lite.language.region_functions import REGIONS, number
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import Value, is_number
from scenic_lite.values.operations import ARC_TANGENT_2, COSINE, NORMALISE, SINE, SQUARE_ROOT


def no_shapely(scope: Scope, node: ast.AST, *shapes: Value) -> None:
    """What football's libraries import and programs have no use for: they have no objects of Shapely."""
    raise ScenicError("unsupported", "there are no objects of Shapely here", hint="write PolygonalRegion(points)")


def outside_behavior(scope: Scope, node: ast.AST) -> None:
    raise ScenicError("type", "simulation() has a meaning only while a behavior runs", hint="use it inside a behavior")


def vector_of(x: Value, y: Value, z: Value = 0) -> Vector:
    """`Vector(x, y)`; programs for three dimensions give a third coordinate, which must be 0."""
    if not is_number(z) or z != 0:
        raise ScenicError("unsupported", "the third coordinate of a vector must be 0 in two dimensions")
    return Vector(number(x), number(y))


# ------------------------------------------------------------ the tables


def plain(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    return Builtin(name, function, types=types)


def needs_context(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    return Builtin(name, function, needs_context=True, types=types, over_choices=False)


DISTRIBUTIONS: dict[str, Value] = {
    name: needs_context(name, function)
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
SCENIC: dict[str, Value] = {
    "Point": POINT,
    "OrientedPoint": ORIENTED_POINT,
    "Object": OBJECT,
    "Vector": plain("Vector", vector_of, Vector),
    "sin": plain("sin", of_one(SINE)),
    "cos": plain("cos", of_one(COSINE)),
    "hypot": MATH["hypot"],
    "sqrt": plain("sqrt", of_one(SQUARE_ROOT)),
    "atan2": plain("atan2", of_two(ARC_TANGENT_2)),
    "normalizeAngle": plain("normalizeAngle", of_one(NORMALISE)),
    "simulation": needs_context("simulation", outside_behavior),
}
BUILTINS: dict[str, Value] = SCENIC | DISTRIBUTIONS | REGIONS | PYTHON | NUMBERS
MODULES: dict[str, Namespace] = {
    "math": Namespace("math", MATH),
    "random": Namespace("random", RANDOM),
    "pdb": Namespace("pdb", {}),
    "scenic.core.geometry": Namespace("scenic.core.geometry", {"normalizeAngle": SCENIC["normalizeAngle"]} | MATH),
    "scenic.core.regions": Namespace(
        "scenic.core.regions",
        REGIONS | {"regionFromShapelyObject": needs_context("regionFromShapelyObject", no_shapely)},
    ),
    "scenic.core.vectors": Namespace("scenic.core.vectors", {"Vector": SCENIC["Vector"]} | REGIONS),
}
