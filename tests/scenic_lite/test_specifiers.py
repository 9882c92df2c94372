"""Every specifier against numbers worked out by hand, in both dialects. The ego is at (1, 2), heading 90 degrees."""

import math

import numpy as np
import pytest
from scene import one_scene, things

from scenic_lite import ScenicError

R2 = math.sqrt(2)
# specifiers -> x, y, heading in degrees; an object is 1 x 1.
BOTH = [
    ("at 3 @ 4", (3, 4, 0)),
    ("at (3, 4)", (3, 4, 0)),
    ("at ego", (1, 2, 0)),
    ("at 3 @ 4, facing 30 deg", (3, 4, 30)),
    ("facing -90 deg, at 3 @ 4", (3, 4, -90)),
    ("at 3 @ 4, with heading 30 deg", (3, 4, 30)),
    ("at 1 @ 5, facing toward 1 @ 9", (1, 5, 0)),
    ("at 1 @ 5, facing toward ego", (1, 5, 180)),
    ("at 3 @ 2, facing toward 2 @ 3", (3, 2, 45)),
    ("at 3 @ 2, facing away from 2 @ 3", (3, 2, -135)),
    ("at 3 @ 4, facing directly toward 3 @ 5", (3, 4, 0)),
    ("offset along 0 by 3 @ 5", (4, 7, 90, 0)),
    ("offset by 3 @ 5", (-4, 5, 90, 0)),
    ("left of 5 @ 5 by 2", (2.5, 5, 0)),
    ("right of 5 @ 5 by 2", (7.5, 5, 0)),
    ("ahead of 5 @ 5 by 2", (5, 7.5, 0)),
    ("behind 5 @ 5 by 2", (5, 2.5, 0)),
    ("behind 5 @ 5", (5, 4.5, 0)),
    ("ahead of 5 @ 5 by 2, with length 4", (5, 9, 0)),
    ("left of 5 @ 5 by 2, with width 4", (1, 5, 0)),
    ("ahead of 5 @ 5 by 2, facing 90 deg", (2.5, 5, 90)),
    ("left of 5 @ 5 by 2 @ 3", (2.5, 8, 0)),
    ("beyond 1 @ 12 by 3", (1, 15, 0)),
    ("beyond 11 @ 2 by 3", (14, 2, 0)),
    ("beyond 11 @ 2 by 1 @ 3", (14, 1, 0)),
    ("beyond 0 @ 0 by 5 from 3 @ 4", (-3, -4, 0)),
    ("ahead of (OrientedPoint at 5 @ 5, facing 45 deg) by 2", (5 - 2.5 / R2, 5 + 2.5 / R2, 45)),
    ("at 1 @ 12, apparently facing 10 deg", (1, 12, 10)),
    ("at 11 @ 2, apparently facing 10 deg from 1 @ 2", (11, 2, -80)),
    ("following VectorField('east', lambda p: -90 deg) from 3 @ 4 for 10", (13, 4, -90)),
    ("facing VectorField('east', lambda p: -90 deg), at 3 @ 4", (3, 4, -90)),
    ("facing VectorField('turn', lambda p: p.x), at 0.5 @ 4", (0.5, 4, math.degrees(0.5))),
    ("at 3 @ 4, facing 30 deg relative to VectorField('east', lambda p: -90 deg)", (3, 4, -60)),
]
# specifiers -> the same in dialect 2 and in dialect 3
DIFFERENT = [
    ("ahead of ego by 2", (-1.5, 2, 90), (-2, 2, 90)),
    ("behind ego by 2", (3.5, 2, 90), (4, 2, 90)),
    ("left of ego by 2", (1, -0.5, 90), (1, -1, 90)),
    ("right of ego by 2", (1, 4.5, 90), (1, 5, 90)),
    ("ahead of ego by 1 @ 4", (-3.5, 3, 90), (-4, 3, 90)),
    ("left of ego by 6 @ -2", (3, -4.5, 90), (3, -5, 90)),
    ("at 3 @ 4, facing 405 deg", (3, 4, 405), (3, 4, 45)),
    ("ahead of ego by 2, apparently facing 0 deg", (-1.5, 2, 90), (-2, 2, 180)),
]


def check(text, dialect, expected):
    scenes = one_scene(f"thing = new Thing {text}", dialect)
    x, y, heading, *other = expected
    if other and dialect == 2:  # dialect 3 takes the heading over, dialect 2 does not
        heading = other[0]
    np.testing.assert_allclose(scenes.positions[0, 1], [x, y], atol=1e-9)
    gap = np.degrees(scenes.headings[0, 1]) - heading
    assert abs(gap) < 1e-6 or (abs(heading) == 180 and abs(abs(gap) - 360) < 1e-6)


@pytest.mark.parametrize("dialect", [2, 3])
@pytest.mark.parametrize(("text", "expected"), BOTH)
def test_specifier(text, expected, dialect):
    check(text, dialect, expected)


@pytest.mark.parametrize(("text", "second", "third"), DIFFERENT)
def test_specifier_that_differs_between_dialects(text, second, third):
    check(text, 2, second)
    check(text, 3, third)


def test_random_reference_is_a_vector_in_dialect_2_and_an_object_in_dialect_3():
    text = "a = new Thing at 3 @ 4, facing 90 deg\nb = new Thing ahead of Uniform(ego, a) by 2"
    np.testing.assert_allclose(one_scene(text, 2, 0.9).positions[0, 2], [3, 6.5])
    np.testing.assert_allclose(one_scene(text, 3, 0.9).positions[0, 2], [0, 4], atol=1e-9)


def test_specifiers_in_any_order():
    text = "thing = new Thing facing toward 5 @ 9, left of ego by 5, with width 2"
    scenes = one_scene(text)
    np.testing.assert_allclose(scenes.positions[0, 1], [1, -4])


def test_properties_may_need_each_other():
    text = "class Box(Thing):\n    width: 2 * self.length\n    length: 3\nbox = new Box with length 5"
    assert one_scene(text).properties["width"] == [1.0, 10]


def test_random_defaults_are_drawn_for_each_object():
    program = things("class Box(Thing):\n    width: Range(1, 2)\na = new Box\nb = new Box")
    assert [draw.name for draw in program.draws] == ["a.width", "b.width"]


def test_additive_properties_collect_those_of_the_bases():
    text = "class A(Thing):\n    tag[additive]: 1\nclass B(A):\n    tag[additive]: 2\nb = new B"
    assert one_scene(text).properties["tag"][1] == (2, 1)


def test_contained_in_sets_the_container():
    program = things("yard = RectangularRegion(0 @ 0, 0, 2, 2)\nthing = new Thing contained in yard", 3)
    _, scenes = program.sample(200, np.random.default_rng(0))
    assert (np.abs(scenes.positions[:, 1]) <= 0.5).all()


def test_visible_lies_in_the_view_of_the_ego():
    ego = "ego = new Thing at 1 @ 2, facing 90 deg, with visibleDistance 4, with viewAngle 60 deg\n"
    _, scenes = things(f"{ego}thing = new Thing visible").sample(500, np.random.default_rng(0))
    offset = scenes.positions[:, 1] - [1, 2]
    assert (np.hypot(*offset.T) <= 4).all()
    assert (np.abs(np.arctan2(offset[:, 1], -offset[:, 0])) <= np.radians(30) + 1e-9).all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("at 5", "`at` needs a vector, not a number"),
        ("in 3 @ 4", "`in` needs a region, not a vector"),
        ("ahead of 3 by 2", "`ahead of` needs a vector, not a number"),
        ("at 1 @ 2, at 3 @ 4", "`at` is given twice"),
        ("at 1 @ 2, in everywhere", "a point cannot be drawn from everywhere"),
        ("at 1 @ 2, ahead of ego", "`at` and `ahead of` both set the position"),
        ("with width 2, with width 3", "`with width` is given twice"),
        ("left of 3 @ 4 by 2, facing toward 5 @ 5", "`left of` depends on itself"),
        ("facing 3 @ 4", "`facing` needs a heading, not a vector"),
        ("with width 'wide'", "width must be a number, not a text"),
        ("above ego by 3", "`above` is not supported in two dimensions"),
    ],
)
def test_wrong_specifier(text, message):
    with pytest.raises(ScenicError) as caught:
        one_scene(f"thing = new Thing {text}")
    assert caught.value.message == message
    assert caught.value.line == 5


ORIENTATIONS = [  # specifiers, heading, yaw and the parent's heading in degrees
    ("with parentOrientation 30 deg", 30, 0, 30),
    ("with parentOrientation (30 deg, 0, 0)", 30, 0, 30),
    ("with parentOrientation ego, with yaw 10 deg", 100, 10, 90),
    ("with parentOrientation 30 deg, facing 10 deg", 10, -20, 30),
    ("facing (30 deg, 0, 0), with pitch 0", 30, 30, 0),
    ("left of ego by 2, with parentOrientation 30 deg", 30, 0, 30),
    ("left of ego by 2, facing 10 deg", 10, -80, 90),
]


@pytest.mark.parametrize(("text", "heading", "yaw", "parent"), ORIENTATIONS)
def test_orientations_of_dialect_3_are_yaws(text, heading, yaw, parent):
    params = "param angles = (a.heading, a.yaw, a.parentOrientation, a.orientation.yaw, a.pitch, a.heading.roll)"
    program = things(f"a = new Thing {text}\n{params}", 3)
    np.testing.assert_allclose(np.degrees(program.params["angles"]), [heading, yaw, parent, heading, 0, 0], atol=1e-9)


@pytest.mark.parametrize("text", ["with orientation 30 deg", "with pitch 1", "with roll Range(0, 1)"])
def test_orientations_that_the_plane_has_not_are_refused(text):
    with pytest.raises(ScenicError, match="in two dimensions no specifier or class sets the"):
        things(f"a = new Thing {text}", 3)


@pytest.mark.parametrize("text", ["facing (1, 2, 0)", "with parentOrientation (0, 0, 1)"])
def test_an_orientation_is_a_yaw_alone(text):
    with pytest.raises(ScenicError, match=r"an orientation in two dimensions is \(yaw, 0, 0\)"):
        things(f"a = new Thing {text}", 3)
