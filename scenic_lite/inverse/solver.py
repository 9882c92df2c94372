"""Draws that several equations decide together: a batched least-squares search over the unit cube.

Levenberg's method with differences for derivatives, from where `inversion` has left off and then from the best of many
points, since the equations may bend, fold and jump. Read next: `inverse.levels`, which calls it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

ROUNDS = 30  # of improvement from one start
STEP = 1e-6  # for differences, in the unit cube
CANDIDATES = 512  # points of the cube that are looked at for each scene
STARTS = 6  # of them that are improved
AT_ONCE = 1 << 16  # points that are evaluated at once

Residuals = Callable[[np.ndarray, np.ndarray], np.ndarray]  # unit [M, V], rows [M] -> [M, E], 0 where all is met


def solve(residuals: Residuals, start: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """The points of the unit cube where all residuals vanish.

    start [M, V], the residuals of scene m being those of its row. Returns the best points found [M, V], and which of
    them are good to `tolerance` [M].
    """
    rows = np.arange(len(start))
    best, error = improve(residuals, start, rows)
    left = np.flatnonzero(error > tolerance)
    cloud = candidates(start.shape[1])
    for chunk in np.array_split(left, -(-len(left) * len(cloud) // AT_ONCE) or 1):
        if len(chunk):
            for begin in promising(residuals, cloud, chunk):
                open_ = error[chunk] > tolerance
                if not open_.any():
                    break
                found, errors = improve(residuals, begin[open_], chunk[open_])
                better = errors < error[chunk[open_]]
                best[chunk[open_][better]], error[chunk[open_][better]] = found[better], errors[better]
    return best, error <= tolerance


def candidates(dimension: int) -> np.ndarray:
    """Points that fill the unit cube: evenly spaced in one dimension, else random, the same ones every time."""
    if dimension == 1:
        return (np.arange(CANDIDATES)[:, None] + 0.5) / CANDIDATES
    return np.random.default_rng(0).random((CANDIDATES, dimension))


def promising(residuals: Residuals, cloud: np.ndarray, rows: np.ndarray) -> list[np.ndarray]:
    """The best points of the cloud [C, V] for each of some rows [M]: one array [M, V] for each start."""
    points, repeated = np.tile(cloud, (len(rows), 1)), np.repeat(rows, len(cloud))
    errors = size_of(residuals(points, repeated)).reshape(len(rows), len(cloud))
    order = np.argsort(errors, axis=1, kind="stable")[:, :STARTS]
    return [cloud[order[:, k]] for k in range(order.shape[1])]


def improve(residuals: Residuals, start: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest minimum to each start [M, V], and how far from zero it is [M]."""
    point = start.copy()
    value = residuals(point, rows)
    error = size_of(value)
    damping = np.full(len(point), 1e-12)
    for _ in range(ROUNDS):
        open_ = np.flatnonzero((error > 1e-14) & (damping < 1e6))
        if not len(open_):
            break
        slope = derivatives(residuals, point[open_], rows[open_], value[open_])  # [M, E, V]
        trial = np.clip(point[open_] - step_of(slope, value[open_], damping[open_]), 0.0, 1.0)
        there = residuals(trial, rows[open_])
        errors = size_of(there)
        better = errors < error[open_]
        kept = open_[better]
        point[kept], value[kept], error[kept] = trial[better], there[better], errors[better]
        damping[open_] = np.where(better, damping[open_] * 0.1, np.maximum(damping[open_] * 100.0, 1e-8))
    return point, error


def step_of(slope: np.ndarray, value: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """The damped least-squares step [M, V]."""
    square = np.einsum("mev,mew->mvw", slope, slope)
    scale = np.maximum(np.einsum("mvv->m", square), 1e-30)
    square += (damping * scale + 1e-15 * scale)[:, None, None] * np.eye(slope.shape[2])
    return np.linalg.solve(square, np.einsum("mev,me->mv", slope, value)[..., None])[..., 0]


def derivatives(residuals: Residuals, point: np.ndarray, rows: np.ndarray, value: np.ndarray) -> np.ndarray:
    """How the residuals change with each coordinate: [M, E, V]; steps lead into the cube."""
    step = np.where(point > 0.5, -STEP, STEP)  # [M, V]
    columns: list[Any] = []
    for v in range(point.shape[1]):
        moved = point.copy()
        moved[:, v] += step[:, v]
        columns.append((residuals(moved, rows) - value) / step[:, v : v + 1])
    return np.stack(columns, axis=2)


def size_of(value: np.ndarray) -> np.ndarray:
    """The largest residual of each row; infinite where one is nan."""
    size = np.abs(value).max(axis=1, initial=0.0)
    return np.where(np.isnan(size), np.inf, size)
