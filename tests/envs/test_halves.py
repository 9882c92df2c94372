"""Kick-offs after goals, and the second half."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pitch import OPEN, play, position

from regista.envs.football.constants import CM, DURATION, GK, LEFT, NORMAL, POSSESSION, RIGHT

UNEQUAL = [(-54.0, 0.0, LEFT, GK), (-6.0, 3.0, LEFT, CM), (-14.0, -9.0, LEFT, CM), (20.0, 12.0, RIGHT, CM)]
EQUAL = [*UNEQUAL[:3], (54.0, 0.5, RIGHT, GK), (20.0, 12.0, RIGHT, CM), (33.0, -8.0, RIGHT, CM)]


def goal(players: list, by: int, **config: bool) -> np.ndarray:
    """Return the first step after a goal by the player who touched the ball last (`by`), with everybody astray."""
    matches = position(players, (0.0, 0.0), replace(OPEN, **config))
    matches["players"]["x"][0] += 3.0
    matches["ball"]["x"], matches["ball"]["vx"], matches["last_touch"] = 54.5, 15.0, by
    play(matches, [0])
    assert matches["score"][0].tolist() == [1, 0]
    return matches


def places(matches: np.ndarray) -> list[tuple[float, float]]:
    count = matches["num_players"][0]
    return [(float(x), float(y)) for x, y in matches["players"][["x", "y"]][0, :count].tolist()]


@pytest.mark.parametrize("by", [1, 3])
def test_after_a_goal_everybody_is_at_his_start_position_and_play_is_on(by: int) -> None:
    """Own goals too: a goal is the other team's, whoever touched the ball last."""
    matches = goal(UNEQUAL, by)
    assert matches["game_mode"][0] == NORMAL
    assert (matches["ball"]["x"][0], matches["ball"]["y"][0], matches["ball"]["vx"][0]) == (0.0, 0.0, 0.0)
    assert places(matches) == [(x, y) for x, y, *_ in UNEQUAL]
    assert (matches["players"]["vx"] == 0.0).all()


def test_equal_teams_swap_their_places_so_that_the_conceding_team_has_the_ball_before_it() -> None:
    """The left team was nearer to the ball at the start, and the right one kicks off now; then the other way round."""
    matches = goal(EQUAL, 1)
    turned = [(-x, -y) for x, y, *_ in EQUAL[3:] + EQUAL[:3]]
    assert places(matches) == turned
    matches["ball"]["x"], matches["ball"]["y"], matches["ball"]["vx"] = -55.0, 3.0, -15.0
    play(matches, [0])
    assert matches["score"][0].tolist() == [1, 1]
    assert places(matches) == [(x, y) for x, y, *_ in EQUAL]


def test_a_goal_does_not_end_possession() -> None:
    """As in the original: the last owner is remembered, so the conceding team's first touch is a change."""
    matches = position(UNEQUAL, (0.0, 0.0), replace(OPEN, end_episode_on_possession_change=True))
    matches["ball"]["x"], matches["ball"]["vx"], matches["last_owned_team"] = 54.5, 15.0, LEFT
    play(matches, [0])
    assert matches["last_owned_team"][0] == LEFT
    matches["ball"]["x"], matches["ball"]["y"] = 19.5, 12.0
    play(matches, [0] * 3)
    assert matches["ended"][0] == POSSESSION


@pytest.mark.parametrize("players", [UNEQUAL, EQUAL])
def test_the_second_half_begins_at_its_step_with_the_other_team(players: list) -> None:
    matches = position(players, (0.0, 1.0), replace(OPEN, second_half=40, game_duration=60))
    play(matches, [0] * 39)
    assert matches["half"][0] == 0
    play(matches, [0])
    assert matches["half"][0] == 1
    assert matches["game_mode"][0] == NORMAL
    equal = len(players) == 6
    expected = [(-x, -y) for x, y, *_ in players[3:] + players[:3]] if equal else [(x, y) for x, y, *_ in players]
    assert places(matches) == expected
    assert matches["ball"]["y"][0] == (-1.0 if equal else 1.0)
    assert matches["score"].sum() == 0
    play(matches, [0] * 20)
    assert matches["ended"][0] == DURATION


def test_the_second_half_waits_for_a_restart() -> None:
    matches = position(EQUAL, (0.0, 35.9), replace(OPEN, second_half=2))
    matches["ball"]["vy"], matches["last_touch"] = 15.0, 1
    play(matches, [0])
    while matches["game_mode"][0] != NORMAL:
        assert matches["half"][0] == 0
        play(matches, [0])
    assert matches["half"][0] == 1


def test_without_a_setting_there_is_no_second_half() -> None:
    matches = position(EQUAL, (0.0, 0.0), replace(OPEN, game_duration=3000))
    play(matches, [0] * 200)
    assert matches["half"][0] == 0
