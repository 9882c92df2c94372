"""Fit which shots a keeper catches (`HOLD`) and how parried balls leave the hands (`PARRY`, `skills/hands.py`).

Both are fitted to the saves among the shots of `shots_at_keeper.py`: a ball is held if the keeper is reported to own it
within three steps. The loss for parries is robust to outliers, such as balls that hit another body. Of `HOLD`, only the
share of balls held among those easy enough to hold is fitted; the other numbers are corners of the law. Read next:
`touches.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import bernoulli, columns
from lab.calibration.shots_at_keeper import MET
from regista.envs.football.skills.hands import HOLD, PARRY, Hold, Parry
from regista.envs.football.skills.saves import SAVE

SPREAD = 2.0  # m/s, of one component of a parried ball's velocity


def meetings(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return the columns `MET` `[R, 10]` of saves for which the keeper had enough time."""
    met = [row for row in rows if str(row["held"]) != ""]
    table = np.column_stack(columns(met, *MET))
    return table[table[:, 0] > SAVE.sudden]


def hold_chances(law: Hold, met: np.ndarray) -> np.ndarray:
    """Return the probability `[R]` that a shot is caught, as in `hands.is_caught`."""
    age, speed = met[:, 0], met[:, 1]
    fresh = np.maximum(1.0 - age / law.age, 0.0) ** law.surprise
    ease = (1.0 - speed / law.top_speed) * (1.0 - fresh)
    surely = (ease - law.from_ease) / max(law.surely - law.from_ease, 1e-2)
    return np.where(ease < law.from_ease, 0.0, np.clip(law.fits + (1.0 - law.fits) * surely, 0.0, 1.0))


def hold_losses(met: np.ndarray, law: Hold) -> np.ndarray:
    """Return the losses `[R]` of a law, which assume that 2% of the shots are mislabeled."""
    return bernoulli(0.02 + 0.96 * hold_chances(law, met), met[:, 9] > 0)


def parried(law: Parry, met: np.ndarray) -> np.ndarray:
    """Return the mean velocity `[R, 2]` of parried balls at the right team's goal, as in `hands.knock_out`."""
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
    """Return the share of held balls and the shipped law's prediction, by s since the kick."""
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
    """Return the median speed of parried balls and the shipped law's prediction."""
    loose = met[met[:, 9] == 0]
    speeds = [float(np.median(np.linalg.norm(ball, axis=1))) for ball in (loose[:, 6:8], parried(PARRY, loose))]
    return {"median speed of parried balls, m/s": (speeds[0], speeds[1])}
