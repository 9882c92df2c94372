"""Between which numbers the registers of a tape lie, as far as sums, products and choices tell.

Read next: `values.intervals`, the rules; `scene.pruning`, which asks.
"""

from __future__ import annotations

from scenic_lite.language.distributions import Integers
from scenic_lite.values.graph import Table, Tape, ThetaColumn
from scenic_lite.values.intervals import UNBOUNDED, Interval, of_fixed, ordered
from scenic_lite.values.operations import row_of


def bounds_of(tape: Tape, columns: list[ThetaColumn]) -> list[Interval]:
    """Return the interval of every register, unbounded where nothing is known."""
    computed = {out for _, _, out in tape.steps}
    bounds = [UNBOUNDED if slot in computed else of_fixed(value) for slot, value in enumerate(tape.registers)]
    for slot, column in enumerate(columns):
        bounds[slot] = ordered(column.offset, column.offset + column.span)
    for operation, inputs, out in tape.steps:
        row = row_of(operation)
        if row is not None and row.interval is not None:
            bounds[out] = row.interval(*(bounds[operand] for operand in inputs))
        elif isinstance(operation, Table | Integers):
            bounds[out] = of_choice(operation)
    return bounds


def of_choice(choice: Table | Integers) -> Interval:
    if isinstance(choice, Integers):
        return float(choice.first), float(choice.first + choice.count - 1)
    options = choice.options
    return (float(options.min()), float(options.max())) if options.dtype.kind in "if" else UNBOUNDED
