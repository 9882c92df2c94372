"""The machine's longer functions: membership in shapes, the normal quantile, sorting, powers.

Two formulas of `values.formulas` are compiled as they stand. Where the machine saves by leaving early, or has a list
of edges, it has its own, and `tests/scenic_lite/test_operations.py` compares both. Read next: `dynamics.machine.vm`.
"""

from __future__ import annotations

import math

import numpy as np

from scenic_lite.kernels.jit import kernel
from scenic_lite.values import formulas
from scenic_lite.values.formulas import CENTRE, CLOSENESS, FAR, LEAST_PROBABILITY, MIDDLE, TURN

_CENTRE, _MIDDLE, _FAR = (np.array(coefficients) for coefficients in (CENTRE, MIDDLE, FAR))  # [2, K] each
point_in_rectangle = kernel(formulas.in_rectangle)
rectangle_meets_rectangle = kernel(formulas.rectangles_meet)


@kernel
def in_sector(x, y, radius, heading, angle):
    """Return whether the offset (x, y) from the apex lies in a sector."""
    if x == 0 and y == 0:
        return radius >= 0
    if math.sqrt(x * x + y * y) > radius:
        return False
    bearing = math.atan2(y, x) - math.pi / 2 - heading
    return abs(bearing - TURN * np.rint(bearing / TURN)) <= angle / 2


@kernel
def in_rectangle(registers, lists, at):
    """Return whether (x, y) lies in (x, y, heading, width, length), edges included."""
    x, y = registers[lists[at]], registers[lists[at + 1]]
    cx, cy, heading = registers[lists[at + 2]], registers[lists[at + 3]], registers[lists[at + 4]]
    return point_in_rectangle(x, y, cx, cy, heading, registers[lists[at + 5]], registers[lists[at + 6]])


@kernel
def rectangles_meet(registers, lists, at):
    """Return whether two rectangles meet, each (x, y, heading, width, length)."""
    ax, ay, turn_a = registers[lists[at]], registers[lists[at + 1]], registers[lists[at + 2]]
    bx, by, turn_b = registers[lists[at + 5]], registers[lists[at + 6]], registers[lists[at + 7]]
    width_a, length_a = registers[lists[at + 3]], registers[lists[at + 4]]
    width_b, length_b = registers[lists[at + 8]], registers[lists[at + 9]]
    return rectangle_meets_rectangle(ax, ay, turn_a, width_a, length_a, bx, by, turn_b, width_b, length_b)


@kernel
def edge_meets_arc(px, py, dx, dy, radius, heading, angle):
    """Return whether a segment from (px, py) by (dx, dy) crosses the circle round the origin within an angle."""
    a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - radius * radius
    if b * b < a * c or a == 0:
        return False
    root = math.sqrt(max(b * b - a * c, 0.0))
    for sign in (-1.0, 1.0):
        t = (-b + sign * root) / a
        if 0 <= t <= 1 and in_sector(px + t * dx, py + t * dy, radius * (1 + 1e-9), heading, angle):
            return True
    return False


@kernel
def edge_meets_ray(px, py, dx, dy, turn, radius):
    """Return whether the segment crosses the one of length `radius` from the origin along a heading."""
    ray_x, ray_y = -math.sin(turn), math.cos(turn)
    qx, qy = px + dx, py + dy
    side_p, side_q = ray_x * py - ray_y * px, ray_x * qy - ray_y * qx
    if side_p == side_q or side_p * side_q > 0:
        return False
    along_p, along_q = ray_x * px + ray_y * py, ray_x * qx + ray_y * qy
    along = along_p + (along_q - along_p) * side_p / (side_p - side_q)
    return 0 <= along <= radius


@kernel
def sector_meets(registers, lists, at):
    """Return whether a sector (x, y, radius, heading, angle) meets a rectangle (x, y, heading, width, length)."""
    x, y = registers[lists[at]], registers[lists[at + 1]]
    radius, heading, angle = registers[lists[at + 2]], registers[lists[at + 3]], registers[lists[at + 4]]
    cx, cy, turn = registers[lists[at + 5]], registers[lists[at + 6]], registers[lists[at + 7]]
    width, length = registers[lists[at + 8]], registers[lists[at + 9]]
    c, s = math.cos(turn), math.sin(turn)
    if abs((x - cx) * c + (y - cy) * s) <= width / 2 and abs((y - cy) * c - (x - cx) * s) <= length / 2:
        return True
    across_x, across_y, along_x, along_y = width * c, width * s, -length * s, length * c
    px, py = cx - x + (across_x + along_x) / 2, cy - y + (across_y + along_y) / 2
    for side in range(4):
        dx, dy = (-across_x, -across_y) if side % 2 == 0 else (-along_x, -along_y)
        if side >= 2:
            dx, dy = -dx, -dy
        if in_sector(px, py, radius, heading, angle) or edge_meets_arc(px, py, dx, dy, radius, heading, angle):
            return True
        if edge_meets_ray(px, py, dx, dy, heading - angle / 2, radius):
            return True
        if edge_meets_ray(px, py, dx, dy, heading + angle / 2, radius):
            return True
        px, py = px + dx, py + dy
    return False


@kernel
def in_rings(registers, lists, at):
    """Return whether a point lies inside or on closed edges: a ray from it crosses them an odd number of times."""
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
    """Count how many of the rising numbers of a list are at most `value`."""
    count = 0
    while count < lists[at - 1] and registers[lists[at + count]] <= value:
        count += 1
    return float(count)


@kernel
def quotient(x, coefficients):
    """Return a quotient of two polynomials, coefficients [2, K] of the highest power first."""
    top, bottom = 0.0, 0.0
    for i in range(coefficients.shape[1]):
        top = top * x + coefficients[0, i]
        bottom = bottom * x + coefficients[1, i]
    return top / bottom


@kernel
def quantile(uniform):
    """Return Φ⁻¹, by Wichura's algorithm AS 241 as in `values.formulas`."""
    uniform = min(max(uniform, LEAST_PROBABILITY), 1 - LEAST_PROBABILITY)
    centred = uniform - 0.5
    if abs(centred) <= 0.425:
        return centred * quotient(0.180625 - centred * centred, _CENTRE)
    tail = math.sqrt(-math.log(min(uniform, 1 - uniform)))
    outer = quotient(tail - 1.6, _MIDDLE) if tail <= 5 else quotient(tail - 5, _FAR)
    return outer if centred > 0 else -outer


@kernel
def sort_order(registers, out, keys, count):
    """Write the stable order of `count` keys: indices, the least key first."""
    for i in range(count):
        at = i
        while at > 0 and registers[keys + i] < registers[keys + int(registers[out + at - 1])]:
            registers[out + at] = registers[out + at - 1]
            at -= 1
        registers[out + at] = i


@kernel
def power(base, exponent):
    """Return base ** exponent and whether Python would give a real number."""
    if base == 0 and exponent < 0:
        return 0.0, False
    if base < 0 and exponent != math.floor(exponent):
        return 0.0, False
    result = np.float64(base) ** np.float64(exponent)
    return result, np.isfinite(result) or not np.isfinite(base) or not np.isfinite(exponent)
