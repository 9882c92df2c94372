"""What regions and vector fields can be asked: `region.containsPoint(v)`, `region.area`, `field[v]`.

Tables of our own, never the attributes of Python objects. Read next: `values.algebra`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, Instance, describe_kind, needs_context, of_values
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


def algebra() -> Any:
    """Return `values.algebra`, which is heavy: it loads shapely."""
    from scenic_lite.values import algebra as module

    return module


def region(value: Value) -> Region:
    if not isinstance(value, Region):
        raise ScenicError("type", f"a region is needed here, not {describe_kind(value)}")
    return value


def line(value: Region) -> PolylineRegion:
    if not isinstance(value, PolylineRegion):
        raise ScenicError("name", f"{describe_kind(value)} that is no polyline has no such method")
    return value


def limited(count: float) -> float:
    if not 0 <= count <= MOST_POINTS:
        raise ScenicError("budget", f"evaluation budget exceeded: {count:,.0f} points along a polyline")
    return count


# ------------------------------------------------------------ methods


def contains_object(self: Region, instance: Value) -> Value:
    if not is_object(instance):
        raise ScenicError("type", f"containsObject needs an object, not {describe_kind(instance)}")
    return self.contains_corners(outline(instance))


def combining(scope: Scope) -> Any:
    """Return `values.algebra` to combine regions with, which counts as much as many elements."""
    scope.mode.budget.spend(COST)
    return algebra()


def bounds(self: Region) -> tuple:
    """Return ((low x, low y), (high x, high y))."""
    limits = self.bounds()
    if limits is None:
        raise ScenicError("unsupported", "this can be asked of a fixed, bounded region only")
    low_x, high_x, low_y, high_y = limits
    return (low_x, low_y), (high_x, high_y)


def nearest_segment(self: Region, point: Value) -> tuple[Vector, Vector]:
    at, chain = vector(point), line(self)
    if not at.fixed:
        raise ScenicError("unsupported", "the nearest segment can be asked of a fixed point only")
    which = int(chain.nearest(at.x, at.y)[0])
    start, end = chain.starts[which], chain.starts[which] + chain.steps[which]
    return Vector(*map(float, start)), Vector(*map(float, end))


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


def follow_from(self: VectorField, pos: Value, dist: Value, steps: Value = None, stepSize: Value = None) -> Vector:
    field = VectorField(self.name, self.heading_at, self.least_steps, self.longest_step)
    if steps is not None:
        field.least_steps, field.longest_step = int(limited(fixed_number("number of steps", steps))), None
    elif stepSize is not None:
        field.longest_step = fixed_number("step", stepSize)
    return along(field, vector(pos), number(dist))


REGION_METHODS = of_values(
    containsPoint=lambda self, point: self.contains(vector(point)),
    containsObject=contains_object,
    containsRegion=lambda self, reg, tolerance=0: algebra().holds(
        self, region(reg), fixed_number("tolerance", tolerance)
    ),
    intersects=lambda self, other: algebra().meet(self, region(other)),
    distanceTo=lambda self, point: self.distance(vector(point)),
    getAABB=bounds,
    signedDistanceTo=lambda self, point: line(self).signed_distance(vector(point)),
    project=lambda self, point: line(self).projected(vector(point)),
    nearestSegmentTo=nearest_segment,
    pointAlongBy=lambda self, distance, normalized=False: line(self).along(number(distance), normalized),
)
REGION_METHODS |= needs_context(equallySpacedPoints=spaced_points, pointsSeparatedBy=separated_points)
COMBINATIONS: dict[str, Callable[..., Value]] = {
    "intersect": lambda scope, node, self, other: combining(scope).common_part(
        self, region(other), scope.state.dialect
    ),
    "difference": lambda scope, node, self, other: combining(scope).remainder(self, region(other)),
    "union": lambda scope, node, self, other, buf=0: combining(scope).union(self, region(other)),
    "buffer": lambda scope, node, self, amount: combining(scope).grown(self, number(amount)),
}
REGION_METHODS |= {name: Builtin(name, combine, needs_context=True) for name, combine in COMBINATIONS.items()}
FIELD_METHODS = of_values(followFrom=follow_from)


# ------------------------------------------------------------ of classes


def chain_all(scope: Scope, node: Any, regions: Value) -> Region:
    """Return several polylines as one."""
    parts = [line(region(part)) for part in scope.elements(regions, node)]
    if not parts:
        return Nowhere()
    return PolylineRegion([chain.tolist() for part in parts for chain in part.chains])


CLASS_FUNCTIONS = {
    "PolygonalRegion": needs_context(
        unionAll=lambda scope, node, regions, buf=0: algebra().union_of(map(region, scope.elements(regions, node)))
    ),
    "PolylineRegion": needs_context(unionAll=chain_all),
    "Region": needs_context(uniformPointIn=lambda scope, node, region: point_in(scope, node, region)[0]),
    "VectorField": needs_context(
        forUnionOf=lambda scope, node, regions, tolerance=0: patchwork(
            [region(part) for part in scope.elements(regions, node)]
        )
    ),
}


# ------------------------------------------------------------ attributes


def parameter(name: str) -> Callable[[Region], Value]:
    """Return a parameter of a rectangle, disc, sector or polyline."""

    def read(self: Region) -> Value:
        if isinstance(self, SectorRegion) and name == "position":
            return self.center
        if isinstance(self, RectangularRegion) and name in ("radius", "corners"):
            return tuple(self.corners()) if name == "corners" else Vector(self.width / 2, self.length / 2).length()
        if name not in vars(self):
            raise ScenicError("name", f"{type(self).__name__} has no attribute '{name}'")
        return vars(self)[name]

    return read


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
    return None if is_endless(self) else algebra().size_of(self)


def points(self: Region) -> Value:
    """Return the corners of a polygon, the points of a polyline or a set: pairs."""
    if isinstance(self, PolylineRegion):
        return tuple(self.vertices())
    if isinstance(self, PointSetRegion):
        return [(float(x), float(y)) for x, y in self.points]
    if isinstance(self, PolygonalRegion):
        return tuple((float(x), float(y)) for x, y, _, _ in self.edges)
    raise ScenicError("name", "only polygons, polylines and sets of points have points")


def end_of(self: Region, last: bool) -> Instance:
    """Return an OrientedPoint at the start or end of a polyline."""
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


PARAMETERS = ("position", "center", "heading", "width", "length", "radius", "angle", "corners")
REGION_FIELDS: dict[str, Callable[[Any], Value]] = {
    **{name: parameter(name) for name in PARAMETERS},
    "hw": lambda self: parameter("width")(self) / 2,
    "hl": lambda self: parameter("length")(self) / 2,
    "circumcircle": lambda self: (parameter("position")(self), parameter("radius")(self)),
    "orientation": lambda self: self.orientation,
    "name": lambda self: None,
    "z": lambda self: 0.0,
    "polygons": polygons,
    "polygon": polygons,
    "boundary": lambda self: algebra().boundary(self),
    "area": area,
    "size": area,
    "dimensionality": lambda self: None if is_endless(self) else self.dimension,
    "inradius": lambda self: algebra().depth_of_middle(self),
    "AABB": lambda self: tuple((*corner, 0.0) for corner in bounds(self)),
    "points": points,
    "segments": segments,
    "lineString": line,
    "start": lambda self: end_of(self, last=False),
    "end": lambda self: end_of(self, last=True),
}
FIELD_FIELDS: dict[str, Callable[[Any], Value]] = {"name": lambda self: self.name}


def item_of(self: Region | VectorField, index: Value) -> Value:
    """`field[v]` and `polyline[i]`."""
    if isinstance(self, VectorField):
        return self.heading_at(vector(index))
    if not isinstance(self, PolylineRegion) or not is_number(index) or index != int(index):
        raise ScenicError("type", f"{describe_kind(self)} has no elements to index")
    return Vector(*self.vertices()[int(index)])
