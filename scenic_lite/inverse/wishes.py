"""What a scene is asked to be, value by value: read from `Scenes`, or from what a person writes down.

Read next: `inverse.levels`, which finds the draws that give it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.scope import near
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.scenes import Scenes, part_of, row_of
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, is_number, kind_of
from scenic_lite.values.regions import Region

CLOSE = 1e-6  # relative, from 1 on: two values that agree so far are the same


class Wish(NamedTuple):
    """One value of the scenes: `node` computes it or is it, `values` [N] is what is asked (nan: nothing is).

    `owner` is the index of the object that it belongs to, or None; `part` says what of it: "position", "heading", ...
    """

    node: Value
    values: Any
    owner: int | None
    part: str
    place: SourceSpan


@dataclass(frozen=True)
class Subjects:
    """What can be asked of: the objects of a program, its parameters and its draws, by name."""

    file: str
    instances: list[Instance]
    params: dict[str, Value]
    param_places: dict[str, SourceSpan]
    draws: dict[str, ThetaColumn]

    def named(self, key: Any) -> int | None:
        """The index of an object by its index, its label, `ego`, or its class if it is the only one of it."""
        if isinstance(key, int | np.integer) and not isinstance(key, bool):
            if not 0 <= key < len(self.instances):
                raise ScenicError("name", f"{self.file} has {len(self.instances)} objects, and no object {key}")
            return int(key)
        labels = [instance.title() for instance in self.instances]
        if key in labels:
            return labels.index(key)
        if key == "ego" and self.instances:
            return 0
        alike = [i for i, each in enumerate(self.instances) if key in [cls.name for cls in each.cls.lineage()]]
        if len(alike) > 1 and key not in self.params and key not in self.draws:
            names = ", ".join(labels[i] for i in alike)
            raise ScenicError("name", f"{self.file} has {len(alike)} objects of the class {key}", hint=f"say {names}")
        return alike[0] if len(alike) == 1 else None

    def unknown(self, key: Any) -> ScenicError:
        names = [*(each.title() for each in self.instances), *self.params, *self.draws]
        hint = near(key, names) if isinstance(key, str) else ""
        message = f"{self.file} has no object, parameter or draw {key!r}"
        return ScenicError("name", message, hint=hint or f"it has {', '.join(names)}")


# ------------------------------------------------------------ from Scenes


def wishes_of_scenes(subjects: Subjects, scenes: Scenes) -> list[Wish]:
    """Everything that scenes hold."""
    count = len(subjects.instances)
    if scenes.positions.shape[1] != count:
        found = scenes.positions.shape[1]
        raise ScenicError("value", f"{subjects.file} has {count} objects, and these scenes have {found}")
    wishes: list[Wish] = []
    for i, instance in enumerate(subjects.instances):
        about = Asked(subjects, i, instance.place)
        wishes += about.position(scenes.positions[:, i])
        wishes += about.leaves("heading", part_of(instance, "heading"), scenes.headings[:, i])
        for name, value in instance.properties.items():
            if name not in ("position", "heading") and name in scenes.properties:
                wishes += about.leaves(name, value, scenes.properties[name][i])
        wishes += about.arguments(scenes.behavior_arguments[i] or {})
    for name, value in scenes.params.items():
        if name in subjects.params:
            wishes += Asked(subjects, None, subjects.param_places[name]).leaves(name, subjects.params[name], value)
    return wishes


# ------------------------------------------------------------ from a description


def wishes_of_description(subjects: Subjects, description: Mapping[Any, Any]) -> list[Wish]:
    """What a person asks of objects, parameters and draws. Raises ScenicError for a name that is none of them."""
    wishes: list[Wish] = []
    for key, wanted in description.items():
        refuse_infinite(key, wanted)
        index = subjects.named(key)
        if index is not None:
            about = Asked(subjects, index, subjects.instances[index].place)
            wishes += about.properties(wanted) if isinstance(wanted, Mapping) else about.stance(wanted)
        elif key in subjects.params:
            wishes += Asked(subjects, None, subjects.param_places[key]).leaves(key, subjects.params[key], wanted)
        elif key in subjects.draws:
            column = subjects.draws[key]
            wishes += Asked(subjects, None, column.place).leaves(key, column.shown, wanted)
        else:
            raise subjects.unknown(key)
    return wishes


def refuse_infinite(key: Any, wanted: Any) -> None:
    """Raise ScenicError if a description holds a number that is none."""
    for part in wanted.values() if isinstance(wanted, Mapping) else wanted if isinstance(wanted, list | tuple) else ():
        refuse_infinite(key, part)
    values = np.asarray(wanted) if isinstance(wanted, float | np.ndarray | np.number) else np.zeros(0)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise ScenicError("value", f"what is asked of {key} holds a number that is not finite")


@dataclass(frozen=True)
class Asked:
    """Makes the wishes about one object, or about what belongs to none."""

    subjects: Subjects
    owner: int | None
    place: SourceSpan

    @property
    def instance(self) -> Instance:
        assert self.owner is not None
        return self.subjects.instances[self.owner]

    def stance(self, wanted: Any) -> list[Wish]:
        """(x, y) or (x, y, heading), each a number or an array [N]; or an array [N, 2] or [N, 3]."""
        parts = self._coordinates(wanted, (2, 3))
        wishes = self.position(parts)
        if len(parts) == 3:
            wishes += self.leaves("heading", part_of(self.instance, "heading"), parts[2])
        return wishes

    def position(self, wanted: Any) -> list[Wish]:
        parts = self._coordinates(wanted, (2, 3))
        nodes = (part_of(self.instance, "x"), part_of(self.instance, "y"))
        return [self._wish("position", node, part) for node, part in zip(nodes, parts, strict=False)]

    def properties(self, wanted: Mapping[str, Any]) -> list[Wish]:
        """By name of the property; `behavior` takes a dict of the behavior's arguments."""
        wishes: list[Wish] = []
        for name, value in wanted.items():
            if name == "position":
                wishes += self.position(value)
            elif name == "behavior" and isinstance(value, Mapping):
                wishes += self.arguments(value)
            elif name == "heading":
                wishes += self.leaves(name, part_of(self.instance, "heading"), value)
            elif name in self.instance.properties:
                wishes += self.leaves(name, self.instance.properties[name], value)
            else:
                hint = near(str(name), self.instance.properties)
                raise ScenicError("name", f"{self.instance.title()} has no property {name!r}", self.place, hint=hint)
        return wishes

    def arguments(self, wanted: Mapping[str, Any]) -> list[Wish]:
        behavior = self.instance.properties["behavior"]
        known = behavior.arguments if isinstance(behavior, BehaviorCall) else {}
        wishes: list[Wish] = []
        for name, value in wanted.items():
            if name not in known:
                message = f"the behavior of {self.instance.title()} has no argument {name!r}"
                raise ScenicError("name", message, self.place, hint=near(str(name), known))
            wishes += self.leaves(name, known[name], value)
        return wishes

    def leaves(self, part: str, value: Value, wanted: Any) -> list[Wish]:
        """The wishes for a value of any structure, `wanted` having the form that Scenes give it."""
        return [self._wish(part, node, data) for node, data in self._leaves(part, value, wanted)]

    def _leaves(self, part: str, value: Value, wanted: Any) -> Iterator[tuple[Value, Any]]:
        if isinstance(value, RandomExpr) or is_number(value) or isinstance(value, str | bool):
            yield value, wanted
        elif isinstance(value, Vector):
            yield from zip((value.x, value.y), self._coordinates(wanted, (2,)), strict=True)
        elif isinstance(value, RandomChoice):
            yield value.index, self._chosen(part, value, wanted)
        elif isinstance(value, Instance):
            if not any(value is each for each in self.subjects.instances):
                yield from self._leaves(part, value.properties["position"], wanted)
        elif isinstance(value, dict):
            for key, each in value.items():
                if isinstance(wanted, Mapping) and key in wanted:
                    yield from self._leaves(part, each, wanted[key])
        elif isinstance(value, list | tuple) and isinstance(wanted, list | tuple) and len(value) == len(wanted):
            for each, data in zip(value, wanted, strict=True):
                yield from self._leaves(part, each, data)
        elif wanted is not None and not isinstance(value, Region | BehaviorCall | list | tuple | None):
            raise ScenicError("type", f"{part} cannot be asked for: {value!r}", self.place)

    def _chosen(self, part: str, choice: RandomChoice, wanted: Any) -> Any:
        """The index of the option in each row; nan where more than one may be meant."""
        data = wanted if isinstance(wanted, np.ndarray) and wanted.dtype == object else np.array([wanted, None])[:-1]
        options = [self._shown(option) for option in choice.options]
        indices = np.full(len(data), np.nan)
        for row in range(len(data)):
            found = [k for k, option in enumerate(options) if fits(option, row_of(data, row))]
            if not found:
                raise ScenicError("value", f"{part} cannot be {row_of(data, row)!r}", self.place)
            if len(found) == 1:
                indices[row] = found[0]
        return indices

    def _shown(self, option: Value) -> Any:
        """An option in the form that Scenes give it; None for what is random itself."""
        if isinstance(option, Instance):
            at = [k for k, each in enumerate(self.subjects.instances) if each is option]
            return at[0] if at else self._shown(option.properties["position"])
        if isinstance(option, Vector):
            return (option.x, option.y) if option.fixed else None
        if isinstance(option, list | tuple):
            return type(option)(self._shown(each) for each in option)
        return None if isinstance(option, RandomExpr | RandomChoice | dict) else option

    def _coordinates(self, wanted: Any, lengths: tuple[int, ...]) -> list[Any]:
        parts = wanted.T if isinstance(wanted, np.ndarray) and wanted.ndim == 2 else wanted
        if not isinstance(parts, list | tuple | np.ndarray) or len(parts) not in lengths:
            who = self.instance.title() if self.owner is not None else "a vector"
            wants = "(x, y) or (x, y, heading)" if 3 in lengths else "(x, y)"
            raise ScenicError("type", f"{who} takes {wants}, not {wanted!r}", self.place)
        return list(parts)

    def _wish(self, part: str, node: Value, data: Any) -> Wish:
        values = np.asarray(data, dtype=object if isinstance(data, str) else None)
        if values.dtype.kind == "U":
            values = values.astype(object)
        if values.dtype.kind not in "biuf" and kind_of(node) == "number":
            raise ScenicError("type", f"{part} is a number, and cannot be {data!r}", self.place)
        if values.ndim > 1:
            raise ScenicError("type", f"{part} takes a number or an array [N], not one of {values.shape}", self.place)
        return Wish(node, values, self.owner, part, self.place)


def fits(option: Any, wanted: Any) -> bool:
    """Whether an option, as Scenes show it, is or may be what is wanted."""
    if option is None:
        return True
    if isinstance(option, list | tuple):
        alike = isinstance(wanted, list | tuple) and len(option) == len(wanted)
        return alike and all(fits(a, b) for a, b in zip(option, wanted, strict=True))
    if is_number(option) and isinstance(wanted, int | float):
        return abs(option - wanted) <= CLOSE * max(1.0, abs(option))
    return bool(option == wanted)
