"""The thesis's own programs: Figures 4.1 and 4.3 are one environment with six parameters; Figure 2.1 runs whole."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from regista import minigames
from regista.envs.football.scenic.domain import FOOTBALL
from scenic_lite import load

PROGRAMS = Path(__file__).parents[1] / "programs"
RNG = np.random.default_rng


@pytest.fixture(scope="module")
def by_region():
    return load(PROGRAMS / "figure_4_1.scenic", FOOTBALL)


@pytest.fixture(scope="module")
def by_range():
    return load(PROGRAMS / "figure_4_3.scenic", FOOTBALL)


def test_six_columns_in_the_same_order(by_region, by_range):
    assert [draw.name for draw in by_region.draws] == ["ego.x", "ego.y", "opponent.x", "opponent.y", "MyGK.x", "MyGK.y"]
    assert [draw.name for draw in by_range.draws] == ["X1", "Y1", "X2", "Y2", "MyGK.x", "MyGK.y"]
    limits = [(draw.low, draw.high) for draw in by_region.draws]
    assert limits == [(draw.low, draw.high) for draw in by_range.draws]
    assert limits[:4] == [(0, 80), (-25, 25), (0, 80), (-25, 25)]


def test_corresponding_theta_gives_the_same_scene(by_region, by_range):
    theta = RNG(0).uniform(-1, 1, (500, 6))
    a, b = by_region.instantiate(theta), by_range.instantiate(theta)
    np.testing.assert_array_equal(a.positions, b.positions)
    np.testing.assert_array_equal(a.ok, b.ok)


EDGES = some.tuples(some.integers(-90, 85), some.integers(1, 10), some.integers(-38, 30), some.integers(1, 8))


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(EDGES, EDGES, some.sampled_from([2, 3]), some.integers(0, 2**32))
def test_a_region_and_two_ranges_are_the_same_wherever_they_lie(a, b, dialect, seed):
    by_region = load(REGIONS.format(*edges(a), *edges(b)), FOOTBALL, dialect)
    by_range = load(RANGES.format(*edges(a), *edges(b)), FOOTBALL, dialect)
    columns = [[(draw.low, draw.high) for draw in each.draws] for each in (by_region, by_range)]
    assert len(columns[0]) == 6 and columns[0] == columns[1]
    theta = np.concatenate([RNG(seed).uniform(-1, 1, (40, 6)), CORNERS])
    one, other = by_region.instantiate(theta), by_range.instantiate(theta)
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(one.ok, other.ok)
    gap = one.positions[:, 3] - one.positions[:, 0]
    np.testing.assert_allclose(gap, [[0, 2.1 if dialect == 2 else 2.6]] * len(theta), atol=1e-12)


REGIONS = """\
ego = LeftCM on get_reg_from_edges({}, {}, {}, {})
opponent = RightGK on get_reg_from_edges({}, {}, {}, {})
new MyGK
ball = Ball ahead of ego by 2
"""
RANGES = """\
X1 = Range({}, {})
Y1 = Range({}, {})
X2 = Range({}, {})
Y2 = Range({}, {})
ego = LeftCM at (X1 @ Y1)
opponent = RightGK at (X2 @ Y2)
new MyGK
ball = Ball ahead of ego by 2
"""


def corners(dim):
    return np.array(list(itertools.product((-1.0, 1.0), repeat=dim)))


CORNERS = corners(6)


def edges(sides):
    left, width, bottom, height = sides
    return left, left + width, bottom, bottom + height


@pytest.mark.parametrize("game", minigames.MINIGAMES)
def test_the_edges_of_theta_belong_to_it(game):
    program = load(minigames.MINIGAMES[game].program, FOOTBALL)
    ends = corners(program.dim)
    scenes = program.instantiate(ends)
    inside = [i for i, rule in enumerate(program.requirements) if rule.kind == "containment"]
    assert inside and not scenes.failed[:, inside].any()
    limits = np.array([[draw.low, draw.high] for draw in program.draws])
    values = np.array([list(program.describe(corner).values()) for corner in ends])
    np.testing.assert_array_equal(values, np.where(ends < 0, limits[:, 0], limits[:, 1]))


def test_theta_of_single_precision_means_the_same(by_region):
    theta = RNG(4).uniform(-1, 1, (300, 6)).astype(np.float32)
    single, double = by_region.instantiate(theta), by_region.instantiate(theta.astype(np.float64))
    np.testing.assert_array_equal(single.positions, double.positions)
    np.testing.assert_array_equal(single.ok, double.ok)
    valid, _ = by_region.sample(2000, RNG(5))
    rounded = by_region.instantiate(valid.astype(np.float32))
    near = np.abs(rounded.positions - by_region.instantiate(valid).positions)
    assert near.max() < 1e-5
    assert rounded.ok.mean() > 0.999  # a pair that all but touched may touch


def test_theta_is_scaled_linearly(by_region):
    scenes = by_region.instantiate(np.array([[-1.0, -1, 0, 0, 0, 0], [1, 1, 0.5, -0.5, 0, 0]]))
    np.testing.assert_allclose(scenes.positions[:, 0], [[0, -25], [80, 25]])
    np.testing.assert_allclose(scenes.positions[:, 1], [[40, 0], [60, -12.5]])


@pytest.mark.parametrize("figure", ["by_region", "by_range"])
def test_ball_is_always_ahead_of_the_striker(figure, request):
    program = request.getfixturevalue(figure)
    _, scenes = program.sample(1000, RNG(1))
    np.testing.assert_allclose(scenes.positions[:, 3] - scenes.positions[:, 0], [[0, 2.1]] * 1000)


def test_in_scenic_3_the_ball_is_half_a_player_farther():
    program = load("ego = new LeftCM at 3 @ 4\nball = new Ball ahead of ego by 2", FOOTBALL, dialect=3)
    scenes = program.instantiate(np.zeros((1, 0)))
    np.testing.assert_allclose(scenes.positions[0], [[3, 4], [3, 6.6]])


def test_team_and_role_of_everyone(by_region):
    scenes = by_region.instantiate(np.zeros((1, 6)))
    assert scenes.properties["team"] == ["left", "right", "left", None]
    assert scenes.properties["role"] == ["CM", "GK", "GK", None]
    assert by_region.objects[2].classes[:4] == ("MyGK", "LeftGK", "LeftPlayer", "Player")
    assert [info.name for info in by_region.objects] == ["ego", "opponent", "", "ball"]


def test_place_of_a_draw_is_in_the_program(by_region):
    assert [draw.place.line for draw in by_region.draws] == [3, 3, 4, 4, 6, 6]
    assert {draw.place.file for draw in by_region.draws} == {"figure_4_1.scenic"}


def test_figure_2_1_runs_whole():
    program = load(PROGRAMS / "figure_2_1.scenic", FOOTBALL)
    assert program.dim == 22  # eight positions, and three points in behavior arguments
    assert [info.name or info.class_name for info in program.objects] == [
        *("ego", "RightGK", "right_RightMid", "right_LeftMid", "ball", "LeftGK", "leftLB", "leftCB", "leftRB"),
    ]
    behaviors = [info.behavior for info in program.objects]
    assert behaviors[:4] == ["runToReceiveCrossAndShoot", None, "runToReceiveCrossAndShoot", "rightLMBehavior"]
    _, scenes = program.sample(200, RNG(2))
    assert scenes.ok.all()
    np.testing.assert_allclose(scenes.positions[:, 4] - scenes.positions[:, 3], [[0, 2.1]] * 200)
    target = scenes.behavior_arguments[0]["destinationPoint"]  # of the ego, in rightAM_AttackRegion
    assert ((target > [-90, -10]) & (target < [-85, -5])).all()
    assert program.params["end_episode_on_score"] is True
    assert program.params["action_set"] == "v2"  # from the model


def test_keepers_of_the_library_always_fit_onto_the_pitch():
    program = load("ego = LeftGK\nRightGK", FOOTBALL)
    assert program.report(2000, RNG(3)).acceptance == 1
