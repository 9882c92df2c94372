"""Fit the numbers of a law to rows of measurements, with standard errors, by NumPy alone.

A law gives the loss of each row: its negative log likelihood, or half of a squared residual in units of its spread.
`fit` minimizes their sum by scoring steps (Berndt, Hall, Hall & Hausman 1974), damped until the sum decreases. Standard
errors come from the sandwich formula. A number that no row identifies has an infinite error. Read next: `saves.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Losses = Callable[[np.ndarray], np.ndarray]  # numbers [K] -> losses [R]
ROUNDS, RELATIVE_STEP, LEAST_STEP = 200, 1e-4, 1e-5
DAMPING, MOST_DAMPING, ENOUGH = 1e-3, 1e9, 1e-7
LIKELY = 1e-6  # smallest probability of an observed outcome, so that a law that excludes it has a finite loss


@dataclass(frozen=True)
class Fit:
    """Fitted numbers `[K]`, their standard errors `[K]`, and the sum of losses at these numbers."""

    values: np.ndarray
    errors: np.ndarray
    loss: float


def bernoulli(chance: np.ndarray, happened: np.ndarray) -> np.ndarray:
    """Return the negative log likelihood `[R]` of the outcomes under these probabilities."""
    sure = np.clip(chance, LIKELY, 1.0 - LIKELY)
    return -np.where(np.asarray(happened, bool), np.log(sure), np.log(1.0 - sure))


def binomial(chance: np.ndarray, share: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return the negative log likelihood `[R]` of shares of `count` trials."""
    sure = np.clip(chance, LIKELY, 1.0 - LIKELY)
    return -count * (share * np.log(sure) + (1.0 - share) * np.log(1.0 - sure))


def squares(residuals: np.ndarray, spread: float) -> np.ndarray:
    """Return half of the squared residuals `[R]` in units of their spread."""
    return 0.5 * (residuals / spread) ** 2


def slopes(losses: Losses, values: np.ndarray) -> np.ndarray:
    """Return the derivatives of each row's loss by each number, `[R, K]`, by central differences."""
    columns = []
    for k in range(len(values)):
        step = np.zeros(len(values))
        step[k] = max(RELATIVE_STEP * abs(values[k]), LEAST_STEP)
        columns.append((losses(values + step) - losses(values - step)) / (2.0 * step[k]))
    return np.stack(columns, 1)


def fit(losses: Losses, start: Sequence[float], least: float = -np.inf) -> Fit:
    """Minimize the sum of losses from `start`, with every number at least `least`.

    Raises ValueError if the losses at the start are not finite.
    """
    values, damping = np.array(start, float), DAMPING
    now = float(losses(values).sum())
    if not np.isfinite(now):
        raise ValueError(f"the losses at the start {list(start)} must be finite, their sum is {now}")
    for _ in range(ROUNDS):
        slope = slopes(losses, values)
        bend, pull = slope.T @ slope, slope.sum(0)
        gained = 0.0
        while damping < MOST_DAMPING and gained <= 0.0:
            scale = np.diag(np.diag(bend) * damping + 1e-12)
            there = np.maximum(values - np.linalg.solve(bend + scale, pull), least)
            new = float(losses(there).sum())
            gained = now - new if np.isfinite(new) else 0.0
            damping *= 0.3 if gained > 0.0 else 4.0
        if gained <= 0.0:
            break
        values, now = there, new
        if gained < ENOUGH * (1.0 + abs(now)):
            break
        damping = max(damping, 1e-9)
    return Fit(values, errors(losses, values), now)


def errors(losses: Losses, values: np.ndarray) -> np.ndarray:
    """Return the standard errors `[K]` at the minimum, by the sandwich formula; inf for unidentified numbers.

    If the sum is not convex at the minimum, as at a corner of a law, the outer product of the slopes takes its place.
    """
    slope = slopes(losses, values)
    spread, bend = slope.T @ slope, np.zeros((len(values), len(values)))
    for k in range(len(values)):
        step = np.zeros(len(values))
        step[k] = max(0.01 * abs(values[k]), 1e-3)
        bend[k] = (slopes(losses, values + step) - slopes(losses, values - step)).sum(0) / (2.0 * step[k])
    bend = 0.5 * (bend + bend.T)
    told = np.diag(spread) > 1e-12
    found = np.full(len(values), np.inf)
    if told.any():
        part = np.ix_(told, told)
        upwards = np.linalg.eigvalsh(bend[part]).min() > 0.0
        inverse = np.linalg.pinv(bend[part] if upwards else spread[part], rcond=1e-10)
        covariance = inverse @ spread[part] @ inverse
        found[told] = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return found


def fit_fields(law: Any, names: Sequence[str], losses: Callable[[Any], np.ndarray], least: float = -np.inf) -> Fit:
    """Fit some fields of a named tuple, starting from their shipped values; `losses` takes the changed tuple."""

    def changed(values: np.ndarray) -> np.ndarray:
        return losses(law._replace(**dict(zip(names, values.tolist(), strict=True))))

    return fit(changed, [getattr(law, name) for name in names], least)


def columns(rows: Sequence[Mapping[str, Any]], *names: str) -> list[np.ndarray]:
    """Return columns of a table as arrays `[R]`."""
    return [np.array([float(row[name]) for row in rows]) for name in names]
