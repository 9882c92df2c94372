"""Code is verified before it runs, and whatever its registers hold, the machine stays within them."""

import numpy as np
import pytest

from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import FAULT, INDEX_ERROR
from scenic_lite.dynamics.machine.verify import CodeError, slots, verify
from tests.scenic_lite.dynamics.hostile import RAN, REFUSED, Target, attack

PROGRAM = """
behavior Walk():
    steps = [1, 2, 3]
    while True:
        for i in range(3):
            take steps[i]

ego = new Object with behavior Walk
"""


def changed(target: Target, row: int, operand: int, value: int) -> None:
    rows = target.compiled.code.rows.copy()
    rows[row, operand] = value
    verify(target.compiled.code._replace(rows=rows), target.objects, target.cells)


def test_what_operands_name_must_exist() -> None:
    target = Target.of(PROGRAM)
    rows, registers = target.compiled.code.rows, target.compiled.code.register_count
    take = int(np.flatnonzero(rows[:, 0] == op.TAKE)[0])
    verify(target.compiled.code, target.objects, target.cells)
    with pytest.raises(CodeError, match="an operand of TAKE is not a register"):
        changed(target, take, 1, registers)
    with pytest.raises(CodeError, match="a target of TAKE is not a row"):
        changed(target, take, 3, len(rows))
    with pytest.raises(CodeError, match="unknown opcode"):
        changed(target, 0, 0, 200)
    with pytest.raises(CodeError, match="nothing follows the last row"):
        changed(target, len(rows) - 1, 0, op.COPY)
    with pytest.raises(CodeError, match="a thread moves no object"):
        verify(target.compiled.code, 0, target.cells)


def test_a_slot_that_holds_no_row_is_a_fault() -> None:
    target = Target.of(PROGRAM)
    for value in (np.nan, -1.0, 1e18, float(len(target.compiled.code.rows))):
        registers = target.registers.copy()
        registers[slots(target.compiled.code)] = value
        target.run(target.compiled.code, registers)
        assert registers[FAULT] == INDEX_ERROR


@pytest.mark.long
def test_code_and_registers_with_a_number_changed() -> None:
    counts = attack(3000, 0)
    assert counts[REFUSED] > 300 and counts[RAN] > 1000
