"""The table of a run's levels as it grows: levels.csv, or with `--levels-format parquet` the folder levels.parquet.

Both hold the same numbers. A killed and resumed run has the same bytes as an uninterrupted one, since only the rows
determine them. `ued.levels.table` reads both. Read next: `run.folder`, which owns the table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.table import EXACT, Table, cannot_write, quoted, read_rows, rounded
from ued.core.columns import PARTS
from ued.core.files import write_whole
from ued.levels import table as tables
from ued.levels.table import CSV, PARQUET, WORDS, implied_by

if TYPE_CHECKING:
    import pyarrow as pa

Format = Literal["csv", "parquet"]
PART_ROWS = 20_000  # per file of levels.parquet
WHOLE = dict.fromkeys(("update", "id", "visit", "parent", "episodes"), "int64") | {"seed": "uint64"}
DELTAS = ("id", "visit")  # nearly sorted columns, stored as differences


def read_levels(run: Path, *names: str, rows: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Return columns as `ued.levels.table.read_levels` does; none without a table.

    Raises `CommandError` for a damaged table, and for levels.parquet without PyArrow.
    """
    try:
        return tables.read_levels(run, *names, rows=rows)
    except FileNotFoundError:
        return {}
    except ValueError as error:
        raise CommandError(str(error)) from error


def open_levels(folder: Path, form: Format) -> CsvLevels | ParquetLevels:
    """Return the table of a run folder in this format."""
    return CsvLevels(folder / CSV) if form == "csv" else ParquetLevels(folder / PARQUET)


class CsvLevels(Table):
    """levels.csv: rows are on disk as soon as they are appended.

    A column that follows from others, see `implied_by`, is omitted until a row differs; then the file is rewritten.
    """

    def append_levels(self, columns: Mapping[str, np.ndarray]) -> None:
        """Append rows given by column, `[R]` each. Raises `CommandError` as `append_columns` does."""
        names = [name for name in columns if name in self.columns or not _follows(name, columns)]
        new = [name for name in names if name not in self.columns]
        if self.columns and new and all(implied_by(name) is not None for name in new):
            self._add(names)
        self.append_columns({name: columns[name] for name in names})

    def flush(self) -> None:
        """Do nothing: all rows are on disk."""

    def _add(self, names: Sequence[str]) -> None:
        """Rewrite the file with these columns, a superset of its own."""
        if not set(self.columns) <= set(names):
            return  # `append_columns` rejects them
        rows, self.columns = read_rows(self.path), list(names)
        self.replace([",".join(map(quoted, names)) + "\n", *(self._line(row | _implied(row, names)) for row in rows)])


class ParquetLevels:
    """levels.parquet: a folder of files of `PART_ROWS` rows; only the last one has fewer.

    Rows are on disk after `flush`, which comes before each checkpoint. A full file is not written again.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.columns: list[str] = []
        self._full = 0  # number of full files
        self._rows: list[pa.Table] = []  # rows of the last file, which is not full
        self._changed = False
        self._begun = False

    def append_levels(self, columns: Mapping[str, np.ndarray]) -> None:
        """Append rows given by column, `[R]` each. Raises `CommandError` for other columns than those of the table."""
        import pyarrow as pa

        if not self._begun:
            self._begin()
        if self.columns and self.columns != list(columns):
            raise CommandError(f"{self.path} has the columns {', '.join(self.columns)}, expected {', '.join(columns)}")
        self.columns, self._changed = list(columns), True
        self._rows.append(pa.table({name: _arrow(name, values) for name, values in columns.items()}))
        if sum(map(len, self._rows)) >= PART_ROWS:
            self.flush()

    def flush(self) -> None:
        """Write the rows that are not on disk. Raises `CommandError` if they cannot be written."""
        import pyarrow as pa

        if not self._changed:
            return
        rows = pa.concat_tables(self._rows).combine_chunks()
        while len(rows) >= PART_ROWS:
            self._write(self._full, rows[:PART_ROWS])
            rows, self._full = rows[PART_ROWS:], self._full + 1
        if len(rows):
            self._write(self._full, rows)
        self._rows, self._changed = [rows], False

    def until(self, update: int) -> list[tuple[Path, pa.Table | None]]:
        """Return the changes that cut the table back to an update: the rows of each file, or None, last file first.

        A run calls this before `replace`. Raises `CommandError` for a damaged file, and without PyArrow.
        """
        if not find_spec("pyarrow"):
            raise CommandError("--levels-format parquet needs pyarrow: pip install 'regista[all]'")
        cuts: list[tuple[Path, pa.Table | None]] = []
        for path in reversed(self._parts()):
            rows = _read_part(path)
            kept = rows.filter(np.asarray(rows["update"]) <= update)
            if len(kept) == len(rows):
                break
            cuts.append((path, kept if len(kept) else None))
        return cuts

    def replace(self, cuts: Sequence[tuple[Path, pa.Table | None]]) -> None:
        """Cut the table back, see `until`. A kill during this call may leave rows beyond the update."""
        try:
            for path, rows in cuts:
                path.unlink() if rows is None else write_whole(path, _encoded(rows))
        except OSError as error:
            raise cannot_write(self.path, error) from error
        self._begin()

    def _begin(self) -> None:
        """Continue after the files on disk, the last of which may not be full."""
        parts = self._parts()
        last = _read_part(parts[-1]) if parts else None
        self.columns = last.column_names if last is not None else []
        self._full, self._rows = len(parts), []
        self._begun, self._changed = True, False
        if last is not None and len(last) < PART_ROWS:
            self._full, self._rows = len(parts) - 1, [last]

    def _parts(self) -> list[Path]:
        """Return the files in their order. Raises `CommandError` if one is missing."""
        parts = sorted(self.path.glob(PARTS))
        for number, path in enumerate(parts):
            if path != self._part(number):
                raise CommandError(f"{self.path} is damaged: {self._part(number).name} is missing")
        return parts

    def _part(self, number: int) -> Path:
        return self.path / f"part-{number:05d}.parquet"

    def _write(self, number: int, rows: pa.Table) -> None:
        try:
            self.path.mkdir(exist_ok=True)
            write_whole(self._part(number), _encoded(rows))
        except OSError as error:
            raise cannot_write(self.path, error) from error


def _follows(name: str, columns: Mapping[str, np.ndarray]) -> bool:
    """Return whether all values of a column follow from other columns by `implied_by`."""
    source = implied_by(name)
    if source is None:
        return False
    values = columns[source] if isinstance(source, str) else np.full(len(columns[name]), source)
    return np.array_equal(columns[name], values, equal_nan=columns[name].dtype.kind == "f")


def _implied(row: Mapping[str, str], names: Sequence[str]) -> dict[str, Any]:
    """Return the cells that a row of levels.csv omits."""
    sources = {name: implied_by(name) for name in names if name not in row}
    return {name: row[source] if isinstance(source, str) else source for name, source in sources.items()}


def _arrow(name: str, values: np.ndarray) -> pa.Array:
    """Return a column of levels.parquet: integers, text, or numbers as in levels.csv; null for nan."""
    import pyarrow as pa

    if name in WORDS:
        return pa.array(values.tolist(), pa.string())
    if name in WHOLE:
        return pa.array(values, from_pandas=True).cast(WHOLE[name])
    return pa.array(rounded(name, values), pa.float64(), from_pandas=True)


def _encoded(rows: pa.Table) -> bytes:
    """Return the bytes of a Parquet file with one row group.

    θ is split into streams of its bytes, which compress better (the format's BYTE_STREAM_SPLIT).
    """
    from pyarrow import parquet

    split = [name for name in rows.column_names if name.startswith(EXACT) or name == "seed"]
    encodings = dict.fromkeys(split, "BYTE_STREAM_SPLIT") | dict.fromkeys(DELTAS, "DELTA_BINARY_PACKED")
    file = BytesIO()
    parquet.write_table(
        rows.combine_chunks(),
        file,
        row_group_size=PART_ROWS,
        compression="zstd",
        use_dictionary=[name for name in rows.column_names if name not in encodings],
        column_encoding={name: encoding for name, encoding in encodings.items() if name in rows.column_names},
    )
    return file.getvalue()


def _read_part(path: Path) -> pa.Table:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with parquet.ParquetFile(path) as file:
            return file.read(use_threads=False)
    except (pa.ArrowException, OSError) as error:
        reason = str(error).partition("\n")[0]
        raise CommandError(f"{path} is damaged: {reason}") from error
