"""Regions of the plane: where points are drawn from and objects must stay; vector fields.

Every region makes a point of two uniform numbers (so a point costs two columns of θ; one on a line), and says whether
points and rectangles lie in it. Parameters may be random except those of polygons. Spec section 8. Read next:
`polygons`, `specifiers`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from scenic_lite import polygons
from scenic_lite.errors import ScenicError
from scenic_lite.geometry import TURN, Vector, cosine, in_sector, sine
from scenic_lite.graph import AND, MAXIMUM, NOT, Operation, Random, Value, apply, is_number
from scenic_lite.polygons import CLOSENESS, Point2

ARC_SEGMENTS = 128  # of a full circle, where one must be made a polygon


class VectorField:
    """A heading for every point; `heading_at` is given a vector."""

    def __init__(self, name: str, heading_at: Callable[[Vector], Value]) -> None:
        self.name = name
        self.heading_at = heading_at


class Region:
    """What every region can do."""

    orientation: VectorField | None = None
    columns = 2  # of θ, for a point drawn from it

    def scales(self) -> list[tuple[float, float]]:
        """Offset and span of the numbers that `point` wants, for each column."""
        return [(0.0, 1.0)] * self.columns

    def point(self, u: Value, v: Value) -> Vector:
        """The point for two uniform numbers, scaled as `scales` says."""
        raise NotImplementedError

    def uniforms(self, point: Vector) -> tuple[Any, ...] | None:
        """The numbers in [0, 1] from which `point` would make a known point (arrays [N]), one for each column.

        nan outside the region. None if there is no such inverse: they are searched for then.
        """
        return None

    def heading_of(self, point: Vector, u: Value) -> Value:
        """The orientation at a point that was drawn with `u`; None if the region has none."""
        return self.orientation.heading_at(point) if self.orientation else None

    def contains(self, point: Vector) -> Value:
        raise NotImplementedError

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Whether a rectangle lies inside, given its corners: exact for convex regions."""
        inside = self.contains(corners[0])
        for corner in corners[1:]:
            inside = apply(AND, inside, self.contains(corner), kind="truth")
        return inside

    def distance(self, point: Vector) -> Value:
        """From a point, 0 inside."""
        pieces = self.pieces()
        measure = Operation(
            lambda x, y: float(polygons.distance_to_pieces(pieces, x, y)),
            lambda x, y: polygons.distance_to_pieces(pieces, x, y),
        )
        return apply(measure, point.x, point.y)

    def pieces(self) -> list[list[Point2]]:
        """Convex pieces that tile it (arcs as polygons). Raises ScenicError where it is random or endless."""
        raise ScenicError("unsupported", f"{type(self).__name__} cannot be combined with another region here")

    def bounds(self) -> tuple[float, float, float, float] | None:
        """Low x, high x, low y, high y; None if random or endless."""
        try:
            points = [point for piece in self.pieces() for point in piece]
        except ScenicError:
            return None
        xs, ys = [x for x, _ in points], [y for _, y in points]
        return min(xs), max(xs), min(ys), max(ys)


class RectangularRegion(Region):
    def __init__(self, position: Vector, heading: Value, width: Value, length: Value) -> None:
        self.position, self.heading, self.width, self.length = position, heading, width, length

    def fixed(self) -> bool:
        return self.position.fixed and all(is_number(part) for part in (self.heading, self.width, self.length))

    def scales(self) -> list[tuple[float, float]]:
        if not self.fixed():
            return [(0.0, 1.0)] * 2
        if self.heading == 0:  # straight into the program's coordinates, so that no operation is left to do
            x, y = self.position.x, self.position.y
            return [(x - self.width / 2, self.width), (y - self.length / 2, self.length)]
        return [(-self.width / 2, self.width), (-self.length / 2, self.length)]

    def point(self, u: Value, v: Value) -> Vector:
        if self.fixed():
            return Vector(u, v) if self.heading == 0 else self.position + Vector(u, v).rotated(self.heading)
        offset = Vector((u - 0.5) * self.width, (v - 0.5) * self.length)
        return self.position + offset.rotated(self.heading)

    def contains(self, point: Vector) -> Value:
        frame = (self.position.x, self.position.y, self.heading, self.width, self.length)
        return truth_of(in_rectangle, point.x, point.y, *frame)

    def pieces(self) -> list[list[Point2]]:
        if not self.fixed():
            return super().pieces()
        signs = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
        offsets = [Vector(x * self.width, y * self.length).rotated(self.heading) for x, y in signs]
        return [[(self.position.x + offset.x, self.position.y + offset.y) for offset in offsets]]


class SectorRegion(Region):
    """A disc, or the part of one within `angle` / 2 of `heading`."""

    def __init__(self, center: Vector, radius: Value, heading: Value = 0.0, angle: Value = TURN) -> None:
        self.center, self.radius, self.heading, self.angle = center, radius, heading, angle

    def point(self, u: Value, v: Value) -> Vector:
        turn = self.heading + (v - 0.5) * self.angle
        reach = self.radius * apply(ROOT, u)
        return Vector(self.center.x - reach * sine(turn), self.center.y + reach * cosine(turn))

    def contains(self, point: Vector) -> Value:
        delta = point - self.center
        reach = self.radius + CLOSENESS
        return truth_of(in_sector, delta.x, delta.y, reach, self.heading, self.angle)

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Exact, also where the sector is more than half a disc and so not convex."""
        inside = super().contains_corners(corners)
        if is_number(self.angle) and (self.angle <= math.pi or self.angle >= TURN):
            return inside
        sides = [self.heading + self.angle * 0.5, self.heading - self.angle * 0.5]
        for side in sides:
            end = Vector(self.center.x - self.radius * sine(side), self.center.y + self.radius * cosine(side))
            numbers = [part for each in (self.center, end, *corners) for part in (each.x, each.y)]
            inside = apply(AND, inside, truth_of(stays_aside, *numbers), kind="truth")
        return inside

    def distance(self, point: Vector) -> Value:
        if is_number(self.angle) and self.angle >= TURN:
            return apply(MAXIMUM, (point - self.center).length() - self.radius, 0.0)
        return super().distance(point)

    def pieces(self) -> list[list[Point2]]:
        parts = (self.center.x, self.center.y, self.radius, self.heading, self.angle)
        if not all(is_number(part) for part in parts):
            return super().pieces()
        whole = self.angle >= TURN
        count = max(2, math.ceil(ARC_SEGMENTS * min(self.angle, TURN) / TURN))
        turns = [self.heading + self.angle * (i / count - 0.5) for i in range(count + (not whole))]
        rim = [(self.center.x - self.radius * math.sin(t), self.center.y + self.radius * math.cos(t)) for t in turns]
        if whole:
            return [rim]
        apex = (self.center.x, self.center.y)
        half = len(rim) // 2  # two fans of at most half a turn each, so that both are convex
        return [[apex, *rim[: half + 1]], [apex, *rim[half:]]]


class PolygonalRegion(Region):
    """A fixed polygon, or any set of convex pieces."""

    def __init__(
        self,
        pieces: list[list[Point2]],
        orientation: VectorField | None = None,
        ring: list[Point2] | None = None,
    ) -> None:
        """`ring` is the boundary, where it is one polygon."""
        if not pieces:
            raise ScenicError("value", "the region is empty")
        self._pieces, self._ring = pieces, ring
        self.orientation = orientation

    @cached_property
    def _sampler(self) -> polygons.PieceSampler:
        return polygons.PieceSampler(self._pieces)

    def point(self, u: Value, v: Value) -> Vector:
        both = Random(self._sampler, (u, v), "any")
        return Vector(Random(first, (both,)), Random(second, (both,)))

    def contains(self, point: Vector) -> Value:
        return truth_of(polygons.PieceMembership(self._pieces), point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Exact where the boundary is known, also for polygons that are not convex."""
        inside = super().contains_corners(corners)
        if self._ring is None:
            return inside
        numbers = [part for corner in corners for part in (corner.x, corner.y)]
        crossed = truth_of(polygons.EdgesCross(self._ring), *numbers)
        return apply(AND, inside, apply(NOT, crossed, kind="truth"), kind="truth")

    def pieces(self) -> list[list[Point2]]:
        return self._pieces


class PolylineRegion(Region):
    """A chain of segments; its orientation is the heading of each."""

    columns = 1

    def __init__(self, points: list[Point2]) -> None:
        self.points = np.array(points, dtype=float)
        steps = np.diff(self.points, axis=0)
        lengths = np.hypot(steps[:, 0], steps[:, 1])
        if not lengths.sum() > 0:
            raise ScenicError("value", "a polyline needs at least two different points")
        self.ends = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
        self.headings = np.arctan2(steps[:, 1], steps[:, 0]) - math.pi / 2
        self.orientation = VectorField("the polyline's direction", self._heading_near)

    def _segment(self, u: Any) -> Any:
        return np.clip(np.searchsorted(self.ends, u, side="right") - 1, 0, len(self.headings) - 1)

    def _x(self, u: Any) -> Any:
        return np.interp(u, self.ends, self.points[:, 0])

    def _y(self, u: Any) -> Any:
        return np.interp(u, self.ends, self.points[:, 1])

    def _heading(self, u: Any) -> Any:
        return self.headings[self._segment(u)]

    def point(self, u: Value, v: Value) -> Vector:
        return Vector(Random(self._x, (u,)), Random(self._y, (u,)))

    def heading_of(self, point: Vector, u: Value) -> Value:
        return Random(self._heading, (u,))

    def _distances(self, x: Any, y: Any) -> Any:
        """Distance of each point from each segment, [..., S]."""
        x, y = np.asarray(x)[..., None], np.asarray(y)[..., None]
        start, step = self.points[:-1], np.diff(self.points, axis=0)
        along = ((x - start[:, 0]) * step[:, 0] + (y - start[:, 1]) * step[:, 1]) / np.sum(step * step, axis=1)
        along = np.clip(along, 0.0, 1.0)
        return np.hypot(x - start[:, 0] - along * step[:, 0], y - start[:, 1] - along * step[:, 1])

    def _heading_near(self, point: Vector) -> Value:
        def nearest(x: Any, y: Any) -> Any:
            return self.headings[np.argmin(self._distances(x, y), axis=-1)]

        return apply(Operation(lambda x, y: float(nearest(x, y)), nearest), point.x, point.y)

    def contains(self, point: Vector) -> Value:
        def near(x: Any, y: Any) -> Any:
            return self._distances(x, y).min(axis=-1) <= 1e-6

        return truth_of(near, point.x, point.y)

    def bounds(self) -> tuple[float, float, float, float]:
        (low_x, low_y), (high_x, high_y) = self.points.min(axis=0), self.points.max(axis=0)
        return float(low_x), float(high_x), float(low_y), float(high_y)


class PointSetRegion(Region):
    columns = 1

    def __init__(self, points: list[Point2]) -> None:
        if not points:
            raise ScenicError("value", "the region is empty")
        self.points = np.array(points, dtype=float)

    def _pick(self, axis: int) -> Callable[[Any], Any]:
        count = len(self.points)
        return lambda u: self.points[np.minimum((u * count).astype(np.int64), count - 1), axis]

    def point(self, u: Value, v: Value) -> Vector:
        return Vector(Random(self._pick(0), (u,)), Random(self._pick(1), (u,)))

    def contains(self, point: Vector) -> Value:
        def near(x: Any, y: Any) -> Any:
            gaps = np.hypot(np.asarray(x)[..., None] - self.points[:, 0], np.asarray(y)[..., None] - self.points[:, 1])
            return gaps.min(axis=-1) <= 1e-6

        return truth_of(near, point.x, point.y)


class Everywhere(Region):
    def point(self, u: Value, v: Value) -> Vector:
        raise ScenicError("value", "a point cannot be drawn from everywhere", hint="name a bounded region")

    def contains(self, point: Vector) -> Value:
        return True


class Nowhere(Region):
    def point(self, u: Value, v: Value) -> Vector:
        raise ScenicError("value", "a point cannot be drawn from nowhere")

    def contains(self, point: Vector) -> Value:
        return False


class Filtered(Region):
    """The points of `region` that pass a test: drawn from `region`, and scenes that fail are rejected.

    For intersections and differences that are no polygons. Drawing adds `test` to the program's requirements.
    """

    def __init__(self, region: Region, test: Callable[[Vector], Value]) -> None:
        self.region, self.test = region, test
        self.columns = region.columns
        self.orientation = region.orientation

    def scales(self) -> list[tuple[float, float]]:
        return self.region.scales()

    def point(self, u: Value, v: Value) -> Vector:
        return self.region.point(u, v)

    def heading_of(self, point: Vector, u: Value) -> Value:
        return self.region.heading_of(point, u)

    def contains(self, point: Vector) -> Value:
        return apply(AND, self.region.contains(point), self.test(point), kind="truth")


ROOT = Operation(math.sqrt, np.sqrt)


def truth_of(test: Callable[..., Any], *operands: Value) -> Value:
    """A test written for arrays, on numbers or random values."""
    return apply(Operation(quietly(test), test), *operands, kind="truth")


def quietly(test: Callable[..., Any]) -> Callable[..., bool]:
    """The same test on numbers; what is infinite is in no region, and no reason for a warning."""

    def of_numbers(*numbers: Value) -> bool:
        with np.errstate(all="ignore"):
            return bool(test(*numbers))

    return of_numbers


def in_rectangle(x: Any, y: Any, cx: Any, cy: Any, heading: Any, width: Any, length: Any) -> Any:
    """Whether points lie in an oriented rectangle, edges included; arrays [N] or scalars."""
    c, s = np.cos(heading), np.sin(heading)
    across = (x - cx) * c + (y - cy) * s
    along = (y - cy) * c - (x - cx) * s
    return (np.abs(across) <= width / 2 + CLOSENESS) & (np.abs(along) <= length / 2 + CLOSENESS)


def stays_aside(x: Any, y: Any, end_x: Any, end_y: Any, *corners: Any) -> Any:
    """Whether no edge of a rectangle crosses the segment from (x, y) to (end_x, end_y)."""
    return np.logical_not(polygons.EdgesCross([(x, y), (end_x, end_y)])(*corners))


def first(pair: Any) -> Any:
    return pair[0]


def second(pair: Any) -> Any:
    return pair[1]
