"""Readable and unique names for the columns of θ and for the objects in constraints.

Read next: `scene.program`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, describe_kind
from scenic_lite.errors import SourceSpan
from scenic_lite.values.geometry import Vector, as_vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, columns_of


class Draw(NamedTuple):
    """One column of θ: [-1, 1] is mapped to the value by its inverse cumulative distribution.

    `kind`: "range", "point.x", "point.y", "point.along", "choice", "integers" or "normal"; `low`, `high`: the limits of
    the value in the program's units (for a choice, of the index; nan if the limits are random). For a choice, `options`
    are the titles of the options, and `weights` their shares of [-1, 1], in the same order.
    """

    name: str
    kind: str
    low: float
    high: float
    place: SourceSpan
    options: tuple[str, ...] = ()
    weights: tuple[float, ...] = ()


class ThetaLayout:
    """The D columns of θ: `columns` are the leaves of the graph, `draws` are their descriptions."""

    def __init__(self, file: str, columns: list[ThetaColumn], draws: tuple[Draw, ...]) -> None:
        self.file, self.columns, self.draws = file, columns, draws
        self.offset = np.array([column.offset for column in columns])[:, None]  # [D, 1]
        self.span = np.array([column.span for column in columns])[:, None]  # [D, 1]

    def checked(self, theta: Any) -> np.ndarray:
        """Return theta as a float array [N, D]. Raises ValueError if theta is invalid."""
        expected = f"theta must be an array of numbers of the shape [N, {len(self.columns)}] for {self.file}"
        try:
            array = np.asarray(theta)
            if array.dtype.kind not in "biuf":
                raise TypeError(f"an array of {array.dtype}")
        except (TypeError, ValueError) as fault:
            raise ValueError(f"{expected}: {fault}") from None
        if array.ndim != 2 or array.shape[1] != len(self.columns):
            raise ValueError(f"{expected}, not {list(array.shape)}")
        return array.astype(float, copy=False)

    def scaled(self, theta: np.ndarray) -> np.ndarray:
        """Scale theta from [-1, 1] to offset + [0, 1] · span; return contiguous columns [D, N]."""
        unit = np.minimum(np.maximum(theta.T, -1.0), 1.0, order="C")
        unit += 1.0
        unit *= 0.5 * self.span
        unit += self.offset
        return unit

    def row(self, theta: np.ndarray) -> dict[RandomExpr, float]:
        """Return the column values of one row theta [D]."""
        scaled = self.scaled(self.checked(np.asarray(theta, dtype=float)[None]))
        return {column: float(value) for column, value in zip(self.columns, scaled[:, 0], strict=True)}


def unique(names: Iterable[str]) -> list[str]:
    """Return unique names; repeated names are numbered from 2."""
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


def name_objects(objects: list[Instance]) -> list[Instance]:
    """Set the unique label of every object for constraints and columns."""
    for instance, label in zip(objects, unique(instance.title() for instance in objects), strict=True):
        instance.label = label
    return objects


def title_of(value: Value) -> str:
    """Return the title of an option of a random choice."""
    if isinstance(value, Instance):
        return value.title()
    if isinstance(value, Vector) and value.fixed:
        return repr(value)
    if isinstance(value, ThetaColumn) and np.isfinite([value.low, value.high]).all():
        return f"{value.low:g} to {value.high:g}"
    return str(value) if isinstance(value, int | float | str) else describe_kind(value)


def titles_of_options(options: Sequence[Value]) -> tuple[str, ...]:
    """Return the titles of the options; equal titles are numbered."""
    titles = [title_of(option) for option in options]
    times = Counter(titles)
    return tuple(f"{t} (no. {k} of {len(titles)})" if times[t] > 1 else t for k, t in enumerate(titles, 1))


def name_arguments(objects: list[Instance]) -> None:
    """Name the draws in a behavior's arguments, such as `ego.behavior.speed`, unless a variable holds them."""
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
    """Return the chain of owners of a column: an object, then the object whose specifier created it, and so on."""
    owners, owner = [], column.owner
    while owner is not None:
        owners.append(owner[0])
        owner = owner[0].owner
    return owners


def shown_parts(value: Value) -> list[Value]:
    """Return the parts of a value that a column may represent: the value, its coordinates, or the index of a choice."""
    vector = as_vector(value)
    if vector is not None:
        return [vector.x, vector.y]
    return [value.index] if isinstance(value, RandomChoice) else [value]


def column_names(columns: list[ThetaColumn]) -> list[str]:
    """Return a name for each column: a variable, an object with an axis, or an object with a property."""
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
    """Return the axis of a column that belongs to a drawn point or to the instance's position, otherwise ""."""
    if column.draw_kind.startswith("point."):
        return column.draw_kind.removeprefix("point.")
    position = instance.properties.get("position")
    if isinstance(position, Vector):
        return "x" if position.x is column.shown else "y" if position.y is column.shown else ""
    return ""


def path_of(instance: Instance) -> str:
    """Return an object's label; for a point created inside a specifier, the name of its owner and the property."""
    if instance.label or instance.name or instance.owner is None:
        return instance.title()
    owner, name = instance.owner
    return path_of(owner) if name == "position" else f"{path_of(owner)}.{name}"
