"""How fast something runs: the best of several stretches, for others may use the machine meanwhile.

Read next: `commands.benchmark`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

STRETCHES = 3  # of each measurement; the best counts


class Measurement(NamedTuple):
    """One line of a table: steps of a single environment per second."""

    what: str
    steps_per_second: float
    note: str = ""


def rate(
    run: Callable[[int], None], seconds: float, warm_up: int = 4, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return calls per second of `run(count)`: the best of several stretches that take `seconds` together."""
    began = clock()
    run(warm_up)
    count = max(1, int(warm_up * seconds / STRETCHES / max(clock() - began, 1e-6)))
    best = 0.0
    for _ in range(STRETCHES):
        began = clock()
        run(count)
        best = max(best, count / max(clock() - began, 1e-9))
    return best
