"""One comparison: a number of ours, the same number of Google Research Football, and how far apart they may be.

A difference is in the terms of its tolerance: a share, a distance, points of a hundred, or a factor less one. Read
next: `stage`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A measurement of ours beside the original's; `difference` and `tolerance` are in the same terms."""

    family: str
    name: str
    ours: float
    grf: float
    unit: str
    difference: float
    tolerance: float

    @property
    def ok(self) -> bool:
        """Whether the difference is within the tolerance; what could not be measured is not."""
        return bool(self.difference <= self.tolerance)


def by_share(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the difference as a share of the original's number, 0.05 for 5%."""
    return Row(family, name, ours, grf, unit, abs(ours - grf) / abs(grf) if grf else math.inf, tolerance)


def by_distance(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the difference itself, in the numbers' own unit (for rates: points of a hundred)."""
    return Row(family, name, ours, grf, unit, abs(ours - grf), tolerance)


def by_factor(family: str, name: str, ours: float, grf: float, unit: str, tolerance: float) -> Row:
    """Compare by the factor between two positive numbers, less one: 0.5 for a factor of 1.5 either way."""
    low, high = sorted((ours, grf))
    factor = high / low if low > 0.0 else (1.0 if high == low else math.inf)
    return Row(family, name, ours, grf, unit, factor - 1.0, tolerance)
