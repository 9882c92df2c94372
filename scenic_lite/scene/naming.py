"""Readable and unique names: of objects for the rules, of the columns of θ for everybody.

Read next: `scene.program`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, describe_kind
from scenic_lite.errors import SourceSpan
from scenic_lite.values.geometry import Vector, as_vector
from scenic_lite.values.graph import ThetaColumn, Value, columns_of


class Draw(NamedTuple):
    """One column of θ: [-1, 1] is mapped to the value by its inverse cumulative distribution.

    `kind`: "range", "point.x", "point.y", "point.along", "choice", "integers" or "normal"; `low`, `high`: the limits of
    the value in the program's units (of the index, for a choice; nan where they are themselves random).
    """

    name: str
    kind: str
    low: float
    high: float
    place: SourceSpan


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
    if isinstance(value, Vector) and value.fixed:
        return repr(value)
    return str(value) if isinstance(value, int | float | str) else describe_kind(value)


def title_of_option(options: Sequence[Value], index: int) -> str:
    """How a chosen option is shown: by its number too, if others look the same."""
    titles = [title_of(option) for option in options]
    alike = titles.count(titles[index]) > 1
    return f"{titles[index]} (no. {index + 1} of {len(titles)})" if alike else titles[index]


def name_arguments(objects: list[Instance]) -> None:
    """Draws made for an argument of a behavior are named by it, if no variable is: `ego.behavior.speed`."""
    for instance in objects:
        behavior = instance.properties["behavior"]
        arguments = behavior.arguments if isinstance(behavior, BehaviorCall) else {}
        for argument, value in arguments.items():
            shown = {id(part) for part in shown_parts(value)}
            for column in columns_of(*shown_parts(value)):
                if id(column.shown) in shown and instance in owners_of(column):
                    axis = column.draw_kind.partition(".")[2]
                    column.name = column.name or f"{instance.title()}.behavior.{argument}{axis and '.'}{axis}"


def owners_of(column: ThetaColumn) -> list[Instance]:
    """Whose specifiers made a column: an object's, and the one's in whose specifiers that was made, and so on."""
    owners, owner = [], column.owner
    while owner is not None:
        owners.append(owner[0])
        owner = owner[0].owner
    return owners


def shown_parts(value: Value) -> list[Value]:
    """What a column may show of a value: itself, its coordinates, or the index of a choice."""
    vector = as_vector(value)
    if vector is not None:
        return [vector.x, vector.y]
    return [value.index] if isinstance(value, RandomChoice) else [value]


def column_names(columns: list[ThetaColumn]) -> list[str]:
    """A name for each column: its variable, or object and axis, or object and property."""
    return unique(column_name(column) for column in columns)


def column_name(column: ThetaColumn) -> str:
    if column.name:
        return column.name
    if column.owner is None:
        return f"{column.draw_kind.split('.')[0]}{column.place.line}"
    instance, name = column.owner
    axis = "" if name.startswith("noise.") else axis_of(column, instance)
    if axis:
        return f"{path_of(instance)}.{axis}"
    return f"{path_of(instance)}.{name}"


def axis_of(column: ThetaColumn, instance: Instance) -> str:
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
