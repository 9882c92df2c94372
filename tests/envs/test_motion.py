"""Running, turning and stopping against the measured tables, within stated tolerances in m/s."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from pitch import OPEN, dribbler, play, position, runner, speeds

from regista.envs.football.constants import (
    BODY_RADIUS,
    CM,
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_LEFT,
    DIRECTION_RIGHT,
    DIRECTION_TOP,
    DIRECTION_TOP_RIGHT,
    DRIBBLE,
    GK,
    LEFT,
    NOBODY,
    NORMAL,
    RELEASE_DIRECTION,
    RELEASE_SPRINT,
    RIGHT,
    SHORT_PASS,
    SLIDING,
    SPRINT,
)
from regista.envs.football.physics.ball import rolled
from regista.envs.football.physics.motion import plan_motion, take_stance
from regista.envs.football.physics.possession import look_ahead, meeting_time, time_needed

TRACES = Path(__file__).parent / "turn_traces.csv"

# What is pressed first, for how many steps, and then; the measured speeds from that moment on.
WITHOUT_BALL = {
    "run from rest": ([], DIRECTION_RIGHT, [0.0, 1.33, 2.65, 3.53, 4.32, 4.93, 5.0]),
    "stop": ([DIRECTION_RIGHT] * 20, RELEASE_DIRECTION, [5.0, 5.0, 4.3, 1.3, 0.0]),
    "turn 45": ([DIRECTION_RIGHT] * 20, DIRECTION_TOP_RIGHT, [5.0, 5.0, 4.8, 4.8, 5.0]),
    "turn 90": ([DIRECTION_RIGHT] * 20, DIRECTION_TOP, [5.0, 5.0, 4.4, 2.5, 2.9, 3.8, 4.5, 5.0]),
    "turn 180": ([DIRECTION_RIGHT] * 20, DIRECTION_LEFT, [5.0, 5.0, 4.3, 1.4, 0.1, 2.0, 2.9, 3.5, 4.0]),
    "stop a sprint": ([SPRINT] + [DIRECTION_RIGHT] * 40, RELEASE_DIRECTION, [7.8, 7.4, 5.2, 2.0, 0.0]),
    "turn a sprint 90": (
        [SPRINT] + [DIRECTION_RIGHT] * 40,
        DIRECTION_TOP,
        [7.8, 7.4, 5.5, 3.2, 3.5, 4.3, 4.9, 5.5, 5.9, 6.0, 6.4, 6.8, 7.0],
    ),
    "release sprint": ([SPRINT] + [DIRECTION_RIGHT] * 40, RELEASE_SPRINT, [7.8, 7.4, 5.5, 5.0]),
}
WITH_BALL = {
    "stop": ([DIRECTION_RIGHT] * 20, RELEASE_DIRECTION, [3.9, 2.7, 0.9, 0.0]),
    "turn 90": ([DIRECTION_RIGHT] * 20, DIRECTION_TOP, [4.5, 3.4, 2.8, 2.9, 3.6, 4.3, 4.9]),
    "turn 180": ([DIRECTION_RIGHT] * 20, DIRECTION_LEFT, [4.6, 3.0, 2.2, 1.8, 1.1, 0.3, 1.1, 2.2, 3.1, 3.9, 4.9]),
}


@pytest.mark.parametrize("case", WITHOUT_BALL)
def test_speeds_without_the_ball(case: str) -> None:
    before, action, measured = WITHOUT_BALL[case]
    matches = runner()
    play(matches, [0] * 3 + before, player=0)
    vx, vy = speeds(matches, [action] + [0] * (len(measured) - 1))
    error = np.abs(np.hypot(vx, vy) - measured)
    assert error.max() < 1.3 and error.mean() < 0.45, np.round(np.hypot(vx, vy), 2)


@pytest.mark.parametrize("case", WITH_BALL)
def test_speeds_with_the_ball(case: str) -> None:
    before, action, measured = WITH_BALL[case]
    matches = dribbler()
    play(matches, before)
    vx, vy = speeds(matches, [action] + [0] * (len(measured) - 1))
    error = np.abs(np.hypot(vx, vy) - measured)
    assert error.max() < 2.5 and error.mean() < 1.1, np.round(np.hypot(vx, vy), 2)


@pytest.mark.parametrize(
    ("keys", "alone", "with_ball", "ahead"),
    [
        ([], 5.0, 5.11, 0.48),
        ([SPRINT], 7.83, 7.27, 0.96),
        ([DRIBBLE], 3.5, 4.11, 0.52),
        ([SPRINT, DRIBBLE], 7.83, 7.66, 1.81),
    ],
)
def test_steady_speeds_and_distance_of_the_ball(keys: list[int], alone: float, with_ball: float, ahead: float) -> None:
    matches = runner()
    play(matches, [*keys, *[DIRECTION_RIGHT] * 60], player=0)
    assert matches["players"]["vx"][0, 0] == pytest.approx(alone, abs=0.1)
    matches = dribbler()
    distances, run = [], []
    play(matches, [*keys, *[DIRECTION_RIGHT] * 30])
    for _ in range(35):  # several touches
        play(matches, [DIRECTION_RIGHT])
        distances.append(matches["ball"]["x"][0] - matches["players"]["x"][0, 0])
        run.append(matches["players"]["vx"][0, 0])
    assert np.mean(run) == pytest.approx(with_ball, abs=0.2)
    assert np.mean(distances) == pytest.approx(ahead, rel=0.15)


def test_a_sprint_with_the_ball_turns_in_a_wide_arc() -> None:
    """Measured: 45 degrees after 18 steps, at hardly any loss of speed."""
    matches = dribbler()
    play(matches, [SPRINT] + [DIRECTION_RIGHT] * 40)
    vx, vy = speeds(matches, [DIRECTION_TOP] * 18)
    assert np.degrees(np.arctan2(vy[-1], vx[-1])) == pytest.approx(42, abs=10)
    assert np.hypot(vx, vy).min() > 6.5


@pytest.mark.parametrize(
    ("first", "then", "way"),
    [([], 0, 1.84), ([DRIBBLE], 0, 1.5), ([], SPRINT, 1.73), ([SPRINT], 0, 0.68)],
    ids=["run", "dribble", "sprint after the turn", "sprint before it"],
)
def test_a_turn_with_the_ball_waits_for_the_end_of_a_touch(first: list[int], then: int, way: float) -> None:
    """Of drawn turns of 90 degrees the real engine's have got so far after 0.8 s, in the mean; when differs."""
    matches = position([(-40.0, 0.0, LEFT, CM), (54.0, 30.0, RIGHT, GK)], (-39.1, 0.0), OPEN, range(100))
    play(matches, [DIRECTION_RIGHT, *first, *[DIRECTION_RIGHT] * (8 - len(first))])
    start = matches["players"]["y"][:, 0].copy()
    begun = np.zeros(100)
    for key in [DIRECTION_TOP, then, *[0] * 6]:
        play(matches, [key])
        begun += matches["players"]["vy"][:, 0] < 1.0
    assert (matches["carrier"] == 0).all()
    assert np.mean(matches["players"]["y"][:, 0] - start) == pytest.approx(way, abs=0.35)
    assert len(set(begun)) >= 2


def test_who_stands_with_the_ball_and_begins_to_dribble_touches_it_first() -> None:
    """Measured: off 0.3 s later than who runs."""
    ways = []
    for first in (0, DRIBBLE):
        matches = dribbler()
        play(matches, [first, *[DIRECTION_RIGHT] * 5])
        ways.append(matches["players"]["x"][0, 0] + 40.0)
    assert ways[0] - ways[1] > 0.6


def test_taking_a_ball_along_straight_on_costs_no_pace() -> None:
    """Drawn starts at a ball 0.75 m ahead: 3.8, 4.5, 5 m/s in the steps around the touch, and the ball at 4.4 m/s."""
    matches = position([(-40.0, 0.0, LEFT, CM), (54.0, 30.0, RIGHT, GK)], (-38.7, 0.0), OPEN, range(20))
    vx, _ = speeds(matches, [DIRECTION_RIGHT] * 7)
    assert (np.diff(vx)[:4] > 0.5).all() and vx[4] > 4.7
    assert (matches["carrier"] == 0).all()


def test_idle_never_stops_a_player() -> None:
    matches = runner()
    play(matches, [DIRECTION_RIGHT] + [0] * 40, player=0)
    assert matches["players"]["vx"][0, 0] == pytest.approx(5.0)


def test_all_directions_are_equally_fast() -> None:
    """In meters; the original's own units differ between the axes."""
    for action, (ux, uy) in {DIRECTION_TOP_RIGHT: (1, 1), DIRECTION_BOTTOM: (0, -1)}.items():
        matches = runner()
        play(matches, [SPRINT] + [action] * 30, player=0)
        velocity = np.array([matches["players"]["vx"][0, 0], matches["players"]["vy"][0, 0]])
        assert np.hypot(*velocity) == pytest.approx(7.75, abs=0.1)
        assert velocity @ np.array([ux, uy]) / np.hypot(ux, uy) == pytest.approx(np.hypot(*velocity))


def test_tiredness_grows_with_distance_alone() -> None:
    matches = runner()
    play(matches, [0] * 50, player=0)
    assert matches["players"]["tiredness"][0, 0] == 0.0
    play(matches, [DIRECTION_RIGHT] * 100, player=0)
    assert matches["players"]["tiredness"][0, 0] == pytest.approx(0.0335, rel=0.1)


def test_nobody_runs_through_anybody() -> None:
    """
    a →  ← b     meeting head on, they stay a body apart
    """
    matches = position([(-5.0, 0.0, LEFT, CM), (0.0, 0.1, RIGHT, CM), (50.0, 0.0, RIGHT, GK)], (-4.6, 0.0))
    for _ in range(40):
        play(matches, [DIRECTION_RIGHT])
        players = matches["players"][0]
        if players["down_wait"][0] == players["down_wait"][1] == 0.0:
            apart = np.hypot(players["x"][0] - players["x"][1], players["y"][0] - players["y"][1])
            assert apart > 1.7 * BODY_RADIUS


def test_players_stay_on_the_grass() -> None:
    matches = runner()
    play(matches, [SPRINT, *[DIRECTION_TOP] * 80], player=0)
    assert matches["players"]["y"][0, 0] == pytest.approx(39.0)


@pytest.mark.parametrize("name", ["walk_top", "walk_left", "walk_top_right", "sprint_top", "sprint_left"])
def test_turning_against_the_raw_traces(name: str) -> None:
    """Place 2 s after a turn without the ball, relative to the turn, within 0.6 m of the measured one."""
    table = csv.DictReader(line for line in TRACES.open() if not line.startswith("#"))
    rows = [row for row in table if row["run"] == name]
    place = np.array([[float(row["x"]), float(row["y"])] for row in rows])  # [T, 2]
    turn = max(i for i in range(1, len(rows)) if rows[i]["sticky"] != rows[i - 1]["sticky"])
    direction = 1 + rows[turn]["sticky"].index("1")
    matches = runner()
    play(matches, ([SPRINT] if name.startswith("sprint") else [0]) + [DIRECTION_RIGHT] * 40, player=0)
    vx, vy = speeds(matches, [direction] * 20)
    ours = 0.1 * np.array([vx.sum(), vy.sum()])
    assert np.abs(ours - (place[turn + 19] - place[turn - 1])).max() < 0.6


def test_a_sprinter_is_slower_for_a_moment_at_every_touch() -> None:
    """Measured: touches come every 7 to 7.3 steps, and cost about 1.3 m/s for 0.12 s."""
    matches = dribbler()
    play(matches, [SPRINT] + [DIRECTION_RIGHT] * 30)
    vx, _ = speeds(matches, [DIRECTION_RIGHT] * 60)
    touched = np.flatnonzero((vx < 7.1) & (np.roll(vx, 1) >= 7.1))
    assert np.mean(np.diff(touched)) == pytest.approx(7.2, abs=0.5)
    assert vx.max() - vx.min() == pytest.approx(1.3, abs=0.4)


@pytest.mark.parametrize("later", range(8))
def test_a_sprinter_does_not_turn_away_from_his_ball(later: int) -> None:
    """Whenever the key comes, before a touch or just after it."""
    matches = dribbler()
    play(matches, [SPRINT] + [DIRECTION_RIGHT] * (40 + later))
    for _ in range(20):
        play(matches, [DIRECTION_TOP])
        player, ball = matches["players"][0, 0], matches["ball"][0]
        assert np.hypot(player["x"] - ball["x"], player["y"] - ball["y"]) < 1.3
        assert matches["carrier"][0] == 0


def test_a_slide_from_the_stand_is_short() -> None:
    """Measured: 0.6 m."""
    matches = runner()
    matches["game_mode"], matches["restart_team"] = NORMAL, NOBODY
    matches["use_magnet"] = False
    before = matches["players"]["x"][0, 0]
    play(matches, [SLIDING] + [0] * 8, player=0)
    assert abs(matches["players"]["x"][0, 0] - before) == pytest.approx(0.6, abs=0.1)


@pytest.mark.parametrize(("asks", "along"), [(False, 0.6), (True, 0.5)])
def test_who_runs_to_a_ball_that_lies_beside_his_way_goes_his_way_in_the_same_stride(asks: bool, along: float) -> None:
    """Measured: 0.56 m his keys' way after 6 steps, and 0.42 m where he asks for a pass as soon as he has the ball."""
    keys = [DIRECTION_BOTTOM_RIGHT] * 4 + ([SHORT_PASS, 0, RELEASE_DIRECTION] if asks else [0] * 3)
    matches = position(
        [(0.0, 0.0, LEFT, CM), (3.0, -16.0, LEFT, CM), (50.0, 33.0, RIGHT, GK)], (0.54, 0.84), OPEN, range(40)
    )
    play(matches, keys[:6], player=0)
    player = matches["players"][:, 0]
    assert np.mean(player["x"] - player["y"]) / np.sqrt(2.0) == pytest.approx(along, abs=0.25)


@pytest.mark.parametrize(
    ("away", "run", "time"), [(2.94, 0.0, 0.7), (2.0, 5.0, 0.29), (2.0, -5.0, 0.84), (0.3, 0.0, 0.0)]
)
def test_how_long_one_needs_to_a_place_heeds_how_he_runs(away: float, run: float, time: float) -> None:
    """As documented: his run fades within 0.7 s, while his reach grows."""
    matches = runner()
    player = matches["players"][0, 0]
    player["vx"], player["top_speed"] = run, 7.8
    assert time_needed(player, away, 0.0) == pytest.approx(time, abs=0.06)


@pytest.mark.parametrize("seed", range(20))
def test_who_can_be_at_a_rolling_ball_first_can_be_there_no_sooner(seed: int) -> None:
    """The time found is the first of all, looked through one by one, at which it is as near as he reaches."""
    rng = np.random.default_rng(seed)
    matches = runner()
    player, ball = matches["players"][0, 0], matches["ball"][0]
    (player["vx"], player["vy"]), player["top_speed"] = rng.uniform(-5.0, 5.0, 2), 7.7
    ball["x"], ball["y"] = player["x"] + rng.uniform(-8.0, 8.0), player["y"] + rng.uniform(-8.0, 8.0)
    ball["vx"], ball["vy"] = rng.uniform(-6.0, 6.0, 2)
    speed = float(np.hypot(ball["vx"], ball["vy"]))
    for time in np.arange(0.0, 3.0, 0.002):
        share = rolled(speed, time) / speed
        dx, dy = ball["x"] + share * ball["vx"] - player["x"], ball["y"] + share * ball["vy"] - player["y"]
        if time_needed(player, dx, dy) <= time:
            break
    assert meeting_time(ball, look_ahead(ball), player) == pytest.approx(max(time, 0.1), abs=0.04)


def test_who_runs_on_in_nearly_the_same_direction_gathers_speed_as_if_straight() -> None:
    """A chaser is on his way to a place that moves: his direction turns by 1.5 degrees in a step."""
    ran = []
    for first, turn in ((0.0, 0.0), (5.0, 1.5)):
        match = position([(0.0, 0.0, LEFT, CM)], (40.0, 30.0))[0]
        player = match["players"][0:1]
        player["vx"] = 3.5
        for step in range(1, 9):
            angle = np.radians(first + turn * step)
            player["desired_vx"], player["desired_vy"] = 8.0 * np.cos(angle), 8.0 * np.sin(angle)
            plan_motion(match, 0)
        ran.append(np.hypot(player["vx"][0], player["vy"][0]))
        assert np.degrees(np.arctan2(player["vy"][0], player["vx"][0])) == pytest.approx(first + 8 * turn, abs=4.0)
    straight, bending = ran
    assert straight - 0.5 < bending < straight


@pytest.mark.parametrize(("away", "longest"), [(9.0, 0.06), (11.0, 0.25), (14.0, 0.25)])
def test_only_near_the_ball_the_first_whistle_finds_a_player_on_his_toes(away: float, longest: float) -> None:
    """Measured of backs 11 to 16 m off: in the mean as late as those farther away."""
    matches = position([(0.0, 0.0, LEFT, CM), (30.0, 0.0, RIGHT, CM)], (away, 0.0), seeds=range(60))
    for match in matches:
        take_stance(match)
    waits = matches["players"]["stance_wait"][:, 0]
    assert 0.6 * longest < waits.max() <= longest
