"""The types of Scenic values other than numbers, texts and Python containers, and the environments of names.

A function keeps the environment of its definition; the `Scope` of the call determines the evaluation of its body.
Read next: `core.state`, `core.scope`; `language.classes`, the built-in classes.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import wraps
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax import nodes
from scenic_lite.values.geometry import Located, Vector, as_vector
from scenic_lite.values.graph import RandomExpr, Value, kind_of, select
from scenic_lite.values.regions import Region, VectorField


# ------------------------------------------------------------ names
@dataclass(frozen=True)
class Source:
    """One file of program text."""

    file: str
    lines: tuple[str, ...]
    folder: Path | None  # the search path of the program's modules
    library: bool  # whether the file belongs to the domain, not to the user

    @property
    def start(self) -> SourceSpan:
        return SourceSpan(self.file, 1, 0, 1, 1)

    def line(self, number: int) -> str:
        return self.lines[number - 1] if 0 < number <= len(self.lines) else ""


class Environment:
    """The variables of one module, function, comprehension or class body, with a link to the enclosing environment."""

    __slots__ = ("assigned", "locals", "module_names", "outer", "source")

    def __init__(self, source: Source, names: dict[str, Value], outer: Environment | None = None) -> None:
        self.source = source
        self.locals = names
        self.outer = outer
        self.assigned: frozenset[str] = frozenset()  # a function's local names, even before they have a value
        self.module_names: dict[str, Value] = outer.module_names if outer else names

    def outwards(self) -> Iterator[Environment]:
        """Yield this environment and the enclosing ones, innermost first; the module's may be absent from the chain."""
        at: Environment | None = self
        while at is not None:
            yield at
            at = at.outer

    def place(self, node: ast.AST) -> SourceSpan:
        if not isinstance(node, ast.expr | ast.stmt):
            return self.source.start
        end_line, end_column = node.end_lineno or node.lineno, node.end_col_offset or node.col_offset + 1
        return SourceSpan(self.source.file, node.lineno, node.col_offset, end_line, end_column)

    def error(self, kind: str, message: str, node: ast.AST, hint: str = "", notes: Iterable[str] = ()) -> ScenicError:
        """Return an error at `node`."""
        return self.placed(ScenicError(kind, message, hint=hint, notes=notes), node)

    def placed(self, error: ScenicError, node: ast.AST) -> ScenicError:
        """Set the place of an error without one; if the node has no place in the text, the caller sets it."""
        if error.place is None and "lineno" in vars(node):
            error.place = self.place(node)
            error.source_line = self.source.line(error.place.line)
        return error


def near(name: str, names: Iterable[str]) -> str:
    """Return a hint with the nearest spelling, or an empty text."""
    public = [candidate for candidate in names if not candidate.startswith("_")]
    swapped = [candidate for candidate in public if sorted(candidate.lower()) == sorted(name.lower())]
    close = swapped or difflib.get_close_matches(name, public, 1, 0.7)
    return f"did you mean '{close[0]}'?" if close else ""


# ------------------------------------------------------------ values
@dataclass(frozen=True, eq=False)
class Default:
    """One `property[attributes]: expression` line: `compute` returns the value for one object and reads its `needs`.

    `compute` also receives the scope of the statement that creates the object, and the property that owns the draws.
    """

    compute: Callable[[Any, Instance, str], Value]
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
        """Yield the class and its bases, most derived first."""
        at: ScenicClass | None = self
        while at is not None:
            yield at
            at = at.base

    def derives_from(self, other: ScenicClass) -> bool:
        return any(cls is other for cls in self.lineage())

    def property_names(self) -> list[str]:
        """Return the names of all properties with a default, the base's first."""
        names: dict[str, None] = {}
        for cls in reversed(list(self.lineage())):
            names.update(dict.fromkeys(cls.defaults))
        return list(names)

    def defaults_of(self, name: str) -> list[Default]:
        """Return the defaults of one property, most derived first."""
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
    owner: Any = None  # (Instance, property) whose specifier created it
    name: str = ""  # the first variable bound to it
    properties: dict[str, Value] = field(default_factory=dict)
    attributes: dict[str, Value] = field(default_factory=dict)  # set by `object.name = value`, without a property
    label: str = ""  # unique among the objects of its program
    parent_heading: Value = 0.0  # in dialect 3, the heading to which its yaw was added

    def position_vector(self) -> Vector | None:
        return as_vector(self.properties["position"]) if "position" in self.properties else None

    def title(self) -> str:
        """Return the name in reports: the label, the variable, or the class."""
        return self.label or self.name or self.cls.name


class Undecided:
    """One of several values, or a list of undecided length; `Handlers.undecided` applies functions to either."""


@dataclass(eq=False)
class RandomChoice(Undecided, Located):
    """A random choice among structured values (objects, regions, tuples); numbers and texts use `RandomExpr`."""

    index: RandomExpr
    options: tuple

    def map_options(self, results: list[Value]) -> Value:
        """Return the same random choice among `results`, one per option."""
        return choose(self.index, results)

    def each(self, function: Callable[[Value], Value]) -> Value:
        """Apply a function to every option and return the same random choice among the results."""
        return choose(self.index, [function(option) for option in self.options])

    def position_vector(self) -> Vector | None:
        vectors = [as_vector(option) for option in self.options]
        return None if None in vectors else self.map_options(vectors)


def choose(index: RandomExpr, options: list[Value] | tuple) -> Value:
    """Return options[index] in the simplest form that the options allow."""
    kinds = {kind_of(option) for option in options}
    if "other" not in kinds and (len(kinds) == 1 or "text" not in kinds):
        return select(index, tuple(options))
    if all(isinstance(option, Vector) for option in options):
        return Vector(
            select(index, tuple(option.x for option in options)), select(index, tuple(option.y for option in options))
        )
    return options[0] if all(option is options[0] for option in options) else RandomChoice(index, tuple(options))


def broadcasts_over_choices(*positions: int) -> Callable[[Callable[..., Value]], Callable[..., Value]]:
    """Return a decorator: the function is mapped over the options of a random choice at one of these positions.

    The first argument of the function is the scope; its handlers may treat the choice differently or reject it.
    """

    def decorate(function: Callable[..., Value]) -> Callable[..., Value]:
        @wraps(function)
        def mapped(*arguments: Any, **keywords: Any) -> Value:
            for at in positions:
                if at < len(arguments) and isinstance(arguments[at], Undecided):
                    return arguments[0].handlers.undecided(mapped, at, arguments, keywords)
            return function(*arguments, **keywords)

        return mapped

    return decorate


def for_each_option(function: Callable[..., Value], at: int, arguments: tuple, keywords: dict[str, Value]) -> Value:
    """Apply a function to every option of argument `at` and return the same random choice among the results."""
    before, after = arguments[:at], arguments[at + 1 :]
    return arguments[at].each(lambda option: function(*before, option, *after, **keywords))


@dataclass(frozen=True, eq=False)
class LazyValue:
    """A value that depends on properties (`needs`) of the object under construction."""

    needs: frozenset[str]
    compute: Callable[[Instance], Value]


SPREAD = Parameter.VAR_POSITIONAL


@dataclass(frozen=True, eq=False)
class Definition:
    """A parameterized definition of a program: a function, a behavior, a monitor or a scenario.

    `signature` holds the values of the defaults. `scope` is the environment of the definition. `assigned` are the local
    names besides the parameters.
    """

    name: str
    signature: Signature
    scope: Environment
    assigned: frozenset[str]

    def trees(self) -> list[ast.AST]:
        """Return the statements of the body."""
        raise NotImplementedError

    def defaults(self) -> list[Value]:
        """Return the default values of the optional parameters."""
        return [p.default for p in self.signature.parameters.values() if p.default is not Parameter.empty]

    def required(self) -> list[str]:
        """Return the names of the required parameters."""
        parameters = self.signature.parameters.values()
        return [p.name for p in parameters if p.default is Parameter.empty and p.kind is not SPREAD]

    def bind(self, arguments: list, keywords: dict[str, Value]) -> dict[str, Value]:
        """Return the arguments by parameter name. Raises ScenicError if they do not match the signature."""
        try:
            bound = self.signature.bind(*arguments, **keywords)
        except TypeError:
            raise self._misfit(arguments, keywords) from None
        bound.apply_defaults()
        return bound.arguments

    def _misfit(self, arguments: list, keywords: dict[str, Value]) -> ScenicError:
        """Return the error for arguments that do not match the signature."""
        names = [p.name for p in self.signature.parameters.values() if p.kind is not SPREAD]
        unknown = [name for name in keywords if name not in names]
        missing = [name for name in self.required() if name not in (*names[: len(arguments)], *keywords)]
        has = f"it has {', '.join(names)}" if names else "it has none"
        if unknown and len(arguments) <= len(names):
            return ScenicError(
                "type", f"{self.name}() has no argument '{unknown[0]}'", hint=near(unknown[0], names) or has
            )
        fault = f"'{missing[0]}' is missing" if missing else f"{len(arguments) + len(keywords)} arguments were given"
        return ScenicError("type", f"{self.name}({', '.join(names)}): {fault}")


@dataclass(frozen=True, eq=False)
class Function(Definition):
    """A `def` or `lambda` of a program."""

    body: list[ast.stmt] | ast.expr

    def trees(self) -> list[ast.AST]:
        return list(self.body) if isinstance(self.body, list) else [self.body]


@dataclass(frozen=True, eq=False)
class Bound:
    """A method with its receiver."""

    function: Function | Builtin
    receiver: Value


@dataclass(frozen=True, eq=False)
class Builtin:
    """A function of the language, from our own tables; with `needs_context` it also takes the scope and the call."""

    name: str
    function: Callable[..., Value]
    needs_context: bool = False
    types: tuple[type, ...] = ()  # for `isinstance`, if the name also denotes a type
    over_choices: bool = True  # an argument that is a RandomChoice is mapped over its options


def of_values(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Return built-ins that take only values and are mapped over random choices."""
    return {name: Builtin(name, function) for name, function in functions.items()}


def needs_context(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Return built-ins that also take the scope and the call."""
    return {
        name: Builtin(name, function, needs_context=True, over_choices=False) for name, function in functions.items()
    }


@dataclass(frozen=True, eq=False)
class Namespace:
    """An imported module, `globalParameters`, or the state of a game; `open`: a program may assign to its names."""

    name: str
    names: dict[str, Value]
    open: bool = False


@dataclass(frozen=True, eq=False)
class Behavior(Definition):
    """A `behavior`, `monitor` or `scenario` definition, kept as a tree."""

    node: nodes.Behavior | nodes.Scenario

    def trees(self) -> list[ast.AST]:
        return [self.node]

    @property
    def kind(self) -> str:
        """Return "behavior", "monitor" or "scenario"."""
        return "scenario" if isinstance(self.node, nodes.Scenario) else self.node.kind

    @property
    def scenario(self) -> nodes.Scenario:
        """Return the tree of a scenario."""
        assert isinstance(self.node, nodes.Scenario)
        return self.node


@dataclass(frozen=True, eq=False)
class BehaviorCall:
    """A behavior with its arguments by name, as in `with behavior B(1)`.

    `names`: the variables of a scenario that has been set up in an episode.
    """

    behavior: Behavior
    arguments: dict[str, Value]
    place: SourceSpan
    names: dict[str, Value] = field(default_factory=dict)


def randoms_in(value: Value, seen: set[int] | None = None) -> Iterator[RandomExpr]:
    """Yield the random nodes in a value, in order."""
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
    """Return the parts of a structured value."""
    if isinstance(value, Vector):
        return (value.x, value.y)
    if isinstance(value, list | tuple):
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
    """Return the kind of a value for messages: "a number", "a region", ..."""
    if isinstance(value, RandomExpr):
        return {"text": "a random text", "truth": "a random truth value"}.get(value.kind, "a random number")
    if isinstance(value, Instance):
        return f"{'an' if value.cls.name[0] in 'AEIOU' else 'a'} {value.cls.name}"
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
