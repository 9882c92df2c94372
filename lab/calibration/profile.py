"""Profile numbers of a law that act through play alone: is our simulator most like GRF at the shipped value?

A family of `lab.benchmarks --suite grf` is replayed with one number at a time multiplied by several factors. The loss
is the mean over the family's rows of the squared difference in units of the tolerance, at most 9 for a row. The output
is the best value, the range in which the loss is within a twentieth of the best, and the losses by factor. A wide range
means that the family does not determine the number. Random numbers are the same for all values. `--search` minimizes
the same loss over all numbers together.

    python -m lab.calibration.profile passes skills.passes.FLIGHT.ground_cap skills.passes.FLIGHT.base
    python -m lab.calibration.profile motion:slide_rows,tired_rows --group slide --csv slide.csv
    python -m lab.calibration.profile motion:slide_rows,tired_rows --group slide --search

Groups are those of `groups.py`; families may be parts of one. A run compiles football once, which takes some minutes.
Read next: `knobs.py`, `groups.py`.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

FACTORS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
SEARCHED = (0.2, 0.05)  # relative steps of a search, the larger one first
MOST = 9.0  # maximum loss of one row, in squared tolerances
NEAR = 0.05  # largest relative excess over the best loss for a value as good as the best


def row_loss(difference: float, tolerance: float) -> float:
    """Return a row's squared difference in tolerances, at most MOST; MOST if the row could not be measured."""
    if not np.isfinite(difference):
        return MOST
    return min((difference / max(tolerance, 0.01)) ** 2, MOST)


def best_of(factors: Sequence[float], losses: Sequence[float], near: float = NEAR) -> tuple[float, float, float]:
    """Return the factor with the least loss, and the range of connected factors that are nearly as good.

    Nearly as good means worse by a share `near` at most. Of equal losses, the factor nearest to 1 counts.
    """
    at = min(range(len(factors)), key=lambda k: (round(losses[k], 6), abs(factors[k] - 1.0)))
    good = np.asarray(losses) <= losses[at] * (1.0 + near) + 1e-12
    low = high = at
    while low > 0 and good[low - 1]:
        low -= 1
    while high < len(factors) - 1 and good[high + 1]:
        high += 1
    return factors[at], factors[low], factors[high]


def coordinate_search(loss: Callable[[list[float]], float], start: Sequence[float]) -> tuple[list[float], float]:
    """Minimize a loss from `start`, one number at a time, with decreasing factors; return the values and the loss."""
    values, least = list(start), loss(list(start))
    for step in SEARCHED:
        moved = True
        while moved:
            moved = False
            for k in range(len(values)):
                for factor in (1.0 + step, 1.0 / (1.0 + step)):
                    there = [*values[:k], factor * values[k], *values[k + 1 :]]
                    if (now := loss(there)) < least - 1e-9:
                        values, least, moved = there, now, True
                        break
    return values, least


def family_loss(name: str, effort: float) -> float:
    """Return the current loss of our simulator in a family, or in some of its parts such as "motion:slide_rows"."""
    from lab.grf.report import family_module

    name, _, parts = name.partition(":")
    module = family_module(name)
    for cached in vars(module).values():
        if hasattr(cached, "cache_clear"):
            cached.cache_clear()
    rows = [row for part in parts.split(",") for row in getattr(module, part)()] if parts else module.measure(effort)
    return float(np.mean([row_loss(row.difference, row.tolerance) for row in rows]))


def main(argv: Sequence[str]) -> int:
    """Run the script and return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("family")
    parser.add_argument("knobs", nargs="*", help="such as skills.saves.SAVE.body")
    parser.add_argument("--group", default="", help="of groups.py")
    parser.add_argument("--effort", type=float, default=1.0)
    parser.add_argument("--search", action="store_true", help="fit the numbers together, by coordinate search")
    parser.add_argument("--csv", type=Path, help="file to write the profiles to")
    typed = parser.parse_args(argv)
    with tempfile.TemporaryDirectory(prefix="regista-knobs-") as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        run(typed)
    return 0


def run(typed: argparse.Namespace) -> None:
    """Install the requested knobs, and profile them."""
    from lab.calibration.groups import group
    from lab.calibration.knobs import install, parse

    chosen = [parse(text) for text in [*typed.knobs, *(group(typed.group) if typed.group else [])]]
    install(chosen)
    if typed.search:
        print_search(typed.family, chosen, typed.effort)
    else:
        print_profiles(typed.family, chosen, typed.effort, typed.csv)


def print_search(family: str, chosen: Sequence, effort: float) -> None:
    """Fit all knobs together, starting from the shipped values; print both."""
    from lab.calibration.knobs import read, turn

    shipped = [read(each) for each in chosen]

    def loss(values: list[float]) -> float:
        for each, value in zip(chosen, values, strict=True):
            turn(each, value)
        return family_loss(family, effort)

    first = loss(shipped)
    fitted, least = coordinate_search(loss, shipped)
    print(f"family {family}: loss {first:.4f} as shipped, {least:.4f} fitted")
    for each, was, now in zip(chosen, shipped, fitted, strict=True):
        print(f"{each}: shipped {was:g}, fitted {now:.4g}")


def print_profiles(family: str, chosen: Sequence, effort: float, path: Path | None) -> None:
    """Profile each knob; print a line for it, and write all losses to a file."""
    from lab.calibration.knobs import read, turn

    now = family_loss(family, effort)
    print(f"family {family}: loss {now:.4f} as shipped", flush=True)
    rows = []
    for each in chosen:
        shipped = read(each)
        losses = [now if factor == 1.0 else turned(each, factor * shipped, family, effort) for factor in FACTORS]
        turn(each, shipped)
        best, low, high = best_of(FACTORS, losses)
        told = " ".join(f"{loss:.3f}" for loss in losses)
        print(f"{each} = {shipped:g}: best {best * shipped:.4g} ({low * shipped:.4g} to {high * shipped:.4g}); {told}")
        sys.stdout.flush()
        numbers = {f"{factor:g}": round(loss, 4) for factor, loss in zip(FACTORS, losses, strict=True)}
        rows.append({"family": family, "number": str(each), "shipped": shipped, **numbers})
        if path is not None:
            with path.open("w", newline="") as file:
                writer = csv.DictWriter(file, rows[0])
                writer.writeheader()
                writer.writerows(rows)


def turned(each: object, value: float, family: str, effort: float) -> float:
    """Return the loss of a family with another value of a knob."""
    from lab.calibration.knobs import turn

    turn(each, value)  # type: ignore[arg-type]
    return family_loss(family, effort)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
