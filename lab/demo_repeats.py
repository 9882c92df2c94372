"""Does the demo show what its text says? It is repeated with fresh seeds; each repetition is compared with DR.

    python -m lab.demo_repeats --out runs/demo_repeats     # 30 minutes on 2 cores; goes on where it was stopped

Runs the command of `make demo` ten times without recordings, each time with other seeds. lab/results/demo.csv gets a
row for each repetition and method. A row has the difference between the method's success rate and DR's, mean of all
scenes, in percentage points.
"""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

from regista.experiments.__main__ import main as regista
from regista.experiments.run import results as estimate
from regista.experiments.run.report import save_rows
from regista.experiments.run.results import Result, unique
from regista.experiments.run.table import read_rows

ROWS = Path("lab/results/demo.csv")
REPETITIONS, FIRST_SEED = 10, 2000
ADDED = ("--no-record",)  # recordings are not needed


def command() -> list[str]:
    """Return the demo's command as words after `regista`, without its folder."""
    made = Path("Makefile").read_text().replace("\\\n", " ")
    found = re.search(r"^demo:.*\n\t\S+ (compare .*)$", made, re.MULTILINE)
    assert found, "the Makefile has no demo of one command"
    words = shlex.split(found[1])
    at = words.index("--out")
    return [*words[:at], *words[at + 2 :]]


def seeds(words: Sequence[str]) -> int:
    """Return the number of runs of each method that a command trains."""
    return int(words[words.index("--seeds") + 1])


def gains(repetition: int, path: Path) -> Iterator[dict[str, object]]:
    """Yield a row for each method of a comparison but the first: its difference to the first, in percentage points."""
    rows = [result(row) for row in read_rows(path / "results.csv")]
    trained = unique([row.method for row in rows if row.env_steps])
    base = estimate.scores(rows, trained[0])
    for name in trained[1:]:
        found = estimate.score_advantage(estimate.scores(rows, name), base)
        told = {key: round(100 * value, 2) for key, value in zip(("difference", "low", "high"), found[:3], strict=True)}
        yield {"repetition": repetition, "seed": FIRST_SEED + repetition * len(base.rates), "method": name} | told


def result(row: dict[str, str]) -> Result:
    """Return the result of a row of results.csv, with 0 in fields that differences do not use."""
    steps = int(row["env_steps"] or 0)
    counts = (int(row["seed"]), row["scene"], int(row["episodes"]), 0.0, 0.0, int(row["goals"]), 0.0, steps, 0)
    return Result(row["method"], *counts)


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/demo_repeats"))
    typed, words = parser.parse_args(argv), command()
    done = read_rows(ROWS) if ROWS.exists() else []
    for repetition in range(REPETITIONS):
        if str(repetition) in {row["repetition"] for row in done}:
            continue
        folder, first = typed.out / str(repetition), FIRST_SEED + repetition * seeds(words)
        failed = regista([*words, *ADDED, "--first-seed", str(first), "--out", str(folder)])
        if failed:
            return failed
        done += [{key: str(value) for key, value in row.items()} for row in gains(repetition, folder)]
        save_rows(done, list(done[0]), ROWS)
    for name in unique([row["method"] for row in done]):
        mine = [row for row in done if row["method"] == name]
        known = sum(float(row["low"]) > 0 or float(row["high"]) < 0 for row in mine)
        print(f"{name}: the interval of the difference excludes 0 in {known} of {len(mine)} repetitions")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
