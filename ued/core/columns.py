"""Tables on disk as numpy arrays by column: CSV files, and folders of Parquet files.

If PyArrow is installed, it reads them several times faster; CSV files can be read without it. Read next:
`core.renamed`, the old names of columns; `levels.table`, the levels of a run.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Collection
from importlib.util import find_spec
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from ued.core.renamed import present_names

Columns = dict[str, np.ndarray]
Wanted = Callable[[str], bool]
LARGE = 200_000  # bytes; in larger files PyArrow saves more time than its import takes
PARTS = "part-*.parquet"


def every(name: str) -> bool:
    """Return True: all columns are wanted."""
    return True


def read_csv(path: Path, wanted: Wanted = every, words: Collection[str] = ()) -> Columns:
    """Return the wanted columns of a CSV file, `[R]` each, by their current names.

    Numbers are float64, nan for empty cells; the columns in `words` are strings. A last line without its newline is
    skipped. Raises `ValueError` for a damaged file: not text, a wrong number of cells, cells that are not numbers.
    """
    data = path.read_bytes()
    data = data[: data.rfind(b"\n") + 1]
    try:
        if b"\n\n" in data:
            raise ValueError("it has an empty line")
        head = data[: data.find(b"\n") + 1]
        names = present_names(next(csv.reader([head.decode()], strict=True), []))
        columns = {name: at for at, name in enumerate(names) if wanted(name)}
        read = _by_arrow if len(data) > LARGE and find_spec("pyarrow") else _by_rows
        return read(data, len(head), len(names), columns, words)
    except (ValueError, csv.Error) as error:  # errors of PyArrow are ValueErrors
        reason = str(error).partition("\n")[0]
        raise ValueError(f"{path} is damaged: {reason}") from error


def _by_arrow(data: bytes, begin: int, width: int, columns: dict[str, int], words: Collection[str]) -> Columns:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    kinds = {str(at): pa.string() if name in words else pa.float64() for name, at in columns.items()}
    if not kinds or begin == len(data):
        return _by_rows(data, begin, width, columns, words)
    try:
        table = arrow_csv.read_csv(
            pa.BufferReader(memoryview(data)[begin:]),
            arrow_csv.ReadOptions(use_threads=False, column_names=[str(at) for at in range(width)]),
            arrow_csv.ParseOptions(ignore_empty_lines=False),
            arrow_csv.ConvertOptions(column_types=kinds, include_columns=list(kinds), null_values=["", "nan"]),
        )
    except pa.ArrowInvalid:  # its message names neither line nor column
        _by_rows(data, begin, width, columns, words)
        raise
    return {name: _plain(table[str(at)]) for name, at in columns.items()}


def _by_rows(data: bytes, begin: int, width: int, columns: dict[str, int], words: Collection[str]) -> Columns:
    rows = list(csv.reader(io.StringIO(data[begin:].decode(), newline=""), strict=True))
    for number, row in enumerate(rows, 2):
        if len(row) != width:
            raise ValueError(f"line {number} is not a row of {width} cells")
    return {name: _column(name, [row[at] for row in rows], name in words) for name, at in columns.items()}


def _column(name: str, cells: list[str], is_text: bool) -> np.ndarray:
    if is_text:
        return np.array(cells, str)
    values = np.empty(len(cells))
    for at, cell in enumerate(cells):
        try:
            values[at] = float(cell or nan)
        except ValueError:
            raise ValueError(f"line {at + 2}, column {name}: {cell!r} is not a number") from None
    return values


def read_parts(folder: Path, wanted: Wanted = every, rows: np.ndarray | None = None) -> Columns:
    """Return the wanted columns of the Parquet files `part-*.parquet` of a folder, in the order of their names.

    Args:
        folder: the folder of the files.
        wanted: whether a column is read.
        rows: indices of the rows to return `[R]`, ascending; None: all. Only these rows and one file are in memory.

    Types as in `read_csv`. Raises `ValueError` for a damaged file, `ModuleNotFoundError` without PyArrow.
    """
    import pyarrow as pa
    from pyarrow import parquet

    tables: list[pa.Table] = []
    begin = 0  # the first row of a file
    for path in sorted(folder.glob(PARTS)):
        try:
            with parquet.ParquetFile(path) as file:
                names = [name for name in file.schema_arrow.names if wanted(name)]
                end = begin + file.metadata.num_rows
                if rows is None:
                    tables.append(file.read(columns=names, use_threads=False))
                elif len(mine := rows[(rows >= begin) & (rows < end)]) or not tables:
                    tables.append(file.read(columns=names, use_threads=False).take(mine - begin))
                begin = end
        except (pa.ArrowException, OSError, KeyError) as error:
            reason = str(error).partition("\n")[0]
            raise ValueError(f"{path} is damaged: {reason}") from error
    if not tables:
        return {}
    try:
        table = pa.concat_tables(tables)
    except pa.ArrowException as error:
        raise ValueError(f"{folder} is damaged: its parts have different columns") from error
    return {name: _plain(table[name]) for name in table.column_names}


def _plain(column: Any) -> np.ndarray:
    """Return an Arrow column as float64, nan for null, or as strings."""
    values = column.to_numpy()
    return values.astype(str if values.dtype == object else np.float64, copy=False)
