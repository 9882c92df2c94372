"""Following a vector field.

Read next: `operators`, which has the other uses of fields.
"""

from __future__ import annotations

import math

from scenic_lite.errors import ScenicError
from scenic_lite.geometry import Vector, is_scalar
from scenic_lite.graph import Value, is_number
from scenic_lite.regions import VectorField

LEAST_STEPS, LONGEST_STEP, MOST_STEPS = 4, 5.0, 1000


def follow(field: Value, start: Vector, distance: Value) -> tuple[Vector, Value]:
    """Where one arrives, and the field's heading there: equal Euler steps (spec section 5, `following`)."""
    if not isinstance(field, VectorField):
        raise ScenicError("type", "only a vector field can be followed")
    if not is_scalar(distance):
        raise ScenicError("type", "the distance to follow a field for must be a number")
    steps = LEAST_STEPS
    if is_number(distance):
        steps = min(MOST_STEPS, max(LEAST_STEPS, math.ceil(distance / LONGEST_STEP)))
    point = start
    for _ in range(steps):
        point = point + Vector(0.0, distance / steps).rotated(field.heading_at(point))
    return point, field.heading_at(point)
