"""An append-only CSV table that survives a kill: whole rows, flushed, cut back to the checkpoint on resume.

Read next: `run.folder`, whose metrics and levels are such tables.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run.errors import CommandError
from ued.core.files import write_whole
from ued.core.renamed import present_names

EXACT = "theta/"  # the beginning of the names of columns whose numbers are not cut
WORDS = ("source", "program", "event", "text")  # columns of a run's tables that hold no numbers


class Table:
    """Rows that belong to updates: the first column is `update`. Numbers are written so that they read back equal.

    The columns are those of the first row. A later row may leave some out; one with a column more widens the table,
    which rewrites the file once.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.columns: list[str] = read_header(path)

    def append(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows and flush them. Raises `CommandError` if the disk refuses; what was there stays."""
        rows = list(rows)
        new = [name for row in rows for name in row if name not in self.columns]
        if new:
            self._widen(list(dict.fromkeys(new)))
        self._write("".join(self._line(row) for row in rows))

    def _write(self, text: str) -> None:
        try:
            with open(self.path, "a", newline="") as file:
                file.write(text)
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def append_columns(self, columns: Mapping[str, np.ndarray]) -> None:
        """Add rows that are given by column, `[R]` each, and flush them.

        Real numbers are cut to 5 decimals, but for θ: a level is what its row says. Raises `CommandError` if the disk
        refuses, or where the table has other columns.
        """
        if self.columns and self.columns != list(columns):
            raise CommandError(f"{self.path} has the columns {', '.join(self.columns)}, and not {', '.join(columns)}")
        if not self.columns:
            self._widen(list(columns))
        cells = [_spell_all(values, 5 if not name.startswith(EXACT) else None) for name, values in columns.items()]
        self._write("".join(",".join(row) + "\n" for row in zip(*cells, strict=True)))

    def until(self, update: int) -> list[str]:
        """Return its lines without later updates, and without a last one that was cut off in the middle."""
        if not self.path.exists():
            return []
        header, lines = _lines(self.path)
        return [header, *(line for line, cells in lines if _number(cells[0]) <= update)]

    def keep_until(self, update: int) -> None:
        """Drop the rows of later updates, and a last one that was cut off in the middle."""
        self.replace(self.until(update))

    def _widen(self, names: list[str]) -> None:
        old = read_rows(self.path) if self.columns else []
        self.columns += names
        header = ",".join(map(_quote, self.columns)) + "\n"
        self.replace([header, *(self._line(row) for row in old)])

    def _line(self, row: Mapping[str, Any]) -> str:
        return ",".join(_quote(spell(row.get(name))) for name in self.columns) + "\n"

    def replace(self, lines: list[str]) -> None:
        """Replace the file in one step, so that a kill leaves either the old or the new one; by nothing, not at all."""
        if not lines:
            return
        try:
            write_whole(self.path, "".join(lines))
        except OSError as error:
            raise cannot_write(self.path, error) from error


def read_header(path: Path) -> list[str]:
    """Return the names of the columns, none if there is no table yet; old names as the present ones."""
    return present_names(next(csv.reader([_lines(path)[0]]), [])) if path.exists() else []


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the whole rows as text by column; a last row without its newline is left out."""
    if not path.exists():
        return []
    names = read_header(path)
    return [dict(zip(names, cells, strict=True)) for _, cells in _lines(path)[1]]


def _lines(path: Path) -> tuple[str, list[tuple[str, list[str]]]]:
    """Return the header and the whole lines of a table, each with its cells; a last one without its end is left out.

    Raises `CommandError` where it is damaged: what is no text, lines of other lengths, cells that are no numbers.
    """
    try:
        with open(path, newline="") as file:
            header, *lines = file.readlines() or [""]
        whole = [line for line in lines if line.endswith("\n")]
        rows = list(csv.reader(whole, strict=True))
        width = len(next(csv.reader([header], strict=True), []))
    except (ValueError, csv.Error) as error:
        raise CommandError(f"{path} is damaged: {error}") from error
    for number, cells in enumerate(rows, 2):
        if len(cells) != width or (header.startswith("update,") and not cells[0].isdecimal()):
            raise CommandError(f"{path} is damaged: line {number} is no row of {width} cells")
    return header, list(zip(whole, rows, strict=True))


def read_columns(path: Path) -> dict[str, np.ndarray]:
    """Return the columns as float64 arrays, NaN where a cell is empty; those of WORDS are left out."""
    rows, names = read_rows(path), [name for name in read_header(path) if name not in WORDS]
    try:
        return {name: np.array([_number(row[name]) for row in rows]) for name in names}
    except ValueError as error:
        raise CommandError(f"{path} is damaged: {error}") from error


def check_files(folder: Path) -> None:
    """Raise `CommandError` where a folder holds what would be read without end: a pipe, a device, a link to one."""
    for entry in folder.iterdir() if folder.is_dir() else ():
        if entry.exists() and not entry.is_file() and not entry.is_dir():
            raise CommandError(f"{entry} is damaged: it is no regular file")


def cannot_write(path: Path, error: Exception) -> CommandError:
    """Return the error of a file that cannot be written."""
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error).partition("\n")[0]
    return CommandError(f"cannot write {path}: {reason}")


def spell(value: Any) -> str:
    """Write a number so that it reads back equal; nothing for None and NaN."""
    if value is None or (isinstance(value, float | np.floating) and math.isnan(value)):
        return ""
    if isinstance(value, float | np.floating):
        return repr(float(value)).removesuffix(".0")
    return str(value)


def _spell_all(values: np.ndarray, decimals: int | None) -> list[str]:
    """Write numbers or words `[R]` as cells: real numbers with so many decimals at most, nothing for NaN."""
    if values.dtype.kind != "f":
        return [_quote(str(value)) for value in values.tolist()]
    numbers = values.astype(np.float64)
    rounded = (numbers if decimals is None else np.round(numbers, decimals)) + 0.0  # no negative zero
    return ["" if value != value else repr(value).removesuffix(".0") for value in rounded.tolist()]


def _number(text: str) -> float:
    return float(text) if text else math.nan


def _quote(text: str) -> str:
    return f'"{text}"' if "," in text or '"' in text else text
