"""One comparison: a number of our simulator, the same number of Google Research Football, and a tolerance.

Difference and tolerance have the same unit: a share, a distance, percentage points, or a factor minus one. Read next:
`stage`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A measurement of our simulator beside GRF's; `difference` and `tolerance` have the same unit."""

    family: str
    name: str
    ours: float
    grf: float
    unit: str
    difference: float
    tolerance: float

    @property
    def ok(self) -> bool:
        """Whether the difference is within the tolerance; False if it could not be measured."""
        return bool(self.difference <= self.tolerance)


def by_share(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the difference as a share of GRF's number, 0.05 for 5%."""
    return Row(family, name, ours, grf, unit, abs(ours - grf) / abs(grf) if grf else math.inf, tolerance)


def by_distance(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the difference itself, in the unit of the numbers (for rates: percentage points)."""
    return Row(family, name, ours, grf, unit, abs(ours - grf), tolerance)


def by_factor(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the factor between two positive numbers, minus one: 0.5 for a factor of 1.5 either way."""
    low, high = sorted((ours, grf))
    factor = high / low if low > 0.0 else (1.0 if high == low else math.inf)
    return Row(family, name, ours, grf, unit, factor - 1.0, tolerance)
