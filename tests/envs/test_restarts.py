"""Throw-ins, goal kicks, corners, free kicks and penalties: who stands where, for how long, and how play goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pitch import OPEN, play, position

from regista.envs.football.constants import (
    BODY_RADIUS,
    CB,
    CF,
    CM,
    CORNER,
    FREE_KICK,
    GK,
    GOAL_KICK,
    LB,
    LEFT,
    LM,
    NOBODY,
    NORMAL,
    PENALTY,
    POSSESSION,
    RB,
    RIGHT,
    RM,
    SHORT_PASS,
    SHOT,
    THROW_IN,
)
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.rules.whistle import stop_play

SHAPE = [
    *[(-54.0, 0.0, GK), (-25.0, 16.0, LB), (-28.0, 5.0, CB), (-28.0, -5.0, CB), (-25.0, -16.0, RB)],
    *[(-12.0, 9.0, CM), (-15.0, 0.0, CM), (-12.0, -9.0, CM), (-3.0, 18.0, LM), (-1.0, 0.0, CF), (-3.0, -18.0, RM)],
]
ELEVENS = [(x, y, LEFT, role) for x, y, role in SHAPE] + [(-x, -y, RIGHT, role) for x, y, role in SHAPE]
PLACES = {  # mode: a place of the ball at which the left team takes it
    THROW_IN: (12.0, 36.0),
    GOAL_KICK: (-50.6, 0.0),
    CORNER: (55.0, -36.0),
    FREE_KICK: (30.0, 10.0),
    PENALTY: (44.0, 0.0),
}
MODES = list(PLACES)


def stopped(mode: int, team: int = LEFT, seeds: range = range(1), agent: bool = False) -> np.ndarray:
    """Return elevens at a restart's first step; with an agent, it has the player of its team nearest to the ball."""
    chosen = {"control": "none", "right_control": "none"}
    if agent:
        chosen["control" if team == LEFT else "right_control"] = "closest1"
    matches = position(ELEVENS, (0.0, 0.0), replace(OPEN, offsides=True, **chosen), seeds)
    x, y = PLACES[mode]
    side = 1.0 if team == LEFT else -1.0
    for match in matches:
        stop_play(match, mode, team, side * x, side * y)
    return play(matches, [0])


def shown(matches: np.ndarray, actions: list[int]) -> np.ndarray:
    """Return steps [N] for which the restart shows, the first included, when these actions are played."""
    steps = np.ones(len(matches), int)
    for action in actions:
        play(matches, [action])
        steps += matches["game_mode"] != NORMAL
    return steps


@pytest.mark.parametrize(
    ("mode", "least", "most"), [(THROW_IN, 2, 3), (GOAL_KICK, 5, 6), (CORNER, 5, 6), (FREE_KICK, 5, 6), (PENALTY, 6, 7)]
)
def test_a_restart_shows_as_long_as_in_the_original(mode: int, least: int, most: int) -> None:
    matches = stopped(mode, seeds=range(40))
    assert (matches["game_mode"] == mode).all()
    steps = np.ones(40, int)
    for _ in range(most):
        play(matches, [0])
        waiting = matches["game_mode"] == mode
        steps += waiting
        moving = np.hypot(matches["ball"]["vx"], matches["ball"]["vy"])
        assert (moving[waiting] == 0.0).all()
    assert set(steps) == {least, most}
    assert (matches["game_mode"] == NORMAL).all()


@pytest.mark.parametrize(("mode", "idle", "quick"), [(THROW_IN, 23, 3), (GOAL_KICK, 26, 6), (CORNER, 26, 6)])
def test_an_agent_takes_it_or_after_20_steps_his_player_passes(mode: int, idle: int, quick: int) -> None:
    for team in (LEFT, RIGHT):
        assert shown(stopped(mode, team, agent=True), [0] * 40)[0] == idle
        assert shown(stopped(mode, team, agent=True), [SHORT_PASS] + [0] * 10)[0] == quick
        assert shown(stopped(mode, team, agent=True), [0, 0, 0, SHORT_PASS] + [0] * 10)[0] == quick + 3


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("team", [LEFT, RIGHT])
def test_who_stands_where(mode: int, team: int) -> None:
    matches = stopped(mode, team)
    ball, players = matches["ball"][0], matches["players"][0, :22]
    side = 1.0 if team == LEFT else -1.0
    assert (ball["x"], ball["y"]) == (side * PLACES[mode][0], side * PLACES[mode][1])
    taker = int(matches["taker"][0])
    assert players["team"][taker] == team
    away = np.hypot(players["x"] - ball["x"], players["y"] - ball["y"])
    assert away[taker] == pytest.approx({THROW_IN: 0.3, PENALTY: 3.0}.get(mode, 2.3))
    opponents = (players["team"] != team) & (players["role"] != GK)
    assert away[opponents].min() >= (2.0 if mode == THROW_IN else 9.15) - 1e-9
    assert (np.abs(players["x"][np.arange(22) != taker]) <= 55.0).all()
    assert (np.abs(players["y"][np.arange(22) != taker]) <= 36.0).all()
    assert (players["vx"] == 0.0).all()
    keepers = players["role"] == GK
    keepers[taker] = False
    assert np.abs(players["x"][keepers]) == pytest.approx(53.9)
    looks = (ball["x"] - players["x"]) * players["facing_x"] + (ball["y"] - players["y"]) * players["facing_y"]
    assert looks == pytest.approx(away)
    gaps = np.hypot(players["x"][:, None] - players["x"], players["y"][:, None] - players["y"]) + 9.0 * np.eye(22)
    play(matches, [0] * 2)  # in which bodies that still overlap part
    gaps = np.hypot(players["x"][:, None] - players["x"], players["y"][:, None] - players["y"]) + 9.0 * np.eye(22)
    assert gaps.min() > 2 * BODY_RADIUS - 0.01


def test_takers_and_owners() -> None:
    """A goal kick is the keeper's, and only a throw-in is owned while it waits: it is in somebody's hands."""
    assert stopped(GOAL_KICK)["taker"][0] == 0
    for mode in MODES:
        matches = stopped(mode)
        assert matches["reported_owner"][0] == (matches["taker"][0] if mode == THROW_IN else NOBODY)
        assert matches["last_owned_team"][0] == (LEFT if mode == THROW_IN else NOBODY)


def test_a_wall_of_three_before_a_near_free_kick() -> None:
    matches = stopped(FREE_KICK)
    ball, players = matches["ball"][0], matches["players"][0, :22]
    x, y = players["x"] - ball["x"], players["y"] - ball["y"]
    to_goal_x, to_goal_y = 55.0 - ball["x"], -ball["y"]
    size = np.hypot(to_goal_x, to_goal_y)
    along, across = (x * to_goal_x + y * to_goal_y) / size, np.abs(x * to_goal_y - y * to_goal_x) / size
    wall = (players["team"] == RIGHT) & (np.abs(np.hypot(x, y) - 9.15) < 0.01) & (along > 8.0) & (across < 1.0)
    assert wall.sum() == 3
    far = position(ELEVENS, (0.0, 0.0))
    stop_play(far[0], FREE_KICK, LEFT, 5.0, 0.0)
    play(far, [0])
    away = np.hypot(far["players"]["x"][0, :22] - 5.0, far["players"]["y"][0, :22])
    assert (np.abs(away[11:] - 9.15) < 0.01).sum() <= 1


@pytest.mark.parametrize("team", [LEFT, RIGHT])
def test_no_wall_stands_beyond_the_goal_line(team: int) -> None:
    """An offside that is whistled only when he comes back to the ball can be as near to his own goal."""
    matches, x = position(ELEVENS, (0.0, 0.0)), 52.25 if team == LEFT else -52.25
    stop_play(matches[0], FREE_KICK, team, x, 1.0)
    play(matches, [0])
    players = matches["players"][0, :22]
    others = players[players["team"] != team][1:]
    assert np.abs(others["x"]).max() < 55.0
    assert np.hypot(others["x"] - x, others["y"] - 1.0).min() > 9.14


@pytest.mark.parametrize("team", [LEFT, RIGHT])
def test_who_would_stand_on_another_steps_back_from_the_ball(team: int) -> None:
    """Teams whose slots are all in the middle find few places beside the arc."""
    line = [(x, 0.0, who, CM) for who in (LEFT, RIGHT) for x in np.linspace(-40.0, 40.0, 8)]
    matches = position(line, (0.0, 0.0), replace(OPEN, control="none"))
    matches["players"]["slot_x"] = matches["players"]["slot_y"] = 0.0
    stop_play(matches[0], PENALTY, team, 44.0 if team == LEFT else -44.0, 0.0)
    play(matches, [0])
    players, ball = matches["players"][0, :16], matches["ball"][0]
    away = np.hypot(players["x"] - ball["x"], players["y"] - ball["y"])
    assert away[players["team"] != team].min() >= 9.15
    assert np.abs(np.subtract.outer(players["x"], players["x"])[~np.eye(16, dtype=bool)]).min() > 0.04


def test_at_a_penalty_only_taker_and_keeper_are_in_the_box() -> None:
    for team in (LEFT, RIGHT):
        matches = stopped(PENALTY, team)
        players = matches["players"][0, :22]
        near = np.abs(players["x"] - (55.0 if team == LEFT else -55.0)) < 16.5
        assert near.sum() == 2


@pytest.mark.parametrize("mode", MODES)
def test_the_ball_is_played_and_the_taker_was_the_last_to_touch_it(mode: int) -> None:
    matches = stopped(mode, seeds=range(20))
    takers = matches["taker"].copy()
    for _ in range(7):
        waiting = matches["game_mode"] == mode
        play(matches, [0])
        free = waiting & (matches["game_mode"] == NORMAL)
        assert (matches["last_touch"][free] == takers[free]).all()
        assert (np.hypot(matches["ball"]["vx"], matches["ball"]["vy"])[free] > 8.0).all()
        x, y = PLACES[mode]
        moved = np.hypot(matches["ball"]["x"] - x, matches["ball"]["y"] - y)[free]
        assert (moved < 4.0).all()


def test_penalties_are_mostly_scored() -> None:
    matches = stopped(PENALTY, seeds=range(60))
    play(matches, [0] * 25)
    assert matches["score"][:, LEFT].sum() >= 30


def test_an_agent_shoots_a_penalty_where_his_keys_say() -> None:
    places = {}
    for key in (4, 6):  # top right, bottom right
        matches = stopped(PENALTY, agent=True)
        play(matches, [key, SHOT])
        for _ in range(12):
            play(matches, [0])
            if matches["ball"]["x"][0] > 50.0:
                break
        places[key] = matches["ball"]["y"][0]
    assert places[4] > 0.5
    assert places[6] < -0.5


def test_after_a_set_piece_the_side_line_does_not_count_for_a_moment() -> None:
    matches = stopped(THROW_IN)
    while matches["game_mode"][0] != NORMAL:
        play(matches, [0])
    matches["ball"]["y"], matches["ball"]["vy"], matches["ball"]["vx"] = 36.5, 0.0, 0.0
    play(matches, [0] * 2)
    assert matches["game_mode"][0] == NORMAL
    play(matches, [0])
    assert matches["game_mode"][0] == THROW_IN


def test_a_throw_in_is_taken_where_the_ball_went_out_by_the_other_team() -> None:
    for last_touch, team in ((0, RIGHT), (1, LEFT)):
        matches = position([(-20.0, 20.0, LEFT, CM), (-20.0, -20.0, RIGHT, CM)], (7.0, -35.0))
        matches["ball"]["vy"], matches["last_touch"] = -12.0, last_touch
        play(matches, [0] * 2)
        assert matches["game_mode"][0] == THROW_IN
        assert matches["restart_team"][0] == team
        assert (matches["ball"]["x"][0], matches["ball"]["y"][0]) == (7.0, -36.0)
        assert matches["players"]["team"][0, matches["taker"][0]] == team
        assert matches["ended"][0] == 0


def test_the_ball_in_the_hands_of_a_thrower_is_owned_so_possession_can_change() -> None:
    matches = position(ELEVENS, (0.0, 35.9), replace(OPEN, end_episode_on_possession_change=True, control="none"))
    matches["ball"]["vy"], matches["last_touch"], matches["last_owned_team"] = 12.0, 1, LEFT
    play(matches, [0])
    assert matches["game_mode"][0] == THROW_IN
    assert matches["ended"][0] == POSSESSION


def test_a_team_without_players_leaves_its_restarts_to_the_other() -> None:
    matches = position([(-20.0, 20.0, LEFT, CM)], (0.0, 35.0), MatchConfig(end_episode_on_out_of_play=False))
    matches["ball"]["vy"], matches["last_touch"] = 12.0, 0
    play(matches, [0] * 2)
    assert matches["restart_team"][0] == LEFT
    play(matches, [0] * 24)
    assert matches["game_mode"][0] == NORMAL
