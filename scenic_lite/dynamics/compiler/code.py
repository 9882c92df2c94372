"""The assembler: rows with labels, and registers for constants, inputs, variables and intermediate results.

Registers are numbered by area during compilation; the final layout makes the areas adjacent. Constants, inputs, the
world and the threads' variables keep their values. All threads share the registers of intermediate results. Read next:
`dynamics.compiler.emit`, which turns nodes into rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from scenic_lite.core.budget import exceeded
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import FIRST_FREE
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.dynamics.machine.verify import ENDS
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values.graph import RandomExpr, ThetaColumn

MOST_ROWS = 200_000
MOST_REGISTERS = 100_000
LABEL = -1  # pseudo-opcode of a row that only marks a label
AREA = 1 << 24  # size of an area's range of register numbers, until the final layout
FIXED, CONSTANTS, INPUTS, VARIABLES, TEMPORARIES = (area * AREA for area in range(5))


class Label:
    """The target row of a jump; its index is known in the final layout."""

    __slots__ = ("row", "used")

    def __init__(self) -> None:
        self.row = -1
        self.used = False


class Operands(NamedTuple):
    """The operands of an opcode that takes a list."""

    registers: tuple[int, ...]


class Row(NamedTuple):
    opcode: int
    a: int
    b: int
    c: int | Label | Operands
    place: SourceSpan | None
    note: str = ""
    called: SourceSpan | None = None  # where the program calls the library function that contains this row


class RuntimeDraw(ThetaColumn):
    """A draw at run time, with the interface of a column of θ; `register` holds the value."""

    __slots__ = ("register",)

    def __init__(self, register: int, kind: str, place: SourceSpan, offset: float, span: float) -> None:
        super().__init__(kind, place, offset, span)
        self.register = register


@dataclass
class Area:
    """Registers of one kind, allocated like a stack."""

    base: int
    used: int = 0
    most: int = 0

    def take(self, count: int = 1) -> int:
        """Return the first of `count` fresh registers."""
        start = self.base + self.used
        self.used += count
        self.most = max(self.most, self.used)
        if self.used > MOST_REGISTERS:
            raise exceeded(f"the behaviors of the program need more than {MOST_REGISTERS:,} numbers at once")
        return start


@dataclass
class Assembler:
    """The rows written so far, and the state for further rows."""

    rows: list[Row] = field(default_factory=list)
    reachable: bool = True  # whether control can reach the next row
    place: SourceSpan | None = None  # place of the statement that is being compiled
    called: SourceSpan | None = None  # see `Row`
    variables: Area = field(default_factory=lambda: Area(VARIABLES))
    temporaries: Area = field(default_factory=lambda: Area(TEMPORARIES))
    constants: dict[float, int] = field(default_factory=dict)
    inputs: dict[int, tuple[int, RandomExpr]] = field(default_factory=dict)  # node id -> (register, node)
    initial: dict[int, float] = field(default_factory=dict)  # register -> value at the start of a match
    texts: dict[str, int] = field(default_factory=dict)
    register_names: dict[int, str] = field(default_factory=dict)  # register -> readable name
    fixed: Area = field(default_factory=lambda: Area(FIXED, FIRST_FREE))
    known: dict[int, tuple[int, RandomExpr]] = field(default_factory=dict)  # nodes already computed here, by id

    # ------------------------------------------------------------ rows

    def row(
        self,
        opcode: int,
        a: int = 0,
        b: int = 0,
        c: int | Label | Operands = 0,
        note: str = "",
        place: SourceSpan | None = None,
    ) -> None:
        if not self.reachable:
            return
        if isinstance(c, Label):
            c.used = True
        self.rows.append(Row(opcode, a, b, c, place or self.place, note, self.called))
        if len(self.rows) > MOST_ROWS:
            raise exceeded(f"the behaviors of the program become more than {MOST_ROWS:,} rows of code")
        if opcode in ENDS:
            self.reachable = False

    def put(self, label: Label) -> None:
        """Put a label at the next row, for jumps from earlier rows."""
        self.rows.append(Row(LABEL, 0, 0, label, self.place))
        self.reachable = self.reachable or label.used
        self.known.clear()

    def put_reachable(self, label: Label) -> None:
        """Put a label at the next row, which a slot can reach."""
        label.used = self.reachable = True
        self.put(label)

    def put_loop(self, label: Label) -> None:
        """Put a label at the next row, for jumps from later rows only."""
        self.rows.append(Row(LABEL, 0, 0, label, self.place))
        self.known.clear()

    def fault_unless(self, register: int, message: str, told: int = 0) -> None:
        self.row(op.FAULT_UNLESS, register, told, note=message)

    @contextmanager
    def when(self, register: int) -> Iterator[None]:
        """Execute the rows written inside the context only if the register is not 0."""
        otherwise = Label()
        self.row(op.JUMP_UNLESS, register, c=otherwise)
        yield
        self.put(otherwise)

    def dispatch(self, register: int, cases: Mapping[int, Callable[[], object]]) -> None:
        """Write the rows of all cases; the register selects the case that is executed."""
        end = Label()
        for number, write in cases.items():
            following = Label()
            self.row(op.JUMP_NOT_EQUAL, register, self.constant(number), following)
            write()
            if number != max(cases):
                self.row(op.JUMP, c=end)
            self.put(following)
        self.put(end)

    @contextmanager
    def rounds(self, stop: int, start: int | None = None, step: int = 1) -> Iterator[tuple[RegisterValue, Label]]:
        """Repeat the rows written inside the context for all numbers from register `start` to register `stop`.

        The label begins the next iteration. Without `start`, the numbers are list indices, and need no loop limit.
        """
        counter, again, following, over = RegisterValue(self.variables.take(), whole=True), Label(), Label(), Label()
        now = counter.register
        self.row(op.COPY, now, self.constant(0) if start is None else start)
        self.put_loop(again)
        self.row(op.JUMP_NOT_LESS, *((now, stop) if step > 0 else (stop, now)), over)
        yield counter, following
        self.put(following)
        self.row(op.ADD, now, now, self.constant(step))
        self.row(op.JUMP if start is None else op.LOOP_BACK, c=again)
        self.put(over)

    @contextmanager
    def captured(self) -> Iterator[list[Row]]:
        """Collect the rows written inside the context in a separate list."""
        inside: list[Row] = []
        outside, known, reachable = self.rows, dict(self.known), self.reachable
        self.rows = inside
        try:
            yield inside
        except BaseException:
            self.reachable = reachable
            raise
        finally:
            self.rows, self.known = outside, known

    # ------------------------------------------------------------ registers

    def constant(self, value: float | bool | str) -> int:
        """Return the register of a constant; a text is represented by its number in `texts`."""
        number = float(self.text(value)) if isinstance(value, str) else float(value)
        key = number if number != 0 else 0.0
        if number != number:
            raise ScenicError("value", "nan cannot be computed with")
        if key not in self.constants:
            self.constants[key] = CONSTANTS + len(self.constants)
        return self.constants[key]

    def text(self, value: str) -> int:
        return self.texts.setdefault(value, len(self.texts))

    def input(self, node: RandomExpr) -> int:
        """Return the register of a value that is constant in a match and computed at its start."""
        if id(node) not in self.inputs:
            self.inputs[id(node)] = (INPUTS + len(self.inputs), node)
        return self.inputs[id(node)][0]

    def begin_with(self, register: int, value: Any) -> None:
        """Set the initial value of a register to a fixed value or a value from the scene."""
        if isinstance(value, RandomExpr):
            self.inputs[-register] = (register, value)
        else:
            self.initial[register] = float(self.text(value)) if isinstance(value, str) else float(value)

    @contextmanager
    def statement(self) -> Iterator[None]:
        """Free the intermediate results of a statement at its end."""
        used = self.temporaries.used
        self.known.clear()
        try:
            yield
        finally:
            self.temporaries.used = used
            self.known.clear()
