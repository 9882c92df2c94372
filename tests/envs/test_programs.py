"""Football programs with behaviors do in the simulator what their comments say."""

from pathlib import Path

import pytest
from expectations import MOST, courses, expectations

PROGRAMS = sorted((Path(__file__).parents[1] / "programs" / "football").glob("*.scenic"))


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_does_what_it_says(path):
    wanted = expectations(path)
    assert wanted, f"{path.name} says nothing"
    played = courses(path, max([60, *(each.step for each in wanted)]))
    for each in wanted:
        answers = [answer for answer in (course.holds(each) for course in played) if answer is not None]
        assert answers, f"every match was over before {each}"
        assert sum(answers) >= MOST * len(answers), f"{each} holds in {sum(answers)} of {len(answers)} matches"
