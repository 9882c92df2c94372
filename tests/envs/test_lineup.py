"""What a program must be to become a match, and what is said where it is not."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import METRES_PER_X, METRES_PER_Y
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.scenic.domain import FOOTBALL, SETTINGS
from regista.envs.football.scenic.lineup import ROLES, Lineup, NotAMatchError
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import load

PROGRAMS = Path(__file__).parents[1] / "programs"
PAIR = "ego = LeftCM at 0 @ 0\nBall at 5 @ 5\n"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("ego = LeftCM at 0 @ 0", "<program>: a match needs a Ball; write ball = Ball ahead of ego by 2"),
        (
            PAIR + "Ball at 9 @ 9",
            "<program>:3:1: a match needs exactly one Ball, this program has 2\n    Ball at 9 @ 9\n    ^^^^^^^^^^^^^",
        ),
        (PAIR + "Object at 9 @ 9", "<program>:3:1: Object is neither a player nor the ball"),
        (
            "ego = RightCM at 0 @ 0\nBall at 5 @ 5",
            "<program>: agents play on the left, and this program has no left player",
        ),
        (PAIR + "Player at 0 @ 3", "<program>:3:1: Player is in no team (use a Left... or Right... class)"),
        (
            PAIR + "LeftPlayer at 0 @ 3, with role 'XX'",
            "<program>:3:1: LeftPlayer has the role 'XX' (give it one of GK, CB",
        ),
        (
            PAIR + "LeftPlayer at 0 @ 3, with role Uniform('CB', 'XX')",
            "<program>:3:1: LeftPlayer has the role 'XX' (give",
        ),
        (PAIR + "for i in range(11):\n    LeftCB at -9 @ (3 * i)", "<program>: 12 left players; a team has at most 11"),
    ],
)
def test_a_program_that_is_no_match_is_refused(body, message):
    with pytest.raises(NotAMatchError) as error:
        FootballVectorEnv(body + "\n")
    assert str(error.value).startswith(message)


def test_a_random_role_is_drawn_for_each_match():
    program = load(PAIR + "other = RightPlayer at 9 @ 9\n", FOOTBALL)
    lineup = Lineup(program)
    theta, scenes = program.sample(64, np.random.default_rng(0))
    matches = lineup.starts(theta, np.arange(64))
    place = lineup.object_to_player[2]
    assert [list(ROLES)[role] for role in matches["players"]["role"][:, place]] == list(scenes.properties["role"][2])
    keepers = matches["players"]["role"][:, place] == ROLES["GK"]
    assert keepers.any() and not keepers.all()
    assert len(np.unique(matches["players"]["top_speed"][keepers, place])) == 1
    with pytest.raises(NotAMatchError, match="RightPlayer has a random role"):
        Lineup(program, right_control="allNonGK")


# ---------------------------------------------------------------- settings


@pytest.mark.parametrize(
    ("setting", "wanted"),
    [
        ("game_duration = 'long'", "a whole number of steps, 1 to 1,000,000, not 'long'"),
        ("game_duration = 0", "a whole number of steps, 1 to 1,000,000, not 0"),
        ("game_duration = 2.5", "a whole number of steps, 1 to 1,000,000, not 2.5"),
        ("game_duration = 1e30", "a whole number of steps, 1 to 1,000,000, not 1e+30"),
        ("game_duration = math.inf", "a whole number of steps, 1 to 1,000,000, not inf"),
        ("offsides = 'no'", "True or False, not 'no'"),
        ("offsides = 0", "True or False, not 0"),
        ("right_team_difficulty = 2", "a number from 0 to 1, not 2"),
        ("right_team_difficulty = True", "a number from 0 to 1, not True"),
        ("right_team_difficulty = math.inf - math.inf", "a number from 0 to 1, not nan"),
        (
            "defending = Uniform(True, False)",
            "True or False, not a random value: it defines success in all matches of a program",
        ),
    ],
)
def test_a_setting_that_does_not_fit_is_refused_where_it_is_written(setting, wanted):
    name = setting.split()[0]
    with pytest.raises(NotAMatchError) as error:
        FootballVectorEnv(f"{PAIR}param {setting}\n")
    assert str(error.value).splitlines() == [
        f"<program>:3:7: param {name} must be {wanted}",
        f"    param {setting}",
        f"          {'^' * len(name)}",
    ]


def test_a_setting_of_the_caller_is_refused_as_the_callers():
    program = load(f"param game_duration = 30\n{PAIR}", FOOTBALL, params={"game_duration": -3})
    with pytest.raises(NotAMatchError, match=r"not -3 \(its caller set it, as --param game_duration=-3 does\)"):
        Lineup(program)


def test_the_last_of_several_settings_counts():
    env = FootballVectorEnv(f"param game_duration = 'x'\nparam game_duration = 30\n{PAIR}param offsides = True\n")
    assert (env.lineup.config.game_duration, env.lineup.config.offsides) == (30, True)


def test_settings_are_those_of_a_match():
    assert {field.name for field in dataclasses.fields(MatchConfig)} - {"control", "right_control"} == SETTINGS


def test_parameters_of_the_model_and_of_the_original_engine_are_known():
    names = [*load(PAIR, FOOTBALL).params, "write_video", "render_resolution_y", "dump_frequency", "players"]
    text = PAIR + "".join(f"param {name} = 1\n" for name in names)
    assert load(text, FOOTBALL).warnings == ()
    assert {"action_set", "rewards", "stacked", "real_time"} <= set(names) <= FOOTBALL.params


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "param game_duraton = 400",
            "<program>:3:7: nothing reads the parameter 'game_duraton' (did you mean 'game_duration'?)",
        ),
        (
            "param end_episode_on_goal = True",
            "<program>:3:7: nothing reads the parameter 'end_episode_on_goal' (did you mean 'end_episode_on_score'?)",
        ),
        ("param weather = 'sunny'", None),
    ],
)
def test_a_misspelt_setting_is_warned_of(line, expected):
    heads = [str(warning).splitlines()[0] for warning in load(PAIR + line, FOOTBALL).warnings]
    assert heads == ([expected] if expected else [])


# ---------------------------------------------------------------- the thesis's striker keeps his ball


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["figure_4_1", "figure_4_3"])
@pytest.mark.parametrize(("dialect", "ahead"), [(2, 2.1), (3, 2.6)])
def test_the_ball_lies_before_the_striker_on_whatever_level_is_played(figure, dialect, ahead):
    text = (PROGRAMS / f"{figure}.scenic").read_text().replace("\nMyGK\n", "\nnew MyGK\n")
    env = FootballVectorEnv(text + "param game_duration = 3\n", 32, config=FootballConfig(dialect=dialect))
    assert env.theta_dim == 6
    env.reset(seed=0)
    theta = np.random.default_rng(1).uniform(-1, 1, (32, 6))
    theta[::2, 2:4] = theta[::2, :2]  # the keeper inside the striker: invalid
    _, info = env.step_adversary(theta)
    assert info["replaced"][::2].all()
    assert_ball_is_ahead(env, ahead)
    env.level_sampler = env.sample_levels
    for _ in range(3):
        _, _, terminated, truncated, _ = env.step(np.zeros(32, int))
    assert (terminated | truncated).any()
    assert_ball_is_ahead(env, ahead, terminated | truncated)
    env.reset_random()
    assert_ball_is_ahead(env, ahead)


def assert_ball_is_ahead(env, ahead, where=slice(None)):
    matches, theta = env.matches[where], env.levels["theta"][where]
    striker = matches["players"][:, 1]  # after his keeper
    np.testing.assert_allclose(striker["x"], (theta[:, 0] + 1) * 40 * METRES_PER_X, atol=1e-9)
    np.testing.assert_allclose(striker["y"], theta[:, 1] * 25 * METRES_PER_Y, atol=1e-9)
    np.testing.assert_allclose(matches["ball"]["x"], striker["x"], atol=1e-9)
    np.testing.assert_allclose(matches["ball"]["y"] - striker["y"], ahead * METRES_PER_Y, atol=1e-9)
