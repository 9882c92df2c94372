"""Faults of arithmetic in scenes: sampling raises them at their place, and only where Scenic would come to them."""

import numpy as np
import pytest

from scenic_lite import ScenicError, load

EGO = "ego = new Object with requireVisible False\nx = DiscreteRange(0, 1)\n"
BRANCHING = "def f(a):\n    if a > 0:\n        return 1 / (a - 1)\n    return 1\n"


def sampled(text: str):
    program = load(EGO + text, dialect=3)
    return program, program.sample(64, np.random.default_rng(0))[1]


@pytest.mark.parametrize(
    ("text", "line", "column", "word"),
    [
        ("param y = 1 / x", 3, 10, "division by zero"),
        ("param y = 5 // x", 3, 10, "division"),
        ("def f(a):\n    return 5 % a\nparam y = f(x)", 4, 11, "modulo|division by zero"),
        ("b = new Object at (5 @ 5) / x, with requireVisible False", 3, 18, "division by zero"),
        ("y = x\ny /= x\nparam z = y", 4, 0, "division by zero"),
        ("require 1 / (x - x) > 0", 3, 8, "division by zero"),
        ("y = 1 / x\nrequire x > 0\nrequire y > 0", 3, 4, "division by zero"),
        ("require[0.5] 1 / x > 0", 3, 13, "division by zero"),
        ("import math\nparam y = math.sqrt(x - 0.5)", 4, 10, "math domain error|expected a"),
        ("import math\nparam y = math.log(x, 2)", 4, 10, "math domain error|expected a"),
        ("param y = (x - 0.5) ** 0.5", 3, 10, "not a real number"),
        (BRANCHING + "require f(x) > 0", 5, 15, "division by zero"),
    ],
)
def test_a_fault_in_a_scene_is_raised_at_its_place(text, line, column, word):
    with pytest.raises(ScenicError, match=word) as caught:
        sampled(text)
    assert (caught.value.line, caught.value.place.column) == (line, column)


@pytest.mark.parametrize(
    "text",
    [
        "require x > 0\nrequire 1 / x > 0",
        "require x > 0 and 1 / x > 0",
        "require x == 0 or 1 // x > 0",
        "require (1 / x if x > 0 else 1) > 0",
        "require 0 < x < 3 / x",
        "require x == 0\n" + BRANCHING + "require f(x) > 0",
        "y = 1 / x",
        "b = new Object at 0 @ 2 * x, with requireVisible False\nrequire 1 / x > 0",
        "param y = 2 / (x + 1)",
    ],
)
def test_what_the_program_never_comes_to_is_no_fault(text):
    _, scenes = sampled(text)
    assert scenes.ok.all()


def test_instantiate_only_says_that_such_scenes_are_not_valid():
    program = load(EGO + "param y = 1 / x", dialect=3)
    assert program.valid(np.array([[-1.0], [1.0]])).tolist() == [False, True]


def test_a_requirement_that_cannot_be_computed_is_broken_even_if_it_is_negated():
    program = load(EGO + "require not 1 / x > 5", dialect=3)
    assert program.valid(np.array([[-1.0], [1.0]])).tolist() == [False, True]
