"""What is known of the registers of a tape in each of N scenes, on the way from values back to draws.

Read next: `inverse.inverses`, one rule per operation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from scenic_lite.scene.bounds import Interval
from scenic_lite.values.graph import Tape


class Knowledge:
    """What is known of the registers of a tape in N scenes: `values[slot]` [N], where `known[slot]` [N] is true."""

    def __init__(self, tape: Tape, count: int, bounds: list[Interval]) -> None:
        self.tape, self.count, self.bounds = tape, count, bounds
        self.values: list[Any] = list(tape.registers)
        computed = set(range(tape.dim)) | {out for _, _, out in tape.steps}
        self.known = [np.full(count, slot not in computed) for slot in range(len(tape.registers))]
        self.learnt = 0  # how often anything was

    def at(self, slot: int, rows: Any) -> Any:
        """The value of a register in some rows."""
        value = self.values[slot]
        if isinstance(value, tuple):  # the two coordinates of a point
            return tuple(part[rows] for part in value)
        return value[rows] if isinstance(value, np.ndarray) and value.shape[:1] == (self.count,) else value

    def learn(self, slot: int, rows: Any, values: Any) -> None:
        """Take note of values [M] in the M rows where `rows` [N] is true."""
        if isinstance(values, tuple):
            if rows.all():
                self._note(slot, rows, values)
            return
        values = np.broadcast_to(np.asarray(values), (int(rows.sum()),))
        if rows.all():
            self._note(slot, rows, values)
            return
        held = self.values[slot]
        if held is None or held.dtype != np.result_type(held, values):
            fresh = np.zeros(self.count, np.result_type(*([values] if held is None else [held, values])))
            if held is not None:
                fresh[:] = held
            held = self.values[slot] = fresh
        held = held if held.flags.writeable else held.copy()
        held[rows] = values
        self._note(slot, rows, held)

    def _note(self, slot: int, rows: Any, values: Any) -> None:
        self.values[slot] = values
        self.known[slot] = self.known[slot] | rows
        self.learnt += 1

    def solve(self, target: int, sources: Iterable[int], compute: Callable[..., Any]) -> None:
        """Compute one register from others, where they are known and it is not."""
        rows = ~self.known[target]
        for source in sources:
            rows = rows & self.known[source]
        if not rows.any():
            return
        found = np.broadcast_to(np.asarray(compute(*(self.at(source, rows) for source in sources))), (rows.sum(),))
        sound = np.isfinite(found) if found.dtype.kind == "f" else np.ones(len(found), dtype=bool)
        if sound.any():
            rows[rows] = sound
            self.learn(target, rows, found[sound])
