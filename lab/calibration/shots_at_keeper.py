"""Measure shots at a keeper in drawn scenes, the data for the odds of a save (`skills/saves.py`, `SAVE`).

A lone striker 3 to 30 m before the goal runs in a drawn direction and shoots; the keeper starts on the line or up to 10
m before it. A row is a shot on target when it is first seen off the foot, `flown` s after the kick. It contains the
velocity one step later, and how the keeper met the shot. Read next: `saves.py`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lab.calibration.scenes import Recording, kick_time, record
from lab.grf.keeper import DIRECTIONS, KICKED, SLOWEST, cross_line
from regista.envs.football.constants import GOAL_HALF_WIDTH, GOAL_HEIGHT, HALF_LENGTH, IDLE, SHOT

SCENE = """x = Range(44, 96)
y = Range(-13, 13)
ego = LeftCF at (x - 0.9) @ y, with allowCollisions True
LeftGK at -99 @ 0
RightGK at Range(80, 99) @ Range(-5, 5), with allowCollisions True
Ball at x @ y, with allowCollisions True
"""
STEPS, LONGEST_RUN, LONGEST_PRESS = 42, 9, 4
STRIKER, KEEPER = 1, 2
DEFLECTED = 5.0  # m/s of lost speed or of sideways speed one step later: the ball has hit a player
COLUMNS = (
    *("flown", "x", "y", "z", "vx", "vy", "vz", "later_vx", "later_vy"),
    *("keeper_x", "keeper_y", "keeper_vx", "keeper_vy", "goal"),
)
MET = ("age", "speed", "run_vx", "run_vy", "came_vx", "came_vy", "after_vx", "after_vy", "after_vz", "held")  # of saves
HELD_WITHIN = 3  # steps


def measure(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every shot on target."""
    rng = np.random.default_rng([seed, 1])
    recording = record(SCENE, draw_keys(rng, count), engine, seed)
    rows = [shot_row(recording, episode) for episode in range(count)]
    return [row for row in rows if row is not None]


def draw_keys(rng: np.random.Generator, count: int) -> np.ndarray:
    """Draw actions `[count, STEPS]`: a direction for some steps, then shot."""
    keys = np.full((count, STEPS), IDLE)
    for row in keys:
        row[0] = rng.choice(DIRECTIONS)
        pressed = int(rng.integers(1, LONGEST_RUN))
        row[pressed : pressed + int(rng.integers(1, LONGEST_PRESS + 1))] = SHOT
    return keys


def shot_row(recording: Recording, episode: int) -> dict[str, Any] | None:
    """Return the shot of an episode as it left the foot; None if no shot is on target."""
    ball, length = recording.ball[episode], int(recording.lengths[episode])
    fast = np.hypot(ball[:length, 3], ball[:length, 4]) > KICKED
    step = int(np.argmax(fast))
    if not fast.any() or step == 0 or ball[step, 3] <= 0.0:
        return None
    goal = bool(recording.scored[episode])
    crossing = cross_line(ball[step : step + 1, :3], ball[step : step + 1, 3:])[0]
    aimed = abs(crossing[0]) < GOAL_HALF_WIDTH and crossing[1] < GOAL_HEIGHT and crossing[2] < SLOWEST
    if not goal and not (aimed and met(ball[step:length], recording.players[episode, step:length, KEEPER])):
        return None
    flown = kick_time(recording, episode, step)
    keeper = recording.players[episode, step, KEEPER]
    later = ball[min(step + 1, length - 1), 3:5]
    free = float(np.linalg.norm(later - ball[step, 3:5])) < DEFLECTED
    numbers = [flown, *ball[step], *(later if free else ball[step, 3:5]), *keeper]
    row = dict(zip(COLUMNS, [*(round(float(number), 2) for number in numbers), int(goal)], strict=True))
    return row | meeting(recording, episode, step, flown) if not goal else row | dict.fromkeys(MET, "")


def meeting(recording: Recording, episode: int, step: int, flown: float) -> dict[str, Any]:
    """Return how the keeper meets a shot that is first seen at `step`.

    It has the s since the kick, the velocities before and after, and whether the keeper's hands hold the ball soon.
    """
    length = int(recording.lengths[episode])
    ball, keeper = recording.ball[episode, :length], recording.players[episode, :length, KEEPER]
    turned = np.linalg.norm(np.diff(ball[step:, 3:5], axis=0), axis=1) > DEFLECTED
    if not turned.any():
        return dict.fromkeys(MET, "")
    met_at = step + int(np.argmax(turned))
    held = (recording.owner[episode, met_at : met_at + 1 + HELD_WITHIN] == KEEPER).any()
    numbers = [flown + 0.1 * (met_at - step) + 0.05, np.linalg.norm(ball[met_at, 3:5]), *keeper[met_at, 2:]]
    numbers += [*ball[met_at, 3:5], *ball[met_at + 1, 3:]]
    return dict(zip(MET, [*(round(float(number), 2) for number in numbers), int(held)], strict=True))


def met(ball: np.ndarray, keeper: np.ndarray) -> bool:
    """Return whether something stops or turns a ball `[T, 6]` before the goal line; otherwise the ball went wide.

    A ball that ends within 1 m of the keeper counts as stopped.
    """
    change = np.diff(ball[:, 3:5], axis=0)
    turned = np.linalg.norm(change, axis=1) > DEFLECTED
    inside = ball[:-1, 0] < HALF_LENGTH
    return bool((turned & inside).any()) or bool(np.linalg.norm(ball[-1, :2] - keeper[-1, :2]) < 1.0)
