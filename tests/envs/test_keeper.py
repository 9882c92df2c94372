"""Where the keeper stands, when he comes, and what he saves, against what is measured and documented."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import OPEN, play, position, take_over

from regista.envs.football.ai.keeper import bisector_foot, boldness
from regista.envs.football.constants import CM, DIRECTION_RIGHT, DIRECTION_TOP_RIGHT, GK, LEFT, RIGHT, SHOT, SPRINT
from regista.envs.football.physics.ball import advance_ball
from regista.envs.football.skills.hands import is_caught, parry
from regista.envs.football.skills.saves import foresee_shot, save_chance


def keeper_after(steps: int, ball: tuple[float, float], striker: tuple[float, float], with_back: bool) -> np.ndarray:
    """Place of the right keeper, from the middle of his goal, after some steps of an idle striker."""
    players = [(*striker, LEFT, CM), (55.0, 0.0, RIGHT, GK)]
    if with_back:
        players.append((50.0, 3.0, RIGHT, CM))
    matches = position(players, ball)
    play(matches, [0] * steps)
    keeper = matches["players"][0, 1]
    return np.array([keeper["x"], keeper["y"]])


def test_he_stands_high_while_the_ball_is_in_the_other_half() -> None:
    assert keeper_after(60, (-20.0, 10.0), (-20.4, 10.0), False) == pytest.approx([45.0, 0.0], abs=0.3)


def test_one_on_one_he_comes_out_at_a_sprint() -> None:
    """Measured: against a striker who stands at x = 0.75 (14 m) with the ball, he is there after 23 steps."""
    place = keeper_after(22, (41.4, 0.0), (40.8, 0.0), False)
    assert place[0] < 44.0


def test_with_a_back_behind_the_ball_he_stays() -> None:
    assert keeper_after(15, (25.0, 20.0), (24.4, 20.0), True)[0] > 52.0


@pytest.mark.parametrize(("swerves", "least", "most"), [(False, 0.8, 1.0), (True, 0.0, 0.4)])
def test_outside_his_box_he_slides_and_misses_who_swerves(swerves: bool, least: float, most: float) -> None:
    """Measured: of 42 slides at a striker who swerves by 30 to 50 degrees at 21 m, 8 met the ball."""
    matches = position(
        [(1.0, 0.0, LEFT, CM), (54.0, 0.0, RIGHT, GK), (-50.0, 0.0, LEFT, GK)], (1.4, 0.0), OPEN, range(40)
    )
    play(matches, [SPRINT], 0)
    slid, kicked = np.zeros(40, bool), np.zeros(40, bool)
    for _ in range(45):
        striker, keeper = matches["players"][:, 0], matches["players"][:, 1]
        near = swerves and keeper["x"][0] - striker["x"][0] < 21.0
        play(matches, [DIRECTION_TOP_RIGHT if near else DIRECTION_RIGHT], 0)
        slid |= keeper["is_sliding"] & (keeper["down_wait"] > 0.0)
        kicked |= slid & (matches["last_touch"] == 1)
    assert slid.mean() > 0.9
    assert least <= kicked[slid].mean() <= most


def test_the_bisector_halves_the_angle() -> None:
    """From a ball at (-11, 8) relative to the goal: both halves of the angle to the posts are equal."""
    foot = bisector_foot(-11.0, 8.0)
    angles = [np.arctan2(y - 8.0, 11.0) for y in (-3.7, foot, 3.7)]
    assert angles[1] - angles[0] == pytest.approx(angles[2] - angles[1], abs=1e-9)
    assert bisector_foot(-11.0, 0.0) == pytest.approx(0.0)


def test_he_halves_the_angle_from_before_the_line() -> None:
    """Measured: while the ball rests at (38.1, 23.4) he settles at (53.95, 1.75), his foot at x = 54.3."""
    place = keeper_after(25, (38.1, 23.4), (37.5, 23.4), True)
    assert place == pytest.approx((53.95, 1.75), abs=0.25)


# m before his line, m by which the shot passes him, s until then, measured goal rate and of how many
SAVES = [
    (1.5, 0.15, 0.16, 0.24, 25),
    (1.5, 1.25, 0.18, 0.95, 21),
    (1.5, 1.25, 0.31, 0.76, 25),
    (1.5, 1.75, 0.43, 0.64, 28),
    (1.5, 2.50, 0.52, 0.47, 30),
    (1.5, 2.50, 0.57, 0.40, 30),
    (1.5, 1.75, 0.72, 0.00, 44),
    (6.0, 0.12, 0.13, 0.00, 24),
    (6.0, 0.12, 0.25, 0.65, 20),
    (6.0, 0.12, 0.31, 0.79, 29),
    (6.0, 1.25, 0.18, 0.91, 56),
    (6.0, 1.25, 0.31, 0.69, 48),
    (6.0, 1.25, 0.47, 0.26, 27),
    (6.0, 1.75, 0.25, 1.00, 31),
    (6.0, 1.25, 0.75, 0.01, 77),
]


@pytest.mark.parametrize(("out", "gap", "time", "goals", "of"), SAVES)
def test_save_odds_against_measured_shots(out: float, gap: float, time: float, goals: float, of: int) -> None:
    """Within .15 and two standard errors; to a shot within an arm's length he need not run."""
    matches = position([(30.0, 0.0, LEFT, CM), (55.0 - out, 0.0, RIGHT, GK)], (30.0, 0.0))
    effort = max(gap - 1.2, 0.0) / (time - 0.08)
    beaten = 1.0 - save_chance(matches["players"][0, 1], effort, gap, time)
    assert beaten == pytest.approx(goals, abs=0.15 + 2.0 * np.sqrt(beaten * (1.0 - beaten) / of))


def test_one_who_lies_down_stops_only_what_hits_him() -> None:
    matches = position([(30.0, 0.0, LEFT, CM), (50.0, 0.0, RIGHT, GK)], (30.0, 0.0))
    keeper = matches["players"][0, 1]
    keeper["down_wait"] = 0.5
    assert save_chance(keeper, 0.0, 0.5, 0.8) == 0.0
    assert save_chance(keeper, 0.0, 0.0, 0.1) > 0.8


def test_nobody_saves_what_he_cannot_reach() -> None:
    """A shot into the corner from 9 m passes 3.3 m from a keeper who stands in the other one: never saved."""
    matches = position([(46.0, 0.0, LEFT, CM), (54.9, -1.0, RIGHT, GK)], (46.4, 0.0), OPEN, range(100))
    ball = matches["ball"]
    ball["vx"], ball["vy"] = 30.0, 11.0
    for match in matches:
        foresee_shot(match, LEFT)
    assert not matches["save_succeeds"].any()


@pytest.mark.parametrize("curl", [-40.0, 0.0, 40.0])
def test_a_keeper_far_out_goes_where_a_curled_shot_passes_him(curl: float) -> None:
    """He sees where it comes by, however much it bends, and that it ends in the goal."""
    matches = position([(25.0, 0.0, LEFT, CM), (35.0, 0.0, RIGHT, GK)], (25.4, 0.0), OPEN)
    ball = matches["ball"]
    ball["vx"], ball["vy"], ball["vz"], ball["z"], ball["curl"] = 30.0, -0.1 * curl, 1.5, 0.2, curl
    before = ball.copy()
    foresee_shot(matches[0], LEFT)
    assert matches["saver"][0] == 1
    assert (ball == before).all()
    while ball["x"][0] < 35.0:
        advance_ball(ball[0])
    assert matches["save_gap"][0] == pytest.approx(abs(ball["y"][0]), abs=0.3)
    while ball["x"][0] < 55.0:
        advance_ball(ball[0])
    assert abs(ball["y"][0]) < 4.9


def test_a_weaker_keeper_saves_less() -> None:
    matches = position([(30.0, 0.0, LEFT, CM), (54.0, 0.0, RIGHT, GK)], (30.0, 0.0))
    keeper = matches["players"][0, 1]
    strong = save_chance(keeper, 0.0, 1.0, 0.5)
    keeper["skill"] = 0.3
    assert save_chance(keeper, 0.0, 1.0, 0.5) < strong - 0.1


def shots(x: float, y: float, keeper: tuple[float, float], seeds: int = 150) -> tuple[float, float]:
    """Return shares of goals and of balls held when strikers at (x, y) shoot once, standing, facing the goal."""
    matches = position([(x, y, LEFT, CM), (*keeper, RIGHT, GK)], (x + 0.45, y), OPEN, range(seeds))
    goals, held = np.zeros(seeds, bool), np.zeros(seeds, bool)
    for action in [0, SHOT] + [0] * 60:
        play(matches, [action])
        goals |= matches["goal"] > 0
        held |= (matches["keeper_holding"] == 1) & ~goals
    return goals.mean(), held.mean()


def test_a_save_goes_the_way_that_he_dives() -> None:
    """As documented, and measured of 662: 2 of his velocity and 4 m/s out, 0.3 of the ball's speed and 2.5 of his."""
    for dive, way in ((5.0, 1.0), (-5.0, -1.0)):
        matches = position([(30.0, 0.0, LEFT, CM), (53.0, 0.0, RIGHT, GK)], (52.5, way), OPEN)
        ball, keeper = matches["ball"][0], matches["players"][0, 1]
        ball["vx"], keeper["vy"] = 20.0, dive
        matches["last_touch"], matches["was_kicked"], matches["kick_age"] = 0, True, 0.5
        parry(matches[0], 1)
        assert np.hypot(ball["vx"], ball["vy"]) == pytest.approx(0.3 * 20.0 + 2.5 * 5.0, abs=0.1)
        assert ball["vy"] * way > 10.0
        assert ball["vx"] < -5.0


@pytest.mark.parametrize(
    ("speed", "age", "least", "most"), [(15.0, 0.4, 0.0, 0.0), (15.0, 0.8, 0.3, 0.8), (12.0, 1.5, 1.0, 1.0)]
)
def test_what_is_old_and_slow_sticks(speed: float, age: float, least: float, most: float) -> None:
    """Measured: none of 542 saves before 0.55 s, a third of 80 at 0.8 s, 57 of 59 after 1.2 s."""
    matches = position([(30.0, 0.0, LEFT, CM), (53.0, 0.0, RIGHT, GK)], (52.5, 0.0), OPEN, range(200))
    matches["kick_age"] = age
    assert least <= np.mean([is_caught(match, speed) for match in matches]) <= most


def test_from_far_nearly_everything_is_saved() -> None:
    """Measured from 22 m: 0 of 40, three quarters of them held."""
    goals, held = shots(33.0, 0.0, (55.0, 0.0))
    assert goals < 0.1
    assert held > 0.5


def test_off_centre_from_near_most_score() -> None:
    """Measured from 11.9 m, a little to the side: 70 % of 40."""
    assert 0.4 < shots(44.0, -4.2, (55.0, 0.0))[0] < 0.9


def test_an_empty_goal_is_empty() -> None:
    assert shots(35.0, 3.0, (40.0, -17.0))[0] > 0.85


def test_a_shot_off_the_post_is_forgotten() -> None:
    """The keeper does not wait for ever where he meant to meet a shot that came back: he goes for the ball."""
    matches = position([(0.0, 30.0, LEFT, CM), (53.0, 0.0, RIGHT, GK)], (40.0, 3.0))
    matches["saver"], matches["save_x"], matches["save_y"], matches["save_wait"] = 1, 54.0, 3.0, 0.2
    play(matches, [0] * 30)
    assert matches["saver"][0] == -1
    assert matches["keeper_holding"][0] == 1


def test_a_pass_back_is_not_for_the_hands_but_a_deflection_is() -> None:
    """
    M → K    a mate plays the ball back along the ground: the keeper takes it with his feet, after a ricochet by hand
    """
    for kicked in (True, False):
        matches = position([(30.0, 20.0, LEFT, CM), (52.0, 0.0, RIGHT, GK), (35.0, 0.0, RIGHT, CM)], (46.0, 0.0))
        matches["ball"]["vx"], matches["last_touch"], matches["was_kicked"] = 10.0, 2, kicked
        held, carried = False, False
        for _ in range(12):
            play(matches, [0])
            held |= matches["keeper_holding"][0] == 1
            carried |= matches["carrier"][0] == 1
        assert carried
        assert held == (not kicked)


def test_with_a_free_second_attacker_he_does_not_come_all_the_way() -> None:
    """A lone striker at 20 m is met half way out; one with a free mate near the goal is not."""
    out = []
    for second in ((-20.0, 0.0), (46.0, 8.0)):
        players = [(35.0, -4.0, LEFT, CM), (54.3, 0.0, RIGHT, GK), (*second, LEFT, CM)]
        matches = position(players, (35.4, -4.0))
        play(matches, [0] * 22)
        out.append(55.0 - matches["players"]["x"][0, 1])
    assert out[0] > 6.0
    assert out[1] < out[0] - 2.0


def test_he_waits_for_a_free_mate_but_not_for_ever() -> None:
    """
    K  M o    his only mate has an opponent beside him: the ball stays in the hands for 4 s; free, he gets it sooner
    """
    waits = []
    for rival_y in (2.0, 30.0):
        players = [(-20.0, rival_y, LEFT, CM), (52.0, 0.0, RIGHT, GK), (-20.0, 0.0, RIGHT, CM)]
        matches = position(players, (51.5, 0.0))
        held = 0
        for _ in range(70):
            matches["players"]["x"][0, 0], matches["players"]["y"][0, 0] = -20.0, rival_y
            matches["players"]["x"][0, 2], matches["players"]["y"][0, 2] = -20.0, 0.0
            play(matches, [0])
            held += matches["keeper_holding"][0] == 1
        waits.append(held)
    assert 38 <= waits[0] <= 50
    assert 4 <= waits[1] <= 22


def test_a_high_ball_is_met_where_it_comes_down() -> None:
    """A ball kicked high over 22 m lands in front of a mate 25 m away who goes to meet it."""
    matches = position([(25.0, 3.0, RIGHT, CM), (-50.0, 0.0, LEFT, GK)], (0.0, 0.0))
    take_over(matches, -1)
    ball = matches["ball"]
    ball["vx"], ball["vz"], ball["z"] = 17.4, 6.8, 0.2
    for _ in range(25):
        play(matches, [0])
        if matches["carrier"][0] == 0:
            break
    assert matches["carrier"][0] == 0
    assert 18.0 < ball["x"][0] < 27.0


def test_near_the_ball_a_second_attacker_still_holds_him_back() -> None:
    """Measured before eleven attackers: he goes on going back, at 2 m/s, until the shot from 3.5 m before him."""
    players = [(43.0, 0.0, LEFT, CM), (47.5, 0.0, RIGHT, GK), (43.0, 3.0, LEFT, CM), (-50.0, 0.0, LEFT, GK)]
    both = []
    for second_x in (43.0, -20.0):
        players[2] = (second_x, 3.0, LEFT, CM)
        matches = position(players, (43.5, 0.0), OPEN)
        matches["carrier"], matches["team_in_possession"] = 0, LEFT
        both.append(boldness(matches[0], 1))
    assert both[0] < 0.5 < both[1]
