"""Verification of bytecode before execution, for tampered checkpoints and code; the machine checks almost nothing.

The rows, registers and lists of all operands must exist, and the last row must not fall through. The machine itself
checks only values that are known during a match, such as a computed index or a row in a slot.
Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

import numpy as np

from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import FIRST_FREE, Code
from scenic_lite.dynamics.machine.opcodes import OPCODES

ENDS = frozenset({op.END, op.JUMP, op.LOOP_BACK, op.RESUME, op.REJECT, op.FAULT, op.TAKE, op.WAIT, op.TERMINATE})
LENGTHS = {op.IN_SECTOR: 5, op.IN_RECTANGLE: 7, op.RECTANGLES_MEET: 10, op.SECTOR_MEETS: 10, op.IN_RINGS: 2}  # of lists
EDGE = 4  # number of operands of IN_RINGS per edge


class CodeError(ValueError):
    """Invalid code, which must not run; the message states the reason."""


def slots(code: Code) -> np.ndarray:
    """Return the sorted registers that hold the rows of suspended blocks."""
    jumps = np.isin(code.rows[:, 0], (op.RESUME, op.RESUME_IF_RUNNING))
    return np.unique(np.concatenate([code.threads[:, 0], code.rows[jumps, 1].astype(np.int32)]))


def verify(code: Code, objects: int, cells: int) -> Code:
    """Return the code if it is safe for a number of objects and a world of `cells` numbers.

    Raises `CodeError` for unsafe code.
    """
    rows, registers = code.rows.astype(np.int64), code.register_count
    _demand(int(rows[-1, 0]) in ENDS, "nothing follows the last row")
    _demand(rows[:, 0] < len(OPCODES), "unknown opcode")
    for opcode in np.unique(rows[:, 0]).tolist():
        mine = rows[rows[:, 0] == opcode]
        for values, kind in zip(mine[:, 1:].T, OPCODES[opcode].operands, strict=True):
            if kind in "abc.":  # the machine also reads unused operands
                _demand(values < registers, f"an operand of {OPCODES[opcode].name} is not a register")
            elif kind == "t":
                _demand(values < len(rows), f"a target of {OPCODES[opcode].name} is not a row")
            elif kind == "l":
                for place in values.tolist():
                    _check_list(code, opcode, place)
    many = rows[rows[:, 0] == op.COPY_MANY]
    _demand(many[:, 1:3] + many[:, 3:] <= registers, "a copy ends beyond the registers")
    entries, moved = code.threads.T
    _demand((entries >= FIRST_FREE) & (entries < registers), "a slot is not a register")
    _demand((moved >= -1) & (moved < objects), "a thread moves no object")
    kinds = code.scenarios, code.behaviors, code.records, code.monitors
    _demand(min(kinds) >= 0 and sum(kinds) + 2 == len(code.threads), "threads are missing")
    _demand(
        0 <= code.world_base <= registers - cells and 0 <= code.clock < registers, "the world is outside the registers"
    )
    return code


def _check_list(code: Code, opcode: int, place: int) -> None:
    """Check one list of operands: its length precedes it, its elements are registers."""
    _demand(1 <= place < len(code.lists), "a list is not there")
    length = int(code.lists[place - 1])
    _demand(place + length <= len(code.lists), "a list ends beyond the lists")
    _demand(code.lists[place : place + length] < code.register_count, "an element of a list is not a register")
    whole = opcode != op.IN_RINGS or (length - LENGTHS[opcode]) % EDGE == 0
    _demand(whole and length >= LENGTHS.get(opcode, 0), "a list is too short")


def _demand(holds: bool | np.ndarray, otherwise: str) -> None:
    if not np.all(holds):
        raise CodeError(otherwise)
