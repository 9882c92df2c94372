"""Measure a carrier running at a lone built-in back, and fit the back's odds (`skills/tackles.py`).

A row is the first time that the back is near the ball of a running carrier. It contains the carrier's speed, the
distance of the ball from the carrier's body, and whether the ball is lost 0.6 s later. The back's skill does
not vary. Read next: `claims.py`, which finds meetings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.claims import PLAYER, first_meeting, is_lost
from lab.calibration.regression import bernoulli, columns
from lab.calibration.scenes import record
from regista.envs.football.constants import DIRECTION_RIGHT, DRIBBLE, IDLE, SPRINT
from regista.envs.football.skills.saves import SAVE
from regista.envs.football.skills.tackles import TACKLE, Tackle

SCENE = """x = Range(-20, 40)
y = Range(-20, 20)
ego = LeftCF at (x - 0.9) @ y, with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
RightCB at (x + Range(5, 20)) @ (y + Range(-5, 5)), with allowCollisions True
Ball at x @ y, with allowCollisions True
"""
STEPS, BACK = 36, 3
COLUMNS = ("speed", "far", "lost")
SLOW, FAST = (1.5, 3.5, 5.0, 6.5), (3.5, 5.0, 6.5, 9.0)  # m/s


def measure(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every meeting of a running carrier and the back."""
    rng = np.random.default_rng([seed, 8])
    keys = np.full((count, STEPS), IDLE)
    keys[:, 0] = DIRECTION_RIGHT
    keys[:, 1] = rng.choice((IDLE, SPRINT, DRIBBLE), count)
    recording = record(SCENE, keys, engine, seed)
    rows = []
    for episode in range(count):
        step = first_meeting(recording, episode, BACK)
        if step is not None:
            carrier, ball = recording.players[episode, step - 1, PLAYER], recording.ball[episode, step - 1]
            speed, far = np.linalg.norm(carrier[2:]), np.linalg.norm(ball[:2] - carrier[:2])
            numbers = (round(float(speed), 2), round(float(far), 2), int(is_lost(recording, episode, step, BACK)))
            rows.append(dict(zip(COLUMNS, numbers, strict=True)))
    return rows


def prepare(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return speed, m from carrier to ball, and whether the ball was lost, of meetings `[R, 3]`."""
    return np.column_stack(columns(rows, *COLUMNS))


def chances(law: Tackle, seen: np.ndarray) -> np.ndarray:
    """Return the probability `[R]` that the back wins, at the measured skill, as in `tackles.chance_of_built_in`."""
    chance = law.built_in - law.built_in_hurried * seen[:, 0] + law.built_in_far * seen[:, 1]
    skilled = law.built_in_least + law.built_in_skill * SAVE.measured_skill
    return np.clip(np.minimum(chance, law.built_in_most) * skilled, 0.0, 1.0)


def losses(seen: np.ndarray, law: Tackle) -> np.ndarray:
    """Return the losses `[R]` of a law, which assume that 2% of the meetings are mislabeled."""
    return bernoulli(0.02 + 0.96 * chances(law, seen), seen[:, 2] > 0)


def summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the share of lost balls and the shipped law's prediction, by the carrier's speed."""
    told = {}
    for slow, fast in zip(SLOW, FAST, strict=True):
        there = (seen[:, 0] >= slow) & (seen[:, 0] < fast)
        if there.any():
            told[f"lost at {slow} to {fast} m/s"] = (
                float(seen[there, 2].mean()),
                float(chances(TACKLE, seen[there]).mean()),
            )
    return told
