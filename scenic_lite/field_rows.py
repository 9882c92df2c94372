"""Functions of the program that branch on the point at which a vector field is asked: called row by row.

Read next: `rows`, the same for requirements.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from scenic_lite.bindings import Bindings
from scenic_lite.budget import Budget
from scenic_lite.errors import ScenicError
from scenic_lite.frame import Frame, in_row
from scenic_lite.geometry import Vector
from scenic_lite.graph import Column, Random, Value, columns_of
from scenic_lite.rows import STEPS, body_of, definitions_in, reached
from scenic_lite.scenes import randoms_in


def heading_by_row(
    frame: Frame, node: ast.AST, function: Value, point: Vector, heading: Callable[[Value], Value]
) -> Random:
    """What a function of the program says at a random point, called once for each sample."""
    pending = [(part.frame, each) for part in definitions_in(function) for each in body_of(part)]
    columns = tuple(columns_of(*(random for value in reached(pending) for random in randoms_in(value))))
    return Random(HeadingByRow(frame, node, function, columns, heading), (point.x, point.y, *columns))


class HeadingByRow:
    """The operation: x, y and the draws that the function depends on, each [N] -> headings [N]."""

    def __init__(
        self,
        frame: Frame,
        node: ast.AST,
        function: Value,
        columns: tuple[Column, ...],
        heading: Callable[[Value], Value],
    ) -> None:
        self.frame, self.node, self.function = frame, node, function
        self.columns, self.heading = columns, heading
        self.bindings = Bindings(frame)

    def __call__(self, x: Any, y: Any, *draws: Any) -> Any:
        rows = np.broadcast_arrays(*(np.atleast_1d(each) for each in (x, y, *draws)))
        with self.bindings.restored():
            return np.array([self._one(*row) for row in zip(*(each.tolist() for each in rows), strict=True)], float)

    def _one(self, x: float, y: float, *draws: Value) -> float:
        """One sample; nan where the function fails, so that the scene is rejected."""
        session = self.frame.session
        before = session.row, session.budget
        session.row = dict(zip(self.columns, draws, strict=True))
        session.budget = Budget(replace(session.budget.limits, steps=STEPS))
        try:
            with session.requiring():
                result = self.heading(self.frame.call(self.function, [Vector(x, y)], {}, self.node))
                return in_row(result, session.row)
        except ScenicError as error:
            if error.kind == "value":
                return float("nan")
            raise
        finally:
            session.row, session.budget = before
