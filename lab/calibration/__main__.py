"""Derive fitted numbers of the football simulator again: measure GRF, fit a law directly to it, print both.

    python -m lab.calibration measure shots_at_keeper             plays the drawn scenes in GRF; writes data/NAME.csv
    python -m lab.calibration fit saves                           fits the stored measurements
    python -m lab.calibration fit                                 fits all tables

For each number, `fit` prints the shipped value, the fit to the measurements of GRF, and the same fit to our simulator
in the same scenes. The measurements are the ball and the bodies one step later, not the law's own variables; this
biases the fit in both engines alike. So compare GRF with our simulator: a number agrees if the two fits agree, and
`shipped + GRF - ours` is the suggested value. Read next: `tables.py`; `profile.py`, for numbers that act through play
alone.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path

from lab.calibration.regression import fit_fields
from lab.calibration.tables import MEASURES, TABLES, Table
from regista.experiments.run.results import align

DATA = Path(__file__).parent / "data"
ROUND = 160  # episodes between two writes of the file
OURS_MORE = 4  # factor on the number of episodes for our simulator


def measure(name: str, engine: str, count: int, seed: int, path: Path | None) -> list[dict]:
    """Play a measurement's scenes, and write its rows to `path` if it is given."""
    rows: list[dict] = []
    for done in range(0, count, ROUND):
        rows += MEASURES[name].measure(min(ROUND, count - done), engine, seed + done)
        if path is not None:
            with path.open("w", newline="") as file:
                writer = csv.DictWriter(file, rows[0], lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
            print(f"{done + ROUND} of {count} episodes, {len(rows)} rows", file=sys.stderr, flush=True)
    return rows


def report(table: Table, grf: Sequence[dict], ours: Sequence[dict]) -> str:
    """Fit a table to the rows of both engines; return its numbers and a summary of the measurements."""
    fits, counts, lines = {}, {}, []
    for engine, rows in (("GRF", grf), ("ours", ours)):
        seen = table.prepare(rows)
        fits[engine] = fit_fields(table.law, table.names, lambda law, seen=seen: table.losses(seen, law), table.least)
        losses = table.losses(seen, table.law)
        counts[engine] = len(losses)
        lines += [
            f"  {engine}, {what}: {seen_:.2f}, law {law:.2f}" for what, (seen_, law) in table.summary(seen).items()
        ]
    cells = [["number", "shipped", "GRF", "error", "ours", "error", "suggested", "GRF - ours, in errors"]]
    for k, name in enumerate(table.names):
        shipped = float(getattr(table.law, name))
        (there, wide), (here, narrow) = ((fits[e].values[k], fits[e].errors[k]) for e in ("GRF", "ours"))
        off = (there - here) / max((wide**2 + narrow**2) ** 0.5, 1e-12)
        numbers = [f"{x:.3g}" for x in (shipped, there, wide, here, narrow, shipped + there - here)]
        cells.append([name, *numbers, f"{off:+.1f}"])
    head = f"{table.title}: {counts['GRF']} rows of GRF, {counts['ours']} of our simulator"
    return "\n".join([head, align(cells), *lines])


def read(name: str) -> list[dict]:
    """Read the stored rows of a measurement of GRF."""
    return list(csv.DictReader((DATA / f"{name}.csv").read_text().splitlines()))


def main(argv: Sequence[str]) -> int:
    """Run the script and return its exit code."""
    parser = argparse.ArgumentParser(prog="python -m lab.calibration", description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("measure", "fit"))
    parser.add_argument(
        "name", nargs="?", help=f"of a measurement, {', '.join(MEASURES)}; of a fit, {', '.join(TABLES)}"
    )
    parser.add_argument("--count", type=int, help="episodes")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--csv", type=Path, help="file for a measurement")
    typed = parser.parse_args(argv)
    known = MEASURES if typed.what == "measure" else TABLES
    if typed.name not in (*known, *([None] if typed.what == "fit" else [])):
        parser.error(f"name must be one of {', '.join(known)}, not {typed.name!r}")
    if typed.what == "measure":
        count = typed.count or MEASURES[typed.name].count
        measure(typed.name, "grf", count, typed.seed, typed.csv or DATA / f"{typed.name}.csv")
        return 0
    played: dict[str, list[dict]] = {}
    for name in [typed.name] if typed.name else TABLES:
        source = TABLES[name].source
        count = typed.count or OURS_MORE * MEASURES[source].count
        if source not in played:
            played[source] = measure(source, "regista", count, typed.seed, None)
        print(report(TABLES[name], read(source), played[source]), end="\n\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
