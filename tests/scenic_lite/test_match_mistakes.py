"""What slips in behaviors and scenarios are answered with, verbatim: `match_mistakes.txt`, in which each program is
followed by the answer.

`python -m tests.scenic_lite.test_match_mistakes` writes the present answers into the file; read the difference.
"""

from pathlib import Path

import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from scenic_lite.dynamics.compiler.compile import compile_program

FILE = Path(__file__).parent / "match_mistakes.txt"
HEAD, *CASES = FILE.read_text().split("\n=====\n")


def answer(text: str) -> str:
    """Return what is said of a program before its first match."""
    football = "ball = " in text
    try:
        program = load(text + "\n", FOOTBALL if football else None)
        compiled = compile_program(program, FOOTBALL_WORLD if football else toy_world(1.0))
    except ScenicError as error:
        return str(error)
    return "\n".join(map(str, (*program.warnings, *compiled.diagnostics))) or "nothing"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.split("\n-----\n")[0][-60:])
def test_slip(case):
    program, expected = case.rstrip("\n").split("\n-----\n")
    assert expected != "nothing"
    assert answer(program) == expected


def record() -> None:
    """Answer every program again."""
    programs = [case.rstrip("\n").split("\n-----\n")[0] for case in CASES]
    FILE.write_text("\n=====\n".join([HEAD, *(f"{text}\n-----\n{answer(text)}" for text in programs)]) + "\n")


if __name__ == "__main__":
    record()
