"""Significance of the differences of a table: marks after Holm's correction, and the smallest detectable difference.

All differences of one table are one family. Read next: `ued.statistics`, which computes p-values.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ued.statistics import Difference

LEVEL = 0.05
HOW = "power below 80% at level 5%"  # see `ued.statistics.detectable`
SURVIVES, SINGLE = "*", "†"
LEGEND = (
    f"marks: {SURVIVES} survives Holm's correction at 5% over the {{tests}} of this table; {SINGLE} does not, though "
    "its interval excludes 0"
)


def difference_of_means(mine: Sequence[Any] | np.ndarray, base: Sequence[Any] | np.ndarray) -> Difference:
    """Estimate the difference of two methods' means over runs `[R, ...]`, resampling whole runs of both."""
    from ued.statistics import bootstrap

    rng = np.random.default_rng(0)
    one, other = (bootstrap(np.array(values, float), rng) for values in (mine, base))
    return (one - other).difference()


def points(found: Any, mark: str) -> str:
    """Return a difference of rates in percentage points, with its interval, if known, and its mark."""
    return difference(found, mark, 100.0, 0)


def difference(found: Any, mark: str, factor: float = 1.0, digits: int = 2) -> str:
    """Return a difference times `factor` with its interval, if known, and its mark.

    If the interval excludes 0, its ends have enough digits not to round to 0.
    """
    ends = [factor * value for value in (found.low, found.high)]
    needed = [digits, digits]
    for k in range(2) if ends[0] > 0 or ends[1] < 0 else ():
        while needed[k] < 6 and not round(ends[k], needed[k]):
            needed[k] += 1
    middle = f"{factor * found.estimate:+z.{digits}f}"
    low, high = (f"{end:+z.{number}f}" for end, number in zip(ends, needed, strict=True))
    return f"{middle} [{low}, {high}] {mark}".rstrip() if found.known else middle


def mark(difference: Any, adjusted: float) -> str:
    """Return the mark of a difference with `low` and `high`, given its p-value after Holm's correction."""
    if not (difference.low > 0 or difference.high < 0):
        return ""
    return SURVIVES if adjusted <= LEVEL else SINGLE


def marks(differences: Sequence[Difference]) -> list[str]:
    """Return the marks of all differences of a table."""
    from ued.statistics import holm

    adjusted = holm([difference.p for difference in differences])
    return [mark(difference, p) for difference, p in zip(differences, adjusted, strict=True)]


def legend(p_values: Sequence[float]) -> str:
    """Return the legend of the marks for these p-values, nan if not available; "" without p-values."""
    from ued.statistics import SAMPLES

    tests = int(np.isfinite(np.asarray(p_values, float)).sum())
    if not tests:
        return ""
    text = LEGEND.format(tests="one difference" if tests == 1 else f"{tests} differences")
    return f"{text}; so many that none can survive" if tests * 2 / (SAMPLES + 1) > LEVEL else text


def sentences(*lines: str) -> str:
    """Join the non-empty lines as sentences."""
    return " ".join(f"{line[0].upper()}{line[1:]}." for line in lines if line)


def visible(sizes: Sequence[float], counts: Sequence[int], unit: str, by: str = "scene") -> str:
    """Return a line about the smallest detectable differences; "" if no size is available.

    Args:
        sizes: the smallest detectable difference in each column of a table, see `ued.statistics.detectable`.
        counts: runs of each method.
        unit: format of a size, such as "{:.0f} points".
        by: the kind of columns, such as "scene".
    """
    known = [size for size in sizes if size == size]
    if not known:
        return ""
    low, high = (unit.format(size) for size in (min(known), max(known)))
    ends = low if low == high else f"{low.split()[0]} to {high}, depending on the {by},"
    return f"{spread(counts)} runs each: differences under {ends} cannot be detected reliably ({HOW})"


def spread(counts: Sequence[int]) -> str:
    """Return the range of counts in words: "5", or "4 to 5"."""
    return f"{min(counts)}" if len(set(counts)) == 1 else f"{min(counts)} to {max(counts)}"
