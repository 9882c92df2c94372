"""Python's built-in functions of containers, texts and types, and the methods of lists and dictionaries.

Nothing of Python's own is reachable but what these tables hold; what they refuse by name is left out on purpose. Texts
are put together by f-strings and `+`, within the budget and one by one where they are random; they have no methods.
Read next: `evaluation.functions`, which puts all tables together.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LOAD, LoadState
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
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import ADD, AND, INTEGER, MULTIPLY, OR, TEXT, TRUTH, Operation

MOST_PRINTED = 1000  # lines that are kept
MOST_SUBLISTS = 256  # of a list that is filtered by random tests
DEEPEST = 50  # containers inside each other that are written out

# ------------------------------------------------------------ truth


def folded(operation: Operation, start: bool) -> Callable[..., Value]:
    """Return `all` or `any`, which outside a requirement must not depend on random values."""

    def fold(scope: Scope, node: ast.AST, values: Value) -> Value:
        items = scope.elements(values, node)
        if not scope.mode.symbolic:
            scope.refuse_random_in(items, node, "control flow cannot depend on a random value")
        return reduce(lambda a, b: apply(operation, a, b), items, start)

    return fold


def truth(scope: Scope, node: ast.AST, value: Value = False) -> Value:
    """`bool(value)`."""
    if scope.mode.symbolic and isinstance(value, RandomExpr):
        return apply(TRUTH, value)
    return scope.certain_truth(value, node)


# ------------------------------------------------------------ containers


def length(scope: Scope, node: ast.AST, value: Value) -> Value:
    """`len(value)`."""
    return len(value) if isinstance(value, str | dict | range | list | tuple) else len(scope.elements(value, node))


def integer_range(scope: Scope, node: ast.AST, *ends: Value) -> range:
    """`range(...)`."""
    scope.refuse_random_in(ends, node, "a range cannot have random ends")
    numbers = range(*ends)
    try:
        count = len(numbers)
    except OverflowError:
        raise exceeded("a range of more elements than can be counted") from None
    if count > scope.mode.budget.limits.elements:
        scope.mode.budget.container(count)
    return numbers


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
    scope.mode.budget.grow(self, 1)
    self.append(item)


def list_extend(scope: Scope, node: ast.AST, self: list, items: Value) -> None:
    items = scope.elements(items, node)
    scope.mode.budget.grow(self, len(items))
    self.extend(items)


def list_insert(scope: Scope, node: ast.AST, self: list, index: int, item: Value) -> None:
    scope.mode.budget.grow(self, 1)
    self.insert(index, item)


def list_sort(scope: Scope, node: ast.AST, self: list, key: Value = None, reverse: Value = False) -> None:
    self[:] = sorted_list(scope, node, self, key, reverse)


def dictionary_update(scope: Scope, node: ast.AST, self: dict, other: Value = (), **more: Value) -> None:
    pairs = make_dictionary(scope, node, other, **more)
    scope.mode.budget.grow(self, len(pairs))
    self.update(pairs)


def keys_of(scope: Scope, node: ast.AST, keys: Value, value: Value = None) -> dict:
    """`dict.fromkeys(keys, value)`."""
    return make_dictionary(scope, node, [(key, value) for key in scope.elements(keys, node)])


# ------------------------------------------------------------ texts


def represent(state: LoadState, value: Value, depth: int = 0) -> Value:
    """Return a value as it is written inside a container, a text in quotes; row by row if it is random."""
    if depth > DEEPEST:
        raise exceeded("a text of collections that are nested too deeply")
    if isinstance(value, dict):
        pairs = [represent(state, k, depth + 1) + ": " + represent(state, v, depth + 1) for k, v in value.items()]
        return "{" + separated(state, pairs) + "}"
    if isinstance(value, list | tuple):
        inside = separated(state, [represent(state, element, depth + 1) for element in value])
        return "[" + inside + "]" if isinstance(value, list) else "(" + inside + "," * (len(value) == 1) + ")"
    if isinstance(value, Vector):
        x, y = represent(state, value.x), represent(state, value.y)
        return "(" + x + " @ " + y + ")" if state.dialect == 2 else "Vector(" + x + ", " + y + ", 0)"
    if isinstance(value, RandomExpr):
        return RandomExpr(array_represented, (value,), "text")
    if isinstance(value, RandomChoice):
        return value.each(lambda option: represent(state, option, depth))
    if isinstance(value, Instance):
        return value.title()
    if isinstance(value, int | float | str | range | type(None)):
        return repr(value)
    if isinstance(value, ScenicClass) or (isinstance(value, Builtin) and value.types):
        return f"<class '{value.name}'>"
    return describe_kind(value)


def array_represented(values: Any) -> Any:
    """Return each element [N] as it is written inside a container."""
    texts = [repr(element.item() if hasattr(element, "item") else element) for element in values]
    return np.array(texts + [None], dtype=object)[:-1]


def separated(state: LoadState, parts: list[Value]) -> Value:
    """Return texts with commas between them."""
    if not all(isinstance(part, str) for part in parts):
        return reduce(lambda before, part: before + ", " + part, parts)
    inside = ", ".join(parts)
    state.budget.text(len(inside))
    return inside


@broadcasts_over_choices(1)
def text_of(scope: Scope, value: Value, spec: str = "") -> Value:
    """`str(value)`, or its formatted text; row by row if it is random."""
    if any(len(number) > 3 for number in re.findall(r"\d+", spec)):
        raise exceeded("a text format wider than 999")
    if isinstance(value, RandomExpr):
        if spec:
            format("" if value.kind == "text" else 1, spec)  # raises ValueError if the spec is none
        return RandomExpr(TEXT.array if not spec else FormatEach(spec), (value,), "text")
    if spec and not isinstance(value, int | float | str):
        raise ScenicError("type", f"{describe_kind(value)} takes no format")
    if spec or isinstance(value, str):
        return format(value, spec)
    scope.mode.budget.whole(value)  # a part that is shared is written each time
    return represent(scope.state, value)


class FormatEach:
    """Write each element of an array [N] with one format."""

    def __init__(self, spec: str) -> None:
        self.spec = spec

    def __call__(self, values: Any) -> Any:
        texts = [format(value.item() if hasattr(value, "item") else value, self.spec) for value in values]
        return np.array(texts + [None], dtype=object)[:-1]


def no_method(name: str) -> ScenicError:
    hint = 'texts are put together by f"..." and +, and compared by == and in'
    return ScenicError("unsupported", f"texts have no method '{name}' here", hint=hint)


def printed(scope: Scope, node: ast.AST, *values: Value, sep: Value = " ", end: Value = "\n") -> None:
    """`print`: what a program says while it is loaded is kept in `Program.printed`; in a match nobody listens."""
    texts = [text_of(scope, value) for value in values]
    if scope.mode.phase == LOAD and len(scope.state.printed) < MOST_PRINTED:
        words = [text if isinstance(text, str) else "(random)" for text in texts]
        scope.state.printed.append((sep if isinstance(sep, str) else " ").join(words))


# ------------------------------------------------------------ types


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


# ------------------------------------------------------------ the tables


def plain(of: type, *names: str) -> dict[str, Builtin]:
    """Return methods of a Python container that cannot grow it and run no code of the program's."""
    return {name: Builtin(name, vars(of)[name], over_choices=False) for name in names}


def typed(kind: type, function: Callable[..., Value], over_choices: bool = False) -> Builtin:
    """Return a function that is also a type: `isinstance(x, bool)`."""
    return Builtin(kind.__name__, function, needs_context=True, types=(kind,), over_choices=over_choices)


def left_out(hints: dict[str, str]) -> dict[str, Value]:
    """Return functions of Python's that a program may expect: a call says what to write instead.

    `hints` gives the names by what is written instead.
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
    typed(dict, make_dictionary),
)
PYTHON: dict[str, Value] = {
    **{each.name: each for each in TYPES},
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
        isinstance=is_instance,
    ),
    **left_out(
        {
            "write a list": "set iter",
            "write a tuple": "frozenset",
            "write items[0]": "next",
            "call the function of the base by a name of its own": "super",
            "write a property with a default": "property",
            "write isinstance(x, ...)": "type issubclass callable",
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
LISTS = plain(list, "pop", "remove", "index", "count", "reverse", "copy", "clear") | needs_context(
    append=list_append, extend=list_extend, insert=list_insert, sort=list_sort
)
TUPLES = plain(tuple, "index", "count")
DICTIONARIES = plain(dict, "get", "pop", "setdefault", "copy", "clear") | needs_context(
    update=dictionary_update,
    keys=lambda scope, node, self: list(self),
    values=lambda scope, node, self: list(self.values()),
    items=lambda scope, node, self: list(self.items()),
)
CLASS_METHODS: dict[str, dict[str, Builtin]] = {"dict": needs_context(fromkeys=keys_of)}
