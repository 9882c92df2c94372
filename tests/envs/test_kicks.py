"""Shots and passes: whom, where to, when and how fast, against the measured tables."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import OPEN, play, position, speeds

from regista.envs.football.constants import (
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
    NOBODY,
    RIGHT,
    SHORT_PASS,
    SHOT,
    SPRINT,
)
from regista.envs.football.simulator import step_everybody
from regista.envs.football.skills.first_touch import difficulty
from regista.envs.football.skills.kicks import aim_again, delay, gauge, swing_legs
from regista.envs.football.skills.passes import choose_mate, place_of


def shoot(x: float, y: float, keys: list[int], presses: int = 1, seeds: int = 40) -> dict[str, np.ndarray]:
    """Let many lone strikers at (x, y) with the ball press the keys, then shoot.

    The delay counts steps as the measurements do: 3 when the ball moves at the end of the third step after the one
    in which the button was pressed first.
    """
    players = [(x, y, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (x + 0.45, y), OPEN, range(seeds))
    play(matches, [0] + keys)
    result = {"delay": np.full(seeds, np.nan), "speed": np.zeros(seeds), "line_y": np.zeros(seeds)}
    for step, action in enumerate([SHOT] * presses + [0] * 12):
        play(matches, [action])
        ball = matches["ball"]
        speed = np.hypot(ball["vx"], ball["vy"])
        new = np.isnan(result["delay"]) & (speed > 15.0)
        result["delay"][new] = step
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
    """Delay within a step, speed within 10 %, the place on the goal line within 1.25 m (0.015 units)."""
    result = shoot(x, y, keys, presses)
    assert not np.isnan(result["delay"]).any()
    assert result["delay"].mean() == pytest.approx(delay, abs=1.0)
    assert result["speed"].mean() == pytest.approx(speed, rel=0.1)
    assert result["line_y"].mean() == pytest.approx(line_y, abs=1.25)


def test_shots_scatter() -> None:
    straight, turned = shoot(43.5, 0.0, [DIRECTION_RIGHT]), shoot(43.5, 0.0, [DIRECTION_TOP])
    assert 0.05 < straight["line_y"].std() < 0.4
    assert turned["line_y"].std() > 2 * straight["line_y"].std()


def test_turning_round_takes_time() -> None:
    """Measured: 8 steps with the back to the goal, when he has only just started to run away from it."""
    assert shoot(43.5, 0.0, [DIRECTION_LEFT])["delay"].mean() == pytest.approx(8.0, abs=0.8)
    standing = [delay(SHOT, angle, 0.0, False, 10.0) for angle in (0.0, 1.0, 1.5, 3.0)]
    running = [delay(SHOT, angle, 5.0, True, 10.0) for angle in (0.0, 1.0, 1.5, 3.0)]
    assert standing == sorted(standing) and running == sorted(running)
    assert running[0] < standing[0] and running[-1] < standing[-1]


def test_a_button_held_with_the_back_to_the_goal_shoots() -> None:
    """In the original he never kicks; here he turns and shoots towards the goal, once the gauge is full."""
    players = [(40.0, 5.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (39.6, 5.0), OPEN, range(20))
    fastest = np.zeros(20)
    for _ in range(14):
        play(matches, [SHOT])
        fastest = np.maximum(fastest, matches["ball"]["vx"])
    assert (fastest > 15.0).all()


def test_the_gauge_fills_with_the_time_that_the_button_is_held() -> None:
    assert gauge(1) == pytest.approx(40 / 940)
    assert gauge(4) == pytest.approx(340 / 940)
    assert gauge(20) == 1.0


def test_a_shot_across_the_body_curls_back() -> None:
    """It starts off further out than it crosses the goal line."""
    players = [(43.5, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (44.0, 0.0), OPEN, range(40))
    play(matches, [0, *[DIRECTION_TOP_RIGHT] * 3, SHOT])
    first, last = np.full(40, np.nan), np.full(40, np.nan)
    for _ in range(12):
        play(matches, [0])
        ball = matches["ball"]
        flies = (ball["vx"] > 15.0) & (ball["x"] < 52.0)
        crossing = ball["y"] + (HALF_LENGTH - ball["x"]) * ball["vy"] / np.where(flies, ball["vx"], 1.0)
        first[flies & np.isnan(first)] = crossing[flies & np.isnan(first)]
        last[flies] = crossing[flies]
    assert np.mean(first - last) > 0.1


@pytest.mark.parametrize(
    ("kick", "least", "most"), [(SHORT_PASS, 10.0, 28.0), (LONG_PASS, 10.0, 28.0), (HIGH_PASS, 1.0, 6.0)]
)
def test_a_pass_across_the_body_curls_away_from_it(kick: int, least: float, most: float) -> None:
    """The faster the more: measured 35 to 60 degrees off the run, of 18 m/s 8 degrees/s, here of 23 m/s."""
    players = [(0.0, 0.0, LEFT, CM), (14.0, 14.0, LEFT, CM), (54.0, 33.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0), OPEN, range(20))
    play(matches, [DIRECTION_RIGHT] * 8 + [DIRECTION_TOP_RIGHT, kick], player=0)
    angles = []
    for _ in range(14):
        play(matches, [0], player=0)
        ball = matches["ball"]
        angles.append(np.where(np.hypot(ball["vx"], ball["vy"]) > 9.0, np.arctan2(ball["vy"], ball["vx"]), np.nan))
    turned = np.degrees(np.diff(np.array(angles), axis=0)) / 0.1
    assert least < np.nanmean(turned[:8]) < most


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
    chosen = choose_mate(matches[0], 0, ux, uy, gauge(1))
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
    matches["players"]["down_wait"][:, 1] = 100.0  # he waits for the ball where he is
    play(matches, [0] * 5 + [kick], player=0)
    x, z = [], []
    for _ in range(3 + int(distance / 3)):
        play(matches, [0], player=0)
        x.append(matches["ball"]["x"][0])
        z.append(matches["ball"]["z"][0])
    assert np.max(np.diff(x) / 0.1) == pytest.approx(speed, rel=0.06)
    assert np.max(z) == pytest.approx(apex, abs=max(0.4, 0.25 * apex))


@pytest.mark.parametrize("held", [0, 1])
def test_who_asks_for_a_pass_from_rest_goes_on_at_a_walk_until_it_leaves(held: int) -> None:
    """Measured: 1.1 to 1.5 m at 3 to 3.8 m/s, where the direction was pressed 0 to 2 steps before."""
    players = [(0.0, 0.0, LEFT, CM), (20.0, 5.0, LEFT, CM), (50.0, 20.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0), OPEN)
    fast, _ = speeds(matches, [0, 0, 0, DIRECTION_RIGHT, *[0] * held, SHORT_PASS, 0, 0, 0, 0])
    assert 2.0 < fast[-2:].mean() < 4.0
    assert fast.max() < 4.5


@pytest.mark.parametrize(("left", "mate"), [(0.35, 2), (0.2, 1)])
def test_a_pass_is_for_whom_the_keys_say_until_shortly_before_it_leaves(left: float, mate: int) -> None:
    """Measured: keys that change 0.4 s before the contact choose another mate, in the last 0.25 s they do not."""
    players = [(0.0, 0.0, LEFT, CM), (12.0, 14.0, LEFT, CM), (12.0, -14.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0))
    passer = matches["players"][0, 0]
    passer["kick"], passer["kick_held"], passer["kick_ready"], passer["kick_wait"] = SHORT_PASS, 1, True, left
    passer["aim_x"], passer["aim_y"], passer["kick_mate"], passer["direction"] = 12.0, 14.0, 1, DIRECTION_BOTTOM_RIGHT
    matches["carrier"], matches["kicker"], matches["last_touch"], matches["players"]["vx"][0, 0] = 0, 0, 0, 3.0
    swing_legs(matches[0])
    assert passer["kick_mate"] == mate
    assert (passer["aim_x"], passer["aim_y"]) == pytest.approx((12.0, -14.0) if mate == 2 else (12.3, 14.0))


@pytest.mark.parametrize(("degrees", "turned", "mate"), [(20, 20, 2), (40, 27, 2), (60, 0, 1)])
def test_other_keys_turn_a_pass_that_leaves_as_far_as_a_foot_can(degrees: int, turned: int, mate: int) -> None:
    """As read in the original: up to 27 degrees it is another's, up to 54 it is turned so far towards him."""
    angle = np.radians(degrees)
    players = [(0.0, 0.0, LEFT, CM), (15.0, 0.0, LEFT, CM), (9.0 * np.cos(angle), 9.0 * np.sin(angle), LEFT, CM)]
    matches = position(players, (0.0, 0.0))
    passer = matches["players"][0, 0]
    passer["kick"], passer["kick_held"], passer["direction"] = SHORT_PASS, 1, DIRECTION_TOP_RIGHT
    passer["aim_x"], passer["aim_y"], passer["kick_mate"] = 15.0, 0.0, 1
    if degrees > 45:
        passer["direction"] = DIRECTION_TOP
    aim_again(matches[0], 0)
    assert np.degrees(np.arctan2(passer["aim_y"], passer["aim_x"])) == pytest.approx(turned, abs=1.0)
    assert passer["kick_mate"] == mate


def test_a_longer_press_looks_further() -> None:
    """Of two mates ahead, the one 8 m away gets a pass of a short press, the one at 33 m that of a long one."""
    players = [(0.0, 0.0, LEFT, CM), (8.0, 0.0, LEFT, CM), (33.0, 0.0, LEFT, CM)]
    matches = position(players, (0.4, 0.0))
    matches["players"]["kick"][0, 0] = SHORT_PASS
    assert choose_mate(matches[0], 0, 1.0, 0.0, gauge(1)) == 1
    assert choose_mate(matches[0], 0, 1.0, 0.0, gauge(5)) == 2


def test_a_pass_leads_a_running_mate() -> None:
    players = [(0.0, 0.0, LEFT, CM), (12.0, -6.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0))
    matches["players"]["vy"][0, 1] = 5.0
    place = place_of(matches["ball"][0], matches["players"][0, 1])
    assert place == pytest.approx((12.0, -6.0 + 5.0 * 0.7 * (0.3 + 0.05 * np.hypot(11.6, 6.0)) ** 0.7), abs=0.05)


@pytest.mark.parametrize(("height", "kick", "slower"), [(0.11, SHOT, 0.0), (1.6, SHOT, 3.0), (1.6, SHORT_PASS, 0.0)])
def test_a_ball_that_comes_is_played_on_first_time(height: float, kick: int, slower: float) -> None:
    """Volleys and headers: who has asked for a kick does not stop the ball; a headed shot is weaker."""
    players = [(40.0, 0.0, LEFT, CM), (45.0, 10.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (39.0, 0.0), OPEN, range(20))
    matches["ball"]["vx"], matches["ball"]["z"], matches["ball"]["vz"] = 8.0, height, 1.0
    matches["players"]["direction"][:, 0] = DIRECTION_RIGHT
    matches["players"]["kick"][:, 0], matches["players"]["kick_held"][:, 0] = kick, 1
    matches["players"]["kick_patience"][:, 0], matches["players"]["facing_x"][:, 0] = 20, 1.0
    play(matches, [0, 0])
    speed = np.hypot(matches["ball"]["vx"], matches["ball"]["vy"])
    assert (matches["carrier"] == NOBODY).all() and (matches["last_touch"] == 0).all()
    assert speed.min() > (15.0 - slower if kick == SHOT else 8.0)


@pytest.mark.parametrize(("height", "struck"), [(0.11, 1.0), (0.9, 0.15)])
def test_a_ball_too_high_for_the_foot_is_stopped_before_a_shot(height: float, struck: float) -> None:
    """Measured: balls at 0.6 to 1.3 m are struck as they come in 14% of 194 receptions, lower ones in all of 189."""
    players = [(40.0, 0.0, LEFT, CM), (45.0, 10.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (39.0, 0.0), OPEN, range(200))
    matches["ball"]["vx"], matches["ball"]["z"], matches["ball"]["vz"] = 8.0, height, 0.5
    matches["players"]["kick"][:, 0], matches["players"]["kick_held"][:, 0] = SHOT, 1
    matches["players"]["kick_patience"][:, 0], matches["players"]["facing_x"][:, 0] = 20, 1.0
    play(matches, [0, 0])
    assert matches["was_kicked"].mean() == pytest.approx(struck, abs=0.1)


def test_who_shoots_a_ball_as_it_comes_slows_down_for_it() -> None:
    """Measured: 3.1 m/s at the contact, in the mean of 127 shots of receivers who ran up to 6 m/s."""
    players = [(40.0, 0.0, LEFT, CM), (45.0, 10.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (41.0, 0.0), OPEN, range(20))
    matches["ball"]["vx"], matches["players"]["vx"][:, 0] = -8.0, 6.0
    matches["players"]["direction"][:, 0], matches["players"]["facing_x"][:, 0] = DIRECTION_RIGHT, 1.0
    matches["players"]["kick"][:, 0], matches["players"]["kick_held"][:, 0] = SHOT, 1
    matches["players"]["kick_patience"][:, 0] = 20
    play(matches, [0])
    assert (matches["ball"]["vx"] > 10.0).all()
    assert matches["players"]["vx"][:, 0].max() < 4.0


def test_the_ball_rests_at_the_feet_after_a_reception() -> None:
    """Measured: a pass over 10 m comes at 11 m/s; after the first touch it moves at about 1.3 m/s."""
    players = [(-27.0, 0.0, LEFT, CM), (-17.0, 0.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (-26.6, 0.0), OPEN, range(20))
    play(matches, [0] * 3 + [SHORT_PASS] + [0] * 4, player=0)
    speed = np.full(20, np.nan)
    for _ in range(14):
        play(matches, [0], player=0)
        ball = matches["ball"]
        new = (matches["carrier"] == 1) & np.isnan(speed)
        mate = matches["players"][:, 1]
        speed[new] = np.hypot(ball["vx"] - mate["vx"], ball["vy"] - mate["vy"])[new]
        assert np.hypot(ball["x"] - mate["x"], ball["y"] - mate["y"])[new].max(initial=0.0) < 1.0
    assert speed.mean() == pytest.approx(1.3, abs=0.6) and speed.max() < 2.5


def test_a_pass_is_hard_to_take_away_just_after_the_kick() -> None:
    """An opponent a meter away cannot control it; 1 s later anybody can."""
    players = [(0.0, 0.0, LEFT, CM), (1.0, 0.0, RIGHT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (0.8, 0.0))
    matches["ball"]["vx"] = 15.0
    matches["last_touch"], matches["was_kicked"], matches["kick_age"] = 0, True, 0.0
    rival = matches["players"][0, 1]
    assert difficulty(matches[0], rival)[0] > 0.4
    matches["kick_age"] = 1.0
    assert difficulty(matches[0], rival)[0] < 0.2


def test_a_pass_reaches_the_mate() -> None:
    players = [(-27.0, 0.0, LEFT, CM), (-12.0, 0.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)]
    matches = position(players, (-26.6, 0.0))
    play(matches, [0] * 5 + [SHORT_PASS] + [0] * 14, player=0)
    assert matches["carrier"][0] == 1
    assert matches["reported_owner"][0] == 1


def test_a_shot_asked_for_too_early_waits_for_the_ball_for_2_s() -> None:
    """The ball is 0.9 or 5 m away: the shot comes. It is 16 m away: the shot is forgotten."""
    for gap, shot in ((0.9, True), (5.0, True), (16.0, False)):
        players = [(30.0, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
        matches = position(players, (30.0 + gap, 0.0))
        fastest = 0.0
        for action in [SHOT] + [0] * 25:
            play(matches, [action])
            fastest = max(fastest, matches["ball"]["vx"][0])
        assert (fastest > 20.0) == shot


@pytest.mark.parametrize(("mate", "key", "least", "most"), [((0.0, 22.0), 3, 0.35, 0.65), ((22.0, 0.0), 5, 0.0, 0.0)])
def test_half_of_the_passes_across_the_pitch_fly(
    mate: tuple[float, float], key: int, least: float, most: float
) -> None:
    """Measured: 10 of 30, and 4 of 16; those of the episodes that the original plays in a mirror."""
    players = [(0.0, 0.0, LEFT, CM), (*mate, LEFT, CM), (-54.0, 0.0, LEFT, GK), (54.0, 30.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0), seeds=range(100))
    highest = np.zeros(100)
    for action in [key, SHORT_PASS] + [0] * 12:
        play(matches, [action], 0)
        highest = np.maximum(highest, matches["ball"]["z"])
    assert least <= np.mean(highest > 0.7) <= most


def test_a_shot_keeps_its_direction_while_the_run_takes_the_foot_elsewhere() -> None:
    """Passes are aimed again when they leave the foot, shots are not: so a run across the goal takes them along."""
    players = [(40.0, -6.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (40.4, -6.0), OPEN, range(40))
    play(matches, [0, *[DIRECTION_TOP] * 8, SHOT, 0])
    kicking = matches["kicker"] >= 0
    assert kicking.any()
    player = matches["players"][kicking, 0]
    meant = np.arctan2(player["aim_y"] - player["y"], player["aim_x"] - player["x"])
    play(matches, [0])
    player = matches["players"][kicking, 0]
    still = matches["kicker"][kicking] >= 0
    now = np.arctan2(player["aim_y"] - player["y"], player["aim_x"] - player["x"])
    assert np.abs(now - meant)[still].max() < 0.001


def test_who_has_asked_for_a_kick_plays_the_ball_that_a_mate_leads() -> None:
    """Measured in meetings drawn at random: of 246 shots 37 % change the ball by more than 6 m/s, half hit nothing; no
    other mate kicks it, and nobody who has missed goes on asking.
    """
    players = [(-6.0, 0.0, LEFT, CM), (0.0, 0.4, LEFT, CM), (-50.0, 33.0, RIGHT, GK)]
    matches = position(players, (-5.5, 0.0), OPEN, range(80))
    asks, fastest = np.arange(80) < 60, np.zeros(80)
    actions = np.full((80, 3), DIRECTION_RIGHT)
    actions[:, 1] = actions[:, 2] = 0
    for step in range(24):
        actions[asks, 1] = SHOT if step == 6 else 0
        step_everybody(matches, actions)
        fastest = np.maximum(fastest, np.hypot(matches["ball"]["vx"], matches["ball"]["vy"]))
    assert 0.25 < (fastest[asks] > 11.0).mean() < 0.75 and (fastest[~asks] < 11.0).all()
    assert (matches["players"]["kick"][:, 1] == 0).all()


@pytest.mark.parametrize(("distance", "keys", "least", "most"), [(0.79, [0], 0.0, 0.05), (1.0, [SHOT] * 3, 1.2, 2.2)])
def test_who_stands_puts_out_a_leg_or_shoots_from_the_run(
    distance: float, keys: list[int], least: float, most: float
) -> None:
    """Drawn scenes, 7 steps, no direction: up to 0.83 m off he stays (0 to 0.1 m); who asks runs on (1.6 to 2.4 m)."""
    matches = position([(0.0, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)], (distance, 0.0), OPEN, range(20))
    play(matches, [0, *keys, *[0] * (6 - len(keys))])
    way = np.hypot(matches["players"]["x"][:, 0], matches["players"]["y"][:, 0])
    assert least <= way.min() and way.max() < most
    assert (matches["last_touch"] == 0).all()


def test_sprint_and_dribble_do_not_free_who_has_the_ball_before_him() -> None:
    """Drawn scenes: with the ball 1.06 m off he goes 0.7 m in 7 steps."""
    matches = position([(0.0, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)], (1.04, 0.0), OPEN, range(10))
    matches["players"]["sprint"][:, 0] = matches["players"]["dribble"][:, 0] = True
    play(matches, [0] * 7)
    assert (matches["players"]["x"][:, 0] > 0.2).all() and (matches["last_touch"] == 0).all()


def test_who_stops_with_a_ball_that_rested_does_so_before_his_keys_lead() -> None:
    """Drawn scenes: a key aside, two or three steps after he set off, moves him a step later than if he ran freely."""
    matches = position([(0.0, 0.0, LEFT, CM), (-50.0, 33.0, RIGHT, GK)], (1.2, 0.0), OPEN, range(20))
    play(matches, [SPRINT, 0, 0, DIRECTION_TOP, 0])
    striker = matches["players"][:, 0]
    assert (matches["carrier"] == 0).all() and (np.hypot(striker["vx"], striker["vy"]) < 1.0).all()
    assert (striker["y"] < 0.01).all() and (np.abs(matches["ball"]["x"] - 1.2) < 0.15).all()
