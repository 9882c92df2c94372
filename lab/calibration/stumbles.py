"""Measure two players put in one place, and fit how they stumble apart (`physics/bodies.py`, `STUMBLE`).

Two teammates begin an episode in one place, far from the ball. A row describes the first steps: the speed of the player
who stumbles farther, and the sideways distance of the other player. The duration follows from the speeds that the
summary prints for each step. Read next: `__main__.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from lab.calibration.regression import columns, squares
from lab.calibration.scenes import record
from regista.envs.football.constants import IDLE, STEP
from regista.envs.football.physics.bodies import STEPS_ASIDE, STUMBLE, STUMBLE_SPEED
from regista.envs.football.physics.motion import FALL_FRICTION

SCENE = """ego = LeftCF at Range(0, 30) @ Range(-20, 20), with allowCollisions True
LeftCM at ego.position, with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
Ball at 60 @ 30, with allowCollisions True
"""
PAIR, STEPS = slice(1, 3), 8
SHOWN = range(1, 7)  # steps
COLUMNS = (*(f"speed_{step}" for step in SHOWN), "aside")
SPREADS = (0.4, 0.05)  # m/s, m


class Stumble(NamedTuple):
    """The numbers of the law."""

    speed: float = STUMBLE_SPEED  # m/s
    aside: float = STEPS_ASIDE  # m


def measure(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for each."""
    recording = record(SCENE, np.full((count, STEPS), IDLE), engine, seed)
    rows = []
    for people in recording.players[:, :, PAIR]:
        away = np.linalg.norm(people[2, :, :2] - people[0, :, :2], axis=1)
        first = int(np.argmax(away))
        speeds = np.linalg.norm(people[1 : 1 + len(SHOWN), first, 2:], axis=1)
        aside = np.linalg.norm(people[1, 1 - first, :2] - people[0, 1 - first, :2])
        numbers = [round(float(number), 2) for number in (*speeds, aside)]
        rows.append(dict(zip(COLUMNS, numbers, strict=True)))
    return rows


def prepare(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return speeds and the sideways distance `[R, 7]`."""
    return np.column_stack(columns(rows, *COLUMNS))


def losses(seen: np.ndarray, law: Stumble) -> np.ndarray:
    """Return the losses `[R]` of a law: of the speeds while the player lies, and of the other's sideways distance."""
    lies = np.arange(round(STUMBLE / STEP))
    off = seen[:, : len(lies)] - np.maximum(law.speed - FALL_FRICTION * STEP * lies, 0.0)
    return squares(off, SPREADS[0]).sum(1) + squares(seen[:, -1] - law.aside, SPREADS[1])


def summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the median speed after each step, and the shipped law's prediction while the player lies (then 0)."""
    told = {}
    for step in SHOWN:
        law = STUMBLE_SPEED - FALL_FRICTION * STEP * (step - 1) if step * STEP <= STUMBLE + 1e-9 else 0.0
        told[f"m/s after {step * STEP:.1f} s"] = float(np.median(seen[:, step - 1])), law
    return told
