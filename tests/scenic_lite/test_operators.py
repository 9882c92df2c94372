"""Every operator against numbers worked out by hand. The ego stands at (1, 2), heading 90 degrees (-x)."""

import math

import numpy as np
import pytest
from scene import one_scene, param, things

from scenic_lite import ScenicError

DEGREE = math.pi / 180
BOTH = [
    ("2 * 3 @ 4", (6, 4)),
    ("-98 @ -1", (-98, -1)),
    ("(1 @ 2) + (3, 4)", (4, 6)),
    ("2 * (1 @ 2) - 3 @ 4", (-1, 0)),
    ("(1 @ 2) / 2", (0.5, 1)),
    ("distance from 0 @ 0 to 3 @ 4", 5),
    ("distance to 1 @ 5", 3),
    ("distance from 1 @ 5", 3),
    ("distance from 5 @ 6 to RectangularRegion(0 @ 0, 0, 4, 4)", 5),
    ("distance from RectangularRegion(0 @ 0, 45 deg, 2, 2) to 0 @ 3", 3 - math.sqrt(2)),
    ("distance to RectangularRegion(0 @ 0, 0, 4, 4)", 0),
    ("distance from 0 @ 9 to CircularRegion(0 @ 1, 3)", 5),
    ("angle from 0 @ 0 to 0 @ 3", 0),
    ("angle from 0 @ 0 to -3 @ 0", math.pi / 2),
    ("angle from 0 @ 0 to 3 @ 3", -math.pi / 4),
    ("angle to 4 @ 2", -math.pi / 2),
    ("relative heading of 100 deg", 10 * DEGREE),
    ("relative heading of -170 deg from 170 deg", 20 * DEGREE),
    ("relative heading of ego from 0", 90 * DEGREE),
    ("relative position of 4 @ 6", (3, 4)),
    ("relative position of ego from 0 @ 0", (1, 2)),
    ("apparent heading of ego from 1 @ 0", 90 * DEGREE),
    ("apparent heading of ego from 5 @ 2", 0),
    ("distance past 0 @ 2", -1),
    ("distance past 5 @ 2 of ego", 4),
    ("(1 @ 2) relative to (3 @ 4)", (4, 6)),
    ("10 deg relative to 20 deg", 30 * DEGREE),
    ("(3 @ 5 relative to ego).position", (-4, 5)),
    ("(ego offset by 3 @ 5).position", (-4, 5)),
    ("(ego offset by 3 @ 5).heading", 90 * DEGREE),
    ("(1 @ 2) offset along 90 deg by 0 @ 3", (-2, 2)),
    ("(front of ego).position", (0.5, 2)),
    ("(back of ego).position", (1.5, 2)),
    ("(left of ego).position", (1, 1.5)),
    ("(front right of ego).position", (0.5, 2.5)),
    ("ego.frontRight.position", (0.5, 2.5)),
    ("ego.x + ego.y", 3),
    ("ego.position.distanceTo(4 @ 6)", 5),
    ("VectorField('f', lambda p: p.x - p.y) at 2 @ 3", -1),
    ("(follow VectorField('east', lambda p: -90 deg) from 3 @ 4 for 10).position", (13, 4)),
    ("(3 @ 4).norm()", 5),
    ("(3 @ 4).normalized()", (0.6, 0.8)),
    ("(3 @ 4).dot(1 @ 2)", 11),
    ("(3 @ 4).rotatedBy(90 deg)", (-4, 3)),
    ("(3 @ 4).offsetRotated(90 deg, 0 @ 1)", (2, 4)),
    ("(3 @ 4).offsetRadially(2, 90 deg)", (1, 4)),
    ("(3 @ 4).angleTo(3 @ 5)", 0),
    ("(3 @ 4)[1]", 4),
    ("90 deg", math.pi / 2),
    ("2 * 45 deg", math.pi / 2),
]


@pytest.mark.parametrize("dialect", [2, 3])
@pytest.mark.parametrize(("text", "expected"), BOTH)
def test_operator(text, expected, dialect):
    np.testing.assert_allclose(param(f"({text})", dialect), expected, atol=1e-8)


def test_degree_of_dialect_2_is_scenic_2s_own():
    assert param("180 deg", 2) == 180 * 0.01745329252
    assert param("180 deg", 3) == math.pi


def test_heading_relative_to_an_object_adds_in_dialect_3_only():
    text = "thing = new Thing at 5 @ 5, facing 10 deg relative to ego"
    np.testing.assert_allclose(one_scene(text, 3).headings[0, 1], 100 * DEGREE)
    with pytest.raises(ScenicError, match="a vector is needed beside an oriented object, not a number"):
        one_scene(text, 2)


SEEN = "ego can see thing.position"  # always, where the scene is
REQUIREMENTS = [
    ("(distance from ego to thing) > 5", lambda x, y, _: np.hypot(x - 1, y - 2) > 5),
    ("thing.x > 3 and not (thing.y > 2 or thing.y < -5)", lambda x, y, _: (x > 3) & ~((y > 2) | (y < -5))),
    ("-2 < thing.x <= 4", lambda x, y, _: (x > -2) & (x <= 4)),
    ("thing.position in RectangularRegion(0 @ 0, 0, 6, 8)", lambda x, y, _: (np.abs(x) <= 3) & (np.abs(y) <= 4)),
    ("thing in RectangularRegion(0 @ 0, 0, 6, 8)", lambda x, y, _: (np.abs(x) <= 2.5) & (np.abs(y) <= 3.5)),
    ("thing not in CircularRegion(0 @ 0, 5)", lambda x, y, _: np.hypot(np.abs(x) + 0.5, np.abs(y) + 0.5) > 5),
    ("(thing.x if thing.y > 0 else -thing.x) > 1", lambda x, y, _: np.where(y > 0, x, -x) > 1),
    ("max(thing.x, thing.y, 1) < 4", lambda x, y, _: np.maximum(np.maximum(x, y), 1) < 4),
    ("abs(thing.x) < 3 or math.sqrt(abs(thing.y)) > 2", lambda x, y, _: (np.abs(x) < 3) | (np.abs(y) > 4)),
    ("all([v > 0 for v in (thing.x, thing.y)])", lambda x, y, _: (x > 0) & (y > 0)),
    ("kind == 'near'", lambda x, y, scenes: scenes.params["kind"] == "near"),
    ("kind in ('far', 'near') and kind != 'far'", lambda x, y, scenes: scenes.params["kind"] == "near"),
    ("nearest(thing) < 4", lambda x, y, _: np.minimum(np.hypot(x, y), np.hypot(x - 1, y - 2)) < 4),
    (SEEN, lambda x, y, _: np.hypot(x - 1, y - 2) <= 50),
]


@pytest.mark.parametrize(("text", "expected"), REQUIREMENTS)
def test_requirement(text, expected):
    program = things(
        "import math\n"
        "kind = Uniform('near', 'far')\nparam kind = kind\n"
        "def nearest(other):\n    return min([distance from other to p for p in (ego, 0 @ 0)])\n"
        "thing = new Thing at Range(-10, 10) @ Range(-10, 10)\n"
        f"require {text}"
    )
    scenes = program.instantiate(np.random.default_rng(0).uniform(-1, 1, (2000, 3)))
    x, y = scenes.positions[:, 1].T
    good = expected(x, y, scenes)
    np.testing.assert_array_equal(scenes.ok, good)
    assert good.all() == (text == SEEN)


def test_view_of_a_sector_meets_rectangles():
    program = things(
        "ego = new Thing at 0 @ 0, facing 0, with visibleDistance 10, with viewAngle 60 deg\n"
        "thing = new Thing at Range(-15, 15) @ Range(-15, 15), facing Range(0, 360) deg, with width 4, with length 2\n"
        "require ego can see thing",
        dialect=3,
    )
    scenes = program.instantiate(np.random.default_rng(0).uniform(-1, 1, (400, 3)))
    grid = np.stack(np.meshgrid(np.linspace(-2, 2, 81), np.linspace(-1, 1, 41)), -1).reshape(-1, 2)
    c, s = np.cos(scenes.headings[:, 1]), np.sin(scenes.headings[:, 1])
    x = scenes.positions[:, 1, 0, None] + grid[:, 0] * c[:, None] - grid[:, 1] * s[:, None]
    y = scenes.positions[:, 1, 1, None] + grid[:, 0] * s[:, None] + grid[:, 1] * c[:, None]
    inside = (np.hypot(x, y) <= 10) & (np.abs(np.arctan2(x, y)) <= np.radians(30))
    share = inside.mean(axis=1)
    np.testing.assert_array_equal(scenes.ok[share > 0], True)  # the grid may miss a corner, never invent one
    assert (scenes.ok & (share == 0)).mean() < 0.01
    assert 0.1 < scenes.ok.mean() < 0.5


def test_function_of_a_random_choice_of_objects():
    program = things(
        "a = new Thing at Range(10, 20) @ 5, with tag 1\n"
        "b = new Thing at Range(30, 40) @ 15, with tag 2\n"
        "who = Uniform(a, b)\n"
        "param x = who.position.x\nparam both = who.y + 100 * who.tag\nparam who = who"
    )
    scenes = program.instantiate(np.random.default_rng(0).uniform(-1, 1, (100, 3)))
    who = np.array(scenes.params["who"], dtype=int)  # as indices of objects
    assert set(who) == {1, 2}
    np.testing.assert_array_equal(scenes.params["x"], scenes.positions[np.arange(100), who, 0])
    np.testing.assert_array_equal(scenes.params["both"], np.where(who == 1, 105, 215))


def test_functions_in_requirements_may_branch_on_random_values():
    program = things(
        "kind = Uniform('near', 'far')\nparam kind = kind\n"
        "def allowed(other):\n"
        "    if kind == 'near':\n"
        "        return (distance from ego to other) < 5\n"
        "    for limit in (6, 8):\n"
        "        if other.x > limit:\n"
        "            return True\n"
        "    return sorted([other.x, other.y])[0] > 0\n"
        "thing = new Thing at Range(-10, 10) @ Range(-10, 10)\n"
        "require allowed(thing)"
    )
    assert program.dim == 3
    scenes = program.instantiate(np.random.default_rng(0).uniform(-1, 1, (500, 3)))
    x, y = scenes.positions[:, 1].T
    far = (x > 6) | (np.minimum(x, y) > 0)
    near = np.hypot(x - 1, y - 2) < 5
    np.testing.assert_array_equal(scenes.ok, np.where(scenes.params["kind"] == "near", near, far))


def test_condition_that_cannot_be_computed_does_not_hold():
    program = things(
        "x = DiscreteRange(0, 1)\ndef f(v):\n    if 1 / v > 0:\n        return True\n    return False\nrequire f(x)"
    )
    np.testing.assert_array_equal(program.valid(np.array([[-0.5], [0.5]])), [False, True])


def test_requirement_means_the_names_of_its_line():
    program = things(
        "x = Range(0, 1)\ndef low(v):\n    if v < 0.5:\n        return True\n    return False\nrequire low(x)\nx = 7"
    )
    np.testing.assert_array_equal(program.valid(np.array([[-0.5], [0.5]])), [True, False])


def test_the_method_distance_to_of_an_object_counts_from_its_outline_in_dialect_3():
    assert param("ego.distanceTo(4 @ 2)", dialect=2) == pytest.approx(3)  # the ego is at (1, 2)
    assert param("ego.distanceTo(4 @ 2)", dialect=3) == pytest.approx(2.5)
    assert param("ego.distanceTo(1.2 @ 2)", dialect=3) == 0
    assert param("ego.position.distanceTo(4 @ 2)", dialect=3) == pytest.approx(3)
