"""The code that behaviors are compiled to: rows of four numbers, of which each does one thing to one row of registers.

A row is (opcode, a, b, c). Every operand is the index of a register, unless the table of `opcodes` says otherwise: a
constant, an input of the scene, a number of the world and a local variable are all registers of the one row that a
match has, so that the machine (`vm`) decodes nothing. In the table, `a = b + c` means registers[a] = registers[b] +
registers[c]; a target is the row where the machine goes on; a list is the place of some operands in `Code.lists`, their
number before them. Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# What can go wrong while a match runs: numbers in the register FAULT, and what the user reads.
INFINITE_LOOP, DIVISION_BY_ZERO, DOMAIN_ERROR, INDEX_ERROR, PROGRAM_ERROR = range(1, 6)
FAULT_MESSAGES = {
    DIVISION_BY_ZERO: "division by zero",
    DOMAIN_ERROR: "math domain error",
    INDEX_ERROR: "index out of range",
    PROGRAM_ERROR: "",  # what the row's note says
}
MESSAGE_SLOT = "{}"  # in the note of a row that may fail: the number that its message tells

MAX_LOOP_ITERATIONS = 10_000  # of one thread in one step; one that takes no action ends here
MOST_ROWS = 20_000_000  # of one thread in one step: what is no loop of the program, and yet too long
NO_COMMAND = -1.0  # of an object that does nothing in this step


# The first registers of every program: the fault, 0 while all is well; the row that failed; 1 + the requirement that is
# broken, 0; 1 + the reason for which the match has ended, 0; the same of the program as a scenario, whose end ends the
# match when monitors have run; the time at which the scenario took its last step; the reward of this step.
FAULT, FAULT_ROW, REJECTED, TERMINATED, COMPLETE, SEEN, REWARD, FIRST_FREE = range(8)


class Code(NamedTuple):
    """A compiled program, as kernels read it: data, so that a new program compiles no kernel.

    Threads run in this order: those of the scenario (what is checked at the start; its step, in which its compose block
    and the scenarios inside take theirs), one for each object with a behavior, one for `record`, one for each monitor,
    one for `terminate simulation when`, and one that is asked at the end of a match whether it leaves a requirement
    unsatisfied.
    """

    rows: np.ndarray  # [n, 4] uint32
    lists: np.ndarray  # uint32: operand lists; each is named by the place of its first element, its length before it
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
