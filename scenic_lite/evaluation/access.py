"""Attributes, elements and targets of assignments: the values of `value.name` and `value[i]`.

Our own tables list all readable attributes; Python's attribute access is never used.

Read next: `evaluation.builtins`, the methods of containers; `language.regions`, those of regions.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from functools import partial
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
    RandomChoice,
    ScenicClass,
    broadcasts_over_choices,
    choose,
    describe_kind,
    near,
    of_values,
    randoms_in,
)
from scenic_lite.core.world import checked_reward
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.builtins import DICTIONARIES, LISTS, TUPLES, no_method
from scenic_lite.language import regions
from scenic_lite.language.classes import ORIENTATION, SIDES, checked, is_object, is_oriented, side_of, vector_of
from scenic_lite.values.geometry import Vector, angle_between, distance_between, is_scalar
from scenic_lite.values.graph import RandomExpr, Value, apply, columns_of, kind_of
from scenic_lite.values.operations import ABSOLUTE, MAXIMUM, SUBTRACT
from scenic_lite.values.regions import Region, VectorField


# ------------------------------------------------------------ attributes
@broadcasts_over_choices(1)
def attribute(scope: Scope, value: Value, name: str) -> Value:
    """Return `value.name`. Raises ScenicError of kind `name`, with the nearest spelling as a hint."""
    if isinstance(value, Instance):
        return of_instance(scope, value, name)
    if isinstance(value, Namespace):
        if name in value.names and not name.startswith("__"):
            return value.names[name]
        raise ScenicError("name", f"{value.name} has no '{name}'", hint=near(name, value.names))
    if name in ("yaw", "pitch", "roll") and scope.state.dialect == 3 and is_scalar(value):  # of an orientation
        return value if name == "yaw" else 0.0
    if isinstance(value, BehaviorCall) and name in value.names:
        return value.names[name]
    if isinstance(value, BehaviorCall) and name in value.behavior.assigned and value.behavior.kind == "scenario":
        message = f"the scenario {value.behavior.name} has not begun, and so has no '{name}' yet"
        raise ScenicError("name", message, hint="read it after `do`")
    if name == "__name__" and isinstance(value, Function | Builtin | Behavior | ScenicClass):
        return value.name
    if kind_of(value) == "text" or (isinstance(value, Builtin) and str in value.types):
        raise no_method(name)
    if isinstance(value, ScenicClass):
        known, member = value.members, value.member(name)
    elif isinstance(value, Builtin) and value.types:  # `PolygonalRegion.unionAll`
        known = regions.CLASS_FUNCTIONS.get(value.name, {})
        member = known.get(name)
    else:
        fields, methods = of_kind(FIELDS, value), of_kind(METHODS, value)
        if name in fields:
            return fields[name](value)
        known, member = fields | methods, Bound(methods[name], value) if name in methods else None
    if member is None:
        hint = near(name, known) or INSTEAD.get(name, "")
        raise ScenicError("name", f"{describe_kind(value)} has no attribute '{name}'", hint=hint)
    return member


def of_kind(tables: tuple[tuple[Any, dict[str, Any]], ...], value: Value) -> dict[str, Any]:
    """Return the attribute table of the first kind that matches a value."""
    return next((table for kind, table in tables if isinstance(value, kind)), {})


def of_instance(scope: Scope, instance: Instance, name: str) -> Value:
    """Return a property, an assigned attribute, a method, a side, or an attribute of the position."""
    for own in (instance.properties, instance.attributes):
        if name in own:
            return own[name]
    member = instance.cls.member(name)
    if member is not None:
        return Bound(member, instance) if isinstance(member, Function) else member
    in_space = scope.state.dialect == 3
    if is_oriented(instance) and name in SIDES:
        return side_of(instance, name)
    if is_oriented(instance) and in_space and name in ORIENTATION:
        return ORIENTATION[name](instance)
    if name == "distanceTo" and in_space and is_object(instance):
        return Bound(DISTANCE_TO_OUTLINE, instance)
    position = instance.position_vector()
    if position is not None and (name in ("x", "y") or (name == "z" and in_space)):
        return VECTOR_FIELDS[name](position)
    if position is not None and name in VECTOR_METHODS:
        return Bound(VECTOR_METHODS[name], position)
    known = [*instance.properties, *VECTOR_METHODS, "x", "y"]
    hint = INSTEAD.get(name, "") or near(name, known)
    raise ScenicError("name", f"{instance.cls.name} has no property '{name}'", hint=hint)


INSTEAD = {  # hints for unsupported attributes
    **dict.fromkeys(("polygons", "polygon"), "objects of Shapely are not supported: write .points, or .boundary"),
    "convexHull": "write PolygonalRegion(points)",
    "canSee": "write a can see b",
    "intersects": "write a intersects b",
    "containsPoint": "write a region of its size",
    "visibleRegion": "write visible region",
    "corners": "write (front left of x).position",
    "occupiedSpace": "write RectangularRegion(x.position, x.heading, x.width, x.length)",
    **dict.fromkeys(("fromEuler", "height"), "there are two dimensions here"),
}


def dot(self: Vector, other: Value) -> Value:
    other = vector_of(other)
    return self.x * other.x + self.y * other.y


def distance_to_outline(self: Instance, other: Value) -> Value:
    """Return dialect 3's `object.distanceTo(point)`: the distance from the object's rectangle, 0 inside it."""
    p = self.properties
    offset = (vector_of(other) - p["position"]).rotated(-p["heading"])
    sides = ((offset.x, p["width"]), (offset.y, p["length"]))
    return Vector(*(apply(MAXIMUM, apply(ABSOLUTE, part) - extent / 2, 0.0) for part, extent in sides)).length()


DISTANCE_TO_OUTLINE = Builtin("distanceTo", distance_to_outline)
VECTOR_FIELDS: dict[str, Callable[[Any], Value]] = {
    "x": lambda self: self.x,
    "y": lambda self: self.y,
    "z": lambda self: 0.0,
    "coordinates": lambda self: (self.x, self.y),
}
VECTOR_METHODS = of_values(
    norm=Vector.length,
    normalized=lambda self: self / self.length(),
    dot=dot,
    distanceTo=lambda self, other: distance_between(self, vector_of(other)),
    angleTo=lambda self, other: angle_between(self, vector_of(other)),
    rotatedBy=lambda self, angle: self.rotated(angle),
    offsetRotated=lambda self, heading, offset: self + vector_of(offset).rotated(heading),
    offsetRadially=lambda self, radius, heading: self + Vector(0.0, radius).rotated(heading),
    offsetBy=lambda self, offset: self + vector_of(offset),
)
FIELDS: tuple[tuple[Any, dict[str, Callable[[Any], Value]]], ...] = ((Vector, VECTOR_FIELDS), *regions.REGION_FIELDS)
METHODS: tuple[tuple[Any, dict[str, Builtin]], ...] = (
    (Vector, VECTOR_METHODS),
    *regions.REGION_METHODS,
    (list, LISTS),
    (tuple, TUPLES),
    (dict, DICTIONARIES),
)


# ------------------------------------------------------------ elements
def item_of(scope: Scope, container: Value, index: Value) -> Value:
    """Return `container[index]`."""
    if isinstance(container, RandomChoice):
        return at_each(index, lambda at: container.each(lambda option: item_of(scope, option, at)))
    if isinstance(container, Region | VectorField):
        return regions.item_of(container, index)
    ends = (index.start, index.stop, index.step) if isinstance(index, slice) else (index,)
    if any(isinstance(end, RandomExpr | RandomChoice) for end in ends):
        hint = "write Uniform(*items) for a random element"
        what = "ends of a slice" if isinstance(index, slice) else "index of a list"
        raise ScenicError("random-control-flow", f"the {what} must not be random", hint=hint)
    if isinstance(container, Vector):
        container = (container.x, container.y)
    if isinstance(container, Namespace):
        container = container.names
    if not isinstance(container, list | tuple | dict | str | range):
        hint = "it is called with round brackets" if isinstance(container, Builtin | Function) else ""
        raise ScenicError("type", f"{describe_kind(container)} has no elements to index", hint=hint)
    scope.mode.budget.whole(index)
    result = container[index]
    if isinstance(index, slice):
        scope.mode.budget.keep(result)
    return result


def at_each(index: Value, item: Callable[[Value], Value]) -> Value:
    """Return the item at an index or slice whose ends may be random integers."""
    if isinstance(index, slice):
        between = partial(at_each, index.stop)
        return at_each(index.start, lambda start: between(lambda stop: item(slice(start, stop, index.step))))
    column = next((own for own in columns_of(index) if own.shown is index), None)
    if column is None or column.draw_kind != "integers" or math.isnan(column.low):
        return item(index)
    first, last = int(column.low), int(column.high)
    return choose(apply(SUBTRACT, index, first), [item(at) for at in range(first, last + 1)])


# ------------------------------------------------------------ targets of assignments
def located(scope: Scope, target: ast.expr) -> tuple[Value, Value]:
    """Return the owner of a target and its key in the owner, each evaluated once; a plain name has no owner."""
    if isinstance(target, ast.Subscript):
        return scope.value(target.value), scope.value(target.slice)
    if isinstance(target, ast.Attribute):
        return scope.value(target.value), target.attr
    if isinstance(target, ast.Name):
        return None, target.id
    raise scope.error("syntax", "this cannot be assigned to", target)


def read(scope: Scope, target: ast.expr, owner: Value, key: Value) -> Value:
    """Return the present value of a target."""
    if isinstance(target, ast.Name):
        return scope.state.ego if key == "ego" else scope.lookup(key)
    return item_of(scope, owner, key) if isinstance(target, ast.Subscript) else attribute(scope, owner, key)


def write(scope: Scope, target: ast.expr, owner: Value, key: Value, value: Value) -> None:
    """Assign to a name, an element, a slice or an attribute."""
    if isinstance(target, ast.Name):
        if key in TRACKED:
            TRACKED[key](scope, target, value)
        scope.assign(key, value)
    elif isinstance(target, ast.Subscript):
        check_container(scope, target, owner, key)
        ranged = isinstance(key, slice) and isinstance(owner, list)
        owner[key] = scope.elements(value, target) if ranged else value
        scope.mode.budget.container(len(owner)) if ranged else scope.mode.budget.spend(1)
    else:
        try:
            set_attribute(scope, owner, key, value)
        except ScenicError as error:
            raise scope.placed(error, target) from None


def check_container(scope: Scope, target: ast.expr, owner: Value, key: Value) -> None:
    """Raise ScenicError for a container without assignable elements, or for a random key."""
    if not isinstance(owner, list | dict):
        raise scope.error("type", f"elements of {describe_kind(owner)} cannot be assigned here", target)
    what = "index of a list" if isinstance(owner, list) else "key of a dictionary"
    scope.refuse_random(key, target, f"the {what} must not be random")
    scope.mode.budget.whole(key)


def set_attribute(scope: Scope, owner: Value, name: str, value: Value) -> None:
    """Assign `owner.name = value` for an object or a class of the program; a property keeps its type."""
    if isinstance(owner, Instance):
        if name in ("x", "y") and name not in owner.properties:  # an attribute would only hide the coordinate
            hint = f"write {owner.title()}.position = x @ y"
            raise ScenicError("type", f"the {name} of an object belongs to its position", hint=hint)
        if name in owner.properties:
            owner.properties[name] = checked(name, value, scope.state.dialect)
        else:
            owner.attributes[name] = value
    elif isinstance(owner, ScenicClass) and owner.base is not None:
        owner.members[name] = value
    elif isinstance(owner, Namespace) and owner.open:
        owner.names[name] = checked_reward(value) if name == "scenic_reward" else value
    elif isinstance(owner, RandomChoice):
        raise ScenicError("type", "the attributes of a random object cannot be assigned")
    else:
        raise ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")


def unpack(scope: Scope, target: ast.expr, value: Value) -> None:
    """Assign a value to one target, or its elements to several targets: `a, (b, c) = value`."""
    if not isinstance(target, ast.Tuple | ast.List):
        write(scope, target, *located(scope, target), value)
        return
    for part, item in zip(target.elts, spread(scope, target, scope.elements(value, target)), strict=True):
        unpack(scope, part, item)


def spread(scope: Scope, target: ast.Tuple | ast.List, items: list[Value]) -> list[Value]:
    """Return one value for each of several targets."""
    if len(items) != len(target.elts):
        raise scope.error("value", f"{len(items)} values for {len(target.elts)} names", target)
    return items


# ------------------------------------------------------------ names that the language tracks
def set_ego(scope: Scope, node: ast.AST, value: Value) -> None:
    if not is_object(value):
        several = isinstance(value, tuple) and any(map(is_object, value))
        hint = "no specifier follows the comma, which makes a tuple: write with property value" if several else ""
        raise scope.error("type", f"ego must be an object, not {describe_kind(value)}", node, hint)
    scope.state.ego = value


def set_workspace(scope: Scope, node: ast.AST, value: Value) -> None:
    hint = "write workspace = Workspace(region)"
    if not isinstance(value, Region):
        raise scope.error("type", f"the workspace must be a region, not {describe_kind(value)}", node, hint)
    drawn = next(randoms_in(value), None)
    if isinstance(drawn, RandomExpr):
        raise scope.error("value", "the workspace must be fixed", node, notes=scope.drawn_notes(drawn))
    scope.state.workspace = value


TRACKED: dict[str, Callable[[Scope, ast.AST, Value], None]] = {"ego": set_ego, "workspace": set_workspace}
