"""Measure first touches in drawn scenes, and fit `AT_REST` and `BRING_DOWN` (`skills/first_touch.py`) to them.

`balls_at_rest`: a player runs to a ball 1 to 4 m ahead, and changes direction before reaching it. `passes_received`: a
teammate passes to a player who runs in some direction. A row is the first touch. It contains the velocities in the
steps before and after it, in the frame of the direction action (`along` it, `aside` to its left). They are seen 0.1 to
0.2 s after the touch, when GRF's bodies have completed it. Read next: `__main__.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import columns
from lab.calibration.scenes import Recording, record
from regista.envs.football.constants import DIRECTION_RIGHT, DIRECTION_X, DIRECTION_Y, IDLE, SHORT_PASS
from regista.envs.football.skills.first_touch import AT_REST, BRING_DOWN, AtRest, BringDown

REST = """ego = LeftCF at 0 @ Range(-10, 10), with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
Ball at Range(2, 7) @ (ego.position.y + Range(-0.5, 0.5)), with allowCollisions True
"""
PASS = """ego = LeftCF at 0 @ 0, with allowCollisions True
LeftCF at Range(-40, 40) @ Range(-30, 30), with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
Ball at 1.2 @ 0, with allowCollisions True
"""
PLAYER, MATE = 1, 2
TURNS = (2, 3, 7, 8)  # directions to the side and slightly back, for a player who runs ahead
STEPS_REST, STEPS_PASS = 22, 36
AFTER = 1  # steps since the touch was first seen
MOVES, CHANGES, NEAR = 0.4, 2.5, 1.6  # m/s of a moving ball, change in m/s of a touched ball, and m to the player
COLUMNS = ("run_along", "run_aside", "came", "body_along", "body_aside", "ball_along", "ball_aside")
SPREAD = 0.5  # m/s


def balls_at_rest(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every first touch of a ball at rest by a player with a direction."""
    rng = np.random.default_rng([seed, 3])
    keys = np.full((count, STEPS_REST), IDLE)
    keys[:, 0] = DIRECTION_RIGHT
    keys[np.arange(count), rng.integers(2, 9, count)] = rng.choice(TURNS, count)
    recording = record(REST, keys, engine, seed)
    rows = []
    for episode in range(count):
        speed = np.hypot(*recording.ball[episode, :, 3:5].T)
        step = int(np.argmax(speed > MOVES))
        if 1 < step < recording.lengths[episode] - AFTER:
            rows.append(touch(recording, episode, step, PLAYER, held(keys[episode, : step - 1])))
    return rows


def passes_received(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every pass that the teammate brings down."""
    rng = np.random.default_rng([seed, 4])
    keys = np.repeat(rng.integers(1, 9, (count, 1)), STEPS_PASS, axis=1)
    keys[:, 0], keys[:, 1], keys[:, 2:9] = IDLE, SHORT_PASS, IDLE
    recording = record(PASS, keys, engine, seed)
    rows = []
    for episode in range(count):
        step = received(recording, episode)
        if step is not None:
            rows.append(touch(recording, episode, step, MATE, int(keys[episode, -1])))
    return rows


def held(pressed: np.ndarray) -> int:
    """Return the direction that remains held after these actions."""
    directions = pressed[(pressed >= 1) & (pressed <= 8)]
    return int(directions[-1])


def received(recording: Recording, episode: int) -> int | None:
    """Return the step before which the teammate first touches the pass; None if that never happens."""
    ball, mate = recording.ball[episode], recording.players[episode, :, MATE]
    for step in range(12, int(recording.lengths[episode]) - AFTER):
        near = np.linalg.norm(ball[step, :2] - mate[step, :2]) < NEAR
        if near and np.linalg.norm(ball[step, 3:5] - ball[step - 1, 3:5]) > CHANGES:
            return step
    return None


def touch(recording: Recording, episode: int, step: int, player: int, key: int) -> dict[str, Any]:
    """Return the velocities around a touch in the direction's frame; `came` is the ball's speed seen by the player."""
    ahead = np.array([DIRECTION_X[key], DIRECTION_Y[key]])
    frame = np.stack([ahead, (-ahead[1], ahead[0])])
    later = step + AFTER
    before, after = recording.players[episode, step - 1, player, 2:], recording.players[episode, later, player, 2:]
    came = np.linalg.norm(recording.ball[episode, step - 1, 3:5] - before)
    numbers = [*(frame @ before), came, *(frame @ after), *(frame @ recording.ball[episode, later, 3:5])]
    return {name: round(float(number), 2) for name, number in zip(COLUMNS, numbers, strict=True)}


def prepare_rest(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return touches `[R, 7]` within a stride: to the side or slightly back, as in `first_touch.in_stride`."""
    table = np.column_stack(columns(rows, *COLUMNS))
    speed = np.hypot(table[:, 0], table[:, 1])
    return table[(speed > 1.0) & (table[:, 0] < -0.01 * speed) & (table[:, 0] > AT_REST.stride_cosine * speed)]


def rest_law(law: AtRest, seen: np.ndarray) -> np.ndarray:
    """Return velocities after the touch `[R, 4]`: body along and aside, ball along and aside."""
    along, aside = seen[:, 0], seen[:, 1]
    speed = np.hypot(along, aside)
    share = np.minimum(law.aside_most / (np.abs(aside) + 1e-9), law.aside_kept)
    pace = law.pace + law.pace_turned * along / speed + law.pace_kept * along
    return np.stack([pace, share * aside, np.full(len(seen), law.stride_ball), np.zeros(len(seen))], 1)


def prepare_pass(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return touches `[R, 7]` of fast balls by players who do not turn back."""
    table = np.column_stack(columns(rows, *COLUMNS))
    back = (table[:, 0] < 0.0) & (np.hypot(table[:, 0], table[:, 1]) > BRING_DOWN.back_from)
    return table[(table[:, 2] > BRING_DOWN.hard) & ~back]


def pass_law(law: BringDown, seen: np.ndarray) -> np.ndarray:
    """Return velocities after the touch `[R, 4]`, as in `first_touch.bring_down`."""
    along, aside = seen[:, 0], seen[:, 1]
    speed = np.hypot(along, aside)
    along = np.where(along < 0.0, law.back_slow * along, along)
    along = along + np.maximum(law.gains - law.gains_less * speed, law.gains_least)
    aside = (law.aside_left + law.aside_more * speed) * aside
    keep = np.minimum(law.most / (np.hypot(along, aside) + 1e-9), 1.0)
    ahead = np.maximum(law.ahead - law.ahead_less * speed, law.ahead_least)
    return np.stack([keep * along, keep * aside, keep * along + ahead, keep * aside], 1)


def losses_of(predicted: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return losses `[R]` that are robust to outliers."""
    return np.log1p((((predicted - seen[:, 3:]) / SPREAD) ** 2).sum(1))


def rest_losses(seen: np.ndarray, law: AtRest) -> np.ndarray:
    """Return the losses `[R]` of a law."""
    return losses_of(rest_law(law, seen), seen)


def pass_losses(seen: np.ndarray, law: BringDown) -> np.ndarray:
    """Return the losses `[R]` of a law."""
    return losses_of(pass_law(law, seen), seen)


def medians(seen: np.ndarray, predicted: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the median of each velocity after the touch, measured and from the shipped law."""
    return {
        f"median {name}, m/s": (float(np.median(seen[:, 3 + k])), float(np.median(predicted[:, k])))
        for k, name in enumerate(COLUMNS[3:])
    }


def rest_summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return medians, measured and from the shipped law."""
    return medians(seen, rest_law(AT_REST, seen))


def pass_summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return medians, measured and from the shipped law."""
    return medians(seen, pass_law(BRING_DOWN, seen))
