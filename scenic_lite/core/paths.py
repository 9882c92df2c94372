"""Functions of the program that branch on random values, walked once along each path through them.

Each walk decides every branch beforehand; the results are joined by the branches' conditions, so that what the
function computes stays a node over arrays. Read next: `language.fields`, for functions with too many paths.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import Value, apply
from scenic_lite.values.operations import WHERE

MOST_BRANCHES, MOST_WALKS = 24, 64


class Path:
    """One path: the decisions of its branches in order, then always True; `conditions` are what was asked."""

    def __init__(self, decisions: list[bool]) -> None:
        self.decisions = decisions
        self.conditions: list[Value] = []

    def branch(self, condition: Value) -> bool:
        """Return which way to go at the next branch."""
        at = len(self.conditions)
        if at >= MOST_BRANCHES:
            raise too_many()
        self.conditions.append(condition)
        if at == len(self.decisions):
            self.decisions.append(True)
        return self.decisions[at]


class PathEnumerator:
    """All paths through a computation that gives a number; nan where one of them fails."""

    def __init__(self, compute: Callable[[Path], Value]) -> None:
        self.compute = compute
        self.count = 0
        self.fault: ScenicError | None = None
        self.arrived = False  # along some path

    def result(self) -> Value:
        """Raises ScenicError if every path fails, or there are too many of them."""
        value = self._from([])
        if not self.arrived and self.fault is not None:
            raise self.fault
        return value

    def _from(self, decisions: list[bool]) -> Value:
        """Return the value of all paths that begin with some decisions."""
        self.count += 1
        if self.count > MOST_WALKS:
            raise too_many()
        path = Path(list(decisions))
        value = self._walk(path)
        for at in reversed(range(len(decisions), len(path.conditions))):
            other = self._from([*path.decisions[:at], False])
            value = apply(WHERE, path.conditions[at], value, other)
        return value

    def _walk(self, path: Path) -> Value:
        try:
            value = self.compute(path)
        except ScenicError as error:
            if error.kind not in ("value", "type"):
                raise
            self.fault = error
            return math.nan
        self.arrived = True
        return value


def too_many() -> ScenicError:
    return ScenicError("random-control-flow", "the function has too many ways through its branches")
