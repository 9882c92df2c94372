"""Eleven against eleven, built-in players on both sides: goals, shots, passes, possession, restarts, running distances.

Passes, turnovers and shots are counted as in GRF's matches: by changes of the reported owner, and by sudden speed of
the ball towards the goal. Read next: `grf.report`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_factor
from lab.grf.scenes import stage_scene
from lab.grf.stage import METRES_Y, OPEN_END, Trace
from regista.envs.football.constants import BUILTIN_AI, CORNER, FREE_KICK, GOAL_KICK, NOBODY, NORMAL, PENALTY, THROW_IN

TITLE = "eleven against eleven"
REQUIRED = 1.0  # share of the rows that should be within tolerance
TOLERANCE = 0.5  # a factor of 1.5
STEPS, MATCHES = 3000, 32
SETTINGS = {"medium": 0.6, "easy": 0.05}  # difficulty of the right team; the left team's is 1
SUDDEN = 16.0  # m/s; a ball that becomes faster than this may be a shot
SHOT_WIDE, SHOT_FAR = 0.13 * METRES_Y, 35.0  # m off the middle of the goal line, m to the goal
SHOT_APART = 8  # steps
GOAL_X, GOAL_HALF = 55.0, 3.7  # m
TELEPORT = 1.2  # m in a step: the player was repositioned


def measure(effort: float = 1.0) -> list[Row]:
    """Compare whole matches at both difficulties; `effort` below 1 plays fewer."""
    rows = []
    for setting in SETTINGS:
        numbers = statistics(setting, max(round(MATCHES * effort), 2))
        for target in read_data("matches"):
            if target[setting]:
                name, unit = target["quantity"], target["unit"]
                grf = float(target[setting])
                rows.append(by_factor("matches", f"{setting}: {name}", numbers[name], grf, unit, TOLERANCE))
    return rows


@lru_cache(maxsize=4)
def statistics(setting: str, n: int) -> dict[str, float]:
    """Play n matches and return every quantity of the table."""
    trace = play(SETTINGS[setting], n)
    return {
        **events(trace),
        **possession(trace),
        **restarts(trace),
        **ways(trace),
        **shape(trace),
    }


def play(right_difficulty: float, n: int, steps: int = STEPS) -> Trace:
    """Record n matches."""
    settings = replace(OPEN_END, offsides=True, right_team_difficulty=right_difficulty)
    stage = stage_scene("11_vs_11", settings, n)
    return stage.play(lambda now: BUILTIN_AI, steps)


def owning_team(trace: Trace) -> np.ndarray:
    """Return the team [T, N] that owns the ball, -1 none."""
    return np.where(trace.owner == NOBODY, NOBODY, trace.owner // 11)


def events(trace: Trace) -> dict[str, float]:
    """Count goals, shots, passes with their lengths, and turnovers."""
    n = trace.owner.shape[1]
    passes, turnovers, shots, on_target = (np.zeros(2) for _ in range(4))
    lengths: list[float] = []
    for match in range(n):
        for team, length in owner_changes(trace, match):
            if length is None:
                turnovers[team] += 1
            else:
                passes[team] += 1
                lengths.append(length)
        for team, y in shots_of(trace, match):
            shots[team] += 1
            on_target[team] += abs(y) < GOAL_HALF
    goals = trace.score[-1].mean(axis=0)
    counts = {"shots": shots, "shots on target": on_target, "passes": passes, "turnovers won": turnovers}
    rates = {f"goals {side}": float(goals[team]) for team, side in enumerate(("left", "right"))}
    for name, count in counts.items():
        rates |= {f"{name} {side}": float(count[team] / n) for team, side in enumerate(("left", "right"))}
    middle, long = np.percentile(lengths, [50, 90]) if lengths else (np.nan, np.nan)
    return rates | {"pass length median": float(middle), "pass length 90 %": float(long)}


def owner_changes(trace: Trace, match: int) -> list[tuple[int, float | None]]:
    """Return every change of the owner: the new owner's team, and the distance of the ball for passes within a team.

    The distance is None if the team changes.
    """
    owner = trace.owner[:, match]
    owned = np.flatnonzero(owner != NOBODY)
    changes: list[tuple[int, float | None]] = []
    for before, now in pairwise(owned):
        if owner[before] == owner[now]:
            continue
        mates = owner[before] // 11 == owner[now] // 11
        way = trace.ball[now, match, :2] - trace.ball[before, match, :2]
        changes.append((int(owner[now] // 11), float(np.hypot(*way)) if mates else None))
    return changes


def shots_of(trace: Trace, match: int) -> list[tuple[int, float]]:
    """Return every shot: the team, and the crossing of its line with the goal line, in m off the middle."""
    ball, owner = trace.ball[:, match, :2], trace.owner[:, match]
    speed = np.linalg.norm(np.diff(ball, axis=0), axis=1) / 0.1
    sudden = np.flatnonzero((speed[1:] > SUDDEN) & (speed[:-1] <= SUDDEN) & (speed[1:] < 60.0)) + 1
    shots: list[tuple[int, float]] = []
    last = -SHOT_APART
    for step in sudden:
        before = owner[: step + 1][owner[: step + 1] != NOBODY]
        if len(before) == 0 or step - last < SHOT_APART or trace.mode[step, match] != NORMAL:
            continue
        team = int(before[-1] // 11)
        side = 1.0 - 2.0 * team
        (x, y), (dx, dy) = ball[step], ball[step + 1] - ball[step]
        if dx * side < 0.3 or np.hypot(side * GOAL_X - x, y) > SHOT_FAR:
            continue
        crossing = y + (side * GOAL_X - x) / dx * dy
        if abs(crossing) < SHOT_WIDE:
            last = int(step)
            shots.append((team, float(crossing)))
    return shots


def possession(trace: Trace) -> dict[str, float]:
    """Return the share of possession of the left team, and the share of time in which the ball is owned."""
    team = owning_team(trace)[1:]
    owned = team != NOBODY
    return {"possession left": float((team[owned] == 0).mean()), "ball owned": float(owned.mean())}


def restarts(trace: Trace) -> dict[str, float]:
    """Count stoppages per match by kind."""
    mode = trace.mode
    begun = (mode[1:] != NORMAL) & (mode[:-1] == NORMAL)
    kinds = {
        "goal kicks": (GOAL_KICK,),
        "free kicks": (FREE_KICK,),
        "throw-ins": (THROW_IN,),
        "corners and penalties": (CORNER, PENALTY),
    }
    return {name: float((begun & np.isin(mode[1:], of)).sum() / mode.shape[1]) for name, of in kinds.items()}


def ways(trace: Trace) -> dict[str, float]:
    """Return the mean running distances of outfield players and of keepers."""
    steps = np.linalg.norm(np.diff(trace.places, axis=0), axis=-1)
    way = np.where(steps < TELEPORT, steps, 0.0).sum(axis=0)
    keepers = [0, 11]
    return {
        "run by an outfield player": float(np.delete(way, keepers, axis=1).mean()),
        "run by a keeper": float(way[:, keepers].mean()),
    }


def shape(trace: Trace) -> dict[str, float]:
    """Measure distances to the ball and the spread of the teams."""
    team, places = owning_team(trace), trace.places
    away = np.linalg.norm(places - trace.ball[:, :, None, :2], axis=-1)
    with_ball, without = team != NOBODY, np.where(team == NOBODY, NOBODY, 1 - team)
    own, other = ([np.sort(_of_team(away, who)[with_ball], axis=-1)] for who in (team, without))
    numbers = {
        "owner to ball median": float(np.median(own[0][:, 0])),
        "owner to opponent median left": _nearest_opponent(trace, team == 0),
        "second of the owners to the ball": float(np.median(own[0][:, 1])),
        "first opponent to the ball": float(np.median(other[0][:, 0])),
        "second opponent to the ball": float(np.median(other[0][:, 1])),
    }
    for words, who in (("with", team), ("without", without)):
        spread = _of_team(places, who)[with_ball][:, 1:].std(axis=1).mean(axis=0)
        numbers |= {
            f"spread {way} {words} the ball": float(spread[axis]) for axis, way in enumerate(("along", "across"))
        }
    return numbers


def _of_team(values: np.ndarray, team: np.ndarray) -> np.ndarray:
    """Return the part [T, N, 11, ...] of values [T, N, 22, ...] that belongs to a team [T, N]."""
    right = (team == 1).reshape(*team.shape, *(1,) * (values.ndim - 2))
    return np.where(right, values[:, :, 11:], values[:, :, :11])


def _nearest_opponent(trace: Trace, left_owns: np.ndarray) -> float:
    """Return the median distance in m from the owner of the ball in the left team to the nearest opponent."""
    owner = np.maximum(trace.owner, 0)[..., None, None]
    place = np.take_along_axis(trace.places, owner, axis=2)[left_owns]
    return float(np.median(np.linalg.norm(trace.places[left_owns][:, 11:] - place, axis=-1).min(axis=1)))


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw every quantity relative to GRF's, one panel per difficulty."""
    rows = measure(effort)
    panels = []
    for setting in SETTINGS:
        here = [row for row in rows if row.name.startswith(setting)]
        order = np.arange(len(here))
        shares = [row.ours / row.grf for row in here]
        panels.append(Panel(setting, (order, np.ones(len(here))), (order, shares), "row", "times GRF's", points=True))
    draw_panels(path, TITLE, panels)
