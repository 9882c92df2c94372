"""How players run: steady speeds, curves of starts, turns and stops, slides, tiredness, and the ball at their feet.

A curve is compared by the root mean square of its difference over the steps since the action, as a share of its highest
speed. This applies to the speed and to its component along the requested direction. Our curve is shifted by the best
whole number of steps, because GRF begins a movement only when its animations allow. With the ball, the action may also
come some steps later, in another phase between two touches; the best of these phases counts. Turns are measured to both
sides, and the worse one counts. Such a curve does not show when a turn with the ball begins. For this, the mean
progress of many drawn turns is compared without a shift. Read next: `grf.ball`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance, by_share
from lab.grf.stage import METRES_X, Stage, Trace, keys
from regista.envs.football.constants import (
    CB,
    CF,
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_LEFT,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_LEFT,
    DIRECTION_RIGHT,
    DIRECTION_TOP,
    DIRECTION_TOP_LEFT,
    DIRECTION_TOP_RIGHT,
    DRIBBLE,
    GK,
    IDLE,
    RELEASE_DIRECTION,
    RELEASE_SPRINT,
    SLIDING,
    SPRINT,
    STAND,
    TOP_SPEEDS,
)
from regista.envs.football.kick_off import Roster

TITLE = "motion"
REQUIRED = 1.0  # share of the rows that should be within tolerance
TOLERANCE = 0.05
SLIDE_TOLERANCE = 0.1  # share of the sliding distance; for the curve, share of the highest speed
DISTANCE_TOLERANCE = 0.1  # share of the distance between ball and player
SHIFTS = range(-3, 4)  # steps by which a curve may begin earlier or later
RUN_UP = 41  # steps before a turn
TURN_TOLERANCE = 0.3  # m, of drawn turns
DRAWN, TURNS_LAST = 200, 30  # turns of a kind, and their steps
PHASES = 8  # number of run-ups with the ball, each a step longer than the last
STEP = 0.1  # s

PRESSED = {"run": (), "sprint": (SPRINT,), "dribble": (DRIBBLE,), "sprint+dribble": (SPRINT, DRIBBLE)}
TURNS = {
    45: (DIRECTION_TOP_RIGHT, DIRECTION_BOTTOM_RIGHT),
    90: (DIRECTION_TOP, DIRECTION_BOTTOM),
    135: (DIRECTION_TOP_LEFT, DIRECTION_BOTTOM_LEFT),
    180: (DIRECTION_LEFT, DIRECTION_LEFT),
}


@dataclass(frozen=True)
class Curve:
    """Velocity `[T, 2]` in m/s per step, along the previous run and to the turn's side; `asked` [2] is requested."""

    velocity: np.ndarray
    asked: np.ndarray

    @property
    def speed(self) -> np.ndarray:
        """Return the speed [T] in m/s."""
        return np.hypot(*self.velocity.T)

    @property
    def along(self) -> np.ndarray:
        """Return the component [T] in m/s along the requested direction."""
        return self.velocity @ self.asked


def measure(effort: float = 1.0) -> list[Row]:
    """Compare with GRF; `effort` has no effect."""
    curves = [*steady_rows(), *start_rows(), *curve_rows()]
    return [*curves, *drawn_turn_rows(), *slide_rows(), *carry_rows(), *tired_rows()]


# ---------------------------------------------------------------- the runner


def runner_stage(with_ball: bool, shirt: int = 1) -> Stage:
    """Return one left player at (-0.4, 0.1), with the ball at the player's feet, or far away at a teammate's."""
    places = [(-0.4, 0.1), (-1.0, 0.0), (0.91, -0.355), (1.0, 0.42)]
    stage = Stage(places, (-0.39, 0.1) if with_ball else (0.905, -0.35), Roster([0, 0, 0, 1], [CB, GK, CF, GK]))
    stage.matches["players"]["top_speed"][:, 0] = TOP_SPEEDS[shirt]
    return stage


def run_keys(with_ball: bool, *pressed: tuple[int, int], shirt: int = 1) -> Trace:
    """Return the trace of a runner who takes these actions, each for a number of steps."""
    stage = runner_stage(with_ball, shirt)
    return stage.play(keys(*pressed, others=(STAND,) * (stage.num_players - 1)))


def run_straight(mode: str, with_ball: bool, steps: int, shirt: int = 1) -> Trace:
    """Let the runner stand for 10 steps, start a mode, and run along +x for `steps` steps."""
    pressed = [(IDLE, 10 - len(PRESSED[mode])), *((key, 1) for key in PRESSED[mode])]
    return run_keys(with_ball, *pressed, (DIRECTION_RIGHT, steps), shirt=shirt)


def velocities(trace: Trace, first: int) -> np.ndarray:
    """Return the velocity [T, 2] of the runner over each step from index `first`, as a difference of positions."""
    return np.diff(trace.places[:, 0, 0], axis=0)[first:] / STEP


# ---------------------------------------------------------------- steady speeds and starts


def steady_rows() -> list[Row]:
    """Compare the steady speed of a player in every mode."""
    rows = []
    for target in read_data("steady_speeds"):
        with_ball = target["ball"] == "yes"
        ours = float(np.mean(velocities(run_straight(target["keys"], with_ball, 64), 39), axis=0)[0])
        name = f"steady {target['keys']}, {'with ball' if with_ball else 'no ball'}"
        rows.append(by_share("motion", name, ours, float(target["speed"]), "m/s", TOLERANCE))
    return rows


def start_rows() -> list[Row]:
    """Compare sprints from rest for each player, since top speeds differ."""
    rows = []
    for target in read_data("player_sprints"):
        theirs = np.array([float(speed) for speed in target["start"].split()])
        path = velocities(run_straight("sprint", False, 64, int(target["player"])), 6)[:, 0]
        name = f"player {target['player']}"
        rows.append(by_share("motion", f"{name}, top speed", float(path[-1]), float(target["top"]), "m/s", TOLERANCE))
        error = min(rms(shifted(path, shift + 4, len(theirs)) - theirs) for shift in SHIFTS)
        rows.append(_curve_row(f"{name}, start", error, float(target["top"])))
    return rows


# ---------------------------------------------------------------- curves


def curve_rows() -> list[Row]:
    """Compare every curve, by speed and by the component along the requested direction."""
    rows = []
    for name, theirs in their_curves().items():
        top = float(np.max(theirs.speed))
        errors = np.max([fit(ours, theirs)[1] for ours in best_phase(name, theirs)], axis=0)
        rows.append(_curve_row(f"{name}: speed", errors[0], top))
        rows.append(_curve_row(f"{name}: along", errors[1], top))
    return rows


def _curve_row(name: str, error: float, top: float) -> Row:
    return Row("motion", name, float(error), top, "m/s rms, top", float(error) / top, TOLERANCE)


def their_curves() -> dict[str, Curve]:
    """Return GRF's curves by name."""
    samples: dict[str, list[tuple[float, float]]] = {}
    for row in read_data("motion_curves"):
        samples.setdefault(row["curve"], []).append((float(row["ahead"]), float(row["aside"])))
    return {name: Curve(np.array(velocity), direction_asked(name)) for name, velocity in samples.items()}


def direction_asked(name: str) -> np.ndarray:
    """Return the unit vector [2] of the direction requested by the last action of a curve; stops keep the old one."""
    angle = np.radians(float(name.split()[-1])) if "turn" in name else 0.0
    return np.array([np.cos(angle), np.sin(angle)])


def best_phase(name: str, theirs: Curve) -> list[Curve]:
    """Return our curves of this name that agree best with GRF's, over the possible phases of the action."""
    phases = range(PHASES if "with ball" in name and "start" not in name else 1)
    return min((our_curves(name, phase) for phase in phases), key=lambda curves: sum(fit(curves[0], theirs)[1]))


def our_curves(name: str, phase: int = 0) -> list[Curve]:
    """Return our curve of this name from four steps before the action; for turns, one curve to either side.

    The action comes `phase` steps after the usual run-up.
    """
    mode, ball, what = name.split(", ")
    with_ball = ball == "with ball"
    asked = direction_asked(name)
    if what == "start":
        return [Curve(velocities(run_straight(mode, with_ball, 40), 6), asked)]
    run_up = RUN_UP + phase
    pressed = [*((key, 1) for key in PRESSED[mode]), (DIRECTION_RIGHT, run_up - len(PRESSED[mode]))]
    last = {"stop": (RELEASE_DIRECTION,), "release sprint": (RELEASE_SPRINT,)}
    curves = []
    for side, key in zip((1.0, -1.0), TURNS[int(what.split()[-1])] if "turn" in what else last[what], strict=False):
        trace = run_keys(with_ball, *pressed, (key, 1), (IDLE, 30))
        curves.append(Curve(velocities(trace, run_up - 4) * (1.0, side), asked))
    return curves


def fit(ours: Curve, theirs: Curve) -> tuple[int, tuple[float, float]]:
    """Return the best shift in steps between two curves, and the rms differences at this shift: of speed, and along."""
    count = len(theirs.velocity)
    errors = []
    for shift in SHIFTS:
        along = rms(shifted(ours.along, shift + 4, count) - theirs.along)
        errors.append((rms(shifted(ours.speed, shift + 4, count) - theirs.speed), along))
    best = int(np.argmin([first**2 + second**2 for first, second in errors]))
    return SHIFTS[best], errors[best]


def shifted(values: np.ndarray, shift: int, count: int) -> np.ndarray:
    """Return `count` values from `shift` on, padded with the first or the last one."""
    return values[np.clip(np.arange(count) + shift, 0, len(values) - 1)]


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


# ---------------------------------------------------------------- start of turns with the ball


def drawn_turn_rows() -> list[Row]:
    """Compare the mean progress of drawn turns with the ball; the time at which a turn begins varies."""
    rows = []
    for target in read_data("turns"):
        way = drawn_turns(target["mode"], int(target["turn"])).mean(axis=1)
        for steps, column in ((5, "way"), (8, "later_way")):
            name = f"{target['mode'].replace('_', ' ')}, drawn turn {target['turn']}: way after {steps * STEP:.1f} s"
            rows.append(by_distance("motion", name, float(way[steps]), float(target[column]), "m", TURN_TOLERANCE))
    return rows


def drawn_turns(mode: str, turn: int) -> np.ndarray:
    """Return the distance `[9, DRAWN]` in m of players along the new direction, per step since the action.

    They start behind a ball at rest, and turn 4 to 8 steps after their first touch.
    """
    rng = np.random.default_rng(turn)
    ball = np.column_stack([rng.uniform(-0.3885, -0.3755, DRAWN), rng.uniform(0.098, 0.102, DRAWN)])
    stage = Stage([(-0.4, 0.1), (-1.0, 0.0), (1.0, 0.42)], ball, Roster([0, 0, 1], [CB, GK, GK]), n=DRAWN)
    first, left = PRESSED.get(mode, ()), rng.random(DRAWN) < 0.5
    due = rng.integers(4, 9, DRAWN)  # steps from the first touch to the action
    key_at = np.full(DRAWN, 10**6)
    for step in range(TURNS_LAST):
        key = np.where(step < key_at, DIRECTION_RIGHT, np.where(left, *TURNS[turn]))
        if 1 <= step <= len(first):
            key = np.full(DRAWN, first[step - 1])
        elif mode == "then_sprint":
            key = np.where(step == key_at + 1, SPRINT, key)
        stage.step(np.column_stack([key, np.full((DRAWN, 2), STAND)]))
        touched = (stage.matches["last_touch"] == 0) & (key_at == 10**6)
        key_at = np.where(touched, step + 1 + due, key_at)
    side = np.where(left, 1.0, -1.0) * np.sin(np.radians(turn))
    asked = np.column_stack([np.full(DRAWN, np.cos(np.radians(turn))), side])
    places, match = stage.trace().places[:, :, 0], np.arange(DRAWN)
    ways = [places[key_at + steps, match] - places[key_at, match] for steps in range(9)]
    return np.einsum("tnk,nk->tn", ways, asked)


# ---------------------------------------------------------------- slides


def slide_rows() -> list[Row]:
    """Compare slides: the curve of speeds, and the distance."""
    rows = []
    for target in read_data("slides"):
        theirs = np.array([float(speed) for speed in target["speeds"].split()])
        ours = slide_speeds(target["mode"])
        shift = min(SHIFTS, key=lambda steps: rms(shifted(ours, steps + 4, len(theirs)) - theirs))
        ours = shifted(ours, shift + 4, len(theirs))
        name = f"slide, {target['mode']}"
        rows.append(Row("motion", f"{name}: speeds", rms(ours - theirs), max(theirs), "m/s rms, top",
                        rms(ours - theirs) / max(theirs), SLIDE_TOLERANCE))  # fmt: skip
        covered = float(np.sum(ours[1 : int(target["stops"])]) * STEP)
        rows.append(by_share("motion", f"{name}: distance", covered, float(target["distance"]), "m", SLIDE_TOLERANCE))
    return rows


def slide_speeds(mode: str) -> np.ndarray:
    """Return the speed [T] over each step from four steps before the slide action, without the ball."""
    run = [] if mode == "stand" else [*((key, 1) for key in PRESSED[mode]), (DIRECTION_RIGHT, 30)]
    stage = Stage([(-0.4, 0.1), (0.9, -0.35)], (0.895, -0.35), Roster([0, 1], [CB, CF]))
    stage.matches["players"]["top_speed"][:, 0] = TOP_SPEEDS[1]
    trace = stage.play(keys((IDLE, 10), *run, (SLIDING, 3), (IDLE, 40), others=(STAND,)))
    return np.hypot(*velocities(trace, 10 - 4 + sum(steps for _, steps in run)).T)


# ---------------------------------------------------------------- the ball at the feet, and tiredness


def carry_rows() -> list[Row]:
    """Compare how far the ball is ahead of a running player, and how often the player owns it."""
    rows = []
    for target in read_data("carrying"):
        trace = run_straight(target["keys"], True, 64)
        away = np.linalg.norm(trace.ball[35:, 0, :2] - trace.places[35:, 0, 0], axis=1)
        name = f"{target['keys']}, with ball:"
        for ours, what in ((np.mean(away), "mean"), (np.max(away), "max")):
            grf = float(target[what])
            rows.append(by_share("motion", f"{name} {what} distance", float(ours), grf, "m", DISTANCE_TOLERANCE))
        owned = float(np.mean(trace.owner[35:, 0] == 0))
        rows.append(by_distance("motion", f"{name} owned", owned, float(target["owned"]), "share", 0.1))
    return rows


def tired_rows() -> list[Row]:
    """Compare tiredness after a number of steps of running straight on; the player is put back every 50 steps."""
    rows = []
    for target in read_data("tiredness"):
        steps = int(target["steps"])
        stage = runner_stage(False)
        for key in PRESSED[target["keys"]]:
            stage.step([key, STAND, STAND, STAND])
        for _ in range(steps // 50):
            stage.matches["players"]["x"][:, 0] = -METRES_X
            stage.play(keys((DIRECTION_RIGHT, 50), others=(STAND,) * 3))
        ours = float(stage.matches["players"]["tiredness"][0, 0])
        name = f"tired after {steps} steps of {target['keys']}"
        rows.append(by_share("motion", name, ours, float(target["tired"]), "", TOLERANCE))
    return rows


# ---------------------------------------------------------------- the picture


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw every curve: the speed, and for turns the component along the requested direction in separate panels."""
    panels = []
    for name, theirs in their_curves().items():
        ours = best_phase(name, theirs)[0]
        shift, _ = fit(ours, theirs)
        count = len(theirs.velocity)
        time = np.arange(count) * STEP
        panels.append(Panel(name, (time, theirs.speed), (time, shifted(ours.speed, shift + 4, count))))
        if "turn" in name:
            along = (time, shifted(ours.along, shift + 4, count))
            panels.append(Panel("along the new direction", (time, theirs.along), along))
    draw_panels(path, "speed in m/s over time in s", panels, columns=8)
