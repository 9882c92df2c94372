"""Starred lists of which a scene or a match decides the length: the machine draws as the reference does."""

import pytest

from tests.scenic_lite.dynamics.compare import differences

SCENE_LISTS = """
behavior B():
    while True:
        take Uniform(*xs), f"{max(*pair)}"
        take Uniform(*xs, "z"), f"{joined(*pair)}"
        take Uniform(*Uniform(*ys), "z")
def joined(a, b):
    return a * 10 + b
xs = Uniform(["p", "q"], ["r"])
ys = Uniform([["p", "q"], ["r"]], [["s"]])
pair = Uniform([1, 2], [3, 4])
ego = new Object at 0 @ 0, with behavior B()
"""
MATCH_LISTS = """
behavior B():
    for i in range(4):
        near = [o for o in (a, b, ego) if o.position.y > i + 1]
        take f"{Uniform(*near).position.x}"
        take Uniform(*near).name
        who = Uniform(*near)
        do Name(who)
behavior Name(o):
    take o.name
ego = new Object at 0 @ 0, with behavior B(), with name "e"
a = new Object at 5 @ 2, with name "a"
b = new Object at 9 @ -1, with name "b"
"""
CHOSEN_BEHAVIORS = """
w = Range(1, 30)
behavior A():
    take "a"
behavior C():
    take "c"
behavior B():
    while True:
        do choose {A(): w, C(): Range(1, 2)}
        do shuffle {A(): w, C(): Range(1, 2)}
        do Uniform(A(), C())
        do Uniform(*which)
which = Uniform([A(), C()], [A()])
ego = new Object at 0 @ 0, with behavior B()
"""
PROGRAMS = {"of the scene": SCENE_LISTS, "of the match": MATCH_LISTS, "of behaviors": CHOSEN_BEHAVIORS}


@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_stars_of_lists(name):
    found, compiled = differences(PROGRAMS[name], range(8), steps=20)
    assert found == []
    assert not compiled.diagnostics


def test_a_choice_among_no_values_rejects_the_match():
    found, compiled = differences(MATCH_LISTS, range(3), steps=20, drift=0.0)
    assert found == []
    assert compiled.rejections == ("a choice among no values",) * len(compiled.rejections) != ()
