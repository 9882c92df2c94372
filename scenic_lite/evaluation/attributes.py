"""What `value.name` may read: our own tables, never the attributes of Python objects.

Read next: `evaluation.functions`, the built-in functions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import (
    Behavior,
    BehaviorCall,
    Bound,
    Builtin,
    Function,
    Instance,
    Namespace,
    ScenicClass,
    broadcasts_over_choices,
    describe_kind,
    near,
    of_values,
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.builtins import CLASS_METHODS, DICTIONARIES, LISTS, TUPLES
from scenic_lite.evaluation.strings import no_method
from scenic_lite.language.classes import ORIENTATION, SIDES, is_object, is_oriented, side_of, vector_of
from scenic_lite.language.regions import CLASS_FUNCTIONS, REGION_FIELDS, REGION_METHODS
from scenic_lite.values.geometry import Vector, angle_between, distance_between, is_scalar
from scenic_lite.values.graph import Value, apply, kind_of
from scenic_lite.values.operations import ABSOLUTE, MAXIMUM


@broadcasts_over_choices(1)
def attribute(scope: Scope, value: Value, name: str) -> Value:
    """`value.name`. Raises ScenicError of kind `name` with the nearest spelling."""
    if isinstance(value, Instance):
        return of_instance(scope, value, name)
    if isinstance(value, Namespace):
        return of_namespace(value, name)
    if name in ("yaw", "pitch", "roll") and scope.state.dialect == 3 and is_scalar(value):  # of an orientation
        return value if name == "yaw" else 0.0
    if isinstance(value, BehaviorCall) and name in value.names:
        return value.names[name]
    if isinstance(value, ScenicClass):
        return of_class(value, name)
    if name == "__name__" and isinstance(value, Function | Builtin | Behavior):
        return value.name
    if isinstance(value, Builtin) and value.types:
        return of_type(value, name)
    if kind_of(value) == "text":
        raise no_method(name)
    fields = next((table for kind, table in FIELDS if isinstance(value, kind)), {})
    if name in fields:
        return fields[name](value)
    methods = methods_of(value)
    return or_unknown(bound(methods.get(name), value), value, name, [*fields, *methods])


def or_unknown(result: Value, value: Value, name: str, known: Any) -> Value:
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


def of_class(cls: ScenicClass, name: str) -> Value:
    if name == "__name__":
        return cls.name
    return or_unknown(cls.member(name), cls, name, cls.members)


def of_type(cls: Builtin, name: str) -> Value:
    """`list.append`: a method without its receiver; what belongs to the function of a class of regions."""
    if str in cls.types:
        raise no_method(name)
    known = next((table for kind, table in METHODS if kind in cls.types), {})
    known = known | CLASS_METHODS.get(cls.name, {}) | CLASS_FUNCTIONS.get(cls.name, {})
    return or_unknown(known.get(name), cls, name, known)


def of_instance(scope: Scope, instance: Instance, name: str) -> Value:
    """Return a property, an attribute set later, a method, a side, or an attribute of the position."""
    if name in instance.properties:
        return instance.properties[name]
    if name in instance.attributes:
        return instance.attributes[name]
    member = instance.cls.member(name)
    if member is not None:
        return Bound(member, instance) if isinstance(member, Function) else member
    if is_oriented(instance) and name in SIDES:
        return side_of(instance, name)
    if is_oriented(instance) and scope.state.dialect == 3 and name in ORIENTATION:
        return ORIENTATION[name](instance)
    position = instance.position_vector()
    if name in ("x", "y") and position is not None:
        return position.x if name == "x" else position.y
    if name == "z" and position is not None and scope.state.dialect == 3:
        return 0.0
    if name == "distanceTo" and scope.state.dialect == 3 and is_object(instance):
        return Bound(DISTANCE_TO_OUTLINE, instance)
    if name in VECTOR_METHODS and position is not None:
        return Bound(VECTOR_METHODS[name], position)
    known = [*instance.properties, *VECTOR_METHODS, "x", "y"]
    raise ScenicError("name", f"{instance.cls.name} has no property '{name}'", hint=near(name, known))


def methods_of(value: Value) -> dict[str, Builtin]:
    return next((table for kind, table in METHODS if isinstance(value, kind)), {})


def rotated_by(self: Vector, angle: Value) -> Vector:
    return self.rotated(angle)


def offset_rotated(self: Vector, heading: Value, offset: Value) -> Vector:
    return self + vector_of(offset).rotated(heading)


def offset_radially(self: Vector, radius: Value, heading: Value) -> Vector:
    return self + Vector(0.0, radius).rotated(heading)


def dot(self: Vector, other: Value) -> Value:
    other = vector_of(other)
    return self.x * other.x + self.y * other.y


def normalized(self: Vector) -> Vector:
    return self / self.length()


def distance_to(self: Vector, other: Value) -> Value:
    return distance_between(self, vector_of(other))


def distance_to_outline(self: Instance, other: Value) -> Value:
    """Dialect 3: `object.distanceTo(point)` counts from the object's rectangle, 0 inside."""
    p = self.properties
    offset = (vector_of(other) - p["position"]).rotated(-p["heading"])
    sides = ((offset.x, p["width"]), (offset.y, p["length"]))
    return Vector(*(apply(MAXIMUM, apply(ABSOLUTE, part) - extent / 2, 0.0) for part, extent in sides)).length()


def angle_to(self: Vector, other: Value) -> Value:
    return angle_between(self, vector_of(other))


DISTANCE_TO_OUTLINE = Builtin("distanceTo", distance_to_outline)
VECTOR_METHODS = of_values(
    norm=Vector.length,
    normalized=normalized,
    dot=dot,
    distanceTo=distance_to,
    angleTo=angle_to,
    rotatedBy=rotated_by,
    offsetRotated=offset_rotated,
    offsetRadially=offset_radially,
    offsetBy=lambda self, offset: self + vector_of(offset),
)
METHODS: tuple[tuple[Any, dict[str, Builtin]], ...] = (
    (Vector, VECTOR_METHODS),
    *REGION_METHODS,
    (list, LISTS),
    (tuple, TUPLES),
    (dict, DICTIONARIES),
)
VECTOR_FIELDS = {"x": lambda v: v.x, "y": lambda v: v.y, "z": lambda v: 0.0, "coordinates": lambda v: (v.x, v.y)}
FIELDS: tuple[tuple[Any, dict[str, Callable[[Any], Value]]], ...] = (
    (Vector, VECTOR_FIELDS),
    *REGION_FIELDS,
)
