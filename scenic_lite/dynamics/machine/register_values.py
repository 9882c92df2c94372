"""Values in registers during a match, and their conversion to plain values.

Read next: `dynamics.machine.compiled`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenic_lite.core.scope import in_row
from scenic_lite.core.types import Instance, parts_of
from scenic_lite.values.graph import RandomExpr, Value


class RegisterValue(RandomExpr):
    """A value in a register during a match; a leaf of the compiler's expressions.

    `whole`: it is an integer, which matters for its text.
    """

    __slots__ = ("register", "whole")

    def __init__(self, register: int, kind: str = "number", whole: bool = False) -> None:
        super().__init__(None, (), kind)
        self.register, self.whole = register, whole


class Listed(NamedTuple):
    """A list of varying length in registers; only the first `length` elements count."""

    length: RegisterValue
    elements: list[Value]


def plain(value: Value, registers: np.ndarray, row: dict[RandomExpr, Value], names: dict[int, str]) -> Value:
    """Return a value with the contents of all its registers."""
    if isinstance(value, Listed):
        count = int(registers[value.length.register])
        return [plain(element, registers, row, names) for element in value.elements[:count]]
    for leaf in leaves(value):
        number = float(registers[leaf.register])
        if leaf.kind == "text":
            row[leaf] = names[int(number)]
        elif leaf.kind == "truth":
            row[leaf] = bool(number)
        else:
            row[leaf] = int(number) if leaf.whole else number
    value = in_row(value, row)
    if isinstance(value, Listed):
        return plain(value, registers, row, names)
    if isinstance(value, dict):
        return {key: plain(part, registers, row, names) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(plain(part, registers, row, names) for part in value)
    return value


def leaves(value: Value) -> list[RegisterValue]:
    """Return the registers on which a value depends, each once."""
    registers: list[RegisterValue] = []
    pending, seen = [value], set()
    while pending:
        part = pending.pop()
        if id(part) in seen or isinstance(part, Instance):
            continue
        seen.add(id(part))
        if isinstance(part, RegisterValue):
            registers.append(part)
        pending.extend(part.inputs if isinstance(part, RandomExpr) else parts_of(part))
    return registers
