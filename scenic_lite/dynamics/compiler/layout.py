"""The last step of the compiler, which assigns final numbers to rows and registers.

Read next: `dynamics.machine.compiled`.
"""

from __future__ import annotations

import numpy as np

from scenic_lite.dynamics.compiler.code import AREA, LABEL, Assembler, Label, Operands, Row
from scenic_lite.dynamics.compiler.compilation import Compilation, Thread
from scenic_lite.dynamics.machine.bytecode import SEEN, Code
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.dynamics.machine.listing import Listing
from scenic_lite.dynamics.machine.opcodes import OPCODES
from scenic_lite.dynamics.machine.register_values import leaves
from scenic_lite.dynamics.machine.verify import verify
from scenic_lite.errors import SourceSpan
from scenic_lite.scene.program import Program
from scenic_lite.values.graph import Tape


def finished(c: Compilation, threads: list[Thread]) -> Compiled:
    """Lay out the rows and registers of one pass."""
    code, program = c.code, c.program
    rows = placed(code.rows)
    layout = Layout(code)
    tape = Tape(
        [node for _, node in code.inputs.values()], program.layout.columns, program.mode.budget.limits.operations
    )
    inputs = [(layout(register), tape.slot(node), node.kind == "text") for register, node in code.inputs.values()]
    listing = listing_of(c, rows, threads, layout)
    for leaf in leaves([*c.output.commands, *(record.value for record in c.output.records)]):
        leaf.register = layout(leaf.register)
    objects = len(program.objects)
    cells = objects * len(c.world.fields) + len(c.world.facts)
    return Compiled(
        verify(code_of(c, rows, threads, layout), objects, cells),
        program,
        tuple(number_of(program, thread) for thread in threads),
        tuple(c.output.commands),
        tuple(c.output.end_reasons),
        tuple(c.output.rejections),
        tuple({(error.place, error.message): error for error in c.output.diagnostics}.values()),
        listing,
        start_of(c, layout),
        tuple(inputs),
        tape,
        code.texts,
        tuple(record._replace(taken=layout(record.taken)) for record in c.output.records),
        tuple((number, layout(register), at_first) for number, register, at_first in c.output.overridden),
        c.output.sets_reward,
    )


def number_of(program: Program, thread: Thread) -> int:
    """Return the number of the object that a thread controls, or -1."""
    return -1 if thread.agent is None else program.instances.index(thread.agent)


def code_of(c: Compilation, rows: list[Row], threads: list[Thread], layout: Layout) -> Code:
    """Return the code as arrays for kernels."""
    program = c.program
    lists: list[int] = []
    table = np.zeros((len(rows), 4), dtype=np.uint32)
    for i, row in enumerate(rows):
        table[i] = (row.opcode, *layout.operands(row, lists))
    return Code(
        table,
        np.array([*lists, 0], dtype=np.uint32),
        np.array([[layout(thread.slot), number_of(program, thread)] for thread in threads], dtype=np.int32),
        *c.output.counts,
        program.dialect == 2,
        layout(c.shown.base),
        layout(c.shown.facts),
        layout(c.shown.clock.register) if c.shown.clock is not None else 0,
        layout.count,
    )


def start_of(c: Compilation, layout: Layout) -> np.ndarray:
    """Return the initial registers [R] of a match, without the values from its scene."""
    code, start = c.code, np.zeros(layout.count)
    for value, register in code.constants.items():
        start[layout(register)] = value
    for register, value in code.initial.items():
        start[layout(register)] = value
    for slot, entry in c.output.starting.items():
        start[layout(slot)] = entry.row
    start[SEEN] = -1.0
    return start


def listing_of(c: Compilation, rows: list[Row], threads: list[Thread], layout: Layout) -> Listing:
    """Return the names that make rows and registers readable."""
    nowhere = SourceSpan(c.program.file, 1, 0, 1, 1)
    places = tuple(row.place or nowhere for row in rows)
    names = {layout(register): note for register, note in c.code.register_names.items()}
    names |= {layout(register): f"{value:g}" for value, register in c.code.constants.items()}
    lines = {(place.file, place.line): c.program.line_of(place) for place in set(places)}
    notes = {i: row.note for i, row in enumerate(rows) if row.note}
    titles = {label.row: title for label, title in c.output.titles.items()}
    titles |= {thread.entry.row: thread.title for thread in threads}
    calls = {i: row.called for i, row in enumerate(rows) if row.called is not None}
    return Listing(places, names, lines, notes, titles, calls)


class Layout:
    """The first register of each area."""

    def __init__(self, code: Assembler) -> None:
        areas = (code.variables, code.temporaries)
        sizes = [code.fixed.used, len(code.constants), len(code.inputs), *(area.most for area in areas)]
        self.bases = [sum(sizes[:i]) for i in range(len(sizes))]
        self.count = sum(sizes)

    def __call__(self, register: int) -> int:
        return self.bases[register // AREA] + register % AREA

    def operands(self, row: Row, lists: list[int]) -> tuple[int, int, int]:
        form = OPCODES[row.opcode].operands
        a, b = (self(row.a) if form[0] in "abc" else 0), (self(row.b) if form[1] in "abc" else 0)
        if isinstance(row.c, Label):
            return a, b, row.c.row
        if isinstance(row.c, Operands):
            lists.append(len(row.c.registers))
            lists += [self(register) for register in row.c.registers]
            return a, b, len(lists) - len(row.c.registers)
        return a, b, self(row.c) if form[2] in "abc" else row.c


def placed(rows: list[Row]) -> list[Row]:
    """Remove the label rows, and set the row index of each label."""
    real = [row for row in rows if row.opcode != LABEL]
    at = 0
    for row in rows:
        if row.opcode != LABEL:
            at += 1
        else:
            assert isinstance(row.c, Label)
            row.c.row = at
    return real
