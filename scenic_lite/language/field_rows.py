"""Functions of the program that branch on the point at which a vector field is asked: called row by row.

Read next: `core.per_sample`, the same for requirements.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

import numpy as np

from scenic_lite.core.per_sample import PerSampleOperation, body_of, definitions_in, reached
from scenic_lite.core.scope import Scope, in_row
from scenic_lite.core.types import randoms_in
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, columns_of


def heading_by_row(
    scope: Scope, node: ast.AST, function: Value, point: Vector, heading: Callable[[Value], Value]
) -> RandomExpr:
    """What a function of the program says at a random point, called once for each sample."""
    pending = [(part.scope, each) for part in definitions_in(function) for each in body_of(part)]
    columns = tuple(columns_of(*(random for value in reached(pending) for random in randoms_in(value))))
    result = RandomExpr(HeadingByRow(scope, node, function, columns, heading), (point.x, point.y, *columns))
    scope.watch(result)
    return result


class HeadingByRow(PerSampleOperation):
    """The operation: x, y and the draws that the function depends on, each [N] -> headings [N]; nan where it fails."""

    def __init__(
        self,
        scope: Scope,
        node: ast.AST,
        function: Value,
        columns: tuple[ThetaColumn, ...],
        heading: Callable[[Value], Value],
    ) -> None:
        super().__init__(scope, node, columns)
        self.function, self.heading = function, heading

    def __call__(self, x: Any, y: Any, *draws: Any) -> Any:
        rows = np.broadcast_arrays(*(np.atleast_1d(each) for each in (x, y, *draws)))
        with self.bindings.restored(self.scope.state):
            headings = [self._one(*row) for row in self.scenes(each.tolist() for each in rows)]
        return np.array(headings, float)

    def _one(self, x: float, y: float, *draws: Value) -> float:
        return self.per_sample(draws, lambda scope: self._asked(scope, x, y), float("nan"))

    def _asked(self, scope: Scope, x: float, y: float) -> Value:
        result = self.heading(scope.call(self.function, [Vector(x, y)], {}, self.node))
        return in_row(result, scope.mode.row or {})
