"""An append-only CSV table that survives a kill: whole rows, flushed, cut back to the checkpoint on resume.

Read next: `run.folder`, which holds several such tables; `run.level_table`, that of levels.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run.errors import CommandError, UsageError
from ued.core.columns import read_csv
from ued.core.files import write_whole
from ued.core.renamed import present_names

DECIMALS = 5  # of floats in `append_columns`, except θ
EXACT = "theta/"  # prefix of columns whose numbers are not rounded
WORDS = ("source", "program", "event", "text")  # text columns of a run's tables


class Table:
    """Rows of updates: the first column is `update`. `append` writes numbers without loss.

    The first row determines the columns. Later rows may omit some; a row with a new column rewrites the file once.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.columns: list[str] = read_header(path)

    def append(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Append rows and flush them. Raises `CommandError` if the file cannot be written; existing rows stay."""
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
        """Append rows given by column, `[R]` each, and flush them.

        Floats are rounded to 5 decimals, except θ, which must reproduce the level. Raises `CommandError` if the file
        cannot be written, or for other columns than those of the table.
        """
        if self.columns and self.columns != list(columns):
            raise CommandError(f"{self.path} has the columns {', '.join(self.columns)}, expected {', '.join(columns)}")
        if not self.columns:
            self._widen(list(columns))
        cells = [_spell_all(rounded(name, values)) for name, values in columns.items()]
        self._write("".join(",".join(row) + "\n" for row in zip(*cells, strict=True)))

    def until(self, update: int) -> list[str]:
        """Return the lines up to an update, without an incomplete last line."""
        if not self.path.exists():
            return []
        header, lines = _lines(self.path)
        return [header, *(line for line, cells in lines if _number(cells[0]) <= update)]

    def _widen(self, names: list[str]) -> None:
        old = read_rows(self.path) if self.columns else []
        self.columns += names
        header = ",".join(map(quoted, self.columns)) + "\n"
        self.replace([header, *(self._line(row) for row in old)])

    def _line(self, row: Mapping[str, Any]) -> str:
        return ",".join(quoted(spell(row.get(name))) for name in self.columns) + "\n"

    def replace(self, lines: list[str]) -> None:
        """Replace the file atomically: after a kill, the old or the new one exists. Without lines, do nothing."""
        if not lines:
            return
        try:
            write_whole(self.path, "".join(lines))
        except OSError as error:
            raise cannot_write(self.path, error) from error


def read_header(path: Path) -> list[str]:
    """Return the names of the columns, empty without a file; old names are converted to current ones."""
    return present_names(next(csv.reader([_lines(path)[0]]), [])) if path.exists() else []


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the complete rows as text by column; a last row without its newline is skipped."""
    if not path.exists():
        return []
    header, lines = _lines(path)
    names = present_names(next(csv.reader([header]), []))
    return [dict(zip(names, cells, strict=True)) for _, cells in lines]


def _lines(path: Path) -> tuple[str, list[tuple[str, list[str]]]]:
    """Return the header and the complete lines of a table, each with its cells; an incomplete last line is skipped.

    Raises `CommandError` for a damaged table: not text, wrong number of cells, or cells that are not numbers.
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
            raise CommandError(f"{path} is damaged: line {number} is not a row of {width} cells")
    return header, list(zip(whole, rows, strict=True))


def read_columns(path: Path) -> dict[str, np.ndarray]:
    """Return the columns as float64 arrays, NaN for empty cells; columns in WORDS are skipped.

    Without a file there are none. Raises `CommandError` for a damaged file.
    """
    if not path.exists():
        return {}
    try:
        return read_csv(path, lambda name: name not in WORDS)
    except ValueError as error:
        raise CommandError(str(error)) from error


def check_files(folder: Path) -> None:
    """Raise `CommandError` if a folder holds a pipe or a device, since reading one might block forever."""
    for entry in folder.iterdir() if folder.is_dir() else ():
        if entry.exists() and not entry.is_file() and not entry.is_dir():
            raise CommandError(f"{entry} is damaged: it is not a regular file")


def check_file(path: Path) -> None:
    """Raise `UsageError` if a file cannot be written to this path, before its content is computed."""
    if not path.absolute().parent.is_dir():
        raise UsageError(f"{path}: the folder {path.parent} does not exist")
    if path.is_dir():
        raise UsageError(f"{path} is a folder; give the name of a file")


def cannot_write(path: Path, error: Exception) -> CommandError:
    """Return the error of a file that cannot be written."""
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error).partition("\n")[0]
    return CommandError(f"cannot write {path}: {reason}")


def spell(value: Any) -> str:
    """Format a number without loss; empty for None and NaN."""
    if value is None or (isinstance(value, float | np.floating) and math.isnan(value)):
        return ""
    if isinstance(value, float | np.floating):
        return repr(float(value)).removesuffix(".0")
    return str(value)


def rounded(name: str, values: np.ndarray) -> np.ndarray:
    """Round the floats `[R]` of a column to DECIMALS, except θ; -0 becomes 0."""
    if values.dtype.kind != "f":
        return values
    numbers = values.astype(np.float64)
    return (numbers if name.startswith(EXACT) else np.round(numbers, DECIMALS)) + 0.0


def _spell_all(values: np.ndarray) -> list[str]:
    """Format numbers or text `[R]` as cells; empty for NaN."""
    if values.dtype.kind != "f":
        return [quoted(str(value)) for value in values.tolist()]
    return ["" if value != value else repr(value).removesuffix(".0") for value in values.tolist()]


def _number(text: str) -> float:
    return float(text) if text else math.nan


def quoted(text: str) -> str:
    """Return a cell, in quotes if it needs them."""
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text
