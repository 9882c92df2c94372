"""What regions and vector fields can be asked: `region.containsPoint(v)`, `region.area`, `field[v]`.

Tables of our own, never the attributes of Python objects. Read next: `values.algebra`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from scenic_lite.core.builtin_tables import needs_context, own
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, Instance, describe_kind
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.language.classes import is_object, oriented_point, outline
from scenic_lite.language.distributions import point_in
from scenic_lite.language.fields import along
from scenic_lite.language.region_functions import fixed_number, number, vector
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import Value, is_number
from scenic_lite.values.lines import PointSetRegion, PolylineRegion
from scenic_lite.values.polygons import PolygonalRegion
from scenic_lite.values.regions import Nowhere, RectangularRegion, Region, SectorRegion, VectorField, patchwork

MOST_POINTS = 100_000  # along one polyline
COST = 10_000  # elements of memory that the combination of two regions counts for


def contains_point(self: Region, point: Value) -> Value:
    return self.contains(vector(point))


def contains_object(self: Region, instance: Value) -> Value:
    if not is_object(instance):
        raise ScenicError("type", f"containsObject needs an object, not {describe_kind(instance)}")
    return self.contains_corners(outline(instance))


def contains_region(self: Region, reg: Value, tolerance: Value = 0) -> Value:
    from scenic_lite.values import algebra

    return algebra.holds(self, region(reg), fixed_number("tolerance", tolerance))


def intersect(scope: Scope, node: Any, self: Region, other: Value) -> Region:
    from scenic_lite.values import algebra

    scope.mode.budget.spend(COST)
    return algebra.common_part(self, region(other), scope.state.dialect)


def difference(scope: Scope, node: Any, self: Region, other: Value) -> Region:
    from scenic_lite.values import algebra

    scope.mode.budget.spend(COST)
    return algebra.remainder(self, region(other))


def union(scope: Scope, node: Any, self: Region, other: Value, buf: Value = 0) -> Region:
    from scenic_lite.values import algebra

    scope.mode.budget.spend(COST)
    return algebra.union(self, region(other))


def intersects(self: Region, other: Value) -> Value:
    from scenic_lite.values import algebra

    return algebra.meet(self, region(other))


def buffer(scope: Scope, node: Any, self: Region, amount: Value) -> Region:
    from scenic_lite.values import algebra

    scope.mode.budget.spend(COST)
    return algebra.grown(self, number(amount))


def distance_to(self: Region, point: Value) -> Value:
    return self.distance(vector(point))


def bounds(self: Region) -> tuple:
    """((low x, low y), (high x, high y))."""
    found = self.bounds()
    if found is None:
        raise ScenicError("unsupported", "this can be asked of a fixed, bounded region only")
    low_x, high_x, low_y, high_y = found
    return (low_x, low_y), (high_x, high_y)


def signed_distance(self: Region, point: Value) -> Value:
    return line(self).signed_distance(vector(point))


def project(self: Region, point: Value) -> Vector:
    return line(self).projected(vector(point))


def nearest_segment(self: Region, point: Value) -> tuple[Vector, Vector]:
    at, chain = vector(point), line(self)
    if not at.fixed:
        raise ScenicError("unsupported", "the nearest segment can be asked of a fixed point only")
    which = int(chain.nearest(at.x, at.y)[0])
    start, end = chain.starts[which], chain.starts[which] + chain.steps[which]
    return Vector(*map(float, start)), Vector(*map(float, end))


def point_along(self: Region, distance: Value, normalized: bool = False) -> Vector:
    return line(self).along(number(distance), normalized)


def spaced_points(scope: Scope, node: Any, self: Region, num: Value) -> list[Vector]:
    count = fixed_number("number of points", num)
    return points_at(scope, self, np.linspace(0, line(self).length, int(limited(count))))


def separated_points(scope: Scope, node: Any, self: Region, distance: Value) -> list[Vector]:
    gap = fixed_number("distance", distance)
    if not gap > 0:
        raise ScenicError("value", f"the distance between points must be positive, not {gap}")
    limited(line(self).length / gap)
    return points_at(scope, self, np.arange(0, line(self).length, gap))


def points_at(scope: Scope, self: Region, distances: Any) -> list[Vector]:
    scope.mode.budget.container(len(distances))
    return [line(self).along(float(distance)) for distance in distances]


def limited(count: float) -> float:
    if not 0 <= count <= MOST_POINTS:
        raise ScenicError("budget", f"evaluation budget exceeded: {count:,.0f} points along a polyline")
    return count


def region(value: Value) -> Region:
    if not isinstance(value, Region):
        raise ScenicError("type", f"a region is needed here, not {describe_kind(value)}")
    return value


def line(value: Region) -> PolylineRegion:
    if not isinstance(value, PolylineRegion):
        raise ScenicError("name", f"{describe_kind(value)} that is no polyline has no such method")
    return value


def follow_from(self: VectorField, pos: Value, dist: Value, steps: Value = None, stepSize: Value = None) -> Vector:
    field = VectorField(self.name, self.heading_at, self.least_steps, self.longest_step)
    if steps is not None:
        field.least_steps, field.longest_step = int(limited(fixed_number("number of steps", steps))), None
    elif stepSize is not None:
        field.longest_step = fixed_number("step", stepSize)
    return along(field, vector(pos), number(dist))


# ------------------------------------------------------------ of classes


def union_all(scope: Scope, node: Any, regions: Value, buf: Value = 0) -> Region:
    from scenic_lite.values import algebra

    return algebra.union_of(region(each) for each in scope.elements(regions, node))


def chain_all(scope: Scope, node: Any, regions: Value) -> Region:
    """Several polylines as one."""
    parts = [line(region(each)) for each in scope.elements(regions, node)]
    if not parts:
        return Nowhere()
    return PolylineRegion([chain.tolist() for part in parts for chain in part.chains])


def uniform_point(scope: Scope, node: Any, region: Value) -> Vector:
    return point_in(scope, node, region)[0]


def field_of_union(scope: Scope, node: Any, regions: Value, tolerance: Value = 0) -> VectorField | None:
    return patchwork([region(each) for each in scope.elements(regions, node)])


# ------------------------------------------------------------ attributes


def boundary(self: Region) -> Region:
    from scenic_lite.values import algebra

    return algebra.boundary(self)


def polygons(self: Region) -> Region:
    if self.dimension != 2 or is_endless(self):
        raise ScenicError("name", f"{describe_kind(self)} without an area has no polygons")
    return self


def is_endless(self: Region) -> bool:
    try:
        self.shape()
    except ScenicError:
        return True
    return False


def area(self: Region) -> Value:
    from scenic_lite.values import algebra

    return None if is_endless(self) else algebra.size_of(self)


def inradius(self: Region) -> Value:
    from scenic_lite.values import algebra

    return algebra.depth_of_middle(self)


def points(self: Region) -> Value:
    """The corners of a polygon, the points of a polyline or a set: pairs."""
    if isinstance(self, PolylineRegion):
        return tuple(self.vertices())
    if isinstance(self, PointSetRegion):
        return [(float(x), float(y)) for x, y in self.points]
    if isinstance(self, PolygonalRegion):
        return tuple((float(x), float(y)) for x, y, _, _ in self.edges)
    raise ScenicError("name", "only polygons, polylines and sets of points have points")


def end_of(self: Region, last: bool) -> Instance:
    """An OrientedPoint at the start or end of a polyline."""
    chain = line(self)
    at = chain.chains[-1][-1] if last else chain.chains[0][0]
    place = Vector(float(at[0]), float(at[1]))
    heading: Value = float(chain.headings[-1 if last else 0])
    if not chain.own_direction:
        heading = 0.0 if chain.orientation is None else chain.orientation.heading_at(place)
    return oriented_point(place, heading, SourceSpan("", 1, 0, 1, 1))


def segments(self: Region) -> list:
    chain = line(self)
    return [(tuple(a.tolist()), tuple((a + step).tolist())) for a, step in zip(chain.starts, chain.steps, strict=True)]


def parameter(name: str) -> Callable[[Region], Value]:
    """A parameter of a rectangle, disc, sector or polyline."""

    def read(self: Region) -> Value:
        if isinstance(self, SectorRegion) and name == "position":
            return self.center
        if isinstance(self, RectangularRegion) and name == "radius":
            return Vector(self.width / 2, self.length / 2).length()
        if name not in vars(self):
            raise ScenicError("name", f"{type(self).__name__} has no attribute '{name}'")
        return vars(self)[name]

    return read


def rectangle_corners(self: Region) -> tuple[Vector, ...]:
    if not isinstance(self, RectangularRegion):
        raise ScenicError("name", f"{type(self).__name__} has no attribute 'corners'")
    return tuple(self.corners())


def circumcircle(self: Region) -> tuple[Vector, Value]:
    if isinstance(self, SectorRegion):
        return self.center, self.radius
    return parameter("position")(self), parameter("radius")(self)


def item_of(self: Region | VectorField, index: Value) -> Value:
    """`field[v]` and `polyline[i]`."""
    if isinstance(self, VectorField):
        return self.heading_at(vector(index))
    if not isinstance(self, PolylineRegion) or not is_number(index) or index != int(index):
        raise ScenicError("type", f"{describe_kind(self)} has no elements to index")
    return Vector(*self.vertices()[int(index)])


REGION_METHODS = own(
    containsPoint=contains_point,
    containsObject=contains_object,
    containsRegion=contains_region,
    intersects=intersects,
    distanceTo=distance_to,
    getAABB=bounds,
    signedDistanceTo=signed_distance,
    project=project,
    nearestSegmentTo=nearest_segment,
    pointAlongBy=point_along,
) | needs_context(equallySpacedPoints=spaced_points, pointsSeparatedBy=separated_points)
for combine in (intersect, difference, union, buffer):
    REGION_METHODS[combine.__name__] = Builtin(combine.__name__, combine, needs_context=True)
REGION_FIELDS: dict[str, Callable[[Any], Value]] = {
    **{name: parameter(name) for name in ("position", "center", "heading", "width", "length", "radius", "angle")},
    "orientation": lambda self: self.orientation,
    "name": lambda self: None,
    "corners": rectangle_corners,
    "circumcircle": circumcircle,
    "hw": lambda self: parameter("width")(self) / 2,
    "hl": lambda self: parameter("length")(self) / 2,
    "z": lambda self: 0.0,
    "polygons": polygons,
    "polygon": polygons,
    "boundary": boundary,
    "area": area,
    "size": area,
    "dimensionality": lambda self: None if is_endless(self) else self.dimension,
    "inradius": inradius,
    "AABB": lambda self: tuple((*corner, 0.0) for corner in bounds(self)),
    "points": points,
    "segments": segments,
    "lineString": line,
    "start": lambda self: end_of(self, last=False),
    "end": lambda self: end_of(self, last=True),
}
CLASS_FUNCTIONS = {
    "PolygonalRegion": needs_context(unionAll=union_all),
    "PolylineRegion": needs_context(unionAll=chain_all),
    "Region": needs_context(uniformPointIn=uniform_point),
    "VectorField": needs_context(forUnionOf=field_of_union),
}
FIELD_METHODS = own(followFrom=follow_from)
FIELD_FIELDS: dict[str, Callable[[Any], Value]] = {"name": lambda self: self.name}
