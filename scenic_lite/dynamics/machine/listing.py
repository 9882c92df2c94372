"""Readable listings of code: rows in words, with their places in the program.

Read next: `dynamics.machine.opcodes`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenic_lite.dynamics.machine.bytecode import Code
from scenic_lite.dynamics.machine.opcodes import OPCODES
from scenic_lite.errors import SourceSpan


class Listing(NamedTuple):
    """The names that make code readable: places of rows, names of registers, and lines of the program."""

    places: tuple[SourceSpan, ...]  # [n]
    names: dict[int, str]  # register -> name
    lines: dict[tuple[str, int], str]  # (file, line) -> text
    notes: dict[int, str]  # row -> message of its fault
    titles: dict[int, str]  # entry row -> title of the thread
    calls: dict[int, SourceSpan]  # row of a library function -> its call in the program


def disassemble(code: Code, listing: Listing) -> str:
    """Return the code as text: each line of the program above its rows."""
    targets = {int(row[3]) for row in code.rows if "t" in OPCODES[row[0]].operands}
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
    """Return one row in words."""
    opcode = OPCODES[row[0]]
    parts = []
    for kind, operand in zip(opcode.operands, map(int, row[1:]), strict=True):
        if kind == "t":
            parts.append(f"-> {operand}")
        elif kind == "l":
            items = code.lists[operand : operand + code.lists[operand - 1]]
            parts.append("[" + ", ".join(name_of(listing, int(register)) for register in items) + "]")
        elif kind == "k":
            parts.append(str(operand))
        elif kind != ".":
            parts.append(name_of(listing, operand))
    return f"{opcode.name.lower():20}{', '.join(parts)}"


def name_of(listing: Listing, register: int) -> str:
    return listing.names.get(register, f"r{register}")
