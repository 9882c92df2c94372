"""Programs that nobody would write, and what must be true of them: a ScenicError or a Program, soon, and nothing else.

`python -m tests.scenic_lite.fuzzing COUNT [SEED]` tries many. Read next: `test_fuzzing`, which tries a few.
"""

import random
import resource
import sys
import time
from pathlib import Path

import numpy as np

from scenic_lite import Program, ScenicError, load

SECONDS = 2  # for one load
TESTS = Path(__file__).parents[1]
FOLDERS = (TESTS / "programs", TESTS / "oracle" / "programs", TESTS / "oracle" / "open", TESTS.parent / "minigames")
SIGNS = (
    "( ) [ ] { } , : ; = == @ + - * ** / // % . ... -> := ' \" ''' f\"{ } \\ # \t \n \x00 é 1e 0x 3deg 0 1 -1 2.5 1e308"
)
WORDS = """
with at by to from distance if else elif for in not and or lambda new require always eventually until param ego class
def return while break try except finally raise behavior monitor take wait do interrupt when terminate mutate record
Range Uniform Discrete Normal DiscreteRange TruncatedNormal Object Point OrientedPoint facing toward ahead of behind
left right on beyond offset along relative heading angle deg can see visible following RectangularRegion
CircularRegion PolygonalRegion VectorField everywhere nowhere workspace Workspace resample len sum max min str int
sorted range self position width length x y None True False import model math global pass del assert match case
"""
TOKENS = [*SIGNS.split(" "), *WORDS.split()]


def shapes() -> list[list[str]]:
    """Return the shapes of expressions, specifiers and statements."""
    _, *tables = (Path(__file__).parent / "fuzzing_shapes.txt").read_text().split("\n== ")
    rows = [table.split("\n", 1)[1].replace("\n", "|").split("|") for table in tables]
    return [[shape.replace("\\n", "\n") for shape in row if shape] for row in rows]


SHAPES = shapes()


def corpus() -> list[str]:
    """Return every program at hand, without the oracle's header lines."""
    texts = [path.read_text() for folder in FOLDERS for path in sorted(folder.rglob("*.scenic"))]
    return ["\n".join(line for line in text.split("\n") if not line.startswith("#!")) for text in texts]


# ---------------------------------------------------------------- making programs


def mutated(rng: random.Random, texts: list[str]) -> str:
    """Return a program with a few slips in it, from a missing sign to a line from somewhere else."""
    text = rng.choice(texts)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.randrange(1, 12))
        lines = rng.choice(texts).split("\n")
        text = rng.choice(
            (
                text[:start] + text[end:],
                f"{text[:start]} {rng.choice(TOKENS)} {text[end:]}",
                text[:start] + rng.choice(TOKENS) + text[start:],
                text[:start] + text[start:end] * rng.choice((2, 3, 40)) + text[end:],
                swapped(rng, text),
                with_line(rng, text, rng.choice(lines)),
            )
        )
    return text


def swapped(rng: random.Random, text: str) -> str:
    """Exchange two words of a text."""
    words = text.split(" ")
    i, j = rng.randrange(len(words)), rng.randrange(len(words))
    words[i], words[j] = words[j], words[i]
    return " ".join(words)


def with_line(rng: random.Random, text: str, line: str) -> str:
    lines = text.split("\n")
    lines.insert(rng.randrange(len(lines) + 1), line)
    return "\n".join(lines)


def soup(rng: random.Random) -> str:
    """Return tokens in any order."""
    return "".join(rng.choice(TOKENS) + rng.choice(("", " ", " ", "\n")) for _ in range(rng.randrange(1, 60)))


class Writer:
    """Programs that follow the grammar and know no types."""

    LEAVES = ("0", "1", "2.5", "-3", "1e9", "'word'", "None", "True", "a", "b", "p", "ego", "box", "[]", "(0 @ 1)")

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.shapes, self.specifiers, self.statements = SHAPES

    def expression(self, depth: int) -> str:
        if depth <= 0 or self.rng.random() < 0.3:
            return self.rng.choice(self.LEAVES)
        return self.filled(self.rng.choice(self.shapes), depth - 1)

    def filled(self, shape: str, depth: int) -> str:
        """Return a shape with expressions in its holes."""
        while "{specs}" in shape:
            specs = [self.filled(self.rng.choice(self.specifiers), depth) for _ in range(self.rng.randrange(1, 4))]
            shape = shape.replace("{specs}", ", ".join(specs).replace("{", "{{").replace("}", "}}"), 1)
        holes = [self.expression(depth) for _ in range(shape.count("{}"))]
        return shape.format(*holes)

    def program(self) -> str:
        start = "ego = new Object at 0 @ 0\np = new Object at 5 @ Range(3, 9)\na, b = Range(0, 1), 3\n"
        start += "box = CircularRegion(0 @ 0, 20)\nswirl = VectorField('swirl', lambda q: q.x)\n"
        count = self.rng.randrange(1, 6)
        return start + "".join(
            self.filled(self.rng.choice(self.statements), self.rng.randrange(4)) + "\n" for _ in range(count)
        )


def written(rng: random.Random, texts: list[str]) -> str:
    """Return a program of one of the three kinds."""
    kind = rng.random()
    if kind < 0.45:
        return mutated(rng, texts)
    return soup(rng) if kind < 0.6 else Writer(rng).program()


# ---------------------------------------------------------------- trying them


def outcome(text: str, dialect: int) -> str:
    """Return what became of a program: "loaded", "unsampled" or an error's kind. AssertionError for what must not."""
    program, spent = timed(text, dialect)
    if spent >= SECONDS:  # a slow program is slow again; a stall of the machine is not
        program, spent = timed(text, dialect)
    assert spent < SECONDS, f"took {spent:.1f} s to load, twice"
    if isinstance(program, ScenicError):
        check_place(program, text)
        return program.kind
    return sampled(program, text)


def timed(text: str, dialect: int) -> tuple[Program | ScenicError, float]:
    """Return a program, or the error with which it is refused, and the processor seconds that this took."""
    start = time.process_time()
    try:
        program: Program | ScenicError = load(text + "\n", dialect=dialect)
    except ScenicError as error:
        program = error
    return program, time.process_time() - start


def sampled(program: Program, text: str) -> str:
    for warning in program.warnings:
        check_place(warning, text)
    program.instantiate(np.linspace(-1, 1, 5)[:, None] * np.ones(program.dim))
    try:
        program.sample(2, np.random.default_rng(0))
    except ScenicError as error:
        if error.place is not None:
            check_place(error, text)
        return f"unsampled: {error.kind}"
    return "loaded"


def check_place(error: ScenicError, text: str) -> None:
    """Check that an error of a text lies inside it, and can be printed."""
    place, lines = error.place, (text + "\n").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    assert place is not None, f"no place: {error.message}"
    assert 1 <= place.line <= place.end_line <= len(lines), f"{place} is outside the text: {error.message}"
    assert 0 <= place.column <= len(lines[place.line - 1]), f"{place} is outside its line: {error.message}"
    assert place.end_column <= len(lines[place.end_line - 1]) + 1, f"{place} ends outside its line: {error.message}"
    assert (place.line, place.column) <= (place.end_line, place.end_column), f"{place} is backwards: {error.message}"
    assert error.message and len(str(error)) < 50_000


def attempt(text: str, dialect: int) -> str:
    """Do as `outcome`, with what must not be as its last words."""
    try:
        return outcome(text, dialect)
    except Exception as fault:
        return f"FAULT {type(fault).__name__}: {str(fault)[:120]}"


def main(count: int, seed: int) -> int:
    """Try programs, print each kind of fault once with its program, then how many came to what."""
    texts, counts, faults = corpus(), {}, 0
    for i in range(count):
        rng = random.Random(f"{seed} {i}")
        text, dialect = written(rng, texts), rng.choice((2, 3))
        result = attempt(text, dialect)
        if result.startswith("FAULT"):
            faults += 1
            if result not in counts:
                print(f"{result}  (number {i}, dialect {dialect})\n{text}\n{'-' * 60}", flush=True)
        counts[result] = counts.get(result, 0) + 1
        if i % 10_000 == 0:
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
            print(f"{i} programs, at most {memory} MiB so far", file=sys.stderr, flush=True)
    for result, times in sorted(counts.items(), key=lambda item: -item[1]):
        print(f"{times:8} {result}")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
