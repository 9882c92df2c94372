"""Between which numbers a result lies, from where its operands lie: one rule for each operation that tells something.

Read next: `values.operations`, which names the rule of each operation; `scene.pruning`, which applies them to a tape.
"""

from __future__ import annotations

import math
from typing import Any

Interval = tuple[float, float]
UNBOUNDED: Interval = (-math.inf, math.inf)


def ordered(a: float, b: float) -> Interval:
    return (a, b) if a <= b else (b, a)


def of_fixed(value: Any) -> Interval:
    known = isinstance(value, int | float) and math.isfinite(value)
    return (float(value), float(value)) if known else UNBOUNDED


def of_sum(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def of_difference(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def of_product(a: Interval, b: Interval) -> Interval:
    """Bound a product where both factors are known, or one of them is fixed."""
    if math.isfinite(a[0] + a[1] + b[0] + b[1]):
        corners = [x * y for x in a for y in b]
        return min(corners), max(corners)
    if a[0] == a[1]:
        a, b = b, a
    return ordered(a[0] * b[0], a[1] * b[0]) if b[0] == b[1] and b[0] != 0 else UNBOUNDED


def of_negative(a: Interval) -> Interval:
    return -a[1], -a[0]


def of_minimum(a: Interval, b: Interval) -> Interval:
    return min(a[0], b[0]), min(a[1], b[1])


def of_maximum(a: Interval, b: Interval) -> Interval:
    return max(a[0], b[0]), max(a[1], b[1])


def of_clip(a: Interval, low: Interval, high: Interval) -> Interval:
    return min(max(a[0], low[0]), high[0]), min(max(a[1], low[1]), high[1])


def of_radians(a: Interval) -> Interval:
    return math.radians(a[0]), math.radians(a[1])


def of_selection(_index: Interval, *options: Interval) -> Interval:
    return min(low for low, _ in options), max(high for _, high in options)
