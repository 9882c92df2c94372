"""`Program.draws`: a readable name for each column of theta, and `describe`: what a row means."""

import numpy as np
import pytest
from scene import things

NAMES = {
    "x = Range(0, 1)\na = new Thing at x @ Range(1, 2)": ["x", "a.y"],
    "x, y = Range(0, 1), Normal(0, 1)\na = new Thing at x @ y": ["x", "y"],
    "p = Range(0, 1) @ Range(1, 2)\na = new Thing at p": ["p.x", "p.y"],
    "v = [Range(0, i + 1) for i in range(2)]\na = new Thing at v[0] @ v[1]": ["v[0]", "v[1]"],
    "v = {'low': Range(0, 1)}\na = new Thing at v['low'] @ 0": ["v['low']"],
    "for i in range(2):\n    new Thing at i @ Range(0, 1)": ["Thing.y", "Thing_2.y"],
    "def f():\n    d = Range(0, 1)\n    return d\na = new Thing at f() @ f()": ["d", "d_2"],
    "def f(x):\n    return new Thing at x @ Range(0, 1)\na = f(3)": ["a.y"],
    "a = new Thing at 0 @ 0, with width Range(1, 2)": ["a.width"],
    "a = new Thing in RectangularRegion(0 @ 0, 0, 2, 2)": ["a.x", "a.y"],
    "p = Point in RectangularRegion(0 @ 0, 0, 2, 2)\na = new Thing at p": ["p.x", "p.y"],
    "a = new Thing on PolylineRegion([(0, 0), (4, 4)])": ["a.along"],
    "r = CircularRegion(0 @ 0, 2)\na = new Thing in Uniform(r, RectangularRegion(0 @ 0, 0, 2, 2))": [
        "a.position",
        "a.x",
        "a.y",
    ],
    "friend = Uniform(ego, 3 @ 4)\na = new Thing left of friend by 3": ["friend"],
    "param weather = Uniform('sun', 'rain')": ["weather"],
    "param day = Range(0, 1) + 3": ["range5"],
    "behavior B(speed, aim):\n    wait\nr = RectangularRegion(0 @ 0, 0, 2, 2)\n"
    "a = new Thing with behavior B(Range(1, 5), Point on r)": [
        "a.behavior.speed",
        "a.behavior.aim.x",
        "a.behavior.aim.y",
    ],
    "a = new Thing at 1 @ 1\nmutate a": ["a.noise.x", "a.noise.y", "a.noise.heading"],
}


@pytest.mark.parametrize("text", NAMES)
def test_every_column_has_a_name(text):
    program = things(text)
    assert [draw.name for draw in program.draws] == NAMES[text]
    assert set(program.describe(np.zeros(program.dim))) == set(NAMES[text])


MEANINGS = {  # the first draw at θ = 0.5
    "x = Range(0, 4)\nparam p = x": 3.0,
    "param p = DiscreteRange(1, 4)": 4,
    "param p = Uniform('a', 'b', 'c', 'd')": "d",
    "x = Uniform(1 @ 2, 3 @ 4)\na = new Thing at x": "(3 @ 4)",
    "a = new Thing at Range(-5, 5) @ 0\nb = new Thing with friend Uniform(ego, a)": 2.5,
    "b = new Thing with friend Uniform(ego, 3)": "3",
    "r = CircularRegion(0 @ 0, 2)\na = new Thing in Uniform(r, CircularRegion(9 @ 0, 2))": "a region (no. 2 of 2)",
    "a = new Thing in RectangularRegion(3 @ 4, 90 deg, 8, 2)": 2.0,
}


@pytest.mark.parametrize("text", MEANINGS)
def test_a_row_is_described_in_the_units_of_the_program(text):
    program = things(text)
    theta = np.zeros(program.dim)
    theta[0] = 0.5
    theta[1:2] = 1.0
    value = program.describe(theta)[program.draws[0].name]
    assert value == pytest.approx(MEANINGS[text]) if isinstance(value, float) else value == MEANINGS[text]
