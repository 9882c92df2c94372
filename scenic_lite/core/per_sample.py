"""Row-by-row evaluation of requirements whose functions branch or loop on random values.

It is slow, since every sample requires another walk over the tree. Read next: `scene.constraints`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np

from scenic_lite.core.budget import Budget
from scenic_lite.core.checks import FallibleOperation
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState
from scenic_lite.core.types import (
    BehaviorCall,
    Bound,
    Definition,
    Environment,
    Function,
    Instance,
    Namespace,
    RandomChoice,
    ScenicClass,
    randoms_in,
)
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, columns_of

Names = dict[str, Any]
COST = 4  # elements of memory charged for one stored name


def per_sample_condition(scope: Scope, node: ast.expr) -> RandomExpr:
    """Return the truth of a condition as a node that evaluates the samples one by one."""
    columns = tuple(columns_of(*(random for value in mentioned(scope, node) for random in randoms_in(value))))
    return RandomExpr(PerSampleCondition(scope, node, columns), columns, "truth")


class PerSampleCondition(FallibleOperation):
    """A condition evaluated scene by scene: a tree and the draws on which it depends; columns [N] -> truth [N].

    An error in a scene, such as a division by zero, makes the scene invalid; `Program.sample` raises it.
    """

    def __init__(self, scope: Scope, node: ast.expr, columns: tuple[ThetaColumn, ...]) -> None:
        self.scope, self.node, self.columns = scope, node, columns
        self.bindings = Bindings(scope)
        self._faults: list[ScenicError | None] = []  # one for each scene of the last call
        self._rows: np.ndarray | None = None  # see `only`

    @contextmanager
    def only(self, rows: np.ndarray) -> Iterator[None]:
        """Evaluate only these rows [N] inside the context; the condition counts as violated in all other rows."""
        self._rows = rows
        try:
            yield
        finally:
            self._rows = None

    def __call__(self, *arrays: Any) -> Any:
        count = len(arrays[0]) if arrays else 0
        wanted = np.ones(count, dtype=bool) if self._rows is None else self._rows
        self._faults, holds = [None] * count, np.zeros(count, dtype=bool)
        with self.bindings.restored(self.scope.state):
            for row in np.flatnonzero(wanted).tolist():
                holds[row] = self._holds(row, [column[row] for column in arrays])
        return holds

    def _holds(self, row: int, draws: list[Value]) -> bool:
        """Return the truth of the condition for the draws of one row; False if the evaluation fails."""
        budget = self.scope.mode.budget.scene()
        mode = self.scope.mode.in_sample(dict(zip(self.columns, draws, strict=True)), budget)
        try:
            return bool(Scope.at(mode, self.scope).value(self.node))
        except ScenicError as error:
            if error.kind != "value":
                raise
            self._faults[row] = error
            return False
        finally:
            self._charge(budget)

    def _charge(self, spent: Budget) -> None:
        try:
            self.scope.mode.budget.charge(spent)
        except ScenicError as error:
            error.hint = "write it without branches and loops on random values, or ask for fewer scenes at once"
            raise self.scope.placed(error, self.node) from None

    def fails(self, result: Any, *inputs: Any) -> Any:
        return np.array([fault is not None for fault in self._faults], dtype=bool)

    def error(self, row: int, *inputs: Any) -> ScenicError:
        fault = self._faults[min(row, len(self._faults) - 1)]
        assert fault is not None, "a scene without a fault"
        return fault


# ------------------------------------------------------------ values of names at a statement
class Bindings:
    """The values of all names visible in `scope`, including the names of functions that a condition may call.

    A requirement uses the values that its names have at its statement; later assignments have no effect.
    """

    def __init__(self, scope: Scope) -> None:
        self.state = scope.state
        self.kept = [(scope, dict(scope)) for scope in scopes_of(scope)]
        self.ego, self.workspace = scope.state.ego, scope.state.workspace
        scope.mode.budget.spend(COST * sum(len(names) for _, names in self.kept))

    @contextmanager
    def restored(self, state: LoadState) -> Iterator[None]:
        """Set every name inside the context to its value at the creation of this object."""
        now = [(scope, dict(scope)) for scope, _ in self.kept]
        tracked = state.ego, state.workspace
        state.ego, state.workspace = self.ego, self.workspace
        put_back(self.kept)
        try:
            yield
        finally:
            state.ego, state.workspace = tracked
            put_back(now)


def scopes_of(scope: Scope) -> list[Names]:
    """Return the dictionaries of the name lookup, innermost first."""
    scopes = [at.locals for at in scope.outwards()]
    return scopes if scopes[-1] is scope.module_names else [*scopes, scope.module_names]


def put_back(kept: list[tuple[Names, Names]]) -> None:
    for scope, names in kept:
        scope.clear()
        scope.update(names)


# ------------------------------------------------------------ dependencies of a condition
def mentioned(scope: Scope, node: ast.AST) -> list[Value]:
    """Return the values that an expression may read: the ego, its names, and the names in its functions."""
    values = [scope.state.ego] if scope.state.ego is not None else []
    return values + reached([(scope, node)])


def reached(pending: list[tuple[Environment, ast.AST]]) -> list[Value]:
    """Return the values of all names in the trees, and in the functions and behaviors to which the trees refer."""
    values: list[Value] = []
    seen: set[int] = set()
    while pending:
        scope, tree = pending.pop()
        for path in names_in(tree):
            value = value_at(scope, path)
            if id(value) in seen:
                continue
            seen.add(id(value))
            values.append(value)
            if isinstance(value, Instance):
                values += members_of(value)
            for part in definitions_in(value):
                values += part.defaults()
                pending += [(part.scope, statement) for statement in part.trees()]
    return values


@lru_cache(maxsize=4096)  # the trees of a library are the same for every program
def names_in(tree: ast.AST) -> frozenset[tuple[str, ...]]:
    """Return the names in a tree, and the attribute paths that begin with a name: `lib`, `lib.far`."""
    return frozenset(path for node in ast.walk(tree) if (path := path_of(node)))


def path_of(node: ast.AST) -> tuple[str, ...]:
    """Return a name, or an attribute path that starts with one; () for any other node."""
    if isinstance(node, ast.Attribute):
        path = path_of(node.value)
        return (*path, node.attr) if path else ()
    return (node.id,) if isinstance(node, ast.Name) else ()


def value_at(scope: Environment, path: tuple[str, ...]) -> Value:
    """Return the value of a path through modules and classes; None for any other path, or without a value yet."""
    value = next((at.locals[path[0]] for at in scope.outwards() if path[0] in at.locals), None)
    value = scope.module_names.get(path[0]) if value is None else value
    for name in path[1:]:
        if isinstance(value, Namespace):
            value = value.names.get(name)
        else:
            value = value.member(name) if isinstance(value, ScenicClass) else None
    return value


def members_of(instance: Instance) -> list[Value]:
    """Return the values that an object reads from its class."""
    return [member for cls in instance.cls.lineage() for member in cls.members.values()]


def definitions_in(value: Value) -> Iterator[Definition]:
    """Yield the functions and behaviors in a value, including the methods of objects."""
    parts: Iterable[Value] = ()
    if isinstance(value, Definition):
        yield value
    elif isinstance(value, BehaviorCall):
        yield value.behavior
    elif isinstance(value, Instance):
        yield from (member for member in members_of(value) if isinstance(member, Function))
    elif isinstance(value, Bound):
        parts = (value.function,)
    elif isinstance(value, list | tuple):
        parts = value
    elif isinstance(value, RandomChoice):
        parts = value.options
    for part in parts:
        yield from definitions_in(part)
