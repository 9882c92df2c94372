"""Vectors, angles and oriented rectangles, for both fixed and random numbers.

Headings are in radians, 0 along +y, counterclockwise. Read next: `values.regions`; `scene.constraints`, which tests
rectangles.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Any

from scenic_lite.values.graph import RandomExpr, Value, apply, is_number
from scenic_lite.values.operations import ARC_TANGENT_2, COSINE, HYPOTENUSE, NORMALISE, SINE, Operation, quietly


class Vector:
    """A point or displacement in the plane; each component is a fixed or random number."""

    __slots__ = ("x", "y")

    def __init__(self, x: Value, y: Value) -> None:
        self.x = x
        self.y = y

    def __add__(self, other: Value) -> Vector:
        other = vector_operand(other, "+")
        return Vector(self.x + other.x, self.y + other.y)

    def __radd__(self, other: Value) -> Vector:
        return vector_operand(other, "+") + self

    def __sub__(self, other: Value) -> Vector:
        other = vector_operand(other, "-")
        return Vector(self.x - other.x, self.y - other.y)

    def __rsub__(self, other: Value) -> Vector:
        return vector_operand(other, "-") - self

    def __mul__(self, factor: Value) -> Vector:
        factor = scalar_operand(factor, "*")
        return Vector(self.x * factor, self.y * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Value) -> Vector:
        divisor = scalar_operand(divisor, "/")
        return Vector(self.x / divisor, self.y / divisor)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y)

    def __pos__(self) -> Vector:
        return self

    def __repr__(self) -> str:
        return f"({self.x} @ {self.y})"

    @property
    def fixed(self) -> bool:
        return is_number(self.x) and is_number(self.y)

    def rotated(self, angle: Value) -> Vector:
        """Return the vector rotated counterclockwise by `angle`; an angle of 0 leaves it exactly unchanged."""
        c, s = cosine(angle), sine(angle)
        return Vector(self.x * c - self.y * s, self.x * s + self.y * c)

    def length(self) -> Value:
        return apply(HYPOTENUSE, self.x, self.y)


class Located(ABC):
    """A value that can replace a vector, which is then the position of the value."""

    @abstractmethod
    def position_vector(self) -> Vector | None:
        """Return the position; None if the value has no position, or none yet."""


def is_scalar(value: Value) -> bool:
    """Return whether a value is a fixed or random number."""
    return is_number(value) or (isinstance(value, RandomExpr) and value.kind == "number")


def vector_operand(value: Value, sign: str) -> Vector:
    vector = as_vector(value)
    if vector is None:
        raise TypeError(f"`{sign}` of a vector and a value that is not a vector")
    return vector


def scalar_operand(value: Value, sign: str) -> Value:
    if not is_scalar(value):
        raise TypeError(f"`{sign}` of a vector needs a number on the other side")
    return value


def as_vector(value: Value) -> Vector | None:
    """Convert a vector, a pair of numbers or a value with a position to a vector; return None for other values.

    A third coordinate must be 0.
    """
    if isinstance(value, Vector):
        return value
    if isinstance(value, tuple | list) and len(value) == 3 and is_number(value[2]) and value[2] == 0:
        value = value[:2]
    if isinstance(value, tuple | list) and len(value) == 2 and all(is_scalar(part) for part in value):
        return Vector(value[0], value[1])
    return value.position_vector() if isinstance(value, Located) else None


def sine(angle: Value) -> Value:
    return apply(SINE, angle)


def cosine(angle: Value) -> Value:
    return apply(COSINE, angle)


def normalized(angle: Value) -> Value:
    """Return the equivalent angle in [-π, π]; -π and π stay unchanged."""
    return apply(NORMALISE, angle)


def distance_between(start: Vector, end: Vector) -> Value:
    return (end - start).length()


def angle_between(start: Vector, end: Vector) -> Value:
    """Return the heading of the ray from `start` to `end`."""
    ray = end - start
    return normalized(apply(ARC_TANGENT_2, ray.y, ray.x) - math.pi / 2)


def corners(position: Vector, heading: Value, width: Value, length: Value) -> list[Vector]:
    """Return the corners of an oriented rectangle, counterclockwise from the front right."""
    signs = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    return [position + Vector(width * x, length * y).rotated(heading) for x, y in signs]


def coordinates(points: Iterable[Vector]) -> list[Value]:
    """Return x and y of the points as one list: x, y, x, y, ..."""
    return [part for point in points for part in (point.x, point.y)]


def vector_by(function: Callable[..., tuple[Any, Any]], *operands: Value) -> Vector:
    """Return a vector; one array function computes both coordinates."""
    both = apply(Operation(quietly(function, tuple), function), *operands, kind="any")
    if isinstance(both, RandomExpr):
        return Vector(RandomExpr(x_of, (both,)), RandomExpr(y_of, (both,)))
    return Vector(*map(float, both))


def x_of(pair: Any) -> Any:
    return pair[0]


def y_of(pair: Any) -> Any:
    return pair[1]
