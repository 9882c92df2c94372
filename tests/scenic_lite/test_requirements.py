"""Requirements and noise: what conditions see, and when."""

import numpy as np
import pytest

from scenic_lite import ScenicError, load


def drawn(text, dialect=3, n=4000):
    program = load(text, dialect=dialect)
    return program, program.sample(n, np.random.default_rng(5))[1]


NOISY = """ego = new Object at 0 @ 0
b = new Object ahead of ego by 5
require b.y > 5
mutate ego, b by 0.5
c = new Object at b offset by 10 @ 0
param gap = distance from ego to b
"""


def test_noise_comes_after_all_that_is_computed_and_before_all_that_is_checked():
    program, scenes = drawn(NOISY)
    assert scenes.params["gap"] == 6.0
    assert (scenes.positions[:, 2] == (10, 6)).all()  # made after the statement, from b without its noise
    assert scenes.positions[:, 1, 1].min() > 5
    assert scenes.positions[:, 0].std(axis=0) == pytest.approx([0.5, 0.5], rel=0.08)
    assert scenes.headings[:, 0].std() == pytest.approx(0.5 * np.radians(5), rel=0.08)
    assert [draw.name for draw in program.draws] == [
        f"{name}.noise.{axis}" for name in ("ego", "b") for axis in ("x", "y", "heading")
    ]
    assert {draw.kind for draw in program.draws} == {"normal"}


def test_the_spread_belongs_to_the_object_and_to_the_dialect():
    text = "ego = new Object at 0 @ 0, with positionStdDev {}, with headingStdDev 0\nmutate by 0.5\n"
    _, scenes = drawn(text.format("2"), dialect=2)
    assert scenes.positions[:, 0].std(axis=0) == pytest.approx([1.0, 1.0], rel=0.08)
    assert (scenes.headings == 0).all()
    _, scenes = drawn(text.format("(2, 0, 0)"), dialect=3)
    assert scenes.positions[:, 0, 0].std() == pytest.approx(1.0, rel=0.08)
    assert (scenes.positions[:, 0, 1] == 0).all()
    for dialect, spread in ((3, "2"), (2, "(2, 0, 0)")):
        with pytest.raises(ScenicError, match="positionStdDev must be a"):
            load(text.format(spread), dialect=dialect)


def test_mutate_of_none_is_of_all_made_so_far():
    _, scenes = drawn("ego = new Object\nb = new Object at 5 @ 0\nmutate\nc = new Object at 20 @ 0\nmutate b by 0\n")
    assert (scenes.positions.std(axis=0).max(axis=1) > 0.5).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("mutate ego by Range(0, 1)", "needs a fixed number"),
        ("mutate x", "`mutate` needs objects, not a number"),
        ("mutate p", "`mutate` needs objects, not"),
    ],
)
def test_what_cannot_be_mutated(line, message):
    with pytest.raises(ScenicError, match=message) as caught:
        load(f"ego = new Object\nx = 3\np = new Point at 3 @ 3\n{line}\n", dialect=3)
    assert caught.value.line == 4


BRANCHING = """ego = new Object at Range(-1, 1) @ Range(-1, 1)
limit = 0
def fine(thing):
    if thing.x > limit:
        return thing.y > 0
    return True
require fine(ego)
limit = -100
mutate ego by 0.001
"""


@pytest.mark.slow
def test_a_condition_keeps_the_names_of_its_line_also_inside_functions():
    _, scenes = drawn(BRANCHING, n=400)
    x, y = scenes.positions[:, 0].T
    assert ((x <= 0) | (y > 0)).all()
    assert ((x <= 0) & (y < 0)).any()


def test_requirements_in_functions_and_loops_keep_their_locals():
    text = """ego = new Object at Range(0, 4) @ Range(0, 4)
def between(value, low, high):
    for limit, sign in ((low, 1), (high, -1)):
        require value * sign > limit * sign
between(ego.x, 1, 2)
for bound in (1, 2):
    require ego.y > bound
bound = 100
mutate ego by 0.0001
"""
    _, scenes = drawn(text, n=300)
    x, y = scenes.positions[:, 0].T
    assert x.min() > 0.99
    assert x.max() < 2.01
    assert y.min() > 1.99


def test_coordinates_keep_their_names_beneath_the_noise():
    program = load("ego = new Object at Range(0, 1) @ Range(0, 1)\nmutate\n", dialect=3)
    assert [draw.name for draw in program.draws][:2] == ["ego.x", "ego.y"]


SLOW = """def steps(x):
    total = 0
    for i in range(20):
        if x > i:
            total = total + 1
    return {result}
ego = new Object at Range(0, 40) @ Range(-20, 20)
{before}
require steps(ego.x) > 10
{after}
"""
RARE = "require -0.02 < ego.y < 0.02"  # in one draw of 1,000


def branching(before="", after="", result="total"):
    return SLOW.format(before=before, after=after, result=result)


@pytest.mark.long
def test_a_condition_that_branches_is_evaluated_only_where_the_rules_before_it_hold():
    _, scenes = drawn(branching(RARE), n=200)
    assert scenes.ok.all() and scenes.positions[:, 0, 0].min() > 10
    with pytest.raises(ScenicError, match="conditions evaluated scene by scene take more than"):
        drawn(branching(after=RARE), n=200)


@pytest.mark.slow
def test_where_it_stands_among_other_rules_changes_no_scene():
    others = "require ego.y > 10\nrequire[0.5] ego.y > 15"
    before, after = (drawn(branching(**{where: others}), n=50)[1] for where in ("before", "after"))
    assert (before.positions == after.positions).all()
    assert (before.positions[:, 0] > (10, 10)).all()


def test_a_condition_that_branches_fails_where_the_rules_before_it_hold():
    failing = "1 / (total - 20) + 100"
    assert drawn(branching("require ego.x < 15", result=failing), n=50)[1].ok.all()
    with pytest.raises(ScenicError, match="division by zero"):
        drawn(branching("require ego.x > 15", result=failing), n=50)
