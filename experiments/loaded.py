"""Results as data: the tables of a run or of a comparison as DataFrames, their curves as a figure.

    run = regista.load_run("runs/paired")
    run.metrics().plot("env_steps", "success")

docs/files.md lists the columns. Read next: `run.folder`, the files; `calls`, which writes them.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.pictures import curves, plots
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.progress import counted
from regista.experiments.run.results import BASELINE, unique
from regista.experiments.run.run_folders import check_comparable, open_runs
from regista.experiments.run.table import read_columns, read_header, read_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True)
class RunData:
    """A run: its settings and tables.

    Attributes:
        path: the run folder.
        config: all settings, such as `config.method` and `config.ppo.learning_rate`.
        name: the label of the run in tables: its method, or the name of its variant.
    """

    path: Path
    config: Any
    name: str

    def __repr__(self) -> str:
        """Return folder, name and seed, without the long settings."""
        return f"RunData({str(self.path)!r}, {self.name}, seed {self.config.seed})"

    def columns(self, table: str = "metrics") -> dict[str, np.ndarray]:
        """Return the columns of a table as arrays; pandas is not required.

        Args:
            table: `metrics` or `levels`.

        Returns:
            arrays `[rows]`: float64, NaN where not available; `source` and `program` of levels are text. A table
            without rows is empty.

        Raises:
            UsageError: an unknown table name.
            CommandError: a damaged table.
        """
        from ued.levels.table import read_levels

        if table not in ("metrics", "levels"):
            raise UsageError(f"the table must be metrics or levels, got {table!r}")
        if table == "metrics":
            return read_columns(self.path / "metrics.csv")
        try:
            return dict(read_levels(self.path))
        except FileNotFoundError:
            return {}
        except ValueError as error:
            raise CommandError(str(error)) from error

    def metrics(self) -> DataFrame:
        """Return metrics.csv, one row per update.

        Raises:
            CommandError: without pandas.
        """
        return _pandas().DataFrame(self.columns("metrics"))

    def levels(self) -> DataFrame:
        """Return the table of levels, one row per visit of a level.

        Raises:
            CommandError: without pandas.
        """
        return _pandas().DataFrame(self.columns("levels"))

    def events(self) -> DataFrame:
        """Return events.csv, one row per warning; empty without warnings.

        Raises:
            CommandError: without pandas.
        """
        frame = _pandas().DataFrame(
            read_rows(self.path / "events.csv"), columns=["update", "env_steps", "event", "text"]
        )
        return frame.astype({"update": float, "env_steps": float})

    def figure(self) -> Figure:
        """Return the learning curves.

        Raises:
            CommandError: without a finished update.
        """
        return _figure({self.name: [self.path]})


@dataclass(frozen=True)
class ComparisonData:
    """The runs and tables of a comparison, or of another folder of runs.

    Attributes:
        path: the folder.
        runs: all runs that have a checkpoint, by method and seed; methods in the order of the comparison.
    """

    path: Path
    runs: tuple[RunData, ...]

    def __repr__(self) -> str:
        """Return the folder, and the number of runs of each method."""
        names = Counter(run.name for run in self.runs)
        runs = ", ".join(f"{name}: {counted(n, 'run')}" for name, n in names.items())
        return f"ComparisonData({str(self.path)!r}, {runs})"

    def metrics(self) -> DataFrame:
        """Return the metrics of all runs in one table, after the columns `method` and `run_seed`."""
        return self._joined("metrics")

    def levels(self) -> DataFrame:
        """Return the levels of all runs in one table, after the columns `method` and `run_seed`."""
        return self._joined("levels")

    def results(self) -> DataFrame:
        """Return results.csv: one row per run and test scene.

        Raises:
            CommandError: before the evaluation.
        """
        return self._written("results.csv")

    def table(self) -> DataFrame:
        """Return table.csv: every number of the tables, with intervals.

        Raises:
            CommandError: before the evaluation.
        """
        return self._written("table.csv")

    def figure(self) -> Figure:
        """Return the learning curves of all methods.

        Raises:
            CommandError: without a finished update.
        """
        paths: dict[str, list[Path]] = {}
        for run in self.runs:
            paths.setdefault(run.name, []).append(run.path)
        self._distinguish()
        return _figure(paths)

    def colors(self) -> dict[str, str]:
        """Return the color of each method, variant and baseline in all figures, by its name in the tables."""
        self._distinguish()
        runs = [run.name for run in self.runs]
        baselines = [name + BASELINE * (name in runs) for name in plots.BASELINES]
        return {name: plots.color(name) for name in [*runs, *baselines]}

    def _distinguish(self) -> None:
        from ued.methods import METHODS

        plots.distinguish({run.name: run.config.method for run in self.runs if run.name not in METHODS})

    def _joined(self, table: str) -> DataFrame:
        pandas = _pandas()
        frames = [pandas.DataFrame(run.columns(table)) for run in self.runs]
        for run, frame in zip(self.runs, frames, strict=True):
            frame.insert(0, "method", run.name)
            frame.insert(1, "run_seed", run.config.seed)
        return pandas.concat(frames, ignore_index=True)

    def _written(self, name: str) -> DataFrame:
        file = self.path / name
        if not file.is_file():
            raise CommandError(f"{file} does not exist: regista compare writes it after all runs are evaluated")
        text = dict.fromkeys(("method", "scene", "simulator"), str)
        empty = {column: [""] if column not in text else [] for column in read_header(file)}
        return _pandas().read_csv(file, dtype=text, keep_default_na=False, na_values=empty)


def load_run(path: str | Path) -> RunData:
    """Return the settings and tables of a run folder.

    Raises:
        ValueError: the argument is not a path.
        CommandError: a folder without a run.
    """
    run = RunFolder.open(as_path("path", path))
    return RunData(run.path, run.config, run.name)


def load_comparison(path: str | Path) -> ComparisonData:
    """Return the runs and tables in the folder of `regista compare`, or in another folder of runs.

    Like `evaluate`, it warns of runs of one method with different settings.

    Raises:
        ValueError: the argument is not a path.
        CommandError: no runs in the folder, no run with a checkpoint, or runs of several games.
    """
    folder = as_path("path", path)
    runs = open_runs([folder])
    check_comparable(runs, "load")
    table = folder / "results.csv"
    order = unique([row["method"] for row in read_rows(table)]) if table.is_file() else []
    runs.sort(key=lambda run: order.index(run.name) if run.name in order else len(order))  # keeps the order of seeds
    return ComparisonData(folder, tuple(RunData(run.path, run.config, run.name) for run in runs))


def as_path(name: str, value: Any) -> Path:
    """Return an argument as a path. Raises `ValueError` for another type."""
    if not isinstance(value, str | os.PathLike):
        raise ValueError(f"{name} must be a path, such as 'runs/plr', got {value!r:.100}")
    return Path(value)


def _figure(paths: Mapping[str, list[Path]]) -> Figure:
    try:
        figure = curves.learning_figure(paths)
    except ModuleNotFoundError as error:
        raise CommandError("figures need matplotlib: pip install 'regista[pictures]'") from error
    if figure is None:
        raise CommandError("there are no learning curves: no update has finished yet")
    return figure


def _pandas() -> Any:
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise CommandError(
            "DataFrames need pandas: pip install 'regista[data]'; `load_run(path).columns()` returns NumPy arrays"
        ) from error
    return pandas
