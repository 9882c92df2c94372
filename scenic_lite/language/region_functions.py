"""The functions that make regions and vector fields, with the arguments that Scenic gives them.

Names of arguments that have no meaning in the plane or for arrays (`name`, `resolution`, `z`, `kdTree`)
are accepted. Read next: `values.regions`; `language.region_members`, what regions can be asked.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from copy import copy

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import as_heading
from scenic_lite.language.fields import cells_field, field_of
from scenic_lite.values.geometry import Vector, as_vector, normalised
from scenic_lite.values.graph import Value, apply, is_number
from scenic_lite.values.lines import NEAR, GridRegion, PointSetRegion, PolylineRegion
from scenic_lite.values.polygons import MOST_CORNERS, PolygonalRegion, ShapeRegion, polygon_through
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


def rectangle(position: Value, heading: Value, width: Value, length: Value, name: Value = None) -> Region:
    return RectangularRegion(vector(position), number(heading), size("width", width), size("length", length))


def disc(center: Value, radius: Value, resolution: Value = 32, name: Value = None) -> Region:
    return SectorRegion(vector(center), size("radius", radius))


def sector(
    center: Value, radius: Value, heading: Value, angle: Value, resolution: Value = 32, name: Value = None
) -> Region:
    return SectorRegion(vector(center), size("radius", radius), number(heading), number(angle))


def size(name: str, value: Value) -> Value:
    """Return a length of a region; 0 is a region of one point or line."""
    extent = number(value)
    if is_number(extent) and not 0 <= extent < math.inf:
        raise ScenicError("value", f"the {name} of a region must be finite and not negative, not {extent}")
    return extent


def polygon(
    scope: Scope,
    node: ast.AST,
    points: Value = None,
    polygon: Value = None,
    z: Value = 0,
    orientation: Value = None,
    name: Value = None,
) -> Region:
    """Make a polygon by its corners, or of the shape of other regions (`polygon=other.polygons`)."""
    field = field_or_none(orientation)
    if polygon is not None:
        return reshaped(scope, node, polygon, field)
    corners = corners_of(scope, node, points, 3, "a polygon")
    if all(corner.fixed for corner in corners):
        return polygon_through(fixed(corners), field)
    from scenic_lite.values import shapes

    numbers = [part for corner in corners for part in (corner.x, corner.y)]
    return ShapeRegion(apply(shapes.POLYGON, *numbers), field)


def reshaped(scope: Scope, node: ast.AST, source: Value, orientation: VectorField | None) -> Region:
    """Return the area of one or several regions, with another orientation."""
    from scenic_lite.values import algebra

    parts = [source] if isinstance(source, Region) else scope.elements(source, node)
    for part in parts:
        if not (isinstance(part, Region) and part.dimension == 2):
            raise ScenicError("type", f"polygon= takes the polygons of a region, not {describe_kind(part)}")
    whole = algebra.union_of(parts)
    if isinstance(whole, ShapeRegion):
        return ShapeRegion(whole.shape(), orientation)
    return PolygonalRegion(whole.shape(), orientation)


def polyline(
    scope: Scope,
    node: ast.AST,
    points: Value = None,
    polyline: Value = None,
    orientation: Value = True,
    name: Value = None,
) -> Region:
    """Make one by its points, or of other polylines (`polyline=`); `orientation` True: along the segments."""
    field = True if orientation is True else field_or_none(orientation)
    if polyline is not None:
        if not isinstance(polyline, PolylineRegion):
            raise ScenicError("type", f"polyline= takes a polyline, not {describe_kind(polyline)}")
        return PolylineRegion([chain.tolist() for chain in polyline.chains], field)
    corners = corners_of(scope, node, points, 2, "a polyline")
    if not all(corner.fixed for corner in corners):
        raise ScenicError("unsupported", "the points of a polyline must not be random")
    return PolylineRegion([fixed(corners)], field)


def point_set(
    scope: Scope,
    node: ast.AST,
    name: Value,
    points: Value,
    kdTree: Value = None,
    orientation: Value = None,
    tolerance: Value = NEAR,
) -> Region:
    places = corners_of(scope, node, points, 1, "a set of points")
    if not all(place.fixed for place in places):
        raise ScenicError("unsupported", "the points of this region must not be random")
    return PointSetRegion(fixed(places), field_or_none(orientation), fixed_number("tolerance", tolerance))


def grid(scope: Scope, node: ast.AST, name: Value, grid: Value, *steps: Value, orientation: Value = None) -> Region:
    """`GridRegion(name, grid, Ax, Ay, Bx, By)`: rows of 0 (free) and 1 (obstacle), spacing and lowest left point."""
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
    """Return a region of its own, though of the same points: objects in a workspace are pruned less (`pruning`)."""
    if region is None:
        return Everywhere()
    if not isinstance(region, Region):
        raise ScenicError("type", f"a workspace is made of a region, not {describe_kind(region)}")
    return copy(region)


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
    """Return a heading for each cell, or a function for cells without one; `defaultHeading` outside all."""
    pairs = [cell_of(scope, node, cell) for cell in scope.elements(cells, node)]
    default = None if defaultHeading is None else number(defaultHeading)
    if headingFunction is None and default is None and any(heading is None for _, heading in pairs):
        raise ScenicError("value", "a cell of the field has no heading", hint="give it one, or a headingFunction")
    if headingFunction is None:
        return cells_field(str(name), pairs, lambda point: default, default)
    inner = field_of(scope, node, str(name), headingFunction, heading_for(scope))
    return cells_field(str(name), pairs, inner.heading_at, default)


def cell_of(scope: Scope, node: ast.AST, cell: Value) -> tuple[Region, Value]:
    parts = scope.elements(cell, node)
    if len(parts) != 2 or not isinstance(parts[0], Region):
        raise ScenicError("type", "a cell of a field is a pair of a region and a heading")
    return parts[0], None if parts[1] is None else number(parts[1])


def piecewise_field(
    scope: Scope, node: ast.AST, name: Value, regions: Value, tolerance: Value = 0, defaultHeading: Value = None
) -> VectorField:
    """Return the orientation of the first region that holds the point."""
    parts = scope.elements(regions, node)
    for part in parts:
        if not isinstance(part, Region):
            raise ScenicError("type", f"the field is patched of regions, not {describe_kind(part)}")
    field = patchwork(parts, None if defaultHeading is None else number(defaultHeading))
    if field is None:
        raise ScenicError("value", "none of the regions has an orientation")
    return field


# ------------------------------------------------------------ checks of arguments


def vector(value: Value) -> Vector:
    result = as_vector(value)
    if result is None:
        raise ScenicError("type", f"a vector is needed here, not {describe_kind(value)}")
    return result


def number(value: Value) -> Value:
    heading = as_heading(value)
    if heading is None:
        raise ScenicError("type", f"a number is needed here, not {describe_kind(value)}")
    return heading


def heading_for(scope: Scope) -> Callable[[Value], Value]:
    """Return what a field's function gives, as a heading: dialect 3 normalises it."""
    return number if scope.state.dialect == 2 else lambda value: normalised(number(value))


def fixed_number(what: str, value: Value) -> float:
    if not is_number(value) or not math.isfinite(value):
        raise ScenicError("type", f"the {what} must be a fixed, finite number, not {describe_kind(value)}")
    return float(value)


def field_or_none(value: Value) -> VectorField | None:
    if value is None or isinstance(value, VectorField):
        return value
    if is_number(value):
        return VectorField("constant", lambda point: value)
    raise ScenicError("type", f"an orientation is a vector field, not {describe_kind(value)}")


def corners_of(scope: Scope, node: ast.AST, points: Value, least: int, what: str) -> list[Vector]:
    """Return any number of points, of two coordinates or three. Raises ScenicError if there are too few."""
    if points is None or isinstance(points, RandomChoice | Region):
        raise ScenicError("type", f"{what} is given by a list of points, not {describe_kind(points)}")
    elements = scope.elements(points, node)
    if len(elements) < least:
        raise ScenicError("value", f"{what} needs {least} points or more, not {len(elements)}")
    if len(elements) > MOST_CORNERS:
        raise ScenicError("budget", f"evaluation budget exceeded: {what} of more than {MOST_CORNERS:,} points")
    return [vector(flat(element)) for element in elements]


def flat(point: Value) -> Value:
    """Return a point without its third coordinate."""
    return point[:2] if isinstance(point, list | tuple) and len(point) == 3 else point


def fixed(points: list[Vector]) -> list[Point2]:
    numbers = [(float(point.x), float(point.y)) for point in points]
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in numbers):
        raise ScenicError("value", "the points of a region must be finite")
    return numbers


# name: the function, what `isinstance` takes the name for, and whether the function gets the scope and the call
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
