"""Tackles: running into a carrier, sliding at one by angle and distance, and getting past a lone built-in defender.

A tackler is an agent, as in GRF's measurement: it runs at the ball along the nearest of the eight directions. Read
next: `grf.report`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance
from lab.grf.stage import METRES_X, METRES_Y, Stage
from regista.envs.football.constants import BUILTIN_AI as AI
from regista.envs.football.constants import (
    CB,
    CF,
    DIRECTION_RIGHT,
    DIRECTION_X,
    DIRECTION_Y,
    DRIBBLE,
    FREE_KICK,
    GK,
    IDLE,
    LEFT,
    PENALTY,
    RIGHT,
    SLIDING,
    SPRINT,
    STAND,
)
from regista.envs.football.kick_off import Roster

TITLE = "tackles"
REQUIRED = 0.8
POINTS = 0.2  # tolerance of a rate
TRIALS = 60  # at full effort; GRF has 25 or 30
ONE_EACH = Roster([LEFT, LEFT, RIGHT, RIGHT], [CF, GK, CB, GK])
CARRIER, TACKLER = 0, 2
KEEPERS = ((-1.0, 0.0), (1.0, -0.4))  # both far from the duel
START_X = -0.3  # of the carrier
TACKLE_STEPS = 60
TACKLE_FROM = 5.0  # m from the ball at which a standing tackle begins
UNSURE = 0.2  # m, half the spread of the tackler's position, so that trials differ
SLIDE_STEPS = 25
SPEEDS = {"stands": 0.0, "runs": 5.1, "sprints": 7.3}  # m/s of the carrier
KEYS = {"stands": (), "runs": (DIRECTION_RIGHT,), "sprints": (SPRINT, DIRECTION_RIGHT), "dribbles": (DRIBBLE,)}
SIDES = {"front": (1.0, 0.0), "side": (0.0, 1.0), "behind": (-1.0, 0.0)}  # of the tackler, from the carrier


@dataclass(frozen=True)
class Outcomes:
    """Shares of trials in which the tackler's team got the ball, the tackler fouled, or saw a yellow card."""

    won: float
    foul: float
    yellow: float


def measure(effort: float = 1.0) -> list[Row]:
    """Compare with GRF; `effort` scales the number of trials."""
    n = max(int(TRIALS * effort), 8)
    rows = []
    for target in read_data("tackles_standing"):
        ours = stand_up(target["carrier"], target["side"], n)
        name = f"tackle, carrier {target['carrier']}, {target['side']}: won"
        rows.append(by_distance("tackles", name, ours, float(target["won"]), "share", POINTS))
    slides = read_data("tackles_sliding")
    slid = [slide_in(target["carrier"], target["side"], float(target["distance"]), n) for target in slides]
    rows += [slide_row(target, ours) for target, ours in zip(slides, slid, strict=True)]
    rows += [card_row(slides, slid, stands) for stands in (True, False)]
    for target in read_data("tackles_dribbling"):
        rows += dribble_rows(target, n)
    return rows


def slide_row(target: dict[str, str], ours: Outcomes) -> Row:
    """Return the row of one way to slide: the outcome (won, foul or nothing) that differs most from GRF."""
    grf = Outcomes(*(float(target[name]) for name in ("won", "foul", "yellow")))
    pairs = {
        "won": (ours.won, grf.won),
        "foul": (ours.foul, grf.foul),
        "nothing": (1.0 - ours.won - ours.foul, 1.0 - grf.won - grf.foul),
    }
    what = max(pairs, key=lambda name: abs(pairs[name][0] - pairs[name][1]))
    name = f"slide, carrier {target['carrier']}, {target['side']}, {target['distance']} m: {what}"
    return by_distance("tackles", name, *pairs[what], "share", POINTS)


def card_row(targets: list[dict[str, str]], ours: list[Outcomes], stands: bool) -> Row:
    """Compare yellow cards per foul by a slide, against standing carriers, or running and sprinting ones."""
    which = [k for k, target in enumerate(targets) if (target["carrier"] == "stands") == stands]
    grf = sum(float(targets[k]["yellow"]) for k in which) / sum(float(targets[k]["foul"]) for k in which)
    fouls = sum(ours[k].foul for k in which)
    rate = sum(ours[k].yellow for k in which) / fouls if fouls else np.nan
    who = "stand" if stands else "run or sprint"
    return by_distance("tackles", f"yellow cards per foul on carriers who {who}", rate, grf, "share", POINTS)


def duel(carrier: str, side: str, distance: float, n: int) -> Stage:
    """Return a carrier at full speed with the ball, and a tackler at rest.

    The tackler is `distance` m from the ball, on this side of the carrier.
    """
    ball = (START_X + 0.45 / METRES_X, 0.0)
    away = SIDES[side]
    place = (ball[0] + away[0] * distance / METRES_X, ball[1] + away[1] * distance / METRES_Y)
    stage = Stage([(START_X, 0.0), KEEPERS[0], place, KEEPERS[1]], ball, ONE_EACH, n=n)
    matches, rng = stage.matches, np.random.default_rng(0)
    matches["players"]["x"][:, TACKLER] += rng.uniform(-UNSURE, UNSURE, n)
    matches["players"]["y"][:, TACKLER] += rng.uniform(-UNSURE, UNSURE, n)
    matches["carrier"] = matches["last_touch"] = CARRIER
    matches["players"]["vx"][:, CARRIER] = matches["ball"]["vx"] = SPEEDS[carrier]
    matches["ball"]["spin_x"] = SPEEDS[carrier]
    return stage


def press_key(stage: Stage, carrier: str, tackler: np.ndarray | int, step: int) -> None:
    """Play a step with the carrier's actions and the tackler's action, while the keepers stand."""
    actions = np.full((len(stage.matches), stage.num_players), STAND)
    keys = KEYS[carrier]
    actions[:, CARRIER] = keys[step] if step < len(keys) else IDLE
    actions[:, TACKLER] = tackler
    stage.step(actions)


def toward_ball(stage: Stage) -> np.ndarray:
    """Return the direction actions `[N]` that point best from tackler to ball, as the tackler sees the pitch."""
    tackler, ball = stage.matches["players"][:, TACKLER], stage.matches["ball"]
    along, across = ball["x"] - tackler["x"], ball["y"] - tackler["y"]
    away = np.column_stack([along, across])
    return np.argmax(away @ np.array([DIRECTION_X[1:], DIRECTION_Y[1:]]), axis=1) + 1


def stand_up(carrier: str, side: str, n: int) -> float:
    """Return the share of tacklers who win the ball by running at it, sprinting."""
    stage = duel(carrier, side, TACKLE_FROM, n)
    won = np.zeros(n, bool)
    for step in range(TACKLE_STEPS):
        press_key(stage, carrier, SPRINT if step == 0 else toward_ball(stage), step)
        won |= stage.matches["reported_owner"] == TACKLER
    return float(won.mean())


def slide_in(carrier: str, side: str, distance: float, n: int) -> Outcomes:
    """Let tacklers run at the ball and slide when it is `distance` m away."""
    stage = duel(carrier, side, distance, n)
    run_at_ball(stage, side)
    fouled, yellow, won = np.zeros(n, bool), np.zeros(n, bool), np.zeros(n, bool)
    for step in range(SLIDE_STEPS):
        press_key(stage, carrier, SLIDING if step == 0 else IDLE, step)
        fouled |= np.isin(stage.matches["game_mode"], (FREE_KICK, PENALTY))
        yellow |= stage.matches["players"]["cards"][:, TACKLER] > 0
        won |= (stage.matches["reported_owner"] == TACKLER) & ~fouled
    return Outcomes(float(won.mean()), float(fouled.mean()), float(yellow.mean()))


def run_at_ball(stage: Stage, side: str) -> None:
    """Give the tackler the speed and the heading of a run at the ball."""
    away, tackler = SIDES[side], stage.matches["players"][:, TACKLER]
    tackler["facing_x"], tackler["facing_y"] = -away[0], away[1]
    for axis, name in enumerate(("vx", "vy")):
        tackler[name] = 5.0 * tackler["facing_x" if axis == 0 else "facing_y"]


def dribble_rows(target: dict[str, str], n: int) -> list[Row]:
    """Compare how often a carrier running straight at the goal loses the ball or scores, and where the ball is lost."""
    lost, scored, place = run_past(target["carrier"], float(target["ahead"]), float(target["beside"]), n)
    name = f"past one defender, carrier {target['carrier']}, {target['ahead']} m ahead, {target['beside']} m beside"
    rows = [
        by_distance("tackles", f"{name}: lost", lost, float(target["lost"]), "share", POINTS),
        by_distance("tackles", f"{name}: goal", scored, float(target["goal"]), "share", POINTS),
    ]
    if target["x_lost"]:
        rows.append(by_distance("tackles", f"{name}: x at loss", place, float(target["x_lost"]), "units", 0.1))
    return rows


def run_past(carrier: str, ahead: float, beside: float, n: int, difficulty: float = 0.6) -> tuple[float, float, float]:
    """Return the shares of carriers who lose the ball to a built-in back or score, and the median x of the losses."""
    places = [(0.0, 0.0), KEEPERS[0], (ahead / METRES_X, beside / METRES_Y), (-1.0, 0.4)]
    stage = Stage(places, (0.45 / METRES_X, 0.0), ONE_EACH, n=n)
    stage.matches["players"]["skill"][:, TACKLER] = 0.3 + 0.7 * difficulty
    stage.matches["end_episode_on_score"] = stage.matches["end_episode_on_out_of_play"] = True
    lost, scored, place = np.zeros(n, bool), np.zeros(n, bool), np.full(n, np.nan)
    keys = (*KEYS[carrier], DIRECTION_RIGHT)
    for step in range(200):
        actions = np.full((n, stage.num_players), STAND)
        actions[:, CARRIER], actions[:, TACKLER] = keys[step] if step < len(keys) else IDLE, AI
        stage.step(actions)
        going = ~lost & ~scored
        scored |= going & (stage.matches["goal"] > 0)
        now = going & (stage.matches["reported_owner"] == TACKLER)
        place[now] = stage.matches["ball"]["x"][now] / METRES_X
        lost |= now
    return float(lost.mean()), float(scored.mean()), float(np.nanmedian(place)) if lost.any() else np.nan


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the rates of standing tackles, slides, and runs past a defender, each in the order of its table."""
    rows = measure(effort)
    panels = []
    for start in ("tackle", "slide", "past"):
        some = [row for row in rows if row.name.startswith(start) and row.unit == "share"]
        order = np.arange(len(some))
        grf, ours = [row.grf for row in some], [row.ours for row in some]
        panels.append(Panel(start, (order, grf), (order, ours), "row", "share", points=True))
    draw_panels(path, TITLE, panels, columns=3)
