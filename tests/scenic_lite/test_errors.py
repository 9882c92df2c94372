"""Every error of the static half, verbatim: the message, the place underlined, the hint."""

import textwrap
from pathlib import Path

import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from scenic_lite import ScenicError, load

# Each case: a program, and what is printed. The carets say which column is meant.
CASES = {
    "branch on a random value": (
        """
        ego = LeftCM at 0 @ 0
        x = Range(0, 1)
        y = 3 if x > 0.5 else 4
        """,
        """
        <program>:3:10: random values cannot be compared here (write it in `require`, or decide in a behavior)
            y = 3 if x > 0.5 else 4
                     ^^^^^^^
        <program>:2:5: the random value is drawn here
            x = Range(0, 1)
                ^^^^^^^^^^^
        """,
    ),
    "while on a random value": (
        """
        n = DiscreteRange(1, 4)
        while n:
            pass
        """,
        """
        <program>:2:7: control flow cannot depend on a random value (write it in `require`, or decide in a behavior)
            while n:
                  ^
        <program>:1:5: the random value is drawn here
            n = DiscreteRange(1, 4)
                ^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "iteration over a random value": (
        """
        for p in Uniform([1], [2, 3]):
            pass
        """,
        """
        <program>:1:10: cannot iterate through a random value (write it in `require`, or decide in a behavior)
            for p in Uniform([1], [2, 3]):
                     ^^^^^^^^^^^^^^^^^^^^
        <program>:1:10: the random value is drawn here
            for p in Uniform([1], [2, 3]):
                     ^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "range with random ends": (
        """
        n = DiscreteRange(1, 4)
        for i in range(n):
            pass
        """,
        """
        <program>:2:10: a range cannot have random ends (write it in `require`, or decide in a behavior)
            for i in range(n):
                     ^^^^^^^^
        <program>:1:5: the random value is drawn here
            n = DiscreteRange(1, 4)
                ^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "draw inside a requirement": (
        """
        ego = LeftCM at 0 @ 0
        require Range(0, 1) > 0.5
        """,
        """
        <program>:2:9: a requirement cannot draw a random value (draw it before the requirement and give it a name)
            require Range(0, 1) > 0.5
                    ^^^^^^^^^^^
        """,
    ),
    "unknown class": (
        "ego = LeftCN at 0 @ 0",
        """
        <program>:1:7: name 'LeftCN' is not defined (did you mean 'LeftCM'?)
            ego = LeftCN at 0 @ 0
                  ^^^^^^
        """,
    ),
    "unknown region": (
        "ego = LeftCM on right_penalty_box",
        """
        <program>:1:17: name 'right_penalty_box' is not defined (did you mean 'right_penaltyBox'?)
            ego = LeftCM on right_penalty_box
                            ^^^^^^^^^^^^^^^^^
        """,
    ),
    "unknown property": (
        """
        ego = LeftCM at 0 @ 0
        require ego.positon.x > 3
        """,
        """
        <program>:2:9: LeftCM has no property 'positon' (did you mean 'position'?)
            require ego.positon.x > 3
                    ^^^^^^^^^^^
        """,
    ),
    "unknown method": (
        """
        ego = LeftCM at 0 @ 0
        param inside = right_penaltyBox.containspoint(3 @ 4)
        """,
        """
        <program>:2:16: a region has no attribute 'containspoint' (did you mean 'containsPoint'?)
            param inside = right_penaltyBox.containspoint(3 @ 4)
                           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "unknown module": (
        "model football.modle",
        """
        <program>:1:1: there is no module 'football.modle' (did you mean 'football.model'?)
            model football.modle
            ^^^^^^^^^^^^^^^^^^^^
            modules that exist: football.model, football.actions, football.behaviors, football.simulator, football.constants, football, math, random
        """,  # noqa: E501
    ),
    "unknown name of a module": (
        "from football.model import LeftGC",
        """
        <program>:1:1: football.model has no 'LeftGC' (did you mean 'LeftGK'?)
            from football.model import LeftGC
            ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "vector expected": (
        "ego = LeftCM at 5",
        """
        <program>:1:14: `at` needs a vector, not a number (a vector is written x @ y)
            ego = LeftCM at 5
                         ^^^^
        """,
    ),
    "region where a vector is expected": (
        "ego = LeftCM at right_penaltyBox",
        """
        <program>:1:14: `at` needs a vector, not a region (a point of a region is written `in region`)
            ego = LeftCM at right_penaltyBox
                         ^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "@ binds tightly": (
        "ego = LeftCM at 1 + 2 @ 3",
        """
        <program>:1:17: `+` of a number and a vector (`@` binds as tightly as `*`: write (x + y) @ z)
            ego = LeftCM at 1 + 2 @ 3
                            ^^^^^^^^^
        """,
    ),
    "no ego yet": (
        "LeftCM ahead of ego by 2",
        """
        <program>:1:17: there is no ego yet (write ego = ... before this line)
            LeftCM ahead of ego by 2
                            ^^^
        """,
    ),
    "no ego at all": (
        "LeftCM",
        """
        <program>:1:1: the program sets no ego (write ego = ... before one of its objects)
            LeftCM
            ^^^^^^
        """,
    ),
    "an operand that is None": (
        "nobody = None\nego = LeftCM at 0 @ 0\nx = distance from nobody to ego",
        """
        <program>:3:5: None is not an object, a number or a vector
            x = distance from nobody to ego
                ^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "an operand of a specifier that is None": (
        "nobody = None\nego = LeftCM at 0 @ 0\nLeftCB left of ego by nobody",
        """
        <program>:3:8: None is not an object, a number or a vector
            LeftCB left of ego by nobody
                   ^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "ego that is no object": (
        "ego = 5",
        """
        <program>:1:1: ego must be an object, not a number
            ego = 5
            ^^^
        """,
    ),
    "workspace that is no region": (
        "workspace = 5",
        """
        <program>:1:1: the workspace must be a region, not a number (write workspace = Workspace(region))
            workspace = 5
            ^^^^^^^^^
        """,
    ),
    "fixed objects that overlap": (
        """
        ego = LeftCM at 0 @ 0
        Ball at 0 @ 0.5
        """,
        """
        <program>:2:1: Ball overlaps ego in every scene (ego is at (0 @ 0), Ball is at (0 @ 0.5))
            Ball at 0 @ 0.5
            ^^^^^^^^^^^^^^^
        """,
    ),
    "fixed object off the pitch": (
        "ego = LeftCM at 100 @ 0",
        """
        <program>:1:7: ego leaves the workspace in every scene (ego is at (100 @ 0))
            ego = LeftCM at 100 @ 0
                  ^^^^^^^^^^^^^^^^^
        """,
    ),
    "fault in a library function": (
        'ego = LeftCM on grid(1, 2, "a")',
        """
        <program>:1:17: `/` of a number and a text
            ego = LeftCM on grid(1, 2, "a")
                            ^^^^^^^^^^^^^^^
            in grid(row, column, grid_len), football/model.scenic:43: width = field_width / grid_len
        """,
    ),
    "wrong arguments of a program's function": (
        "ego = LeftCM on get_reg_from_edges(1, 2, 3)",
        """
        <program>:1:17: get_reg_from_edges(left, right, top, bottom): 'bottom' is missing
            ego = LeftCM on get_reg_from_edges(1, 2, 3)
                            ^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "wrong arguments of a built-in function": (
        "ego = LeftCM at Range(1) @ 0",
        """
        <program>:1:17: Range does not take 1 argument (write Range(low, high))
            ego = LeftCM at Range(1) @ 0
                            ^^^^^^^^
        """,
    ),
    "wrong arguments of a behavior": (
        """
        behavior Run(speed):
            take speed
        ego = LeftCM at 0 @ 0, with behavior Run(1, 2)
        """,
        """
        <program>:3:38: Run(speed): 2 arguments were given
            ego = LeftCM at 0 @ 0, with behavior Run(1, 2)
                                                 ^^^^^^^^^
        """,
    ),
    "no class": (
        """
        x = 5
        ego = new x at 3 @ 4
        """,
        """
        <program>:2:11: a number is not a class of objects
            ego = new x at 3 @ 4
                      ^
        """,
    ),
    "object made by a call": (
        "ego = LeftCM()",
        """
        <program>:1:7: objects of class LeftCM are not made by a call (write new LeftCM)
            ego = LeftCM()
                  ^^^^^^^^
        """,
    ),
    "negative weight": (
        "ego = LeftCM at Discrete({1: -1, 2: 3}) @ 0",
        """
        <program>:1:17: the weight -1 of 1 in Discrete is negative
            ego = LeftCM at Discrete({1: -1, 2: 3}) @ 0
                            ^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "ends of a truncated normal": (
        "ego = LeftCM at TruncatedNormal(0, 1, 3, 2) @ 0",
        """
        <program>:1:17: the low end 3 of TruncatedNormal must be below the high end 2
            ego = LeftCM at TruncatedNormal(0, 1, 3, 2) @ 0
                            ^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "random index": (
        """
        ego = LeftCM at 0 @ 0
        param x = [1, 2][DiscreteRange(0, 1)]
        """,
        """
        <program>:2:11: the index of a list must not be random (write Uniform(*items) for a random element)
            param x = [1, 2][DiscreteRange(0, 1)]
                      ^^^^^^^^^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "random key": (
        """
        ego = LeftCM at 0 @ 0
        param x = {1: 2}.get(DiscreteRange(0, 1), 3)
        """,
        """
        <program>:2:11: a random value cannot be looked up here (write it in `require`, or decide in a behavior)
            param x = {1: 2}.get(DiscreteRange(0, 1), 3)
                      ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
        <program>:2:22: the random value is drawn here
            param x = {1: 2}.get(DiscreteRange(0, 1), 3)
                                 ^^^^^^^^^^^^^^^^^^^
        """,
    ),
    "division by zero": (
        "ego = LeftCM at 1 / 0 @ 3",
        """
        <program>:1:17: division by zero
            ego = LeftCM at 1 / 0 @ 3
                            ^^^^^
        """,
    ),
    "simulation outside a behavior": (
        """
        ego = LeftCM at 0 @ 0
        t = simulation().currentTime
        """,
        """
        <program>:2:5: simulation() has a meaning only while a behavior runs (use it inside a behavior)
            t = simulation().currentTime
                ^^^^^^^^^^^^
        """,
    ),
    "statement that is left out": (
        """
        ego = LeftCM at 0 @ 0
        raise ego
        """,
        """
        <program>:2:1: `raise` is not supported (write "assert condition, message")
            raise ego
            ^^^^^
        """,
    ),
    "property assigned": (
        """
        ego = LeftCM at 0 @ 0
        ego.x = 5
        """,
        """
        <program>:2:1: the x of an object belongs to its position (write ego.position = x @ y)
            ego.x = 5
            ^^^^^
        """,
    ),
    "behavior that is none": (
        "ego = LeftCM at 0 @ 0, with behavior 5",
        """
        <program>:1:24: the property 'behavior' must be a behavior, not a number (write with behavior B())
            ego = LeftCM at 0 @ 0, with behavior 5
                                   ^^^^^^^^^^^^^^^
        """,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_error(name):
    program, expected = (textwrap.dedent(text).strip("\n") for text in CASES[name])
    with pytest.raises(ScenicError) as caught:
        load(program, FOOTBALL)
    assert str(caught.value) == expected.rstrip()


def test_everything_that_is_wrong_is_shown_at_once():
    with pytest.raises(ScenicError) as caught:
        load("take 3\nego = LeftCM\nparam a = 1, a = 2\n", FOOTBALL)
    assert caught.value.line == 1
    assert [error.line for error in caught.value.also] == [3]
    assert str(caught.value).splitlines() == [
        '<program>:1:1: "take" may only stand in a behavior, not at the top level',
        "    take 3",
        "    ^^^^^^",
        '<program>:3:14: the parameter "a" occurs twice in one statement',
        "    param a = 1, a = 2",
        "                 ^",
    ]


def test_many_errors_are_cut_short():
    with pytest.raises(ScenicError) as caught:
        load("take 1\n" * 1000)
    assert len(caught.value.also) == 999
    assert str(caught.value).splitlines()[-1] == "and 979 errors more"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_the_line_shown_is_the_one_that_the_lexer_counts(end):
    text = end.join(["\ufeff# a page\x0cbreak\u2028and more", "x = 'a\u2028b'", "ego = nobody"])
    with pytest.raises(ScenicError) as caught:
        load(text)
    assert str(caught.value).splitlines() == [
        "<program>:3:7: name 'nobody' is not defined",
        "    ego = nobody",
        "          ^^^^^^",
    ]


def test_missing_file(tmp_path):
    with pytest.raises(ScenicError, match="there is no file"):
        load(tmp_path / "none.scenic")
    with pytest.raises(ScenicError, match="is not UTF-8 text"):
        Path(tmp_path / "latin.scenic").write_bytes(b"x = '\xe9'")
        load(tmp_path / "latin.scenic")


def test_modules_beside_the_program(tmp_path):
    (tmp_path / "places.scenic").write_text("spot = 3 @ 4\n_hidden = 5\nfar = spot / 0\n")
    main = tmp_path / "main.scenic"
    main.write_text("from places import spot\nego = Object at spot\n")
    with pytest.raises(ScenicError, match=r"places.scenic:3:7: division by zero") as caught:
        load(main)
    assert caught.value.line == 3
    (tmp_path / "places.scenic").write_text("spot = 3 @ 4\n_hidden = 5\n")
    assert load(main).instantiate([[]]).positions.tolist() == [[[3, 4]]]
    main.write_text("import places as p\nego = Object at p.spot + p._hidden @ 0\n")
    assert load(main).instantiate([[]]).positions.tolist() == [[[8, 4]]]
    main.write_text("from places import *\nego = Object at _hidden @ 0\n")
    with pytest.raises(ScenicError, match="name '_hidden' is not defined"):
        load(main)
    (tmp_path / "places.scenic").write_text("import main\n")
    with pytest.raises(ScenicError, match="in a circle"):
        load(main)


def test_dialect_must_be_known():
    with pytest.raises(ValueError, match=r"dialect must be one of \(2, 3\), not 4"):
        load("ego = Object", dialect=4)
