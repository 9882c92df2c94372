"""Readable and unique names: of objects for the rules, of the columns of θ for everybody.

Read next: `program`.
"""

from __future__ import annotations

from collections.abc import Iterable

from scenic_lite.geometry import Vector
from scenic_lite.graph import Column, Value
from scenic_lite.values import Instance, describe_kind


def unique(names: Iterable[str]) -> list[str]:
    """The same names, repeated ones numbered from 2."""
    taken: set[str] = set()
    result = []
    for name in names:
        candidate, number = name, 1
        while candidate in taken:
            number += 1
            candidate = f"{name}_{number}"
        taken.add(candidate)
        result.append(candidate)
    return result


def name_objects(objects: list[Instance]) -> None:
    """Give every object the label by which rules and columns speak of it."""
    for instance, label in zip(objects, unique(instance.title() for instance in objects), strict=True):
        instance.label = label


def title_of(value: Value) -> str:
    """How a chosen value is shown."""
    if isinstance(value, Instance):
        return value.title()
    return str(value) if isinstance(value, int | float | str) else describe_kind(value)


def column_names(columns: list[Column]) -> list[str]:
    """A name for each column: its variable, or object and axis, or object and property."""
    return unique(column_name(column) for column in columns)


def column_name(column: Column) -> str:
    if column.name:
        return column.name
    if column.owner is None:
        return f"{column.draw_kind.split('.')[0]}{column.place.line}"
    instance, name = column.owner
    axis = "" if name.startswith("noise.") else axis_of(column, instance)
    if axis:
        return f"{path_of(instance)}.{axis}"
    return f"{path_of(instance)}.{name}"


def axis_of(column: Column, instance: Instance) -> str:
    """x or y, if the column is that of a point or of the instance's position."""
    if column.draw_kind.startswith("point."):
        return column.draw_kind.removeprefix("point.")
    position = instance.properties.get("position")
    if isinstance(position, Vector):
        return "x" if position.x is column.shown else "y" if position.y is column.shown else ""
    return ""


def path_of(instance: Instance) -> str:
    """An object's label; for a point made inside a specifier, its owner's name and the property."""
    if instance.label or instance.name or instance.owner is None:
        return instance.title()
    owner, name = instance.owner
    return path_of(owner) if name == "position" else f"{path_of(owner)}.{name}"
