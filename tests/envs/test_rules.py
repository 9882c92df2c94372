"""Goals, balls out of play, restarts, possession, checkpoints and the ends of episodes."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import OPEN, duel, play, position, same

from regista.envs.football.constants import (
    CM,
    CORNER,
    DURATION,
    GK,
    GOAL,
    GOAL_KICK,
    LEFT,
    OUT_OF_PLAY,
    POSSESSION,
    RIGHT,
    THROW_IN,
)
from regista.envs.football.kick_off import MatchConfig

FAR = [(-20.0, 20.0, LEFT, CM), (-20.0, -20.0, RIGHT, CM)]


def rolling(x: float, y: float, vx: float, vy: float, last_touch: int, config: MatchConfig) -> np.ndarray:
    """Return a free ball on its way over a line, with everybody far away."""
    matches = position(FAR, (x, y), config)
    matches["ball"]["vx"], matches["ball"]["vy"] = vx, vy
    matches["last_touch"] = last_touch
    return play(matches, [0] * 3)


@pytest.mark.parametrize(
    ("x", "y", "vx", "goal", "score"), [(54.0, 1.0, 15.0, 1, [1, 0]), (-54.0, -3.0, -15.0, -1, [0, 1])]
)
def test_a_goal_counts_and_ends_the_episode(x: float, y: float, vx: float, goal: int, score: list[int]) -> None:
    matches = position(FAR, (x, y), MatchConfig())
    matches["ball"]["vx"] = vx
    goals = [play(matches, [0])["goal"][0] for _ in range(3)]
    assert sum(goals) == goal
    assert matches["ended"][0] == GOAL
    assert matches["terminated"][0] and not matches["truncated"][0]
    assert matches["score"][0].tolist() == score


def test_over_the_bar_is_no_goal() -> None:
    matches = position(FAR, (54.0, 0.0), MatchConfig())
    matches["ball"]["vx"], matches["ball"]["z"] = 15.0, 3.0
    play(matches, [0] * 3)
    assert matches["score"].sum() == 0
    assert matches["ended"][0] == OUT_OF_PLAY


@pytest.mark.parametrize(
    ("x", "y", "vx", "vy", "last_touch", "mode"),
    [
        (0.0, 35.5, 0.0, 10.0, 0, THROW_IN),
        (0.0, -35.5, 0.0, -10.0, 1, THROW_IN),
        (54.5, 12.0, 12.0, 0.0, 0, GOAL_KICK),
        (54.5, 12.0, 12.0, 0.0, 1, CORNER),
        (-54.5, 12.0, -12.0, 0.0, 0, CORNER),
        (-54.5, 12.0, -12.0, 0.0, 1, GOAL_KICK),
    ],
)
def test_out_of_play(x: float, y: float, vx: float, vy: float, last_touch: int, mode: int) -> None:
    matches = rolling(x, y, vx, vy, last_touch, MatchConfig())
    assert matches["game_mode"][0] == mode
    assert matches["ended"][0] == OUT_OF_PLAY
    assert matches["terminated"][0]


def test_without_a_touch_the_ball_belongs_to_the_team_whose_half_it_left() -> None:
    for x, team in ((-10.0, LEFT), (10.0, RIGHT)):
        matches = position(FAR, (x, 35.9), OPEN)
        matches["ball"]["vy"] = 10.0
        assert play(matches, [0])["restart_team"][0] == team
    assert rolling(54.5, 12.0, 12.0, 0.0, -1, OPEN)["game_mode"][0] == GOAL_KICK


def test_possession_changes_between_owned_states_only() -> None:
    """left owns → nobody → left owns is no change; → nobody → right owns is one."""
    matches = duel((30.0, 0.0), (54.0, 0.0), end_episode_on_possession_change=True)
    play(matches, [0] * 9)
    assert matches["last_owned_team"][0] == LEFT
    matches["ball"]["x"] = 20.0  # out of reach: nobody's
    matches["carrier"] = -1
    play(matches, [0])
    assert matches["reported_owner"][0] == -1
    assert matches["ended"][0] == 0
    matches["ball"]["x"], matches["ball"]["y"] = matches["players"]["x"][0, 1] - 0.5, matches["players"]["y"][0, 1]
    matches["ball"]["vx"] = matches["ball"]["vy"] = 0.0
    play(matches, [0] * 2)
    assert matches["ended"][0] == POSSESSION
    assert matches["terminated"][0]


def test_the_first_touch_is_no_change() -> None:
    matches = position([(30.0, 20.0, LEFT, CM), (50.0, 0.0, RIGHT, GK)], (49.0, 0.0), MatchConfig())
    play(matches, [0] * 6)
    assert matches["last_owned_team"][0] == RIGHT
    assert matches["ended"][0] == 0


@pytest.mark.parametrize("duration", [1, 7, 30])
def test_an_episode_lasts_exactly_its_duration(duration: int) -> None:
    matches = position(FAR, (0.0, 0.0), MatchConfig(game_duration=duration))
    play(matches, [0] * (duration - 1))
    assert matches["ended"][0] == 0
    play(matches, [0])
    assert matches["ended"][0] == DURATION
    assert matches["truncated"][0] and not matches["terminated"][0]


def test_a_goal_in_the_last_step_is_a_goal() -> None:
    matches = position(FAR, (55.1, 1.0), MatchConfig(game_duration=1))
    matches["ball"]["vx"] = 15.0
    play(matches, [0])
    assert matches["ended"][0] == GOAL
    assert not matches["truncated"][0]


def test_a_match_that_has_ended_changes_no_more_and_pays_nothing() -> None:
    matches = rolling(54.0, 1.0, 15.0, 0.0, 0, MatchConfig())
    assert matches["ended"][0] == GOAL
    play(matches, [0])
    before = matches.copy()
    play(matches, [5, 12, 13])
    assert same(before, matches)
    assert matches["goal"][0] == 0 and (matches["checkpoint_reward"][0] == 0.0).all()


def test_checkpoints_pay_once_each_and_all_at_a_goal() -> None:
    """Close to the goal the first step with the ball pays most of them, a goal the rest: 1.0 in all."""
    matches = position([(30.0, 0.0, LEFT, CM), (-55.0, 0.0, LEFT, GK)], (30.4, 0.0), MatchConfig())
    paid = []
    for _ in range(80):
        play(matches, [5])
        paid.append(matches["checkpoint_reward"][0, 0])
        if matches["ended"][0]:
            break
    assert matches["ended"][0] == GOAL
    assert sum(paid) == pytest.approx(1.0)
    assert max(paid) < 0.75
    assert min(paid) >= 0.0
