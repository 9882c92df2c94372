"""Shapes: the geometries of shapely behind regions, fixed or one for each of N samples.

The only importer of shapely, and itself imported only where a program has polygons. A shape that differs from scene to
scene is a node whose value is an array [N] of geometries. Read next: `values.shape_points`;
`values.algebra`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

from scenic_lite.values.formulas import ARC_SEGMENTS, CLOSENESS, sector_rings
from scenic_lite.values.operations import Operation

COARSE = 64  # segments of a circle that differs from scene to scene
EMPTY = shapely.Polygon()


def guarded(build: Callable[..., Any]) -> Callable[..., Any]:
    """The same construction of shapes, empty where numbers are not finite or geometry fails."""

    def of_rows(*parts: Any) -> Any:
        try:
            return build(*parts)
        except (shapely.errors.GEOSException, ValueError):
            rows = np.broadcast_arrays(*parts)
            return np.array([one(build, row) for row in zip(*rows, strict=True)] + [None], dtype=object)[:-1]

    return of_rows


def one(build: Callable[..., Any], row: tuple) -> Any:
    try:
        return build(*(np.array([part]) for part in row))[0]
    except (shapely.errors.GEOSException, ValueError):
        return EMPTY


def shaping(build: Callable[..., Any]) -> Operation:
    """An operation that makes shapes: `build` takes arrays [N]."""
    rows = guarded(build)
    return Operation(lambda *parts: rows(*(np.array([part]) for part in parts))[0], rows)


def rectangles(x: Any, y: Any, heading: Any, width: Any, length: Any) -> Any:
    """[N] oriented rectangles."""
    x, y, heading, width, length = np.broadcast_arrays(x, y, heading, width, length)
    c, s = np.cos(heading), np.sin(heading)
    rings = [
        np.stack([x + a * width * c - b * length * s, y + a * width * s + b * length * c], axis=-1)
        for a, b in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    ]
    return shapely.polygons(np.stack(rings, axis=1))


def sectors(x: Any, y: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """[N] discs or parts of one; their arcs are chains of chords of equal length."""
    return shapely.polygons(sector_rings(x, y, radius, heading, angle, COARSE))


def polygons_of(*numbers: Any) -> Any:
    """[N] polygons from the x and y of each corner in turn; empty where they cross themselves."""
    rows = np.broadcast_arrays(*numbers)
    made = shapely.polygons(np.stack([np.stack(rows[::2], axis=-1), np.stack(rows[1::2], axis=-1)], axis=-1))
    return np.where(shapely.is_valid(made), made, EMPTY)


def lines_of(*numbers: Any) -> Any:
    """[N] polylines from the x and y of each point in turn."""
    rows = np.broadcast_arrays(*numbers)
    return shapely.linestrings(np.stack([np.stack(rows[::2], axis=-1), np.stack(rows[1::2], axis=-1)], axis=-1))


def flat(shapes: Any) -> Any:
    """Collections of mixed dimensions reduced to the parts of the highest: what a uniform point falls into."""
    mixed = shapely.get_type_id(shapes) == 7
    if not np.any(mixed):
        return shapes
    shapes = np.array(shapes, dtype=object, ndmin=1)
    for i in np.flatnonzero(np.atleast_1d(mixed)):
        parts = shapely.get_parts(shapes[i])
        dimensions = shapely.get_dimensions(parts)
        shapes[i] = shapely.union_all(parts[dimensions == dimensions.max(initial=0)])
    return shapes


def intersections(a: Any, b: Any) -> Any:
    return flat(shapely.intersection(a, b))


def differences(a: Any, b: Any) -> Any:
    return flat(shapely.difference(a, b))


def unions(a: Any, b: Any) -> Any:
    return flat(shapely.union(a, b))


def distances(shape: Any, x: Any, y: Any) -> Any:
    return shapely.distance(shape, shapely.points(x, y))


RECTANGLE = shaping(rectangles)
SECTOR = Operation(lambda *numbers: shapely.Polygon(sector_rings(*numbers)[0]), shaping(sectors).array)
POLYGON = shaping(polygons_of)
LINE = shaping(lines_of)
INTERSECTION = shaping(intersections)
DIFFERENCE = shaping(differences)
UNION = shaping(unions)
DISTANCE = Operation(lambda shape, x, y: float(distances(shape, x, y)), distances)
MEET = Operation(lambda a, b: bool(shapely.intersects(a, b)), shapely.intersects)
HOLDS_POINT = Operation(
    lambda shape, x, y: bool(shapely.intersects_xy(shape, x, y)), lambda shape, x, y: shapely.intersects_xy(shape, x, y)
)
AREA = Operation(lambda shape: float(shape.area), shapely.area)
LENGTH = Operation(lambda shape: float(shape.length), shapely.length)


def grown(shape: Any, by: Any) -> Any:
    """A shape and all that is within a distance of it."""
    return shapely.buffer(shape, by, quad_segs=ARC_SEGMENTS // 4)


GROWN = shaping(grown)


def moved(shape: Any, x: float, y: float) -> Any:
    """A fixed shape somewhere else."""
    return shapely.transform(shape, lambda points: points + (x, y))


def holds_shape(shape: Any, other: Any) -> Any:
    """Whether shapes lie in shapes, boundaries included."""
    return shapely.covers(shapely.buffer(shape, CLOSENESS, join_style="mitre"), other)


HOLDS_SHAPE = Operation(lambda shape, other: bool(holds_shape(shape, other)), holds_shape)


def covers_rectangles(shape: Any, *numbers: Any) -> Any:
    """Whether a fixed, prepared shape holds rectangles, given x and y of their corners in turn."""
    rows = np.broadcast_arrays(*(np.asarray(each, dtype=float) for each in numbers))
    corners = np.stack([np.stack(rows[::2], -1), np.stack(rows[1::2], -1)], -1)
    known = np.isfinite(corners).all(axis=(-2, -1))  # what stands nowhere is in no shape
    return known & shapely.covers(shape, shapely.polygons(np.where(known[..., None, None], corners, 0.0)))
