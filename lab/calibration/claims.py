"""Measure a carrier running at a lone keeper in drawn scenes, and fit `CLAIM` and `FEET` (`skills/contacts.py`) to it.

A row is the first time that the keeper is near the ball of a running carrier. It contains the carrier's speed, the
speed across the keeper's reach, and whether the keeper is in the box. `lost` means that the keeper soon gets the ball
or knocks it off. Read next: `__main__.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import bernoulli, columns
from lab.calibration.scenes import Recording, record
from regista.envs.football.constants import DIRECTION_RIGHT, IDLE, RIGHT, SPRINT
from regista.envs.football.physics.pitch import in_box_of
from regista.envs.football.skills.contacts import CLAIM, FEET, Claim, Feet
from regista.envs.football.skills.saves import SAVE
from regista.envs.football.skills.tackles import STANDING

SCENE = """x = Range(40, 82)
y = Range(-10, 10)
ego = LeftCF at (x - 0.9) @ y, with allowCollisions True
LeftGK at -99 @ 0
RightGK at (x + Range(7, 17)) @ (y + Range(-3, 3)), with allowCollisions True
Ball at x @ y, with allowCollisions True
"""
STEPS, PLAYER, KEEPER = 44, 1, 2
NEAR, KNOCKED, SOON = 1.0, 5.0, 6  # m from the keeper to the ball, m/s by which it is knocked off, and steps until then
COLUMNS = ("speed", "swerve", "in_box", "lost")


def measure(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every meeting of a running carrier and the keeper."""
    rng = np.random.default_rng([seed, 6])
    keys = np.full((count, STEPS), IDLE)
    keys[:, 0] = DIRECTION_RIGHT
    keys[:, 1] = np.where(rng.random(count) < 0.5, SPRINT, IDLE)
    recording = record(SCENE, keys, engine, seed)
    rows = [meeting(recording, episode) for episode in range(count)]
    return [row for row in rows if row is not None]


def meeting(recording: Recording, episode: int) -> dict[str, Any] | None:
    """Return the meeting of an episode; None if no running carrier meets the keeper."""
    step = first_meeting(recording, episode, KEEPER)
    if step is None:
        return None
    run = recording.players[episode, step - 1, PLAYER, 2:]
    keeper = recording.players[episode, :, KEEPER]
    way = recording.ball[episode, step - 1, :2] - keeper[step - 1, :2]
    swerve = abs(run[0] * way[1] - run[1] * way[0]) / (np.linalg.norm(way) + 1e-9)
    in_box, lost = in_box_of(RIGHT, *keeper[step, :2]), is_lost(recording, episode, step, KEEPER)
    numbers = (round(float(np.linalg.norm(run)), 2), round(float(swerve), 2), int(in_box), int(lost))
    return dict(zip(COLUMNS, numbers, strict=True))


def first_meeting(recording: Recording, episode: int, other: int) -> int | None:
    """Return the first step in which an opponent is near the ball of a running carrier; None if there is none."""
    length = int(recording.lengths[episode])
    away = recording.ball[episode, :length, :2] - recording.players[episode, :length, other, :2]
    step = int(np.argmax(np.linalg.norm(away, axis=1) < NEAR))
    speed = np.linalg.norm(recording.players[episode, step - 1, PLAYER, 2:])
    return None if step == 0 or recording.owner[episode, step - 1] != PLAYER or speed < STANDING else step


def is_lost(recording: Recording, episode: int, step: int, other: int) -> bool:
    """Return whether the opponent soon has the ball or knocks it off, or the carrier loses it."""
    owner, length = recording.owner[episode], int(recording.lengths[episode])
    later = slice(step - 1, step + SOON)
    knocked = np.linalg.norm(np.diff(recording.ball[episode, later, 3:5], axis=0), axis=1) > KNOCKED
    gone = owner[min(step + SOON, length - 1)] != PLAYER and not recording.scored[episode]
    return bool(gone or knocked.any() or (owner[later] == other).any())


def prepare_box(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return speed, swerve, and whether the ball was lost, of meetings in the box `[R, 3]`."""
    table = np.column_stack(columns(rows, *COLUMNS))
    return table[table[:, 2] > 0][:, (0, 1, 3)]


def prepare_outside(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return speed, swerve, and whether the ball was lost, of meetings outside the box `[R, 3]`."""
    table = np.column_stack(columns(rows, *COLUMNS))
    return table[table[:, 2] == 0][:, (0, 1, 3)]


def claim_chances(law: Claim, seen: np.ndarray) -> np.ndarray:
    """Return the probability `[R]` that a keeper with hands gets the ball, at the skill of the measured keeper."""
    chance = np.minimum(law.sure - law.hurried * seen[:, 0], law.most) * (0.5 + 0.5 * SAVE.measured_skill)
    return np.clip(chance * np.maximum(1.0 - seen[:, 1] / law.swerve, 0.0), 0.0, 1.0)


def feet_chances(law: Feet, seen: np.ndarray) -> np.ndarray:
    """Return the probability `[R]` that a keeper without hands gets the ball, as in `contacts.claim`."""
    share = np.maximum(1.0 - seen[:, 1] / law.swerve, 0.0)
    return np.clip(law.chance * share * (2.0 - share), 0.0, 1.0)


def claim_losses(seen: np.ndarray, law: Claim) -> np.ndarray:
    """Return the losses `[R]` of a law, which assume that 2% of the meetings are mislabeled."""
    return bernoulli(0.02 + 0.96 * claim_chances(law, seen), seen[:, 2] > 0)


def feet_losses(seen: np.ndarray, law: Feet) -> np.ndarray:
    """Return the losses `[R]` of a law, which assume that 2% of the meetings are mislabeled."""
    return bernoulli(0.02 + 0.96 * feet_chances(law, seen), seen[:, 2] > 0)


def claim_summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the share of lost balls and the shipped law's prediction, by the carrier's speed."""
    told = {}
    for slow, fast in ((1.5, 4.0), (4.0, 5.5), (5.5, 6.5), (6.5, 9.0)):
        there = (seen[:, 0] >= slow) & (seen[:, 0] < fast)
        if there.any():
            law = claim_chances(CLAIM, seen[there]).mean()
            told[f"lost at {slow} to {fast} m/s"] = float(seen[there, 2].mean()), float(law)
    return told


def feet_summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the share of lost balls and the shipped law's prediction."""
    return {"lost outside the box": (float(seen[:, 2].mean()), float(feet_chances(FEET, seen).mean()))}
