"""Fit `SAVE`, the odds of a save, to measured shots on target.

`follow_shot` of the simulator computes the time, the gap and the effort to meet a shot. Its inputs are the measured
keeper and ball, traced back to the kick. The probabilities of the law are fitted by maximum likelihood to goals and
saves. Held fixed are the numbers at which the law changes (`sudden`, `on_line`, `off_line`), and `dive_from` and
`dive_range`, which these shots do not identify. Read next: `regression.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from lab.calibration.regression import bernoulli, columns
from lab.calibration.shots_at_keeper import measure as measure
from lab.grf.stage import Stage
from regista.envs.football.constants import BALL_RADIUS, CF, DT, GK, HALF_LENGTH, LEFT, RIGHT
from regista.envs.football.kick_off import Roster
from regista.envs.football.physics.ball import advance_ball
from regista.envs.football.physics.pitch import in_box_of
from regista.envs.football.skills.saves import DIVE, SAVE, SaveOdds, follow_shot
from regista.kernels.jit import kernel

LAW, NAMES = SAVE, ("body", "body_gap", "hands", "halfway", "line_halfway", "effort")
TIMES = (0.0, 0.22, 0.35, 0.45, 0.6, 9.0)  # s
BALL, KEEPER = ("x", "y", "z", "vx", "vy", "vz"), ("x", "y", "vx", "vy")
DRAG, GRAVITY = 0.0175, 9.8  # share of its speed that a shot loses per m, and m/s²; to trace it back to the kick


@kernel
def fly_a_step(matches):
    """Let each match's ball fly for a step."""
    for e in range(len(matches)):
        for _ in range(10):
            advance_ball(matches[e].ball)


@kernel
def follow_all(matches, result):
    """Write the results of following each match's shot: effort in m/s, gap in m, time in s, 1 if hands are allowed."""
    for e in range(len(matches)):
        keeper = matches[e].players[1]
        _, result[e, 0], result[e, 1], result[e, 2] = follow_shot(matches[e], keeper, HALF_LENGTH)
        result[e, 3] = in_box_of(RIGHT, keeper.x, keeper.y)


def features(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return effort, gap, time, whether the keeper is in the box, and the keeper's m before the line, `[R, 5]`."""
    stage = Stage([(0.0, 0.0), (1.0, 0.0)], (0.0, 0.0), Roster([LEFT, RIGHT], [CF, GK]), n=len(rows))
    ball, keeper = stage.matches["ball"], stage.matches["players"][:, 1]
    for name, column in zip(BALL, columns(rows, *BALL), strict=True):
        ball[name] = column
    ball["curl"] = turning(stage.matches.copy(), *columns(rows, "later_vx", "later_vy"))
    flown, faster = columns(rows, "flown")[0], DRAG * np.hypot(ball["vx"], ball["vy"])
    for name in ("vx", "vy"):
        ball[name] *= 1.0 + faster * flown
    ball["vz"] += GRAVITY * flown
    for name, column in zip(KEEPER, columns(rows, *(f"keeper_{name}" for name in KEEPER)), strict=True):
        keeper[name] = column
    for axis in ("x", "y"):
        ball[axis] -= flown * ball[f"v{axis}"]
        keeper[axis] -= flown * keeper[f"v{axis}"]
    ball["z"] = BALL_RADIUS
    result = np.zeros((len(rows), 4))
    follow_all(stage.matches, result)
    return np.column_stack([result, HALF_LENGTH - keeper["x"]])


def turning(matches: np.ndarray, later_vx: np.ndarray, later_vy: np.ndarray) -> np.ndarray:
    """Return the curl `[R]` in rad/s that reproduces the observed turn of each ball within a step."""
    ball, turned = matches["ball"], []
    vx, vy = ball["vx"].copy(), ball["vy"].copy()
    for curl in (0.0, 1.0):
        there = matches.copy()
        there["ball"]["curl"] = curl
        fly_a_step(there)
        turned.append(np.arctan2(there["ball"]["vy"], there["ball"]["vx"]))
    seen = np.where((later_vx == vx) & (later_vy == vy), turned[0], np.arctan2(later_vy, later_vx))
    return (seen - turned[0]) / (turned[1] - turned[0])


def chances(law: SaveOdds, seen: np.ndarray) -> np.ndarray:
    """Return the probability of a save `[R]`, as in `save_chance`, at the skill of the measured keeper."""
    effort, gap, time, in_box, before = seen.T
    body = np.where(time < law.sudden, law.body * np.maximum(1.0 - (gap / law.body_gap) ** 2, 0.0), 0.0)
    out = np.clip((before - law.on_line) / law.off_line, 0.0, 1.0)
    dives = np.clip((gap - law.dive_from) / max(law.dive_range, 1e-3), 0.0, 1.0)
    late = time - law.halfway - (1.0 - out) * law.line_halfway * dives
    logit = np.clip(law.hands * late - out * law.effort * effort, -50.0, 50.0)
    hands = np.where(effort < DIVE.speed, 1.0 / (1.0 + np.exp(-logit)), 0.0)
    hands *= np.where(in_box > 0.0, 1.0, np.maximum(1.0 - (gap / law.foot_gap) ** 2, 0.0))
    return 1.0 - (1.0 - hands) * (1.0 - body)


def prepare(rows: Sequence[Mapping[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the features `[R, 5]` of shots, and whether each was saved `[R]`."""
    seen, saved = features(rows), columns(rows, "goal")[0] == 0
    told = seen[:, 2] > DT
    return seen[told], saved[told]


def losses(shots: tuple[np.ndarray, np.ndarray], law: SaveOdds) -> np.ndarray:
    """Return the losses `[R]` of a law."""
    return bernoulli(chances(law, shots[0]), shots[1])


def summary(shots: tuple[np.ndarray, np.ndarray]) -> dict[str, tuple[float, float]]:
    """Return the share of saves and the shipped law's prediction, by s until the shot passes."""
    told = {}
    for least, most in pairwise(TIMES):
        there = (shots[0][:, 2] >= least) & (shots[0][:, 2] < most)
        if there.any():
            saved, law = shots[1][there].mean(), chances(SAVE, shots[0][there]).mean()
            told[f"saved, {least:.2f} to {most:.2f} s"] = float(saved), float(law)
    return told
