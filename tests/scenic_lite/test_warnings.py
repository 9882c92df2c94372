"""What is legal but looks like a slip: every warning with its place, once."""

import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from scenic_lite import load

WARNINGS = [
    (
        "ego = LeftCM at 0 @ 0, with bahavior HoldPosition()",
        "<program>:2:24: LeftCM has no property 'bahavior' (did you mean 'behavior'?)",
    ),
    (
        "ego = LeftGK at 95 @ 40, with HoldPosition()",
        "<program>:2:26: LeftGK has no property 'HoldPosition' (did you mean 'behavior HoldPosition()'?)",
    ),
]


@pytest.mark.parametrize(("line", "expected"), WARNINGS)
def test_misspelt_property_is_a_warning(line, expected):
    program = load(f"from scenic.simulators.gfootball.behaviors import *\n{line}", FOOTBALL)
    assert [str(each).splitlines()[0] for each in program.warnings] == [expected]
    assert program.objects[0].behavior is None


def test_warnings_of_the_parser_are_passed_on():
    program = load("ego = LeftCM at 0 @ 0, facing 90\nBall at 3 @ 3, with rotation 1", FOOTBALL)
    assert [str(each).splitlines()[0] for each in program.warnings] == [
        '<program>:1:24: angles are in radians, and this one makes 14 turns (degrees are written "90 deg")'
    ]


def test_warnings_come_once_each_and_from_imported_files_too(tmp_path):
    (tmp_path / "helpers.scenic").write_text("def put(y):\n    return LeftCM at 0 @ y, facing 90\nput(1)\nput(5)\n")
    main = tmp_path / "main.scenic"
    main.write_text("from helpers import put\nego = put(9)\nLeftCM at 20 @ 0, with bahavior 3\n")
    assert [str(each).splitlines()[0] for each in load(main, FOOTBALL).warnings] == [
        "main.scenic:3:19: LeftCM has no property 'bahavior' (did you mean 'behavior'?)",
        'helpers.scenic:2:29: angles are in radians, and this one makes 14 turns (degrees are written "90 deg")',
    ]


def test_unknown_property_that_resembles_none_is_no_warning():
    assert load("ego = LeftCM at 0 @ 0, with plan 3", FOOTBALL).warnings == ()
