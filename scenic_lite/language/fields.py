"""Vector fields from regions or from functions of the program, and paths along a field.

If a function branches on the point, all of its branches are evaluated. Read next: `language.scenic_operators`, for the
other uses of fields.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import BranchPath
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values.geometry import Vector, is_scalar, vector_by
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, apply, columns_of, is_number
from scenic_lite.values.operations import WHERE
from scenic_lite.values.regions import Region, VectorField, patched

MOST_STEPS = 1000
UNPLACED = SourceSpan("", 1, 0, 1, 1)  # the place of placeholders for a moving point
MOST_OPERATIONS = 100_000  # maximum number in the heading of one field


def field_of(scope: Scope, node: ast.AST, name: str, function: Value, heading: Callable[[Value], Value]) -> VectorField:
    """Return the field of a program function, which may branch on the point.

    `heading` checks the result of the function.
    """

    def heading_at(point: Vector) -> Value:
        try:
            return heading(scope.call(function, [point], {}, node))
        except ScenicError as error:
            if point.fixed or error.kind != "random-control-flow":
                raise
        return along_all_ways(scope, lambda along: heading(along.call(function, [point], {}, node)))

    return VectorField(name, heading_at)


def along_all_ways(scope: Scope, compute: Callable[[Scope], Value], decisions: Sequence[bool] = ()) -> Value:
    """Return one value for all branches that begin with some decisions, selected by the branch conditions."""
    path = BranchPath([*decisions])
    value = compute(scope.along(path))
    for at in reversed(range(len(decisions), len(path.conditions))):
        other = along_all_ways(scope, compute, [*path.decisions[:at], False])
        value = apply(WHERE, path.conditions[at], value, other)
    return value


def cells_field(
    name: str, cells: Sequence[tuple[Region, Value]], otherwise: Callable[[Vector], Value], default: Value
) -> VectorField:
    """Return the field with the heading of the first cell around the point, or of `otherwise` if the cell has none.

    The heading outside all cells is `default`. If `default` is None, scenes that need a heading there are rejected.
    """
    pieces: list[Any] = [(region, otherwise if h is None else (lambda point, h=h: h)) for region, h in cells]
    field = patched(name, pieces, default)

    def heading_at(point: Vector) -> Value:
        result = field.heading_at(point)
        if is_number(result) and math.isnan(result):
            raise ScenicError("value", f"the vector field {name} has no heading at {point!r}")
        return result

    return VectorField(name, heading_at)


# ------------------------------------------------------------ following
def follow(field: Value, start: Vector, distance: Value) -> tuple[Vector, Value]:
    """Follow a field in equal Euler steps; return the end point and the field's heading at the end point."""
    if not isinstance(field, VectorField):
        raise ScenicError("type", "only a vector field can be followed")
    if not is_scalar(distance):
        raise ScenicError("type", "the distance to follow a field for must be a number")
    end = along(field, start, distance)
    return end, field.heading_at(end)


def along(field: VectorField, start: Vector, distance: Value) -> Vector:
    """Return the end point of equal Euler steps along a field."""
    if not (start.fixed and is_number(distance)):
        return followed(field, start, distance)
    steps = int(steps_of(field, distance))
    point = start
    for _ in range(steps):
        heading = field.heading_at(point)
        if isinstance(heading, RandomExpr):
            return followed(field, start, distance)
        point = point + Vector(0.0, distance / steps).rotated(heading)
    return point


def followed(field: VectorField, start: Vector, distance: Value) -> Vector:
    """Return the end point as one node, for any number of steps."""
    walk = Walk(field)
    return vector_by(walk, start.x, start.y, distance, *walk.others)


def steps_of(field: VectorField, distance: Any) -> Any:
    """Return the number of steps for a distance; the field gives the minimum number and the maximum length of steps."""
    if field.longest_step is None:
        return np.full(np.shape(distance), field.least_steps)
    needed = np.ceil(np.nan_to_num(np.asarray(distance, dtype=float) / field.longest_step, nan=0.0))
    return np.clip(needed, field.least_steps, MOST_STEPS).astype(int)


class Walk:
    """The operation `follow`: x, y, distance and the field's other inputs, each [N] -> x [N], y [N] of the end."""

    def __init__(self, field: VectorField) -> None:
        self.field = field
        self.here = [ThetaColumn("range", UNPLACED), ThetaColumn("range", UNPLACED)]
        self.heading = field.heading_at(Vector(*self.here))
        others = [column for column in columns_of(self.heading) if not any(column is own for own in self.here)]
        self.others = tuple(others)
        self.known = [*self.here, *others]

    @cached_property
    def tape(self) -> Tape | None:
        """Return the tape of the heading; it is created after loading, since `pruning` changes nodes."""
        return Tape([self.heading], self.known, MOST_OPERATIONS) if isinstance(self.heading, RandomExpr) else None

    def __call__(self, x: Any, y: Any, distance: Any, *others: Any) -> tuple[Any, Any]:
        rows = [values.astype(float) for values in np.broadcast_arrays(x, y, distance, *others)]
        x, y, distance = rows[:3]
        steps = steps_of(self.field, distance)
        for step in range(steps.max(initial=0)):
            heading = self._heading(x, y, rows[3:])
            length = np.where(step < steps, distance / steps, 0.0)
            x, y = x - length * np.sin(heading), y + length * np.cos(heading)
        return x, y

    def _heading(self, x: Any, y: Any, others: list[Any]) -> Any:
        if self.tape is None:
            return self.heading
        return self.tape.run([x, y, *others])[self.tape.slot(self.heading)]
