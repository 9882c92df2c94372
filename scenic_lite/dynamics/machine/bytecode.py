"""The code of compiled behaviors: rows of four numbers; each row does one thing to one row of registers.

A row is (opcode, a, b, c). Every operand is the index of a register, unless the table of `opcodes` says otherwise: a
constant, an input of the scene, a number of the world and a local variable are all registers of the one row that a
match has, so that the machine (`vm`) decodes nothing. In the table, `a = b + c` means registers[a] = registers[b] +
registers[c]; a target is the row of a jump; a list is the index of some operands in `Code.lists`, preceded by their
number. Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Faults of a running match: numbers in the register FAULT, and their messages.
INFINITE_LOOP, DIVISION_BY_ZERO, DOMAIN_ERROR, INDEX_ERROR, PROGRAM_ERROR = range(1, 6)
FAULT_MESSAGES = {
    DIVISION_BY_ZERO: "division by zero",
    DOMAIN_ERROR: "math domain error",
    INDEX_ERROR: "index out of range",
    PROGRAM_ERROR: "",  # given by the row's note
}
MESSAGE_SLOT = "{}"  # in the note of a row that may fail: replaced by a number

MAX_LOOP_ITERATIONS = 10_000  # of one thread in one step; one that takes no action ends here
MOST_ROWS = 20_000_000  # of one thread in one step: long code without a loop
NO_COMMAND = -1.0  # of an object that does nothing in this step


# The first registers of every program: the fault, 0 if none; the row that failed; 1 + the violated requirement, or 0; 1
# + the reason for the end of the match, or 0; the same of the program as a scenario, whose end ends the match when the
# monitors have run; the time of the scenario's last step; the reward of this step.
FAULT, FAULT_ROW, REJECTED, TERMINATED, COMPLETE, SEEN, REWARD, FIRST_FREE = range(8)


class Code(NamedTuple):
    """A compiled program, as kernels read it: it is data, so that a new program compiles no kernel.

    Threads run in this order: those of the scenario (checks at the start; its step, with its compose block and the
    inner scenarios), one for each object with a behavior, one for `record`, one for each monitor, one for
    `terminate simulation when`, and one at the end of a match that checks for unsatisfied
    requirements.
    """

    rows: np.ndarray  # [n, 4] uint32
    lists: np.ndarray  # uint32: operand lists; each is named by its first element's index, its length precedes it
    threads: np.ndarray  # [T, 2] int32: register of the slot, object (-1: none)
    scenarios: int  # threads of each kind
    behaviors: int
    records: int
    monitors: int
    parting: bool  # monitors also run in the step in which the scenario ends: Scenic 2
    world_base: int  # first register of the world table [O, F], row by row
    fact_base: int  # first register of the facts [G]
    clock: int  # register of the time, in steps
    register_count: int  # R
