"""The built-in functions: those of Python, distributions, regions, the modules `math` and `random`.

Nothing of Python's own is reachable but what these tables hold. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import ast

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, Namespace, needs_context
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.builtins import PYTHON, left_out
from scenic_lite.evaluation.math_builtins import MATH, NUMBERS, of_one, of_two
from scenic_lite.language import distributions as draw
from scenic_lite.language.classes import OBJECT, ORIENTED_POINT, POINT, number_of
from scenic_lite.language.regions import REGIONS
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
    return Vector(number_of(x), number_of(y))


def random_unit(scope: Scope, node: ast.AST) -> Value:
    """`random.random()`."""
    return draw.draw_range(scope, node, 0, 1)


def random_choice(scope: Scope, node: ast.AST, seq: Value) -> Value:
    """`random.choice(seq)`."""
    return draw.draw_uniform(scope, node, *scope.elements(seq, node))


# ------------------------------------------------------------ the tables


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
RANDOM: dict[str, Value] = {  # Python's module, where a program imports it: each call draws from θ
    **needs_context(
        uniform=draw.draw_range,
        random=random_unit,
        randint=draw.draw_integers,
        choice=random_choice,
        gauss=draw.draw_normal,
        normalvariate=draw.draw_normal,
        seed=lambda scope, node, *seed: None,  # whoever draws θ decides that
    ),
    "shuffle": left_out("shuffle", "draw the elements one by one: Uniform(*items)"),
    "sample": left_out("sample", "draw the elements one by one: Uniform(*items)"),
    "choices": left_out("choices", "write [Uniform(*items) for i in range(k)]"),
    "randrange": left_out("randrange", "write DiscreteRange(low, high)"),
    "triangular": left_out("triangular", "write Range(low, high) or TruncatedNormal(...)"),
    "expovariate": left_out("expovariate", "write Range(low, high) or TruncatedNormal(...)"),
}
RARE_MATH: dict[str, Value] = {
    "isclose": left_out("isclose", "write abs(a - b) < 1e-9"),
    "isqrt": left_out("isqrt", "write math.floor(math.sqrt(x))"),
    "modf": left_out("modf", "write x - math.trunc(x) and math.trunc(x)"),
    "fsum": left_out("fsum", "write sum(...)"),
    **{name: left_out(name, "write a function with a loop") for name in ("prod", "factorial", "comb", "gcd", "lcm")},
}
SCENIC: dict[str, Value] = {
    "Point": POINT,
    "OrientedPoint": ORIENTED_POINT,
    "Object": OBJECT,
    "Vector": Builtin("Vector", vector_of, types=(Vector,)),
    "sin": Builtin("sin", of_one(SINE)),
    "cos": Builtin("cos", of_one(COSINE)),
    "hypot": MATH["hypot"],
    "sqrt": Builtin("sqrt", of_one(SQUARE_ROOT)),
    "atan2": Builtin("atan2", of_two(ARC_TANGENT_2)),
    "normalizeAngle": Builtin("normalizeAngle", of_one(NORMALISE)),
    "simulation": Builtin("simulation", outside_behavior, needs_context=True, over_choices=False),
}
BUILTINS: dict[str, Value] = SCENIC | DISTRIBUTIONS | REGIONS | PYTHON | NUMBERS
MODULES: dict[str, Namespace] = {
    "math": Namespace("math", MATH | RARE_MATH),
    "random": Namespace("random", RANDOM),
    "pdb": Namespace("pdb", {}),
    "scenic.core.geometry": Namespace("scenic.core.geometry", {"normalizeAngle": SCENIC["normalizeAngle"]} | MATH),
    "scenic.core.regions": Namespace(
        "scenic.core.regions",
        REGIONS | needs_context(regionFromShapelyObject=no_shapely),
    ),
    "scenic.core.vectors": Namespace("scenic.core.vectors", {"Vector": SCENIC["Vector"]} | REGIONS),
}
