"""Python's built-in functions of containers, texts and types, and the methods of lists and dictionaries.

Programs can call only the functions in these tables; functions that are rejected by name are excluded on purpose.
F-strings and `+` build texts, within the budget and row by row if random; texts have no methods.
Read next: `evaluation.functions`, which puts all tables together.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LOAD
from scenic_lite.core.types import (
    Builtin,
    Instance,
    RandomChoice,
    ScenicClass,
    broadcasts_over_choices,
    choose,
    describe_kind,
    needs_context,
    randoms_in,
)
from scenic_lite.errors import ScenicError
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import ADD, AND, INTEGER, MULTIPLY, OR, TRUTH, Operation

MOST_PRINTED = 1000  # maximum number of stored lines
MOST_SUBLISTS = 256  # maximum number of possible results of a filter with random tests


# ------------------------------------------------------------ truth
def folded(operation: Operation, start: bool) -> Callable[..., Value]:
    """Return `all` or `any`; outside a requirement the elements must not be random."""

    def fold(scope: Scope, node: ast.AST, values: Value) -> Value:
        items = scope.elements(values, node)
        if not scope.mode.symbolic:
            scope.refuse_random_in(items, node, "control flow cannot depend on a random value")
        return reduce(lambda a, b: apply(operation, a, b), items, start)

    return fold


def truth(scope: Scope, node: ast.AST, value: Value = False) -> Value:
    """Return `bool(value)`."""
    if scope.mode.symbolic and isinstance(value, RandomExpr):
        return apply(TRUTH, value)
    return scope.certain_truth(value, node)


# ------------------------------------------------------------ containers
def length(scope: Scope, node: ast.AST, value: Value) -> Value:
    """Return `len(value)`."""
    return len(value) if isinstance(value, str | dict | range | list | tuple) else len(scope.elements(value, node))


def integer_range(scope: Scope, node: ast.AST, *ends: Value) -> range:
    """Return `range(...)`."""
    scope.refuse_random_in(ends, node, "a range cannot have random ends")
    numbers = range(*ends)
    try:
        count = len(numbers)
    except OverflowError:
        raise exceeded("a range of more elements than can be counted") from None
    if count > scope.mode.budget.limits.elements:
        scope.mode.budget.container(count)
    return numbers


def sorted_list(scope: Scope, node: ast.AST, values: Value, key: Value = None, reverse: Value = False) -> list:
    """Return `sorted(values, key=..., reverse=...)`; the keys and `reverse` must not be random."""
    items = scope.elements(values, node)
    keys = mapped(scope, node, key, items) if key is not None else items
    scope.mode.budget.whole(keys)
    scope.refuse_random_in(keys, node, "random values cannot be sorted")
    order = sorted(range(len(items)), key=lambda i: keys[i], reverse=scope.certain_truth(reverse, node))
    return [items[i] for i in order]


def zipped(scope: Scope, node: ast.AST, *several: Value) -> list:
    return list(zip(*(scope.elements(values, node) for values in several), strict=False))


def mapped(scope: Scope, node: ast.AST, function: Value, *several: Value) -> list:
    return [scope.call(function, list(items), {}, node) for items in zipped(scope, node, *several)]


@broadcasts_over_choices(3)
def filtered(scope: Scope, node: ast.AST, function: Value, values: Value) -> Value:
    """Return `filter(function, values)`; the selection may differ between scenes."""
    items = scope.elements(values, node)
    try:
        tests = items if function is None else mapped(scope, node, function, items)
    except ScenicError as error:
        if error.kind != "random-control-flow" or scope.mode.phase != LOAD:
            raise
        tests = mapped(scope.requiring(), node, function, items)
    return random_sublist(items, tests)


def random_sublist(items: list, tests: list) -> Value:
    """Return the elements whose tests hold, as a random choice among all possible lists."""
    sublists: list[list] = [[]]
    index: Value = 0
    for item, test in zip(items, tests, strict=True):
        longer = [[*sublist, item] for sublist in sublists]
        if not isinstance(test, RandomExpr):
            sublists = longer if test else sublists
            continue
        index = apply(ADD, index, apply(MULTIPLY, len(sublists), apply(INTEGER, test)))
        sublists += longer
        if len(sublists) > MOST_SUBLISTS:
            raise exceeded(f"a filter with more than {MOST_SUBLISTS} results")
    return choose(index, sublists) if isinstance(index, RandomExpr) else sublists[0]


def list_append(scope: Scope, node: ast.AST, self: list, item: Value) -> None:
    scope.mode.budget.grow(self, 1)
    self.append(item)


def list_extend(scope: Scope, node: ast.AST, self: list, items: Value) -> None:
    items = scope.elements(items, node)
    scope.mode.budget.grow(self, len(items))
    self.extend(items)


# ------------------------------------------------------------ texts
def written(dialect: int, value: Value) -> str:
    """Return the text of a fixed value inside a collection."""
    if isinstance(value, list | tuple):
        parts = ", ".join(written(dialect, part) for part in value)
        return f"[{parts}]" if isinstance(value, list) else f"({parts}{',' * (len(value) == 1)})"
    if isinstance(value, Vector):
        return f"({value.x} @ {value.y})" if dialect == 2 else f"Vector({value.x}, {value.y}, 0)"
    if isinstance(value, Instance):
        return value.title()
    if isinstance(value, dict):
        raise ScenicError(
            "unsupported", "a dictionary cannot be converted to text", hint="write its elements one by one"
        )
    return repr(value) if isinstance(value, int | float | str | None) else describe_kind(value)


@broadcasts_over_choices(1)
def text_of(scope: Scope, value: Value, spec: str = "") -> Value:
    """Return `str(value)` or the formatted text; row by row if the value is random."""
    if any(len(number) > 3 for number in re.findall(r"\d+", spec)):
        raise exceeded("a text format wider than 999")
    if isinstance(value, RandomExpr):
        if spec:
            format("" if value.kind == "text" else 1, spec)  # raises ValueError for an invalid format
        return RandomExpr(FormatEach(spec), (value,), "text")
    if spec and not isinstance(value, int | float | str):
        raise ScenicError("type", f"{describe_kind(value)} takes no format")
    if spec or isinstance(value, str):
        return format(value, spec)
    if any(True for _ in randoms_in(value)) and not isinstance(value, Instance):
        message = "a collection or vector with random or live values cannot be converted to text"
        raise ScenicError("unsupported", message, hint="write them one by one")
    scope.mode.budget.whole(value)  # a shared part is written at every occurrence
    text = written(scope.state.dialect, value)
    scope.mode.budget.text(len(text))
    return text


@dataclass(frozen=True)
class FormatEach:
    """Format each element of an array [N] with one format; "" is the format of `str`."""

    spec: str

    def __call__(self, values: Any) -> Any:
        texts = [format(value.item() if hasattr(value, "item") else value, self.spec) for value in values]
        return np.array(texts + [None], dtype=object)[:-1]


def no_method(name: str) -> ScenicError:
    hint = 'texts are put together by f"..." and +, and compared by == and in'
    return ScenicError("unsupported", f"texts have no method '{name}' here", hint=hint)


def printed(scope: Scope, node: ast.AST, *values: Value, sep: Value = " ", end: Value = "\n") -> None:
    """Implement `print`: `Program.printed` keeps output during loading; output in a match is discarded."""
    if scope.mode.phase == LOAD and len(scope.state.printed) < MOST_PRINTED:
        fixed = [isinstance(value, Instance) or next(randoms_in(value), None) is None for value in values]
        words = [text_of(scope, value) if known else "(random)" for value, known in zip(values, fixed, strict=True)]
        scope.state.printed.append((sep if isinstance(sep, str) else " ").join(words))


# ------------------------------------------------------------ types
def is_instance(scope: Scope, node: ast.AST, value: Value, types: Value) -> Value:
    """Return `isinstance(value, types)`; for a random choice it is fixed if all options agree, else random."""
    if isinstance(value, RandomChoice):
        answers = [is_instance(scope, node, option, types) for option in value.options]
        return answers[0] if len(set(answers)) == 1 else value.map_options(answers)
    return any(is_of(value, cls) for cls in (types if isinstance(types, tuple) else (types,)))


def is_subclass(scope: Scope, node: ast.AST, cls: Value, bases: Value) -> bool:
    """Return `issubclass(cls, bases)` for Scenic classes."""
    several = bases if isinstance(bases, tuple) else (bases,)
    other = next((each for each in (cls, *several) if not isinstance(each, ScenicClass)), None)
    if other is not None:
        raise ScenicError("type", f"issubclass takes classes of Scenic, not {describe_kind(other)}")
    return any(cls.derives_from(base) for base in several)


def is_of(value: Value, cls: Value) -> bool:
    if isinstance(cls, ScenicClass):
        return isinstance(value, Instance) and value.cls.derives_from(cls)
    if isinstance(cls, Builtin) and cls.types:
        return isinstance(value, cls.types)
    raise ScenicError("type", f"isinstance needs a class, not {describe_kind(cls)}")


# ------------------------------------------------------------ the tables
def plain(of: type, *names: str) -> dict[str, Builtin]:
    """Return methods of a Python container that neither add elements nor run code of the program.

    Python's comparison would compare random values by identity, so a random first argument is rejected.
    """

    def method(name: str) -> Callable[..., Value]:
        def do(scope: Scope, node: ast.AST, self: Value, *arguments: Value) -> Value:
            scope.refuse_random_in(arguments[:1], node, "a random value cannot be looked up here")
            scope.mode.budget.whole([self, *arguments])
            return vars(of)[name](self, *arguments)

        return do

    return needs_context(**{name: method(name) for name in names})


def typed(kind: type, function: Callable[..., Value], over_choices: bool = False) -> Builtin:
    """Return a function that is also a type, as in `isinstance(x, bool)`."""
    return Builtin(kind.__name__, function, needs_context=True, types=(kind,), over_choices=over_choices)


def left_out(hints: dict[str, str]) -> dict[str, Value]:
    """Return placeholders for unsupported Python functions; a call raises an error that names an alternative.

    `hints` maps each alternative to the names of the functions.
    """

    def refusal(name: str, hint: str) -> Builtin:
        def refuse(scope: Scope, node: ast.AST, *_: Any, **__: Any) -> None:
            raise ScenicError("unsupported", f"there is no {name}() here", hint=hint)

        return Builtin(name, refuse, needs_context=True, over_choices=False)

    return {name: refusal(name, hint) for hint, names in hints.items() for name in names.split()}


TYPES: tuple[Builtin, ...] = (
    typed(bool, truth),
    typed(str, lambda scope, node, value="": text_of(scope, value)),
    typed(range, integer_range),
    typed(list, lambda scope, node, values=(): scope.elements(values, node), over_choices=True),
    typed(tuple, lambda scope, node, values=(): tuple(scope.elements(values, node)), over_choices=True),
)
SOLID = "BoxRegion SpheroidRegion MeshVolumeRegion MeshSurfaceRegion PathRegion VoxelRegion BoxShape MeshShape"
PYTHON: dict[str, Value] = {
    **{kind.name: kind for kind in TYPES},
    "len": Builtin("len", length, needs_context=True),
    **needs_context(
        all=folded(AND, True),
        any=folded(OR, False),
        enumerate=lambda scope, node, iterable, start=0: list(enumerate(scope.elements(iterable, node), start)),
        reversed=lambda scope, node, values: scope.elements(values, node)[::-1],
        zip=zipped,
        sorted=sorted_list,
        map=mapped,
        filter=filtered,
        print=printed,
        verbosePrint=printed,
        isinstance=is_instance,
        issubclass=is_subclass,
    ),
    **left_out(
        {
            "write a list": "set iter",
            "write a tuple": "frozenset",
            "write {key: value for ...}": "dict",
            "write items[0]": "next",
            "call the function of the base by a name of its own": "super",
            "write a property with a default": "property",
            "write isinstance(x, ...)": "type callable",
            "a program opens no files": "localPath",
            "there are two dimensions here: write facing H": "Orientation",
            "there are two dimensions here: write RectangularRegion, CircularRegion ...": SOLID,
            "write x.name": "getattr",
            "write x.name = value": "setattr",
            "give the property a default in the class": "hasattr",
            "write str(x)": "repr hex oct bin",
            'write f"{x:.2f}"': "format",
            "write the text itself": "chr",
            "write the number itself": "ord",
            "write a // b and a % b": "divmod",
        }
    ),
}
LISTS = (
    plain(list, "pop", "remove", "index", "count", "reverse", "copy", "clear")
    | needs_context(append=list_append, extend=list_extend)
    | left_out({"write items = sorted(items)": "sort", "write items[i:i] = [x]": "insert"})
)
TUPLES = plain(tuple, "index", "count")
DICTIONARIES = (
    plain(dict, "get", "pop", "setdefault", "copy", "clear")
    | needs_context(
        keys=lambda scope, node, self: list(self),
        values=lambda scope, node, self: list(self.values()),
        items=lambda scope, node, self: list(self.items()),
    )
    | left_out({"write d[key] = value for each": "update"})
)
