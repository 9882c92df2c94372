"""The names that a condition sees, as they were at its statement, for the times when it is evaluated again.

A requirement means the values that its names had where it is written, whatever is assigned to them later (spec
section 2). Read next: `language.requirements`, `core.per_sample`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from scenic_lite.core.environment import Environment
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState

Names = dict[str, Any]
COST = 4  # elements of memory that one kept name counts for


class Bindings:
    """All names in sight of `scope`, also for the functions of its module that a condition may call."""

    def __init__(self, scope: Scope) -> None:
        self.state = scope.state
        self.kept = [(scope, dict(scope)) for scope in scopes_of(scope)]
        self.ego, self.workspace = scope.state.ego, scope.state.workspace
        scope.mode.budget.spend(COST * sum(len(names) for _, names in self.kept))

    @contextmanager
    def restored(self, state: LoadState) -> Iterator[None]:
        """Inside, every name has the value it had when this was made."""
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
    """The dictionaries that names are looked up in, innermost first."""
    scopes: list[Names] = []
    at: Environment | None = scope
    while at is not None:
        scopes.append(at.locals)
        at = at.outer
    return scopes if scopes[-1] is scope.module_names else [*scopes, scope.module_names]


def put_back(kept: list[tuple[Names, Names]]) -> None:
    for scope, names in kept:
        scope.clear()
        scope.update(names)
