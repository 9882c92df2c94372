"""The ball's flight, bounce, roll and spin against measured traces; posts and crossbar."""

from __future__ import annotations

import numpy as np
import pytest

from regista.envs.football.constants import BALL_RADIUS, GOAL_HEIGHT
from regista.envs.football.physics.ball import advance_ball, rolled
from regista.envs.football.state import BALL


def flown(steps: int, **start: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return speed along x over each step, x and z after each, of a ball thus started."""
    ball = np.zeros(1, BALL).view(np.recarray)
    ball["z"] = BALL_RADIUS
    for name, value in start.items():
        ball[name] = value
    x, z = [ball["x"][0]], []
    for _ in range(steps):
        for _ in range(10):
            advance_ball(ball[0])
        x.append(ball["x"][0])
        z.append(ball["z"][0])
    return np.diff(x) / 0.1, np.array(x[1:]), np.array(z)


def test_a_resting_ball_rests() -> None:
    speed, x, z = flown(5)
    assert not speed.any() and not x.any() and (z == BALL_RADIUS).all()


def test_ground_pass_rolls_out_as_measured() -> None:
    """A 20 m ground pass, speed per step from the second step on; within 8 % (a bounce may fall a step later)."""
    measured = [22.8, 22.1, 20.0, 18.7, 16.8, 15.1, 13.8, 12.7, 11.7, 10.9, 10.1]
    speed, _, _ = flown(11, vx=23.24, vz=1.84, z=0.196, spin_x=5.2)
    assert speed == pytest.approx(measured, rel=0.08)


def test_high_pass_flies_as_measured() -> None:
    """A 20 m high pass until it lands; speed within 3 %."""
    measured = [16.6, 16.1, 15.7, 15.3, 15.0, 14.6, 14.3, 14.0, 13.7, 13.5]
    speed, _, z = flown(10, vx=16.8, vz=5.7, z=1.01, spin_x=-1.5)
    assert speed == pytest.approx(measured, rel=0.03)
    assert z.max() == pytest.approx(2.73, abs=0.1)


def test_shot_slows_down_as_measured() -> None:
    measured = [24.9, 24.0, 23.1, 22.3, 21.6, 20.9, 20.3]
    speed, _, _ = flown(7, vx=25.3, vz=4.2, z=0.3, spin_x=-1.5)
    assert speed == pytest.approx(measured, rel=0.03)


def test_a_slow_ball_stops() -> None:
    """Below 2 m/s it loses about 1.65 m/s each second."""
    speed, x, _ = flown(30, vx=2.0, spin_x=2.0)
    assert speed[-1] == 0.0
    assert x[-1] == pytest.approx(2.0**2 / (2 * 1.68), rel=0.06)


def test_bounce_keeps_what_the_original_keeps() -> None:
    """Dropped from 1 m: 4.18 m/s down become 0.62 × 4.18 − 0.06 up, that is 0.33 m high."""
    _, _, z = flown(12, z=1.0 + BALL_RADIUS)
    assert z[6:].max() == pytest.approx(BALL_RADIUS + (0.62 * 4.18 - 0.06) ** 2 / (2 * 9.81), abs=0.03)


def test_backspin_slows_and_topspin_carries() -> None:
    assert flown(10, vx=10.0, spin_x=12.0)[1][-1] > flown(10, vx=10.0, spin_x=-5.0)[1][-1] + 0.2


def test_a_post_throws_the_ball_back() -> None:
    """
    ----→ o   straight at the post at (55, 3.7): it comes back with 0.8 of its speed
    """
    speed, x, _ = flown(3, x=53.0, y=3.7, z=1.2, vx=25.0, vz=1.0)
    assert x.max() < 55.0
    assert speed[-1] == pytest.approx(-0.8 * 24.0, rel=0.06)


def test_a_ball_inside_the_post_goes_in() -> None:
    _, x, _ = flown(3, x=53.0, y=3.4, vx=25.0)
    assert x[-1] > 55.17


def test_the_crossbar_throws_the_ball_back() -> None:
    _, x, _ = flown(3, x=54.0, z=GOAL_HEIGHT, vx=25.0)
    assert x.max() < 55.0


@pytest.mark.parametrize("speed", [25.0, 5.0, 0.5])
def test_estimates_for_the_players(speed: float) -> None:
    """What players expect of the ball is near what it does."""
    _, x, _ = flown(10, vx=speed, spin_x=speed)
    assert rolled(speed, 1.0) == pytest.approx(x[-1], rel=0.35)


@pytest.mark.parametrize("curl", [-60.0, 0.0, 25.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_curling_ball_bends_to_its_side(curl: float, way: float) -> None:
    ball = np.zeros(1, BALL).view(np.recarray)
    ball["z"], ball["vx"], ball["vy"], ball["vz"], ball["curl"] = 0.3, 28.0 * way, 2.0, 4.5, curl
    straight = 2.0 / 28.0 * 18.0
    for _ in range(200):
        advance_ball(ball[0])
        if abs(ball["x"][0]) > 18.0:
            break
    assert np.sign(np.round(ball["y"][0] - straight, 1)) == np.sign(curl * way)


def test_a_pass_with_reversed_spin_flies() -> None:
    """Measured height after each step of a ground pass across the pitch at 23.4 m/s, in an episode that is mirrored."""
    measured = [0.34, 0.58, 0.78, 0.95, 1.09, 1.18, 1.24, 1.25, 1.21, 1.13]
    _, _, mirrored = flown(10, vy=23.4, vz=2.57, spin_y=-5.2)
    assert mirrored == pytest.approx(measured, abs=0.1)
    _, _, plain = flown(10, vy=23.4, vz=2.57, spin_y=5.2)
    assert plain.max() < 0.4
