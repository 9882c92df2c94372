"""Football programs with behaviors do in the simulator what their comments say."""

from pathlib import Path

import pytest
from expectations import MOST, courses, expectations

PROGRAMS = sorted((Path(__file__).parents[1] / "programs" / "football").glob("*.scenic"))
AMISS = {  # programs of which the real engine does what the comments say, and the simulator does not
    "counterattack": "the carrier may pass before he turns, to the forward: three matches of four do what they should",
}


def program(path):
    marks = [pytest.mark.xfail(reason=AMISS[path.stem])] if path.stem in AMISS else []
    return pytest.param(path, id=path.stem, marks=marks)


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("path", [program(path) for path in PROGRAMS])
def test_a_program_does_what_it_says(path):
    wanted = expectations(path)
    assert wanted, f"{path.name} says nothing"
    played = courses(path, max([60, *(each.step for each in wanted)]))
    for each in wanted:
        answers = [answer for answer in (course.holds(each) for course in played) if answer is not None]
        assert answers, f"every match was over before {each}"
        assert sum(answers) >= MOST * len(answers), f"{each} holds in {sum(answers)} of {len(answers)} matches"
