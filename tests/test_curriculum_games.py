"""Tests of the games that need a curriculum: test scenes lie within each game, and its difficulty parameters work."""

import numpy as np
import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames.suites import MINIGAMES, SPARSE_REWARD
from scenic_lite import load

DIMENSIONS = {
    "Gauntlet": 11,
    "ThreeLines": 11,
    "Pursuit": 11,
    "Alone": 8,
    "Crowd": 15,
    "1v1Rare": 7,
    "1v1RareLine": 8,
    "Buildup": 15,
    "CrossingWide": 12,
}
HELD_OUT = {"Gauntlet": 11, "Pursuit": 11, "Crowd": 4, "Buildup": 15}  # columns of held-out scenes, parts of each game


def program_of(path):
    return load(path, FOOTBALL)


def corners(program):
    """Return the least and greatest position of each object: at the ends and middle of each column, and at random θ."""
    theta = np.vstack([np.zeros((1, program.dim)), np.eye(program.dim), -np.eye(program.dim)])
    theta = np.vstack([theta, np.random.default_rng(0).uniform(-1, 1, (256, program.dim))])
    places = program.instantiate(theta).positions
    return places.min(0), places.max(0)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPARSE_REWARD)
def test_all_scenes_of_a_game_are_the_same_match(name):
    game = SPARSE_REWARD[name]
    train = Lineup(program_of(game.program))
    assert train.program.dim == DIMENSIONS[name]
    theta = np.random.default_rng(0).uniform(-1, 1, (1000, train.program.dim))
    assert train.program.valid(theta).mean() > 0.97
    for _, path in (*game.tests, *game.held_out):
        other = Lineup(program_of(path))
        assert (np.asarray(other.roster.teams) == np.asarray(train.roster.teams)).all()
        assert other.config.end_episode_on_possession_change and other.config.end_episode_on_score
        assert other.config.game_duration == train.config.game_duration


@pytest.mark.parametrize("name", HELD_OUT)
def test_tests_and_held_out_scenes_lie_within_the_game(name):
    game = SPARSE_REWARD[name]
    low, high = corners(program_of(game.program))
    for label, path in (*game.tests, *game.held_out):
        program = program_of(path)
        assert program.dim == (HELD_OUT[name] if (label, path) in game.held_out else 0)
        least, greatest = corners(program)
        assert (least > low - 6).all() and (greatest < high + 6).all(), label


@pytest.mark.parametrize("name", ["1v1Restricted", "1v1Free"])
def test_held_out_keepers_stand_in_the_way_near_it_and_clear_of_it_within_the_game(name):
    game = MINIGAMES[name]
    low, high = corners(program_of(game.program))
    gaps = {}
    for label, path in game.held_out:
        program = program_of(path)
        theta = np.random.default_rng(1).uniform(-1, 1, (400, program.dim))
        places = program.instantiate(theta).positions
        assert (places.min(0) > low - 0.5).all() and (places.max(0) < high + 0.5).all(), label
        ego, keeper = places[:, 0], places[:, 1]
        way = ego[:, 1] * (100 - keeper[:, 0]) / (100 - ego[:, 0])  # y of the line to the goal at the keeper's x
        gaps[label] = np.abs(keeper[:, 1] - way)
        assert (keeper[:, 0] >= ego[:, 0] - 0.5).all()
    assert gaps["in"].max() <= 2 <= gaps["near"].min() and gaps["near"].max() <= 6 <= gaps["clear"].min()


def aside_of_the_way(striker, keeper):
    return np.abs(keeper[:, 1] - striker[:, 1] * (100 - keeper[:, 0]) / (100 - striker[:, 0]))


def before_the_line(striker, keeper):
    return 99 - keeper[:, 0]


@pytest.mark.parametrize(
    ("name", "gap", "most"), [("1v1Rare", aside_of_the_way, 2), ("1v1RareLine", before_the_line, 0)]
)
def test_what_is_rare_comes_in_one_random_level_of_fifty_and_in_half_of_what_is_held_out(name, gap, most):
    game = SPARSE_REWARD[name]

    def gaps(path):
        program = program_of(path)
        places = program.instantiate(np.random.default_rng(0).uniform(-1, 1, (20_000, program.dim))).positions
        return gap(places[:, 0], places[:, 1])

    (_, rare), (_, common) = game.held_out
    assert gaps(rare).max() < most + 0.1 < gaps(common).min()
    assert 0.015 < (gaps(game.program) < most + 0.1).mean() < 0.025


def courses(name, columns, steps=30):
    """Play with an idle carrier and some columns fixed; return the right team's positions `[steps, N, players, 2]`."""
    env = FootballVectorEnv(SPARSE_REWARD[name].program, 32)
    env.reset(seed=0)
    theta = env.sample_levels(32)["theta"]
    for column, value in columns.items():
        theta[:, column] = value
    env.reset(seed=0, options={"theta": theta})
    right = np.flatnonzero((env.matches["players"]["team"][0] == 1)[: env.num_players])
    seen = []
    for _ in range(steps):
        players = env.matches["players"][:, right]
        seen.append(np.stack([players["x"], players["y"]], -1))
        env.step(np.zeros(32, int))
    return np.array(seen)


def test_a_guard_without_reach_stands_and_one_with_reach_comes():
    near = {0: 1.0, 1: 0.0}  # the striker is 10 m from the goal line, so close to the first guard that they touch
    still, awake = (courses("Gauntlet", near | dict.fromkeys((4, 7, 10), reach), 5)[:, :, 2:] for reach in (-1.0, 1.0))
    gone = [np.hypot(*np.moveaxis(course[-1] - course[0], -1, 0)) for course in (still, awake)]
    assert np.median(gone[0], 0).max() < 0.01  # of the other two guards; few of them are pushed
    assert np.median(gone[1], 0).min() > 0.5


def test_so_many_defend_as_are_awake():
    asleep, awake = (courses("Buildup", {0: value}, 10)[:, :, 1:] for value in (-1.0, 1.0))
    gone = [np.hypot(*np.moveaxis(course[-1] - course[0], -1, 0)) for course in (asleep, awake)]
    assert np.quantile(gone[0], 0.9) < 0.2  # running players push some of them
    assert np.quantile(gone[1], 0.1) > 0.5


@pytest.mark.slow
def test_a_chaser_comes_the_nearer_the_greater_his_pace():
    paces = (-1.0, -0.2, 1.0)  # stands, runs in 4 of 10 steps, runs in every step
    ways = [courses("Pursuit", {0: -1.0, 1: 0.0} | dict.fromkeys((4, 7, 10), pace), 20)[:, :, 2:] for pace in paces]
    stood, walked, ran = (np.median(np.hypot(*np.moveaxis(way[-1] - way[0], -1, 0)), 0) for way in ways)
    assert stood.max() < 0.01
    assert (walked > 1.0).all() and (ran > 1.5 * walked).all()


def test_an_episode_of_the_crowd_ends_where_the_ball_is_lost_before_the_box():
    env = FootballVectorEnv(SPARSE_REWARD["Crowd"].program, 64)
    env.reset(seed=0)
    theta = env.sample_levels(64)["theta"]
    theta[:, 0], theta[:, 2] = -1.0, -1.0  # from midfield, guards with the shortest reach
    env.reset(seed=0, options={"theta": theta})
    ended = np.zeros(64, bool)
    for step in range(40):
        _, reward, ended_now, cut, _ = env.step(np.full(64, 12 if step == 0 else 0))  # a shot, then idle
        ended |= ended_now | cut
    assert ended.mean() > 0.9 and (reward == 0).all()
