"""Shapes: the geometries of shapely behind regions, fixed or one for each of N samples.

The only importer of shapely, which is loaded where a program first needs a polygon. A shape that differs from scene to
scene is a node whose value is an array [N] of geometries. Read next: `values.polygons`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.values.formulas import ARC_SEGMENTS, CLOSENESS, sector_rings
from scenic_lite.values.operations import Operation

HALVINGS = 44  # of a shape's width, until x is known as well as a float allows
COARSE = 64  # segments of a circle that differs from scene to scene


class DeferredModule:
    """A module that is loaded when something of it is wanted first."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        vars(self)[name] = vars(import_module(self._name))[name]
        return vars(self)[name]


shapely: Any = DeferredModule("shapely")


def shaping(build: Callable[..., Any]) -> Operation:
    """Return an operation that makes shapes as `build` does of arrays [N].

    They are empty where numbers are not finite or geometry fails.
    """

    def one(row: tuple) -> Any:
        try:
            return build(*(np.array([part]) for part in row))[0]
        except (shapely.errors.GEOSException, ValueError):
            return shapely.Polygon()

    def of_rows(*parts: Any) -> Any:
        try:
            return build(*parts)
        except (shapely.errors.GEOSException, ValueError):
            rows = zip(*np.broadcast_arrays(*parts), strict=True)
            return np.array([*map(one, rows), None], dtype=object)[:-1]

    return Operation(lambda *parts: of_rows(*(np.array([part]) for part in parts))[0], of_rows, kind="any")


def rectangles(x: Any, y: Any, heading: Any, width: Any, length: Any) -> Any:
    """Return [N] oriented rectangles."""
    x, y, heading, width, length = np.broadcast_arrays(x, y, heading, width, length)
    c, s = np.cos(heading), np.sin(heading)
    rings = [
        np.stack([x + a * width * c - b * length * s, y + a * width * s + b * length * c], axis=-1)
        for a, b in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    ]
    return shapely.polygons(np.stack(rings, axis=1))


def sectors(x: Any, y: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """Return [N] discs or parts of one; their arcs are chains of chords of equal length."""
    return shapely.polygons(sector_rings(x, y, radius, heading, angle, COARSE))


def polygons_of(*numbers: Any) -> Any:
    """Return [N] polygons from the x and y of each corner in turn; empty where they cross themselves."""
    made = shapely.polygons(points_from(np.broadcast_arrays(*numbers)))
    return np.where(shapely.is_valid(made), made, shapely.Polygon())


def points_from(rows: Any) -> Any:
    """Return points [..., K, 2] from their x and y in turn, each [...]."""
    return np.stack([np.stack(rows[::2], axis=-1), np.stack(rows[1::2], axis=-1)], axis=-1)


def flat(shapes: Any) -> Any:
    """Reduce collections of mixed dimensions to the parts of the highest: what a uniform point falls into."""
    mixed = shapely.get_type_id(shapes) == 7
    if not np.any(mixed):
        return shapes
    shapes = np.array(shapes, dtype=object, ndmin=1)
    for i in np.flatnonzero(np.atleast_1d(mixed)):
        parts = shapely.get_parts(shapes[i])
        dimensions = shapely.get_dimensions(parts)
        shapes[i] = shapely.union_all(parts[dimensions == dimensions.max(initial=0)])
    return shapes


def distances(shape: Any, x: Any, y: Any) -> Any:
    return shapely.distance(shape, shapely.points(x, y))


def buffered(shape: Any, by: Any) -> Any:
    """Return a shape and all that is within a distance of it."""
    return shapely.buffer(shape, by, quad_segs=ARC_SEGMENTS // 4)


def widened(shape: Any) -> Any:
    """Return a shape together with what counts as its boundary."""
    return shapely.buffer(shape, CLOSENESS, join_style="mitre")


def holds_points(shape: Any, x: Any, y: Any) -> Any:
    return shapely.intersects_xy(shape, x, y)


def holds_shapes(shape: Any, other: Any) -> Any:
    """Return whether shapes lie in shapes, boundaries included."""
    return shapely.covers(widened(shape), other)


def moved(shape: Any, x: float, y: float) -> Any:
    """Return a fixed shape somewhere else."""
    return shapely.transform(shape, lambda points: points + (x, y))


RECTANGLE, POLYGON, GROWN = shaping(rectangles), shaping(polygons_of), shaping(buffered)
SECTOR = Operation(lambda *numbers: shapely.Polygon(sector_rings(*numbers)[0]), shaping(sectors).array, kind="any")
INTERSECTION = shaping(lambda a, b: flat(shapely.intersection(a, b)))
DIFFERENCE = shaping(lambda a, b: flat(shapely.difference(a, b)))
UNION = shaping(lambda a, b: flat(shapely.union(a, b)))


# ------------------------------------------------------------ uniform points


class Edges(NamedTuple):
    """The edges of N shapes, each from its left end to its right one; `owner` ascends, `sign` is -1 where turned."""

    left: Any  # [E, 2]
    right: Any
    sign: Any
    owner: Any


def points_of(shapes: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """Return a uniform point of each polygon or polyline: [N], [N], [N] -> x [N], y [N]; nan where the shape is empty.

    The same map as that of `polygons.Slabs`, for N shapes at once, whose edges lie in one flat array.
    """
    shapes, u, v = np.broadcast_arrays(shapes, u, v)
    x, y = np.full(len(shapes), np.nan), np.full(len(shapes), np.nan)
    dimension, filled = shapely.get_dimensions(shapes), ~shapely.is_empty(shapes)
    for size, points in ((2, polygon_points), (1, line_points)):
        rows = filled & (dimension == size)
        if rows.any():
            x[rows], y[rows] = points(shapes[rows], u[rows], v[rows])
    return x, y


def segments_of(lines: Any) -> tuple[Any, Any]:
    """Return the segments of each polyline or ring, [E, 2, 2], and whose they are [E]."""
    parts, owner = shapely.get_parts(lines, return_index=True)
    points, part = shapely.get_coordinates(parts, return_index=True)
    same = part[:-1] == part[1:]
    return np.stack([points[:-1], points[1:]], axis=1)[same], owner[part[:-1][same]]


def line_points(lines: Any, u: Any, v: Any) -> Any:
    """Return points by the length along each polyline: [2, N]."""
    segments, owner = segments_of(lines)
    lengths = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    which, target, start = piece_of(lengths, owner, u)
    share = np.clip((target - start) / np.maximum(lengths[which], 1e-300), 0.0, 1.0)
    begin, end = segments[which, 0], segments[which, 1]
    return (begin + (end - begin) * share[:, None]).T


def piece_of(sizes: Any, owner: Any, u: Any) -> tuple[Any, Any, Any]:
    """Return the piece of each row into which a share `u` of them all falls, and the totals there and before."""
    ends = np.cumsum(sizes)
    rows = np.arange(len(u))
    first, last = np.searchsorted(owner, rows, side="left"), np.searchsorted(owner, rows, side="right") - 1
    before = ends[first] - sizes[first]
    target = before + u * (ends[last] - before)
    which = np.clip(np.searchsorted(ends, target, side="right"), first, last)
    return which, target, ends[which] - sizes[which]


def polygon_points(polygons: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """Return points by the area left of them, and by the vertical through them."""
    segments, owner = segments_of(shapely.boundary(shapely.normalize(polygons)))
    slanted = segments[:, 0, 0] != segments[:, 1, 0]
    segments, owner = segments[slanted], owner[slanted]
    turned = segments[:, 0, 0] > segments[:, 1, 0]
    left, right = np.where(turned[:, None], segments[:, ::-1].transpose(1, 0, 2), segments.transpose(1, 0, 2))
    edges = Edges(left, right, np.where(turned, -1.0, 1.0), owner)
    bounds = shapely.bounds(polygons)
    x = x_with(edges, u, bounds[:, 0], bounds[:, 2])
    return x, y_with(edges, x, v)


def x_with(edges: Edges, u: Any, low: Any, high: Any) -> Any:
    """Return where the share `u` of each area lies to the left."""
    starts = np.searchsorted(edges.owner, np.arange(len(u)))
    slope = (edges.right[:, 1] - edges.left[:, 1]) / (edges.right[:, 0] - edges.left[:, 0])

    def area_left_of(x: Any) -> Any:
        reach = np.clip(x[edges.owner], edges.left[:, 0], edges.right[:, 0]) - edges.left[:, 0]
        return np.add.reduceat(edges.sign * reach * (edges.left[:, 1] + slope * reach / 2), starts)

    whole = area_left_of(high)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        less = area_left_of(middle) / whole < u
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return (low + high) / 2


def y_with(edges: Edges, x: Any, v: Any) -> Any:
    """Return where the share `v` of each vertical at x that lies in the shape is below."""
    at = x[edges.owner]
    crossing = (edges.left[:, 0] <= at) & (at < edges.right[:, 0])
    owner, at, left, right = (part[crossing] for part in (edges.owner, at, edges.left, edges.right))
    height = left[:, 1] + (right[:, 1] - left[:, 1]) * ((at - left[:, 0]) / (right[:, 0] - left[:, 0]))
    order = np.lexsort((height, owner))
    low, high, whose = height[order][::2], height[order][1::2], owner[order][::2]  # they come in pairs
    y = np.full(len(x), np.nan)
    rows, number = np.unique(whose, return_inverse=True)
    which, target, start = piece_of(high - low, number, v[rows])
    y[rows] = np.clip(low[which] + target - start, low[which], high[which])
    return y
