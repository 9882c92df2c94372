"""The torture suite: minutes or hours of what must never harm, in rounds, with a report of how much was done.

    python -m tests.torture [--minutes 10] [--report runs/torture.json] [--only states code]

Each part does rounds of so many attempts, every round with a seed of its own; the part that has had least of the time
is next. The report is written after each round, and a suite that was stopped goes on with the seeds that follow. With
NUMBA_BOUNDSCHECK=1 kernels are compiled with bounds checks, and counted apart.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from tests.envs.hostile import attack_records, attack_states
from tests.envs.torture import torture
from tests.scenic_lite.dynamics.hostile import attack as attack_code
from tests.torture import moments
from tests.torture.faults import attack as inject_faults
from tests.torture.files import attack as attack_folders
from tests.torture.interrupts import attack as interrupt_commands

CHECKED = " with bounds checks" if os.environ.get("NUMBA_BOUNDSCHECK") == "1" else ""


class Part(NamedTuple):
    """What is counted, how many in a round, and how a round is done: from its number of attempts, seed and folder."""

    unit: str
    size: int
    attack: Callable[[int, int, Path], dict[str, int]]


def programs(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Try programs that nobody would write; raises AssertionError for an error that is none of the language's."""
    import random

    from tests.scenic_lite import fuzzing

    texts, counts = fuzzing.corpus(), dict[str, int]()
    for i in range(count):
        rng = random.Random(f"{seed} {i}")
        text, dialect = fuzzing.written(rng, texts), rng.choice((2, 3))
        result = fuzzing.attempt(text, dialect)
        assert not result.startswith("FAULT"), f"{result}\n{text}"
        kind = "loaded" if result == "loaded" else "refused"
        counts[kind] = counts.get(kind, 0) + 1
    return counts


PARTS = {
    "states": Part("states with a number changed", 2_000, lambda count, seed, _: attack_states(count, seed)),
    "code": Part("code or registers with a number changed", 5_000, lambda count, seed, _: attack_code(count, seed)),
    "records": Part("records of matches damaged", 100, attack_records),
    "folders": Part("run folders damaged", 40, attack_folders),
    "programs": Part("programs that nobody would write", 500, programs),
    "faults": Part("changes on the disk that failed, or were the last", 10, inject_faults),
    "kills": Part("commands killed", 10, moments.kill),
    "ctrl-c": Part("commands interrupted in their work", 10, moments.interrupt),
    "interrupts": Part("commands interrupted", 9, interrupt_commands),
    "matches": Part("player-steps", 64, lambda count, seed, _: {"sane": torture(count, 1_000, seed)}),
}


def run_round(name: str, seed: int, folder: Path) -> dict[str, int]:
    """Do one round of a part; return its counts."""
    part = PARTS[name]
    (folder / name).mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return part.attack(part.size, seed, folder / name)


def main(argv: list[str]) -> int:
    """Do rounds until the time is over; return 1 if something was harmed."""
    parser = argparse.ArgumentParser(prog="python -m tests.torture")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--report", type=Path, default=Path("runs/torture.json"))
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    typed = parser.parse_args(argv)
    report: dict[str, Any] = json.loads(typed.report.read_text()) if typed.report.exists() else {}
    typed.report.parent.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60 * typed.minutes
    with tempfile.TemporaryDirectory() as folder:
        while time.monotonic() < end:
            done = {name: report.setdefault(name + CHECKED, new_row(name)) for name in typed.only}
            name = min(typed.only, key=lambda each: done[each]["seconds"])
            row, began = done[name], time.monotonic()
            try:
                counts = run_round(name, row["rounds"], Path(folder))
            except AssertionError as harm:
                counts = {"HARM": 1}
                row["harm"].append(f"round {row['rounds']}: {harm}"[:2_000])
                print(f"{name}, round {row['rounds']}: {harm}", file=sys.stderr, flush=True)
            row["rounds"] += 1
            row["seconds"] += time.monotonic() - began
            for what, count in counts.items():
                row["counts"][what] = row["counts"].get(what, 0) + count
            beside = typed.report.with_name(typed.report.name + ".part")
            beside.write_text(json.dumps(report, indent=2) + "\n")
            beside.replace(typed.report)
    print(table(report))
    return int(any(row["harm"] for row in report.values()))


def new_row(name: str) -> dict[str, Any]:
    return {"unit": PARTS[name].unit + CHECKED, "rounds": 0, "seconds": 0.0, "counts": {}, "harm": []}


def table(report: dict[str, Any]) -> str:
    """Return the report as a Markdown table."""
    lines = ["| what | how many | what became of them | harm |", "|---|---|---|---|"]
    for row in report.values():
        total = sum(row["counts"].values())
        parts = ", ".join(f"{count:,} {what}" for what, count in sorted(row["counts"].items()))
        lines.append(f"| {row['unit']} | {total:,} | {parts} | {len(row['harm'])} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
