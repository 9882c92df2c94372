"""Conditions that arrays cannot decide: requirements whose functions branch or loop on random values, row by row.

Slow (each sample walks the tree again), and only for those. Read next: `rules`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from scenic_lite.bindings import Bindings
from scenic_lite.budget import Budget
from scenic_lite.errors import ScenicError
from scenic_lite.frame import Frame
from scenic_lite.graph import Column, Random, Value, columns_of
from scenic_lite.scenes import randoms_in
from scenic_lite.values import Behavior, BehaviorCall, Bound, Choice, Function, Instance

STEPS = 20_000  # of one condition in one scene, of which there are thousands


def row_by_row(frame: Frame, node: ast.expr) -> Random:
    """The truth of a condition for each sample, evaluated one after the other."""
    columns = tuple(columns_of(*(random for value in mentioned(frame, node) for random in randoms_in(value))))
    return Random(RowByRow(frame, node, columns), columns, "truth")


class RowByRow:
    """The operation: columns [N] -> truth [N]."""

    def __init__(self, frame: Frame, node: ast.expr, columns: tuple[Column, ...]) -> None:
        self.frame, self.node, self.columns = frame, node, columns
        self.bindings = Bindings(frame)

    def __call__(self, *arrays: Any) -> Any:
        with self.bindings.restored():
            return np.array([self._one(values) for values in zip(*arrays, strict=True)], dtype=bool)

    def _one(self, values: tuple) -> bool:
        """One sample; a condition that cannot be computed there does not hold."""
        session = self.frame.session
        before = session.row, session.budget
        session.row = dict(zip(self.columns, values, strict=True))
        session.budget = Budget(replace(session.budget.limits, steps=STEPS))
        try:
            with session.requiring():
                return bool(self.frame.value(self.node))
        except ScenicError as error:
            if error.kind == "value":
                return False
            raise
        finally:
            session.row, session.budget = before


def mentioned(frame: Frame, node: ast.AST) -> list[Value]:
    """The values that an expression may read: of its names, of what its functions name, and of the ego."""
    found = [frame.session.ego] if frame.session.ego is not None else []
    return found + reached([(frame, node)])


def reached(pending: list[tuple[Frame, ast.AST]]) -> list[Value]:
    """The values of all names in some trees, and in the functions and behaviors that they name."""
    found: list[Value] = []
    seen: set[int] = set()
    while pending:
        scope, tree = pending.pop()
        for name in names_in(tree):
            value = visible(scope, name)
            if id(value) not in seen:
                seen.add(id(value))
                found.append(value)
                for part in definitions_in(value):
                    found += [*part.defaults, *part.keyword_defaults.values()]
                    pending += [(part.frame, each) for each in body_of(part)]
    return found


@lru_cache(maxsize=4096)  # the trees of a library are the same for every program
def names_in(tree: ast.AST) -> frozenset[str]:
    return frozenset(each.id for each in ast.walk(tree) if isinstance(each, ast.Name))


def visible(frame: Frame, name: str) -> Value:
    """The value of a name, or None: it may be a local of a function not yet called."""
    at: Frame | None = frame
    while at is not None:
        if name in at.locals:
            return at.locals[name]
        at = at.outer
    return frame.module_names.get(name)


def definitions_in(value: Value) -> Iterator[Function | Behavior]:
    """The functions and behaviors that a value is or carries: methods of objects are among them."""
    if isinstance(value, Function | Behavior):
        yield value
    elif isinstance(value, Bound):
        yield from definitions_in(value.function)
    elif isinstance(value, BehaviorCall):
        yield value.behavior
    elif isinstance(value, Instance):
        for cls in value.cls.lineage():
            yield from (member for member in cls.members.values() if isinstance(member, Function))
    elif isinstance(value, list | tuple):
        for each in value:
            yield from definitions_in(each)
    elif isinstance(value, Choice):
        for each in value.options:
            yield from definitions_in(each)


def body_of(definition: Function | Behavior) -> list[ast.AST]:
    if isinstance(definition, Behavior):
        return [definition.node]
    return list(definition.body) if isinstance(definition.body, list) else [definition.body]
