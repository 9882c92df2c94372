"""The methods of lists, tuples, dictionaries and sets, within the budget.

What is not here does not exist for a program. Read next: `evaluation.attributes`, which looks them up.
"""

from __future__ import annotations

from typing import Any

from scenic_lite.core.builtin_tables import needs_context, plain
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import Value


def sorted_list(scope: Scope, node: Any, values: Value, key: Value = None, reverse: Value = False) -> list:
    """`sorted(values, key=..., reverse=...)`; what decides the order must not be random."""
    items = scope.elements(values, node)
    keys = [scope.call(key, [item], {}, node) for item in items] if key is not None else items
    scope.mode.budget.whole(keys)
    for each in keys:
        scope.refuse_random(each, node, "random values cannot be sorted")
    order = sorted(range(len(items)), key=lambda i: keys[i], reverse=scope.certain_truth(reverse, node))
    return [items[i] for i in order]


def list_append(scope: Scope, node: Any, self: list, item: Value) -> None:
    scope.mode.budget.container(len(self) + 1)
    scope.mode.budget.memory -= len(self)
    self.append(item)


def list_extend(scope: Scope, node: Any, self: list, items: Value) -> None:
    items = scope.elements(items, node)
    scope.mode.budget.container(len(self) + len(items))
    self.extend(items)


def list_insert(scope: Scope, node: Any, self: list, index: int, item: Value) -> None:
    scope.mode.budget.container(len(self) + 1)
    self.insert(index, item)


def list_sort(scope: Scope, node: Any, self: list, key: Value = None, reverse: Value = False) -> None:
    self[:] = sorted_list(scope, node, self, key, reverse)


def dictionary_update(scope: Scope, node: Any, self: dict, other: Value = (), **more: Value) -> None:
    pairs = other if isinstance(other, dict) else dictionary_of(scope, node, other)
    scope.mode.budget.container(len(self) + len(pairs) + len(more))
    self.update(pairs, **more)


def dictionary_of(scope: Scope, node: Any, pairs: Value) -> dict:
    """A dictionary of pairs, or a copy of one."""
    if isinstance(pairs, dict):
        return dict(pairs)
    found = [scope.elements(pair, node) for pair in scope.elements(pairs, node)]
    if any(len(pair) != 2 for pair in found):
        raise ScenicError("value", "a dictionary is made of pairs of a key and a value")
    scope.mode.budget.whole([key for key, _ in found])
    return dict(found)


def keys_of(scope: Scope, node: Any, keys: Value, value: Value = None) -> dict:
    """`dict.fromkeys(keys, value)`."""
    found = scope.elements(keys, node)
    scope.mode.budget.whole(found)
    return dict.fromkeys(found, value)


def dictionary_keys(scope: Scope, node: Any, self: dict) -> list:
    return list(self)


def dictionary_values(scope: Scope, node: Any, self: dict) -> list:
    return list(self.values())


def dictionary_items(scope: Scope, node: Any, self: dict) -> list:
    return list(self.items())


def set_update(scope: Scope, node: Any, self: set, *several: Value) -> None:
    for each in several:
        self.update(hashable(scope, node, each))
    scope.mode.budget.container(len(self))


def set_union(scope: Scope, node: Any, self: set, *several: Value) -> set:
    return self.union(*(hashable(scope, node, each) for each in several))


def set_intersection(scope: Scope, node: Any, self: set, *several: Value) -> set:
    return self.intersection(*(hashable(scope, node, each) for each in several))


def set_difference(scope: Scope, node: Any, self: set, *several: Value) -> set:
    return self.difference(*(hashable(scope, node, each) for each in several))


def set_symmetric(scope: Scope, node: Any, self: set, other: Value) -> set:
    return self.symmetric_difference(hashable(scope, node, other))


def set_within(scope: Scope, node: Any, self: set, other: Value) -> bool:
    return self.issubset(hashable(scope, node, other))


def set_around(scope: Scope, node: Any, self: set, other: Value) -> bool:
    return self.issuperset(hashable(scope, node, other))


def set_apart(scope: Scope, node: Any, self: set, other: Value) -> bool:
    return self.isdisjoint(hashable(scope, node, other))


def hashable(scope: Scope, node: Any, values: Value) -> list:
    """The elements of a collection that a set is to hold or to be compared with."""
    elements = scope.elements(values, node)
    scope.mode.budget.whole(elements)
    return elements


LISTS: dict[str, Builtin] = plain(
    "pop", "remove", "index", "count", "reverse", "copy", "clear", of=list
) | needs_context(append=list_append, extend=list_extend, insert=list_insert, sort=list_sort)
TUPLES: dict[str, Builtin] = plain("index", "count", of=tuple)
DICTIONARIES: dict[str, Builtin] = plain(
    "get", "pop", "popitem", "setdefault", "copy", "clear", of=dict
) | needs_context(update=dictionary_update, keys=dictionary_keys, values=dictionary_values, items=dictionary_items)
ASKED_OF_SETS: dict[str, Builtin] = plain("copy", of=set) | needs_context(
    union=set_union, intersection=set_intersection, difference=set_difference, symmetric_difference=set_symmetric,
    issubset=set_within, issuperset=set_around, isdisjoint=set_apart,
)  # fmt: skip
SETS: dict[str, Builtin] = (
    ASKED_OF_SETS | plain("add", "discard", "remove", "pop", "clear", of=set) | needs_context(update=set_update)
)
CLASS_METHODS: dict[str, dict[str, Builtin]] = {"dict": needs_context(fromkeys=keys_of)}
