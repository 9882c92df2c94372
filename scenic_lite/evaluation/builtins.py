"""Python's built-in functions of containers, texts and types, and the methods of lists and dictionaries.

Nothing of Python's own is reachable but what these tables hold; what they refuse by name is left out on purpose. Read
next: `evaluation.functions`, which puts all tables together.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import reduce
from typing import Any

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
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.math_builtins import NUMBERS
from scenic_lite.evaluation.strings import text_of
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import ADD, AND, INTEGER, MULTIPLY, OR, TRUTH, Operation

MOST_PRINTED = 1000  # lines that are kept
MOST_SUBLISTS = 256  # of a list that is filtered by random tests


def plain(*names: str, of: type) -> dict[str, Builtin]:
    """Return methods of a Python container that cannot grow it and run no code of the program's."""
    return {name: Builtin(name, vars(of)[name], over_choices=False) for name in names}


def typed(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    """Return a function that is also a type: `isinstance(x, int)`."""
    return Builtin(name, function, needs_context=True, types=types, over_choices=False)


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
    return reduce(lambda a, b: apply(operation, a, b), items, start)


def truth(scope: Scope, node: ast.AST, value: Value = False) -> Value:
    """`bool(value)`."""
    if scope.mode.symbolic and isinstance(value, RandomExpr):
        return apply(TRUTH, value)
    return scope.certain_truth(value, node)


# ------------------------------------------------------------ containers


@broadcasts_over_choices(2)
def length(scope: Scope, node: ast.AST, value: Value) -> Value:
    """`len(value)`."""
    return len(value) if isinstance(value, str | dict | range | list | tuple) else len(scope.elements(value, node))


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


@broadcasts_over_choices(2)
def make_list(scope: Scope, node: ast.AST, values: Value = ()) -> Value:
    return scope.elements(values, node)


@broadcasts_over_choices(2)
def make_tuple(scope: Scope, node: ast.AST, values: Value = ()) -> Value:
    return tuple(scope.elements(values, node))


def make_dictionary(scope: Scope, node: ast.AST, values: Value = (), **more: Value) -> dict:
    """`dict(...)`: of pairs, or a copy of one."""
    if isinstance(values, dict):
        return values | more
    pairs = [scope.elements(pair, node) for pair in scope.elements(values, node)]
    if any(len(pair) != 2 for pair in pairs):
        raise ScenicError("value", "a dictionary is made of pairs of a key and a value")
    scope.mode.budget.whole([key for key, _ in pairs])
    return dict(pairs) | more


def sorted_list(scope: Scope, node: ast.AST, values: Value, key: Value = None, reverse: Value = False) -> list:
    """`sorted(values, key=..., reverse=...)`; what decides the order must not be random."""
    items = scope.elements(values, node)
    keys = [scope.call(key, [item], {}, node) for item in items] if key is not None else items
    scope.mode.budget.whole(keys)
    for sort_key in keys:
        scope.refuse_random(sort_key, node, "random values cannot be sorted")
    order = sorted(range(len(items)), key=lambda i: keys[i], reverse=scope.certain_truth(reverse, node))
    return [items[i] for i in order]


def enumerated(scope: Scope, node: ast.AST, iterable: Value, start: Value = 0) -> list:
    return list(enumerate(scope.elements(iterable, node), start))


def zipped(scope: Scope, node: ast.AST, *several: Value) -> list:
    return list(zip(*(scope.elements(values, node) for values in several), strict=False))


def backwards(scope: Scope, node: ast.AST, values: Value) -> list:
    return scope.elements(values, node)[::-1]


def mapped(scope: Scope, node: ast.AST, function: Value, *several: Value) -> list:
    return [scope.call(function, list(items), {}, node) for items in zipped(scope, node, *several)]


@broadcasts_over_choices(3)
def filtered(scope: Scope, node: ast.AST, function: Value, values: Value) -> Value:
    """`filter(function, values)`; which elements are kept may differ from scene to scene."""
    items = scope.elements(values, node)
    try:
        tests = items if function is None else mapped(scope, node, function, items)
    except ScenicError as error:
        if error.kind != "random-control-flow" or scope.mode.phase != LOAD:
            raise
        tests = mapped(scope.requiring(), node, function, items)
    return random_sublist(items, tests)


def random_sublist(items: list, tests: list) -> Value:
    """Return the elements whose tests hold: one of all the lists that may be."""
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
    scope.mode.budget.container(len(self) + 1)
    scope.mode.budget.memory -= len(self)
    self.append(item)


def list_extend(scope: Scope, node: ast.AST, self: list, items: Value) -> None:
    items = scope.elements(items, node)
    scope.mode.budget.container(len(self) + len(items))
    self.extend(items)


def list_insert(scope: Scope, node: ast.AST, self: list, index: int, item: Value) -> None:
    scope.mode.budget.container(len(self) + 1)
    self.insert(index, item)


def list_sort(scope: Scope, node: ast.AST, self: list, key: Value = None, reverse: Value = False) -> None:
    self[:] = sorted_list(scope, node, self, key, reverse)


def dictionary_update(scope: Scope, node: ast.AST, self: dict, other: Value = (), **more: Value) -> None:
    pairs = make_dictionary(scope, node, other, **more)
    scope.mode.budget.container(len(self) + len(pairs))
    self.update(pairs)


def keys_of(scope: Scope, node: ast.AST, keys: Value, value: Value = None) -> dict:
    """`dict.fromkeys(keys, value)`."""
    return make_dictionary(scope, node, [(key, value) for key in scope.elements(keys, node)])


# ------------------------------------------------------------ texts and types


def text(scope: Scope, node: ast.AST, value: Value = "") -> Value:
    """`str(value)`."""
    return text_of(scope, value)


def printed(scope: Scope, node: ast.AST, *values: Value, sep: Value = " ", end: Value = "\n") -> None:
    """`print`: what a program says while it is loaded is kept in `Program.printed`; in a match nobody listens."""
    texts = [text_of(scope, value) for value in values]
    if scope.mode.phase == LOAD and len(scope.state.printed) < MOST_PRINTED:
        words = [text if isinstance(text, str) else "(random)" for text in texts]
        scope.state.printed.append((sep if isinstance(sep, str) else " ").join(words))


def is_instance(scope: Scope, node: ast.AST, value: Value, types: Value) -> Value:
    """`isinstance(value, types)`; of a random choice, if all its options agree or in a requirement."""
    if isinstance(value, RandomChoice):
        answers = [is_instance(scope, node, option, types) for option in value.options]
        return answers[0] if len(set(answers)) == 1 else value.map_options(answers)
    return any(is_of(value, cls) for cls in (types if isinstance(types, tuple) else (types,)))


def is_of(value: Value, cls: Value) -> bool:
    if isinstance(cls, ScenicClass):
        return isinstance(value, Instance) and value.cls.derives_from(cls)
    if isinstance(cls, Builtin) and cls.types:
        return isinstance(value, cls.types)
    raise ScenicError("type", f"isinstance needs a class, not {describe_kind(cls)}")


def left_out(name: str, hint: str) -> Builtin:
    """Return a function of Python's that a program may expect here: its call says what to write instead."""

    def refuse(scope: Scope, node: ast.AST, *_: Any, **__: Any) -> None:
        raise ScenicError("unsupported", f"there is no {name}() here", hint=hint)

    return Builtin(name, refuse, needs_context=True, over_choices=False)


TYPES: dict[str, Builtin] = {
    "int": NUMBERS["int"],
    "float": NUMBERS["float"],
    "bool": typed("bool", truth, bool),
    "str": typed("str", text, str),
    "range": typed("range", integer_range, range),
    "list": typed("list", make_list, list),
    "tuple": typed("tuple", make_tuple, tuple),
    "dict": typed("dict", make_dictionary, dict),
}
LEFT_OUT = {
    "set": "write a list",
    "frozenset": "write a tuple",
    "iter": "write a list",
    "next": "write items[0]",
    "super": "call the function of the base by a name of its own",
    "property": "write a property with a default",
    "type": "write isinstance(x, ...)",
    "issubclass": "write isinstance(x, ...)",
    "callable": "write isinstance(x, ...)",
    "getattr": "write x.name",
    "setattr": "write x.name = value",
    "hasattr": "give the property a default in the class",
    "repr": "write str(x)",
    "format": 'write f"{x:.2f}"',
    "chr": "write the text itself",
    "ord": "write the number itself",
    "hex": "write str(x)",
    "oct": "write str(x)",
    "bin": "write str(x)",
    "divmod": "write a // b and a % b",
}
PYTHON: dict[str, Value] = {
    **TYPES,
    **needs_context(
        all=every, any=some, len=length, enumerate=enumerated, zip=zipped, reversed=backwards, sorted=sorted_list,
        map=mapped, filter=filtered, print=printed, isinstance=is_instance,
    ),
    **{name: left_out(name, hint) for name, hint in LEFT_OUT.items()},
}  # fmt: skip
LISTS: dict[str, Builtin] = plain(
    "pop", "remove", "index", "count", "reverse", "copy", "clear", of=list
) | needs_context(append=list_append, extend=list_extend, insert=list_insert, sort=list_sort)
TUPLES: dict[str, Builtin] = plain("index", "count", of=tuple)
DICTIONARIES: dict[str, Builtin] = plain(
    "get", "pop", "setdefault", "copy", "clear", of=dict
) | needs_context(
    update=dictionary_update,
    keys=lambda scope, node, self: list(self),
    values=lambda scope, node, self: list(self.values()),
    items=lambda scope, node, self: list(self.items()),
)  # fmt: skip
CLASS_METHODS: dict[str, dict[str, Builtin]] = {"dict": needs_context(fromkeys=keys_of)}
