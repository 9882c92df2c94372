"""Regions without area: polylines, sets of points, and grids.

Read next: `values.polygons`, regions of any shape.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError
from scenic_lite.values import shapes
from scenic_lite.values.formulas import in_frame
from scenic_lite.values.geometry import Vector, coordinates, vector_by
from scenic_lite.values.graph import Value, all_of, apply, number_by, truth_by
from scenic_lite.values.operations import LESS_EQUAL, NORMALISE
from scenic_lite.values.regions import Point2, Region, VectorField

NEAR = 1e-6  # maximum distance of a point that belongs to a polyline or a set of points


class ThinRegion(Region):
    """A region without area: it contains points within a small distance, but no object fits into it."""

    columns = 1
    tolerance = NEAR

    def contains(self, point: Vector) -> Value:
        return apply(LESS_EQUAL, self.distance(point), self.tolerance)

    def contains_corners(self, corners: list[Vector]) -> Value:
        return False


class PolylineRegion(ThinRegion):
    """Chains of segments. The orientation is the heading of each segment, unless another orientation is given."""

    dimension = 1

    def __init__(self, chains: Sequence[Any], orientation: VectorField | bool | None = True) -> None:
        """Create from chains [n, 2] of at least two points. `orientation` True: along the segments; None: none."""
        self.chains = [np.array(chain, dtype=float) for chain in chains]
        self.starts = np.concatenate([chain[:-1] for chain in self.chains])  # [S, 2]
        self.steps = np.concatenate([np.diff(chain, axis=0) for chain in self.chains])
        self.lengths = np.hypot(self.steps[:, 0], self.steps[:, 1])
        self.length = float(self.lengths.sum())
        if not self.length > 0:
            raise ScenicError("value", "a polyline needs at least two different points")
        self.ends = np.cumsum(self.lengths) / self.length
        self.headings = NORMALISE.array(np.arctan2(self.steps[:, 1], self.steps[:, 0]) - math.pi / 2)
        self.own_direction = orientation is True
        along = VectorField("the polyline's direction", self._heading_near)
        self.orientation = along if isinstance(orientation, bool) else orientation

    def _segment(self, u: Any) -> Any:
        return np.minimum(np.searchsorted(self.ends, u, side="right"), len(self.ends) - 1)

    def at(self, u: Any, v: Any = None) -> Any:
        """Return x and y of the point at share `u` in [0, 1] of the length."""
        which = self._segment(u)
        left = u - (self.ends[which] - self.lengths[which] / self.length)
        return self._point_of(which, np.clip(left * self.length / np.maximum(self.lengths[which], 1e-300), 0.0, 1.0))

    def _point_of(self, which: Any, share: Any) -> Any:
        return tuple(self.starts[which, axis] + share * self.steps[which, axis] for axis in (0, 1))

    def _heading(self, u: Any) -> Any:
        return self.headings[self._segment(u)]

    def point(self, u: Value, v: Value) -> Vector:
        return vector_by(self.at, u)

    def heading_of(self, point: Vector, u: Value) -> Value:
        return number_by(self._heading, u) if self.own_direction else super().heading_of(point, u)

    def nearest(self, x: Any, y: Any) -> tuple[Any, Any, Any]:
        """Return the nearest segment of each point, the position along the segment in [0, 1], and the distance."""
        dx, dy = np.asarray(x)[..., None] - self.starts[:, 0], np.asarray(y)[..., None] - self.starts[:, 1]
        square = np.maximum(self.lengths * self.lengths, 1e-300)
        along = np.clip((dx * self.steps[:, 0] + dy * self.steps[:, 1]) / square, 0.0, 1.0)  # [..., S]
        gaps = np.hypot(dx - along * self.steps[:, 0], dy - along * self.steps[:, 1])
        which = np.argmin(gaps, axis=-1)
        at = which[..., None]
        return which, np.take_along_axis(along, at, -1)[..., 0], np.take_along_axis(gaps, at, -1)[..., 0]

    def _heading_near(self, point: Vector) -> Value:
        return number_by(lambda x, y: self.headings[self.nearest(x, y)[0]], point.x, point.y)

    def signed_distance(self, point: Vector) -> Value:
        """Return the distance, positive to the left of the nearest segment and negative to the right."""

        def signed(x: Any, y: Any) -> Any:
            which, _, distance = self.nearest(x, y)
            start, step = self.starts[which], self.steps[which]
            side = step[..., 0] * (y - start[..., 1]) - step[..., 1] * (x - start[..., 0])
            return np.where(side >= 0, distance, -distance)

        return number_by(signed, point.x, point.y)

    def projected(self, point: Vector) -> Vector:
        """Return the nearest point of the polyline."""
        return vector_by(lambda x, y: self._point_of(*self.nearest(x, y)[:2]), point.x, point.y)

    def along(self, distance: Value, normalized: bool = False) -> Vector:
        """Return the point at a distance along the polyline; with `normalized`, at a share of its length."""
        return vector_by(lambda u: self.at(np.clip(u, 0.0, 1.0)), distance if normalized else distance / self.length)

    def __add__(self, other: Value) -> PolylineRegion:
        """Return a polyline of both sets of chains, each with its direction."""
        if not isinstance(other, PolylineRegion):
            raise TypeError("a polyline and something else")
        return PolylineRegion([*self.chains, *other.chains])

    def vertices(self) -> list[Point2]:
        """Return the points in order; a point shared by consecutive chains appears once."""
        points: list[Point2] = []
        for chain in self.chains:
            own = [(x, y) for x, y in chain.tolist()]
            points += own[1:] if points and points[-1] == own[0] else own
        return points

    def shape(self) -> Any:
        lines = [shapes.shapely.LineString(chain) for chain in self.chains]
        return lines[0] if len(lines) == 1 else shapes.shapely.MultiLineString(lines)

    def outlines(self) -> list[Any]:
        return self.chains


class PointSetRegion(ThinRegion):
    """A set of points with equal probabilities."""

    dimension = 0

    def __init__(self, points: Any, orientation: VectorField | None = None, tolerance: float = NEAR) -> None:
        """Create from points [n, 2]."""
        if not len(points):
            raise ScenicError("value", "the region is empty")
        self.points = np.array(points, dtype=float)
        self.orientation = orientation
        self.tolerance = tolerance

    def vectors(self) -> list[Vector]:
        return [Vector(x, y) for x, y in self.points.tolist()]

    def at(self, u: Any, v: Any = None) -> Any:
        """Return x and y of the point at share `u` in [0, 1) of the list of points."""
        index = np.minimum((u * len(self.points)).astype(np.int64), len(self.points) - 1)
        return self.points[index, 0], self.points[index, 1]

    def point(self, u: Value, v: Value) -> Vector:
        return vector_by(self.at, u)

    def outlines(self) -> list[Any]:
        return [point[None] for point in self.points]

    def shape(self) -> Any:
        return shapes.shapely.MultiPoint(self.points)


class GridRegion(PointSetRegion):
    """The free cells of a grid of obstacles: the region contains a point if the nearest grid point is free.

    grid [Y, X] of 0 (free) and 1 (obstacle), with the lowest row first; `step` and `origin` are (x, y).
    """

    def __init__(self, grid: Any, step: Point2, origin: Point2, orientation: VectorField | None = None) -> None:
        self.grid = np.array(grid)
        self.step, self.origin = step, origin
        super().__init__(self._places(self.grid == 0), orientation)
        self.obstacles = np.array(self._places(self.grid == 1)).reshape(-1, 2)

    def _places(self, chosen: Any) -> list[Point2]:
        rows, columns = np.nonzero(chosen)
        (step_x, step_y), (x, y) = self.step, self.origin
        return [(float(x + step_x * i), float(y + step_y * j)) for j, i in zip(rows, columns, strict=True)]

    def _free(self, x: Any, y: Any) -> Any:
        i = np.rint((np.asarray(x) - self.origin[0]) / self.step[0])
        j = np.rint((np.asarray(y) - self.origin[1]) / self.step[1])
        height, width = self.grid.shape
        inside = (i >= 0) & (i < width) & (j >= 0) & (j < height)
        i, j = np.where(inside, i, 0).astype(int), np.where(inside, j, 0).astype(int)
        return inside & (self.grid[j, i] == 0)

    def contains(self, point: Vector) -> Value:
        return truth_by(self._free, point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        """Return whether all corners are free and the rectangle contains no grid point of an obstacle."""
        unobstructed = truth_by(self._unobstructed, *coordinates(corners))
        return all_of(*(self.contains(corner) for corner in corners), unobstructed)

    def _unobstructed(self, *numbers: Any) -> Any:
        x0, y0, x1, y1, x2, y2 = (np.asarray(number)[..., None] for number in numbers[:6])
        heading = np.arctan2(y0 - y1, x0 - x1)  # direction of the front side, from left to right
        across, along = in_frame(self.obstacles[:, 0] - (x0 + x2) / 2, self.obstacles[:, 1] - (y0 + y2) / 2, heading)
        half_width, half_length = np.hypot(x0 - x1, y0 - y1) / 2, np.hypot(x1 - x2, y1 - y2) / 2
        return ~((np.abs(across) <= half_width) & (np.abs(along) <= half_length)).any(axis=-1)
