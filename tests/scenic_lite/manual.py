"""Reads the language reference: its examples, and what each promises in comments that begin with `#=`.

An expectation stands at the end of the line that it is about; several are divided by `;`, and `2:` or `3:` before one
restricts it to a dialect (then the example runs in both). θ is 0 in every column. The forms are the functions of
`CHECKS`; anything else is the value of the line's parameter, or the place of the line's object. Read next:
`test_manual`.
"""

import ast
import math
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from regista.envs.toy_world import toy_world
from scenic_lite import Program, Scenes, ScenicError, load
from scenic_lite.dynamics.compiler.compile import compile_program
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.toy_world import Trace, first_table, run

MANUAL = Path(__file__).parents[2] / "scenic_lite" / "README.md"
STEPS, DRIFT = 6, 1.0  # of an episode in the toy world
CLOSE = 1e-3
DRAWS, SLACK = 4000, 0.02  # for a share of valid scenes


class Block(NamedTuple):
    """A fenced example: its language, the file that it is saved as ("" for none), its first line in the manual."""

    language: str
    file: str
    line: int
    text: str


class Expectation(NamedTuple):
    """What is promised of a line (counted from 1 in the example); `dialect` None for any."""

    line: int
    dialect: int | None
    text: str


def blocks(text: str) -> list[Block]:
    """Return the examples of a text, in order."""
    found = re.finditer(r"^```(scenic|python)(?: +(\S+))?\n(.*?)^```", text, re.M | re.S)
    return [Block(m[1], m[2] or "", text.count("\n", 0, m.start()) + 2, m[3]) for m in found]


def expectations(block: Block) -> list[Expectation]:
    found = []
    for number, line in enumerate(block.text.splitlines(), 1):
        _, mark, promised = line.partition("#= ")
        for part in promised.split("; ") if mark else []:
            dialect = re.match(r"([23]): ", part)
            found.append(Expectation(number, int(dialect[1]) if dialect else None, part[3 if dialect else 0 :].strip()))
    return found


@dataclass
class Example:
    """A Scenic example in one dialect, loaded."""

    text: str
    folder: Path
    dialect: int | None
    error: ScenicError | None = None

    @cached_property
    def program(self) -> Program:
        path = self.folder / "example.scenic"
        path.write_text(self.text)
        return load(path, dialect=self.dialect)

    @cached_property
    def scenes(self) -> Scenes:
        return self.program.instantiate(np.zeros((1, self.program.dim)))

    @cached_property
    def episode(self) -> tuple[Reference, Trace]:
        theta = np.zeros(self.program.dim)
        reference = Reference(self.program, theta, toy_world())
        return reference, run(first_table(self.program, theta), reference, STEPS, DRIFT)

    @cached_property
    def compiled(self) -> tuple[CompiledController, Trace]:
        theta = np.zeros(self.program.dim)
        controller = CompiledController(compile_program(self.program, toy_world()), theta)
        return controller, run(first_table(self.program, theta), controller, STEPS, DRIFT)

    def index(self, name: str) -> int:
        return [info.name for info in self.program.objects].index(name)


def failures(block: Block, folder: Path) -> list[str]:
    """Return what an example does other than promised."""
    wanted = expectations(block)
    assert wanted, f"the example of line {block.line} promises nothing"
    if block.language == "python":
        return python_failures(block, wanted)
    both = any(each.dialect for each in wanted)
    return [said for dialect in ((2, 3) if both else (None,)) for said in scenic_failures(block, folder, dialect)]


def scenic_failures(block: Block, folder: Path, dialect: int | None) -> list[str]:
    example = Example(block.text, folder, dialect)
    wanted = [each for each in expectations(block) if each.dialect in (None, dialect)]
    try:
        example.scenes  # noqa: B018  loads the program
        if not any(each.text.startswith("error:") for each in wanted):
            example.error = None
        elif needs_episode(example.program):
            example.episode  # noqa: B018  plays it
        else:
            example.program.sample(1, np.random.default_rng(0))
    except ScenicError as error:
        example.error = error
    said = []
    if example.error is not None:
        wanted = [each for each in wanted if each.text.startswith("error:") or not dialect]
        if not any(each.text.startswith("error:") for each in wanted):
            return [f"line {block.line}, dialect {dialect}: {example.error}"]
    for each in wanted:
        found = check(example, each)
        if found:
            said.append(f"line {block.line + each.line - 1}, dialect {dialect}: promised {each.text}\n    but {found}")
    if "episode" in vars(example) and example.error is None:
        said += compiled_failures(example, block, wanted)
    return said


def compiled_failures(example: Example, block: Block, wanted: list[Expectation]) -> list[str]:
    """Return where the compiled program does other than the reference, unless promised that it cannot be compiled."""
    refused = next((each for each in wanted if each.text.startswith("not compiled: ")), None)
    try:
        (controller, ours), (reference, theirs) = example.compiled, example.episode
    except ScenicError as error:
        good = refused and headline(error).startswith(refused.text.removeprefix("not compiled: "))
        return [] if good else [f"line {block.line}, compiled: {error}"]
    same_actions = [step.actions for step in ours.commands] == [step.actions for step in theirs.commands]
    if refused or not same_actions or ours[1:] != theirs[1:] or controller.records != reference.records:
        return [f"line {block.line}, compiled: {ours}"]
    return []


def needs_episode(program: Program) -> bool:
    return bool(program.behaviors or program.monitors or program.main)


def check(example: Example, promise: Expectation) -> str:
    """Return how an example differs from one promise; "" if it does not."""
    for start, function in CHECKS:
        match = re.match(start, promise.text)
        if match:
            return function(example, promise.line, match)
    return value_or_place(example, promise)


# ------------------------------------------------------------ the forms of expectations


def error(example: Example, line: int, match: re.Match) -> str:
    """`error: first words`, at this line."""
    found = example.error
    if found is None:
        return "there is no error"
    said = str(found).partition("\n")[0] if found.place is None else headline(found)
    return "" if said.startswith(match[1]) and found.line in (line, None) else f"line {found.line}: {said}"


def warning(example: Example, line: int, match: re.Match) -> str:
    """`warning: first words`, at this line."""
    found = [headline(each) for each in example.program.warnings if each.line == line]
    return "" if any(each.startswith(match[1]) for each in found) else f"warnings are {found}"


def headline(found: ScenicError) -> str:
    return found.message + (f" ({found.hint})" if found.hint else "")


def dimension(example: Example, line: int, match: re.Match) -> str:
    """`D = 2`."""
    return "" if example.program.dim == int(match[1]) else f"D = {example.program.dim}"


def columns(example: Example, line: int, match: re.Match) -> str:
    """`theta ego.x in [0, 5]`: a column drawn on this line; without limits where they are not known."""
    for draw in example.program.draws:
        if draw.name == match[1] and draw.place.line == line:
            wanted = ast.literal_eval(match[2].replace("inf", "1e999")) if match[2] else (draw.low, draw.high)
            near = same(list(wanted), [draw.low, draw.high]) or math.isnan(draw.low)
            return "" if near else f"{draw}"
    return f"the columns are {[(draw.name, draw.place.line) for draw in example.program.draws]}"


def acceptance(example: Example, line: int, match: re.Match) -> str:
    """Check `accepts 79 %` of uniform draws, soft requirements counted by their share."""
    report = example.program.report(DRAWS, np.random.default_rng(0))
    share = report.accepted / DRAWS
    return "" if abs(share - float(match[1]) / 100) < SLACK else f"{share:.1%}"


def does(example: Example, line: int, match: re.Match) -> str:
    """`ego does a, b, -`: its actions, step by step; - is none, a+b are two, the rest of the episode is not shown."""
    index = example.index(match[1])
    found = ["+".join(map(str, step.actions[index])) or "-" for step in example.episode[1].commands]
    wanted = match[2].split(", ")
    return "" if found[: len(wanted)] == wanted else f"{match[1]} does {', '.join(found)}"


def ends(example: Example, line: int, match: re.Match) -> str:
    """Check `ends at 3: reason`: steps played, and first words of Scenic's reason."""
    trace = example.episode[1]
    said = trace.ending if not trace.rejected else f"rejected: {trace.rejected}"
    good = len(trace.commands) == int(match[1]) and said.startswith(match[2])
    return "" if good else f"ends at {len(trace.commands)}: {said}"


def rewards(example: Example, line: int, match: re.Match) -> str:
    """`rewards 0, 1`: of each watched step."""
    found = example.episode[1].rewards
    wanted = [float(each) for each in match[1].split(", ")]
    return "" if list(found[: len(wanted)]) == wanted else f"{found}"


def record(example: Example, line: int, match: re.Match) -> str:
    """`record name = value`: a value, or the values of a series."""
    reference, _ = example.episode
    found = reference.records.get(match[1])
    series = [value for _, value in found] if isinstance(found, list) else found
    return "" if same(series, literal(match[2])) else f"{found}"


def value_or_place(example: Example, promise: Expectation) -> str:
    """Return the value of the line's parameter, or position and perhaps heading of its object."""
    for name, place in example.program.param_places.items():
        if place.line == promise.line:
            found = plain(example.scenes.params[name])
            return "" if same(found, literal(promise.text)) else f"{name} is {found!r}"
    for i, info in enumerate(example.program.objects):
        if info.place.line == promise.line:
            x, y = example.scenes.positions[0, i]
            heading = float(example.scenes.headings[0, i])
            place, facing, turn = promise.text.partition(" facing ")
            good = same((x, y), literal(place)) and (not facing or same(heading, literal(turn)))
            return "" if good else f"it is at ({x:.3f}, {y:.3f}) facing {math.degrees(heading):.3f} deg"
    return "nothing is made on this line"


CHECKS = (
    (r"error: (.*)", error),
    (r"warning: (.*)", warning),
    (r"D = (\d+)$", dimension),
    (r"theta (\S+)(?: in (\[.*\]))?$", columns),
    (r"accepts ([\d.]+) %$", acceptance),
    (r"(\w+) does (.*)", does),
    (r"ends at (\d+): (.*)", ends),
    (r"rewards (.*)", rewards),
    (r"record (\w+) = (.*)", record),
    (r"not compiled: .*", lambda example, line, match: ""),
)


# ------------------------------------------------------------ values


def literal(text: str) -> Any:
    """Return a value as the manual writes it; `90 deg` is an angle."""
    angle = re.fullmatch(r"(-?[\d.]+) deg", text)
    return math.radians(float(angle[1])) if angle else ast.literal_eval(text)


def plain(value: Any) -> Any:
    """Return a value of one scene."""
    if isinstance(value, np.ndarray):
        return plain(value[0])
    if isinstance(value, np.generic):
        return value.item()
    return value


def same(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, tuple | list) and isinstance(found, tuple | list | np.ndarray):
        return len(found) == len(wanted) and all(same(a, b) for a, b in zip(found, wanted, strict=True))
    if isinstance(wanted, bool) or isinstance(found, bool | np.bool_):
        return bool(found) is wanted
    if isinstance(wanted, int | float) and isinstance(found, int | float | np.number):
        return found == wanted or abs(found - wanted) < CLOSE
    return bool(found == wanted)


# ------------------------------------------------------------ Python


def python_failures(block: Block, wanted: list[Expectation]) -> list[str]:
    """Run the statements one by one; a promise is the value of the expression, or the error, that ends on its line."""
    names: dict[str, Any] = {}
    said = []
    for statement in ast.parse(block.text).body:
        promise = next((each for each in wanted if each.line == statement.end_lineno), None)
        source = ast.get_source_segment(block.text, statement)
        place = f"line {block.line + statement.end_lineno - 1}"
        found, fault = None, None
        try:
            if isinstance(statement, ast.Expr):
                found = eval(source, names)
            else:
                exec(source, names)
        except Exception as raised:  # whatever it is, the manual must have told of it
            fault = raised
        if promise is None or not promise.text.startswith("error: "):
            if fault is not None:
                return [*said, f"{place}: {fault}"]
            if promise is not None and not same_python(found, promise.text):
                said.append(f"{place}: {source} is {found!r}, not {promise.text}")
        elif fault is None or not words_of(fault).startswith(promise.text.removeprefix("error: ")):
            said.append(f"{place}: promised {promise.text}\n    but {fault}")
    return said


def words_of(fault: Exception) -> str:
    return headline(fault) if isinstance(fault, ScenicError) else str(fault)


def same_python(found: Any, text: str) -> bool:
    if str(found) == text:
        return True
    try:
        wanted = literal(text)
    except (ValueError, SyntaxError):
        return False
    return same(found.tolist() if isinstance(found, np.ndarray) else found, wanted)
