"""Fouls from hand-made positions: free kicks, penalties, advantage, cards, and being a man short."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pitch import OPEN, play, position, take_over

from regista.envs.football.constants import CB, CF, CM, FREE_KICK, GK, LEFT, NOBODY, NORMAL, OUT_OF_PLAY, PENALTY, RIGHT
from regista.envs.football.rules.fouls import report_foul
from regista.envs.football.rules.offside import mark_offside

PLAYERS = [
    *[(-54.0, 0.0, LEFT, GK), (0.0, 0.0, LEFT, CF), (-10.0, 14.0, LEFT, CM)],
    *[(54.0, 0.0, RIGHT, GK), (20.0, 20.0, RIGHT, CB), (22.0, -20.0, RIGHT, CB)],
]


def at(x: float, y: float = 3.0, **config: bool) -> np.ndarray:
    """Return a left forward with the ball at (x, y), and the right back 4 beside him."""
    players = [*PLAYERS[:1], (x, y, LEFT, CF), PLAYERS[2], PLAYERS[3], (x, y + 1.5, RIGHT, CB), PLAYERS[5]]
    matches = position(players, (x + 0.4, y), replace(OPEN, **config))
    take_over(matches, NOBODY)
    matches["carrier"], matches["last_touch"] = 1, 1
    return matches


def fouled(matches: np.ndarray, severity: float, slid: bool = True, player: int = 4, victim: int = 1) -> np.ndarray:
    report_foul(matches[0], player, victim, severity, slid)
    return play(matches, [0])


@pytest.mark.parametrize(
    ("severity", "mode", "cards"), [(1.0, NORMAL, 0), (1.2, FREE_KICK, 0), (1.5, FREE_KICK, 1), (2.1, FREE_KICK, 2)]
)
def test_severity_decides_about_foul_and_card(severity: float, mode: int, cards: int) -> None:
    matches = fouled(at(10.0), severity)
    assert matches["game_mode"][0] == mode
    assert matches["players"]["cards"][0, 4] == cards
    if mode != NORMAL:
        assert matches["restart_team"][0] == LEFT
        assert (matches["ball"]["x"][0], matches["ball"]["y"][0]) == (10.0, 3.0)


def test_a_foul_in_the_own_box_is_a_penalty_and_elsewhere_never() -> None:
    for x, mode in ((45.0, PENALTY), (-45.0, FREE_KICK), (38.0, FREE_KICK)):
        matches = fouled(at(x), 1.2)
        assert matches["game_mode"][0] == mode
        if mode == PENALTY:
            assert (matches["ball"]["x"][0], matches["ball"]["y"][0]) == (44.0, 0.0)


def test_a_free_kick_is_not_taken_at_the_very_line() -> None:
    matches = fouled(at(10.0, 35.8), 1.2)
    assert matches["ball"]["y"][0] == pytest.approx(0.95 * 36.0)


def test_a_foul_ends_the_episode_when_out_of_play_does() -> None:
    matches = fouled(at(10.0, end_episode_on_out_of_play=True), 1.2)
    assert matches["ended"][0] == OUT_OF_PLAY


def test_a_trip_is_played_on_for_the_advantage_and_then_forgotten() -> None:
    matches = at(-10.0)
    fouled(matches, 1.0, slid=False)
    for _ in range(29):
        assert matches["game_mode"][0] == NORMAL
        matches["last_touch"] = 1  # the victim's team keeps the ball
        matches["carrier"], matches["ball"]["x"], matches["ball"]["y"] = NOBODY, -30.0, -30.0
        matches["ball"]["vx"] = matches["ball"]["vy"] = 0.0
        play(matches, [0])
    play(matches, [0] * 2)
    assert matches["foul_player"][0] == NOBODY


def test_a_trip_is_given_once_the_ball_is_lost_but_not_before_0_6_s() -> None:
    matches = at(-10.0)
    fouled(matches, 1.0, slid=False)
    steps = 1
    while matches["game_mode"][0] == NORMAL and steps < 20:
        matches["last_touch"], matches["carrier"] = 5, NOBODY
        matches["ball"]["x"], matches["ball"]["y"], matches["ball"]["vx"] = 30.0, -30.0, 0.0
        play(matches, [0])
        steps += 1
    assert steps == 7
    assert matches["game_mode"][0] == FREE_KICK
    assert (matches["ball"]["x"][0], matches["ball"]["y"][0]) == (-10.0, 3.0)
    assert matches["players"]["cards"].sum() == 0


def test_a_trip_in_the_box_is_given_at_once() -> None:
    assert fouled(at(45.0), 1.0, slid=False)["game_mode"][0] == PENALTY


def test_a_foul_goes_before_a_throw_in_but_not_before_a_goal() -> None:
    for x, y, vx, vy, mode in ((0.0, 36.1, 0.0, 9.0, FREE_KICK), (55.1, 0.0, 9.0, 0.0, NORMAL)):
        matches = at(-10.0)
        matches["carrier"] = NOBODY
        report_foul(matches[0], 4, 1, 1.0, False)
        matches["ball"]["x"], matches["ball"]["y"], matches["ball"]["vx"], matches["ball"]["vy"] = x, y, vx, vy
        play(matches, [0])
        assert matches["game_mode"][0] == mode
        assert matches["foul_player"][0] == NOBODY


def test_the_second_yellow_card_is_a_red_one_and_after_6_s_he_is_gone() -> None:
    matches = at(10.0)
    matches["players"]["cards"][0, 4] = 1
    fouled(matches, 1.5)
    assert matches["players"]["cards"][0, 4] == 2
    play(matches, [0] * 58)
    assert not matches["players"]["has_left"][0, 4]
    for _ in range(12):
        play(matches, [0])
    assert matches["players"]["has_left"][0, 4]


def sent_off() -> np.ndarray:
    """Return a match in which the right back 4 has been sent off and has left."""
    matches = position(PLAYERS, (0.4, 0.0), replace(OPEN, offsides=True))
    matches["players"]["cards"][0, 4], matches["players"]["leave_wait"][0, 4] = 2, 0.1
    play(matches, [0])
    assert matches["players"]["has_left"][0, 4]
    return matches


def test_who_has_left_neither_moves_nor_plays_nor_comes_back() -> None:
    matches = sent_off()
    before = matches["players"][0, 4].copy()
    for _ in range(300):
        play(matches, [int(matches["step"][0]) % 19])
        assert matches["chaser"][0, RIGHT] != 4 and matches["carrier"][0] != 4 and matches["taker"][0] != 4
    after = matches["players"][0, 4]
    assert (before["x"], before["y"]) == (after["x"], after["y"])
    assert after["has_left"] and abs(after["x"]) > 60.0


def test_who_has_left_plays_nobody_onside() -> None:
    """With back 4 gone, the keeper and back 5 are the last two: a forward at 30 is beyond back 5 at 22."""
    matches = sent_off()
    matches["players"]["x"][0, [2, 3, 5]] = 30.0, 54.0, 22.0
    mark_offside(matches[0], 1)
    assert matches["offside_bits"][0] == 0b100


def test_a_team_can_be_sent_off_altogether() -> None:
    matches = position(PLAYERS, (0.4, 0.0))
    matches["players"]["cards"][0, 3:6], matches["players"]["leave_wait"][0, 3:6] = 2, 0.1
    for _ in range(400):
        play(matches, [5])
        assert np.isfinite(matches["ball"]["x"][0])
        assert matches["restart_team"][0] in (NOBODY, LEFT)
    assert matches["players"]["has_left"][0, 3:6].all()
