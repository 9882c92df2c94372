"""The code of compiled behaviors: rows of four numbers, each of which is one operation on a match's registers.

A row is (opcode, a, b, c). Every operand is the index of a register, unless the table of `opcodes` specifies otherwise.
Constants, inputs of the scene, numbers of the world and local variables are all registers of one array per match, so
the machine (`vm`) decodes nothing. In the table, `a = b + c` means registers[a] = registers[b] + registers[c]. A
target is the row of a jump. A list is the index of the first of several operands in `Code.lists`; their number
precedes it. Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Faults of a running match: values of the register FAULT, and their messages.
INFINITE_LOOP, DIVISION_BY_ZERO, DOMAIN_ERROR, INDEX_ERROR, PROGRAM_ERROR = range(1, 6)
FAULT_MESSAGES = {
    DIVISION_BY_ZERO: "division by zero",
    DOMAIN_ERROR: "math domain error",
    INDEX_ERROR: "index out of range",
    PROGRAM_ERROR: "",  # the message is the note of the row
}
MESSAGE_SLOT = "{}"  # placeholder for a number in the note of a row that may fail

MAX_LOOP_ITERATIONS = 10_000  # per thread and step; a loop without actions stops at this limit
MOST_ROWS = 20_000_000  # per thread and step; a limit for long code without loops
NO_COMMAND = -1.0  # the command of an object without an action in this step


# The first registers of every program: FAULT, 0 without a fault; FAULT_ROW, the failed row; REJECTED, 1 + the violated
# requirement, or 0; TERMINATED, 1 + the reason for the end of the match, or 0; COMPLETE, the same for the program as a
# scenario, which ends the match after the monitors; SEEN, the time of the scenario's last step; REWARD of this step.
FAULT, FAULT_ROW, REJECTED, TERMINATED, COMPLETE, SEEN, REWARD, FIRST_FREE = range(8)


class Code(NamedTuple):
    """A compiled program in the form for kernels: it is data, so that a new program needs no kernel compilation.

    Threads run in this order: threads of the scenario (checks at the start; its step, with its compose block and the
    inner scenarios), one for each object with a behavior, one for `record`, one for each monitor, one for
    `terminate simulation when`. One thread runs at the end of a match and checks for unsatisfied requirements.
    """

    rows: np.ndarray  # [n, 4] uint32
    lists: np.ndarray  # uint32: operand lists, each given by the index of its first element; its length precedes it
    threads: np.ndarray  # [T, 2] int32: register of the slot; object, or -1
    scenarios: int  # numbers of threads by kind
    behaviors: int
    records: int
    monitors: int
    parting: bool  # whether monitors also run in the step in which the scenario ends, as in Scenic 2
    world_base: int  # first register of the world table [O, F], row by row
    fact_base: int  # first register of the facts [G]
    clock: int  # register of the time, in steps
    register_count: int  # R
