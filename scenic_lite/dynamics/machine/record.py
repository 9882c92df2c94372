"""What `record` statements have put into the registers of many matches in one step.

Read next: `dynamics.machine.compiled`, for one match.
"""

from __future__ import annotations

import numpy as np

from scenic_lite.core.types import Instance
from scenic_lite.dynamics.machine.compiled import Compiled, Record
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.values.geometry import Vector


def recorded(compiled: Compiled, registers: np.ndarray) -> dict[str, np.ndarray]:
    """Return the values by name, after a step that left registers [N, R].

    Numbers and truth values are float64 [N], vectors [N, 2], NaN where a match has recorded nothing in this step; all
    else is an array of Python values, None where there is none. `record initial` counts to the first step, `record
    final` to the last.
    """
    by_name: dict[str, np.ndarray] = {}
    for record in compiled.records:
        time, at = registers[:, compiled.code.clock], registers[:, record.taken]
        taken = at == time if record.when == "each" else (at >= 0) & ((record.when == "final") | (time <= 1))
        values = values_of(compiled, record, registers, taken)
        before = by_name.get(record.name)
        if before is None:
            by_name[record.name] = values
        elif before.shape == values.shape and before.dtype == values.dtype:
            before[taken] = values[taken]  # scenarios with records of one name: the last that runs counts
    return by_name


def values_of(compiled: Compiled, record: Record, registers: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Return one record of all matches."""
    value = record.value
    if is_number(value):
        return np.where(taken, numbers(value, registers), np.nan)
    if isinstance(value, Vector) and is_number(value.x) and is_number(value.y):
        both = np.stack([numbers(value.x, registers), numbers(value.y, registers)], axis=1)
        return np.where(taken[:, None], both, np.nan)
    values = np.full(len(registers), None, dtype=object)
    for match in np.flatnonzero(taken):
        one = compiled.plain(value, registers[match], {})
        values[match] = one.title() if isinstance(one, Instance) else one
    return values


def is_number(value: object) -> bool:
    return isinstance(value, bool | int | float) or (isinstance(value, RegisterValue) and value.kind != "text")


def numbers(value: float | RegisterValue, registers: np.ndarray) -> np.ndarray:
    if isinstance(value, RegisterValue):
        return registers[:, value.register]
    return np.full(len(registers), float(value))
