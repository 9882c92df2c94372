"""What a beginner's slips are answered with, verbatim: `mistakes.txt`, in which each program is followed by the answer.

`python -m tests.scenic_lite.test_mistakes` writes the present answers into the file; read the difference.
"""

from pathlib import Path

import numpy as np
import pytest

from scenic_lite import ScenicError, load

FILE = Path(__file__).parent / "mistakes.txt"
NEWER = {  # the words of Python itself, up to 3.13 and since
    "math domain error": "expected a nonnegative input, got -1.0",
    "integer modulo by zero": "division by zero",
}
HEAD, *CASES = FILE.read_text().split("\n=====\n")


def answer(program: str) -> str:
    try:
        load(program + "\n", dialect=3).sample(1, np.random.default_rng(0))
    except ScenicError as error:
        return str(error)
    return "no error"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.split("\n-----\n")[0][:40])
def test_slip(case):
    program, expected = case.rstrip("\n").split("\n-----\n")
    assert expected != "no error"
    newer = expected
    for before, since in NEWER.items():
        newer = newer.replace(before, since)
    assert answer(program) in (expected, newer)


def record() -> None:
    """Answer every program again."""
    programs = [case.rstrip("\n").split("\n-----\n")[0] for case in CASES]
    cases = [f"{program}\n-----\n{answer(program)}" for program in programs]
    FILE.write_text("\n=====\n".join([HEAD, *cases]) + "\n")


if __name__ == "__main__":
    record()
