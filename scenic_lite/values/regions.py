"""Regions of the plane, which generate points and contain objects: rectangles, discs and sectors.

Every region maps two uniform numbers to a point, so a point takes two columns of θ (one column on a line). Every region
also tests whether it contains points and rectangles.
Read next: `values.lines`, regions without area; `values.polygons`, regions of any shape; `language.fields`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError
from scenic_lite.values import shapes
from scenic_lite.values.formulas import CLOSENESS, TURN, sector_rings
from scenic_lite.values.geometry import Vector, coordinates, corners, cosine, sine
from scenic_lite.values.graph import Value, all_of, apply, is_number, number_by, truth_by
from scenic_lite.values.operations import IN_RECTANGLE, IN_SECTOR, MAXIMUM, SQUARE_ROOT, WHERE

Point2 = tuple[float, float]


class VectorField:
    """A heading for every point, from `heading_at(vector)`. Steps along the field are at most `longest_step` long."""

    def __init__(
        self, name: str, heading_at: Callable[[Vector], Value], least_steps: int = 4, longest_step: float | None = 5.0
    ) -> None:
        self.name, self.heading_at = name, heading_at
        self.least_steps, self.longest_step = least_steps, longest_step


class Region:
    """The interface of all regions."""

    orientation: VectorField | None = None
    columns = 2  # number of columns of θ for a point drawn from the region
    dimension = 2

    def scales(self) -> list[tuple[float, float]]:
        """Return the offset and span of each argument of `point`."""
        return [(0.0, 1.0)] * self.columns

    def point(self, u: Value, v: Value) -> Vector:
        """Return the point for two uniform numbers, scaled as `scales` specifies."""
        raise NotImplementedError

    def heading_of(self, point: Vector, u: Value) -> Value:
        """Return the orientation at a point drawn with `u`; None if the region has no orientation."""
        return self.orientation.heading_at(point) if self.orientation else None

    def contains(self, point: Vector) -> Value:
        raise NotImplementedError

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Return whether the region contains a rectangle with these corners; touching the boundary is allowed."""
        return all_of(*(self.contains(corner) for corner in corners))

    def distance(self, point: Vector) -> Value:
        """Return the distance of a point from the region, 0 inside. Raises ScenicError for an unbounded region."""
        return number_by(shapes.distances, self.shape(), point.x, point.y)

    def shape(self) -> Value:
        """Return the shapely geometry (arcs as chords), or a node of such. Raises ScenicError if there is none."""
        raise ScenicError("unsupported", f"{type(self).__name__} cannot be combined with another region here")

    def bounds(self) -> tuple[float, float, float, float] | None:
        """Return low x, high x, low y, high y; None for a random or unbounded region."""
        try:
            points = np.concatenate(self.outlines())
        except ScenicError:
            return None
        (low_x, low_y), (high_x, high_y) = points.min(axis=0), points.max(axis=0)
        return float(low_x), float(high_x), float(low_y), float(high_y)

    def outlines(self) -> list[Any]:
        """Return the boundary as lines, each [n, 2]. Raises ScenicError for a random or unbounded region."""
        raise ScenicError("unsupported", f"{type(self).__name__} has no fixed outline")

    def vertices(self) -> list[Point2] | None:
        """Return the points of a polyline, for `len` and iteration; None for other regions."""
        return None

    def fixed(self) -> bool:
        """Return whether the region is the same in every scene."""
        return all(is_number(part) for part in self.parameters())

    def parameters(self) -> tuple[Value, ...]:
        """Return the parts of the region that may be random."""
        return ()


class RectangularRegion(Region):
    def __init__(self, position: Vector, heading: Value, width: Value, length: Value) -> None:
        self.position, self.heading, self.width, self.length = position, heading, width, length

    def parameters(self) -> tuple[Value, ...]:
        return self.position.x, self.position.y, self.heading, self.width, self.length

    def corners(self) -> list[Vector]:
        return corners(self.position, self.heading, self.width, self.length)

    def scales(self) -> list[tuple[float, float]]:
        if not self.fixed():
            return [(0.0, 1.0)] * 2
        if self.heading == 0:  # the columns are the coordinates themselves, which saves operations
            x, y = self.position.x, self.position.y
            return [(x - self.width / 2, self.width), (y - self.length / 2, self.length)]
        return [(-self.width / 2, self.width), (-self.length / 2, self.length)]

    def point(self, u: Value, v: Value) -> Vector:
        if self.fixed():
            return Vector(u, v) if self.heading == 0 else self.position + Vector(u, v).rotated(self.heading)
        offset = Vector((u - 0.5) * self.width, (v - 0.5) * self.length)
        return self.position + offset.rotated(self.heading)

    def contains(self, point: Vector) -> Value:
        return apply(IN_RECTANGLE, point.x, point.y, *self.parameters())

    def outlines(self) -> list[Any]:
        if not self.fixed():
            return super().outlines()
        corners = self.corners()
        return [np.array([(corner.x, corner.y) for corner in [*corners, corners[0]]])]

    def shape(self) -> Value:
        return apply(shapes.RECTANGLE, *self.parameters())


class SectorRegion(Region):
    """A disc, or its part within `angle` / 2 of `heading`."""

    def __init__(self, center: Vector, radius: Value, heading: Value = 0.0, angle: Value = TURN) -> None:
        self.center, self.radius, self.heading, self.angle = center, radius, heading, angle

    def parameters(self) -> tuple[Value, ...]:
        return self.center.x, self.center.y, self.radius, self.heading, self.angle

    def round(self) -> bool:
        """Return whether the region is certainly a whole disc."""
        return is_number(self.angle) and self.angle >= TURN

    def point(self, u: Value, v: Value) -> Vector:
        turn, reach = self.heading + (v - 0.5) * self.angle, self.radius * apply(SQUARE_ROOT, u)
        return Vector(self.center.x - reach * sine(turn), self.center.y + reach * cosine(turn))

    def contains(self, point: Vector) -> Value:
        delta = point - self.center
        reach = self.radius + CLOSENESS
        return apply(IN_SECTOR, delta.x, delta.y, reach, self.heading, self.angle)

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Return whether the region contains a rectangle; sectors of more than half a disc are not convex."""
        if is_number(self.angle) and (self.angle <= math.pi or self.angle >= TURN):
            return super().contains_corners(corners)
        return truth_by(shapes.holds_shapes, self.shape(), apply(shapes.POLYGON, *coordinates(corners)))

    def distance(self, point: Vector) -> Value:
        if self.round():
            return apply(MAXIMUM, (point - self.center).length() - self.radius, 0.0)
        return super().distance(point)

    def outlines(self) -> list[Any]:
        return [sector_rings(*self.parameters())[0]] if self.fixed() else super().outlines()

    def shape(self) -> Value:
        return apply(shapes.SECTOR, *self.parameters())


class Everywhere(Region):
    def point(self, u: Value, v: Value) -> Vector:
        raise ScenicError("value", "a point cannot be drawn from everywhere", hint="name a bounded region")

    def contains(self, point: Vector) -> Value:
        return True

    def distance(self, point: Vector) -> Value:
        return 0.0


class Nowhere(Region):
    def point(self, u: Value, v: Value) -> Vector:
        raise ScenicError("value", "a point cannot be drawn from nowhere")

    def contains(self, point: Vector) -> Value:
        return False

    def distance(self, point: Vector) -> Value:
        return math.inf


class Filtered(Region):
    """The points of `region` that pass a test: points are drawn from `region`, and failing scenes are rejected.

    Intersections and differences without a shape use it. A draw adds `test` to the program's requirements.
    """

    def __init__(self, region: Region, test: Callable[[Vector], Value]) -> None:
        self.region, self.test = region, test
        self.columns, self.dimension = region.columns, region.dimension
        self.orientation = region.orientation

    def scales(self) -> list[tuple[float, float]]:
        return self.region.scales()

    def point(self, u: Value, v: Value) -> Vector:
        return self.region.point(u, v)

    def heading_of(self, point: Vector, u: Value) -> Value:
        return self.region.heading_of(point, u)

    def outlines(self) -> list[Any]:
        return self.region.outlines()

    def contains(self, point: Vector) -> Value:
        return all_of(self.region.contains(point), self.test(point))


# ------------------------------------------------------------ fields made of regions
def patched(
    name: str, pieces: Sequence[tuple[Region, Callable[[Vector], Value]]], default: Value = None
) -> VectorField:
    """Return the field with the heading of the first piece that contains the point; outside all, `default` or nan."""

    def heading_at(point: Vector) -> Value:
        result = math.nan if default is None else default
        for region, heading_of in reversed(pieces):
            inside = region.contains(point)
            if inside is not False:
                heading = heading_of(point)
                result = heading if inside is True else apply(WHERE, inside, heading, result)
        return result

    return VectorField(name, heading_at)


def patchwork(regions: Sequence[Region], default: Value = None) -> VectorField | None:
    """Return the field with the orientation of the first region that contains the point; None without orientations."""
    pieces = [(region, region.orientation.heading_at) for region in regions if region.orientation is not None]
    return patched("Union", pieces, default) if pieces else None
