"""Results of a comparison as tables: text for a terminal, Markdown, CSV.

The first table has a row for each method and a column for each scene. The second aggregates over scenes, by mean and
IQM, and reports the success rate on the worst of random levels. Methods with several runs are compared with the first
of them. Read next: `run.results`, the statistics.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from regista.experiments.run import results as estimate
from regista.experiments.run import significance, versions
from regista.experiments.run.results import LevelResult, Result, align_within, select, unique
from regista.experiments.run.table import cannot_write, spell
from ued.core.files import write_whole
from ued.core.task import TRAINING_SCENE

if TYPE_CHECKING:
    from ued.statistics import Difference, Interval

    Write = Callable[["Entry | None"], str]  # formats a cell

INTERVALS = (
    "95% intervals: bootstrap over runs and their episodes; for a single run or a baseline, over its episodes only, "
    "Wilson's for rates and Student's t for returns and CVaR10; none below 5 runs, or 5 episodes"
)
OF_SCENES = (
    "mean and IQM over all scenes{training}; stratified: rliable's interval, too narrow since each run plays all scenes"
)
OF_PAIRS = (
    "differences to {first} in percentage points; P(better): probability that a run's mean exceeds that of a run of "
    "{first}"
)
OF_LEVELS = "CVaR10: on the worst tenth of {levels} random levels, selected by other episodes than those that count"


class Entry(NamedTuple):
    """One number of a table: `measure` of a method on a scene, "" for all scenes.

    `interval` names the estimator of the interval. Without an interval, it is empty and `low` and `high` are nan.
    `p` is the p-value of a difference, `p_holm` the p-value after Holm's correction over the table; otherwise nan.
    """

    method: str
    measure: str
    scene: str
    estimate: float
    low: float
    high: float
    interval: str
    p: float = math.nan
    p_holm: float = math.nan

    @property
    def known(self) -> bool:
        """Whether there is an interval."""
        return bool(self.interval)

    @property
    def mark(self) -> str:
        """The mark of a difference whose interval excludes 0; empty for other numbers."""
        return significance.mark(self, self.p_holm) if self.measure in DIFFERENCES else ""


DIFFERENCES = ("return minus first", "mean minus first")  # measures of the first table, and of the second
OF_RUNS = {"IQM, stratified": "bootstrap over runs and scenes", "P(better)": "Newcombe"}
OF_ONE_RUN = {"return": "t", "CVaR10": "t"}  # rates have Wilson's interval


def entry(method: str, measure: str, scene: str, found: Interval | Difference, runs: int) -> Entry:
    """Return one number of a table, estimated from this number of runs."""
    kind = OF_RUNS.get(measure, "bootstrap over runs") if runs > 1 else OF_ONE_RUN.get(measure, "Wilson")
    p = getattr(found, "p", math.nan)
    return Entry(method, measure, scene, *found[:3], kind if found.known else "", p)


def corrected(entries: Sequence[Entry]) -> list[Entry]:
    """Return the numbers of both tables with p-values after Holm's correction over the differences of each table."""
    from ued.statistics import holm

    adjusted: dict[int, float] = {}
    for measure in DIFFERENCES:
        family = [k for k, one in enumerate(entries) if one.measure == measure]
        adjusted |= zip(family, holm([entries[k].p for k in family]), strict=True)
    return [one._replace(p_holm=adjusted.get(k, math.nan)) for k, one in enumerate(entries)]


@dataclass(frozen=True)
class Report:
    """All results of some methods; every method is evaluated on every scene.

    Attributes:
        results: rows of all policies on all scenes.
        levels: rows of all policies on random levels; may be empty.
        word: word for successes, such as "goals".
        simulator: the simulator version of the episodes; None for other engines and tasks.
    """

    results: Sequence[Result]
    levels: Sequence[LevelResult] = ()
    word: str = "goals"
    simulator: int | None = None

    @cached_property
    def methods(self) -> list[str]:
        return unique([row.method for row in self.results])

    @cached_property
    def scenes(self) -> list[str]:
        return unique([row.scene for row in self.results])

    @cached_property
    def several(self) -> list[str]:
        """Methods with several runs; the others are compared with the first."""
        return [name for name in self.methods if len(select(self.results, name, self.scenes[0])) > 1]

    @property
    def first(self) -> str:
        return self.several[0] if self.several else ""

    def others(self) -> list[str]:
        """Return the methods that are compared with the first."""
        return self.several[1:]

    @cached_property
    def entries(self) -> list[Entry]:
        """All numbers of both tables."""
        return corrected([*self._of_scenes(), *self._of_all_scenes(), *self._of_levels()])

    @cached_property
    def _scores(self) -> dict[str, estimate.Scores]:
        return {name: estimate.scores(self.results, name) for name in self.methods}

    def _of_scenes(self) -> Iterable[Entry]:
        for scene in self.scenes:
            for name in self.methods:
                rows = select(self.results, name, scene)
                yield entry(name, "return", scene, estimate.mean_return(rows), len(rows))
                yield entry(name, "goals", scene, estimate.goal_rate(rows), len(rows))
                if name in self.others():
                    gain = estimate.advantage(rows, select(self.results, self.first, scene))
                    yield entry(name, "return minus first", scene, gain, len(rows))

    def _of_all_scenes(self) -> Iterable[Entry]:
        scores = self._scores
        for name, score in scores.items():
            found: dict[str, Interval | Difference] = {
                "mean": estimate.mean_score(score),
                "IQM": estimate.iqm_score(score),
            }
            found["IQM, stratified"] = estimate.iqm_stratified(score)
            if name in self.others():
                found["mean minus first"] = estimate.score_advantage(score, scores[self.first])
                found["P(better)"] = estimate.chance_of_better(score, scores[self.first])
            for measure, interval in found.items():
                yield entry(name, measure, "", interval, len(score.rates))

    def _of_levels(self) -> Iterable[Entry]:
        for name in self.methods if self.levels else ():
            rows = [row for row in self.levels if row.method == name]
            yield entry(name, "random levels", "", estimate.level_rate(rows), len(rows))
            yield entry(name, "CVaR10", "", estimate.level_cvar(rows), len(rows))

    # ------------------------------------------------------------ tables

    def by_scene(self) -> list[list[str]]:
        """Return methods x scenes: mean return, goal rate, and the difference of returns to the first method."""
        table = [["method", "", *self.scenes, "runs", "env_steps", "updates"]]
        for name in self.methods:
            table.append([name, "return", *self._cells(name, "return", _signed), *self._training(name)])
            table.append(["", self.word, *self._cells(name, "goals", percent), "", "", ""])
            if name in self.others():
                table.append(["", f"− {self.first}", *self._cells(name, "return minus first", _signed), "", "", ""])
        return table

    def by_method(self) -> list[list[str]]:
        """Return methods x aggregates over all scenes and over random levels."""
        columns: dict[str, Write] = {"mean": percent, "IQM": percent, "IQM, stratified": percent}
        if self.others():
            columns |= {"mean minus first": _points, "P(better)": two_digits}
        if self.levels:
            columns |= {"random levels": percent, "CVaR10": percent}
        names = {"mean minus first": f"mean − {self.first}", "P(better)": f"P(better than {self.first})"}
        table = [["method", *(names.get(measure, measure) for measure in columns)]]
        for name in self.methods:
            table.append([name, *(write(self._at(name, measure)) for measure, write in columns.items())])
        return table

    def _cells(self, method: str, measure: str, write: Write) -> list[str]:
        return [write(self._at(method, measure, scene)) for scene in self.scenes]

    def _at(self, method: str, measure: str, scene: str = "") -> Entry | None:
        return next((entry for entry in self.entries if entry[:3] == (method, measure, scene)), None)

    def _training(self, method: str) -> list[str]:
        rows = select(self.results, method, self.scenes[0])
        steps, updates = ([getattr(row, name) for row in rows] for name in ("env_steps", "updates"))
        return [str(len(rows)), *(f"{round(np.mean(counts)):_}" if any(counts) else "–" for counts in (steps, updates))]

    def notes_by_scene(self) -> list[str]:
        """Return the notes below the first table."""
        sizes = [
            estimate.detectable_return([select(self.results, m, scene) for m in self.several]) for scene in self.scenes
        ]
        return [INTERVALS, *self._on_differences(DIFFERENCES[0], sizes, "{:.2f}")]

    def _on_differences(self, measure: str, sizes: Sequence[float], unit: str) -> list[str]:
        """Return the legend of a table's marks, and the differences that its runs can detect."""
        legend = significance.legend([entry.p for entry in self.entries if entry.measure == measure])
        counts = [len(self._scores[name].rates) for name in self.several]
        return [text for text in (legend, significance.visible(sizes, counts, unit)) if text]

    def _notes(self) -> list[str]:
        """Return the notes below the second table."""
        training = f", including the {TRAINING_SCENE}" if TRAINING_SCENE in self.scenes else ""
        notes = [f"{self.word}; {OF_SCENES.format(training=training)}"]
        if self.others():
            notes.append(OF_PAIRS.format(first=self.first))
            size = 100 * estimate.detectable_score([self._scores[name] for name in self.several])
            notes += self._on_differences(DIFFERENCES[1], [size], "{:.0f} points")
        if self.levels:
            notes.append(OF_LEVELS.format(levels=self.levels[0].levels))
        if self.simulator is not None:
            notes.append(f"played on simulator version {self.simulator}")
        return notes

    # ------------------------------------------------------------ forms

    def text(self, width: int | None = None) -> str:
        """Return both tables for a terminal; a table that is wider than `width` characters is cut into blocks."""
        first, second = (";\n ".join(notes) for notes in (self.notes_by_scene(), self._notes()))
        scenes, methods = align_within(self.by_scene(), width), align_within(self.by_method(), width, kept=1)
        return f"{scenes}\n[{first}]\n\n{methods}\n[{second}]"

    def markdown(self) -> str:
        """Return both tables in Markdown."""
        first, second = ("; ".join(notes) for notes in (self.notes_by_scene(), self._notes()))
        return f"{as_markdown(self.by_scene())}\n\n{first}.\n\n{as_markdown(self.by_method())}\n\n{second}."

    def save(self, folder: Path) -> None:
        """Write table.txt, table.md, table.csv (all numbers of the tables), results.csv and levels.csv (by run)."""
        write_text(folder / "table.txt", self.text() + "\n")
        write_text(folder / "table.md", self.markdown() + "\n")
        self._save([entry._asdict() for entry in self.entries], Entry._fields, folder / "table.csv")
        self.save_csv(folder / "results.csv")
        if self.levels:
            names = [item.name for item in fields(LevelResult)]
            self._save(list(map(asdict, self.levels)), names, folder / "levels.csv")

    def save_csv(self, path: Path) -> None:
        """Write the results as CSV, including the goal rate. Raises `CommandError` if the file cannot be written."""
        rows = [asdict(row) | {"goal_rate": round(row.goal_rate, 6)} for row in self.results]
        self._save(rows, [*(item.name for item in fields(Result)), "goal_rate"], path)

    def _save(self, rows: Sequence[Mapping[str, Any]], columns: Sequence[str], path: Path) -> None:
        version = versions.spelled(self.simulator)
        save_rows([{**row, versions.KEY: version} for row in rows], [*columns, versions.KEY], path)


def as_markdown(rows: list[list[str]]) -> str:
    """Return a table in Markdown; the first row is its header."""
    safe = [[cell.replace("|", r"\|") for cell in row] for row in rows]
    lines = [f"| {' | '.join(row)} |" for row in safe]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def _signed(entry: Entry | None) -> str:
    return "" if entry is None else significance.difference(entry, entry.mark)


def _points(entry: Entry | None) -> str:
    return "" if entry is None else significance.points(entry, entry.mark)


def percent(interval: Interval | Entry | None) -> str:
    """Return a rate in percent with its interval, if it has one."""
    return _spelled(interval, lambda value: f"{value:.0%}")


def two_digits(interval: Interval | Entry | None) -> str:
    """Return a number with its interval, if it has one."""
    return _spelled(interval, lambda value: f"{value:.2f}")


def _spelled(interval: Interval | Entry | None, write: Callable[[float], str]) -> str:
    if interval is None:
        return ""
    ends = f" [{write(interval.low)}, {write(interval.high)}]" if interval.known else ""
    return write(interval.estimate) + ends


# ---------------------------------------------------------------- files


def write_text(path: Path, text: str) -> None:
    """Write a file. Raises `CommandError` if it cannot be written."""
    try:
        write_whole(path, text)
    except OSError as error:
        raise cannot_write(path, error) from error


def save_rows(rows: Sequence[Mapping[str, Any]], columns: Sequence[str], path: Path) -> None:
    """Write rows as CSV. Raises `CommandError` if the file cannot be written."""
    try:
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows({name: spell(value) for name, value in row.items()} for row in rows)
        write_whole(path, text.getvalue())
    except OSError as error:
        raise cannot_write(path, error) from error
