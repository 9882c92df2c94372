"""Scenic's operators: distances, angles, relative positions and visibility.

An omitted operand is None and means the ego. Read next: `evaluation.expressions`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EPISODE, LOAD
from scenic_lite.core.types import Instance, LazyValue, RandomChoice, broadcasts_over_choices, describe_kind
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.language.classes import (
    SIDES,
    can_see,
    heading_of,
    is_object,
    is_oriented,
    oriented_point,
    rectangle_of,
    region_of,
    side_of,
    vector_of,
    view_of,
)
from scenic_lite.language.fields import follow
from scenic_lite.language.specifier_rules import at_position, moved_along, or_ego, viewer_of
from scenic_lite.values.geometry import angle_between, as_vector, distance_between, is_scalar, normalized
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import RECTANGLES_MEET
from scenic_lite.values.polygons import common_part, remainder
from scenic_lite.values.regions import Region, VectorField

DEGREE_OF_DIALECT_2 = 0.01745329252  # the value in Scenic 2's source


def degrees(scope: Scope, angle: Value) -> Value:
    if not is_scalar(angle):
        raise ScenicError("type", f"`deg` follows a number, not {describe_kind(angle)}")
    return angle * (DEGREE_OF_DIALECT_2 if scope.state.dialect == 2 else math.pi / 180)


def distance(scope: Scope, start: Value, end: Value) -> Value:
    start, end = or_ego(scope, start), or_ego(scope, end)
    for region, other in ((start, end), (end, start)):
        if isinstance(region, Region):
            return region.distance(vector_of(other, "distance to"))
    return distance_between(vector_of(start, "distance from"), vector_of(end, "distance to"))


def angle(scope: Scope, start: Value, end: Value) -> Value:
    return angle_between(vector_of(or_ego(scope, start), "angle from"), vector_of(or_ego(scope, end), "angle to"))


def relative_heading(scope: Scope, heading: Value, base: Value) -> Value:
    base = or_ego(scope, base)
    return normalized(heading_of(heading, "relative heading of") - heading_of(base, "relative heading ... from"))


def apparent_heading(scope: Scope, seen: Value, viewpoint: Value) -> Value:
    start = vector_of(or_ego(scope, viewpoint), "apparent heading ... from")
    line = angle_between(start, vector_of(seen, "apparent heading of"))
    return normalized(heading_of(seen, "apparent heading of") - line)


def relative_position(scope: Scope, place: Value, base: Value) -> Value:
    base = or_ego(scope, base)
    return vector_of(place, "relative position of") - vector_of(base, "relative position ... from")


def distance_past(scope: Scope, place: Value, base: Value) -> Value:
    base = or_ego(scope, base)
    offset = vector_of(base, "distance past ... of") - vector_of(place, "distance past")
    return offset.rotated(-heading_of(base, "distance past ... of")).y


def field_at(scope: Scope, field: Value, place: Value) -> Value:
    if not isinstance(field, VectorField):
        hint = "write `new` before it" if scope.state.dialect == 3 else ""
        raise ScenicError("type", f"`X at Y` needs a vector field or a class, not {describe_kind(field)}", hint=hint)
    return field.heading_at(vector_of(place, "at"))


def relative_to(scope: Scope, x: Value, y: Value) -> Value:
    """Return `X relative to Y` or `X offset by Y`: a sum of headings or vectors, or a vector in an object's frame."""
    if isinstance(x, VectorField | LazyValue) or isinstance(y, VectorField | LazyValue):
        first, second = late_heading(x), late_heading(y)
        return LazyValue(first.needs | second.needs, lambda self: first.compute(self) + second.compute(self))
    random_frames = is_random_frame if scope.state.dialect == 3 else is_oriented
    if all(is_oriented(operand) or random_frames(operand) for operand in (x, y)):
        raise ScenicError("type", "`X relative to Y` of two oriented objects", hint="use x.heading or x.position")
    if is_oriented(y):
        return into_frame(scope, x, y)
    if is_oriented(x):
        return into_frame(scope, y, x)
    if is_scalar(x) and is_scalar(y):
        return x + y
    if scope.state.dialect == 3 and is_random_frame(x):
        return x.each(lambda option: relative_to(scope, option, y))
    if scope.state.dialect == 3 and is_random_frame(y):
        return y.each(lambda option: relative_to(scope, x, option))
    return vector_of(x, "relative to") + vector_of(y, "relative to")


def is_random_frame(value: Value) -> bool:
    """Return whether a value is a random choice among oriented objects; dialect 2 treats such a value as a vector."""
    return isinstance(value, RandomChoice) and all(is_oriented(option) for option in value.options)


def into_frame(scope: Scope, offset: Value, base: Instance) -> Value:
    """Return the OrientedPoint at `offset` in the frame of `base`; in dialect 3 `offset` may be a heading to add."""
    vector, heading = as_vector(offset), base.properties["heading"]
    if vector is not None:
        return oriented_point(base.properties["position"] + vector.rotated(heading), heading, base.place)
    if is_scalar(offset) and scope.state.dialect == 3:
        return offset + heading
    hint = f"write {base.title()}.heading" if is_scalar(offset) else ""
    raise ScenicError("type", f"a vector is needed beside an oriented object, not {describe_kind(offset)}", hint=hint)


def late_heading(value: Value) -> LazyValue:
    """Return a heading as a lazy value; for a field, the field's heading at the object's position."""
    if isinstance(value, LazyValue):
        return value
    if isinstance(value, VectorField):
        return at_position(value.heading_at)
    heading = heading_of(value, "relative to")
    return LazyValue(frozenset(), lambda self: heading)


def offset_along(scope: Scope, start: Value, direction: Value, offset: Value) -> Value:
    return moved_along(vector_of(start, "offset along"), direction, offset)


def sees(scope: Scope, viewer: Value, seen: Value) -> Value:
    dialect = scope.state.dialect
    if not scope.mode.symbolic and scope.mode.phase != EPISODE and dialect == 3:
        raise ScenicError("type", "`can see` is meant for requirements", hint="write `require X can see Y`")
    result = one_sees(scope, viewer, seen)
    if isinstance(result, RandomExpr) and not scope.mode.symbolic:
        raise ScenicError("random-control-flow", "what can be seen differs from scene to scene", hint="write `require`")
    return result


@broadcasts_over_choices(1, 2)
def one_sees(scope: Scope, viewer: Value, seen: Value) -> Value:
    return can_see(viewer_of(scope, viewer), seen, scope.state.dialect)


@broadcasts_over_choices(1, 2)
def intersects(scope: Scope, x: Value, y: Value) -> Value:
    if not (is_object(x) and is_object(y)):
        raise ScenicError("unsupported", "`intersects` is supported between objects only")
    return apply(RECTANGLES_MEET, *rectangle_of(x), *rectangle_of(y))


def follow_field(scope: Scope, field: Value, start: Value, length: Value) -> Value:
    base = or_ego(scope, start)
    point, heading = follow(field, vector_of(base, "follow ... from"), length)
    place = base.place if isinstance(base, Instance) else SourceSpan(scope.source.file, 1, 0, 1, 1)
    return oriented_point(point, heading, place)


def visible(scope: Scope, region: Value, viewer: Value = None) -> Region:
    return common_part(region_of(region, "visible"), view_of(viewer_of(scope, viewer)), scope.state.dialect)


def not_visible(scope: Scope, region: Value, viewer: Value = None) -> Region:
    return remainder(region_of(region, "not visible"), view_of(viewer_of(scope, viewer)))


def side(name: str) -> Callable[[Scope, Value], Value]:
    """Return the operator for a side: `front of O`, `back left of O`, ..."""

    def operator(scope: Scope, instance: Value) -> Value:
        if not is_oriented(instance):
            raise ScenicError("type", f"`{side_words(name)}` needs an object, not {describe_kind(instance)}")
        return side_of(instance, name)

    return operator


def side_words(name: str) -> str:
    """Return the words of a side's operator: "backLeft" gives `back left of`."""
    return re.sub("[A-Z]", lambda capital: " " + capital[0].lower(), name) + " of"


def in_initial_scenario(scope: Scope) -> bool:
    """Return `initial scenario`: true while the program itself is set up, false in a scenario that a match starts."""
    return scope.mode.phase == LOAD


OPERATORS: dict[str, Callable[..., Value]] = {
    "initial scenario": in_initial_scenario,
    "deg": degrees,
    "distance": distance,
    "angle": angle,
    "relative heading of": relative_heading,
    "apparent heading of": apparent_heading,
    "relative position of": relative_position,
    "distance past": distance_past,
    "at": field_at,
    "relative to": relative_to,
    "offset by": relative_to,
    "offset along": offset_along,
    "can see": sees,
    "intersects": intersects,
    "follow": follow_field,
    "visible": visible,
    "not visible": not_visible,
    "visible from": visible,
    "not visible from": not_visible,
}
OPERATORS |= {side_words(name): side(name) for name in SIDES}
