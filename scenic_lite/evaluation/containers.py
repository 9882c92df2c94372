"""The methods of lists, tuples, dictionaries and sets, within the budget.

What is not here does not exist for a program. Read next: `evaluation.attributes`, which looks them up.
"""

from __future__ import annotations

from typing import Any

from scenic_lite.core.builtin_tables import plain, sited
from scenic_lite.core.scope import Frame
from scenic_lite.core.types import Builtin
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import Value


def sorted_list(frame: Frame, node: Any, values: Value, key: Value = None, reverse: Value = False) -> list:
    """`sorted(values, key=..., reverse=...)`; what decides the order must not be random."""
    items = frame.elements(values, node)
    keys = [frame.call(key, [item], {}, node) for item in items] if key is not None else items
    frame.session.budget.whole(keys)
    for each in keys:
        frame.refuse_random(each, node, "random values cannot be sorted")
    order = sorted(range(len(items)), key=lambda i: keys[i], reverse=frame.certain_truth(reverse, node))
    return [items[i] for i in order]


def list_append(frame: Frame, node: Any, self: list, item: Value) -> None:
    frame.session.budget.container(len(self) + 1)
    frame.session.budget.memory -= len(self)
    self.append(item)


def list_extend(frame: Frame, node: Any, self: list, items: Value) -> None:
    items = frame.elements(items, node)
    frame.session.budget.container(len(self) + len(items))
    self.extend(items)


def list_insert(frame: Frame, node: Any, self: list, index: int, item: Value) -> None:
    frame.session.budget.container(len(self) + 1)
    self.insert(index, item)


def list_sort(frame: Frame, node: Any, self: list, key: Value = None, reverse: Value = False) -> None:
    self[:] = sorted_list(frame, node, self, key, reverse)


def dictionary_update(frame: Frame, node: Any, self: dict, other: Value = (), **more: Value) -> None:
    pairs = other if isinstance(other, dict) else dictionary_of(frame, node, other)
    frame.session.budget.container(len(self) + len(pairs) + len(more))
    self.update(pairs, **more)


def dictionary_of(frame: Frame, node: Any, pairs: Value) -> dict:
    """A dictionary of pairs, or a copy of one."""
    if isinstance(pairs, dict):
        return dict(pairs)
    found = [frame.elements(pair, node) for pair in frame.elements(pairs, node)]
    if any(len(pair) != 2 for pair in found):
        raise ScenicError("value", "a dictionary is made of pairs of a key and a value")
    frame.session.budget.whole([key for key, _ in found])
    return dict(found)


def keys_of(frame: Frame, node: Any, keys: Value, value: Value = None) -> dict:
    """`dict.fromkeys(keys, value)`."""
    found = frame.elements(keys, node)
    frame.session.budget.whole(found)
    return dict.fromkeys(found, value)


def dictionary_keys(frame: Frame, node: Any, self: dict) -> list:
    return list(self)


def dictionary_values(frame: Frame, node: Any, self: dict) -> list:
    return list(self.values())


def dictionary_items(frame: Frame, node: Any, self: dict) -> list:
    return list(self.items())


def set_update(frame: Frame, node: Any, self: set, *several: Value) -> None:
    for each in several:
        self.update(hashable(frame, node, each))
    frame.session.budget.container(len(self))


def set_union(frame: Frame, node: Any, self: set, *several: Value) -> set:
    return self.union(*(hashable(frame, node, each) for each in several))


def set_intersection(frame: Frame, node: Any, self: set, *several: Value) -> set:
    return self.intersection(*(hashable(frame, node, each) for each in several))


def set_difference(frame: Frame, node: Any, self: set, *several: Value) -> set:
    return self.difference(*(hashable(frame, node, each) for each in several))


def set_symmetric(frame: Frame, node: Any, self: set, other: Value) -> set:
    return self.symmetric_difference(hashable(frame, node, other))


def set_within(frame: Frame, node: Any, self: set, other: Value) -> bool:
    return self.issubset(hashable(frame, node, other))


def set_around(frame: Frame, node: Any, self: set, other: Value) -> bool:
    return self.issuperset(hashable(frame, node, other))


def set_apart(frame: Frame, node: Any, self: set, other: Value) -> bool:
    return self.isdisjoint(hashable(frame, node, other))


def hashable(frame: Frame, node: Any, values: Value) -> list:
    """The elements of a collection that a set is to hold or to be compared with."""
    elements = frame.elements(values, node)
    frame.session.budget.whole(elements)
    return elements


LISTS: dict[str, Builtin] = plain("pop", "remove", "index", "count", "reverse", "copy", "clear", of=list) | sited(
    append=list_append, extend=list_extend, insert=list_insert, sort=list_sort
)
TUPLES: dict[str, Builtin] = plain("index", "count", of=tuple)
DICTIONARIES: dict[str, Builtin] = plain("get", "pop", "popitem", "setdefault", "copy", "clear", of=dict) | sited(
    update=dictionary_update, keys=dictionary_keys, values=dictionary_values, items=dictionary_items
)
ASKED_OF_SETS: dict[str, Builtin] = plain("copy", of=set) | sited(
    union=set_union, intersection=set_intersection, difference=set_difference, symmetric_difference=set_symmetric,
    issubset=set_within, issuperset=set_around, isdisjoint=set_apart,
)  # fmt: skip
SETS: dict[str, Builtin] = (
    ASKED_OF_SETS | plain("add", "discard", "remove", "pop", "clear", of=set) | sited(update=set_update)
)
CLASS_METHODS: dict[str, dict[str, Builtin]] = {"dict": sited(fromkeys=keys_of)}
