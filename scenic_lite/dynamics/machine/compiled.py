"""A compiled program: its code, and the data for execution and for error messages.

Read next: `dynamics.machine.vm`; `tests/scenic_lite/dynamics/controller.py`, which drives one match from Python.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from scenic_lite.core.types import Instance
from scenic_lite.dynamics.machine import bytecode
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.listing import Listing, disassemble
from scenic_lite.dynamics.machine.register_values import RegisterValue, plain
from scenic_lite.errors import ScenicError
from scenic_lite.scene.program import Program
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, Value


class Record(NamedTuple):
    """A `record` in registers.

    `when`: "initial", "each" or "final". `taken`: the register with the time of the last recording, or -1. `value`: the
    value, with registers.
    """

    name: str
    when: str
    taken: int
    value: Value


@dataclass(frozen=True, eq=False)
class Compiled:
    """A program's behaviors as code, with the data for execution and for error messages.

    Attributes:
        code: the arrays that kernels read.
        program: the source program.
        threads: for each thread, the object that it controls, or -1.
        commands: in a world without numbered actions, the value of each command number, with registers.
        diagnostics: errors of statements that stop every match that reaches them; kind `warning`: probable
            mistakes.
        records: the registers of `record` statements.
        sets_reward: whether a statement assigns `simulation().scenic_reward`.
        end_reasons, rejections: the possible reasons for the end of a match, and the requirements that it may
            violate; a register holds the index plus 1.
    """

    code: bytecode.Code
    program: Program
    threads: tuple[int, ...]
    commands: tuple[tuple[Value, ...], ...]
    end_reasons: tuple[str, ...]
    rejections: tuple[str, ...]
    diagnostics: tuple[ScenicError, ...]
    listing: Listing
    start: np.ndarray  # [R]: initial registers, such as constants and entry rows of threads
    inputs: tuple[tuple[int, int, bool], ...]  # set by the scene: register, slot of the tape, is text
    tape: Tape
    texts: dict[str, int]
    records: tuple[Record, ...]
    overridden: tuple[tuple[int, int, bool], ...]  # objects that change behavior: number, register, has an initial one
    sets_reward: bool

    def registers(self, theta: np.ndarray) -> np.ndarray:
        """Return the registers at the start of matches with theta [N, D]: [N, R] float64."""
        theta = self.program.layout.checked(theta)
        rows = np.tile(self.start, (len(theta), 1))
        if self.inputs:
            with np.errstate(all="ignore"):
                values_of = self.tape.run(self.program.layout.scaled(theta))
            for register, slot, text in self.inputs:
                values = values_of[slot]
                rows[:, register] = [self.text(value) for value in values] if text else values
        return rows

    def text(self, value: str) -> int:
        """Return the number of a text, which is new if the program does not contain the text."""
        return self.texts.setdefault(str(value), len(self.texts))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return `diagnostics` as messages with places, for the author of the program."""
        stops = "a match that comes to this line stops: "
        return tuple(f"{'' if error.kind == 'warning' else stops}{error}" for error in self.diagnostics)

    def disassembly(self) -> str:
        """Return a readable listing of the code, with the lines of the program."""
        return disassemble(self.code, self.listing)

    def fault(self, registers: np.ndarray) -> ScenicError | None:
        """Return the fault of a match [R] as an error with its place in the program, or None."""
        if registers[bytecode.FAULT] == 0:
            return None
        row = min(int(registers[bytecode.FAULT_ROW]), len(self.listing.places) - 1)
        fault = int(registers[bytecode.FAULT])
        if fault == bytecode.INFINITE_LOOP:
            hint = "is a take or wait missing in a loop?"
            message = f"more than {bytecode.MAX_LOOP_ITERATIONS:,} rounds of loops without an action"
            return self.program.error("budget", message, self.listing.places[row], hint)
        message = self.listing.notes.get(row, "") or bytecode.FAULT_MESSAGES[fault]
        if self.code.rows[row, 0] == op.FAULT_UNLESS:
            message = message.replace(bytecode.MESSAGE_SLOT, f"{registers[self.code.rows[row, 2]]:g}")
        place, called = self.listing.places[row], self.listing.calls.get(row)
        error = self.program.error("value", message, called or place)
        if called is not None:
            error.notes = (f"    in {place.file}:{place.line}: {self.program.line_of(place).strip()}",)
        return error

    def plain(self, value: Value, registers: np.ndarray, scene: dict[RandomExpr, Value]) -> Value:
        """Return a value with registers as a plain value, in a match [R] with these values of its draws."""
        names = {number: text for text, number in self.texts.items()}
        return plain(value, registers, dict(scene), names)


# ------------------------------------------------------------ results of `record` statements
def recorded(compiled: Compiled, registers: np.ndarray) -> dict[str, np.ndarray]:
    """Return the recorded values by name, given the registers [N, R] after a step.

    Numbers and truth values are float64 [N], vectors [N, 2], with NaN for a match without a recording in this step.
    Other values are an array of Python values, with None for a missing value. `record initial` belongs to the first
    step, `record final` to the last.
    """
    by_name: dict[str, np.ndarray] = {}
    for record in compiled.records:
        time, at = registers[:, compiled.code.clock], registers[:, record.taken]
        taken = (at == time) | ((record.when != "each") & (at == 0) & (time <= 1))
        values = values_of(compiled, record, registers, taken)
        before = by_name.get(record.name)
        if before is None:
            by_name[record.name] = values
        elif before.shape == values.shape and before.dtype == values.dtype:
            before[taken] = values[taken]  # among records with one name, the last recording counts
    return by_name


def values_of(compiled: Compiled, record: Record, registers: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Return the values of one record in all matches."""
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
