"""Read levels from levels.csv, the table of a run, whose rows hold played levels at full precision.

Read next: `levels.batch`, the columns.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from ued.core.level_space import level_dtype
from ued.core.renamed import present_keys


def read_level(run: str | Path, id: int, visit: int | None = None) -> np.ndarray:
    """Return a level of a run as a record `[1]` of `level_dtype(D)`, for `UPOMDP.reset_to_levels`.

    Args:
        run: the folder of a run, or the path of its levels.csv.
        id: the number of the level.
        visit: the number of a visit of it; None: any, since all visits have the same level.

    In a mixture of programs, θ determines the program. Raises `FileNotFoundError` without such a table, `KeyError` for
    a level that is not in it, `ValueError` for a damaged row.
    """
    return read_visit(run, id, visit)[0]


def read_visit(run: str | Path, id: int, visit: int | None = None) -> tuple[np.ndarray, int]:
    """Return a level, see `read_level`, and the number of the visit; for None the first one in the table."""
    path = Path(run)
    path = path / "levels.csv" if path.is_dir() else path
    with open(path, newline="", encoding="utf-8") as file:
        for row in map(present_keys, csv.DictReader(file)):
            if row.get("id") == str(id) and visit in (None, _whole(row, "visit", path)):
                return _level(row, path), _whole(row, "visit", path)
    at = "" if visit is None else f" at visit {visit}"
    raise KeyError(f"{path} has no level {id}{at}; see its column id for the levels that were played")


def _level(row: dict[str, Any], path: Path) -> np.ndarray:
    names = [name for name in row if name and name.startswith("theta/")]
    level = np.zeros(1, level_dtype(len(names)))
    level["seed"] = _whole(row, "seed", path)
    try:
        level["theta"] = [float(row[name]) for name in names]
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} is damaged: θ of level {row['id']} must be {len(names)} numbers") from error
    return level


def _whole(row: dict[str, Any], name: str, path: Path) -> int:
    try:
        return int(row[name])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path} is damaged: {name} must be a whole number, got {row.get(name)!r}") from error
