"""Hostile programs: each ends quickly with an error that says which limit was passed, or does no harm."""

import tracemalloc

import numpy as np
import pytest

from scenic_lite import ScenicError, load
from scenic_lite.values import graph

START = "ego = Object at 0 @ 0\n"
TOO_MUCH = [
    ("x = 2**10**10", "an integer of more than 4,096 bits"),
    ("x = 7\nfor i in range(40):\n    x = x * x", "an integer of more than 4,096 bits"),
    ("x = 'a' * 10**10", "a text of 10,000,000,000 characters"),
    ("x = 10**10 * 'a'", "a text of 10,000,000,000 characters"),
    ("x = [0] * 10**10", "a collection of 10,000,000,000 elements"),
    ("x = (0,) * 10**10", "a collection of 10,000,000,000 elements"),
    ("for i in range(10**12):\n    pass", "a collection of 1,000,000,000,000 elements"),
    ("x = range(10**30)", "a range of more elements than can be counted"),
    ("x = [1]\nfor i in range(40):\n    x = x + x", "a collection of 131,072 elements"),
    ("x = [1]\nfor i in range(40):\n    x.extend(x)", "a collection of 131,072 elements"),
    ("x = 'ab'\nfor i in range(40):\n    x = x + x", "a text of 1,048,576 characters"),
    ("d = {'a': 1}\nfor i in range(45):\n    d = {'a': d, 'b': d}\nx = f'{d}'", "more than 100,000 elements in all"),
    ("x = [list(range(10**5)) for i in range(10**5)]", "more than 10,000,000 elements and characters"),
    ("x = f'{3:1000000000}'", "a text format wider than 999"),
    ("while True:\n    pass", "more than 200,000 steps"),
    ("x = sum([i for i in range(10**4) for j in range(10**4)])", "more than 200,000 steps"),
    ("def f(n):\n    return f(n + 1)\nf(0)", "functions call each other more than 40 deep"),
    ("f = lambda: f()\nf()", "functions call each other more than 40 deep"),
    ("for i in range(10**4):\n    Object at 3 * i @ 9", "more than 400 objects"),
    ("x = [Range(0, 1) for i in range(10**4)]", "more than 2,000 random values"),
    ("x = Range(0, 1)\nfor i in range(15000):\n    x = x * 1.5 + 1\nparam x = x", "more than 20,000 random operations"),
    ("x = []\nx.append(x)\nparam x = x", "the parameter 'x' has more than 20,000 parts, or holds itself"),
    (
        "x = [1]\nfor i in range(60):\n    x = [x, x]\nparam x = x",
        "the parameter 'x' has more than 20,000 parts",
    ),
    ("x = " + "(" * 500 + "1" + ")" * 500, "nested more than"),
    ("x = " + "-" * 5000 + "1", "nested too deeply"),
]
OUT_OF_REACH = [
    "x = ().__class__",
    "x = (1 @ 2).__class__",
    "x = ego.__dict__",
    "x = ego.cls",
    "x = Object.lineage",
    "x = (lambda: 1).__globals__",
    "x = (lambda: 1).frame",
    "x = math.__loader__",
    "x = Range(0, 1).operation",
    "x = right.__init__",
    "x = '{0.__class__}'.format(1)",
    "x = open('/etc/passwd')",
    "x = eval('1')",
    "x = exec('1')",
    "x = __import__('os')",
    "x = getattr(ego, 'cls')",
    "x = globals()",
    "x = vars(ego)",
    "import os",
    "import sys",
    "from subprocess import run",
    "from .. import secrets",
    "import pdb\npdb.set_trace()",
    "x = everywhere.orientation.name",
    "x = RectangularRegion(0 @ 0, 0, 1, 1).fixed",
    "x = f'{ego.__class__}'",
    "x = [1].__add__([2])",
    "x = globalParameters.__class__",
]


@pytest.mark.slow
@pytest.mark.parametrize(("text", "message"), TOO_MUCH)
def test_budget(text, message):
    with pytest.raises(ScenicError) as caught:
        load(START + text)
    assert message in caught.value.message
    assert caught.value.place is not None
    assert len(str(caught.value)) < 20_000


@pytest.mark.parametrize("text", OUT_OF_REACH)
def test_python_is_out_of_reach(text):
    with pytest.raises(ScenicError) as caught:
        load(START + text)
    assert caught.value.kind in ("name", "import", "type", "syntax", "unsupported")


def test_sampling_ends():
    program = load("ego = Object at Range(0, 1) @ 0\nrequire ego.x < 1e-9")
    with pytest.raises(ScenicError) as caught:
        program.sample(10, np.random.default_rng(0))
    assert caught.value.kind == "rejection"


@pytest.mark.parametrize(
    "use",
    [
        "x == y",
        "x < y",
        "x in [y]",
        "sorted([x, y])",
        "{x: 1}",
        "{}.get(x)",
        "[y].index(x)",
        "{}[x]",
    ],
)
def test_shared_parts_are_counted_each_time_before_they_are_compared_or_hashed(use):
    text = f"x, y = (1,), (1,)\nfor i in range(60):\n    x, y = (x, x), (y, y)\nz = {use}\n"
    with pytest.raises(ScenicError, match="evaluation budget exceeded"):
        load(text)


@pytest.mark.parametrize("use", ["b = new Object with behavior B(a)", "param b = Uniform(a, 3)"])
def test_endless_arguments_and_options_are_refused(use):
    text = (
        "ego = new Object at 9 @ 9\nbehavior B(x):\n    take x\na = (1, Range(0, 1))\n"
        f"for i in range(60):\n    a = (a, a)\n{use}\n"
    )
    with pytest.raises(ScenicError, match="has more than 20,000 parts, or holds itself") as caught:
        load(text)
    assert caught.value.line == 7


BRANCHING = """
x = Range(0, 1)
ego = new Object at x @ 0
def f(v):
    total = 0
    for i in range(800):
        if v > i:
            total += i
    return total
require f(x) > 1000
"""


@pytest.mark.long
def test_conditions_decided_scene_by_scene_share_one_budget():
    with pytest.raises(ScenicError) as caught:
        load(BRANCHING).sample(1, np.random.default_rng(0))
    assert caught.value.kind == "budget" and caught.value.line == 10
    assert "take more than 2,000,000 steps in all scenes" in caught.value.message


def test_what_fails_in_a_scene_is_raised_by_sampling_with_its_line():
    program = load(
        "x = Range(0, 1)\nego = new Object at x @ 0\n"
        "def f(v):\n    if v > 0.5:\n        return [1, 2][5]\n    return 3\nrequire f(x) > 2\n"
    )
    assert program.valid(np.array([[-0.5], [0.5]])).tolist() == [True, False]
    with pytest.raises(ScenicError, match="list index out of range") as caught:
        program.sample(50, np.random.default_rng(0))
    assert caught.value.line == 5


def test_a_text_that_would_take_long_to_read():
    with pytest.raises(ScenicError, match="the program is longer than 200,000 characters"):
        load("x = 1\n" * 40_000)


CHAIN = "x = Range(0, 1)\ny = x\nfor i in range(9000):\n    y = y * 1.0001 + 0.5\nego = new Object at y @ 0"


@pytest.mark.slow
def test_many_operations_on_one_draw_need_little_memory():
    program = load(CHAIN, dialect=3)
    theta = np.zeros((4096, 1))
    tracemalloc.start()
    program.instantiate(theta)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(program.tape.steps) == 18_000
    assert peak < 20e6  # all results at once would be 590 MB


@pytest.mark.slow
def test_what_no_memory_holds_is_refused(monkeypatch):
    monkeypatch.setattr(graph, "MOST_NUMBERS", 10_000)
    program = load(CHAIN, dialect=3)
    program.instantiate(np.zeros((1000, 1)))
    with pytest.raises(ScenicError, match="5,000 scenes at once, of 3 random values each; ask for fewer at a time"):
        program.instantiate(np.zeros((5000, 1)))
