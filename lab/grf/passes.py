"""Passes: the intended receiver, speed and height, and the time until the teammate has the ball.

Read next: `grf.shots`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance, by_share
from lab.grf.stage import METRES_X, METRES_Y, Stage, Trace, keys
from regista.envs.football.constants import (
    CM,
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_LEFT,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_LEFT,
    DIRECTION_RIGHT,
    DIRECTION_TOP,
    DIRECTION_TOP_LEFT,
    DIRECTION_TOP_RIGHT,
    GK,
    HIGH_PASS,
    IDLE,
    LONG_PASS,
    SHORT_PASS,
    STAND,
)
from regista.envs.football.kick_off import Roster

TITLE = "passes"
REQUIRED = 0.9
TOLERANCE = 0.1
REPEATS = 20
WATCHED = 60  # steps after the action
MOVING = 8.0  # m/s of a ball that has left the foot
KICKS = {"short": SHORT_PASS, "long": LONG_PASS, "high": HIGH_PASS}
DIRECTIONS = {
    "none": IDLE,
    "left": DIRECTION_LEFT,
    "top_left": DIRECTION_TOP_LEFT,
    "top": DIRECTION_TOP,
    "top_right": DIRECTION_TOP_RIGHT,
    "right": DIRECTION_RIGHT,
    "bottom_right": DIRECTION_BOTTOM_RIGHT,
    "bottom": DIRECTION_BOTTOM,
    "bottom_left": DIRECTION_BOTTOM_LEFT,
}
MATES = ((10, 0), (20, -10), (0, -15), (-10, 0), (0, 15), (20, 10))  # m from the passer, y downwards
PLACED_X, PLACED_Y = 1.011, 1.016  # GRF stretches the positions of players, not that of the ball
KEEPERS = ((-1.011, 0.0), (1.011, -0.4268))


def measure(effort: float = 1.0) -> list[Row]:
    """Compare delay, speed and time to reception of passes over 5 to 40 m, and the choice of the receiver."""
    repeats = max(int(REPEATS * effort), 2)
    rows = []
    for target in read_data("passes"):
        name = f"{target['kind']} pass, {target['distance']} m"
        trace = straight_pass(target["kind"], float(target["distance"]), repeats)
        rows += compare_pass(name, target, trace)
    for target in read_data("pass_choices"):
        name = f"{target['kind']} pass, keys {target['direction']}"
        chosen, delay = choice(target["kind"], target["direction"], repeats)
        wrong = float(np.mean(chosen != int(target["mate"])))
        rows.append(Row("passes", f"{name}: mate", float(np.median(chosen)), float(target["mate"]), "", wrong, 0.0))
        rows.append(by_share("passes", f"{name}: delay", delay, float(target["delay"]), "steps", 0.25))
    return rows


def compare_pass(name: str, target: dict[str, str], trace: Trace) -> list[Row]:
    """Return rows for one kind of pass over one distance."""
    start = first_moving(trace)
    matches = np.arange(len(start))
    speed = np.linalg.norm(trace.ball_velocity[start, matches, :2], axis=-1).mean()
    apex = np.mean([trace.ball[at : at + 30, k, 2].max() for k, at in enumerate(start)])
    measured = float(target["apex"])
    rows = [
        by_share("passes", f"{name}: delay", (start - 2).mean(), float(target["delay"]), "steps", TOLERANCE),
        by_share("passes", f"{name}: speed", speed, float(target["speed"]), "m/s", TOLERANCE),
        by_distance("passes", f"{name}: apex", float(apex), measured, "m", 0.1 + 0.1 * measured),
    ]
    if target["flight"]:
        flight = np.mean(reception(trace, start))
        rows.append(by_share("passes", f"{name}: flight", float(flight), float(target["flight"]), "steps", TOLERANCE))
    return rows


def straight_pass(kind: str, distance: float, repeats: int) -> Trace:
    """Let a standing player pass along +x to a teammate `distance` m ahead; the pass action is step 2."""
    x = -0.5 * PLACED_X
    places = [(x, 0.0), (x + distance / METRES_X, 0.0), *KEEPERS]
    stage = Stage(places, (-0.49, 0.0), Roster([0, 0, 0, 1], [CM, CM, GK, GK]), n=repeats)
    return stage.play(keys((IDLE, 1), (KICKS[kind], 1), (IDLE, WATCHED), others=(STAND,) * 3))


def first_moving(trace: Trace) -> np.ndarray:
    """Return the index [N] of the first row in which the ball is kicked, or of the last row."""
    fast = np.linalg.norm(trace.ball_velocity[..., :2], axis=-1) > MOVING
    return np.where(fast.any(axis=0), fast.argmax(axis=0), len(fast) - 1)


def reception(trace: Trace, start: np.ndarray) -> np.ndarray:
    """Return the steps [N] from the kick until another player has the ball, or until the end of the trace."""
    steps = []
    for k, at in enumerate(start):
        owned = trace.owner[at:, k] > 0
        steps.append(owned.argmax() if owned.any() else len(owned))
    return np.array(steps)


def choice(kind: str, direction: str, repeats: int) -> tuple[np.ndarray, float]:
    """Return the intended receivers, numbers [N] among MATES (-1 another player), and the mean delay."""
    places = [(0.0, 0.0), *((x / METRES_X, y / METRES_Y) for x, y in MATES), *KEEPERS]
    stage = Stage(places, (0.01, 0.0), Roster([0] * 8 + [1], [CM] * 7 + [GK] * 2), n=repeats)
    pressed = ((IDLE, 1), (DIRECTIONS[direction], 2), (KICKS[kind], 1))
    stage.play(keys(*pressed, others=(STAND,) * 8))
    chosen, delay = np.full(repeats, -1), np.zeros(repeats)
    for step in range(1, 15):
        stage.step([IDLE] + [STAND] * 8)
        ball = stage.matches["ball"]
        new = (delay == 0.0) & (np.hypot(ball["vx"], ball["vy"]) > MOVING)
        chosen[new], delay[new] = stage.matches["receiver"][new] - 1, step
    return np.where(chosen < len(MATES), chosen, -1), float(delay.mean())


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw speed, apex and time to reception over the distance, one panel per kind and number."""
    rows = {row.name: row for row in measure(effort)}
    panels = []
    for number, unit in (("speed", "m/s"), ("apex", "m"), ("flight", "steps")):
        for kind in KICKS:
            measured = [(d, rows.get(f"{kind} pass, {d} m: {number}")) for d in (5, 10, 15, 20, 30, 40)]
            over = [d for d, row in measured if row]
            grf, ours = ([getattr(row, side) for _, row in measured if row] for side in ("grf", "ours"))
            panels.append(Panel(f"{kind} pass: {number}", (over, grf), (over, ours), "m", unit))
    draw_panels(path, TITLE, panels, columns=3)
