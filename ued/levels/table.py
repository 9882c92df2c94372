"""Levels from levels.csv, the table of a run: a row is a level that was played, written so that it reads back equal.

Read next: `levels.batch`, what is in a row.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from ued.core.level_space import level_dtype


def read_level(run: str | Path, id: int, turn: int | None = None) -> np.ndarray:
    """Return a level of a run as a record `[1]` of `level_dtype(D)`, as `UPOMDP.reset_to_levels` takes it.

    Args:
        run: the folder of a run, or the path of its levels.csv.
        id: the number of the level.
        turn: the number of a visit of it; None: any, for the level is the same at each.

    Of a mixture of programs, θ says which program it is. Raises `FileNotFoundError` where there is no such table,
    `KeyError` for a level that is not in it, `ValueError` for a row that is damaged.
    """
    return read_visit(run, id, turn)[0]


def read_visit(run: str | Path, id: int, turn: int | None = None) -> tuple[np.ndarray, int]:
    """Return a level as `read_level` does, and the number of the visit; for None the first one in the table."""
    path = Path(run)
    path = path / "levels.csv" if path.is_dir() else path
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row.get("id") == str(id) and turn in (None, _whole(row, "turn", path)):
                return _level(row, path), _whole(row, "turn", path)
    visit = "" if turn is None else f" at visit {turn}"
    raise KeyError(f"{path} has no level {id}{visit}; its columns id and turn have those that were played")


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
