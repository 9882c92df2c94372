"""The names of a program's random primitives, and the lines that contain them.

A primitive stored in a variable has the name of the variable: `gap`. Other primitives are named after their parameter
or property: `param weather`, `lead.position`, `lead.behavior.target_speed`. Read next: `program`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from scenic.core.distributions import Options
from scenic.core.dynamics.behaviors import Behavior
from scenic.core.lazy_eval import LazilyEvaluable, needsSampling
from scenic.core.object_types import Object
from scenic.core.scenarios import Scenario

FIRST = ("position", "yaw", "pitch", "roll")  # properties that are named first, since others are derived from them


class Place(NamedTuple):
    """A place in a program: the line of a file, from 1; 0 if unknown."""

    file: str
    line: int


class Places:
    """Records the lines on which the values of a program are created, and their order."""

    def __init__(self, file: str) -> None:
        self.file = file
        self._lines: dict[int, int] = {}  # by id, in order of creation
        self._kept: list[Any] = []  # keeps the values alive, so that ids stay unique
        text = Path(file).read_text().splitlines()
        self._ego = next((line for line, text in enumerate(text, 1) if re.match(r"\s*ego\s*=", text)), 1)

    def of(self, value: Any) -> Place:
        """Return where a value was created."""
        return Place(self.file, self._lines.get(id(value), 0))

    def order(self, values: list[Any]) -> list[Any]:
        """Return values in order of creation; values that Scenic's pruning added come last."""
        made = {each: index for index, each in enumerate(self._lines)}
        return sorted(values, key=lambda value: made.get(id(value), len(made)))

    @contextmanager
    def noting(self) -> Iterator[None]:
        """Record where values are created inside the context."""
        make = LazilyEvaluable.__init__

        def note(value: Any, *args: Any, **kwargs: Any) -> None:
            make(value, *args, **kwargs)
            frame = sys._getframe(1)
            while frame is not None and frame.f_code.co_filename != self.file:
                frame = frame.f_back  # type: ignore[assignment]
            if frame is not None:
                line = frame.f_lineno if frame.f_lineno > 1 else self._ego  # Scenic loses the position of `ego = `
                self._lines.setdefault(id(value), line)
                self._kept.append(value)

        LazilyEvaluable.__init__ = note
        try:
            yield
        finally:
            LazilyEvaluable.__init__ = make


def variables(scenario: Scenario) -> dict[str, Any]:
    """Return the variables of a program, or of its modular scenario, by name."""
    dynamic = scenario.dynamicScenario
    names = dynamic._dummyNamespace or {name: getattr(dynamic, name, None) for name in dynamic._locals}
    return {name: value for name, value in names.items() if not name.startswith("_")}


def object_names(scenario: Scenario) -> dict[int, str]:
    """Return a name for each object, by its id: its variable, `ego`, or its class and a number."""
    names: dict[int, str] = {}
    named = {id(value): name for name, value in variables(scenario).items() if isinstance(value, Object)}
    for index, thing in enumerate(scenario.objects):
        ego = "ego" if thing is scenario.egoObject else f"{type(thing).__name__}{index}"
        names[id(thing)] = named.get(id(thing), ego)
    return names


def primitive_names(scenario: Scenario) -> dict[int, str]:
    """Return a name for each random value, by its id: the first name that leads to it."""
    held = {called: value for called, value in variables(scenario).items() if not isinstance(value, Object | Behavior)}
    names: dict[int, str] = {}
    for called, value in held.items():  # names of variables before names of properties
        names.setdefault(id(value.index if isinstance(value, Options) else value), called)
    roots = [*held.items(), *((f"param {called}", value) for called, value in scenario.params.items())]
    for thing in scenario.objects:
        roots += _properties(thing, object_names(scenario)[id(thing)])
    walked: set[int] = set()

    def walk(value: Any, called: str) -> None:
        if needsSampling(value) and id(value) not in walked and not isinstance(value, Object):
            walked.add(id(value))
            names.setdefault(id(value), called)
            for child in value._conditioned._dependencies:
                walk(child, called)

    for called, value in roots:
        walk(value, called)
    return names


def _properties(thing: Object, called: str) -> Iterator[tuple[str, Any]]:
    """Yield the properties of an object with their names, a behavior's arguments one by one."""
    rest = [name for name in thing.properties if name not in FIRST]
    for label in (*FIRST, *rest):
        value = getattr(thing, label)
        if isinstance(value, Behavior):
            signature = type(value).__signature__.bind(*value._args, **value._kwargs)
            yield from ((f"{called}.{label}.{name}", argument) for name, argument in signature.arguments.items())
        else:
            yield f"{called}.{label}", value
