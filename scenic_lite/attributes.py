"""What `value.name` may read: our own tables, never the attributes of Python objects.

Read next: `functions`, the built-in functions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenic_lite.classes import SIDES, is_oriented, outline, side_of
from scenic_lite.errors import ScenicError
from scenic_lite.frame import Frame, near
from scenic_lite.geometry import Vector, angle_between, as_vector, distance_between
from scenic_lite.graph import Value
from scenic_lite.operators import common_part, remainder, union
from scenic_lite.regions import Region, SectorRegion
from scenic_lite.values import (
    Bound,
    Builtin,
    Choice,
    Function,
    Instance,
    Namespace,
    ScenicClass,
    describe_kind,
)


def attribute(frame: Frame, value: Value, name: str) -> Value:
    """`value.name`. Raises ScenicError of kind `name` with the nearest spelling."""
    if isinstance(value, Choice):
        return value.merged([attribute(frame, option, name) for option in value.options])
    if isinstance(value, Instance):
        return of_instance(value, name)
    if isinstance(value, Namespace):
        return of_namespace(value, name)
    if isinstance(value, ScenicClass):
        return value.name if name == "__name__" else found(value.member(name), value, name, value.members)
    fields = next((table for kind, table in FIELDS if isinstance(value, kind)), {})
    if name in fields:
        return fields[name](value)
    methods = methods_of(value)
    return found(bound(methods.get(name), value), value, name, [*fields, *methods])


def found(result: Value, value: Value, name: str, known: Any) -> Value:
    if result is None:
        raise ScenicError("name", f"{describe_kind(value)} has no attribute '{name}'", hint=near(name, known))
    return result


def bound(function: Builtin | None, value: Value) -> Value:
    return None if function is None else Bound(function, value)


def of_namespace(module: Namespace, name: str) -> Value:
    if name not in module.names or name.startswith("__"):
        hint = near(name, module.names)
        raise ScenicError("name", f"{module.name} has no '{name}'", hint=hint)
    return module.names[name]


def of_instance(instance: Instance, name: str) -> Value:
    """A property, a method, a side, or an attribute of the position."""
    if name in instance.properties:
        return instance.properties[name]
    member = instance.cls.member(name)
    if member is not None:
        return Bound(member, instance) if isinstance(member, Function) else member
    if is_oriented(instance) and name in SIDES:
        return side_of(instance, name)
    position = instance.position_vector()
    if name in ("x", "y") and position is not None:
        return position.x if name == "x" else position.y
    if name in VECTOR_METHODS and position is not None:
        return Bound(VECTOR_METHODS[name], position)
    known = [*instance.properties, *VECTOR_METHODS, "x", "y"]
    raise ScenicError("name", f"{instance.cls.name} has no property '{name}'", hint=near(name, known))


def methods_of(value: Value) -> dict[str, Builtin]:
    return next((table for kind, table in METHODS if isinstance(value, kind)), {})


def vector(value: Value) -> Vector:
    result = as_vector(value)
    if result is None:
        raise ScenicError("type", f"a vector is needed here, not {describe_kind(value)}")
    return result


def rotated_by(self: Vector, angle: Value) -> Vector:
    return self.rotated(angle)


def offset_rotated(self: Vector, heading: Value, offset: Value) -> Vector:
    return self + vector(offset).rotated(heading)


def offset_radially(self: Vector, radius: Value, heading: Value) -> Vector:
    return self + Vector(0.0, radius).rotated(heading)


def dot(self: Vector, other: Value) -> Value:
    other = vector(other)
    return self.x * other.x + self.y * other.y


def normalized(self: Vector) -> Vector:
    return self / self.length()


def distance_to(self: Vector, other: Value) -> Value:
    return distance_between(self, vector(other))


def angle_to(self: Vector, other: Value) -> Value:
    return angle_between(self, vector(other))


def contains_point(self: Region, point: Value) -> Value:
    return self.contains(vector(point))


def contains_object(self: Region, instance: Value) -> Value:
    if not isinstance(instance, Instance):
        raise ScenicError("type", f"containsObject needs an object, not {describe_kind(instance)}")
    return self.contains_corners(outline(instance))


def list_append(frame: Frame, node: Any, self: list, item: Value) -> None:
    frame.session.budget.container(len(self) + 1)
    frame.session.budget.memory -= len(self)
    self.append(item)


def list_extend(frame: Frame, node: Any, self: list, items: Value) -> None:
    items = frame.elements(items, node)
    frame.session.budget.container(len(self) + len(items))
    self.extend(items)


def list_insert(frame: Frame, node: Any, self: list, index: int, item: Value) -> None:
    frame.session.budget.container(len(self) + 1)
    self.insert(index, item)


def text_join(frame: Frame, node: Any, self: str, items: Value) -> str:
    items = frame.elements(items, node)
    frame.session.budget.text(sum(len(item) + len(self) for item in items if isinstance(item, str)))
    return self.join(items)


def text_replace(frame: Frame, node: Any, self: str, old: str, new: str) -> str:
    frame.session.budget.text(len(self) + (len(self) + 1) * len(new))
    return self.replace(old, new)


def text_split(frame: Frame, node: Any, self: str, separator: str | None = None) -> list:
    frame.session.budget.container(len(self))
    return self.split(separator)


def dictionary_update(frame: Frame, node: Any, self: dict, other: dict) -> None:
    frame.session.budget.container(len(self) + len(other))
    self.update(other)


def plain(*names: str, of: type) -> dict[str, Builtin]:
    """Methods of a Python container that cannot grow it and run no code of the program's."""
    return {name: Builtin(name, vars(of)[name], lifted=False) for name in names}


def own(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    return {name: Builtin(name, function) for name, function in functions.items()}


def sited(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Methods that also receive the frame and the call."""
    return {name: Builtin(name, function, sited=True, lifted=False) for name, function in functions.items()}


VECTOR_METHODS = own(
    norm=Vector.length,
    normalized=normalized,
    dot=dot,
    distanceTo=distance_to,
    angleTo=angle_to,
    rotatedBy=rotated_by,
    offsetRotated=offset_rotated,
    offsetRadially=offset_radially,
    offsetBy=lambda self, offset: self + vector(offset),
)
REGION_METHODS = own(
    containsPoint=contains_point,
    containsObject=contains_object,
    intersect=lambda self, other: common_part(self, other),
    difference=lambda self, other: remainder(self, other),
    union=lambda self, other: union(self, other),
)
LIST_METHODS = plain("pop", "remove", "index", "count", "reverse", "copy", "clear", of=list) | sited(
    append=list_append, extend=list_extend, insert=list_insert
)
DICTIONARY_METHODS = (
    plain("get", "pop", "setdefault", "copy", of=dict)
    | sited(update=dictionary_update)
    | {
        name: Builtin(name, function, lifted=False)
        for name, function in (
            ("keys", lambda self: list(self)),
            ("values", lambda self: list(self.values())),
            ("items", lambda self: list(self.items())),
        )
    }
)
TEXT_METHODS = plain(
    "lower", "upper", "title", "capitalize", "strip", "lstrip", "rstrip", "startswith", "endswith",
    "find", "count", "isdigit", "isalpha", of=str,
) | sited(join=text_join, replace=text_replace, split=text_split)  # fmt: skip
SET_METHODS = plain("add", "discard", "remove", "union", "intersection", "difference", "copy", of=set)
METHODS: tuple[tuple[Any, dict[str, Builtin]], ...] = (
    (Vector, VECTOR_METHODS),
    (Region, REGION_METHODS),
    (list, LIST_METHODS),
    (tuple, plain("index", "count", of=tuple)),
    (dict, DICTIONARY_METHODS),
    (str, TEXT_METHODS),
    (set, SET_METHODS),
)
VECTOR_FIELDS = {"x": lambda v: v.x, "y": lambda v: v.y, "z": lambda v: 0.0, "coordinates": lambda v: (v.x, v.y)}
REGION_FIELDS: dict[str, Callable[[Any], Value]] = {
    "orientation": lambda region: region.orientation,
    "position": lambda region: region_part(region, "position"),
    "center": lambda region: region_part(region, "center"),
    "heading": lambda region: region_part(region, "heading"),
    "width": lambda region: region_part(region, "width"),
    "length": lambda region: region_part(region, "length"),
    "radius": lambda region: region_part(region, "radius"),
    "angle": lambda region: region_part(region, "angle"),
}
FIELDS: tuple[tuple[Any, dict[str, Callable[[Any], Value]]], ...] = (
    (Vector, VECTOR_FIELDS),
    (Region, REGION_FIELDS),
)


def region_part(region: Region, name: str) -> Value:
    """A parameter of a rectangle, disc or sector."""
    if isinstance(region, SectorRegion) and name == "position":
        return region.center
    if name not in vars(region):
        raise ScenicError("name", f"{type(region).__name__} has no attribute '{name}'")
    return vars(region)[name]
