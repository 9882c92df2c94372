"""What a Scenic expression can be besides a number, a text or a Python container.

Read next: `language.classes`, the built-in classes; `evaluation.attributes`, what may be read of a value by a name.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

from scenic_lite.core.environment import Environment
from scenic_lite.errors import SourceSpan
from scenic_lite.syntax import nodes
from scenic_lite.values.geometry import Located, Vector, as_vector
from scenic_lite.values.graph import RandomExpr, Value, select
from scenic_lite.values.regions import Region, VectorField


@dataclass(frozen=True, eq=False)
class Default:
    """One `property[attributes]: expression` line: `compute` gives the value for one object, reading `needs` of it.

    It also gets the scope of the statement that makes the object.
    """

    compute: Callable[[Any, Instance], Value]
    needs: frozenset[str] = frozenset()
    attributes: tuple[str, ...] = ()


@dataclass(eq=False)
class ScenicClass:
    """A class of the language: properties with defaults, methods, attributes."""

    name: str
    base: ScenicClass | None
    defaults: dict[str, Default] = field(default_factory=dict)
    members: dict[str, Value] = field(default_factory=dict)

    def lineage(self) -> Iterator[ScenicClass]:
        """Return the class and its bases, most derived first."""
        at: ScenicClass | None = self
        while at is not None:
            yield at
            at = at.base

    def derives_from(self, other: ScenicClass) -> bool:
        return any(cls is other for cls in self.lineage())

    def property_names(self) -> list[str]:
        """Return every property with a default, the base's first."""
        names: dict[str, None] = {}
        for cls in reversed(list(self.lineage())):
            names.update(dict.fromkeys(cls.defaults))
        return list(names)

    def defaults_of(self, name: str) -> list[Default]:
        """Return the defaults for one property, most derived first."""
        return [cls.defaults[name] for cls in self.lineage() if name in cls.defaults]

    def member(self, name: str) -> Value:
        for cls in self.lineage():
            if name in cls.members:
                return cls.members[name]
        return None


@dataclass(eq=False)
class Instance(Located):
    """A Point, OrientedPoint or Object with its properties."""

    cls: ScenicClass
    place: SourceSpan
    owner: Any = None  # (Instance, property) in whose specifiers it was made
    name: str = ""  # the first variable it was bound to
    properties: dict[str, Value] = field(default_factory=dict)
    attributes: dict[str, Value] = field(default_factory=dict)  # set by `object.name = value`, of no property
    label: str = ""  # unique among the objects of its program
    parent_heading: Value = 0.0  # in dialect 3, to which its yaw was added

    def position_vector(self) -> Vector | None:
        return as_vector(self.properties["position"]) if "position" in self.properties else None

    def title(self) -> str:
        """Return how a report names it: its variable, or its class."""
        return self.label or self.name or self.cls.name


@dataclass(eq=False)
class RandomChoice(Located):
    """A random one of several structured values (objects, regions, tuples); numbers, texts are `RandomExpr` instead."""

    index: RandomExpr
    options: tuple

    def map_options(self, results: list[Value]) -> Value:
        """Return the same choice among `results`, one per option."""
        return choose(self.index, results)

    def position_vector(self) -> Vector | None:
        vectors = [as_vector(option) for option in self.options]
        if any(vector is None for vector in vectors):
            return None
        return self.map_options(vectors)


def choose(index: RandomExpr, options: list[Value] | tuple) -> Value:
    """options[index], as simple a value as the options allow."""
    if all(isinstance(option, int | float | str | RandomExpr) for option in options):
        return select(index, tuple(options))
    if all(isinstance(option, Vector) for option in options):
        return Vector(
            select(index, tuple(option.x for option in options)), select(index, tuple(option.y for option in options))
        )
    return options[0] if all(option is options[0] for option in options) else RandomChoice(index, tuple(options))


def broadcasts_over_choices(*positions: int) -> Callable[[Callable[..., Value]], Callable[..., Value]]:
    """Return a function that is mapped over the options of a random choice which it gets at one of these positions."""

    def decorate(function: Callable[..., Value]) -> Callable[..., Value]:
        @wraps(function)
        def mapped(*arguments: Any, **keywords: Any) -> Value:
            for i in positions:
                if i < len(arguments) and isinstance(arguments[i], RandomChoice):
                    before, choice, after = arguments[:i], arguments[i], arguments[i + 1 :]
                    return choice.map_options(
                        [mapped(*before, option, *after, **keywords) for option in choice.options]
                    )
            return function(*arguments, **keywords)

        return mapped

    return decorate


@dataclass(frozen=True, eq=False)
class LazyValue:
    """A value that waits for properties of the object being made: `needs` names them."""

    needs: frozenset[str]
    compute: Callable[[Instance], Value]


@dataclass(frozen=True, eq=False)
class Function:
    """A `def` or `lambda` of a program."""

    name: str
    arguments: ast.arguments
    defaults: tuple[Value, ...]
    keyword_defaults: dict[str, Value]
    body: list[ast.stmt] | ast.expr
    scope: Environment
    assigned: frozenset[str] = frozenset()  # its local names besides its arguments


@dataclass(frozen=True, eq=False)
class Bound:
    """A method with its receiver."""

    function: Function | Builtin
    receiver: Value


@dataclass(frozen=True, eq=False)
class Builtin:
    """A function of the language itself, from our own tables; `needs_context`: it also gets the scope and the call."""

    name: str
    function: Callable[..., Value]
    needs_context: bool = False
    types: tuple[type, ...] = ()  # for `isinstance`, if the name is also a type
    over_choices: bool = True  # an argument that is a RandomChoice is mapped over its options


def of_values(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Return functions of values alone, mapped over a random choice of them."""
    return {name: Builtin(name, function) for name, function in functions.items()}


def needs_context(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Return functions that also receive the scope and the call."""
    return {
        name: Builtin(name, function, needs_context=True, over_choices=False) for name, function in functions.items()
    }


@dataclass(frozen=True, eq=False)
class Namespace:
    """An imported module, `globalParameters`, or the state of a game; `open`: a program may assign its names."""

    name: str
    names: dict[str, Value]
    open: bool = False


@dataclass(frozen=True, eq=False)
class Behavior:
    """A `behavior`, `monitor` or `scenario` definition, kept as a tree."""

    name: str
    node: nodes.Behavior | nodes.Scenario
    defaults: tuple[Value, ...]
    keyword_defaults: dict[str, Value]
    scope: Environment
    assigned: frozenset[str] = frozenset()  # its own variables besides its arguments

    @property
    def kind(self) -> str:
        """Return one of "behavior", "monitor" and "scenario"."""
        return "scenario" if isinstance(self.node, nodes.Scenario) else self.node.kind

    @property
    def scenario(self) -> nodes.Scenario:
        """Return the tree of a scenario."""
        assert isinstance(self.node, nodes.Scenario)
        return self.node


@dataclass(frozen=True, eq=False)
class BehaviorCall:
    """A behavior with its arguments, bound by name; what `with behavior B(1)` attaches.

    `names`: the variables of a scenario that has been set up in an episode.
    """

    behavior: Behavior
    arguments: dict[str, Value]
    place: SourceSpan
    names: dict[str, Value] = field(default_factory=dict)


def randoms_in(value: Value, seen: set[int] | None = None) -> Iterator[RandomExpr]:
    """Return the random nodes that a value is made of, in order."""
    seen = set() if seen is None else seen
    if isinstance(value, RandomExpr):
        yield value
        return
    if id(value) in seen:
        return
    parts = parts_of(value)
    if parts:
        seen.add(id(value))
    for part in parts:
        yield from randoms_in(part, seen)


def parts_of(value: Value) -> tuple[Value, ...]:
    """Return what a structured value is made of."""
    if isinstance(value, Vector):
        return (value.x, value.y)
    if isinstance(value, list | tuple | set):
        return tuple(value)
    if isinstance(value, dict):
        return tuple(value.values())
    if isinstance(value, RandomChoice):
        return (value.index, *value.options)
    if isinstance(value, Instance):
        return tuple(value.properties.values())
    if isinstance(value, BehaviorCall):
        return tuple(value.arguments.values())
    if isinstance(value, Region):
        return value.parameters()
    return ()


def describe_kind(value: Value) -> str:
    """Return what a value is, for a message: "a number", "a region", ..."""
    if isinstance(value, RandomExpr):
        return {"text": "a random text", "truth": "a random truth value"}.get(value.kind, "a random number")
    if isinstance(value, Instance):
        return f"a {value.cls.name}"
    for types, words in KINDS:
        if isinstance(value, types):
            return words
    return f"a {type(value).__name__.lower()}"


KINDS: tuple[tuple[Any, str], ...] = (
    (type(None), "None"),
    (bool, "a truth value"),
    ((int, float), "a number"),
    (str, "a text"),
    (Vector, "a vector"),
    (Region, "a region"),
    (VectorField, "a vector field"),
    (ScenicClass, "a class"),
    ((Function, Bound, Builtin), "a function"),
    (Behavior, "a behavior without its arguments"),
    (BehaviorCall, "a behavior"),
    (Namespace, "a module"),
    (RandomChoice, "a random choice"),
    (range, "a range"),
    (list, "a list"),
    (dict, "a dictionary"),
    (LazyValue, "a value that depends on the object being made"),
)
