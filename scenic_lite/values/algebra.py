"""Regions made of regions: intersections, differences and unions, and whether regions meet or hold one another.

Fixed regions are combined once. Regions that differ from scene to scene are combined in every scene (so that a point
drawn from the result is uniform whatever the sizes), by geometry if they have a shape, else by rejection.
Read next: `values.polygons`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

import numpy as np
import shapely

from scenic_lite.errors import ScenicError
from scenic_lite.values import shapes
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.lines import GridRegion, PointSetRegion, PolylineRegion
from scenic_lite.values.operations import NOT, OR, Operation
from scenic_lite.values.polygons import MOST_CORNERS, PolygonalRegion, ShapeRegion
from scenic_lite.values.regions import (
    Everywhere,
    Filtered,
    Nowhere,
    RectangularRegion,
    Region,
    SectorRegion,
    VectorField,
    numbers_of,
    patchwork,
)


def common_part(a: Region, b: Region, dialect: int = 3) -> Region:
    """Return the intersection, with the orientation of `a` if it has one, else of `b`.

    Dialect 2 draws from `b`, and rejects by `a`, where both are random rectangles, discs or sectors: so that those
    which overlap more are the likelier ones.
    """
    if isinstance(a, Everywhere) or isinstance(b, Nowhere):
        return b
    if isinstance(b, Everywhere) or isinstance(a, Nowhere):
        return a
    if a.dimension > b.dimension and b.dimension == 0:
        a, b = b, a
    if isinstance(a, PointSetRegion):
        return chosen_points(a, b, kept=True)
    if isinstance(a, Filtered) or isinstance(b, Filtered):
        return Filtered(a, b.contains)
    simple = RectangularRegion | SectorRegion
    if dialect == 2 and isinstance(a, simple) and isinstance(b, simple) and not (a.fixed() and b.fixed()):
        return Filtered(b, a.contains)
    return made_of(shapes.INTERSECTION, a, b, a.orientation or b.orientation)


def remainder(a: Region, b: Region) -> Region:
    """Return what is in `a` and not in `b`; of a polyline it has no orientation."""
    if isinstance(b, Everywhere):
        return Nowhere()
    if isinstance(b, Nowhere) or isinstance(a, Nowhere):
        return a
    if isinstance(a, PointSetRegion):
        return chosen_points(a, b, kept=False)
    if isinstance(a, Filtered | Everywhere) or isinstance(b, Filtered | PointSetRegion):
        return Filtered(a, lambda point: apply(NOT, b.contains(point)))
    return made_of(shapes.DIFFERENCE, a, b, a.orientation if a.dimension == 2 else None)


def union(a: Region, b: Region) -> Region:
    """Return a region uniform over the whole, also where the two overlap; each part keeps its orientation."""
    if isinstance(a, Everywhere) or isinstance(b, Nowhere):
        return a
    if isinstance(b, Everywhere) or isinstance(a, Nowhere):
        return b
    return made_of(shapes.UNION, a, b, patchwork([a, b]))


def union_of(regions: Iterable[Region]) -> Region:
    """Return the union of any number of regions."""
    nothing: Region = Nowhere()
    return reduce(union, regions, nothing)


def made_of(operation: Operation, a: Region, b: Region, orientation: VectorField | None) -> Region:
    dimension = max(a.dimension, b.dimension) if operation is shapes.UNION else min(a.dimension, b.dimension)
    if operation is shapes.DIFFERENCE:
        dimension = a.dimension
    shape = apply(operation, a.shape(), b.shape())
    return (
        ShapeRegion(shape, orientation, dimension) if isinstance(shape, RandomExpr) else region_of(shape, orientation)
    )


def region_of(shape: Any, orientation: VectorField | None = None) -> Region:
    """Return the region of a fixed shape, whatever it turned out to be."""
    if shape.is_empty:
        return Nowhere()
    if shapely.get_num_coordinates(shape) > MOST_CORNERS:
        raise ScenicError("budget", f"evaluation budget exceeded: a region of more than {MOST_CORNERS:,} corners")
    if shape.area > 0:
        return PolygonalRegion(shape, orientation)
    if shape.length > 0:
        chains = [[tuple(point) for point in line.coords] for line in shapely.get_parts(shape)]
        return PolylineRegion(chains, orientation)
    return PointSetRegion([tuple(point) for point in shapely.get_coordinates(shape)], orientation)


def chosen_points(points: PointSetRegion, other: Region, kept: bool) -> Region:
    """Return the points of a set that lie in another region, or those that do not."""
    inside = [other.contains(Vector(float(x), float(y))) for x, y in points.points]
    if any(isinstance(truth, RandomExpr) for truth in inside):
        return Filtered(points, other.contains if kept else lambda p: apply(NOT, other.contains(p)))
    left = [tuple(point) for point, held in zip(points.points, inside, strict=True) if bool(held) is kept]
    return PointSetRegion(left, points.orientation or other.orientation) if left else Nowhere()


def meet(a: Region, b: Region) -> Value:
    """Return whether two regions have a common point."""
    for first, second in ((a, b), (b, a)):
        if isinstance(first, Everywhere | Nowhere):
            return isinstance(first, Everywhere) and not isinstance(second, Nowhere)
        if isinstance(first, PointSetRegion):
            inside = [second.contains(Vector(float(x), float(y))) for x, y in first.points]
            return reduce(lambda some, truth: apply(OR, some, truth), inside)
    return apply(shapes.MEET, a.shape(), b.shape())


def holds(a: Region, b: Region, tolerance: float = 0.0) -> Value:
    """Return whether all of `b` lies in `a`, or within `tolerance` of it."""
    if isinstance(a, Everywhere) or isinstance(b, Nowhere):
        return True
    if isinstance(a, Nowhere | GridRegion) or isinstance(b, Everywhere):
        return False
    shape = a.shape() if tolerance == 0 else apply(shapes.GROWN, a.shape(), tolerance)
    return apply(shapes.HOLDS_SHAPE, shape, b.shape())


def grown(region: Region, by: Value) -> Region:
    """Return the region and all points within a distance of it (for a negative one, what is so deep inside)."""
    shape = apply(shapes.GROWN, region.shape(), by)
    return ShapeRegion(shape) if isinstance(shape, RandomExpr) else region_of(shape)


def boundary(region: Region) -> Region:
    """Return the boundary of a fixed polygon, as polylines."""
    shape = fixed_shape(region).boundary
    lines = shape.geoms if hasattr(shape, "geoms") else [shape]
    return PolylineRegion([[tuple(point) for point in line.coords] for line in lines])


def fixed_shape(region: Region) -> Any:
    shape = region.shape()
    if isinstance(shape, RandomExpr):
        raise ScenicError("unsupported", "this can be asked of a fixed region only")
    return shape


def size_of(region: Region) -> Value:
    """Return area, length or number of points."""
    if region.dimension == 0:
        return len(region.points) if isinstance(region, PointSetRegion) else None
    return apply(shapes.AREA if region.dimension == 2 else shapes.LENGTH, region.shape())


def depth_of_middle(region: Region) -> Value:
    """Return how far the middle of a region's bounds is from its boundary; 0 outside."""
    return numbers_of(middle_depths, region.shape())


def middle_depths(shape: Any) -> Any:
    low_x, low_y, high_x, high_y = np.moveaxis(shapely.bounds(shape), -1, 0)
    middle = shapely.points((low_x + high_x) / 2, (low_y + high_y) / 2)
    return np.where(shapely.contains(shape, middle), shapely.distance(shapely.boundary(shape), middle), 0.0)
