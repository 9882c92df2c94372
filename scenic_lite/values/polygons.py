"""Regions of any shape: polygons with holes, fixed or different in every scene; membership of many points at once.

Read next: `values.shapes`, the geometry; `values.lines`.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError
from scenic_lite.values.formulas import CLOSENESS
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import AND
from scenic_lite.values.regions import Point2, Region, VectorField, truth_of

MOST_CORNERS = 5000  # of one region
FEW_EDGES = 60  # up to here plain arrays find faster than shapely whether an edge meets a rectangle
BLOCK = 1 << 15  # numbers in one array, so that they stay in the processor's cache


class PolygonalRegion(Region):
    """A fixed polygon or several, with holes or without."""

    def __init__(self, shape: Any, orientation: VectorField | None = None) -> None:
        """Take a valid shapely Polygon or MultiPolygon, not empty."""
        self._shape = shape
        self.orientation = orientation

    def shape(self) -> Any:
        return self._shape

    @cached_property
    def rings(self) -> list[Any]:
        """Return its closed boundaries, each [n, 2]: outer ones and holes."""
        import shapely

        return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(self._shape))]

    @cached_property
    def edges(self) -> Any:
        """Return x, y of both ends of each edge of its boundary, [E, 4]."""
        return np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in self.rings])

    def outlines(self) -> list[Any]:
        return self.rings

    @cached_property
    def _slabs(self) -> Slabs:
        return Slabs(self.edges)

    @cached_property
    def _holds(self) -> Holds:
        return Holds(self._shape)

    def point(self, u: Value, v: Value) -> Vector:
        both = RandomExpr(self._slabs, (u, v), "any")
        return Vector(RandomExpr(first, (both,)), RandomExpr(second, (both,)))

    def contains(self, point: Vector) -> Value:
        return truth_of(self._holds, point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        numbers = [part for corner in corners for part in (corner.x, corner.y)]
        if len(self.edges) > FEW_EDGES:
            return apply(AND, super().contains_corners(corners), truth_of(self._covers, *numbers))
        centre = (corners[0] + corners[2]) / 2
        return apply(AND, self.contains(centre), truth_of(self._clear, *numbers))

    def _covers(self, *numbers: Any) -> Any:
        return self._holds.rectangles(*numbers)

    def _clear(self, *numbers: Any) -> Any:
        """Return whether no edge of the boundary enters a rectangle, given x and y of its corners in turn: [N]."""
        corners = np.stack(np.broadcast_arrays(*(np.asarray(number, dtype=float) for number in numbers)))  # [8, N]
        size = max(1, BLOCK // len(self.edges))
        whole = corners.reshape(8, -1)
        parts = [edges_clear(self.edges, whole[:, i : i + size]) for i in range(0, whole.shape[1], size)]
        return np.concatenate(parts).reshape(corners.shape[1:])


class Slabs:
    """Uniform points of a fixed shape from two uniform numbers: the first gives x, the second y.

    The shape is cut at the x of every corner into S vertical slabs, in each of which it is a stack of up to K
    trapezoids. x is the inverse of the share of the area left of it, y divides what lies on the vertical line through
    x. So both grow with their numbers, and near numbers give near points wherever the shape is not interrupted.
    """

    def __init__(self, edges: Any) -> None:
        """Cut closed rings that do not cross: edges [E, 4], x and y of both ends."""
        xs = np.unique(edges[:, [0, 2]])
        stacks = [stack_between(edges, *pair) for pair in pairwise(xs)]
        deepest = max(len(stack) for stack in stacks)
        sides = np.zeros((len(stacks), deepest, 4))  # lower left, lower right, upper left, upper right
        for slab, stack in zip(sides, stacks, strict=True):
            slab[: len(stack)] = stack
            slab[len(stack) :] = stack[-1][[2, 3, 2, 3]] if len(stack) else 0.0
        self.start, self.width = xs[:-1], np.diff(xs)
        self.low, self.low_step = sides[..., 0], sides[..., 1] - sides[..., 0]
        self.high = sides[..., 2:] - sides[..., :2]  # heights at the left and right, [S, K, 2]
        self.left, self.right = self.high.sum(axis=1).T  # of the whole stack, [S]
        areas = self.width * (self.left + self.right) / 2
        self.ends = np.cumsum(areas) / areas.sum()
        self.before = np.concatenate([[0.0], self.ends[:-1]])

    def __call__(self, u: Any, v: Any) -> tuple[Any, Any]:
        """Return the points of uniform numbers: [N], [N] -> x [N], y [N]."""
        which = np.minimum(np.searchsorted(self.ends, u, side="right"), len(self.ends) - 1)
        share = np.clip((u - self.before[which]) / np.maximum(self.ends[which] - self.before[which], 1e-300), 0.0, 1.0)
        left, right = self.left[which], self.right[which]
        root = left + np.sqrt(left * left + (right * right - left * left) * share)
        t = np.minimum(share * (left + right) / np.maximum(root, 1e-300), 1.0)
        low, height = self._stack(which, t)
        ends = np.cumsum(height, axis=1)
        target = v * ends[:, -1]
        level = np.minimum((target[:, None] > ends[:, :-1]).sum(axis=1), low.shape[1] - 1)
        rows = np.arange(len(which))
        y = low[rows, level] + target - (ends[rows, level] - height[rows, level])
        return self.start[which] + t * self.width[which], y

    def _stack(self, which: Any, t: Any) -> tuple[Any, Any]:
        """Return the lower ends and the heights of the trapezoids on the verticals at t of some slabs, each [N, K]."""
        t = t[:, None]
        height = self.high[which]
        return self.low[which] + t * self.low_step[which], height[..., 0] * (1 - t) + height[..., 1] * t


def stack_between(edges: Any, start: float, end: float) -> Any:
    """Return the trapezoids between two neighbouring xs, the lowest first: [K, 4]."""
    low, high = np.minimum(edges[:, 0], edges[:, 2]), np.maximum(edges[:, 0], edges[:, 2])
    x0, y0, x1, y1 = edges[(low <= start) & (high >= end)].T
    at_start, at_end = (y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) for x in (start, end))
    order = np.argsort(at_start + at_end, kind="stable")
    lines = np.stack([at_start, at_end], axis=1)[order]
    return np.hstack([lines[::2], lines[1::2]])


class Holds:
    """Whether points, or rectangles, lie in a fixed shape, boundaries included."""

    def __init__(self, shape: Any) -> None:
        import shapely

        self.shape = shapely.buffer(shape, CLOSENESS, join_style="mitre")
        self.points = shapely.intersects_xy
        shapely.prepare(self.shape)

    def __call__(self, x: Any, y: Any) -> Any:
        return self.points(self.shape, x, y)

    def rectangles(self, *numbers: Any) -> Any:
        """Return whether rectangles lie inside, given x and y of the corners in turn, [N] or scalars."""
        from scenic_lite.values import shapes

        return shapes.covers_rectangles(self.shape, *numbers)


class ShapeRegion(Region):
    """A shape that differs from scene to scene: random corners, or what random regions have in common.

    `shape` is a node of polygons, or of polylines where `dimension` is 1. A scene in which it is empty is rejected when
    a point is drawn from it.
    """

    def __init__(self, shape: RandomExpr, orientation: VectorField | None = None, dimension: int = 2) -> None:
        self._shape = shape
        self.orientation = orientation
        self.dimension = dimension
        self.columns = 2 if dimension == 2 else 1

    def shape(self) -> Value:
        return self._shape

    def parameters(self) -> tuple[Value, ...]:
        return (self._shape,)

    def point(self, u: Value, v: Value) -> Vector:
        from scenic_lite.values import shapes

        both = RandomExpr(shapes.points_of, (self._shape, u, v), "any")
        return Vector(RandomExpr(first, (both,)), RandomExpr(second, (both,)))

    def contains(self, point: Vector) -> Value:
        from scenic_lite.values import shapes

        return apply(shapes.HOLDS_POINT, self._shape, point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        from scenic_lite.values import shapes

        numbers = [part for corner in corners for part in (corner.x, corner.y)]
        outline = apply(shapes.POLYGON, *numbers)
        return apply(shapes.HOLDS_SHAPE, self._shape, outline)


def polygon_through(points: list[Point2], orientation: VectorField | None = None) -> PolygonalRegion:
    """Return the polygon with fixed corners. Raises ScenicError if it crosses itself or has no area."""
    import shapely

    if len(points) < 3:
        raise ScenicError("value", "a polygon needs three points that do not lie on a line")
    shape = shapely.Polygon(points)
    if len(set(points)) > 3 and not shape.is_valid and shape.convex_hull.area > 0:
        raise ScenicError("value", "the polygon crosses itself")
    if not shape.area > 0:
        raise ScenicError("value", "a polygon needs three points that do not lie on a line")
    return PolygonalRegion(shape, orientation)


def edges_clear(edges: Any, corners: Any) -> Any:
    """Return whether no edge enters the inside of a rectangle: edges [E, 4], corners [8, N] -> [N].

    An edge stays out exactly if it is apart from the rectangle along one of its two sides, or along its own normal.
    """
    x, y = (corners[0] + corners[4]) / 2, (corners[1] + corners[5]) / 2
    across_x, across_y = (corners[0] - corners[2]) / 2, (corners[1] - corners[3]) / 2  # half the width
    along_x, along_y = (corners[2] - corners[4]) / 2, (corners[3] - corners[5]) / 2  # half the length
    clear = np.ones(len(x), dtype=bool)
    for start_x, start_y, end_x, end_y in edges:
        step_x, step_y = (end_x - start_x) / 2, (end_y - start_y) / 2
        dx, dy = (start_x + end_x) / 2 - x, (start_y + end_y) / 2 - y
        apart = np.zeros(len(x), dtype=bool)
        for side_x, side_y in ((across_x, across_y), (along_x, along_y)):
            square = side_x * side_x + side_y * side_y
            reach = square + np.abs(step_x * side_x + step_y * side_y)
            apart |= np.abs(dx * side_x + dy * side_y) >= reach - CLOSENESS * np.sqrt(square)
        reach = np.abs(across_x * step_y - across_y * step_x) + np.abs(along_x * step_y - along_y * step_x)
        apart |= np.abs(dx * step_y - dy * step_x) >= reach - CLOSENESS * np.hypot(step_x, step_y)
        clear &= apart
    return clear


def first(pair: Any) -> Any:
    return pair[0]


def second(pair: Any) -> Any:
    return pair[1]
