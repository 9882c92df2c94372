"""Shots and passes: whom, where to, when and how fast, against the measured tables."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import OPEN, play, position

from envs.football.constants import (
    CM,
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_LEFT,
    DIRECTION_RIGHT,
    DIRECTION_TOP,
    DIRECTION_TOP_LEFT,
    DIRECTION_TOP_RIGHT,
    DIRECTION_X,
    DIRECTION_Y,
    GK,
    HALF_LENGTH,
    HIGH_PASS,
    LEFT,
    LONG_PASS,
    RIGHT,
    SHORT_PASS,
    SHOT,
)
from envs.football.kicks import choose_mate, swing_time


def shoot(x: float, y: float, keys: list[int], presses: int = 1, seeds: int = 40) -> dict[str, np.ndarray]:
    """Let many lone strikers at (x, y) settle with the ball, press the keys, then shoot."""
    players = [(x, y, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (x + 0.45, y), OPEN, range(seeds))
    play(matches, [0] * 6 + keys)
    result = {"delay": np.full(seeds, np.nan), "speed": np.zeros(seeds), "line_y": np.zeros(seeds)}
    for step, action in enumerate([SHOT] * presses + [0] * 12):
        play(matches, [action])
        ball = matches["ball"]
        speed = np.hypot(ball["vx"], ball["vy"])
        new = np.isnan(result["delay"]) & (speed > 15.0)
        result["delay"][new] = step + 1
        result["speed"][new] = speed[new]
        slope = np.divide(ball["vy"], ball["vx"], out=np.zeros(seeds), where=ball["vx"] != 0)
        result["line_y"][new] = (ball["y"] + (HALF_LENGTH - ball["x"]) * slope)[new]
    return result


# x, y, keys, presses; measured delay, speed and y on the goal line; measured positions, from `grf/shot_aim.md`
AIM = [
    (43.5, 0.0, [], 1, 3.0, 26.7, -0.3),
    (43.5, 0.0, [DIRECTION_RIGHT], 1, 3.0, 30.6, 0.1),
    (43.5, 0.0, [DIRECTION_RIGHT], 4, 6.0, 33.5, -0.1),
    (43.5, 0.0, [DIRECTION_TOP_RIGHT], 1, 4.4, 31.0, 3.3),
    (43.5, 0.0, [DIRECTION_BOTTOM_RIGHT], 1, 4.4, 31.0, -3.3),
    (43.5, 0.0, [DIRECTION_TOP], 1, 4.5, 26.1, 7.3),
    (35.4, -10.0, [DIRECTION_RIGHT], 1, 4.0, 30.8, -2.8),
    (35.4, -10.0, [DIRECTION_TOP_RIGHT], 1, 3.0, 29.5, 2.0),
    (35.4, -10.0, [DIRECTION_TOP], 1, 5.0, 28.2, 7.1),
    (35.4, 0.0, [DIRECTION_TOP_RIGHT], 1, 4.4, 31.0, 4.0),
]


@pytest.mark.parametrize(("x", "y", "keys", "presses", "delay", "speed", "line_y"), AIM)
def test_shots_as_measured(
    x: float, y: float, keys: list[int], presses: int, delay: float, speed: float, line_y: float
) -> None:
    """Delay within 1 step, speed within 10 %, the place on the goal line within 0.8 m."""
    result = shoot(x, y, keys, presses)
    assert not np.isnan(result["delay"]).any()
    assert result["delay"].mean() == pytest.approx(delay, abs=1.05)
    assert result["speed"].mean() == pytest.approx(speed, rel=0.1)
    assert result["line_y"].mean() == pytest.approx(line_y, abs=0.8)


def test_shots_scatter() -> None:
    straight, turned = shoot(43.5, 0.0, [DIRECTION_RIGHT]), shoot(43.5, 0.0, [DIRECTION_TOP])
    assert 0.05 < straight["line_y"].std() < 0.4
    assert turned["line_y"].std() > 2 * straight["line_y"].std()


def test_turning_round_takes_time() -> None:
    """Measured: 3 steps facing the goal, 4 to 5 for up to a quarter turn, 8 with the back to it."""
    assert shoot(43.5, 0.0, [DIRECTION_LEFT])["delay"].mean() == pytest.approx(8.0, abs=1.0)
    assert swing_time(0.0) < swing_time(0.5) < swing_time(1.0) < swing_time(2.0)


MATES = [(10, 0), (20, 10), (0, 15), (-10, 0), (0, -15), (20, -10)]  # m from the passer
CHOICES = {
    0: (10, 0),
    DIRECTION_RIGHT: (10, 0),
    DIRECTION_TOP_RIGHT: (20, 10),
    DIRECTION_TOP: (0, 15),
    DIRECTION_TOP_LEFT: (-10, 0),
    DIRECTION_LEFT: (-10, 0),
    DIRECTION_BOTTOM: (0, -15),
    DIRECTION_BOTTOM_RIGHT: (20, -10),
}


@pytest.mark.parametrize("kick", [SHORT_PASS, LONG_PASS, HIGH_PASS])
@pytest.mark.parametrize("direction", CHOICES)
def test_passes_choose_the_mate_that_the_original_chooses(kick: int, direction: int) -> None:
    players = [(0.0, 0.0, LEFT, CM), *[(x, y, LEFT, CM) for x, y in MATES]]
    matches = position(players, (0.4, 0.0))
    matches["players"]["kick"][0, 0] = kick
    ux, uy = (DIRECTION_X[direction], DIRECTION_Y[direction]) if direction else (1.0, 0.0)
    chosen = choose_mate(matches[0], 0, ux, uy)
    assert MATES[chosen - 1] == CHOICES[direction]


@pytest.mark.parametrize(
    ("kick", "distance", "speed", "apex"),
    [
        (SHORT_PASS, 10, 15.0, 0.20),
        (SHORT_PASS, 20, 23.2, 0.27),
        (SHORT_PASS, 30, 24.9, 0.69),
        (LONG_PASS, 10, 16.3, 0.21),
        (LONG_PASS, 20, 24.9, 0.36),
        (HIGH_PASS, 10, 12.4, 1.57),
        (HIGH_PASS, 20, 17.4, 2.73),
        (HIGH_PASS, 30, 23.5, 4.42),
        (HIGH_PASS, 40, 30.6, 6.43),
    ],
)
def test_passes_are_as_fast_and_high_as_measured(kick: int, distance: float, speed: float, apex: float) -> None:
    """Speed in the first free step within 6 %; apex within 0.4 m or 25 %."""
    players = [(-27.0, 0.0, LEFT, CM), (-27.0 + distance, 0.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (-26.6, 0.0))
    matches["players"]["down"][:, 1] = 100.0  # he waits for the ball where he is
    play(matches, [0] * 5 + [kick], player=0)
    x, z = [], []
    for _ in range(3 + int(distance / 3)):
        play(matches, [0], player=0)
        x.append(matches["ball"]["x"][0])
        z.append(matches["ball"]["z"][0])
    assert np.max(np.diff(x) / 0.1) == pytest.approx(speed, rel=0.06)
    assert np.max(z) == pytest.approx(apex, abs=max(0.4, 0.25 * apex))


def test_a_pass_reaches_the_mate() -> None:
    players = [(-27.0, 0.0, LEFT, CM), (-12.0, 0.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (-26.6, 0.0))
    play(matches, [0] * 5 + [SHORT_PASS] + [0] * 14, player=0)
    assert matches["carrier"][0] == 1
    assert matches["owner"][0] == 1


def test_a_shot_asked_for_too_early_waits_for_the_ball_a_moment_only() -> None:
    """The ball is 0.9 m away: the shot comes. It is 8 m away: the shot is forgotten."""
    for gap, shot in ((0.9, True), (8.0, False)):
        players = [(30.0, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
        matches = position(players, (30.0 + gap, 0.0))
        fastest = 0.0
        for action in [SHOT] + [0] * 25:
            play(matches, [action])
            fastest = max(fastest, matches["ball"]["vx"][0])
        assert (fastest > 20.0) == shot
