"""Any text whatever gives a tree or a ScenicError, and soon."""

import inspect
import random
import sys
from pathlib import Path

import pytest

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.check import check
from scenic_lite.syntax.parser import parse

PROGRAMS = """
ego = new Ball ahead of keeper by Range(1, 2), facing 30 deg relative to ego, with behavior Run(Point on goal)
---
behavior Run(goal):
    try:
        do Move(goal) until (distance from self to ball) < 3
    interrupt when self.x > 3 and not self.owns_ball:
        take Shoot(), Pass(f"{goal!r:>{width}}")
        abort
    do choose {A(): 1, B(): 2} for 3 seconds
---
monitor M:
    while True:
        if ego in box: terminate
        wait
---
scenario S(x):
    precondition: x
    setup:
        ego = LeftGK at -98 @ 0,
            with role 'GK'
    compose:
        do A(), B()
---
class Player(Object):
    width[dynamic, final]: 1
    def speed(self, *args, k=1): return [x @ y for x, y in self.points if x > k]
---
require[0.5] (always x > 3) implies (eventually y until z) as name
param time = 3, 'a b' = {1: 2, **c}
""".strip("\n").split("\n---\n")
SIGNS = """
( ) [ ] { } , : ; = == @ + - * ** / . ... -> := ' " ''' f"{ } \\ # \t \n \x00 \x0c é “ 1e 0x 3deg
"""
WORDS = """
with at by to from distance if else for in not lambda interrupt when try: do until as new always take wait require
behavior monitor class def yield await match
"""
PIECES = SIGNS.split(" ") + WORDS.split()


def mutated(rng):
    text = rng.choice(PROGRAMS)
    for _ in range(rng.randrange(1, 6)):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.randrange(1, 12))
        change = rng.randrange(4)
        if change == 0:
            text = text[:start] + text[end:]
        elif change == 1:
            text = f"{text[:start]} {rng.choice(PIECES)} {text[end:]}"
        elif change == 2:
            text = text[:start] + text[start:end] * rng.choice([2, 3, 40]) + text[end:]
        else:
            text = text[:start] + rng.choice(PROGRAMS)[:40] + text[end:]
    return text


@pytest.mark.parametrize("seed", range(8))
def test_mutated_programs(seed):
    rng = random.Random(seed)
    for _ in range(250):
        text = mutated(rng)
        try:
            errors = check(parse(text, "p", rng.choice((2, 3))), text, "p")
        except ScenicError as error:
            errors = [error]
        for error in errors:
            assert error.place is not None and error.message
            assert error.place.line <= text.count("\n") + 2 and str(error)


N = 20_000
DEEP = {
    "brackets": "(" * N + ")" * N,
    "minus": "-" * N + "1",
    "not": "not " * N + "x",
    "lambda": "lambda: " * N + "1",
    "choice": "x if y else " * N + "z",
    "attributes": "a" + ".b" * N,
    "calls": "a" + "()" * N,
    "powers": "2**" * N + "2",
    "sums": "1+" * N + "1",
    "instances": "A at " * N + "x",
    "instances in brackets": "A at (" * 70 + "x" + ")" * 70,
    "both readings": "x = " + "A in b and (A in b if c else " * 70 + "x" + ")" * 70,
    "distances": "distance to " * N + "x",
    "distances in a row": "x = " + "distance to a relative to " * 80 + "b",
    "distances with choices": "x = " + "distance to a if (distance to b if " * 35 + "x" + ")" * 35,
    "always": "require " + "always " * N + "x",
    "until": "require " + "a until " * N + "b",
    "elif": "if x: pass\n" + "elif y: pass\n" * N,
    "blocks": "".join(" " * depth + "if x:\n" for depth in range(400)),
    "blocks and brackets": "".join(" " * k + "if x:\n" for k in range(70)) + " " * 70 + "(" * 70 + "x" + ")" * 70,
    "assignments": "x=" * N + "1",
    "comprehensions": "[x " + "for x in y " * N + "]",
    "f-strings": "f'{x:" + "{y:" * N + "}'",
    "digits": "x = " + "9" * 10_000,
    "specifiers": "Ball at x" + ", with y 3" * 2000,
}


@pytest.mark.slow
@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP.keys())
def test_deep_nesting(text):
    try:
        errors = check(parse(text, "p"), text, "p")
    except ScenicError as error:
        assert error.kind in ("budget", "syntax", "unsupported")
    else:
        assert all(isinstance(error, ScenicError) for error in errors)


def test_nesting_that_people_write_is_read():
    parse("x = " + "(" * 60 + "1" + ")" * 60)
    parse("x = " + " + ".join("abcdefgh" * 10))
    parse("".join(" " * k + "if x:\n" for k in range(40)) + " " * 40 + "pass")


def test_little_stack_left():
    """Even near Python's own limit a ScenicError comes out."""

    def parse_at(depth):
        if depth:
            return parse_at(depth - 1)
        with pytest.raises(ScenicError) as caught:
            parse("x = " + "(" * 70 + "1" + ")" * 70)
        return caught.value.kind

    used = len(inspect.stack())
    assert parse_at(sys.getrecursionlimit() - used - 150) == "budget"


def test_bytes_of_anything():
    rng = random.Random(0)
    for _ in range(200):
        text = rng.randbytes(60).decode("latin-1")
        try:
            parse(text)
        except ScenicError as error:
            assert str(error)


def test_nothing_is_handed_to_the_compiler():
    """No source of the parser calls eval, exec, compile, or ast.parse."""
    folder = Path(__file__).parents[2] / "scenic_lite" / "syntax"
    for path in folder.glob("*.py"):
        text = path.read_text()
        for call in ("eval(", "exec(", " compile(", "ast.parse(", "literal_eval(", "__import__"):
            assert call not in text.replace("re.compile(", ""), (path.name, call)


def test_an_fstring_in_an_operand_that_is_only_tried():
    """A word operator first tries a full expression as its operand; that failed attempt must leave no trace."""
    for text in ("x = distance to sum(a) can see f'{1 2}' by 3", "x = distance to sum(a) can see f'{(' by 3"):
        with pytest.raises(ScenicError):
            parse(text)
