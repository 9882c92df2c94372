"""How players run, with the ball and without: steady speeds.

Read next: `report`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from envs.football.constants import CB, CF, DIRECTION_RIGHT, DRIBBLE, GK, IDLE, SPRINT, STAND
from envs.football.state import Lineup
from experiments.grf.figures import Panel, draw_panels
from experiments.grf.report import read_data
from experiments.grf.rows import Row, by_share
from experiments.grf.stage import Stage, Trace, keys

TITLE = "motion"
REQUIRED = 1.0  # share of the rows that should be within tolerance
TOLERANCE = 0.05

PRESSED = {"run": (), "sprint": (SPRINT,), "dribble": (DRIBBLE,), "sprint+dribble": (SPRINT, DRIBBLE)}


def measure(effort: float = 1.0) -> list[Row]:
    """Compare with the original; nothing here is random, so `effort` changes nothing."""
    rows = []
    for target in read_data("steady_speeds"):
        with_ball = target["ball"] == "yes"
        trace = run_straight(target["keys"], with_ball)
        ours = steady_speed(trace)
        name = f"steady {target['keys']}, {'with ball' if with_ball else 'no ball'}"
        rows.append(by_share("motion", name, ours, float(target["speed"]), "m/s", TOLERANCE))
    return rows


def run_straight(mode: str, with_ball: bool, steps: int = 60) -> Trace:
    """Let player 1 run along +x with these keys held; without the ball, a mate stands on it far away."""
    stage = runner_stage(with_ball)
    pressed = [(key, 1) for key in (*PRESSED[mode], DIRECTION_RIGHT)]
    return stage.play(keys(*pressed, (IDLE, steps), others=(STAND,) * (stage.num_players - 1)))


def runner_stage(with_ball: bool) -> Stage:
    """One left player who stands at (-0.8, 0.1), the ball at his feet or far away at a mate's."""
    places = [(-0.8, 0.1), (-1.0, 0.0), (0.91, -0.355), (1.0, 0.42)]
    ball = (-0.79, 0.1) if with_ball else (0.905, -0.35)
    stage = Stage(places, ball, Lineup([0, 0, 0, 1], [CB, GK, CF, GK]))
    stage.matches["players"]["top_speed"][:, 0] = 7.83  # of player 1, on whom all was measured
    return stage


def steady_speed(trace: Trace, last: int = 25) -> float:
    """Mean speed in m/s of the first player over the last steps."""
    path = trace.places[-1 - last :, 0, 0]
    return float(np.linalg.norm(path[-1] - path[0]) / (0.1 * last))


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the steady speeds, in the order of the table."""
    rows = measure(effort)
    order = np.arange(len(rows))
    grf, ours = [row.grf for row in rows], [row.ours for row in rows]
    draw_panels(path, TITLE, [Panel("steady speeds", (order, grf), (order, ours), "row", "m/s", points=True)])
