"""Shots of a lone striker: delay until the kick, speed, and where their initial course meets the goal line.

Read next: `grf.keeper`, who faces them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.passes import DIRECTIONS, PLACED_X, PLACED_Y
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance, by_factor, by_share
from lab.grf.stage import METRES_Y, Stage, keys
from regista.envs.football.constants import CF, GK, HALF_LENGTH, IDLE, SHOT, STAND
from regista.envs.football.kick_off import Roster

TITLE = "shots"
REQUIRED = 0.8
SHARE = 0.1  # tolerance of speed and delay
UNITS = 0.015  # tolerance of the mean position on the goal line
FACTOR = 0.5  # tolerance of its spread: 1.5 times
REPEATS = 120
MOVING = 15.0  # m/s of a ball that has left the foot
TOP_SPEED, SHIRT = 7.83, 1  # of the player used in all of GRF's measurements


@dataclass(frozen=True)
class Shots:
    """Results of many shots: means, and `line_y` [N] in units, y downwards."""

    delay: float
    speed: float
    rise: float
    line_y: np.ndarray


def measure(effort: float = 1.0) -> list[Row]:
    """Compare delay, speed, mean position on the goal line and its spread in GRF's 104 conditions."""
    rows = []
    for name, target, shots in conditions(effort):
        mean, spread = float(np.mean(shots.line_y)), float(np.std(shots.line_y, ddof=1))
        rows += [
            by_share("shots", f"{name}: delay", shots.delay, float(target["delay"]), "steps", SHARE),
            by_share("shots", f"{name}: speed", shots.speed, float(target["speed"]), "m/s", SHARE),
            by_distance("shots", f"{name}: line y", mean, float(target["line_y"]), "units", UNITS),
            by_factor("shots", f"{name}: spread", spread, float(target["line_sd"]), "units", FACTOR),
        ]
    return rows


@cache
def conditions(effort: float) -> list[tuple[str, dict[str, str], Shots]]:
    """Return the name, GRF's numbers and our shots of every condition."""
    repeats = max(int(REPEATS * effort), 4)
    played = []
    for target in read_data("shots"):
        place = (float(target["x"]), float(target["y"]))
        before, presses = int(target["before"]), int(target["presses"])
        shots = shoot(place, target["direction"], before, presses, repeats)
        name = f"({target['x']}, {target['y']}) {target['direction']} for {before}, {presses} x shot"
        played.append((name, target, shots))
    return played


def shoot(place: tuple[float, float], direction: str, before: int, presses: int, repeats: int) -> Shots:
    """Let a striker at `place` with the ball in front hold a direction for `before` steps, shoot, and wait."""
    players = [(place[0] * PLACED_X, place[1] * PLACED_Y), (1.011, -0.4268)]
    stage = Stage(players, (place[0] + 0.01, place[1]), Roster([0, 1], [CF, GK]), n=repeats)
    stage.matches["players"]["shirt"][:, 0] = SHIRT
    stage.matches["players"]["top_speed"][:, 0] = TOP_SPEED
    trace = stage.play(keys((IDLE, 1), (DIRECTIONS[direction], before), (SHOT, presses), (IDLE, 14), others=(STAND,)))
    flat = np.linalg.norm(trace.ball_velocity[..., :2], axis=-1)
    shot = np.flatnonzero((flat > MOVING).any(axis=0))
    if len(shot) < 2:
        return Shots(np.nan, np.nan, np.nan, np.full(2, np.nan))
    start = (flat > MOVING).argmax(axis=0)[shot]
    ball, velocity = trace.ball[start, shot], trace.ball_velocity[start, shot]
    forward = np.where(velocity[:, 0] > 1.0, velocity[:, 0], np.nan)
    line_y = ball[:, 1] + (HALF_LENGTH - ball[:, 0]) / forward * velocity[:, 1]
    pressed = 2 + before  # row of the trace at the end of the step of the first shot action
    return Shots(
        float(np.mean(start - pressed)),
        float(flat[start, shot].mean()),
        float(velocity[:, 2].mean()),
        line_y[np.isfinite(line_y)] / -METRES_Y,
    )


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the four numbers and the rise, ours over GRF's: a dot per condition, and the diagonal."""
    played = conditions(effort)
    panels = []
    numbers = (
        ("delay", "steps", lambda shots: shots.delay),
        ("speed", "m/s", lambda shots: shots.speed),
        ("rise", "m/s", lambda shots: shots.rise),
        ("line_y", "units", lambda shots: np.mean(shots.line_y)),
        ("line_sd", "units", lambda shots: np.std(shots.line_y, ddof=1)),
    )
    for column, unit, number in numbers:
        grf = np.array([float(target[column]) for _, target, _ in played])
        ours = np.array([number(shots) for _, _, shots in played])
        panels.append(Panel(column, (grf, grf), (grf, ours), f"original, {unit}", f"ours, {unit}", points=True))
    draw_panels(path, TITLE, panels, columns=3)
