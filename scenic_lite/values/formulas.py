"""Formulas of the plane and of the normal distribution, on arrays [N] or single numbers.

Scenes evaluate each formula on arrays; the virtual machine compiles the same formula for single numbers
(`dynamics.machine.vm_geometry`). Read next: `values.operations`, which turns the formulas into operations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

TURN = 2 * math.pi
ARC_SEGMENTS = 128  # number of segments in the polygon of a circle
CLOSENESS = 1e-9  # a point within this distance of a boundary belongs to it
# θ = ±1 truncates a normal value at the quantiles of this probability, about eight standard deviations.
LEAST_PROBABILITY = 2.0**-52


# ------------------------------------------------------------ the plane
def in_frame(dx: Any, dy: Any, heading: Any) -> tuple[Any, Any]:
    """Return a displacement in a frame rotated by `heading`."""
    c, s = np.cos(heading), np.sin(heading)
    return dx * c + dy * s, dy * c - dx * s


def in_rectangle(x: Any, y: Any, cx: Any, cy: Any, heading: Any, width: Any, length: Any) -> Any:
    """Return whether points are in an oriented rectangle, edges included; arrays [N] or scalars."""
    c, s = np.cos(heading), np.sin(heading)
    across, along = (x - cx) * c + (y - cy) * s, (y - cy) * c - (x - cx) * s
    return (abs(across) <= width / 2 + CLOSENESS) & (abs(along) <= length / 2 + CLOSENESS)


def in_sector(delta_x: Any, delta_y: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """Return whether points at (delta_x, delta_y) from the apex are in a sector; arrays [N] or scalars."""
    bearing = np.arctan2(delta_y, delta_x) - math.pi / 2 - heading
    turn = np.abs(bearing - TURN * np.rint(bearing / TURN))
    at_apex = (delta_x == 0) & (delta_y == 0)
    return (np.hypot(delta_x, delta_y) <= radius) & ((turn <= angle / 2) | at_apex)


def sector_meets_rectangle(
    x: Any, y: Any, radius: Any, heading: Any, angle: Any, cx: Any, cy: Any, turn: Any, width: Any, length: Any
) -> Any:
    """Return whether a sector (x, y, radius, heading, angle) meets a rectangle (x, y, heading, width, length).

    They meet if the rectangle contains the apex, the sector contains a corner, or an edge crosses the arc or one of
    the two straight sides. Arrays [N] or scalars.
    """
    c, s = np.cos(turn), np.sin(turn)
    local_x, local_y = in_frame(x - cx, y - cy, turn)
    meets = (np.abs(local_x) <= width / 2) & (np.abs(local_y) <= length / 2)
    across_x, across_y, along_x, along_y = c * width / 2, s * width / 2, -s * length / 2, c * length / 2
    px, py = cx - x + across_x - along_x, cy - y + across_y - along_y  # a corner relative to the apex
    for sign_x, sign_y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        qx, qy = cx - x + sign_x * across_x + sign_y * along_x, cy - y + sign_x * across_y + sign_y * along_y
        meets = meets | in_sector(qx, qy, radius, heading, angle)
        meets = meets | edge_meets_arc(px, py, qx, qy, radius, heading, angle)
        meets = meets | edge_meets_ray(px, py, qx, qy, heading - angle / 2, radius)
        meets = meets | edge_meets_ray(px, py, qx, qy, heading + angle / 2, radius)
        px, py = qx, qy
    return meets


def edge_meets_arc(px: Any, py: Any, qx: Any, qy: Any, radius: Any, heading: Any, angle: Any) -> Any:
    """Return whether a segment crosses the arc of a sector: radius `radius`, center at the origin."""
    dx, dy = qx - px, qy - py
    a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - radius * radius
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    meets: Any = False
    for sign in (-1.0, 1.0):
        t = (sign * root - b) / np.maximum(a, 1e-300)
        within = in_sector(px + t * dx, py + t * dy, radius * (1 + 1e-9), heading, angle)
        meets = meets | ((b * b >= a * c) & (t >= 0) & (t <= 1) & within)
    return meets


def edge_meets_ray(px: Any, py: Any, qx: Any, qy: Any, turn: Any, radius: Any) -> Any:
    """Return whether a segment crosses a straight side of a sector: from the origin, along heading `turn`."""
    ray_x, ray_y = -np.sin(turn), np.cos(turn)
    side_p, side_q = ray_x * py - ray_y * px, ray_x * qy - ray_y * qx
    along_p, along_q = ray_x * px + ray_y * py, ray_x * qx + ray_y * qy
    along = along_p + (along_q - along_p) * side_p / (side_p - side_q + (side_p == side_q))
    return (side_p * side_q <= 0) & (side_p != side_q) & (along >= 0) & (along <= radius)


def rectangles_meet(
    ax: Any, ay: Any, turn_a: Any, width_a: Any, length_a: Any,
    bx: Any, by: Any, turn_b: Any, width_b: Any, length_b: Any,
) -> Any:  # fmt: skip
    """Return whether two rectangles, each (x, y, heading, width, length), have a common point; touching counts.

    By the separating axis theorem, only their four axes need a test. Arrays of any common shape, or scalars.
    """
    ca, sa, cb, sb = np.cos(turn_a), np.sin(turn_a), np.cos(turn_b), np.sin(turn_b)
    c, s = abs(ca * cb + sa * sb), abs(sa * cb - ca * sb)  # absolute cosine and sine of the angle between them
    dx, dy = bx - ax, by - ay
    across_a, along_a, across_b, along_b = width_a / 2, length_a / 2, width_b / 2, length_b / 2
    return (
        (abs(dx * ca + dy * sa) <= across_a + across_b * c + along_b * s)
        & (abs(dy * ca - dx * sa) <= along_a + across_b * s + along_b * c)
        & (abs(dx * cb + dy * sb) <= across_b + across_a * c + along_a * s)
        & (abs(dy * cb - dx * sb) <= along_b + across_a * s + along_a * c)
    )


def edges_clear(edges: Any, corners: Any) -> Any:
    """Return whether no edge enters the interior of a rectangle: edges [E, 4], corners [8, N] -> [N].

    An edge stays outside exactly if the axes of the rectangle or the edge's own normal separate the two.
    """
    x, y = (corners[0] + corners[4]) / 2, (corners[1] + corners[5]) / 2
    across_x, across_y = (corners[0] - corners[2]) / 2, (corners[1] - corners[3]) / 2  # half the width
    along_x, along_y = (corners[2] - corners[4]) / 2, (corners[3] - corners[5]) / 2  # half the length
    clear = np.ones(len(x), dtype=bool)
    for start_x, start_y, end_x, end_y in edges:
        step_x, step_y = (end_x - start_x) / 2, (end_y - start_y) / 2
        dx, dy = (start_x + end_x) / 2 - x, (start_y + end_y) / 2 - y
        apart = np.zeros(len(x), dtype=bool)
        for side_x, side_y in ((across_x, across_y), (along_x, along_y)):
            square = side_x * side_x + side_y * side_y
            reach = square + np.abs(step_x * side_x + step_y * side_y)
            apart |= np.abs(dx * side_x + dy * side_y) >= reach - CLOSENESS * np.sqrt(square)
        reach = np.abs(across_x * step_y - across_y * step_x) + np.abs(along_x * step_y - along_y * step_x)
        apart |= np.abs(dx * step_y - dy * step_x) >= reach - CLOSENESS * np.hypot(step_x, step_y)
        clear &= apart
    return clear


def sector_rings(x: Any, y: Any, radius: Any, heading: Any, angle: Any, count: int = ARC_SEGMENTS) -> Any:
    """Return discs or sectors as closed polygons whose arcs are chords of equal length: [N] or scalars -> [N, K, 2]."""
    x, y, radius, heading, angle = np.broadcast_arrays(*np.atleast_1d(x, y, radius, heading, angle))
    turns = heading[:, None] + np.minimum(angle, TURN)[:, None] * np.linspace(-0.5, 0.5, count + 1)
    rim_x, rim_y = x[:, None] - radius[:, None] * np.sin(turns), y[:, None] + radius[:, None] * np.cos(turns)
    whole = angle >= TURN
    first_x, first_y = np.where(whole, rim_x[:, 0], x), np.where(whole, rim_y[:, 0], y)  # a sector starts at its apex
    xs, ys = np.column_stack([first_x, rim_x, first_x]), np.column_stack([first_y, rim_y, first_y])
    return np.stack([xs, ys], axis=-1)


# ------------------------------------------------------------ the normal distribution
def normal_cdf(z: float) -> float:
    """Return Φ(z), the probability of a standard normal value below z."""
    return 0.5 * math.erfc(-z / math.sqrt(2))


def normal_cdfs(z: Any) -> Any:
    """Return Φ of each element."""
    return 0.5 * np.array([math.erfc(-number / math.sqrt(2)) for number in z])


def normal_quantile(uniform: Any) -> Any:
    """Return Φ⁻¹ elementwise, by Wichura's algorithm AS 241 (Applied Statistics 37, 1988), accurate to 1e-15."""
    uniform = np.minimum(np.maximum(uniform, LEAST_PROBABILITY), 1 - LEAST_PROBABILITY)
    centered = uniform - 0.5
    inner = centered * rational(0.180625 - centered * centered, CENTER)
    tail = np.sqrt(-np.log(np.minimum(uniform, 1 - uniform)))
    outer = either(tail <= 5, rational(tail - 1.6, MIDDLE), rational(tail - 5, FAR))
    return either(np.abs(centered) <= 0.425, inner, np.copysign(outer, centered))


def either(condition: Any, first: Any, second: Any) -> Any:
    """Return `np.where`; the virtual machine replaces this function by a version for numbers."""
    return np.where(condition, first, second)


def rational(x: Any, coefficients: tuple[Sequence[float], Sequence[float]]) -> Any:
    """Return a quotient of two polynomials with coefficients from the highest power down."""
    return horner(x, coefficients[0]) / horner(x, coefficients[1])


def horner(x: Any, coefficients: Sequence[float]) -> Any:
    total: Any = 0.0
    for coefficient in coefficients:
        total = total * x + coefficient
    return total


CENTER = (
    (2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
     13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608),
    (5226.495278852545925, 28729.085735721942674, 39307.89580009271061, 21213.794301586595867,
     5394.1960214247511077, 687.1870074920579083, 42.313330701600911252, 1.0),
)  # fmt: skip
MIDDLE = (
    (7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177, 1.27045825245236838258,
     3.64784832476320460504, 5.7694972214606914055, 4.6303378461565452959, 1.42343711074968357734),
    (1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966, 0.14810397642748007459,
     0.68976733498510000455, 1.6763848301838038494, 2.05319162663775882187, 1.0),
)  # fmt: skip
FAR = (
    (2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386, 0.026532189526576123093,
     0.29656057182850489123, 1.7848265399172913358, 5.4637849111641143699, 6.6579046435011037772),
    (2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5, 7.868691311456132591e-4,
     0.0148753612908506148525, 0.13692988092273580531, 0.59983220655588793769, 1.0),
)  # fmt: skip
