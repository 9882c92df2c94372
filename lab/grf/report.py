"""Run and print the families of comparisons: one table each, and a last line with the count within tolerance.

A family is a module of this package with `TITLE`, `REQUIRED` (the share of its rows that should be within tolerance),
`measure(effort) -> list[Row]` and `figure(path, effort)`. Read next: a family.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType

from lab.grf.rows import Row
from regista.experiments.run.results import align
from regista.experiments.run.table import cannot_write

DATA = Path(__file__).parent / "data"
FAMILIES = (
    "motion",
    "ball",
    "passes",
    "shots",
    "keeper",
    "tackles",
    "blocks",
    "chases",
    "academy",
    "matches",
    "players",
)


def family_module(name: str) -> ModuleType:
    """Import the module of a family."""
    return import_module(f"lab.grf.{name}")


def compare(name: str, effort: float = 1.0) -> list[Row]:
    """Measure a family; `effort` below 1 repeats random measurements less often."""
    return family_module(name).measure(effort)


def draw(name: str, folder: Path, effort: float = 1.0) -> None:
    """Draw a family's curves, ours and GRF's, to `folder`/`name`.png. Raises CommandError if writing fails."""
    path = folder / f"{name}.png"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        family_module(name).figure(path, effort)
    except OSError as error:
        raise cannot_write(path, error) from error


def render_family(name: str, rows: Sequence[Row]) -> str:
    """Return a family as a table."""
    module = family_module(name)
    return render_rows(module.TITLE, rows, module.REQUIRED)


def render_rows(title: str, rows: Sequence[Row], required: float) -> str:
    """Return comparisons as a table; `required` is the share that must be within tolerance."""
    lines = [[title, "     ours", "      GRF", "unit", "difference", "tolerance", "verdict"]]
    for row in rows:
        numbers = [_spell(number).rjust(9) for number in (row.ours, row.grf)]
        differences = [_spell(number).rjust(9) for number in (row.difference, row.tolerance)]
        lines.append([row.name, *numbers, row.unit, *differences, "ok" if row.ok else "MISSES"])
    least = math.ceil(required * len(rows) - 1e-9)
    return f"{align(lines)}\n{sum(row.ok for row in rows)} of {len(rows)} within tolerance (wanted {least})"


def read_data(name: str) -> list[dict[str, str]]:
    """Read GRF's numbers from `data/NAME.csv`: rows by column; lines that begin with # are comments."""
    text = (DATA / f"{name}.csv").read_text()
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def _spell(number: float) -> str:
    return f"{number:.4f}" if abs(number) < 1.0 else f"{number:.2f}"
