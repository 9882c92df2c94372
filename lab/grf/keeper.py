"""The built-in goalkeeper: saves, rebounds, and play after a catch.

Goal rates are compared by time to the line and gap (2400 random shots at full effort; 800 of GRF). The table of single
positions is compared by its means: in GRF, a position is locked to the phase of a few animations. Read next:
`grf.report`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance, by_share
from lab.grf.stage import OPEN_END, Stage, Trace
from regista.envs.football.constants import BUILTIN_AI as AI
from regista.envs.football.constants import (
    CB,
    CF,
    CM,
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_RIGHT,
    DIRECTION_TOP,
    DIRECTION_TOP_RIGHT,
    DT,
    GK,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    HALF_LENGTH,
    IDLE,
    LEFT,
    NORMAL,
    RIGHT,
    SHOT,
    SPRINT,
)
from regista.envs.football.kick_off import MatchConfig, Roster
from regista.envs.football.physics.ball import advance_ball
from regista.kernels.jit import kernel

TITLE = "keeper"
REQUIRED = 0.8
POINTS = 0.15  # tolerance of a rate
SHOTS, PER_POSITION = 2400, 40  # at full effort
TIMES = ((0.0, 0.35), (0.35, 0.45), (0.45, 0.55), (0.55, 0.65), (0.65, 9.0))  # s from launch to the line
GAPS = ((0.0, 1.0), (1.0, 2.0), (2.0, 4.0))  # m from the keeper to the line of the shot
DIRECTIONS = (IDLE, DIRECTION_RIGHT, DIRECTION_TOP_RIGHT, DIRECTION_BOTTOM_RIGHT, DIRECTION_TOP, DIRECTION_BOTTOM)
SHOTS_X, SHOTS_Y = (0.70, 0.75, 0.80, 0.85), (-0.12, -0.06, 0.0, 0.06, 0.12)
AFTERWARDS = 70  # steps in which the ball becomes a goal, is held, or stays loose
SLOWEST = 3.0  # s to the line, maximum for a shot
KICKED = 8.0  # m/s from which the ball has left the foot
DUEL = Roster([LEFT, LEFT, RIGHT], [CF, GK, GK])
FAR = (-1.0, 0.0)  # the strikers' own keeper
SQUAD = Roster([LEFT] * 4 + [RIGHT] * 5, [CF, GK, CM, CM, GK, CB, CB, CM, CM])  # with teammates some way behind
SQUAD_PLACES = (FAR, (0.3, 0.2), (0.3, -0.2), (1.0, 0.0), (0.5, -0.25), (0.5, 0.25), (0.1, -0.1), (0.0, 0.1))


@dataclass(frozen=True)
class Shots:
    """State of N shots when the ball left the foot, and their outcomes."""

    time: np.ndarray  # [N], s to the goal line
    gap: np.ndarray  # [N], m from the keeper to the line of the shot
    height: np.ndarray  # [N], m at the line
    on_target: np.ndarray  # [N]
    goal: np.ndarray  # [N]
    held: np.ndarray  # [N], whether the keeper has the ball afterwards
    out: np.ndarray  # [N], play stopped
    distance: np.ndarray  # [N], m from the middle of the goal
    rebound: np.ndarray  # [N], team that next has the ball after a save, -1 none


def measure(effort: float = 1.0) -> list[Row]:
    """Compare with GRF; `effort` scales the number of shots."""
    shots = random_shots(max(int(SHOTS * effort), 50))
    return [*goal_rates(shots), *odds_rows(shots), *rebound_rows(shots), *position_rows(effort), *catch_rows(effort)]


def random_shots(n: int, seed: int = 0) -> Shots:
    """Let strikers at random positions near the goal choose a direction, then shoot once."""
    rng = np.random.default_rng(seed)
    x, y = rng.choice(SHOTS_X, n), rng.choice(SHOTS_Y, n, p=(0.19, 0.2, 0.22, 0.2, 0.19))
    keys = np.stack([rng.choice(DIRECTIONS, n), np.full(n, SHOT)])
    return shoot(np.stack([x, y], axis=-1), keys, SQUAD, SQUAD_PLACES, seed=seed)


def shoot(
    strikers: np.ndarray, keys: np.ndarray, roster: Roster, others: tuple, difficulty: float = 0.6, seed: int = 0
) -> Shots:
    """Let strikers at `[N, 2]` take actions `keys` `[T, N]`, then none, against the built-in keeper; watch for 7 s."""
    n = len(strikers)
    places = np.concatenate([strikers[:, None], np.broadcast_to(others, (n, *np.shape(others)))], axis=1)
    config = MatchConfig(**{**vars(OPEN_END), "right_team_difficulty": difficulty})
    stage = Stage(places, strikers + (0.01, 0.0), roster, config, n, seed)
    stage.matches["end_episode_on_score"] = stage.matches["end_episode_on_out_of_play"] = True
    actions = np.full((len(keys) + AFTERWARDS, n, places.shape[1]), AI)
    actions[:, :, 0] = IDLE
    actions[: len(keys), :, 0] = keys
    return judge(stage.play(actions), len(keys), roster)


def judge(trace: Trace, pressed: int, roster: Roster) -> Shots:
    """Find in a trace when the ball left the foot, where it would have crossed the line, and the outcome."""
    speed = np.linalg.norm(trace.ball_velocity[:, :, :2], axis=-1)
    launch = np.maximum(np.argmax(speed > KICKED, axis=0), 1)
    match = np.arange(len(launch))
    ball, velocity = trace.ball[launch, match], trace.ball_velocity[launch, match]
    gk = int(np.flatnonzero((np.asarray(roster.teams) == RIGHT) & (np.asarray(roster.roles) == GK))[0])
    keeper = trace.places[launch, match, gk]
    crossing = cross_line(ball, velocity)
    to_line = np.column_stack([HALF_LENGTH - ball[:, 0], crossing[:, 0] - ball[:, 1]])
    away = keeper - ball[:, :2]
    gap = np.abs(away[:, 0] * to_line[:, 1] - away[:, 1] * to_line[:, 0]) / np.linalg.norm(to_line, axis=1)
    later = np.arange(len(speed))[:, None] > launch
    goal = trace.score[-1, :, LEFT] > 0
    owners = np.where(later, trace.owner, -1)
    out = ((trace.mode != NORMAL) & later).any(axis=0) & ~goal
    first = np.argmax(owners >= 0, axis=0)
    team = np.where((owners >= 0).any(axis=0), np.asarray(roster.teams)[owners[first, match]], -1)
    on_target = (np.abs(crossing[:, 0]) < GOAL_HALF_WIDTH) & (crossing[:, 1] < GOAL_HEIGHT)
    on_target &= crossing[:, 2] < SLOWEST
    distance = np.linalg.norm(ball[:, :2] - (HALF_LENGTH, 0.0), axis=1)
    held = (owners == gk).any(axis=0) & ~goal
    return Shots(crossing[:, 2], gap, crossing[:, 1], on_target, goal, held, out & ~held, distance, team)


def cross_line(ball: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return where and when free balls cross the right goal line, `[N, 3]`: y in m, height in m, time in s.

    The time is 9 s for balls that do not cross it.
    """
    stage = Stage([(0.0, 0.0)], (0.0, 0.0), Roster([LEFT], [CF]), n=len(ball))
    for axis, name in enumerate("xyz"):
        stage.matches["ball"][name], stage.matches["ball"]["v" + name] = ball[:, axis], velocity[:, axis]
    result = np.zeros((len(ball), 3))
    fly_to_line(stage.matches, result)
    return result


@kernel
def fly_to_line(matches, result):
    """Let each match's ball fly on to the goal line; write the position and time of arrival."""
    for e in range(len(matches)):
        ball, time = matches[e].ball, 0.0
        while ball.x < HALF_LENGTH - 0.2 and ball.vx > 0.5 and time < 9.0:
            advance_ball(ball)
            time += DT
        rest = (HALF_LENGTH - ball.x) / ball.vx if ball.vx > 0.5 else 0.0
        result[e, 0], result[e, 1] = ball.y + rest * ball.vy, ball.z
        result[e, 2] = time + rest if ball.vx > 0.5 else 9.0


def cell(shots: Shots, time: tuple[float, float], gap: tuple[float, float]) -> np.ndarray:
    """Return which shots on target have a time to the line and a gap to the keeper in these ranges."""
    in_time = (shots.time >= time[0]) & (shots.time < time[1])
    return shots.on_target & in_time & (shots.gap >= gap[0]) & (shots.gap < gap[1])


def goal_rates(shots: Shots) -> list[Row]:
    """Return the table of goal rates by time to the line and gap."""
    rows = []
    for target in read_data("keeper_cells"):
        time = (float(target["time_from"]), float(target["time_to"]))
        gap = (float(target["gap_from"]), float(target["gap_to"]))
        ours = shots.goal[cell(shots, time, gap)]
        name = f"goals, {time[0]:.2f}-{time[1]:.2f} s, gap {gap[0]:.0f}-{gap[1]:.0f} m"
        rate = ours.mean() if len(ours) else np.nan
        rows.append(by_distance("keeper", name, rate, float(target["goals"]), f"share of {len(ours)}", POINTS))
    return rows


def odds_rows(shots: Shots) -> list[Row]:
    """Return the logistic fit of goals on target; the tolerance of a coefficient is three of GRF's standard errors."""
    on = shots.on_target
    features = np.column_stack([np.ones(on.sum()), shots.time[on], shots.gap[on], shots.height[on]])
    fitted = fit_odds(features, shots.goal[on])
    rows = []
    for target, ours in zip(read_data("keeper_odds"), fitted, strict=True):
        name = f"log odds of a goal, {target['name']}"
        rows.append(by_distance("keeper", name, ours, float(target["value"]), "", 3.0 * float(target["error"])))
    return rows


def fit_odds(features: np.ndarray, happened: np.ndarray) -> np.ndarray:
    """Return the coefficients of a logistic regression, by Newton's method."""
    weights = np.zeros(features.shape[1])
    for _ in range(25):
        chance = 1.0 / (1.0 + np.exp(-features @ weights))
        slope = features.T @ (happened - chance)
        bend = (features * (chance * (1.0 - chance))[:, None]).T @ features
        weights += np.linalg.solve(bend + 1e-6 * np.eye(len(weights)), slope)
    return weights


def rebound_rows(shots: Shots) -> list[Row]:
    """Return the team that has the ball after a save of a shot on target."""
    target = read_data("keeper_rebounds")[0]
    saved = shots.on_target & ~shots.goal & (shots.rebound >= 0)
    share = np.mean(shots.rebound[saved] == RIGHT)
    return [by_distance("keeper", "rebounds to the defenders", share, float(target["defenders"]), "share", POINTS)]


def position_rows(effort: float) -> list[Row]:
    """Return the outcomes of shots from the table's positions, mean over the positions, for each way to shoot."""
    rows = []
    for way, keys, difficulty in (
        ("single press", (IDLE, SHOT), 0.6),
        ("4 presses", (IDLE, *[SHOT] * 4), 0.6),
        ("sprinting", (SPRINT, *[DIRECTION_RIGHT] * 5, SHOT), 0.6),
        ("single press, weak keeper", (IDLE, SHOT), 0.05),
    ):
        ours, grf = position_shares(way, keys, difficulty, max(int(PER_POSITION * effort), 4))
        for name in grf:
            rows.append(by_distance("keeper", f"{way}: {name}", ours[name], grf[name], "share", POINTS))
    return rows


def position_shares(way: str, keys: tuple, difficulty: float, n: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return the mean outcome shares over the positions in GRF's table for this way to shoot: ours, and GRF's."""
    targets = [row for row in read_data("keeper_positions") if row["way"] == way]
    places = np.array([(float(row["x"]), float(row["y"])) for row in targets]).repeat(n, axis=0)
    shots = shoot(places, np.array(keys)[:, None].repeat(len(places), axis=1), DUEL, (FAR, (1.0, 0.0)), difficulty)
    ours = {"goals": shots.goal.mean(), "the keeper's": shots.held.mean()}
    names = {"goals": "goal", "the keeper's": "held"}
    grf = {name: [float(row[key]) for row in targets if row[key]] for name, key in names.items()}
    return ours, {name: float(np.mean(numbers)) for name, numbers in grf.items() if numbers}


def catch_rows(effort: float) -> list[Row]:
    """Compare what a keeper does with a caught ball: how long it is held, how fast and how far it is played."""
    ours = after_catch(max(int(100 * effort), 20))
    grf = read_data("keeper_catches")
    rows = []
    for name, unit, tolerance in (("hold", "steps", 0.25), ("v", "m/s", 0.15), ("vz", "m/s", 0.2), ("dist", "m", 0.25)):
        median = float(np.median([float(row[name]) for row in grf]))
        rows.append(by_share("keeper", f"after a catch, median {name}", ours[name], median, unit, tolerance))
    return rows


def after_catch(n: int) -> dict[str, float]:
    """Let strikers shoot once, then wait until the keeper has had the ball and has played it away; return medians."""
    places = np.array([(0.7, 0.0), *SQUAD_PLACES])
    stage = Stage(places, (0.71, 0.0), SQUAD, n=n)
    actions = np.full((160, len(places)), AI)
    actions[:, 0] = IDLE
    actions[1, 0] = SHOT
    trace = stage.play(actions)
    gk = list(np.asarray(SQUAD.teams)).index(RIGHT)
    measured: dict[str, list[float]] = {name: [] for name in ("hold", "v", "vz", "dist")}
    for e in range(n):
        one = catch(trace, e, gk)
        for name, value in one.items():
            measured[name].append(value)
    return {name: float(np.median(values)) if values else np.nan for name, values in measured.items()}


def catch(trace: Trace, e: int, gk: int) -> dict[str, float]:
    """Return the first time that the keeper of match `e` had the ball and played it away; empty if it never did."""
    has = trace.owner[:, e] == gk
    if not has.any():
        return {}
    start = int(np.argmax(has))
    hold = int(np.argmin(has[start:]))
    left = start + hold
    following = trace.owner[left:, e]
    if hold == 0 or not (following >= 0).any():
        return {}
    taken = left + int(np.argmax(following >= 0))
    velocity = trace.ball_velocity[left, e]
    path = trace.ball[taken, e, :2] - trace.ball[left, e, :2]
    numbers = {"hold": hold, "v": np.linalg.norm(velocity[:2]), "vz": velocity[2], "dist": np.linalg.norm(path)}
    return {name: float(number) for name, number in numbers.items()}


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the goal rates over the time to the line, one panel per gap, and the shares of the positions."""
    shots = random_shots(max(int(SHOTS * effort), 50))
    targets = read_data("keeper_cells")
    panels = []
    for gap in GAPS:
        middles = [0.3, 0.4, 0.5, 0.6, 0.75]
        grf = [float(row["goals"]) for row in targets if float(row["gap_from"]) == gap[0]]
        some = [shots.goal[cell(shots, time, gap)] for time in TIMES]
        ours = [goals.mean() if len(goals) else np.nan for goals in some]
        title = f"goals, gap {gap[0]:.0f}-{gap[1]:.0f} m"
        panels.append(Panel(title, (middles, grf), (middles, ours), "s to the line", "share"))
    rows = position_rows(effort)
    order = np.arange(len(rows))
    grf, ours = [row.grf for row in rows], [row.ours for row in rows]
    panels.append(Panel("positions, means", (order, grf), (order, ours), "row", "share", points=True))
    draw_panels(path, TITLE, panels, columns=4)
