"""A program's behaviors, compiled for its matches: their initial registers, and their errors.

Read next: `scenic.scripted_step`, which runs them in a match; `scenic_lite.dynamics.compiler.compile`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from regista.envs.football.constants import PROGRAM_FAULT
from regista.envs.football.field_kinds import Kind, Place
from regista.envs.football.limits import Limits
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.football.scenic.world_table import BUT_HEADING, HEADING, NUM_FIELDS, UNREAD, WHOLE
from scenic_lite import Program
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import COMPLETE, FAULT, FAULT_ROW, REJECTED, TERMINATED
from scenic_lite.dynamics.machine.compiled import recorded
from scenic_lite.dynamics.machine.verify import slots


class CompiledBehaviors:
    """The compiled behaviors and monitors of a program.

    Attributes:
        code: for kernels.
        is_live: whether any behavior or monitor does something.
        num_registers: R, the number of registers of each match.
        has_records: whether the program has `record` statements.
        sets_reward: whether it assigns `simulation().scenic_reward`.

    Raises ScenicError for a behavior that cannot be compiled.
    """

    def __init__(self, program: Program) -> None:
        self.compiled = compile_program(program, FOOTBALL_WORLD)
        self.code = self.compiled.code
        self.is_live = not does_nothing(self.code.rows)
        self.num_registers = self.code.register_count
        self.has_records = bool(self.compiled.records)
        self.sets_reward = self.compiled.sets_reward

    @cached_property
    def limits(self) -> Limits:
        """The limits of registers: of row numbers, faults and endings; other registers may hold any number."""
        compiled, kinds = self.compiled, dict[int, Kind]()
        kinds |= {int(slot): Place(len(self.code.rows)) for slot in slots(self.code)}
        kinds |= {FAULT: Place(1), FAULT_ROW: Place(len(self.code.rows))}  # the batch resets a failed match at once
        kinds |= {REJECTED: Place(1 + len(compiled.rejections))}
        kinds |= {TERMINATED: Place(1 + len(compiled.end_reasons)), COMPLETE: Place(1 + len(compiled.end_reasons))}
        return Limits.of_array(self.num_registers, kinds)

    @cached_property
    def objects_read(self) -> np.ndarray:
        """The fields that the program reads of its O objects: `world_table.UNREAD`, `BUT_HEADING` or `WHOLE`, `[O]`."""
        code, count = self.code, len(self.compiled.program.objects)
        registers = np.array([[kind in "abc" for kind in opcode.operands] for opcode in op.OPCODES])
        read = np.zeros(code.register_count, bool)
        read[code.rows[:, 1:][registers[code.rows[:, 0]]]] = True
        read[code.lists[code.lists < code.register_count]] = True  # the lengths of lists are in between
        for base in code.rows[np.isin(code.rows[:, 0], (op.LOAD_INDEXED, op.SORT, op.COPY_MANY)), 2]:
            read[base:] = True  # several registers from there on
        cells = read[code.world_base :][: count * NUM_FIELDS].reshape(count, NUM_FIELDS) | self.has_records
        return np.where(cells[:, HEADING], WHOLE, np.where(cells.any(axis=1), BUT_HEADING, UNREAD))

    def registers(self, theta: np.ndarray) -> np.ndarray:
        """Return the registers `[N, R]` at the start of episodes on θ `[N, D]`."""
        return self.compiled.registers(theta)

    def recorded(self, registers: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values recorded in the last step of matches with registers `[N, R]`, by name (see `recording`)."""
        return recorded(self.compiled, registers)

    def error(self, match: np.ndarray, registers: np.ndarray, where: str) -> Exception:
        """Return the error of a failed match from its registers `[R]`, with the program's line and the match."""
        if match["fault"] != PROGRAM_FAULT:
            return FloatingPointError(f"impossible state (fault {match['fault']}) in {where}")
        error = self.compiled.fault(registers)
        assert error is not None
        error.notes = (*error.notes, f"    in {where}")
        return error


def does_nothing(rows: np.ndarray) -> bool:
    """Return whether the threads of a program `[n, 4]` only end, wait, or jump forward."""
    opcodes, on = rows[:, 0], rows[:, 3] > np.arange(len(rows))
    return bool((np.isin(opcodes, (op.END, op.WAIT)) | ((opcodes == op.JUMP) & on)).all())
