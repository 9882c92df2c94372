"""From values back to draws: what is known of the registers of a tape is carried backwards, operation by operation.

A value that is known, with all its inputs but one, gives that one; and forwards, inputs that are known give the value.
What only several equations together decide is left to `solver`. Read next: `inverse.levels`, which asks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scenic_lite.core.scope import DrawnPoint
from scenic_lite.inverse.inverses import rule_for
from scenic_lite.inverse.knowledge import Knowledge
from scenic_lite.values.geometry import Vector

SWEEPS = 50  # each carries knowledge through the whole graph, forwards and back; more only for a malicious graph


def propagate(knowledge: Knowledge, points: list[DrawnPoint], slots: dict[int, int]) -> None:
    """Carry what is known through the tape, forwards and backwards, until nothing new is learnt.

    `points` gives the regions' own inverses, `slots` the register of a node by its id.
    """
    places = [(each, [slots.get(id(part), -1) for part in (each.point.x, each.point.y)]) for each in points]
    with np.errstate(all="ignore"):
        for _ in range(SWEEPS):
            before = knowledge.learnt
            for operation, inputs, out in knowledge.tape.steps:
                forward(knowledge, operation, inputs, out)
            for drawn, registers in places:
                if min(registers) >= 0:
                    from_point(knowledge, drawn, registers, slots)
            for operation, inputs, out in reversed(knowledge.tape.steps):
                rule = rule_for(operation)
                if rule is not None:
                    rule(knowledge, operation, inputs, out)
            if knowledge.learnt == before:
                return


def forward(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    rows = ~knowledge.known[out]
    for each in inputs:
        rows = rows & knowledge.known[each]
    if rows.any():
        knowledge.learn(out, rows, operation(*(knowledge.at(each, rows) for each in inputs)))


def from_point(knowledge: Knowledge, drawn: DrawnPoint, registers: list[int], slots: dict[int, int]) -> None:
    """The columns of a point that is known, by its region's inverse; nan outside."""
    columns = [slots[id(column)] for column in drawn.columns]
    rows = ~knowledge.known[columns[0]] & knowledge.known[registers[0]] & knowledge.known[registers[1]]
    if not rows.any():
        return
    x, y = (np.broadcast_to(knowledge.at(each, rows), (rows.sum(),)).astype(float) for each in registers)
    uniforms = drawn.region.uniforms(Vector(x, y))
    if uniforms is None:
        return
    sound = np.isfinite(uniforms[0]) & np.isfinite(uniforms[-1])
    rows[rows] = sound
    for slot, column, uniform in zip(columns, drawn.columns, uniforms, strict=False):
        knowledge.learn(slot, rows, column.offset + column.span * np.asarray(uniform)[sound])
