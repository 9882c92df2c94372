"""Settings of the match that a program draws: difficulties, durations, rules; columns of θ like all that is random."""

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import NUM_ACTIONS
from regista.envs.football.limits import StateError
from regista.envs.football.observation.features import features_names
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import NotAMatchError
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.__main__ import main
from regista.experiments.run.table import read_columns
from scenic_lite import load

PLACES = """
ego = LeftCM at -10 @ 0
LeftGK at -98 @ 0
RightGK at 98 @ 0
RightCB at 10 @ 3
ball = Ball ahead of ego by 1
"""
DRAWN = """
param game_duration = DiscreteRange(5, 9)
param right_team_difficulty = Range(0, 1), left_team_difficulty = Range(0.2, 0.4)
param offsides = Uniform(True, False), second_half = DiscreteRange(3, 8)
param deterministic = Uniform(True, False), engine_spread = Range(0, 0.2)
"""
NAMES = [
    *("game_duration", "right_team_difficulty", "left_team_difficulty", "offsides", "second_half"),
    *("deterministic", "engine_spread"),
]


def make(settings, count=2, theta=None):
    """Return matches of a program with some settings, at their start."""
    env = FootballVectorEnv(settings + PLACES, count)
    env.reset(seed=0, options=None if theta is None else {"theta": np.array(theta, float)})
    return env


def rollout(env, steps, seed=3):
    """Return the matches after each of some steps of random actions."""
    rng, seen = np.random.default_rng(seed), []
    for _ in range(steps):
        env.step(rng.integers(0, NUM_ACTIONS, env.num_envs))
        seen.append(env.matches)
    return seen


def test_random_settings_are_columns_and_reach_the_record():
    theta = np.zeros((2, 7))
    theta[0], theta[1] = -1, 1
    env = make(DRAWN, theta=theta)
    assert [draw.name for draw in env.parameters] == NAMES
    first, second = map(env.program.describe, theta)
    assert first["game_duration"] == 5 and second["game_duration"] == 9
    assert first["right_team_difficulty"] == 0 and second["right_team_difficulty"] == 1
    matches = env.matches
    for name in ("game_duration", "second_half", "offsides", "deterministic"):
        assert matches[name].tolist() == [first[name], second[name]]
    np.testing.assert_allclose(matches["players"]["skill"][:, :2], 0.3 + 0.7 * np.array([[0.2] * 2, [0.4] * 2]))
    np.testing.assert_allclose(matches["players"]["skill"][:, 2:4], 0.3 + 0.7 * np.array([[0.0] * 2, [1.0] * 2]))
    np.testing.assert_allclose(matches["engine_spread"], [0, 0.2])


def test_matches_of_different_durations_end_each_at_its_own():
    env = make("param game_duration = DiscreteRange(5, 9)\n", theta=[[-1], [1]])
    ends = []
    for step in range(1, 10):
        _, _, terminated, truncated, _ = env.step(np.zeros(2, int))
        assert not terminated.any()
        ends += [(step, int(row)) for row in np.flatnonzero(truncated)]
    assert ends == [(5, 0), (9, 1)]


@pytest.mark.parametrize(
    ("duration", "longest"),
    [
        ("param game_duration = 30", 30),
        ("param game_duration = DiscreteRange(5, 9)", 9),
        ("param game_duration = Uniform(5, 70, 30)", 70),
        ("param game_duration = Discrete({5: 3, 12: 1})", 12),
        ("game_duration = DiscreteRange(5, 9)\nparam game_duration = 2 * game_duration", 18),
        ("game_duration = DiscreteRange(5, 9)\nparam game_duration = 20 - game_duration", 15),
        ("param game_duration = 3 * DiscreteRange(5, 9)", None),
    ],
)
def test_the_longest_episode_is_that_of_the_values(duration, longest):
    assert make(duration).max_episode_steps == longest


def test_observations_tell_the_share_of_the_own_duration_that_is_left():
    env = make("param game_duration = DiscreteRange(5, 9)\n", theta=[[-1], [1]])
    seen = env.step(np.zeros(2, int))[0]
    clock = features_names(4).index("clock")
    np.testing.assert_allclose(seen[:, clock], [1 - 1 / 5, 1 - 1 / 9], rtol=1e-6)
    raw = FootballVectorEnv(
        "param game_duration = DiscreteRange(5, 9)\n" + PLACES, 2, config=FootballConfig(representation="raw")
    )
    seen, _ = raw.reset(seed=0, options={"theta": np.array([[-1.0], [1.0]])})
    assert seen["steps_left"].tolist() == [5, 9]


def test_programs_see_the_steps_that_their_own_match_has_left():
    text = "record simulation().game_ds.steps_left as left\nparam game_duration = DiscreteRange(5, 9)\n" + PLACES
    env = FootballVectorEnv(text, 2)
    env.reset(seed=0, options={"theta": np.array([[-1.0], [1.0]])})
    assert env.step(np.zeros(2, int))[4]["records"]["left"].tolist() == [4, 8]


def test_difficulties_change_play_and_nothing_else_at_the_start():
    env = make("param right_team_difficulty = Range(0, 1)\n")
    start = env.lineup.starts(np.array([[-1.0], [1.0]]), np.array([7, 7]))
    assert start["players"]["skill"][0].tolist() != start["players"]["skill"][1].tolist()
    start["players"]["skill"] = 0
    assert start[0] == start[1]
    levels = env.levels.copy()
    levels["theta"], levels["seed"] = [[-1.0], [1.0]], 7
    env.reset_to_levels(levels)
    rng, play = np.random.default_rng(0), []
    for _ in range(80):
        env.step(np.full(2, rng.integers(0, NUM_ACTIONS)))
        play.append(env.matches)
    assert any(each["players"]["x"][0, 3] != each["players"]["x"][1, 3] for each in play)


@pytest.mark.parametrize("value", [(12, 0.25, "True"), (30, 1.0, "False")])
def test_a_drawn_setting_plays_as_the_same_setting_written_down(value):
    duration, difficulty, flag = value
    drawn = f"param game_duration = DiscreteRange({duration}, {duration})\n"
    drawn += f"param right_team_difficulty = Range({difficulty}, {difficulty}), deterministic = Uniform({flag})\n"
    fixed = f"param game_duration = {duration}, right_team_difficulty = {difficulty}, deterministic = {flag}\n"
    both = [make(drawn), make(fixed)]
    for env in both:
        levels = env.levels.copy()
        levels["seed"] = [4, 5]
        env.reset_to_levels(levels)
    one, other = (rollout(env, 40) for env in both)
    assert all((a == b).all() for a, b in zip(one, other, strict=True))


def test_a_match_that_is_drawn_deterministic_repeats_itself_and_its_neighbor_does_not():
    settings = "param game_duration = 25, deterministic = Uniform(True, False), engine_spread = 0.3\n"
    env = make(settings, theta=[[-1], [1]])
    play = rollout(env, 0)
    for _ in range(50):
        env.step(np.full(2, 12))
        play.append(env.matches)
    again = [(play[t]["engine"][0] == play[t + 25]["engine"][0], play[t]["engine"][1] == play[t + 25]["engine"][1])
             for t in range(24)]  # fmt: skip
    assert all(first for first, _ in again) and not any(second for _, second in again)


REFUSED = {
    "game_duration = DiscreteRange(0, 9)": "must be a whole number of steps, 1 to 1,000,000, not 0",
    "game_duration = Range(100, 200)": "(write param game_duration = DiscreteRange(low, high))",
    "right_team_difficulty = Range(0, 2)": "must be a number from 0 to 1, not 2.0",
    "left_team_difficulty = Uniform(0.5, 'hard')": "must be a number from 0 to 1, not 'hard'",
    "offsides = Uniform(1, 2)": "must be True or False, not ",
    "defending = Uniform(True, False)": "must be True or False, not a random value: it defines success",
    "game_duration = 0": "must be a whole number of steps, 1 to 1,000,000, not 0",
    "right_team_difficulty = 2": "must be a number from 0 to 1, not 2",
}


@pytest.mark.parametrize("setting", REFUSED)
def test_what_no_match_can_have_is_refused_at_its_line(setting):
    with pytest.raises(NotAMatchError) as caught:
        FootballVectorEnv(f"\nparam {setting}{PLACES}")
    said = str(caught.value)
    assert said.startswith(f"<program>:2:7: param {setting.split(' =')[0]} ") and REFUSED[setting] in said
    assert f"param {setting}" in said.splitlines()[1]


def test_a_value_that_only_scenes_without_matches_have_is_none():
    env = make("length = DiscreteRange(0, 9)\nrequire length > 4\nparam game_duration = length\n", count=8)
    assert (env.matches["game_duration"] > 4).all()


def test_a_state_with_a_duration_that_no_match_has_is_refused():
    env = make("param game_duration = DiscreteRange(5, 9)\n")
    state = env.get_state()
    state["matches"]["game_duration"][1] = 0
    with pytest.raises(StateError, match=r"matches\[1\]\.game_duration is 0"):
        env.set_state(state)


def test_a_state_goes_on_with_its_own_settings():
    env = make(DRAWN, count=4)
    rollout(env, 3)
    state, twin = env.get_state(), FootballVectorEnv(DRAWN + PLACES, 4)
    twin.set_state(state)
    assert all((a == b).all() for a, b in zip(rollout(env, 12), rollout(twin, 12), strict=True))


def test_theta_finds_a_match_with_settings_that_a_person_names():
    program = load(DRAWN + PLACES, FOOTBALL)
    theta = program.theta({"game_duration": 7, "right_team_difficulty": 0.75}, default=np.zeros(program.dim))
    assert program.describe(theta[0])["game_duration"] == 7
    assert program.describe(theta[0])["right_team_difficulty"] == pytest.approx(0.75)


@pytest.mark.slow
def test_domain_randomization_of_difficulty_and_duration_trains(tmp_path):
    program = tmp_path / "mine.scenic"
    settings = "param game_duration = DiscreteRange(8, 32), right_team_difficulty = Range(0, 1)"
    program.write_text(settings + PLACES)
    call = ["train", str(program), "--method", "dr", "--out", str(tmp_path / "run"), "--total-env-steps", "1024"]
    assert main([*call, "--num-envs", "4", "--eval-every", "0", "--no-record"]) == 0
    levels = read_columns(tmp_path / "run" / "levels.csv")
    lengths, difficulties = levels["theta/game_duration"], levels["theta/right_team_difficulty"]
    assert len(set(lengths)) > 3 and len(set(difficulties)) > 3
