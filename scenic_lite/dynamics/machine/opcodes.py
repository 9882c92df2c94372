"""The opcodes of the virtual machine: plain integers, each with its operands and its meaning.

Kernels read plain integers faster than members of an enumeration, and Numba compiles them to constants. A new opcode
needs one row in this table and one branch in `vm`. Read next: `dynamics.machine.bytecode`, the format of code.
"""

from __future__ import annotations

from typing import NamedTuple


class Opcode(NamedTuple):
    """One row of the table; `operands` are their kinds: t target, l list, k number, a..c register, `.` unused."""

    name: str
    operands: str
    meaning: str


OPCODES: list[Opcode] = []  # index: the number of the opcode


def opcode(name: str, operands: str, meaning: str) -> int:
    """Add an opcode to the table and return its number."""
    OPCODES.append(Opcode(name, operands, meaning))
    return len(OPCODES) - 1


# ------------------------------------------------------------ time and control
END = opcode("END", "a..", "the thread has ended for good: its slot a = 0")
TAKE = opcode("TAKE", "abt", "the object's command = a; slot b = target; nothing more in this step")
WAIT = opcode("WAIT", ".bt", "no command; slot b = target; nothing more in this step")
JUMP = opcode("JUMP", "..t", "go on at the target")
JUMP_IF = opcode("JUMP_IF", "a.t", "go on at the target if a is not 0")
JUMP_UNLESS = opcode("JUMP_UNLESS", "a.t", "go on at the target if a is 0")
JUMP_LESS = opcode("JUMP_LESS", "abt", "go on at the target if a < b")
JUMP_NOT_LESS = opcode("JUMP_NOT_LESS", "abt", "go on at the target unless a < b")
JUMP_LESS_EQUAL = opcode("JUMP_LESS_EQUAL", "abt", "go on at the target if a <= b")
JUMP_NOT_LESS_EQUAL = opcode("JUMP_NOT_LESS_EQUAL", "abt", "go on at the target unless a <= b")
JUMP_EQUAL = opcode("JUMP_EQUAL", "abt", "go on at the target if a == b")
JUMP_NOT_EQUAL = opcode("JUMP_NOT_EQUAL", "abt", "go on at the target unless a == b")
SET_SLOT = opcode("SET_SLOT", "a.t", "slot a = target: where the block goes on when it is resumed")
RESUME = opcode("RESUME", "a..", "go on where slot a says")
RESUME_IF_RUNNING = opcode("RESUME_IF_RUNNING", "a..", "go on where slot a says, unless it is 0: not running")
# ------------------------------------------------------------ moving
COPY = opcode("COPY", "ab.", "a = b")
SELECT = opcode("SELECT", "abl", "a = the register at place b of the list; a fault if there is none")
LOAD_INDEXED = opcode("LOAD_INDEXED", "abc", "a = register b + the value of c")
STORE = opcode("STORE", "abc", "register a + the value of b = c")
# ------------------------------------------------------------ arithmetic
ADD = opcode("ADD", "abc", "a = b + c")
SUBTRACT = opcode("SUBTRACT", "abc", "a = b - c")
MULTIPLY = opcode("MULTIPLY", "abc", "a = b * c")
DIVIDE = opcode("DIVIDE", "abc", "a = b / c; a fault if c is 0")
FLOOR_DIVIDE = opcode("FLOOR_DIVIDE", "abc", "a = b // c; a fault if c is 0")
MODULO = opcode("MODULO", "abc", "a = b % c, with the sign of c; a fault if c is 0")
POWER = opcode("POWER", "abc", "a = b ** c; a fault if that is not a real number")
NEGATE = opcode("NEGATE", "ab.", "a = -b")
ABSOLUTE = opcode("ABSOLUTE", "ab.", "a = |b|")
MINIMUM = opcode("MINIMUM", "abc", "a = the smaller of b and c, b if they are equal")
MAXIMUM = opcode("MAXIMUM", "abc", "a = the larger of b and c, b if they are equal")
# ------------------------------------------------------------ truth
LESS = opcode("LESS", "abc", "a = b < c")
LESS_EQUAL = opcode("LESS_EQUAL", "abc", "a = b <= c")
EQUAL = opcode("EQUAL", "abc", "a = b == c")
NOT_EQUAL = opcode("NOT_EQUAL", "abc", "a = b != c")
AND = opcode("AND", "abc", "a = b and c, as 0 or 1")
OR = opcode("OR", "abc", "a = b or c, as 0 or 1")
NOT = opcode("NOT", "ab.", "a = not b, as 0 or 1")
# ------------------------------------------------------------ functions
SQUARE_ROOT = opcode("SQUARE_ROOT", "ab.", "a = √b; a fault if b < 0")
HYPOTENUSE = opcode("HYPOTENUSE", "abc", "a = √(b² + c²)")
SINE = opcode("SINE", "ab.", "a = sin b")
COSINE = opcode("COSINE", "ab.", "a = cos b")
ARC_TANGENT_2 = opcode("ARC_TANGENT_2", "abc", "a = the angle of the vector (c, b)")
EXPONENTIAL = opcode("EXPONENTIAL", "ab.", "a = e to the b")
LOGARITHM = opcode("LOGARITHM", "ab.", "a = ln b; a fault if b <= 0")
FLOOR = opcode("FLOOR", "ab.", "a = the largest integer not above b")
CEILING = opcode("CEILING", "ab.", "a = the smallest integer not below b")
TRUNCATE = opcode("TRUNCATE", "ab.", "a = b without its fraction; a fault if b is not finite")
ROUND = opcode("ROUND", "ab.", "a = the integer nearest to b, the even one of two")
NORMALISE = opcode("NORMALISE", "ab.", "a = the angle b in [-π, π]")
# ------------------------------------------------------------ geometry
IN_SECTOR = opcode("IN_SECTOR", "a.l", "a = whether (x, y) lies in the list's sector (radius, heading, angle)")
IN_RECTANGLE = opcode("IN_RECTANGLE", "a.l", "a = whether (x, y) lies in the list's (x, y, heading, width, length)")
RECTANGLES_MEET = opcode(
    "RECTANGLES_MEET", "a.l", "a = whether two rectangles meet, each (x, y, heading, width, length)"
)
SECTOR_MEETS = opcode("SECTOR_MEETS", "a.l", "a = whether (x, y, radius, heading, angle) meets the rectangle after it")
IN_RINGS = opcode("IN_RINGS", "a.l", "a = whether (x, y) lies inside the closed edges (x, y, x, y) after it")
# ------------------------------------------------------------ chance
DRAW = opcode("DRAW", "abc", "a = b + c * the next uniform number in [0, 1) of the match's stream")
BUCKETIZE = opcode("BUCKETIZE", "abl", "a = how many of the numbers of the list, which rise, are at most b")
QUANTILE = opcode("QUANTILE", "ab.", "a = the normal quantile of b")
# ------------------------------------------------------------ lists and ends
SORT = opcode("SORT", "abc", "the c registers from a = the order of the c values from b: indices, the least first")
REJECT = opcode("REJECT", "..k", "the match violates requirement k of the program and is rejected")
TERMINATE = opcode("TERMINATE", "abt", "the match ends for reason a; slot b = target; nothing more in this step")
FAULT = opcode("FAULT", "...", "the program's own fault")
FAULT_UNLESS = opcode("FAULT_UNLESS", "ab.", "the program's own fault unless a is not 0; its text may contain b")
IS_INDEX = opcode("IS_INDEX", "abc", "a = whether b is an integer from 0 to c - 1")
LOOP_BACK = opcode("LOOP_BACK", "..t", "a loop goes round: go on at the target; a fault at the 10,001st time in a step")
COPY_MANY = opcode("COPY_MANY", "abk", "the k registers from a = those from b")

NUMBERS = {row.name: number for number, row in enumerate(OPCODES)}
