"""Comprehensions: over a fixed list with fixed tests a fixed list, otherwise one whose length the match decides.

Read next: `dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import RandomChoice
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.conditions import jump_on, truth
from scenic_lite.dynamics.compiler.emit import jump
from scenic_lite.dynamics.compiler.lists import (
    LiveRange,
    among_objects,
    each_number,
    each_object,
    each_of,
    elements,
    one_list,
    put_at_end,
)
from scenic_lite.dynamics.compiler.registers import Slot, settled
from scenic_lite.dynamics.compiler.types import Items, RegisterList
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.assignments import unpack
from scenic_lite.values.graph import Value

Keep = Callable[[Value], None]


def comprehension(c: Compilation, scope: Scope, node: ast.ListComp | ast.GeneratorExp | ast.SetComp) -> Value:
    found = Gathered(c, (*c.path, "gathered", id(node)))
    rounds(c, scope, node.generators, lambda inner: found.add(inner.value(node.elt)), found)
    if isinstance(node, ast.SetComp):
        if found.live:
            raise ScenicError("unsupported", "a set whose elements the match decides", hint="write a list: [ ... ]")
        return set(found.fixed)
    return found.value


def rounds(
    c: Compilation, scope: Scope, generators: list[ast.comprehension], each: Callable[[Scope], None], found: Gathered
) -> None:
    """Compile the rounds of a comprehension."""
    first, *rest = generators
    items = scope.value(first.iter)
    if isinstance(items, RandomChoice):
        items = one_list(c, items, first.iter)

    def one(item: Value, after: Label) -> None:
        inner = scope.inner({})
        inner.transparent = True
        unpack(inner, first.target, item)
        for test in first.ifs:
            jump_on(c, inner, test, after, when=False)
        if c.code.reachable and rest:
            rounds(c, inner, rest, each, found)
        elif c.code.reachable:
            each(inner)

    go_through(c, scope, items, first.iter, one, found)


def go_through(
    c: Compilation, scope: Scope, items: Value, node: ast.AST, one: Callable[[Value, Label], None], found: Gathered
) -> None:
    if isinstance(items, RegisterList | LiveRange):
        found.become_live()
        for item, after in each_number(c, items) if isinstance(items, LiveRange) else each_of(c, items):
            one(item, after)
        return
    items = elements(c, scope, items, node)
    for i, item in enumerate(items):
        if found.live and among_objects(items[i:], 0) is not None:
            for each, after in each_object(c, items[i:], c.code.variables.take()):
                one(each, after)
            return
        after = Label()
        with c.round(node, i), c.code.captured() as rows:
            reachable = c.code.reachable
            one(item, after)
        if after.used and not found.live and c.code.reachable:
            # What was thought fixed is not: do this round again in registers.
            found.undo(i)
            found.become_live()
            if among_objects(items[i:], 0) is not None:
                c.code.reachable = reachable
                go_through(c, scope, items[i:], node, one, found)
                return
            after = Label()
            with c.round(node, i), c.code.captured() as rows:
                one(item, after)
        c.code.rows.extend(rows)
        c.code.reachable = reachable
        if after.used:
            c.code.put(after)
        found.done(i)


class Gathered:
    """The elements found so far: a fixed list until the match has a say in what belongs to it."""

    def __init__(self, c: Compilation, key: tuple) -> None:
        self.c, self.key = c, key
        self.fixed: list[Value] = []
        self.sure = 0
        self.live = False
        self.slot: Slot | None = None

    def add(self, value: Value) -> None:
        value = settled(self.c.code, value)
        if not self.live:
            self.fixed.append(value)
            return
        items = self.room_for(value)
        put_at_end(self.c, items, value)

    def room_for(self, value: Value) -> RegisterList:
        assert self.slot is not None
        shape = self.slot.shape
        assert isinstance(shape, Items)
        self.slot.widen(as_items(value))
        found = self.slot.value
        assert isinstance(found, RegisterList)
        return found

    def done(self, number: int) -> None:
        self.sure = len(self.fixed)

    def undo(self, number: int) -> None:
        del self.fixed[self.sure :]

    def become_live(self) -> None:
        if self.live:
            return
        self.live = True
        self.slot = Slot(self.c.code, self.c.shapes, self.key)
        self.slot.widen(RegisterList(None, (0,)))
        for each in self.fixed:
            self.slot.widen(as_items(each))
        self.slot.store(self.fixed)

    @property
    def value(self) -> Value:
        return self.fixed if not self.live else self.slot.value  # type: ignore[union-attr]


def as_items(value: Value) -> RegisterList:
    """A list whose length varies and whose elements are like this value, as a shape."""
    from scenic_lite.dynamics.compiler.types import shape_of

    return RegisterList(shape_of(value), ())


def gathered(
    c: Compilation,
    scope: Scope,
    items: Value,
    node: ast.AST,
    test: Callable[[Value], Value],
    make: Callable[[Value], Value],
) -> Value:
    """The elements for which a test holds, each made into something."""
    found = Gathered(c, (*c.path, "gathered", id(node)))

    def one(item: Value, after: Label) -> None:
        jump(c.code, truth(test(item)), after, when=False)
        if c.code.reachable:
            found.add(make(item))

    go_through(c, scope, items, node, one, found)
    return found.value


def dictionary_comprehension(c: Compilation, scope: Scope, node: ast.DictComp) -> dict:
    keys, values = Gathered(c, (*c.path, "keys", id(node))), []

    def each(inner: Scope) -> None:
        keys.add(inner.value(node.key))
        values.append(settled(c.code, inner.value(node.value)))

    rounds(c, scope, node.generators, each, keys)
    if keys.live:
        raise ScenicError("unsupported", "a dictionary whose keys the match decides")
    return dict(zip(keys.fixed, values, strict=True))
