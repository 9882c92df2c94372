"""Python's built-in functions of containers, texts, types and attributes.

Nothing of Python's own is reachable but what these tables hold. Read next: `evaluation.functions`, which puts all
tables together.
"""

from __future__ import annotations

import ast
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.builtin_tables import typed
from scenic_lite.core.environment import Environment
from scenic_lite.core.exceptions import NAMED, ExceptionClass, Fault, named_fault
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LOAD
from scenic_lite.core.types import (
    Behavior,
    Bound,
    Builtin,
    Descriptor,
    Function,
    Instance,
    RandomChoice,
    ScenicClass,
    Stream,
    Super,
    describe_kind,
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.assignments import set_attribute
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.containers import dictionary_of, sorted_list
from scenic_lite.evaluation.math_builtins import NUMBERS
from scenic_lite.evaluation.strings import represented, text_of
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import AND, OR, TRUTH, Operation

CALLABLE = (Function, Bound, Builtin, ScenicClass, ExceptionClass, Behavior)
NOTHING = object()  # no default was given
MOST_PRINTED = 1000  # lines that are kept


# ------------------------------------------------------------ truth


def every(scope: Scope, node: ast.AST, values: Value) -> Value:
    """`all(values)`."""
    return folded(scope, node, values, AND, True)


def some(scope: Scope, node: ast.AST, values: Value) -> Value:
    """`any(values)`."""
    return folded(scope, node, values, OR, False)


def folded(scope: Scope, node: ast.AST, values: Value, operation: Operation, start: bool) -> Value:
    items = scope.elements(values, node)
    if not scope.mode.symbolic:
        for item in items:
            scope.refuse_random(item, node, "control flow cannot depend on a random value")
    return reduce(lambda a, b: apply(operation, a, b, kind="truth"), items, start)


def truth(scope: Scope, node: ast.AST, value: Value = False) -> Value:
    """`bool(value)`."""
    if scope.mode.symbolic and isinstance(value, RandomExpr):
        return apply(TRUTH, value, kind="truth")
    return scope.certain_truth(value, node)


# ------------------------------------------------------------ containers and iteration


def length(scope: Scope, node: ast.AST, value: Value) -> Value:
    """`len(value)`; a random text has a random one."""
    if isinstance(value, RandomChoice):
        return value.map_options([length(scope, node, option) for option in value.options])
    if kind_of(value) == "text" and isinstance(value, RandomExpr):
        return RandomExpr(each_length, (value,))
    if isinstance(value, str | dict | set | range | list | tuple):
        return len(value)
    if isinstance(value, Stream):
        raise ScenicError("type", "an iterator has no length", hint="write len(list(...))")
    return len(scope.elements(value, node))


def each_length(texts: Any) -> Any:
    return np.array([len(each) for each in texts], dtype=np.int64)


def integer_range(scope: Scope, node: ast.AST, *ends: Value) -> range:
    """`range(...)`."""
    for end in ends:
        scope.refuse_random(end, node, "a range cannot have random ends")
    numbers = range(*ends)
    try:
        count = len(numbers)
    except OverflowError:
        raise exceeded("a range of more elements than can be counted") from None
    if count > scope.mode.budget.limits.elements:
        scope.mode.budget.container(count)
    return numbers


def make_list(scope: Scope, node: ast.AST, values: Value = ()) -> Value:
    if isinstance(values, RandomChoice):
        return values.map_options([make_list(scope, node, option) for option in values.options])
    return scope.elements(values, node)


def make_tuple(scope: Scope, node: ast.AST, values: Value = ()) -> Value:
    if isinstance(values, RandomChoice):
        return values.map_options([make_tuple(scope, node, option) for option in values.options])
    return tuple(scope.elements(values, node))


def make_set(scope: Scope, node: ast.AST, values: Value = ()) -> set:
    elements = scope.elements(values, node)
    scope.mode.budget.whole(elements)
    return set(elements)


def make_dictionary(scope: Scope, node: ast.AST, values: Value = (), **more: Value) -> dict:
    return dictionary_of(scope, node, values) | more


def numbered(scope: Scope, node: ast.AST, iterable: Value, start: Value = 0) -> Stream:
    """`enumerate(iterable, start)`."""
    return stream(scope, list(enumerate(scope.elements(iterable, node), start)))


def zipped(scope: Scope, node: ast.AST, *several: Value, strict: Value = False) -> Stream:
    """`zip(...)`."""
    parts = [scope.elements(values, node) for values in several]
    if strict and len({len(part) for part in parts}) > 1:
        raise ScenicError("value", "zip() of collections of different lengths")
    return stream(scope, list(zip(*parts, strict=False)))


def backwards(scope: Scope, node: ast.AST, values: Value) -> Stream:
    """`reversed(values)`."""
    return stream(scope, scope.elements(values, node)[::-1])


def mapped(scope: Scope, node: ast.AST, function: Value, *several: Value) -> Stream:
    """`map(function, ...)`."""
    parts = [scope.elements(values, node) for values in several]
    return stream(scope, [scope.call(function, list(items), {}, node) for items in zip(*parts, strict=False)])


def filtered(scope: Scope, node: ast.AST, function: Value, values: Value) -> Stream:
    """`filter(function, values)`; which elements are kept must not be random."""
    kept = []
    for item in scope.elements(values, node):
        test = item if function is None else scope.call(function, [item], {}, node)
        if scope.certain_truth(test, node):
            kept.append(item)
    return stream(scope, kept)


def iterator(scope: Scope, node: ast.AST, values: Value) -> Stream:
    """`iter(values)`."""
    return values if isinstance(values, Stream) else stream(scope, scope.elements(values, node))


def following(scope: Scope, node: ast.AST, iterator: Value, default: Value = NOTHING) -> Value:
    """`next(iterator, default)`."""
    if not isinstance(iterator, Stream):
        hint = "write next(iter(...))"
        raise ScenicError("type", f"next() needs an iterator, not {describe_kind(iterator)}", hint=hint)
    if iterator.at < len(iterator.items):
        iterator.at += 1
        return iterator.items[iterator.at - 1]
    if default is NOTHING:
        raise named_fault("StopIteration", ScenicError("value", "the iterator has no further element"))
    return default


def stream(scope: Scope, items: list) -> Stream:
    scope.mode.budget.container(len(items))
    return Stream(items)


# ------------------------------------------------------------ texts


def text(scope: Scope, node: ast.AST, value: Value = "") -> Value:
    """`str(value)`."""
    return text_of(scope, value)


def formatted(scope: Scope, node: ast.AST, value: Value, spec: Value = "") -> Value:
    """`format(value, spec)`."""
    return text_of(scope, value, spec)


def character(scope: Scope, node: ast.AST, number: Value) -> str:
    return chr(number)


def code(scope: Scope, node: ast.AST, character: Value) -> int:
    return ord(character)


def printed(scope: Scope, node: ast.AST, *values: Value, sep: Value = " ", end: Value = "\n") -> None:
    """`print`: what a program says while it is loaded is kept in `Program.printed`; in a match nobody listens."""
    texts = [text_of(scope, value) for value in values]
    if scope.mode.phase == LOAD and len(scope.state.printed) < MOST_PRINTED:
        words = [text if isinstance(text, str) else "(random)" for text in texts]
        scope.state.printed.append((sep if isinstance(sep, str) else " ").join(words))


# ------------------------------------------------------------ types and attributes


def is_instance(scope: Scope, node: ast.AST, value: Value, types: Value) -> Value:
    """`isinstance(value, types)`; of a random choice, if all its options agree or in a requirement."""
    if isinstance(value, RandomChoice):
        answers = [is_instance(scope, node, option, types) for option in value.options]
        return answers[0] if len(set(answers)) == 1 else value.map_options(answers)
    return any(is_of(value, each) for each in (types if isinstance(types, tuple) else (types,)))


def is_of(value: Value, cls: Value) -> bool:
    if isinstance(cls, ScenicClass):
        return isinstance(value, Instance) and value.cls.derives_from(cls)
    if isinstance(cls, ExceptionClass):
        return isinstance(value, Fault) and value.cls.derives_from(cls)
    if isinstance(cls, Builtin) and cls.types:
        return isinstance(value, cls.types)
    raise ScenicError("type", f"isinstance needs a class, not {describe_kind(cls)}")


def is_subclass(scope: Scope, node: ast.AST, cls: Value, types: Value) -> bool:
    if not isinstance(cls, ScenicClass | ExceptionClass):
        raise ScenicError("type", f"issubclass needs a class, not {describe_kind(cls)}")
    several = types if isinstance(types, tuple) else (types,)
    return any(each is base for each in several for base in cls.lineage())


def type_of(scope: Scope, node: ast.AST, value: Value) -> Value:
    """`type(value)`: the function of that name, or the class."""
    if isinstance(value, Instance | Fault):
        return value.cls
    if value is None:
        return NONE_TYPE
    scope.refuse_random(value, node, "the type of a random value")
    found = [each for each in TYPES.values() if type(value) in each.types]
    if not found:
        raise ScenicError("unsupported", f"the type of {describe_kind(value)}", hint="write isinstance(x, ...)")
    return found[0]


def has_attribute(scope: Scope, node: ast.AST, value: Value, name: Value) -> bool:
    """`hasattr(value, name)`."""
    return get_attribute(scope, node, value, name, NOTHING) is not NOTHING


def get_attribute(scope: Scope, node: ast.AST, value: Value, name: Value, *default: Value) -> Value:
    """`getattr(value, name[, default])`, from the same tables as `value.name`."""
    if not isinstance(name, str):
        raise ScenicError("type", f"the name of an attribute is a text, not {describe_kind(name)}")
    try:
        return attribute(scope, value, name)
    except ScenicError as error:
        if error.kind != "name" or not default:
            raise
        return default[0]


def attribute_to(scope: Scope, node: ast.AST, value: Value, name: Value, new: Value) -> None:
    """`setattr(value, name, new)`."""
    set_attribute(scope, value, name, new)


def can_be_called(value: Value) -> bool:
    return isinstance(value, CALLABLE)


def own_super(scope: Scope, node: ast.AST) -> Super:
    """`super()` in a method."""
    at: Environment | None = scope
    while at is not None and at.method is None:
        at = at.outer
    if at is None or at.method is None or at.method[0].base is None:
        raise ScenicError("type", "super() has a meaning only in a method of a class")
    return Super(at.method[0].base, at.method[1])


def descriptor(kind: str) -> Builtin:
    return Builtin(kind, lambda function: Descriptor(kind, function), over_choices=False)


NONE_TYPE = typed("NoneType", lambda scope, node: None, type(None))
TYPES: dict[str, Builtin] = {
    "int": NUMBERS["int"],
    "float": NUMBERS["float"],
    "bool": typed("bool", truth, bool),
    "str": typed("str", text, str),
    "range": typed("range", integer_range, range),
    "list": typed("list", make_list, list),
    "tuple": typed("tuple", make_tuple, tuple),
    "set": typed("set", make_set, set),
    "dict": typed("dict", make_dictionary, dict),
}
PYTHON: dict[str, Value] = (
    TYPES
    | NAMED
    | {
        "all": Builtin("all", every, needs_context=True, over_choices=False),
        "any": Builtin("any", some, needs_context=True, over_choices=False),
        "len": Builtin("len", length, needs_context=True, over_choices=False),
        "enumerate": Builtin("enumerate", numbered, needs_context=True, over_choices=False),
        "zip": Builtin("zip", zipped, needs_context=True, over_choices=False),
        "reversed": Builtin("reversed", backwards, needs_context=True, over_choices=False),
        "sorted": Builtin("sorted", sorted_list, needs_context=True, over_choices=False),
        "map": Builtin("map", mapped, needs_context=True, over_choices=False),
        "filter": Builtin("filter", filtered, needs_context=True, over_choices=False),
        "iter": Builtin("iter", iterator, needs_context=True, over_choices=False),
        "next": Builtin("next", following, needs_context=True, over_choices=False),
        "repr": Builtin("repr", represented, needs_context=True, over_choices=False),
        "format": Builtin("format", formatted, needs_context=True, over_choices=False),
        "chr": Builtin("chr", character, needs_context=True, over_choices=False),
        "ord": Builtin("ord", code, needs_context=True, over_choices=False),
        "print": Builtin("print", printed, needs_context=True, over_choices=False),
        "isinstance": Builtin("isinstance", is_instance, needs_context=True, over_choices=False),
        "issubclass": Builtin("issubclass", is_subclass, needs_context=True, over_choices=False),
        "type": Builtin("type", type_of, needs_context=True, over_choices=False),
        "hasattr": Builtin("hasattr", has_attribute, needs_context=True, over_choices=False),
        "getattr": Builtin("getattr", get_attribute, needs_context=True, over_choices=False),
        "setattr": Builtin("setattr", attribute_to, needs_context=True, over_choices=False),
        "callable": Builtin("callable", can_be_called, over_choices=False),
        "super": Builtin("super", own_super, needs_context=True, over_choices=False),
        "staticmethod": descriptor("staticmethod"),
        "classmethod": descriptor("classmethod"),
        "property": descriptor("property"),
    }
)
