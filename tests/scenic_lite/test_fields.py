"""Vector fields: their headings, branching functions, cells, and following them; numbers are from real Scenic 3."""

import math

import numpy as np
import pytest

from scenic_lite import ScenicError, load
from tests.scenic_lite.scene import param, things

BRANCHING = """
def turn(p):
    if p.x > 0:
        return 0.5
    if p.y > 0:
        return p.y * 0.1
    return -0.2
f = VectorField("f", turn)
"""
LOOPING = """
def turn(p):
    total = 0
    while total < p.x:
        total += 1
    return total * 0.1
f = VectorField("f", turn)
"""
CELLS = "[(RectangularRegion(-5@0, 0, 10, 20), 1), (RectangularRegion(5@0, 0, 10, 20), None)]"


def headings(text, n=400):
    _, scenes = things(text, 3).sample(n, np.random.default_rng(1))
    x, y = scenes.positions[:, 1].T
    return x, y, scenes.headings[:, 1]


def test_functions_that_branch():
    x, y, heading = headings(BRANCHING + "spot = new Thing in RectangularRegion(0@0, 0, 9, 9), facing f")
    np.testing.assert_allclose(heading, np.where(x > 0, 0.5, np.where(y > 0, y * 0.1, -0.2)))


def test_functions_that_loop_over_the_point_are_refused():
    with pytest.raises(ScenicError, match=r":8:\d+: a field's function decides on its point more than 8 times"):
        things(LOOPING + "spot = new Thing in RectangularRegion(0@0, 0, 9, 9), facing f", 3)


def test_a_function_that_gives_no_heading():
    with pytest.raises(ScenicError, match="a number is needed here"):
        things("f = VectorField('f', lambda p: 'north')\nspot = new Thing in CircularRegion(0@0, 3), facing f", 3)


def test_headings_are_angles_in_dialect_3():
    assert param("VectorField('f', lambda p: 4)[1 @ 1]", 3) == pytest.approx(4 - 2 * math.pi)
    assert param("VectorField('f', lambda p: 4)[1 @ 1]", 2) == 4


def test_cells():
    field = f"f = PolygonalVectorField('F', {CELLS}, headingFunction=lambda p: p.x * 0.1)\n"
    x, _, heading = headings(field + "spot = new Thing in RectangularRegion(0@0, 0, 18, 18), facing f")
    np.testing.assert_allclose(heading, np.where(x <= 0, 1.0, x * 0.1))


def test_outside_all_cells():
    field = "PolygonalVectorField('F', [(RectangularRegion(-5@0, 0, 10, 20), 1)]"
    spot = "\nspot = new Thing in RectangularRegion(0@0, 0, 18, 18), facing f"
    x, _, heading = headings(f"f = {field}, defaultHeading=0.25){spot}")
    np.testing.assert_allclose(heading, np.where(x <= 0, 1.0, 0.25))
    x, _, _ = headings(f"f = {field}){spot}")
    assert (x <= 0).all()
    with pytest.raises(ScenicError, match="has no heading at"):
        param(f"{field})[1 @ 1]", 3)


@pytest.mark.parametrize(
    ("expression", "steps"),
    [("12", 4), ("12, steps=5", 5), ("12, stepSize=1", 12), ("30", 6)],
)
def test_following(expression, steps):
    """Equal Euler steps: at least four, none longer than five."""
    x, y, length = 2.0, 3.0, (30 if expression == "30" else 12) / steps
    for _ in range(steps):
        x, y = x - length * math.sin(y * 0.05), y + length * math.cos(y * 0.05)
    end = f"VectorField('f', lambda p: p.y * 0.05).followFrom(2 @ 3, {expression})"
    assert param(f"{end}.x", 3) == pytest.approx(x) and param(f"{end}.y", 3) == pytest.approx(y)


def test_following_for_a_random_distance():
    """As many steps as each scene needs."""
    text = BRANCHING + "d = Range(3, 40)\nspot = new Thing following f from (-3 @ -9) for d\nparam d = d"
    _, scenes = things(text, 3).sample(50, np.random.default_rng(1))
    for distance, place in zip(scenes.params["d"], scenes.positions[:, 1], strict=True):
        x, y, steps = -3.0, -9.0, max(4, math.ceil(distance / 5))
        for _ in range(steps):
            turn = 0.5 if x > 0 else y * 0.1 if y > 0 else -0.2
            x, y = x - distance / steps * math.sin(turn), y + distance / steps * math.cos(turn)
        np.testing.assert_allclose(place, (x, y))


def test_unions_keep_each_orientation():
    text = (
        "a = PolygonalRegion([0@0, 6@0, 6@6, 0@6], orientation=VectorField('f', lambda p: 0.5))\n"
        "b = PolygonalRegion([3@3, 10@3, 10@10, 3@10], orientation=VectorField('g', lambda p: -0.7))\n"
        "spot = new Thing in a.union(b)"
    )
    x, y, heading = headings(text)
    np.testing.assert_allclose(heading, np.where((x <= 6) & (y <= 6), 0.5, -0.7))


def test_a_default_from_a_field():
    text = "class Car(Thing):\n    heading: f at self.position\nspot = new Car in CircularRegion(0@0, 4)"
    x, _, heading = headings("f = VectorField('f', lambda p: p.x * 0.1)\n" + text)
    np.testing.assert_allclose(heading, x * 0.1)


def test_a_field_may_depend_on_a_draw():
    text = "k = Range(0, 1)\nf = VectorField('f', lambda p: k if p.x > 0 else 2)\nparam k = k\n"
    program = things(text + "spot = new Thing in CircularRegion(0@0, 4), facing f", 3)
    _, scenes = program.sample(200, np.random.default_rng(1))
    expected = np.where(scenes.positions[:, 1, 0] > 0, scenes.params["k"], 2.0)
    np.testing.assert_allclose(scenes.headings[:, 1], expected)


def test_steps_are_bounded():
    with pytest.raises(ScenicError, match="1 to 1000 steps"):
        load("f = VectorField('f', lambda p: 0, minSteps=0)\nego = new Object at 0@0", dialect=3)


def test_a_field_is_followed_from_a_vector_without_an_ego():
    text = "up = VectorField('up', lambda p: 0)\nparam end = (follow up from 1 @ 2 for 5).position\n"
    program = load(text + "new Object at 9 @ 9, with requireVisible False", dialect=3)
    assert program.params["end"] == pytest.approx((1, 7))
