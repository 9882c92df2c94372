"""The built-in classes Point, OrientedPoint and Object, and the values derived from their properties.

Read next: `language.specifiers`, which creates the instances.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scenic_lite.core.types import Behavior, BehaviorCall, Default, Instance, RandomChoice, ScenicClass, describe_kind
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values.geometry import Vector, as_vector, corners, is_scalar, normalized
from scenic_lite.values.graph import RandomExpr, Value, any_of, apply, is_number
from scenic_lite.values.operations import SECTOR_MEETS
from scenic_lite.values.regions import Region, SectorRegion


def constants(**values: Value) -> dict[str, Default]:
    """Return property defaults that are equal for all instances."""
    return {name: constant(value) for name, value in values.items()}


def constant(value: Value) -> Default:
    return Default(lambda *_: value)


VELOCITY = Default(
    lambda _, self, _owner: Vector(0.0, self.properties["speed"]).rotated(self.properties["heading"]),
    frozenset({"speed", "heading"}),
)
NOWHERE_IN_PARTICULAR = Vector(0.0, 0.0)
UNIT_SPREAD = Vector(1.0, 1.0)  # the default noise that `mutate` adds to a position
POINT = ScenicClass(
    "Point",
    None,
    constants(
        position=NOWHERE_IN_PARTICULAR,
        width=0.0,
        length=0.0,
        visibleDistance=50.0,
        mutationScale=0.0,
        positionStdDev=UNIT_SPREAD,
        regionContainedIn=None,
    ),
)
ORIENTED_POINT = ScenicClass(
    "OrientedPoint", POINT, constants(heading=0.0, viewAngle=2 * math.pi, headingStdDev=math.radians(5))
)
OBJECT = ScenicClass(
    "Object",
    ORIENTED_POINT,
    constants(
        width=1.0,
        length=1.0,
        speed=0.0,
        angularSpeed=0.0,
        cameraOffset=NOWHERE_IN_PARTICULAR,
        allowCollisions=False,
        requireVisible=True,
        behavior=None,
        lastActions=(),
    )
    | {"velocity": VELOCITY},
)
SWITCHES = frozenset({"allowCollisions", "requireVisible"})
# Sides and corners: the offset from the center, in units of the half width and the half length.
SIDES = {
    "front": (0, 1),
    "back": (0, -1),
    "left": (-1, 0),
    "right": (1, 0),
    "frontLeft": (-1, 1),
    "frontRight": (1, 1),
    "backLeft": (-1, -1),
    "backRight": (1, -1),
}


def is_oriented(value: Value) -> bool:
    """Return whether a value is an OrientedPoint or Object."""
    return isinstance(value, Instance) and value.cls.derives_from(ORIENTED_POINT)


def is_object(value: Value) -> bool:
    return isinstance(value, Instance) and value.cls.derives_from(OBJECT)


def as_heading(value: Value) -> Value:
    """Return a value as a heading: a number, or the heading of an oriented object. None for any other value."""
    if is_scalar(value):
        return value
    if is_oriented(value):
        return value.properties["heading"]
    if isinstance(value, RandomChoice):
        headings = [as_heading(option) for option in value.options]
        return None if any(heading is None for heading in headings) else value.map_options(headings)
    return None


def as_orientation(value: Value) -> Value:
    """Return the yaw of an orientation in dialect 3, which is a heading (`as_heading`) or (yaw, 0, 0)."""
    if isinstance(value, tuple | list) and len(value) == 3 and all(is_scalar(part) for part in value):
        if not all(is_number(part) and part == 0 for part in value[1:]):
            raise ScenicError("unsupported", "an orientation in two dimensions is (yaw, 0, 0)")
        return value[0]
    return as_heading(value)


def needed(words: str, noun: str, value: Value, converted: Value, hint: str = "") -> Value:
    """Return the result of a conversion. Raises ScenicError, with the form in the message, if the result is None."""
    if converted is None:
        message = f"`{words}` needs {noun}" if words else f"{noun} is needed here"
        raise ScenicError("type", f"{message}, not {describe_kind(value)}", hint=hint)
    return converted


def vector_of(value: Value, words: str = "") -> Vector:
    """Convert a value to a vector. Raises ScenicError if this is impossible."""
    hint = "a vector is written x @ y" if words and is_scalar(value) else ""
    hint = "a point of a region is written `in region`" if isinstance(value, Region) else hint
    return needed(words, "a vector", value, as_vector(value), hint)


def heading_of(value: Value, words: str) -> Value:
    """Convert a value to a heading. Raises ScenicError if this is impossible."""
    return needed(words, "a heading", value, as_heading(value))


def number_of(value: Value) -> Value:
    return needed("", "a number", value, as_heading(value))


def region_of(value: Value, words: str = "") -> Region:
    return needed(words, "a region", value, value if isinstance(value, Region) else None)


# Properties of oriented objects in dialect 3 that describe the orientation, besides the heading.
ORIENTATION: dict[str, Callable[[Instance], Value]] = {
    "orientation": lambda self: self.properties["heading"],
    "parentOrientation": lambda self: self.parent_heading,
    "yaw": lambda self: normalized(self.properties["heading"] - self.parent_heading),
    "pitch": lambda self: 0.0,
    "roll": lambda self: 0.0,
}


def as_number(value: Value) -> Value:
    return value if is_scalar(value) else None


# For properties with a type: the name of the type, and the conversion, which returns None if it fails.
VECTOR, NUMBER = ("a vector", as_vector), ("a number", as_number)
PROPERTY_TYPES: dict[str, tuple[str, Callable[[Value], Value]]] = {
    **dict.fromkeys(("position", "velocity", "cameraOffset"), VECTOR),
    **dict.fromkeys(("width", "length", "visibleDistance", "viewAngle", "speed", "angularSpeed"), NUMBER),
    **dict.fromkeys(("mutationScale", "headingStdDev"), NUMBER),
    "heading": ("a number", as_heading),
    "parentOrientation": ("a heading", as_orientation),  # in dialect 3
}


def checked(name: str, value: Value, dialect: int) -> Value:
    """Return a value converted to the type of a property. Raises ScenicError if this is impossible."""
    if name in SWITCHES and not isinstance(value, RandomExpr | RandomChoice):
        return bool(value)
    if name == "positionStdDev":
        return spread_of(value, dialect)
    if name == "behavior" and isinstance(value, Behavior) and value.kind == "behavior":
        return BehaviorCall(value, value.bind([], {}), value.scope.place(value.node))
    if name == "behavior" and value is not None and not is_behavior(value):
        what, hint = describe_kind(value), "write with behavior B()"
        if isinstance(value, BehaviorCall):
            what = f"the {value.behavior.kind} {value.behavior.name}"
            if value.behavior.kind == "monitor":
                hint = f"write require monitor {value.behavior.name}()"
        message = f"the property 'behavior' must be a behavior, not {what}"
        raise ScenicError("type", message, hint=hint)
    if name not in PROPERTY_TYPES or (name == "parentOrientation" and dialect == 2):
        return value
    noun, read = PROPERTY_TYPES[name]
    converted = read(value)
    if converted is None:
        raise ScenicError("type", f"{name} must be {noun}, not {describe_kind(value)}")
    if name in ("width", "length") and is_number(converted) and not 0 <= converted < math.inf:
        raise ScenicError("value", f"{name} must be finite and not negative, not {converted}")
    return converted


def is_behavior(value: Value) -> bool:
    return isinstance(value, BehaviorCall) and value.behavior.kind == "behavior"


def spread_of(value: Value, dialect: int) -> Value:
    """Return the standard deviation of a position: a number in dialect 2, a vector in dialect 3."""
    if dialect == 2 and not is_scalar(value):
        if value is UNIT_SPREAD:
            return 1.0
        raise ScenicError("type", f"positionStdDev must be a number, not {describe_kind(value)}")
    if dialect == 3 and as_vector(value) is None:
        if not (isinstance(value, tuple | list) and len(value) == 3 and all(is_scalar(part) for part in value)):
            hint = "write (s, s, 0)" if is_scalar(value) else ""
            raise ScenicError("type", f"positionStdDev must be a vector, not {describe_kind(value)}", hint=hint)
        return Vector(value[0], value[1])
    return value if dialect == 2 else as_vector(value)


def oriented_point(at: Vector, heading: Value, place: SourceSpan) -> Instance:
    """Return an OrientedPoint that no statement of the program creates."""
    properties = {"position": at, "heading": heading, "width": 0.0, "length": 0.0}
    properties |= {"visibleDistance": 50.0, "viewAngle": 2 * math.pi}
    return Instance(ORIENTED_POINT, place, properties=properties)


def side_of(instance: Instance, side: str) -> Instance:
    """Return the OrientedPoint at the midpoint of a side or at a corner."""
    across, along = SIDES[side]
    offset = Vector(instance.properties["width"] * (across / 2), instance.properties["length"] * (along / 2))
    heading = instance.properties["heading"]
    return oriented_point(instance.properties["position"] + offset.rotated(heading), heading, instance.place)


def view_of(instance: Instance) -> SectorRegion:
    """Return the visible region: a disc for a Point, a sector for an OrientedPoint."""
    position, reach = instance.properties["position"], instance.properties["visibleDistance"]
    if not is_oriented(instance):
        return SectorRegion(position, reach)
    heading = instance.properties["heading"]
    offset = instance.properties.get("cameraOffset", NOWHERE_IN_PARTICULAR)
    return SectorRegion(position + offset.rotated(heading), reach, heading, instance.properties["viewAngle"])


def outline(instance: Instance) -> list[Vector]:
    """Return the corners of an object."""
    p = instance.properties
    return corners(p["position"], p["heading"], p["width"], p["length"])


def rectangle_of(instance: Instance) -> tuple[Value, ...]:
    """Return x, y, heading, width, length of an object."""
    p = instance.properties
    return p["position"].x, p["position"].y, p["heading"], p["width"], p["length"]


def can_see(viewer: Instance, seen: Value, dialect: int) -> Value:
    """Return whether the viewer's sector contains a point or meets an object's rectangle, without occlusion.

    Dialect 2 tests only the corners of the rectangle, like Scenic 2.
    """
    view = view_of(viewer)
    if not is_object(seen):
        point = as_vector(seen)
        if point is None:
            raise ScenicError("type", f"`can see` needs an object or a point, not {describe_kind(seen)}")
        return view.contains(point)
    if dialect == 2:
        return any_of(*(view.contains(corner) for corner in outline(seen)))
    return apply(SECTOR_MEETS, *view.parameters(), *rectangle_of(seen))
