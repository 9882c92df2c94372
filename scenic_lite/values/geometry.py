"""Vectors, angles and oriented rectangles; one code for numbers and for random values.

Headings are radians, 0 along +y, anticlockwise (spec section 6). Read next: `values.regions`; `scene.constraints`,
which tests rectangles.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from scenic_lite.values.graph import (
    ARC_TANGENT,
    COSINE,
    HYPOTENUSE,
    SINE,
    Operation,
    RandomExpr,
    Value,
    apply,
    is_number,
)

TURN = 2 * math.pi
ARC_SEGMENTS = 128  # of a circle, where one must be a polygon
CLOSENESS = 1e-9  # a point this near a boundary belongs to it


class Vector:
    """A point or displacement in the plane; each component a number or random."""

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
        """Turned anticlockwise by `angle`; exactly itself if that is 0."""
        c, s = cosine(angle), sine(angle)
        return Vector(self.x * c - self.y * s, self.x * s + self.y * c)

    def length(self) -> Value:
        return apply(HYPOTENUSE, self.x, self.y)


class Located(ABC):
    """What stands for its position where a vector is wanted."""

    @abstractmethod
    def position_vector(self) -> Vector | None:
        """The position, or None if it has none (yet)."""


def is_scalar(value: Value) -> bool:
    """Whether it is a number, fixed or random."""
    return is_number(value) or (isinstance(value, RandomExpr) and value.kind == "number")


def vector_operand(value: Value, sign: str) -> Vector:
    vector = as_vector(value)
    if vector is None:
        raise TypeError(f"`{sign}` of a vector and something that is no vector")
    return vector


def scalar_operand(value: Value, sign: str) -> Value:
    if not is_scalar(value):
        raise TypeError(f"`{sign}` of a vector needs a number on the other side")
    return value


def as_vector(value: Value) -> Vector | None:
    """A vector from what the language accepts as one: itself, a pair of numbers, anything with a position.

    Of three coordinates the third must be 0.
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


NORMALISE = Operation(
    lambda angle: angle - TURN * round(angle / TURN), lambda angle: angle - TURN * np.rint(angle / TURN)
)


def normalised(angle: Value) -> Value:
    """The same angle in [-π, π]; both ends stay as they are."""
    return apply(NORMALISE, angle)


def distance_between(start: Vector, end: Vector) -> Value:
    return (end - start).length()


def angle_between(start: Vector, end: Vector) -> Value:
    """Heading of the ray from `start` to `end`."""
    ray = end - start
    return normalised(apply(ARC_TANGENT, ray.y, ray.x) - math.pi / 2)


def corners(position: Vector, heading: Value, width: Value, length: Value) -> list[Vector]:
    """The corners of an oriented rectangle, anticlockwise from the front right."""
    signs = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    return [position + Vector(width * x, length * y).rotated(heading) for x, y in signs]


def in_sector(delta_x: Any, delta_y: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """Whether points at (delta_x, delta_y) from the apex lie in a sector; arrays [N] or scalars."""
    bearing = np.arctan2(delta_y, delta_x) - math.pi / 2 - heading
    turn = np.abs(bearing - TURN * np.rint(bearing / TURN))
    at_apex = (delta_x == 0) & (delta_y == 0)
    return (np.hypot(delta_x, delta_y) <= radius) & ((turn <= np.asarray(angle) / 2) | at_apex)


def sector_meets_rectangle(sector: tuple[Any, ...], rectangle: tuple[Any, ...]) -> Any:
    """Whether a sector (x, y, radius, heading, angle) meets a rectangle (x, y, heading, width, length).

    They meet if the apex lies in the rectangle, a corner in the sector, or an edge crosses the arc or one of the two
    straight sides. Arrays [N] or scalars; returns [N].
    """
    x, y, radius, heading, angle = sector
    cx, cy, turn, width, length = rectangle
    c, s = np.cos(turn), np.sin(turn)
    local_x, local_y = (x - cx) * c + (y - cy) * s, (y - cy) * c - (x - cx) * s
    meets = (np.abs(local_x) <= width / 2) & (np.abs(local_y) <= length / 2)
    points = []  # corners relative to the apex
    for sign_x, sign_y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        dx, dy = sign_x * width / 2, sign_y * length / 2
        points.append((cx - x + dx * c - dy * s, cy - y + dx * s + dy * c))
    for (px, py), (qx, qy) in zip(points, points[1:] + points[:1], strict=True):
        meets = meets | in_sector(px, py, radius, heading, angle)
        meets = meets | _edge_meets_arc((px, py, qx, qy), radius, heading, angle)
        for side in (heading - np.asarray(angle) / 2, heading + np.asarray(angle) / 2):
            meets = meets | _edge_meets_ray((px, py, qx, qy), -np.sin(side), np.cos(side), radius)
    return meets


def _edge_meets_arc(edge: tuple[Any, ...], radius: Any, heading: Any, angle: Any) -> Any:
    """Whether a segment crosses the circle of `radius` round the origin within the sector's angle."""
    px, py, qx, qy = edge
    dx, dy = qx - px, qy - py
    a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - radius * radius
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    meets = np.zeros(np.shape(root), dtype=bool)
    for t in ((-b - root) / np.maximum(a, 1e-300), (-b + root) / np.maximum(a, 1e-300)):
        within = in_sector(px + t * dx, py + t * dy, radius * (1 + 1e-9), heading, angle)
        meets = meets | ((b * b >= a * c) & (t >= 0) & (t <= 1) & within)
    return meets


def _edge_meets_ray(edge: tuple[Any, ...], ray_x: Any, ray_y: Any, radius: Any) -> Any:
    """Whether a segment crosses the segment of length `radius` from the origin along (ray_x, ray_y)."""
    px, py, qx, qy = edge
    side_p, side_q = ray_x * py - ray_y * px, ray_x * qy - ray_y * qx
    along_p, along_q = ray_x * px + ray_y * py, ray_x * qx + ray_y * qy
    gap = np.where(side_p == side_q, 1.0, side_p - side_q)
    along = along_p + (along_q - along_p) * side_p / gap
    return (side_p * side_q <= 0) & (side_p != side_q) & (along >= 0) & (along <= radius)


def rectangles_meet(*numbers: Any) -> Any:
    """Whether two rectangles, each (x, y, heading, width, length), have a common point; touching counts.

    They are apart exactly if they are apart along one of their four axes. Arrays of any one shape, or scalars.
    """
    ax, ay, turn_a, width_a, length_a, bx, by, turn_b, width_b, length_b = numbers
    ca, sa, cb, sb = np.cos(turn_a), np.sin(turn_a), np.cos(turn_b), np.sin(turn_b)
    c, s = np.abs(ca * cb + sa * sb), np.abs(sa * cb - ca * sb)  # of the angle between them
    dx, dy = bx - ax, by - ay
    half_a, half_b = (width_a / 2, length_a / 2), (width_b / 2, length_b / 2)
    meets = np.abs(dx * ca + dy * sa) <= half_a[0] + half_b[0] * c + half_b[1] * s
    meets = meets & (np.abs(dy * ca - dx * sa) <= half_a[1] + half_b[0] * s + half_b[1] * c)
    meets = meets & (np.abs(dx * cb + dy * sb) <= half_b[0] + half_a[0] * c + half_a[1] * s)
    return meets & (np.abs(dy * cb - dx * sb) <= half_b[1] + half_a[0] * s + half_a[1] * c)


def sector_rings(x: Any, y: Any, radius: Any, heading: Any, angle: Any, count: int = ARC_SEGMENTS) -> Any:
    """Discs or parts of one as closed polygons, arcs as chords of equal length: [N] or scalars -> [N, K, 2]."""
    x, y, radius, heading, angle = np.broadcast_arrays(*np.atleast_1d(x, y, radius, heading, angle))
    turns = heading[:, None] + np.minimum(angle, TURN)[:, None] * np.linspace(-0.5, 0.5, count + 1)
    rim_x, rim_y = x[:, None] - radius[:, None] * np.sin(turns), y[:, None] + radius[:, None] * np.cos(turns)
    whole = angle >= TURN
    first_x, first_y = np.where(whole, rim_x[:, 0], x), np.where(whole, rim_y[:, 0], y)  # a sector starts at its apex
    xs, ys = np.column_stack([first_x, rim_x, first_x]), np.column_stack([first_y, rim_y, first_y])
    return np.stack([xs, ys], axis=-1)
