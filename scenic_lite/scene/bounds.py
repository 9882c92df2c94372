"""Between which numbers the registers of a tape lie, as far as sums, products and choices tell.

Read next: `scene.pruning`, which asks how wide an object is at least.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenic_lite.language.distributions import Integers
from scenic_lite.values.graph import Table, Tape, ThetaColumn, pick

Interval = tuple[float, float]
ENDLESS: Interval = (-math.inf, math.inf)


def bounds_of(tape: Tape, columns: list[ThetaColumn]) -> list[Interval]:
    """The interval of every register; endless where nothing is known."""
    computed = {out for _, _, out in tape.steps}
    bounds = [ENDLESS if slot in computed else fixed(value) for slot, value in enumerate(tape.registers)]
    for slot, column in enumerate(columns):
        bounds[slot] = ordered(column.offset, column.offset + column.span)
    for operation, inputs, out in tape.steps:
        rule = RULES.get(operation)
        if rule is not None:
            bounds[out] = rule(*(bounds[each] for each in inputs))
        elif isinstance(operation, Table | Integers):
            bounds[out] = of_choice(operation)
    return bounds


def of_choice(choice: Table | Integers) -> Interval:
    if isinstance(choice, Integers):
        return float(choice.first), float(choice.first + choice.count - 1)
    options = choice.options
    return (float(options.min()), float(options.max())) if options.dtype.kind in "if" else ENDLESS


def of_one(_index: Interval, *options: Interval) -> Interval:
    return min(low for low, _ in options), max(high for _, high in options)


def clipped(a: Interval, low: Interval, high: Interval) -> Interval:
    return min(max(a[0], low[0]), high[1]), max(min(a[1], high[1]), low[0])


def fixed(value: Any) -> Interval:
    known = isinstance(value, int | float) and math.isfinite(value)
    return (float(value), float(value)) if known else ENDLESS


def ordered(a: float, b: float) -> Interval:
    return (a, b) if a <= b else (b, a)


def of_sum(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def of_difference(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def of_product(a: Interval, b: Interval) -> Interval:
    """Where both are known, or one of them is fixed."""
    if math.isfinite(a[0] + a[1] + b[0] + b[1]):
        corners = [x * y for x in a for y in b]
        return min(corners), max(corners)
    if a[0] == a[1]:
        a, b = b, a
    return ordered(a[0] * b[0], a[1] * b[0]) if b[0] == b[1] and b[0] != 0 else ENDLESS


def of_negative(a: Interval) -> Interval:
    return -a[1], -a[0]


RULES: dict[Any, Any] = {
    np.add: of_sum,
    np.subtract: of_difference,
    np.multiply: of_product,
    np.negative: of_negative,
    np.clip: clipped,
    np.minimum: lambda a, b: (min(a[0], b[0]), min(a[1], b[1])),
    np.maximum: lambda a, b: (max(a[0], b[0]), max(a[1], b[1])),
    pick: of_one,
    np.radians: lambda a: (math.radians(a[0]), math.radians(a[1])),
}
