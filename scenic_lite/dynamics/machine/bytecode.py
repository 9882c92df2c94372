"""The code that behaviors are compiled to: rows of four numbers, of which each does one thing to one row of registers.

A row is (op, a, b, c). Every operand is the index of a register, unless the table says otherwise: a constant, an input
of the scene, a number of the world and a local variable are all registers of the one row that a match has, so that the
machine (`vm`) decodes nothing. In the table, `a = b + c` means registers[a] = registers[b] + registers[c]; a target is
the row where the machine goes on; a list is the place of some operands in `Code.lists`, their number before them. Read
next: `vm`.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from scenic_lite.errors import SourceSpan


class Op(IntEnum):
    """One opcode each; the text is its meaning."""

    meaning: str
    form: str  # of the operands: t target, l list, k number, a..c registers; what is not there is unused

    def __new__(cls, value: int, form: str = "...", meaning: str = "") -> Op:
        op = int.__new__(cls, value)
        op._value_ = value
        op.form, op.meaning = form, meaning
        return op

    # ------------------------------------------------------------ time and control
    END = 0, "a..", "the thread has ended for good: its slot a = 0"
    TAKE = 1, "abt", "the object's command = a; slot b = target; nothing more in this step"
    WAIT = 2, ".bt", "no command; slot b = target; nothing more in this step"
    JUMP = 3, "..t", "go on at the target"
    JUMP_IF = 4, "a.t", "go on at the target if a is not 0"
    JUMP_UNLESS = 5, "a.t", "go on at the target if a is 0"
    JUMP_LESS = 6, "abt", "go on at the target if a < b"
    JUMP_NOT_LESS = 7, "abt", "go on at the target unless a < b"
    JUMP_LESS_EQUAL = 8, "abt", "go on at the target if a <= b"
    JUMP_NOT_LESS_EQUAL = 9, "abt", "go on at the target unless a <= b"
    JUMP_EQUAL = 10, "abt", "go on at the target if a == b"
    JUMP_NOT_EQUAL = 11, "abt", "go on at the target unless a == b"
    SET_SLOT = 12, "a.t", "slot a = target: where the block goes on when it is resumed"
    RESUME = 13, "a..", "go on where slot a says"
    RESUME_IF_RUNNING = 14, "a..", "go on where slot a says, unless it is 0: a block that is not running"
    # ------------------------------------------------------------ moving
    COPY = 15, "ab.", "a = b"
    PICK = 16, "abl", "a = the register that stands at place b of the list; a fault if there is no such place"
    FETCH = 17, "abc", "a = register b + the value of c"
    STORE = 18, "abc", "register a + the value of b = c"
    # ------------------------------------------------------------ arithmetic
    ADD = 19, "abc", "a = b + c"
    SUBTRACT = 20, "abc", "a = b - c"
    MULTIPLY = 21, "abc", "a = b * c"
    DIVIDE = 22, "abc", "a = b / c; a fault if c is 0"
    FLOOR_DIVIDE = 23, "abc", "a = b // c; a fault if c is 0"
    MODULO = 24, "abc", "a = b % c, with the sign of c; a fault if c is 0"
    POWER = 25, "abc", "a = b ** c; a fault if that is no real number"
    NEGATE = 26, "ab.", "a = -b"
    ABSOLUTE = 27, "ab.", "a = |b|"
    MINIMUM = 28, "abc", "a = the smaller of b and c, b if they are equal"
    MAXIMUM = 29, "abc", "a = the larger of b and c, b if they are equal"
    # ------------------------------------------------------------ truth
    LESS = 30, "abc", "a = b < c"
    LESS_EQUAL = 31, "abc", "a = b <= c"
    EQUAL = 32, "abc", "a = b == c"
    NOT_EQUAL = 33, "abc", "a = b != c"
    AND = 34, "abc", "a = b and c, as 0 or 1"
    OR = 35, "abc", "a = b or c, as 0 or 1"
    NOT = 36, "ab.", "a = not b, as 0 or 1"
    # ------------------------------------------------------------ functions
    SQUARE_ROOT = 37, "ab.", "a = √b; a fault if b < 0"
    HYPOTENUSE = 38, "abc", "a = √(b² + c²)"
    SINE = 39, "ab.", "a = sin b"
    COSINE = 40, "ab.", "a = cos b"
    TANGENT = 41, "ab.", "a = tan b"
    ARC_SINE = 42, "ab.", "a = arcsin b; a fault outside [-1, 1]"
    ARC_COSINE = 43, "ab.", "a = arccos b; a fault outside [-1, 1]"
    ARC_TANGENT = 44, "ab.", "a = arctan b"
    ARC_TANGENT_2 = 45, "abc", "a = the angle of the vector (c, b)"
    EXPONENTIAL = 46, "ab.", "a = e to the b"
    LOGARITHM = 47, "ab.", "a = ln b; a fault if b <= 0"
    LOGARITHM_2 = 48, "ab.", "a = the logarithm of b to base 2; a fault if b <= 0"
    LOGARITHM_10 = 49, "ab.", "a = the logarithm of b to base 10; a fault if b <= 0"
    FLOOR = 50, "ab.", "a = the largest integer not above b"
    CEILING = 51, "ab.", "a = the smallest integer not below b"
    TRUNCATE = 52, "ab.", "a = b without its fraction; a fault if b is not finite"
    ROUND = 53, "ab.", "a = the integer nearest to b, the even one of two"
    ROUND_DIGITS = 54, "abc", "a = b rounded to c decimal digits"
    COPY_SIGN = 55, "abc", "a = |b| with the sign of c"
    REMAINDER = 56, "abc", "a = the remainder of b / c with the sign of b; a fault if c is 0"
    NORMALISE = 57, "ab.", "a = the angle b in [-π, π]"
    # ------------------------------------------------------------ geometry
    IN_SECTOR = 58, "a.l", "a = whether the offset (x, y) lies in the sector (radius, heading, angle) of the list"
    IN_RECTANGLE = 59, "a.l", "a = whether (x, y) lies in the rectangle (x, y, heading, width, length) of the list"
    RECTANGLES_MEET = 60, "a.l", "a = whether two rectangles of the list meet, each (x, y, heading, width, length)"
    SECTOR_MEETS = 61, "a.l", "a = whether the sector (x, y, radius, heading, angle) meets the rectangle after it"
    IN_RINGS = 62, "a.l", "a = whether (x, y) lies inside the closed edges (x, y, x, y) that follow it in the list"
    # ------------------------------------------------------------ chance
    DRAW = 63, "abc", "a = b + c * the next uniform number in [0, 1) of the match's stream"
    CUT = 64, "abl", "a = how many of the numbers of the list, which rise, are at most b"
    QUANTILE = 65, "ab.", "a = the normal quantile of b"
    # ------------------------------------------------------------ lists and ends
    SORT = 66, "abc", "the c registers from a = the order of the c values from b: indices, the least first"
    REJECT = 67, "..k", "the match breaks requirement k of the program: it is none of its matches"
    TERMINATE = 68, "abt", "the match ends for reason a (a number); slot b = target; nothing more in this step"
    FAULT = 69, "...", "the program's own fault"
    FAULT_UNLESS = 70, "ab.", "the program's own fault unless a is not 0; its text may tell b"
    IS_INDEX = 71, "abc", "a = whether b is an integer from 0 to c - 1"
    AGAIN = 72, "..t", "a loop goes round: go on at the target; a fault if it is the 10,001st time in this step"
    COPY_MANY = 73, "abk", "the k registers from a = those from b"


class Fault(IntEnum):
    """What can go wrong while a match runs; the text is what the user reads."""

    words: str

    def __new__(cls, value: int, words: str = "") -> Fault:
        fault = int.__new__(cls, value)
        fault._value_ = value
        fault.words = words
        return fault

    NONE = 0, ""
    ENDLESS = 1, "the behavior never takes an action here"
    ZERO = 2, "division by zero"
    DOMAIN = 3, "math domain error"
    INDEX = 4, "index out of range"
    OWN = 5, ""  # what the row's note says


PATIENCE = 10_000  # rounds of loops of one thread in one step; one that takes no action ends here
MOST_ROWS = 20_000_000  # of one thread in one step: what is no loop of the program, and yet too long
NO_COMMAND = -1.0  # of an object that does nothing in this step


# The first registers of every program: Fault, 0 while all is well; the row that failed; 1 + the requirement that is
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


class Listing(NamedTuple):
    """What a person needs to read the code: a place for each row, a name for each register, the program's lines."""

    places: tuple[SourceSpan, ...]  # [n]
    names: dict[int, str]  # of registers
    lines: dict[tuple[str, int], str]  # by file and line
    notes: dict[int, str]  # of rows that are faults of the program
    titles: dict[int, str]  # of threads, by their entry row


def disassemble(code: Code, listing: Listing) -> str:
    """The code as text: each line of the program above the rows that it became."""
    targets = {int(row[3]) for row in code.rows if "t" in Op(row[0]).form}
    lines: list[str] = []
    shown = None
    for at, row in enumerate(code.rows):
        place = listing.places[at]
        if at in listing.titles:
            lines += ["", listing.titles[at]]
            shown = None
        if (place.file, place.line) != shown:
            shown = place.file, place.line
            lines.append(f"  {place.file}:{place.line}: {listing.lines.get(shown, '').strip()}")
        mark = ">" if at in targets else " "
        lines.append(f"  {mark}{at:5d}  {written(code, listing, row)}".rstrip())
    return "\n".join(lines).strip("\n")


def written(code: Code, listing: Listing, row: np.ndarray) -> str:
    """One row in words."""
    op = Op(row[0])
    parts = []
    for kind, operand in zip(op.form, map(int, row[1:]), strict=True):
        if kind == "t":
            parts.append(f"-> {operand}")
        elif kind == "l":
            items = code.lists[operand : operand + code.lists[operand - 1]]
            parts.append("[" + ", ".join(name_of(listing, int(each)) for each in items) + "]")
        elif kind == "k":
            parts.append(str(operand))
        elif kind != ".":
            parts.append(name_of(listing, operand))
    return f"{op.name.lower():20}{', '.join(parts)}"


def name_of(listing: Listing, register: int) -> str:
    return listing.names.get(register, f"r{register}")
