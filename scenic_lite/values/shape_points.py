"""Uniform points of shapes that differ from scene to scene, from two uniform numbers each.

The same map as that of `slabs`: x by the share of the area left of it, then y by the share of the vertical line below
it; here for N shapes at once, whose edges lie in one flat array. Read next: `values.shapes`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import shapely

HALVINGS = 44  # of a shape's width, until x is known as well as a float allows


class Edges(NamedTuple):
    """The edges of N shapes, each from its left end to its right one; `owner` ascends, `sign` is -1 where turned."""

    left: Any  # [E, 2]
    right: Any
    sign: Any
    owner: Any


def points_of(shapes: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """A uniform point of each polygon or polyline: [N], [N], [N] -> x [N], y [N]; nan where the shape is empty."""
    shapes, u, v = np.broadcast_arrays(shapes, u, v)
    x, y = np.full(len(shapes), np.nan), np.full(len(shapes), np.nan)
    dimension, filled = shapely.get_dimensions(shapes), ~shapely.is_empty(shapes)
    for wanted, points in ((2, polygon_points), (1, line_points)):
        rows = filled & (dimension == wanted)
        if rows.any():
            x[rows], y[rows] = points(shapes[rows], u[rows], v[rows])
    return x, y


def segments_of(lines: Any) -> tuple[Any, Any]:
    """The segments of each polyline or ring, [E, 2, 2], and whose they are [E]."""
    parts, owner = shapely.get_parts(lines, return_index=True)
    points, part = shapely.get_coordinates(parts, return_index=True)
    same = part[:-1] == part[1:]
    return np.stack([points[:-1], points[1:]], axis=1)[same], owner[part[:-1][same]]


def line_points(lines: Any, u: Any, v: Any) -> Any:
    """By the length along each polyline: [2, N]."""
    segments, owner = segments_of(lines)
    lengths = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    ends = np.cumsum(lengths)
    which, target = found(ends, lengths, owner, u)
    share = np.clip((target - (ends[which] - lengths[which])) / np.maximum(lengths[which], 1e-300), 0.0, 1.0)
    start, end = segments[which, 0], segments[which, 1]
    return (start + (end - start) * share[:, None]).T


def found(ends: Any, sizes: Any, owner: Any, u: Any) -> tuple[Any, Any]:
    """For each row the piece of its own into which a share `u` of them all falls, and the running total there."""
    rows = np.arange(len(u))
    first, last = np.searchsorted(owner, rows, side="left"), np.searchsorted(owner, rows, side="right") - 1
    before = ends[first] - sizes[first]
    target = before + u * (ends[last] - before)
    return np.clip(np.searchsorted(ends, target, side="right"), first, last), target


def polygon_points(polygons: Any, u: Any, v: Any) -> tuple[Any, Any]:
    """By the area left of a point, and by the vertical through it."""
    segments, owner = segments_of(shapely.boundary(shapely.normalize(polygons)))
    segments, owner = segments[segments[:, 0, 0] != segments[:, 1, 0]], owner[segments[:, 0, 0] != segments[:, 1, 0]]
    turned = segments[:, 0, 0] > segments[:, 1, 0]
    left, right = np.where(turned[:, None], segments[:, ::-1].transpose(1, 0, 2), segments.transpose(1, 0, 2))
    edges = Edges(left, right, np.where(turned, -1.0, 1.0), owner)
    bounds = shapely.bounds(polygons)
    x = x_with(edges, u, bounds[:, 0], bounds[:, 2])
    return x, y_with(edges, x, v)


def x_with(edges: Edges, u: Any, low: Any, high: Any) -> Any:
    """Where the share `u` of each area lies to the left."""
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
    """Where the share `v` of each vertical at x that lies in the shape is below."""
    at = x[edges.owner]
    crossing = (edges.left[:, 0] <= at) & (at < edges.right[:, 0])
    owner, at, left, right = (part[crossing] for part in (edges.owner, at, edges.left, edges.right))
    height = left[:, 1] + (right[:, 1] - left[:, 1]) * ((at - left[:, 0]) / (right[:, 0] - left[:, 0]))
    order = np.lexsort((height, owner))
    low, high, whose = height[order][::2], height[order][1::2], owner[order][::2]  # they come in pairs
    lengths = high - low
    ends = np.cumsum(lengths)
    y = np.full(len(x), np.nan)
    rows, number = np.unique(whose, return_inverse=True)
    which, target = found(ends, lengths, number, v[rows])
    y[rows] = np.clip(low[which] + target - (ends[which] - lengths[which]), low[which], high[which])
    return y
