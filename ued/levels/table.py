"""Read the table of a run's levels: levels.csv, or levels.parquet, a folder of Parquet files.

All code of the repository reads tables with this module, which supports both forms and tables of older runs. Read next:
`levels.batch`, the columns; `core.columns`, which reads files.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ued.core.columns import Columns, read_csv, read_parts
from ued.core.level_space import level_dtype

CSV, PARQUET = "levels.csv", "levels.parquet"
WORDS = ("source", "program")  # columns of text
IMPLIED: dict[str, str | float] = {"visit": "id", "parent": np.nan, "episodes": 1.0}  # see `implied_by`
OF_IMPLIED = ("id", "parent")  # columns that `with_implied` needs: the number of rows, and the age of the table


def table_of(run: str | Path) -> Path:
    """Return the path of the table in a run folder, levels.csv if there is none yet; other paths are returned as is."""
    path = Path(run)
    if path.name in (CSV, PARQUET) or not path.is_dir():
        return path
    return path / PARQUET if (path / PARQUET).exists() else path / CSV


def implied_by(name: str) -> str | float | None:
    """Return the values of a column that levels.csv omits: the name of another column, or a number in all rows.

    None: the column is never omitted, because no other column has its values.
    """
    if name.startswith("best/"):
        return f"return/{name.removeprefix('best/')}"  # after one episode
    return IMPLIED.get(name)


def read_levels(run: str | Path, *names: str, rows: np.ndarray | None = None) -> Columns:
    """Return columns of the table of a run's levels, `[R]` each, including those that levels.csv omits.

    Args:
        run: the folder of a run, or the path of its levels.csv or levels.parquet.
        names: the columns to read; `"theta/"` selects all that begin with it. None: all. Columns that the table does
            not have are missing in the result.
        rows: indices of the rows to return `[R]`, ascending; None: all. Other rows of levels.parquet are not kept in
            memory.

    Numbers are float64, nan where not available; `source` and `program` are strings.

    Raises:
        FileNotFoundError: without a table.
        ValueError: a damaged table.
        ModuleNotFoundError: levels.parquet without PyArrow.
    """
    path = table_of(run)
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist: no update has finished yet")
    sources = [implied_by(name) for name in names]
    also = [source for source in sources if isinstance(source, str)]
    if any(source is not None for source in sources):
        also += OF_IMPLIED

    def wanted(name: str) -> bool:
        return not names or _matches(name, [*names, *also])

    if path.is_dir():
        found = read_parts(path, wanted, rows)
    else:
        found = read_csv(path, wanted, WORDS)
        found = found if rows is None else {name: values[rows] for name, values in found.items()}
    columns = with_implied(found)
    return {name: values for name, values in columns.items() if not names or _matches(name, names)}


def with_implied(columns: Columns) -> Columns:
    """Return the columns of a table, including those that it omits.

    A table with `parent` but without `visit` was written by an older version, which does not number visits.
    """
    if "id" not in columns:
        return columns
    best = [f"best/{name.removeprefix('return/')}" for name in columns if name.startswith("return/")]
    missing = {}
    for name in (*IMPLIED, *best):
        if name in columns or (name == "visit" and "parent" in columns):
            continue
        source: Any = implied_by(name)
        missing[name] = columns[source] if isinstance(source, str) else np.full(len(columns["id"]), source)
    return columns | missing


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(name == each or (each[-1] == "/" and name.startswith(each)) for each in patterns)


def read_level(run: str | Path, id: int, visit: int | None = None) -> np.ndarray:
    """Return a level of a run as a record `[1]` of `level_dtype(D)`, for `UPOMDP.reset_to_levels`.

    Args:
        run: the folder of a run, or the path of its levels.csv or levels.parquet.
        id: the number of the level.
        visit: the number of a visit of the level; None: any visit, since all have the same level.

    In a mixture of programs, θ determines the program.

    Raises:
        FileNotFoundError: without such a table.
        KeyError: a level that is not in it.
        ValueError: a damaged row.
    """
    return read_visit(run, id, visit)[0]


def read_visit(run: str | Path, id: int, visit: int | None = None) -> tuple[np.ndarray, int]:
    """Return a level, see `read_level`, and the number of the visit; None: the first visit in the table."""
    path = table_of(run)
    columns = read_levels(path, "id", "visit", "seed", "theta/")
    for name in ("id", "visit", "seed"):
        if name not in columns:
            raise ValueError(f"{path} is damaged: it has no column {name}")
    rows = np.flatnonzero((columns["id"] == id) & (visit is None or columns["visit"] == visit))
    if not len(rows):
        at = "" if visit is None else f" at visit {visit}"
        raise KeyError(f"{path} has no level {id}{at}; see its column id for the levels that were played")
    row = {name: values[rows[0]] for name, values in columns.items()}
    names = [name for name in row if name.startswith("theta/")]
    level = np.zeros(1, level_dtype(len(names)))
    level["theta"] = [row[name] for name in names]
    if np.isnan(level["theta"]).any():
        raise ValueError(f"{path} is damaged: θ of level {id} must be {len(names)} numbers")
    level["seed"] = _whole(row["seed"], "seed", path)
    return level, _whole(row["visit"], "visit", path)


def _whole(value: float, name: str, path: Path) -> int:
    if not (value >= 0 and float(value).is_integer()):
        raise ValueError(f"{path} is damaged: {name} must be an integer, got {value}")
    return int(value)
