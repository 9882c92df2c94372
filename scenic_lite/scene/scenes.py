"""Scenes: N samples of a program as arrays, and the plan that extracts them from a tape's registers.

Read next: `scene.program`, which owns the plan; `scene.constraints`, which tests scenes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, parts_of
from scenic_lite.errors import SourceSpan
from scenic_lite.language.classes import rectangle_of
from scenic_lite.scene.constraints import Outlines
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, Value, is_number

LARGEST_VALUE, DEEPEST_VALUE = 20_000, 20
Reader = Callable[[list[Any], int], Any]  # (registers, N) -> the value in N samples


class ObjectInfo(NamedTuple):
    """The description of an object before any scene is drawn.

    `name`: the variable in the program, or "". `classes`: the names of its class and all bases, most derived first.
    `behavior`: the name of its behavior, or None. `behavior_place`: the place of this name.
    """

    name: str
    class_name: str
    classes: tuple[str, ...]
    place: SourceSpan
    behavior: str | None
    behavior_place: SourceSpan | None


@dataclass(frozen=True, eq=False)
class Scenes:
    """N initial arrangements of a program's O objects.

    positions: [N, O, 2], headings: [N, O] (radians, 0 along +y, counterclockwise).
    properties: name -> list over the O objects. A fixed value is a plain value (a vector is a pair), a random value is
    an array [N] (a vector is [N, 2]). None means that the object has no such property.
    params: the program's parameters, in the same form.
    behavior_arguments: for each object a dict name -> value in the same form, or None without a behavior. An object
        as an argument is its index in `Program.objects`.
    ok: [N] bool, whether every constraint holds; failed: [N, R] bool, the violated ones of `Program.requirements`.
    """

    positions: np.ndarray
    headings: np.ndarray
    properties: dict[str, list[Any]]
    params: dict[str, Any]
    behavior_arguments: list[dict[str, Any] | None]
    ok: np.ndarray
    failed: np.ndarray


def refuse_huge(value: Value, what: str) -> None:
    """Raise ScenicError if a value in scenes has too many parts or contains itself."""
    count, stack = 0, [(value, 0)]
    while stack:
        part, depth = stack.pop()
        count += 1
        if count > LARGEST_VALUE or depth > DEEPEST_VALUE:
            raise exceeded(f"{what} has more than {LARGEST_VALUE:,} parts, or holds itself")
        if isinstance(part, list | tuple | set | dict | RandomChoice | BehaviorCall):
            stack += [(inner, depth + 1) for inner in parts_of(part)]


@dataclass(eq=False)
class Fixed:
    """The reader of a fixed value."""

    value: Any

    def __call__(self, registers: list[Any], count: int) -> Any:
        return self.value


class Planner:
    """A factory of readers, which compute values from the registers of a tape."""

    def __init__(self, tape: Tape, objects: Iterable[Instance]) -> None:
        self.tape = tape
        self.indices = {id(instance): i for i, instance in enumerate(objects)}

    def reader(self, value: Value) -> Reader:
        """Return the reader of a value, in the format of Scenes."""
        if value is None or isinstance(value, int | float | str):  # the most frequent case
            return Fixed(value)
        if isinstance(value, RandomExpr):
            slot = self.tape.slot(value)
            return lambda registers, count: registers[slot]
        if isinstance(value, BehaviorCall):
            return Fixed(value.behavior.name)
        if isinstance(value, Instance):
            index = self.indices.get(id(value))
            return self.reader(value.properties["position"]) if index is None else Fixed(index)
        if isinstance(value, RandomChoice):
            return self._choice(value)
        if isinstance(value, dict):
            keys = list(value)
            return self._of_parts(value.values(), lambda parts, _: dict(zip(keys, parts, strict=True)))
        if isinstance(value, Vector):
            return Fixed((value.x, value.y)) if value.fixed else self._of_parts([value.x, value.y], points)
        if isinstance(value, list | tuple):
            return self._of_parts(value, lambda parts, _: type(value)(parts))
        return Fixed(value)

    def _of_parts(self, values: Iterable[Value], joined: Callable[[list[Any], int], Any]) -> Reader:
        """Return the reader of a value composed of parts."""
        readers = [self.reader(part) for part in values]
        if all(isinstance(reader, Fixed) for reader in readers):
            return Fixed(joined([reader([], 0) for reader in readers], 0))
        return lambda registers, count: joined([reader(registers, count) for reader in readers], count)

    def _choice(self, value: RandomChoice) -> Reader:
        index = self.tape.slot(value.index)
        readers = [self.reader(option) for option in value.options]

        def read(registers: list[Any], count: int) -> Any:
            options = [reader(registers, count) for reader in readers]
            rows = [row_of(options[k], i) for i, k in enumerate(registers[index])]
            return np.array(rows + [None], dtype=object)[:-1]

        return read


def points(coordinates: list[Any], count: int) -> np.ndarray:
    """Return points [N, 2] from coordinates that are arrays [N] or numbers."""
    return np.stack([np.broadcast_to(part, count) for part in coordinates], axis=1)


def row_of(value: Any, row: int) -> Any:
    """Return the value of one sample from a value over all samples."""
    if isinstance(value, np.ndarray):
        part = value[row]
        if isinstance(part, np.ndarray):
            return tuple(part.tolist())
        return part.item() if isinstance(part, np.generic) else part
    if isinstance(value, list | tuple):
        return type(value)(row_of(part, row) for part in value)
    if isinstance(value, dict):
        return {key: row_of(part, row) for key, part in value.items()}
    return value


class ScenePlan:
    """The extraction of scenes from the registers of a tape; fixed values are computed in advance."""

    def __init__(self, tape: Tape, objects: list[Instance], params: dict[str, Value]) -> None:
        planner = Planner(tape, objects)
        self.arrangement = Arrangement(planner, objects)
        names = dict.fromkeys(name for instance in objects for name in instance.properties)
        others = [name for name in names if name not in ("position", "heading")]
        behaviors = [instance.properties["behavior"] for instance in objects]
        arguments = [call.arguments if isinstance(call, BehaviorCall) else None for call in behaviors]
        self._properties = planner.reader({name: [one.properties.get(name) for one in objects] for name in others})
        self._arguments = planner.reader(arguments)
        self._params = planner.reader(params)
        readers = {name: planner.reader(value) for name, value in params.items()}
        self.params = {name: reader.value for name, reader in readers.items() if isinstance(reader, Fixed)}

    def read(self, registers: list[Any], count: int) -> tuple[dict[str, list[Any]], dict[str, Any], list[Any]]:
        """Return the properties, parameters and behavior arguments of N = count scenes, in the format of Scenes."""
        properties, params = self._properties(registers, count), self._params(registers, count)
        return properties, params, self._arguments(registers, count)


class Arrangement:
    """The layout of objects: extracts outlines from the registers, and positions and headings from the outlines."""

    def __init__(self, planner: Planner, objects: list[Instance]) -> None:
        self.count = len(objects)
        self.fixed: dict[str, np.ndarray] = {}
        self.random: dict[str, list[tuple[int, int]]] = {}  # part -> (object, register)
        columns = [[rectangle_of(instance)[k] for instance in objects] for k in range(5)]
        for part, values in zip(("x", "y", "heading", "width", "length"), columns, strict=True):
            fixed = [value if is_number(value) else 0.0 for value in values]
            self.fixed[part] = np.array(fixed, dtype=float)[:, None]  # [O, 1]
            self.random[part] = [
                (i, planner.tape.slot(value)) for i, value in enumerate(values) if isinstance(value, RandomExpr)
            ]

    def outlines(self, registers: list[Any], count: int) -> Outlines:
        """Return the objects' rectangles in N = count scenes."""
        x, y = self._filled("x", registers, count), self._filled("y", registers, count)
        heading, width, length = (
            self._filled(part, registers, count) if self.random[part] else self.fixed[part]
            for part in ("heading", "width", "length")
        )
        return Outlines(x, y, heading, width, length)

    def placed(self, outlines: Outlines, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return positions [N, O, 2] and headings [N, O] of the objects' rectangles."""
        positions = np.empty((count, self.count, 2))
        positions[:, :, 0], positions[:, :, 1] = outlines.x.T, outlines.y.T
        headings = np.empty((count, self.count))
        headings[:] = outlines.heading.T
        return positions, headings

    def _filled(self, part: str, registers: list[Any], count: int) -> np.ndarray:
        """Return one attribute of every object: [O, N]."""
        values = np.empty((self.count, count))
        values[:] = self.fixed[part]
        for i, slot in self.random[part]:
            values[i] = registers[slot]
        return values


def info_of(instance: Instance) -> ObjectInfo:
    """Return the description of an object before any scene is drawn."""
    behavior = instance.properties["behavior"]
    attached = (None, None) if behavior is None else (behavior.behavior.name, behavior.place)
    classes = tuple(cls.name for cls in instance.cls.lineage())
    return ObjectInfo(instance.name, instance.cls.name, classes, instance.place, *attached)
