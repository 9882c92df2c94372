"""Measure passes of a runner in drawn scenes, and fit their curl (`skills/passes.py`, `FLIGHT.curl`).

A player runs with the ball and passes to the only teammate, at any place, so that kicks leave at all angles to the
body. A row is a pass when it is first seen off the foot. It contains the angle between the body and the ball's course,
and the curl of the ball in the next step. Read next: `saves.py`, whose `turning` finds the curl.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lab.calibration.regression import columns
from lab.calibration.saves import BALL, turning
from lab.calibration.scenes import Recording, record
from lab.grf.stage import Stage
from regista.envs.football.constants import CF, HIGH_PASS, IDLE, LEFT, LONG_PASS, SHORT_PASS
from regista.envs.football.kick_off import Roster
from regista.envs.football.skills.passes import FLIGHT, Flight
from regista.envs.football.skills.shots import CURL

SCENE = """ego = LeftCF at Range(-20, 20) @ 0, with allowCollisions True
LeftCF at Range(-70, 70) @ Range(-38, 38), with allowCollisions True
LeftGK at -99 @ 0
RightGK at 99 @ 0
Ball at (ego.position.x + 1.2) @ 0, with allowCollisions True
"""
PLAYER, STEPS, LONGEST_RUN = 1, 24, 10
KICKED, RUNS = 7.0, 2.0  # m/s between ball and player at a kick; minimum m/s of a runner, who faces the run
SPREAD, MOST = 6.0, 200.0  # rad/s; larger curls mean that the ball has hit something


def passes_kicked(count: int, engine: str, seed: int) -> list[dict[str, Any]]:
    """Play `count` episodes; return a row for every pass of a runner."""
    rng = np.random.default_rng([seed, 5])
    keys = np.full((count, STEPS), IDLE)
    keys[:, 0] = rng.integers(1, 9, count)
    keys[np.arange(count), rng.integers(3, LONGEST_RUN + 1, count)] = rng.choice(
        (SHORT_PASS, LONG_PASS, HIGH_PASS), count
    )
    recording = record(SCENE, keys, engine, seed)
    found = [(episode, step) for episode in range(count) if (step := kicked(recording, episode)) is not None]
    ball = np.array([recording.ball[episode, step] for episode, step in found])
    later = np.array([recording.ball[episode, step + 1, 3:5] for episode, step in found])
    stage = Stage([(0.0, 0.0)], (0.0, 0.0), Roster([LEFT], [CF]), n=len(found))
    for name, column in zip(BALL, ball.T, strict=True):
        stage.matches["ball"][name] = column
    curl = turning(stage.matches, *later.T)
    rows = []
    for (episode, step), struck, spin in zip(found, ball, curl, strict=True):
        run = recording.players[episode, step - 1, PLAYER, 2:]
        turn = np.arctan2(struck[3] * run[1] - struck[4] * run[0], struck[3] * run[0] + struck[4] * run[1])
        high = int((keys[episode] == HIGH_PASS).any())
        numbers = {"turn": float(turn), "speed": float(np.linalg.norm(struck[3:])), "curl": float(spin)}
        if abs(spin) < MOST:
            rows.append({name: round(number, 3) for name, number in numbers.items()} | {"high": high})
    return rows


def kicked(recording: Recording, episode: int) -> int | None:
    """Return the step before which a pass leaves a runner's foot and flies freely; None if there is none."""
    pressed = int(np.argmax(recording.keys[episode] >= LONG_PASS))
    ball, player = recording.ball[episode, :, 3:5], recording.players[episode, :, PLAYER, 2:]
    for step in range(pressed + 1, int(recording.lengths[episode]) - 1):
        if np.linalg.norm(ball[step] - player[step]) > KICKED:
            free = np.linalg.norm(ball[step + 1] - ball[step]) < 0.25 * np.linalg.norm(ball[step])
            return step if free and np.linalg.norm(player[step - 1]) > RUNS else None
    return None


def prepare(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Return passes `[R, 4]`: turn, speed, curl, whether high."""
    return np.column_stack(columns(rows, "turn", "speed", "curl", "high"))


def curl_law(law: Flight, seen: np.ndarray) -> np.ndarray:
    """Return the curl `[R]` in rad/s, as in `play_pass`."""
    turn, speed, _, high = seen.T
    folded = np.where(np.abs(turn) > 0.5 * np.pi, np.copysign(np.pi - np.abs(turn), turn), turn)
    lean = CURL.bend / np.pi * (CURL.slow + CURL.fast * np.minimum(speed / CURL.fastest, 1.0))
    share = np.where(high > 0.0, law.high_bend, 1.0)
    return law.curl * share * CURL.bend / np.pi * folded / (1.0 - share * lean)


def losses(seen: np.ndarray, law: Flight) -> np.ndarray:
    """Return the losses `[R]` of a law, robust to outliers."""
    return np.log1p(((curl_law(law, seen) - seen[:, 2]) / SPREAD) ** 2)


def summary(seen: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return the mean curl per turn of the body, in rad/s per rad, measured and from the shipped law."""
    ground = seen[(seen[:, 3] == 0.0) & (np.abs(seen[:, 0]) < 0.5 * np.pi)]
    slopes = [float(np.polyfit(ground[:, 0], curl, 1)[0]) for curl in (ground[:, 2], curl_law(FLIGHT, ground))]
    return {"curl of ground passes, rad/s per rad of turn": (slopes[0], slopes[1])}
