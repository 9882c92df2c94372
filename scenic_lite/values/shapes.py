"""Shapes: shapely's geometries of regions, either fixed or one for each of N samples.

Only this module imports shapely, at the first need for a polygon. A shape that differs between scenes is a node
whose value is an array [N] of geometries. Read next: `values.polygons`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from scenic_lite.values.formulas import ARC_SEGMENTS, CLOSENESS, sector_rings
from scenic_lite.values.operations import Operation

COARSE = 64  # number of segments of a circle that differs between scenes


class DeferredModule:
    """A module that is loaded on first use."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        vars(self)[name] = vars(import_module(self._name))[name]
        return vars(self)[name]


shapely: Any = DeferredModule("shapely")


def shaping(build: Callable[..., Any]) -> Operation:
    """Return an operation that creates shapes with `build` from arrays [N].

    A shape is empty if a number is not finite or the geometry fails.
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
    """Return oriented rectangles [N]."""
    x, y, heading, width, length = np.broadcast_arrays(x, y, heading, width, length)
    c, s = np.cos(heading), np.sin(heading)
    rings = [
        np.stack([x + a * width * c - b * length * s, y + a * width * s + b * length * c], axis=-1)
        for a, b in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    ]
    return shapely.polygons(np.stack(rings, axis=1))


def sectors(x: Any, y: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """Return discs or sectors [N], whose arcs are chords of equal length."""
    return shapely.polygons(sector_rings(x, y, radius, heading, angle, COARSE))


def polygons_of(*numbers: Any) -> Any:
    """Return polygons [N]; the arguments are x, y, x, y, ... of the corners. Self-crossing polygons become empty."""
    made = shapely.polygons(points_from(np.broadcast_arrays(*numbers)))
    return np.where(shapely.is_valid(made), made, shapely.Polygon())


def points_from(rows: Any) -> Any:
    """Return points [..., K, 2] from a list x, y, x, y, ... of arrays [...]."""
    return np.stack([np.stack(rows[::2], axis=-1), np.stack(rows[1::2], axis=-1)], axis=-1)


def flat(shapes: Any) -> Any:
    """Reduce collections of mixed dimensions to the highest-dimensional parts, which contain all uniform points."""
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
    """Return all points within a distance of a shape."""
    return shapely.buffer(shape, by, quad_segs=ARC_SEGMENTS // 4)


def widened(shape: Any) -> Any:
    """Return a shape that is slightly grown, so that its boundary belongs to it."""
    return shapely.buffer(shape, CLOSENESS, join_style="mitre")


def holds_points(shape: Any, x: Any, y: Any) -> Any:
    return shapely.intersects_xy(shape, x, y)


def holds_shapes(shape: Any, other: Any) -> Any:
    """Return whether shapes contain other shapes, including the boundary."""
    return shapely.covers(widened(shape), other)


def moved(shape: Any, x: float, y: float) -> Any:
    """Return a fixed shape translated by (x, y)."""
    return shapely.transform(shape, lambda points: points + (x, y))


RECTANGLE, POLYGON, GROWN = shaping(rectangles), shaping(polygons_of), shaping(buffered)
SECTOR = Operation(lambda *numbers: shapely.Polygon(sector_rings(*numbers)[0]), shaping(sectors).array, kind="any")
INTERSECTION = shaping(lambda a, b: flat(shapely.intersection(a, b)))
DIFFERENCE = shaping(lambda a, b: flat(shapely.difference(a, b)))
UNION = shaping(lambda a, b: flat(shapely.union(a, b)))
