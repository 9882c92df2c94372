"""Control: whom the agents move, in every mode, on either side."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import position, take_over

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import (
    CM,
    DIRECTION_RIGHT,
    DRIBBLE,
    GK,
    LEFT,
    NOBODY,
    RIGHT,
    RUN_SPEED,
    SHORT_PASS,
    SHOT,
    SPRINT,
)
from regista.envs.football.kick_off import MatchConfig, Roster, kick_off
from regista.envs.football.scenic.lineup import NotAMatchError
from regista.envs.football.simulator import step_matches
from regista.envs.football.vector_env import FootballVectorEnv

PROGRAM = """
param end_episode_on_possession_change = {ends}
LeftCM at -10 @ 0
ego = LeftCM at 5 @ 3
LeftGK at -99 @ 0
LeftCM at 5 @ -3
RightCM at 40 @ 0
RightGK at 99 @ 0
ball = Ball at 5 @ 0
"""
OPEN = PROGRAM.format(ends=False)
# A program begins with its ego, a match with the keepers: the left players are 2, 1, 0, 3 of the match.


def distances(matches: np.ndarray) -> np.ndarray:
    left = matches["players"][:, :4]
    return np.hypot(left["x"] - matches["ball"]["x"][:, None], left["y"] - matches["ball"]["y"][:, None])


def started(control: str, right_control: str = "none", count: int = 2) -> FootballVectorEnv:
    env = FootballVectorEnv(OPEN, count, config=FootballConfig(control=control, right_control=right_control))
    env.reset(seed=0)
    return env


@pytest.mark.parametrize(
    ("control", "agents"),
    [
        ("closest1", [1]),
        ("closest2", [1, 3]),
        ("closest3", [1, 3, 2]),
        ("active", [0]),
        ("1", [1]),
        ("2", [1, 3]),
        ("4", [1, 3, 2, 0]),
        ("all", [1, 2, 0, 3]),
        ("allNonGK", [1, 2, 3]),
    ],
)
def test_at_the_start_ties_keep_the_order_of_the_program(control: str, agents: list[int]) -> None:
    """Players 1 and 3 are equally far from the ball; in the program the keeper is third."""
    env = started(control)
    assert env.num_agents == len(agents)
    assert env.matches["agents"][0, : len(agents)].tolist() == agents
    assert (env.matches["agents"][0, len(agents) :] == NOBODY).all()
    assert env.matches["players"]["agent"][0, agents].tolist() == list(range(len(agents)))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_closest_are_chosen_anew_before_every_action(count: int) -> None:
    env = started(f"closest{count}")
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(150):
        env.step(rng.integers(0, 19, env.action_space.shape))
        matches = env.matches
        wanted = np.argsort(distances(matches), axis=1, kind="stable")[:, :count]
        assert (matches["agents"][:, :count] == wanted).all()
        seen.add(tuple(wanted[0]))
    assert len(seen) > 1


@pytest.mark.parametrize("control", ["2", "all", "allNonGK"])
def test_fixed_players_stay(control: str) -> None:
    env = started(control)
    before = env.matches["agents"].copy()
    rng = np.random.default_rng(0)
    for _ in range(100):
        env.step(rng.integers(0, 19, env.action_space.shape))
    assert (env.matches["agents"] == before).all()


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ("5", "control '5' needs 5 players in the left team, which has 4"),
        ("0", "whole number of players from 1, not '0'"),
        ("-1", "whole number of players from 1, not '-1'"),
        ("closest4", "not 'closest4'"),
        ("everybody", "not 'everybody'"),
    ],
)
def test_modes_that_do_not_fit_are_refused(control: str, message: str) -> None:
    with pytest.raises(ValueError) as error:
        FootballVectorEnv(OPEN, config=FootballConfig(control=control))
    assert message in str(error.value)


def test_all_but_the_keeper_needs_exactly_one_keeper() -> None:
    with pytest.raises(NotAMatchError, match="exactly one keeper in the left team, which has 0"):
        FootballVectorEnv(OPEN.replace("LeftGK", "LeftCB"), config=FootballConfig(control="allNonGK"))


def test_there_must_be_an_agent() -> None:
    with pytest.raises(ValueError, match="at least one agent is needed"):
        FootballConfig(control="none")


@pytest.mark.slow
def test_one_agent_has_no_axis_and_several_have_one() -> None:
    one, three = started("closest1"), started("closest3")
    assert one.single_action_space.n == 19 and one.action_space.shape == (2,)
    assert three.single_action_space.nvec.tolist() == [19] * 3 and three.action_space.shape == (2, 3)
    size = one.single_observation_space.shape[0]
    assert three.single_observation_space.shape == (3, size)
    observations, _, _, _, info = three.step(np.zeros((2, 3), int))
    assert observations.shape == (2, 3, size) and info["agent_rewards"].shape == (2, 3)


def test_each_observation_belongs_to_the_player_whom_the_next_action_moves() -> None:
    """His place stands first in `features`, and the key that is pressed next is his."""
    env = started("closest3", count=4)
    rng = np.random.default_rng(1)
    observations = env.observe()
    for _ in range(120):
        matches = env.matches
        rows = np.arange(4)[:, None]
        mine = matches["players"][rows, matches["agents"][:, :3]]
        np.testing.assert_allclose(observations[..., 0], mine["x"] / 55.0, atol=1e-6)
        np.testing.assert_allclose(observations[..., 1], mine["y"] / 36.0, atol=1e-6)
        actions = rng.integers(1, 9, (4, 3))
        going_on = env.step(actions)
        observations, ended = going_on[0], going_on[2] | going_on[3]
        after = env.matches["players"]["action"][rows, matches["agents"][:, :3]]
        assert (after == actions)[~ended].all()


# ---------------------------------------------------------------- both sides

MIRROR = [(-10.0, 0.0, LEFT, CM), (-20.0, 4.0, LEFT, CM), (10.0, 0.0, RIGHT, CM), (20.0, -4.0, RIGHT, CM)]


def facing(control: MatchConfig) -> np.ndarray:
    places = np.array([[row[:2] for row in MIRROR]])
    roster = Roster([row[2] for row in MIRROR], [row[3] for row in MIRROR])
    return kick_off(places, np.zeros((1, 2)), roster, [0], control).view(np.recarray)


@pytest.mark.slow
def test_a_right_agent_sees_and_moves_the_turned_pitch() -> None:
    """Both teams stand turned by 180°: with equal keys until the ball is near, both go the same way as each sees it."""
    matches = facing(MatchConfig(control="2", right_control="2", use_magnet=False))
    assert matches["agents"][0, :4].tolist() == [0, 1, 2, 3]
    for action in (3, SPRINT, 2, 4):
        step_matches(matches, np.array([[action] * 4]))
    players = matches["players"][0]
    np.testing.assert_allclose(players["x"][:2], -players["x"][2:4], atol=1e-9)
    np.testing.assert_allclose(players["y"][:2], -players["y"][2:4], atol=1e-9)
    assert abs(players["y"][0]) > 0.3


@pytest.mark.slow
def test_right_agents_observe_what_left_ones_would() -> None:
    text = """
        ego = LeftCM at -10 @ 0
        LeftCM at -20 @ 4
        RightCM at 10 @ 0
        RightCM at 20 @ -4
        ball = Ball at 0 @ 0
        """.replace("        ", "")
    for name in ("features", "simple115", "smm_stacked"):
        settings = FootballConfig(representation=name, control="2", right_control="2")
        env = FootballVectorEnv(text, 1, config=settings)
        seen, _ = env.reset(seed=0)
        assert env.num_agents == 4
        if name != "smm_stacked":  # whose pixels are cut, not rounded
            np.testing.assert_allclose(seen[0, :2], seen[0, 2:], atol=1e-6)
        assert (seen[0, 0] != seen[0, 1]).any()


def test_right_agents_are_paid_for_their_goals() -> None:
    text = "param end_episode_on_score = True\nego = LeftCM at 60 @ 20\nRightCM at -90 @ 0\nball = Ball at -92 @ 0\n"
    env = FootballVectorEnv(text, 1, config=FootballConfig(control="closest1", right_control="closest1"))
    env.reset(seed=0)
    for _ in range(100):
        _, rewards, terminated, _, info = env.step(np.array([[0, DIRECTION_RIGHT]]))
        if terminated[0]:
            break
    assert rewards[0] == -1.0 and info["agent_rewards"].tolist() == [[-1.0, 1.0]]


# ---------------------------------------------------------------- the original's active player


UNITS = np.array([54.4, -83.6])  # of the original, in m
STRETCHED = np.array([55.0, -83.6 * 1.016])  # where its players stand


def original(players: list[tuple[float, float]], ball: tuple[float, float], keeper: int = 0) -> np.ndarray:
    """Return left players at these places of the original's, its built-in keeper among them, and two far away."""
    places = (np.array(players) * STRETCHED).tolist()
    left = [(x, y, LEFT, GK if i == keeper else CM) for i, (x, y) in enumerate(places)]
    rows = [*left, (55.0, 0.0, RIGHT, GK), (49.5, 25.0, RIGHT, CM)]
    x, y = np.array(ball) * UNITS
    return position(rows, (x, y), MatchConfig(control="active", end_episode_on_possession_change=False))


ROW = [(-1.0, 0.0), *((-0.5 + 0.09 * i, 0.3 - 0.06 * i) for i in range(1, 11))]


@pytest.mark.parametrize(
    ("size", "first", "second"),
    [(1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 3), (5, 0, 4), (6, 5, 5), (7, 6, 6), (8, 6, 6), (11, 6, 6)],
)
def test_who_is_active_at_first_is_the_original_s_measured_choice(size: int, first: int, second: int) -> None:
    """Seen in the real engine, the ball in the middle: before and after a first step. Of 2, 28 m is not near enough."""
    matches = original(ROW[:size], (0.0, 0.0))
    assert matches["agents"][0, 0] == first
    step_matches(matches, np.array([[0]]))
    assert matches["agents"][0, 0] == second


SEVEN = [(-1.0, 0.0), (-0.5, 0.3), (-0.5, -0.3), (-0.3, 0.1), (-0.3, -0.1), (-0.2, 0.3), (0.6, 0.0)]
THREE = [(-1.0, 0.0), (0.0, 0.0), (0.3, 0.2)]


@pytest.mark.parametrize(
    ("players", "ball", "active"),
    [(SEVEN, (0.62, 0.0), 6), (SEVEN, (0.9, 0.3), 6), (THREE, (0.2, 0.0), 1), (THREE, (-0.8, 0.0), 0)],
)
def test_control_goes_where_the_original_s_went(players, ball, active: int) -> None:
    """Measured, too; a keeper who is nearest to the ball keeps it."""
    matches = original(players, ball)
    for _ in range(8):
        step_matches(matches, np.array([[0]]))
        assert matches["agents"][0, 0] == active


def test_sticky_keys_of_the_first_step_count_and_its_kick_is_lost_with_the_player() -> None:
    three = [(-1.0, 0.0), (0.6, 0.0), (0.7, 0.2), (0.7, -0.2)]
    runs = [original(three, (0.62, 0.0)) for _ in range(4)]
    for matches, keys in zip(runs, ([SHOT], [0], [DIRECTION_RIGHT], [0, DIRECTION_RIGHT]), strict=True):
        for step in range(8):
            step_matches(matches, np.array([[keys[step] if step < len(keys) else 0]]))
    shot, idle, right, later = (matches["ball"]["x"][0] for matches in runs)
    assert shot == idle and runs[0]["players"]["x"][0, 0] == runs[1]["players"]["x"][0, 0]
    assert min(right, later) > idle + 1.0
    assert runs[2]["players"]["direction"][0, 1] == DIRECTION_RIGHT and runs[2]["players"]["direction"][0, 0] == 0


def test_a_kick_of_the_first_step_counts_where_control_stays() -> None:
    """Player 6 has the ball from the beginning; in the original it leaves at step 4."""
    matches = original(SEVEN, (0.62, 0.0))
    speeds = []
    for step in range(8):
        step_matches(matches, np.array([[SHOT if step == 0 else 0]]))
        speeds.append(matches["ball"]["vx"][0])
    assert max(speeds) > 15.0


def test_nobody_owns_the_ball_until_it_is_touched() -> None:
    """As seen in the original: the owner is reported from the step on in which the ball first moves, 1 to 5 there."""
    matches = original([(-1.0, 0.0), (0.0, 0.0)], (0.02, 0.0))
    owners, moved = [], []
    for _ in range(8):
        step_matches(matches, np.array([[DIRECTION_RIGHT]]))
        owners.append(int(matches["reported_owner"][0]))
        moved.append(matches["ball"]["x"][0] - 0.02 * 54.4 > 0.05)
    assert owners[0] == NOBODY and owners[-1] == 1
    assert [owner != NOBODY for owner in owners] == moved


def test_another_player_is_designated_only_where_he_is_clearly_sooner() -> None:
    """A mate a little nearer to a loose ball does not get the agent; one much nearer does, but no keeper."""
    for place, gets in ((9.0, False), (0.9, True)):
        rows = [(-54.0, 0.0, LEFT, GK), (10.0, 0.0, LEFT, CM), (-place, 0.0, LEFT, CM), (54.0, 0.0, RIGHT, GK)]
        matches = position(rows, (0.0, 0.0), MatchConfig(control="active", end_episode_on_possession_change=False))
        matches["agents"][0, 0], matches["designated"][0, 0] = 1, 1
        matches["players"]["agent"][0, :3] = NOBODY, 0, NOBODY
        step_matches(matches, np.array([[0]]))
        assert (matches["agents"][0, 0] == 2) == gets
    rows = [(-2.0, 0.0, LEFT, GK), (10.0, 0.0, LEFT, CM), (54.0, 0.0, RIGHT, GK)]
    matches = position(rows, (0.0, 0.0), MatchConfig(control="active", end_episode_on_possession_change=False))
    matches["agents"][0, 0], matches["players"]["agent"][0, :2] = 1, (NOBODY, 0)
    step_matches(matches, np.array([[0]]))
    assert matches["designated"][0, 0] == 0 and matches["agents"][0, 0] == 1


def test_the_active_player_is_the_receiver_as_soon_as_a_pass_leaves() -> None:
    players = [(0.0, 0.0, LEFT, CM), (20.0, 0.0, LEFT, CM), (-50.0, 0.0, LEFT, GK), (50.0, 20.0, RIGHT, GK)]
    matches = position(players, (0.4, 0.0), MatchConfig(control="active", end_episode_on_possession_change=False))
    keys = [DIRECTION_RIGHT, 0, 0, SHORT_PASS, *[0] * 20]
    for key in keys:
        step_matches(matches, np.array([[key]]))
        if matches["carrier"][0] == NOBODY and matches["last_touch"][0] == 0 and matches["ball"]["vx"][0] > 8.0:
            break
    assert matches["ball"]["x"][0] < 10.0  # far closer to the passer
    assert matches["agents"][0, 0] == 1
    assert matches["players"]["direction"][0, 1] == DIRECTION_RIGHT  # the keys go with the agent


def test_the_magnet_can_be_switched_off() -> None:
    """A lone player who is told to run away from a free ball does so without it, and is pulled with it."""
    players = [(0.0, 0.0, LEFT, CM), (50.0, 20.0, RIGHT, GK)]
    ends = []
    for magnet in (True, False):
        matches = position(players, (12.0, 0.0), MatchConfig(use_magnet=magnet, game_duration=100))
        for _ in range(15):
            step_matches(matches, np.array([[1]]))
        ends.append(matches["players"]["x"][0, 0])
    assert ends[0] > 3.0 and ends[1] < -0.9 * RUN_SPEED


def test_sprint_and_dribble_together_free_a_player_of_the_magnet() -> None:
    """A free ball pulls him against either key alone, and against none with both."""
    players = [(0.0, 0.0, LEFT, CM), (50.0, 20.0, RIGHT, GK)]
    ends = []
    for sticky in ([SPRINT], [DRIBBLE], [SPRINT, DRIBBLE]):
        matches = position(players, (12.0, 0.0), MatchConfig(game_duration=100))
        for key in (*sticky, *[1] * 15):
            step_matches(matches, np.array([[key]]))
        ends.append(matches["players"]["x"][0, 0])
    assert ends[0] > 3.0 and ends[1] > 3.0 and ends[2] < -0.9 * RUN_SPEED


def test_a_player_who_was_sent_off_is_not_chosen() -> None:
    matches = position([(0.0, 1.0, LEFT, CM), (0.0, 9.0, LEFT, CM), (50.0, 0.0, RIGHT, GK)], (0.0, 0.0))
    matches["players"]["has_left"][0, 0] = True
    step_matches(matches, np.array([[0]]))
    assert matches["agents"][0, 0] == 1


def test_a_match_without_agents_plays_itself() -> None:
    matches = position([(0.0, 1.0, LEFT, CM), (50.0, 0.0, RIGHT, GK)], (0.0, 0.0))
    take_over(matches, NOBODY)
    for _ in range(30):
        step_matches(matches, np.zeros((1, 1), np.int64))
    assert matches["players"]["action"][0, 0] == 19 and matches["ball"]["x"][0] != 0.0
