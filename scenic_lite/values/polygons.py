"""Regions of any shape: polygons, and intersections, differences and unions of regions.

Fixed regions are combined once. Regions that differ between scenes are combined in every scene, so that points drawn
from the result are uniform in each scene. The combination is geometric if the regions have shapes; otherwise points
are rejected. Read next: `values.shapes`, the geometry; `scene.pruning`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property, reduce
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError
from scenic_lite.values import shapes
from scenic_lite.values.formulas import edges_clear
from scenic_lite.values.geometry import Vector, coordinates, vector_by
from scenic_lite.values.graph import RandomExpr, Value, all_of, any_of, apply, number_by, truth_by
from scenic_lite.values.lines import GridRegion, PointSetRegion, PolylineRegion
from scenic_lite.values.operations import NOT, Operation
from scenic_lite.values.regions import (
    Everywhere,
    Filtered,
    Nowhere,
    RectangularRegion,
    Region,
    SectorRegion,
    VectorField,
    patchwork,
)
from scenic_lite.values.shapes import shapely

MOST_CORNERS = 5000  # maximum number of corners of one region
FEW_EDGES = 60  # up to this number plain arrays are faster than shapely at finding edges that meet a rectangle
BLOCK = 1 << 15  # size of one array in numbers, which fits into the processor's cache


class PolygonalRegion(Region):
    """One or more fixed polygons, with or without holes."""

    def __init__(self, shape: Any, orientation: VectorField | None = None) -> None:
        """Create from a valid and nonempty shapely Polygon or MultiPolygon."""
        self._shape = shape
        self.orientation = orientation

    def shape(self) -> Any:
        return self._shape

    @cached_property
    def rings(self) -> list[Any]:
        """Return the closed boundaries, each [n, 2]: outer boundaries and holes."""
        return [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(self._shape))]

    @cached_property
    def edges(self) -> Any:
        """Return x, y of both ends of each boundary edge, [E, 4]."""
        return np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in self.rings])

    def outlines(self) -> list[Any]:
        return self.rings

    @cached_property
    def at(self) -> Slabs:
        """Return the map from two uniform numbers to a point."""
        return Slabs(self.edges)

    @cached_property
    def _holds(self) -> Holds:
        return Holds(self._shape)

    def point(self, u: Value, v: Value) -> Vector:
        return vector_by(self.at, u, v)

    def contains(self, point: Vector) -> Value:
        return truth_by(self._holds, point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        if len(self.edges) > FEW_EDGES:
            return all_of(super().contains_corners(corners), truth_by(self._holds.rectangles, *coordinates(corners)))
        center = (corners[0] + corners[2]) / 2
        return all_of(self.contains(center), truth_by(self._clear, *coordinates(corners)))

    def _clear(self, *numbers: Any) -> Any:
        """Return whether no boundary edge enters a rectangle, [N]; the arguments are x, y, x, y, ... of its corners."""
        corners = np.stack(np.broadcast_arrays(*(np.asarray(number, dtype=float) for number in numbers)))  # [8, N]
        size = max(1, BLOCK // len(self.edges))
        whole = corners.reshape(8, -1)
        parts = [edges_clear(self.edges, whole[:, i : i + size]) for i in range(0, whole.shape[1], size)]
        return np.concatenate(parts).reshape(corners.shape[1:])


class Slabs:
    """Uniform points of a fixed shape from two uniform numbers: the first gives x, the second y.

    Vertical cuts at the x of every corner divide the shape into S slabs. Each slab is a stack of up to K trapezoids.
    The first number is the share of the area to the left of x. The second number is the share of the vertical line
    inside the shape below y. Both coordinates increase with their numbers, and nearby numbers give nearby points,
    except across gaps in the shape.
    """

    def __init__(self, edges: Any) -> None:
        """Cut closed rings that do not cross, given as edges [E, 4]: x and y of both ends."""
        xs = np.unique(edges[:, [0, 2]])
        x0, y0, x1, y1 = edges[edges[:, 0] != edges[:, 2]].T
        ends = np.stack([xs[:-1], xs[1:]], axis=1)[:, None]  # x limits of each slab, [S, 1, 2]
        crosses = (np.minimum(x0, x1) <= ends[..., 0]) & (np.maximum(x0, x1) >= ends[..., 1])  # [S, E]
        heights = y0[:, None] + ((y1 - y0) / (x1 - x0))[:, None] * (ends - x0[:, None])  # of the edges, [S, E, 2]
        order = np.argsort(np.where(crosses, heights.sum(axis=2), np.inf), axis=1, kind="stable")
        crossed = crosses.sum(axis=1)  # number of sorted edges in each slab, which is even
        lines = np.take_along_axis(heights, order[:, : crossed.max(), None], axis=1)
        self.start, self.width = xs[:-1], np.diff(xs)
        self.low, self.low_step = lines[:, ::2, 0], lines[:, ::2, 1] - lines[:, ::2, 0]
        real = np.arange(0, crossed.max(), 2) < crossed[:, None]  # existing trapezoids of each slab, [S, K]
        self.high = np.where(real[..., None], lines[:, 1::2] - lines[:, ::2], 0.0)  # left and right, [S, K, 2]
        self.left, self.right = self.high.sum(axis=1).T  # heights of the whole stack, [S]
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
        high, at = self.high[which], t[:, None]
        low = self.low[which] + at * self.low_step[which]  # lower end of each trapezoid on the vertical line, [N, K]
        height = high[..., 0] * (1 - at) + high[..., 1] * at
        ends = np.cumsum(height, axis=1)
        target = v * ends[:, -1]
        level = np.minimum((target[:, None] > ends[:, :-1]).sum(axis=1), low.shape[1] - 1)
        rows = np.arange(len(which))
        y = low[rows, level] + target - (ends[rows, level] - height[rows, level])
        return self.start[which] + t * self.width[which], y


def points_of(shapes: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """Return a uniform point of each shape: [N], [N], [N] -> x [N], y [N]; nan for an empty shape."""
    shapes, u, v = np.broadcast_arrays(shapes, u, v)
    points = np.full((2, len(shapes), 1), np.nan)
    for i, shape in enumerate(shapes):
        if not shape.is_empty:
            region: Any = region_of(shape)
            points[:, i] = region.at(u[i : i + 1], v[i : i + 1])
    return points[0, :, 0], points[1, :, 0]


class Holds:
    """Tests whether points or rectangles are in a fixed shape, including its boundary."""

    def __init__(self, shape: Any) -> None:
        self.shape = shapes.widened(shape)
        shapely.prepare(self.shape)

    def __call__(self, x: Any, y: Any) -> Any:
        return shapely.intersects_xy(self.shape, x, y)

    def rectangles(self, *numbers: Any) -> Any:
        """Return whether rectangles are inside; the arguments are x, y, x, y, ... of the corners, [N] or scalars."""
        corners = shapes.points_from(np.broadcast_arrays(*(np.asarray(number, dtype=float) for number in numbers)))
        known = np.isfinite(corners).all(axis=(-2, -1))  # undefined positions are in no shape
        return known & shapely.covers(self.shape, shapely.polygons(np.where(known[..., None, None], corners, 0.0)))


class ShapeRegion(Region):
    """A shape that differs between scenes, such as a polygon with random corners or an intersection of random regions.

    `shape` is a node of polygons, or of polylines if `dimension` is 1. A scene that draws a point from an empty shape
    is rejected.
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
        return vector_by(points_of, self._shape, u, v)

    def contains(self, point: Vector) -> Value:
        return truth_by(shapes.holds_points, self._shape, point.x, point.y)

    def contains_corners(self, corners: list[Vector]) -> Value:
        return truth_by(shapes.holds_shapes, self._shape, apply(shapes.POLYGON, *coordinates(corners)))


def polygon_through(corners: list[Vector], orientation: VectorField | None = None) -> Region:
    """Return the polygon with these corners. Raises ScenicError if a fixed polygon crosses itself or has no area."""
    if not all(corner.fixed for corner in corners):
        return ShapeRegion(apply(shapes.POLYGON, *coordinates(corners)), orientation)
    points = [(float(corner.x), float(corner.y)) for corner in corners]
    shape = shapely.Polygon(points)
    if len(set(points)) > 3 and not shape.is_valid and shape.convex_hull.area > 0:
        raise ScenicError("value", "the polygon crosses itself")
    if not shape.area > 0:
        raise ScenicError("value", "a polygon needs three points that do not lie on a line")
    return PolygonalRegion(shape, orientation)


# ------------------------------------------------------------ combinations
def common_part(a: Region, b: Region, dialect: int = 3) -> Region:
    """Return the intersection, with the orientation of `a` if it has one, otherwise of `b`.

    If both are random rectangles, discs or sectors, dialect 2 draws from `b` and rejects points outside `a`. Larger
    overlaps are then more likely.
    """
    for region, other in ((a, b), (b, a)):
        if isinstance(region, Everywhere) or isinstance(other, Nowhere):
            return other
    if a.dimension > b.dimension and b.dimension == 0:
        a, b = b, a
    if isinstance(a, PointSetRegion):
        return chosen_points(a, b, kept=True)
    if isinstance(a, Filtered) or isinstance(b, Filtered):
        return Filtered(a, b.contains)
    simple = RectangularRegion | SectorRegion
    if dialect == 2 and isinstance(a, simple) and isinstance(b, simple) and not (a.fixed() and b.fixed()):
        return Filtered(b, a.contains)
    return combined(shapes.INTERSECTION, a, b, min(a.dimension, b.dimension), a.orientation or b.orientation)


def remainder(a: Region, b: Region) -> Region:
    """Return the part of `a` outside `b`; a polyline loses its orientation."""
    if isinstance(b, Everywhere):
        return Nowhere()
    if isinstance(b, Nowhere) or isinstance(a, Nowhere):
        return a
    if isinstance(a, PointSetRegion):
        return chosen_points(a, b, kept=False)
    if isinstance(a, Filtered | Everywhere) or isinstance(b, Filtered | PointSetRegion):
        return outside(a, b)
    return combined(shapes.DIFFERENCE, a, b, a.dimension, a.orientation if a.dimension == 2 else None)


def outside(region: Region, hole: Region) -> Region:
    """Return a region without the points in `hole`; draws in `hole` are rejected."""
    return Filtered(region, lambda point: apply(NOT, hole.contains(point)))


def union(a: Region, b: Region) -> Region:
    """Return the union, which is uniform even if the regions overlap; each part keeps its orientation."""
    for region, other in ((a, b), (b, a)):
        if isinstance(region, Everywhere) or isinstance(other, Nowhere):
            return region
    return combined(shapes.UNION, a, b, max(a.dimension, b.dimension), patchwork([a, b]))


def union_of(regions: Iterable[Region]) -> Region:
    """Return the union of any number of regions."""
    nothing: Region = Nowhere()
    return reduce(union, regions, nothing)


def combined(
    operation: Operation, a: Region, b: Region, dimension: int, orientation: VectorField | None = None
) -> Region:
    """Apply an operation to the shapes of two regions and return the region of the result."""
    return region_of(apply(operation, a.shape(), b.shape()), orientation, dimension)


def region_of(shape: Value, orientation: VectorField | None = None, dimension: int = 2) -> Region:
    """Return the region of a shape; `dimension` is the expected dimension of a random shape."""
    if isinstance(shape, RandomExpr):
        return ShapeRegion(shape, orientation, dimension)
    if shape.is_empty:
        return Nowhere()
    if shapely.get_num_coordinates(shape) > MOST_CORNERS:
        raise ScenicError("budget", f"evaluation budget exceeded: a region of more than {MOST_CORNERS:,} corners")
    if shape.area > 0:
        return PolygonalRegion(shape, orientation)
    if shape.length > 0:
        return PolylineRegion([line.coords for line in shapely.get_parts(shape)], orientation)
    return PointSetRegion(shapely.get_coordinates(shape), orientation)


def chosen_points(points: PointSetRegion, other: Region, kept: bool) -> Region:
    """Return the points of a set inside another region (`kept` True) or outside it."""
    inside = [other.contains(point) for point in points.vectors()]
    if any(isinstance(truth, RandomExpr) for truth in inside):
        return Filtered(points, other.contains) if kept else outside(points, other)
    left = points.points[[bool(held) is kept for held in inside]]
    return PointSetRegion(left, points.orientation or other.orientation) if len(left) else Nowhere()


def meet(a: Region, b: Region) -> Value:
    """Return whether two regions have a common point."""
    for first, second in ((a, b), (b, a)):
        if isinstance(first, Everywhere | Nowhere):
            return isinstance(first, Everywhere) and not isinstance(second, Nowhere)
        if isinstance(first, PointSetRegion):
            return any_of(*(second.contains(point) for point in first.vectors()))
    return truth_by(shapely.intersects, a.shape(), b.shape())


def holds(a: Region, b: Region, tolerance: float = 0.0) -> Value:
    """Return whether `a`, grown by `tolerance`, contains all of `b`."""
    if isinstance(a, Everywhere) or isinstance(b, Nowhere):
        return True
    if isinstance(a, Nowhere | GridRegion) or isinstance(b, Everywhere):
        return False
    shape = a.shape() if tolerance == 0 else apply(shapes.GROWN, a.shape(), tolerance)
    return truth_by(shapes.holds_shapes, shape, b.shape())


def grown(region: Region, by: Value) -> Region:
    """Return all points within a distance of a region; a negative distance shrinks the region."""
    return region_of(apply(shapes.GROWN, region.shape(), by))


def boundary(region: Region) -> Region:
    """Return the boundary of a fixed polygon, as polylines."""
    shape = region.shape()
    if isinstance(shape, RandomExpr):
        raise ScenicError("unsupported", "only fixed regions support this")
    return PolylineRegion([line.coords for line in shapely.get_parts(shape.boundary)])


def size_of(region: Region) -> Value:
    """Return the area, the length or the number of points of a region."""
    if isinstance(region, PointSetRegion):
        return len(region.points)
    return number_by(shapely.area if region.dimension == 2 else shapely.length, region.shape())
