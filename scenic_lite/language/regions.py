"""Regions and vector fields in programs: the functions that create them, and their methods.

Arguments without a meaning in the plane or for arrays (`name`, `resolution`, `z`, `kdTree`) are accepted but ignored.
Our own tables list the readable attributes; attributes of Python objects are never read. Read next: `values.regions`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from copy import copy
from operator import attrgetter
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, Instance, RandomChoice, describe_kind, needs_context, of_values
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import is_object, number_of, oriented_point, outline, region_of, vector_of
from scenic_lite.language.distributions import point_in
from scenic_lite.language.fields import UNPLACED, along, cells_field, field_of
from scenic_lite.values import polygons
from scenic_lite.values.geometry import Vector, normalized
from scenic_lite.values.graph import Value, is_number
from scenic_lite.values.lines import NEAR, GridRegion, PointSetRegion, PolylineRegion
from scenic_lite.values.polygons import MOST_CORNERS, PolygonalRegion, ShapeRegion, polygon_through, union_of
from scenic_lite.values.regions import (
    Everywhere,
    Nowhere,
    Point2,
    RectangularRegion,
    Region,
    SectorRegion,
    VectorField,
    patchwork,
)

MOST_POINTS = 100_000  # maximum number along one polyline
COST = 10_000  # memory charge for a combination of two regions, in elements


def rectangle(position: Value, heading: Value, width: Value, length: Value, name: Value = None) -> Region:
    return RectangularRegion(vector_of(position), number_of(heading), size("width", width), size("length", length))


def disc(center: Value, radius: Value, resolution: Value = 32, name: Value = None) -> Region:
    return SectorRegion(vector_of(center), size("radius", radius))


def sector(
    center: Value, radius: Value, heading: Value, angle: Value, resolution: Value = 32, name: Value = None
) -> Region:
    return SectorRegion(vector_of(center), size("radius", radius), number_of(heading), number_of(angle))


def size(name: str, value: Value) -> Value:
    """Check and return a side length or radius of a region; 0 gives a single point or line."""
    extent = number_of(value)
    if is_number(extent) and not 0 <= extent < math.inf:
        raise ScenicError("value", f"the {name} of a region must be finite and not negative, not {extent}")
    return extent


def polygon(
    scope: Scope, node: ast.AST, points: Value, z: Value = 0, orientation: Value = None, name: Value = None
) -> Region:
    return polygon_through(corners_of(scope, node, points, 3, "a polygon"), field_or_none(orientation))


def polyline(scope: Scope, node: ast.AST, points: Value, orientation: Value = True, name: Value = None) -> Region:
    """Create a polyline from its points; `orientation` True: headings along the segments."""
    field = True if orientation is True else field_or_none(orientation)
    return PolylineRegion([fixed_points(scope, node, points, 2, "a polyline")], field)


def point_set(
    scope: Scope,
    node: ast.AST,
    name: Value,
    points: Value,
    kdTree: Value = None,
    orientation: Value = None,
    tolerance: Value = NEAR,
) -> Region:
    places = fixed_points(scope, node, points, 1, "a set of points")
    return PointSetRegion(places, field_or_none(orientation), fixed_number("tolerance", tolerance))


def grid(scope: Scope, node: ast.AST, name: Value, grid: Value, *steps: Value, orientation: Value = None) -> Region:
    """Create `GridRegion(name, grid, Ax, Ay, Bx, By)`: rows of 0 (free) or 1 (obstacle), spacing, lower left point."""
    if len(steps) not in (4, 5):
        raise ScenicError("type", "a grid needs its spacing and its lowest left point", hint="write Ax, Ay, Bx, By")
    rows = [scope.elements(row, node) for row in scope.elements(grid, node)]
    if not rows or len({len(row) for row in rows}) != 1 or not all(is_number(cell) for row in rows for cell in row):
        raise ScenicError("value", "a grid is a list of rows of numbers, all of one length")
    ax, ay, bx, by = (fixed_number("spacing", step) for step in steps[:4])
    if ax == 0 or ay == 0:
        raise ScenicError("value", "the spacing of a grid must not be 0")
    return GridRegion(rows, (ax, ay), (bx, by), field_or_none(steps[4] if len(steps) == 5 else orientation))


def workspace(region: Value = None) -> Region:
    """Return a copy of the region, since `pruning` treats points drawn from the workspace itself differently."""
    if not isinstance(region, Region | None):
        raise ScenicError("type", f"a workspace is made of a region, not {describe_kind(region)}")
    return Everywhere() if region is None else copy(region)


# ------------------------------------------------------------ fields
def vector_field(
    scope: Scope, node: ast.AST, name: Value, value: Value, minSteps: Value = 4, defaultStepSize: Value = 5
) -> VectorField:
    field = field_of(scope, node, str(name), value, heading_for(scope))
    least = fixed_number("least number of steps", minSteps)
    if not 1 <= least <= 1000:
        raise ScenicError("value", f"a field is followed in 1 to 1000 steps, not {least}")
    field.least_steps = math.ceil(least)
    field.longest_step = None if defaultStepSize is None else fixed_number("step", defaultStepSize)
    if field.longest_step is not None and not field.longest_step > 0:
        raise ScenicError("value", f"the step along a field must be positive, not {field.longest_step}")
    return field


def polygonal_field(
    scope: Scope, node: ast.AST, name: Value, cells: Value, headingFunction: Value = None, defaultHeading: Value = None
) -> VectorField:
    """Return a field with a heading per cell, `headingFunction` in other cells, `defaultHeading` outside all cells."""
    pairs = [cell_of(scope, node, cell) for cell in scope.elements(cells, node)]
    default = None if defaultHeading is None else number_of(defaultHeading)
    if headingFunction is None and default is None and any(heading is None for _, heading in pairs):
        raise ScenicError("value", "a cell of the field has no heading", hint="give it one, or a headingFunction")
    if headingFunction is not None:
        inner = field_of(scope, node, str(name), headingFunction, heading_for(scope))
    else:
        inner = VectorField(str(name), lambda point: default)
    return cells_field(str(name), pairs, inner.heading_at, default)


def cell_of(scope: Scope, node: ast.AST, cell: Value) -> tuple[Region, Value]:
    parts = scope.elements(cell, node)
    if len(parts) != 2 or not isinstance(parts[0], Region):
        raise ScenicError("type", "a cell of a field is a pair of a region and a heading")
    return parts[0], None if parts[1] is None else number_of(parts[1])


def piecewise_field(
    scope: Scope, node: ast.AST, name: Value, regions: Value, tolerance: Value = 0, defaultHeading: Value = None
) -> VectorField:
    """Return the field with the orientation of the first region that contains the point."""
    parts = [region_of(part, "PiecewiseVectorField") for part in scope.elements(regions, node)]
    field = patchwork(parts, None if defaultHeading is None else number_of(defaultHeading))
    if field is None:
        raise ScenicError("value", "none of the regions has an orientation")
    return field


def heading_for(scope: Scope) -> Callable[[Value], Value]:
    """Return the conversion of a function's result to a heading; dialect 3 normalizes the heading."""
    return number_of if scope.state.dialect == 2 else lambda value: normalized(number_of(value))


def field_or_none(value: Value) -> VectorField | None:
    if value is None or isinstance(value, VectorField):
        return value
    if is_number(value):
        return VectorField("constant", lambda point: value)
    raise ScenicError("type", f"an orientation is a vector field, not {describe_kind(value)}")


# ------------------------------------------------------------ checks of arguments
def fixed_number(what: str, value: Value) -> float:
    if not is_number(value) or not math.isfinite(value):
        raise ScenicError("type", f"the {what} must be a fixed, finite number, not {describe_kind(value)}")
    return float(value)


def corners_of(scope: Scope, node: ast.AST, points: Value, least: int, what: str) -> list[Vector]:
    """Return a list of points with two or three coordinates each. Raises ScenicError for too few or too many points."""
    if points is None or isinstance(points, RandomChoice | Region):
        raise ScenicError("type", f"{what} is given by a list of points, not {describe_kind(points)}")
    elements = scope.elements(points, node)
    if len(elements) < least:
        raise ScenicError("value", f"{what} needs {least} points or more, not {len(elements)}")
    if len(elements) > MOST_CORNERS:
        raise ScenicError("budget", f"evaluation budget exceeded: {what} of more than {MOST_CORNERS:,} points")
    flat = [part[:2] if isinstance(part, list | tuple) and len(part) == 3 else part for part in elements]
    corners = [vector_of(part) for part in flat]
    if not all(math.isfinite(part) for at in corners for part in (at.x, at.y) if is_number(part)):
        raise ScenicError("value", "the points of a region must be finite")
    return corners


def fixed_points(scope: Scope, node: ast.AST, points: Value, least: int, what: str) -> list[Point2]:
    corners = corners_of(scope, node, points, least, what)
    if not all(corner.fixed for corner in corners):
        raise ScenicError("unsupported", f"the points of {what} must not be random")
    return [(float(corner.x), float(corner.y)) for corner in corners]


def limited(count: float) -> float:
    if not 0 <= count <= MOST_POINTS:
        raise ScenicError("budget", f"evaluation budget exceeded: {count:,.0f} points along a polyline")
    return count


# ------------------------------------------------------------ methods of regions
def contains_object(self: Region, instance: Value) -> Value:
    if not is_object(instance):
        raise ScenicError("type", f"containsObject needs an object, not {describe_kind(instance)}")
    return self.contains_corners(outline(instance))


def bounds(self: Region) -> tuple:
    """Return ((low x, low y), (high x, high y))."""
    limits = self.bounds()
    if limits is None:
        raise ScenicError("unsupported", "only fixed, bounded regions support this")
    low_x, high_x, low_y, high_y = limits
    return (low_x, low_y), (high_x, high_y)


def nearest_segment(self: PolylineRegion, point: Value) -> tuple[Vector, Vector]:
    at = vector_of(point)
    if not at.fixed:
        raise ScenicError("unsupported", "only fixed points have a nearest segment")
    start, end = segments(self)[int(self.nearest(at.x, at.y)[0])]
    return Vector(*start), Vector(*end)


def spaced_points(self: PolylineRegion, num: Value) -> list[Vector]:
    count = limited(fixed_number("number of points", num))
    return [self.along(float(distance)) for distance in np.linspace(0, self.length, int(count))]


def separated_points(self: PolylineRegion, distance: Value) -> list[Vector]:
    gap = fixed_number("distance", distance)
    if not gap > 0:
        raise ScenicError("value", f"the distance between points must be positive, not {gap}")
    limited(self.length / gap)
    return [self.along(float(at)) for at in np.arange(0, self.length, gap)]


def combining(scope: Scope) -> Any:
    """Return `values.polygons` for the combination of two regions, and charge its memory."""
    scope.mode.budget.spend(COST)
    return polygons


def follow_from(self: VectorField, pos: Value, dist: Value, steps: Value = None, stepSize: Value = None) -> Vector:
    field = copy(self)
    if steps is not None:
        field.least_steps, field.longest_step = int(limited(fixed_number("number of steps", steps))), None
    elif stepSize is not None:
        field.longest_step = fixed_number("step", stepSize)
    return along(field, vector_of(pos), number_of(dist))


def is_endless(self: Region) -> bool:
    try:
        self.shape()
    except ScenicError:
        return True
    return False


def area(self: Region) -> Value:
    return None if is_endless(self) else polygons.size_of(self)


def end_of(self: PolylineRegion, which: int) -> Instance:
    """Return an OrientedPoint at the start (0) or end (-1) of a polyline."""
    place = Vector(*self.chains[which][which].tolist())
    heading: Value = float(self.headings[which])
    if not self.own_direction:
        heading = 0.0 if self.orientation is None else self.orientation.heading_at(place)
    return oriented_point(place, heading, UNPLACED)


def segments(self: PolylineRegion) -> list:
    return [(tuple(a.tolist()), tuple((a + step).tolist())) for a, step in zip(self.starts, self.steps, strict=True)]


def item_of(self: Region | VectorField, index: Value) -> Value:
    """Return `field[v]` or `polyline[i]`."""
    if isinstance(self, VectorField):
        return self.heading_at(vector_of(index))
    if not isinstance(self, PolylineRegion) or not is_number(index) or index != int(index):
        raise ScenicError("type", f"{describe_kind(self)} has no elements to index")
    return Vector(*self.vertices()[int(index)])


def chain_all(scope: Scope, node: ast.AST, regions: Value) -> Region:
    """Combine several polylines into one."""
    parts = scope.elements(regions, node)
    if not all(isinstance(part, PolylineRegion) for part in parts):
        raise ScenicError("type", "only polylines are made into one")
    return PolylineRegion([chain for part in parts for chain in part.chains]) if parts else Nowhere()


# ------------------------------------------------------------ the tables

METHODS = of_values(
    containsPoint=lambda self, point: self.contains(vector_of(point)),
    containsObject=contains_object,
    containsRegion=lambda self, reg, tolerance=0: polygons.holds(
        self, region_of(reg), fixed_number("tolerance", tolerance)
    ),
    intersects=lambda self, other: polygons.meet(self, region_of(other)),
    distanceTo=lambda self, point: self.distance(vector_of(point)),
    getAABB=bounds,
)
COMBINATIONS: dict[str, Callable[..., Value]] = {
    "intersect": lambda scope, node, self, other: combining(scope).common_part(
        self, region_of(other), scope.state.dialect
    ),
    "difference": lambda scope, node, self, other: combining(scope).remainder(self, region_of(other)),
    "union": lambda scope, node, self, other, buf=0: combining(scope).union(self, region_of(other)),
    "buffer": lambda scope, node, self, amount: combining(scope).grown(self, number_of(amount)),
}
METHODS |= {name: Builtin(name, combine, needs_context=True) for name, combine in COMBINATIONS.items()}
LINE_METHODS = of_values(
    signedDistanceTo=lambda self, point: self.signed_distance(vector_of(point)),
    project=lambda self, point: self.projected(vector_of(point)),
    nearestSegmentTo=nearest_segment,
    pointAlongBy=lambda self, distance, normalized=False: self.along(number_of(distance), normalized),
    equallySpacedPoints=spaced_points,
    pointsSeparatedBy=separated_points,
)

FIELDS: dict[str, Callable[[Any], Value]] = {
    "orientation": attrgetter("orientation"),
    "name": lambda self: None,
    "z": lambda self: 0.0,
    "boundary": polygons.boundary,
    "area": area,
    "size": area,
    "dimensionality": lambda self: None if is_endless(self) else self.dimension,
    "AABB": lambda self: tuple((*corner, 0.0) for corner in bounds(self)),
}
RECTANGLE_FIELDS: dict[str, Callable[[Any], Value]] = {
    **{name: attrgetter(name) for name in ("position", "heading", "width", "length")},
    "corners": lambda self: tuple(self.corners()),
}
SECTOR_FIELDS: dict[str, Callable[[Any], Value]] = {
    **{name: attrgetter(name) for name in ("center", "heading", "radius", "angle")},
    "position": attrgetter("center"),
}
LINE_FIELDS: dict[str, Callable[[Any], Value]] = {
    "length": attrgetter("length"),
    "points": lambda self: tuple(self.vertices()),
    "segments": segments,
    "start": lambda self: end_of(self, 0),
    "end": lambda self: end_of(self, -1),
}
# Attributes of values by class; the first matching row counts.
REGION_METHODS = (
    (PolylineRegion, METHODS | LINE_METHODS),
    (Region, METHODS),
    (VectorField, of_values(followFrom=follow_from)),
)
REGION_FIELDS: tuple[tuple[type, dict[str, Callable[[Any], Value]]], ...] = (
    (RectangularRegion, FIELDS | RECTANGLE_FIELDS),
    (SectorRegion, FIELDS | SECTOR_FIELDS),
    (PolylineRegion, FIELDS | LINE_FIELDS),
    (PolygonalRegion, FIELDS | {"points": lambda self: tuple((x, y) for x, y, _, _ in self.edges.tolist())}),
    (PointSetRegion, FIELDS | {"points": lambda self: [(x, y) for x, y in self.points.tolist()]}),
    (Region, FIELDS),
    (VectorField, {"name": attrgetter("name")}),
)
CLASS_FUNCTIONS = {
    "PolygonalRegion": needs_context(
        unionAll=lambda scope, node, regions, buf=0: union_of(map(region_of, scope.elements(regions, node)))
    ),
    "PolylineRegion": needs_context(unionAll=chain_all),
    "Region": needs_context(uniformPointIn=lambda scope, node, region: point_in(scope, node, region)[0]),
    "VectorField": needs_context(
        forUnionOf=lambda scope, node, regions, tolerance=0: patchwork(
            [region_of(part) for part in scope.elements(regions, node)]
        )
    ),
}
# name: the function, the types of the name for `isinstance`, and whether the function takes the scope and the call
CLASSES: dict[str, tuple[Callable[..., Value], tuple[type, ...], bool]] = {
    "RectangularRegion": (rectangle, (RectangularRegion,), False),
    "CircularRegion": (disc, (SectorRegion,), False),
    "SectorRegion": (sector, (SectorRegion,), False),
    "PolygonalRegion": (polygon, (PolygonalRegion, ShapeRegion, RectangularRegion, SectorRegion), True),
    "PolylineRegion": (polyline, (PolylineRegion,), True),
    "PointSetRegion": (point_set, (PointSetRegion,), True),
    "GridRegion": (grid, (GridRegion,), True),
    "Region": (workspace, (Region,), False),
    "Workspace": (workspace, (Region,), False),
    "VectorField": (vector_field, (VectorField,), True),
    "PolygonalVectorField": (polygonal_field, (VectorField,), True),
    "PiecewiseVectorField": (piecewise_field, (VectorField,), True),
}
REGIONS: dict[str, Value] = {"everywhere": Everywhere(), "nowhere": Nowhere()} | {
    name: Builtin(name, function, needs_context=scoped, types=types, over_choices=not scoped)
    for name, (function, types, scoped) in CLASSES.items()
}
