"""What sets a property when several could: priorities, final properties, defaults; spec section 4."""

import numpy as np
import pytest
from scene import one_scene, things

from scenic_lite import ScenicError, load


@pytest.mark.parametrize(
    ("text", "message", "line"),
    [
        ("class C:\n    foo[final]: 1\nego = new C with foo 2\n", "'foo' is final", 3),
        ("class C:\n    foo[final]: 1\nclass D(C):\n    foo: 2\nego = new D\n", "'foo' of C is final", 3),
        ("class C:\n    foo: self\nego = new C\n", "never the bare `self`", 2),
        ("ego = new Object facing 1, with yaw 2\n", "both set the yaw", 1),
        ("ego = new Object with front 3\n", "'front' is the place at a side", 1),
        ("ego = new Object\np = new Point at 3 @ 3, facing 1\n", "a Point has no heading for `facing`", 2),
    ],
)
def test_what_cannot_be_specified(text, message, line):
    with pytest.raises(ScenicError, match=message) as caught:
        load(text, dialect=3)
    assert caught.value.line == line


def test_switches_are_on_or_off_whatever_they_are_written_as():
    text = "ego = new Object with allowCollisions 0\n"
    text += "b = new Object at {}, with allowCollisions {}, with requireVisible {}\n"
    for place, collisions, visible in (("0 @ 0", "1", "1"), ("99 @ 0", "0", "0")):
        load(text.format(place, collisions, visible), dialect=3)
    for place, collisions, visible in (("0 @ 0", "0", "1"), ("99 @ 0", "0", "1")):
        with pytest.raises(ScenicError, match="in every scene"):
            load(text.format(place, collisions, visible), dialect=3)


def test_on_a_point_and_on_an_object():
    scenes = one_scene("a = new Thing on 3 @ 4\n", dialect=3)
    assert scenes.positions[0, 1].tolist() == [3, 4]
    program = things("b = new Thing on ego\n", dialect=3)
    scenes = program.sample(500, np.random.default_rng(2))[1]
    assert np.abs(scenes.positions[:, 1] - [1, 2]).max() <= 0.5
    with pytest.raises(ScenicError, match="`on` needs a region"):
        one_scene("a = new Thing on 3 @ 4\n", dialect=2)


def test_a_random_place_has_a_frame_in_dialect_3_and_is_a_vector_in_dialect_2():
    text = "spot = Uniform(new OrientedPoint at 10 @ 0, facing 90 deg)\na = new Thing at spot offset by 0 @ 5\n"
    text = text.replace("Uniform(", "Uniform(new OrientedPoint at 10 @ 0, facing 90 deg, ")
    for dialect, place in ((3, [5, 0]), (2, [10, 5])):
        source = text if dialect == 3 else text.replace("Uniform(new", "Uniform((new").replace("deg, new", "deg), (new")
        source = source if dialect == 3 else source.replace("90 deg)\na", "90 deg))\na")
        np.testing.assert_allclose(one_scene(source, dialect).positions[0, 1], place, atol=1e-6)
