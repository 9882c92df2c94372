"""Pruning: a point is drawn only from the part of its region in which the object fits into its container.

The valid scenes and their distribution do not change, since the pruned part would be rejected; only fewer levels are
invalid. Pruning applies to objects without noise at a drawn point, or at a fixed offset from a drawn point.
Read next: `scene.constraints`, which tests the remaining conditions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from scenic_lite.core.state import DrawnPoint, LoadState
from scenic_lite.core.types import Instance
from scenic_lite.errors import ScenicError
from scenic_lite.language.distributions import show_coordinates, span_between
from scenic_lite.scene.constraints import containers
from scenic_lite.values import shapes
from scenic_lite.values.formulas import ARC_SEGMENTS, CLOSENESS, TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Table, ThetaColumn, Value, columns_of, is_number
from scenic_lite.values.polygons import PolygonalRegion, region_of
from scenic_lite.values.regions import Filtered, RectangularRegion, Region, SectorRegion

SLIGHT = 1e-5  # minimum share of a rectangle that is pruned
ROUGH = 1e-3  # minimum share of other regions, whose circles become polygons in the test
LARGEST_NUMBER = 1e12  # maximum number in a region; areas of larger numbers may overflow


class Demand(NamedTuple):
    """The condition on the drawn point of one object: the object must fit into `container`.

    `right`, `up`: the fixed offset from the point to the object; `radius`: the radius of a circle inside the object.
    """

    container: Region
    right: float
    up: float
    radius: float

    @property
    def step(self) -> Vector:
        return Vector(self.right, self.up)


def prune(state: LoadState) -> None:
    """Restrict the regions of a program's drawn points to the parts in which the objects fit.

    The pruned parts are those of Scenic, so that acceptance rates are comparable. They are a margin of the container,
    as wide as the radius of the object's inner circle. Dialect 3 prunes nothing for an object `in workspace`. Raises
    ScenicError if an object fits nowhere.
    """
    points = {id(part): i for i, drawn in enumerate(state.points) for part in (drawn.point.x, drawn.point.y)}
    parts: dict[Demand, dict[Region, Region | None]] = {}  # cache for equal demands
    for container, (where, label) in containers(state, state.objects).items():
        for instance in [state.objects[i] for i in where] if is_fixed_area(container) else []:
            near = near_point(points, state, instance.properties["position"])
            if near is None:
                continue
            at, right, up = near
            base = state.points[at].region
            if state.dialect == 3 and base is state.workspace:
                continue
            base = base.region if isinstance(base, Filtered) else base  # its test is a separate requirement
            if not is_fixed_area(base):
                continue
            radius = min(least(instance.properties[name]) / 2 for name in ("width", "length"))  # of the inner circle
            demand = Demand(container, right, up, radius)
            known = parts.setdefault(demand, {})
            if base not in known:
                known[base] = common_part(base, demand)
            part = known[base]
            if part is None:
                raise does_not_fit(state, instance, label)
            if part is not base:
                draw_from(state, at, part)


def is_fixed_area(region: Region) -> bool:
    """Return whether a region is the same in every scene, has an area, and has a known boundary."""
    if not isinstance(region, RectangularRegion | SectorRegion | PolygonalRegion):
        return False
    return region.fixed() and all(abs(part) < LARGEST_NUMBER for part in region.parameters())


def near_point(points: dict[int, int], state: LoadState, position: Vector) -> tuple[int, float, float] | None:
    """Return the index of the drawn point on which a position depends, and the fixed offset from the point."""
    (x, right), (y, up) = (without_step(part, points) for part in (position.x, position.y))
    at = points.get(id(x))
    if at is None or state.points[at].point.x is not x or state.points[at].point.y is not y:
        return None
    return at, right, up


def without_step(value: Value, points: dict[int, int]) -> tuple[Value, float]:
    """Split a value into a coordinate of one of the points, if it contains one, and the fixed number added to it."""
    step = 0.0
    while isinstance(value, RandomExpr) and id(value) not in points and value.operation in (np.add, np.subtract):
        first, second = value.inputs
        if is_number(second):
            step += second if value.operation is np.add else -second
            value = first
        elif is_number(first) and value.operation is np.add:
            step, value = step + first, second
        else:
            break
    return value, step


def least(value: Value) -> float:
    """Return a lower bound of a size: the low end of a draw or the least option; 0 for a computed value."""
    if not isinstance(value, RandomExpr):
        return float(value)
    if isinstance(value.operation, Table):
        return max(0.0, min(value.operation.options.tolist()))
    return max((column.low for column in columns_of(value) if column.shown is value and column.low > 0), default=0.0)


def does_not_fit(state: LoadState, instance: Instance, label: str) -> ScenicError:
    place = instance.place
    message = f"{instance.title()} does not fit into {label}"
    hint = "nowhere in the region from which its position is drawn is there room for it"
    return ScenicError("value", message, place, hint=hint, source_line=state.sources[place.file].line(place.line))


# ------------------------------------------------------------ one point
def draw_from(state: LoadState, at: int, part: Region) -> None:
    """Restrict the point with index `at` to a part of its region."""
    drawn = state.points[at]
    columns = drawn.columns
    if drawn.point.x is columns[0] and isinstance(part, RectangularRegion):
        narrow(columns, part)
    else:
        columns = redraw(state, drawn, part)
    state.points[at] = DrawnPoint(part, columns, drawn.point, drawn.whole or drawn.region)


def common_part(base: Region, demand: Demand) -> Region | None:
    """Return the part of a region that meets a demand; the region itself if nearly all does, None if none does."""
    container = demand.container
    if isinstance(base, RectangularRegion) and isinstance(container, RectangularRegion) and aligned(base, container):
        return common_rectangle(base, demand)
    return common_shape(base, demand)


def aligned(a: RectangularRegion, b: RectangularRegion) -> bool:
    return abs(math.remainder(a.heading - b.heading, math.pi)) < CLOSENESS


def common_rectangle(base: RectangularRegion, demand: Demand) -> RectangularRegion | None:
    """Return the common part of two rectangles with the same heading, computed in their frame."""
    container = demand.container
    assert isinstance(container, RectangularRegion)
    middle = base.position.rotated(-base.heading)
    room = (container.position - demand.step).rotated(-base.heading)
    x = overlap(middle.x, base.width / 2, room.x, container.width / 2 - demand.radius)
    y = overlap(middle.y, base.length / 2, room.y, container.length / 2 - demand.radius)
    width, length = x[1] - x[0], y[1] - y[0]
    if (min(width, length) <= 0 and base.width * base.length > 0) or min(width, length) < -CLOSENESS:
        return None
    if width * length >= (1 - SLIGHT) * base.width * base.length:
        return base
    place = Vector((x[0] + x[1]) / 2, (y[0] + y[1]) / 2).rotated(base.heading)
    return RectangularRegion(place, base.heading, width, length)


def overlap(a: float, reach_a: float, b: float, reach_b: float) -> tuple[float, float]:
    """Return the intersection of two intervals, each given by its middle and half length."""
    return max(a - reach_a, b - reach_b), min(a + reach_a, b + reach_b)


def common_shape(base: Region, demand: Demand) -> Region | None:
    """Return the common part of two regions of any shape."""
    room = circumscribed(demand.container).shape()
    if demand.radius > 0:
        room = shapes.GROWN.scalar(room, -demand.radius)
    whole = base.shape()
    part = shapes.INTERSECTION.scalar(whole, shapes.moved(room, -demand.right, -demand.up))
    if part.area >= (1 - ROUGH) * whole.area:
        return base
    return region_of(part, base.orientation) if part.area > 0 else None


def circumscribed(region: Region) -> Region:
    """Return a region whose polygon contains the given region, including its arcs."""
    if not isinstance(region, SectorRegion):
        return region
    radius = region.radius / math.cos(min(region.angle, TURN) / 2 / ARC_SEGMENTS)
    return SectorRegion(region.center, radius, region.heading, region.angle)


# ------------------------------------------------------------ the graph
def narrow(columns: tuple[ThetaColumn, ...], part: RectangularRegion) -> None:
    """Tighten the limits of columns that directly hold coordinates."""
    for column, (low, span) in zip(columns, part.scales(), strict=True):
        column.offset, column.low, column.high = low, low, low + span
        column.span = span_between(low, low + span)


def redraw(state: LoadState, drawn: DrawnPoint, part: Region) -> tuple[ThetaColumn, ...]:
    """Replace the computation of the point's nodes, so that all values computed from the point change with it."""
    columns = drawn.columns
    if drawn.point.x is columns[0]:  # the old columns become nodes of two new columns
        columns = tuple(successor(state, column) for column in columns)
    for column, (offset, span) in zip(columns, part.scales(), strict=True):
        column.offset, column.span = offset, span
    made = part.point(*columns)
    for node, computed in zip((drawn.point.x, drawn.point.y), (made.x, made.y), strict=True):
        node.operation, node.inputs = computed.operation, computed.inputs
    show_coordinates(list(columns), drawn.point, part.bounds())
    return columns


def successor(state: LoadState, column: ThetaColumn) -> ThetaColumn:
    """Return a new column that replaces another one."""
    fresh = ThetaColumn(column.draw_kind, column.place)
    fresh.name, fresh.owner = column.name, column.owner
    state.columns[next(i for i, other in enumerate(state.columns) if other is column)] = fresh
    return fresh
