"""Fit which shots stick in a keeper's hands (`HOLD`) and how parried ones leave them (`PARRY`, `skills/hands.py`).

Both are fitted to the saves among the shots of `shots_at_keeper.py`: a ball is held if the keeper is reported to own
it within three steps. Parries are fitted with a loss that outliers do not rule, such as balls that meet another body.
Of `HOLD`, only how often a ball is held whose ease allows it is fitted: the other numbers say where the law has
corners. Read next: `touches.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import bernoulli, columns
from lab.calibration.shots_at_keeper import MET
from regista.envs.football.skills.hands import HOLD, PARRY, Hold, Parry
from regista.envs.football.skills.saves import SAVE

SPREAD = 2.0  # m/s of a component of a parried ball


def meetings(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return the columns `MET` `[R, 10]` of saves that the keeper has had time for."""
    met = [row for row in rows if str(row["held"]) != ""]
    table = np.column_stack(columns(met, *MET))
    return table[table[:, 0] > SAVE.sudden]


def hold_chances(law: Hold, met: np.ndarray) -> np.ndarray:
    """Return the chance `[R]` that shots stick, as `hands.is_caught` has it."""
    age, speed = met[:, 0], met[:, 1]
    fresh = np.maximum(1.0 - age / law.age, 0.0) ** law.surprise
    ease = (1.0 - speed / law.top_speed) * (1.0 - fresh)
    surely = (ease - law.from_ease) / max(law.surely - law.from_ease, 1e-2)
    return np.where(ease < law.from_ease, 0.0, np.clip(law.fits + (1.0 - law.fits) * surely, 0.0, 1.0))


def hold_losses(met: np.ndarray, law: Hold) -> np.ndarray:
    """Return the losses `[R]` of a law; one shot in fifty is taken for another."""
    return bernoulli(0.02 + 0.96 * hold_chances(law, met), met[:, 9] > 0)


def parried(law: Parry, met: np.ndarray) -> np.ndarray:
    """Return the mean velocity `[R, 2]` of parried balls, as `hands.knock_out` has it, at the right team's goal."""
    run, came = met[:, 2:4], met[:, 4:6]
    way = law.along * run - law.back * came + np.array([-law.out, 0.0])
    way /= np.linalg.norm(way, axis=1, keepdims=True) + 1e-9
    speed = law.ball * np.linalg.norm(came, axis=1) + law.run * np.linalg.norm(run, axis=1)
    return speed[:, None] * way


def parry_losses(met: np.ndarray, law: Parry) -> np.ndarray:
    """Return the losses `[R]` of a law, for balls that are not held."""
    loose = met[met[:, 9] == 0]
    off = (parried(law, loose) - loose[:, 6:8]) / SPREAD
    return np.log1p((off**2).sum(1))


def hold_summary(met: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the share that is held, and what the shipped law says, by the s since the kick."""
    told = {}
    for young, old in ((0.22, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 3.0)):
        there = (met[:, 0] >= young) & (met[:, 0] < old)
        if there.any():
            told[f"held, {young} to {old} s"] = (
                float(met[there, 9].mean()),
                float(hold_chances(HOLD, met[there]).mean()),
            )
    return told


def parry_summary(met: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the median speed of parried balls, and what the shipped law says."""
    loose = met[met[:, 9] == 0]
    speeds = [float(np.median(np.linalg.norm(ball, axis=1))) for ball in (loose[:, 6:8], parried(PARRY, loose))]
    return {"median speed of parried balls, m/s": (speeds[0], speeds[1])}
