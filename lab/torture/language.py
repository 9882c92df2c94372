"""Feed many texts to the parser, the evaluator, the compiler and the machine, each text as far as it gets.

    python -m lab.torture.language COUNT SEED

Most texts are pieces of programs with some words changed, which take the parser a tenth of a millisecond. Some of the
texts that the parser accepts go on to the evaluator, and all that pass the evaluator go on to the next stages. Texts
are counted by the stage at which they end. Read next: `tests.scenic_lite.fuzzing`, what must be true of them.
"""

from __future__ import annotations

import random
import re
import sys
import time
from functools import cache

import numpy as np

from regista.envs.toy_world import toy_world
from scenic_lite import Program, ScenicError, load
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.syntax.parser import parse
from tests.scenic_lite import fuzzing
from tests.scenic_lite.dynamics import feature_programs
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.generated import program as generated
from tests.scenic_lite.dynamics.toy_world import first_table, run

LONGEST = 400  # characters of a piece
WORD = re.compile(r"\w+|[^\S\n]+|\n *|\W")
LOADED = 0.05  # share of readable texts that are evaluated
WHOLE = 0.005  # share of whole programs among all texts; these are always evaluated
STEPS = 3  # of a match with a compiled text
START = """ego = new Object at 0 @ 0
p = new Object at 5 @ Range(3, 9)
a, b = Range(0, 1), 3
box = CircularRegion(0 @ 0, 20)
swirl = VectorField('swirl', lambda q: q.x)
"""
STARTS = {2: START.replace("new ", ""), 3: START}
UNREAD, READ, REFUSED, UNCOMPILED, FAULTED, RAN = (
    *("refused by the parser", "read by the parser", "refused by the evaluator", "refused by the compiler"),
    *("stopped by a fault", "ran"),
)


@cache
def programs() -> list[str]:
    """Return all available programs, including those with behaviors."""
    bodies = [feature_programs.program(name) for name in feature_programs.BODIES]
    return [*fuzzing.corpus(), *bodies, feature_programs.MIXED, *(generated(seed) for seed in range(20))]


@cache
def pieces() -> list[list[str]]:
    """Return the pieces of all programs as words; a piece is an unindented line and the indented lines beneath it."""
    texts = {piece for text in programs() for piece in re.split(r"\n(?=[^\s#])", text) if 0 < len(piece) <= LONGEST}
    return [WORD.findall(piece) for piece in sorted(texts)]


def varied(rng: random.Random) -> str:
    """Return one or more pieces of programs with some words changed."""
    known = pieces()
    words = list(rng.choice(known))
    for _ in range(rng.choice((1, 1, 1, 2, 3, 5))):
        i = int(rng.random() * len(words))
        kind = int(rng.random() * 8)
        if kind == 0:
            del words[i : i + rng.choice((1, 1, 2, 5))]
        elif kind == 1:
            words.insert(i, f" {rng.choice(fuzzing.TOKENS)} ")
        elif kind == 2:
            words[i : i + 1] = [rng.choice(fuzzing.TOKENS)]
        elif kind == 3:
            words[i : i + 1] = [rng.choice(rng.choice(known))]
        elif kind == 4:
            j = int(rng.random() * len(words))
            words[i], words[j] = words[j], words[i]
        elif kind == 5:
            words[i:i] = words[i : i + rng.choice((1, 2, 6))] * rng.choice((1, 1, 2, 30))
        elif kind == 6:
            other = rng.choice(known)
            at = int(rng.random() * len(other))
            words[i : i + rng.choice((0, 1, 4))] = other[at : at + rng.choice((1, 2, 4, 12))]
        else:
            words += ["\n", *rng.choice(known)]
        words = words or [""]
    return "".join(words)


def text_of(rng: random.Random) -> tuple[str, bool]:
    """Return a text, and whether it is a changed whole program."""
    kind = rng.random()
    if kind < WHOLE:
        return fuzzing.mutated(rng, programs()), True
    if kind < 0.1:
        return fuzzing.soup(rng), False
    if kind < 0.2:
        writer = fuzzing.Writer(rng)
        return writer.filled(rng.choice(writer.statements), rng.randrange(4)), False
    return varied(rng), False


def ended(text: str, dialect: int, whole: bool, deeper: bool) -> str:
    """Return the stage at which a text ended. Raises AssertionError for a violated property."""
    try:
        parse(text + "\n", dialect=dialect)
    except ScenicError as error:
        fuzzing.check_place(error, text)
        return UNREAD
    if not deeper and not whole:
        return READ
    text = text if whole else STARTS[dialect] + text
    try:
        program = load(text + "\n", dialect=dialect)
    except ScenicError as error:
        fuzzing.check_place(error, text)
        return REFUSED
    return REFUSED if fuzzing.sampled(program, text) != "loaded" else played(program, text)


def played(program: Program, text: str) -> str:
    """Return the outcome of a program in a match of the toy world."""
    try:
        compiled = compile_program(program, toy_world())
    except ScenicError as error:
        if error.place is not None:
            fuzzing.check_place(error, text)
        return UNCOMPILED
    try:
        theta = program.sample(1, np.random.default_rng(0))[0][0]
        run(first_table(program, theta), CompiledController(compiled, theta, 0), STEPS, 1.0)
    except ScenicError:
        return FAULTED
    return RAN


@cache
def warm_up() -> None:
    """Compile or load the kernels of the machine, so that their time counts for no text."""
    played(load(feature_programs.MIXED), feature_programs.MIXED)


def attack(count: int, seed: int) -> dict[str, int]:
    """Try `count` texts; return the count of each end. Raises AssertionError for any error but the language's own."""
    warm_up()
    counts = dict.fromkeys((UNREAD, READ, REFUSED, UNCOMPILED, FAULTED, RAN), 0)
    for i in range(count):
        rng = random.Random(f"{seed} {i}")
        text, whole = text_of(rng)
        dialect, deeper, began = rng.choice((2, 3)), rng.random() < LOADED, time.process_time()
        try:
            counts[ended(text, dialect, whole, deeper)] += 1
            assert time.process_time() - began < fuzzing.SECONDS, "took too long"
        except Exception as fault:
            raise AssertionError(
                f"text {i} of round {seed}, dialect {dialect}: {type(fault).__name__}: {fault}\n{text}"
            ) from fault
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2])))
