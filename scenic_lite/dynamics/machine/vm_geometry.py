"""The longer functions of the virtual machine: formulas of `values` on operand lists, polygons, sorting, powers.

Numba compiles the formulas unchanged. Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import overload, register_jitable

from regista.kernels.jit import kernel
from scenic_lite.values import formulas
from scenic_lite.values.formulas import CLOSENESS

for helper in (formulas.in_frame, formulas.edge_meets_arc, formulas.edge_meets_ray, formulas.rational, formulas.horner):
    register_jitable(helper)
in_sector = kernel(register_jitable(formulas.in_sector))
in_rectangle = kernel(formulas.in_rectangle)
rectangles_meet = kernel(formulas.rectangles_meet)
sector_meets_rectangle = kernel(formulas.sector_meets_rectangle)
quantile = kernel(formulas.normal_quantile)


@overload(formulas.either)
def either(condition, first, second):
    """Choose between two numbers; `np.where` would create an array, and kernels must not allocate."""
    return lambda condition, first, second: first if condition else second


@kernel
def five(registers, lists, at):
    """Return five operands of a list: a sector (x, y, radius, heading, angle) or a rectangle (x, y, heading, ...)."""
    x, y = registers[lists[at]], registers[lists[at + 1]]
    return x, y, registers[lists[at + 2]], registers[lists[at + 3]], registers[lists[at + 4]]


@kernel
def in_rings(registers, lists, at):
    """Return whether a point is inside or on closed edges; inside, a ray crosses the edges an odd number of times."""
    x, y = registers[lists[at]], registers[lists[at + 1]]
    inside = False
    for edge in range(at + 2, at + lists[at - 1], 4):
        px, py = registers[lists[edge]], registers[lists[edge + 1]]
        dx, dy = registers[lists[edge + 2]] - px, registers[lists[edge + 3]] - py
        share = ((x - px) * dx + (y - py) * dy) / max(dx * dx + dy * dy, 1e-300)
        share = min(max(share, 0.0), 1.0)
        if math.sqrt((x - px - share * dx) ** 2 + (y - py - share * dy) ** 2) <= CLOSENESS:
            return True
        if (py > y) != (py + dy > y) and x < px + dx * (y - py) / dy:
            inside = not inside
    return inside


@kernel
def bucketize(value, registers, lists, at):
    """Count the numbers of an ascending list that are at most `value`."""
    count = 0
    while count < lists[at - 1] and registers[lists[at + count]] <= value:
        count += 1
    return float(count)


@kernel
def sort_order(registers, out, keys, count):
    """Write the stable sort order of `count` keys, as indices from the least key up."""
    for i in range(count):
        at = i
        while at > 0 and registers[keys + i] < registers[keys + int(registers[out + at - 1])]:
            registers[out + at] = registers[out + at - 1]
            at -= 1
        registers[out + at] = i


@kernel
def power(base, exponent):
    """Return base ** exponent, and whether Python's result is a real number."""
    if base == 0 and exponent < 0:
        return 0.0, False
    if base < 0 and exponent != math.floor(exponent):
        return 0.0, False
    result = np.float64(base) ** np.float64(exponent)
    return result, np.isfinite(result) or not np.isfinite(base) or not np.isfinite(exponent)
