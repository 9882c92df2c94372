"""Lengths in the plane, by a formula that gives the same bits compiled and uncompiled.

(`math.hypot` does not: CPython and the C library round it differently.)
"""

from __future__ import annotations

import math

from regista.kernels.jit import kernel


@kernel
def length(x, y):
    """Return the length of the vector (x, y)."""
    return math.sqrt(x * x + y * y)


@kernel
def squared_apart(a, x, y):
    """Return the square of the distance in m from a player or the ball to (x, y)."""
    dx, dy = a.x - x, a.y - y
    return dx * dx + dy * dy


@kernel
def apart(a, b):
    """Return the distance in m between two players, or a player and the ball."""
    return length(a.x - b.x, a.y - b.y)


@kernel
def toward(x, y):
    """Return the unit vector along (x, y); the zero vector for the zero vector."""
    size = math.sqrt(x * x + y * y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)
