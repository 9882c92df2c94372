"""Speed of reading programs and drawing scenes from them, beside the original Scenic interpreter.

The programs are in `lab/benchmarks/programs`. Read next: `scenic_lite.scene.program`, whose `sample` is measured.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lab.benchmarks.timing import STRETCHES, rate
from regista.experiments.run.results import align

if TYPE_CHECKING:
    from scenic_lite import Domain, Program

PROGRAMS = Path(__file__).parent / "programs"
LARGE, SMALL = 4096, 256  # scenes drawn in one call
DRAWS = 4096  # for the share of valid scenes


class Original(NamedTuple):
    """Processor time of Scenic 3.1.1 (two-dimensional mode, pruning on) for the same text on one core."""

    scenes_per_second: float
    load_ms: float


# By file in `programs`: whether it is a football program, the dialect, and Scenic's numbers.
CASES = {
    "figure_4_3": (True, 2, Original(1283, 53)),
    "eleven_a_side": (False, 3, Original(202, 95)),
    "crowd": (False, 3, Original(28, 184)),
    "polygons": (False, 3, Original(553, 81)),
    "tight": (False, 3, Original(90, 52)),
    "soft": (False, 3, Original(537, 50)),
    "mutated": (False, 3, Original(567, 27)),
}


class LanguageMeasurement(NamedTuple):
    """One program: its size, the share of valid draws, valid scenes per second, and the ms from text to Program."""

    program: str
    objects: int
    draws: int
    valid: float
    scenes_per_second: float
    scenes_per_second_small: float
    load_ms: float
    original_scenes_per_second: float
    original_load_ms: float


def language_suite(seconds: float) -> list[LanguageMeasurement]:
    """Measure every program of `CASES`, about `seconds` for each number."""
    return [measure(name, seconds) for name in CASES]


def measure(name: str, seconds: float) -> LanguageMeasurement:
    """Measure one program on one core with all default checks, in processor time as for the original."""
    football, dialect, original = CASES[name]
    path, domain = PROGRAMS / f"{name}.scenic", football_domain() if football else None
    text = path.read_text()
    program = loaded(text, domain, dialect)

    def load(count: int) -> None:
        for _ in range(count):
            loaded(text, domain, dialect)

    large, small = (scenes_per_second(program, n, seconds) for n in (LARGE, SMALL))
    load_ms = 1e3 / rate(load, seconds / STRETCHES, clock=time.process_time)
    valid = program.report(DRAWS, np.random.default_rng(0)).accepted / DRAWS
    return LanguageMeasurement(name, len(program.objects), program.dim, valid, large, small, load_ms, *original)


def football_domain() -> Domain:
    from regista.envs.football.scenic.domain import FOOTBALL

    return FOOTBALL


def loaded(text: str, domain: Domain | None, dialect: int) -> Program:
    from scenic_lite import load

    return load(text, domain, dialect)


def scenes_per_second(program: Program, n: int, seconds: float) -> float:
    """Return valid scenes per second, n at a time."""
    rng = np.random.default_rng(0)

    def sample(count: int) -> None:
        for _ in range(count):
            program.sample(n, rng)

    return n * rate(sample, seconds, warm_up=1, clock=time.process_time)


def render_language(rows: Sequence[LanguageMeasurement]) -> str:
    """Return the suite as a table."""
    head = ["language", "objects", "draws", "valid", f"scenes/s at {LARGE}", f"at {SMALL}", "load"]
    lines = [[*head, "Scenic 3.1.1: scenes/s", "load", "ours"]]
    for row in rows:
        numbers = [str(row.objects), str(row.draws), f"{row.valid:.1%}"]
        speeds = [f"{row.scenes_per_second:,.0f}", f"{row.scenes_per_second_small:,.0f}", f"{row.load_ms:.1f} ms"]
        ratio = row.scenes_per_second / row.original_scenes_per_second
        theirs = [f"{row.original_scenes_per_second:,.0f}", f"{row.original_load_ms:.0f} ms", f"{ratio:,.0f} x"]
        lines.append([row.program, *numbers, *speeds, *theirs])
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return align([[line[0], *(cell.rjust(w) for cell, w in zip(line[1:], widths[1:], strict=True))] for line in lines])
