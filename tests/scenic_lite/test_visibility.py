"""What is seen: by the ego, by `can see`, by the specifiers `visible` and `not visible`; in both dialects."""

import numpy as np
import pytest
from scene import one_scene

from scenic_lite import ScenicError, load

EGO = "ego = new Object at 0 @ 0, with visibleDistance 10, with viewAngle 40 deg\n"


def is_valid(text, dialect):
    program = load(text, dialect=dialect)
    return bool(program.valid(np.zeros((1, program.dim)))[0])


def test_dialect_2_looks_at_corners_dialect_3_at_the_whole_rectangle():
    wall = EGO + "x = Range(4, 6)\nwall = new Object at 0 @ x, with width 30, with length 1\n"
    assert is_valid(wall, 3)  # the view ends in the middle of the wall
    assert not is_valid(wall, 2)
    corner = EGO + "x = Range(4, 6)\nbox = new Object at 0 @ x\n"
    assert is_valid(corner, 3)
    assert is_valid(corner, 2)


def test_can_see_at_the_top_level_belongs_to_dialect_2():
    text = EGO + "param seen = ego can see 0 @ 5, behind_it = ego can see 0 @ -5\n"
    assert load(text.replace(", behind_it", "\nparam behind_it"), dialect=2).params == {
        "seen": True,
        "behind_it": False,
    }
    with pytest.raises(ScenicError, match="meant for requirements"):
        load(text, dialect=3)
    with pytest.raises(ScenicError, match="differs from scene to scene"):
        load(EGO + "x = ego can see 0 @ Range(0, 5)\n", dialect=2)


def test_visible_is_a_demand_of_dialect_3_wherever_the_object_is_put():
    place = EGO + "x = Range(-6, -4)\nb = new Object at 0 @ x, with requireVisible False, {}\n"
    assert not is_valid(place.format("visible"), 3)
    assert is_valid(place.format("not visible"), 3)
    with pytest.raises(ScenicError, match="both set the position"):
        load(place.format("visible"), dialect=2)


def test_not_visible_hides_the_whole_object_in_dialect_3():
    text = "workspace = Workspace(RectangularRegion(0 @ 0, 0, 40, 40))\n" + EGO.replace("40 deg", "360 deg")
    text += "b = new Object not visible, with requireVisible False, with width 6, with length 6\n"
    for dialect in (2, 3):
        program = load(text, dialect=dialect)
        scenes = program.sample(500, np.random.default_rng(1))[1]
        distance = np.hypot(*scenes.positions[:, 1].T)
        assert (distance.min() > 12.9) == (dialect == 3)
        assert distance.min() > 10


def test_beyond_looks_north_in_both_dialects():
    for dialect in (2, 3):
        scenes = one_scene("b = new Thing beyond 1 @ 12 by 3\n", dialect)
        assert scenes.headings[0, 1] == 0


def test_a_random_object_is_seen_as_the_object_it_is():
    text = EGO + "a = new Object at Range(2, 7) @ 5, with width 4, with requireVisible False\n"
    text += "b = new Object at 0 @ -5, with requireVisible False\nc = Uniform(a, a, b)\nparam x = c.x\n"
    for dialect in (2, 3):
        program = load(text + "require ego can see c\n", dialect=dialect)
        scenes = program.sample(300, np.random.default_rng(1))[1]
        np.testing.assert_array_equal(scenes.params["x"], scenes.positions[:, 1, 0])
        assert scenes.params["x"].max() > 2.5  # only a corner of it is in the view
        assert load(text + "require c can see ego\n", dialect=dialect).report(100, np.random.default_rng(2)).accepted
