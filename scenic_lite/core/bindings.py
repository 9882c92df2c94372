"""The names that a condition sees, as they were at its statement, for the times when it is evaluated again.

A requirement means the values that its names had where it is written, whatever is assigned to them later (spec
section 2). Read next: `language.requirements`, `core.per_sample`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from scenic_lite.core.scope import Scope

Names = dict[str, Any]
COST = 4  # elements of memory that one kept name counts for


class Bindings:
    """All names in sight of `scope`, also for the functions of its module that a condition may call."""

    def __init__(self, scope: Scope) -> None:
        self.session = scope.session
        self.kept = [(scope, dict(scope)) for scope in scopes_of(scope)]
        self.ego, self.workspace = scope.session.ego, scope.session.workspace
        scope.session.budget.spend(COST * sum(len(names) for _, names in self.kept))

    @contextmanager
    def restored(self) -> Iterator[None]:
        """Inside, every name has the value it had when this was made."""
        session = self.session
        now = [(scope, dict(scope)) for scope, _ in self.kept]
        tracked = session.ego, session.workspace
        session.ego, session.workspace = self.ego, self.workspace
        put_back(self.kept)
        try:
            yield
        finally:
            session.ego, session.workspace = tracked
            put_back(now)


def scopes_of(scope: Scope) -> list[Names]:
    """The dictionaries that names are looked up in, innermost first."""
    scopes: list[Names] = []
    at: Scope | None = scope
    while at is not None:
        scopes.append(at.locals)
        at = at.outer
    return scopes if scopes[-1] is scope.module_names else [*scopes, scope.module_names]


def put_back(kept: list[tuple[Names, Names]]) -> None:
    for scope, names in kept:
        scope.clear()
        scope.update(names)
