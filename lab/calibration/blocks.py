"""Measure shots past a lone back in drawn scenes, and fit `BLOCK` (`skills/blocks.py`) to them.

A striker 15 to 30 m before the goal shoots with a back 0.8 to 5 m in front. The undisturbed direction of a shot is
estimated from the shots that no player meets: a line through their directions over the direction of the goal. A row
contains the distance at which the shot would pass the back, the time since the kick, and whether it was stopped. The
fit is by maximum likelihood. `leg_until` and `leg_gone`, the corners of the law, are held fixed. The rebound of a
stopped shot is not fitted. Read next: `__main__.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import bernoulli, columns
from lab.calibration.scenes import Recording, record
from lab.grf.blocks import KICKED, ONWARD, WAITS
from regista.envs.football.constants import DIRECTION_RIGHT, HALF_LENGTH, IDLE, SHOT
from regista.envs.football.skills.blocks import BLOCK, Block

SCENE = """x = Range(45, 72)
y = Range(-18, 18)
ego = LeftCF at (x - 1) @ y, with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
RightCB at (x + Range(1, 9)) @ (y + Range(-3.5, 3.5)), with allowCollisions True
Ball at x @ y, with allowCollisions True
"""
STEPS, LONGEST_RUN = 22, 7
STRIKER, BACK = 1, 3
LAW, NAMES = BLOCK, ("body", "body_edge", "leg", "leg_most", "body_most")
HALF_STEP = 0.05  # s since the kick on average, if the exact time is unknown
YOUNGEST = 0.02  # s: a back already at the ball has mostly just tried for it, and cannot try again
FARTHEST = 2.0  # m from the back; shots that pass farther away carry no information


def measure(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every shot that comes near the back in time."""
    rng = np.random.default_rng([seed, 2])
    keys = np.full((count, STEPS), IDLE)
    keys[:, 0] = DIRECTION_RIGHT
    keys[np.arange(count), rng.integers(1, LONGEST_RUN + 1, count)] = SHOT
    recording = record(SCENE, keys, engine, seed)
    kicks = [kick(recording, episode) for episode in range(count)]
    found = [(episode, *each) for episode, each in enumerate(kicks) if each is not None]
    line, speed = directions(recording, found)
    rows = [row(recording, episode, step, stopped, line, speed) for episode, step, stopped in found]
    return [each for each in rows if YOUNGEST < each["age"] < BLOCK.until and each["distance"] < FARTHEST]


def kick(recording: Recording, episode: int) -> tuple[int, bool] | None:
    """Return the step before which the ball first leaves the foot, and whether it is stopped within two steps.

    None if the ball is not kicked, or the back has it first.
    """
    ball, length = recording.ball[episode], int(recording.lengths[episode])
    pressed = int(np.argmax(recording.keys[episode] == SHOT))
    speed = np.hypot(ball[:, 3], ball[:, 4])
    for step in range(pressed + 1, min(length, pressed + WAITS + 2)):
        if recording.owner[episode, step - 1] not in (STRIKER, -1):
            return None
        if speed[step] - speed[step - 1] > KICKED:
            striker, back = recording.players[episode, step - 1, (STRIKER, BACK), :2]
            away = ball[step - 1, :2]
            if np.linalg.norm(away - striker) > np.linalg.norm(away - back) or recording.owner[episode, step] == BACK:
                return None
            return step, bool(ball[min(step + 2, length - 1), 3] <= ONWARD)
    return None


def directions(recording: Recording, found: Sequence[tuple[int, int, bool]]) -> tuple[np.ndarray, float]:
    """Return the line `[2]` of the shots' directions over the goal's, in rad, and their mean speed.

    Only shots that pass the back are used.
    """
    passed = [(episode, step) for episode, step, stopped in found if not stopped]
    ball = np.array([recording.ball[episode, step] for episode, step in passed])
    line = np.polyfit(to_goal(ball), np.arctan2(ball[:, 4], ball[:, 3]), 1)
    return line, float(np.hypot(ball[:, 3], ball[:, 4]).mean())


def to_goal(ball: np.ndarray) -> np.ndarray:
    """Return the direction in rad from balls `[..., 6]` to the middle of the goal."""
    return np.arctan2(-ball[..., 1], HALF_LENGTH - ball[..., 0])


def row(
    recording: Recording, episode: int, step: int, stopped: bool, line: np.ndarray, speed: float
) -> dict[str, float]:
    """Return the distance in m at which a shot would pass the back, the s since the kick, and whether it is stopped."""
    ball, back = recording.ball[episode, step - 1], recording.players[episode, step - 1, BACK]
    angle = float(np.polyval(line, to_goal(ball)))
    velocity = speed * np.array([np.cos(angle), np.sin(angle)]) - back[2:]
    away = ball[:2] - back[:2] + HALF_STEP * (ball[3:5] - back[2:])
    age = float(-(away @ velocity) / (velocity @ velocity))
    distance = float(np.linalg.norm(away + age * velocity))
    return {"distance": round(distance, 3), "age": round(age, 3), "stopped": int(stopped)}


def chances(law: Block, distance: np.ndarray, age: np.ndarray) -> np.ndarray:
    """Return the probability `[R]` that a shot is stopped, as in `blocks.block`."""
    leg = np.clip((law.leg_gone - age) / max(law.leg_gone - law.leg_until, 1e-3), 0.0, 1.0)
    edge, sure = law.body_edge + law.leg * leg, law.body + law.leg * leg * leg
    most = np.where(leg == 1.0, law.leg_most, law.body_most)
    return np.clip(most * np.minimum((edge - distance) / np.maximum(edge - sure, 1e-2), 1.0), 0.0, 1.0)


def prepare(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return distance, age, and whether the shot was stopped, of shots `[R, 3]`."""
    return np.column_stack(columns(rows, "distance", "age", "stopped"))


def losses(shots: np.ndarray, law: Block) -> np.ndarray:
    """Return the losses `[R]` of a law."""
    distance, age, stopped = shots.T
    return bernoulli(0.01 + 0.98 * chances(law, distance, age), stopped > 0)


def summary(shots: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the share of stopped shots and the shipped law's prediction, by m from the back and s since the kick."""
    told = {}
    for near, far in ((0.0, 0.3), (0.3, 0.6), (0.6, 1.0), (1.0, 1.5)):
        for young, old in ((0.02, 0.05), (0.05, 0.2)):
            there = (shots[:, 0] >= near) & (shots[:, 0] < far) & (shots[:, 1] >= young) & (shots[:, 1] < old)
            if there.any():
                law = chances(BLOCK, shots[there, 0], shots[there, 1]).mean()
                told[f"stopped, {near} to {far} m, {young} to {old} s"] = float(shots[there, 2].mean()), float(law)
    return told
