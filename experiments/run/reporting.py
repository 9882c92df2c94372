"""Interface between training and its reporters: tables, terminal, recording, external trackers.

The training loop passes each update once to every `Reporter`. All scalars have the names of metrics.csv columns.
Read next: `run.folder`, the tables; `run.recording`; `run.trackers`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from regista.experiments.run import build
from regista.experiments.run.errors import CommandError, TaskError
from regista.experiments.run.events import Event, Watch
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.progress import Progress, headline
from regista.experiments.run.table import read_columns
from ued.levels.batch import LevelBatch
from ued.recorder.shades import unique_names


@dataclass(frozen=True)
class Update:
    """Results of an update: `metrics` is the row of metrics.csv, including `update` and `env_steps`."""

    method: Any
    metrics: Mapping[str, float]
    events: Sequence[Event] = ()

    @property
    def number(self) -> int:
        return self.method.updates

    @property
    def env_steps(self) -> int:
        return self.method.env_steps

    @property
    def levels(self) -> LevelBatch | None:
        """The levels of the update."""
        return self.method.last


class Reporter(Protocol):
    """Receives every update."""

    def report(self, update: Update) -> None:
        """Process an update."""

    def flush(self) -> None:
        """Write pending data to disk; called after each checkpoint."""

    def close(self) -> None:
        """Close; no more updates follow."""


class Reporters:
    """Passes updates to all reporters. A failed reporter is removed with a message, and training continues.

    Args:
        run: the run whose metrics.csv, levels.csv and events.csv are written first; an error there ends the run.
        upomdp: the environments.
    """

    def __init__(self, run: RunFolder, upomdp: Any) -> None:
        self.tables = Tables(run, upomdp)
        self.watch = Watch(run.config.total_env_steps, upomdp.max_episode_steps)
        self.others: dict[str, Reporter] = {}
        for row in _rows(read_columns(run.metrics.path)):
            self.watch.look(row)

    def add(self, name: str, make: Callable[[], Reporter]) -> None:
        """Add the reporter that `make` returns; `name` completes the message "no more updates are ..." if it fails."""
        with self._excused(name):
            self.others[name] = make()

    def report(self, method: Any, metrics: Mapping[str, float]) -> None:
        """Report an update of the method; wall-clock metrics come last."""
        row = {"update": method.updates, "env_steps": method.env_steps}
        rest = {name: value for name, value in metrics.items() if name not in ("updates", "env_steps")}
        row |= dict(sorted(rest.items(), key=lambda item: item[0].startswith("time/")))
        update = Update(method, row, self.watch.look(row))
        self.tables.report(update)
        self._all(lambda reporter: reporter.report(update))

    def flush(self) -> None:
        """Flush all reporters."""
        self._all(lambda reporter: reporter.flush())

    def close(self) -> None:
        """Close all reporters."""
        self._all(lambda reporter: reporter.close())

    def _all(self, act: Callable[[Reporter], None]) -> None:
        for name, reporter in list(self.others.items()):
            with self._excused(name):
                act(reporter)

    @contextmanager
    def _excused(self, name: str) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            if isinstance(error, CommandError) and not isinstance(error, TaskError):
                raise
            self.others.pop(name, None)
            what = str(error) if isinstance(error, TaskError) else f"{type(error).__name__}: {error}"
            print(f"regista: no more updates are {name}: {what}", file=sys.stderr)


def _rows(columns: Mapping[str, np.ndarray]) -> list[dict[str, float]]:
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


class Tables:
    """metrics.csv, levels.csv and events.csv of a run folder."""

    def __init__(self, run: RunFolder, upomdp: Any) -> None:
        self.run, self.names = run, unique_names(upomdp.parameters)
        self.programs = np.array(upomdp.program_names or [build.find_game(run.config.minigame).short])

    def report(self, update: Update) -> None:
        """Add a row to metrics.csv, one for each level to levels.csv, and one for each event to events.csv."""
        batch, place = update.levels, {"update": update.number, "env_steps": update.env_steps}
        if batch is not None:
            facts = batch.facts()
            columns = {"update": np.full(len(batch.theta), update.number), **facts}
            if len(self.programs) > 1 or "program" in self.run.levels.columns:  # tables of older versions have it
                columns["program"] = self.programs[facts["program"]]
            else:
                del columns["program"]
            columns |= {f"theta/{name}": batch.theta[:, d] for d, name in enumerate(self.names)}
            self.run.levels.append_levels(columns | batch.outcomes())  # first, since it raises for other columns
        self.run.metrics.append([update.metrics])
        if update.events:
            self.run.events.append([place | event._asdict() for event in update.events])


class Console:
    """Shows the progress line and warnings."""

    def __init__(self, progress: Progress) -> None:
        self.progress = progress

    def report(self, update: Update) -> None:
        """Show the progress of the run."""
        for event in update.events:
            self.progress.say(f"{event.event} (update {update.number}): {event.text}")
        self.progress.show(update.env_steps, headline(update.metrics))

    def flush(self) -> None:
        """Do nothing: output is not buffered."""

    def close(self) -> None:
        """Do nothing: the training loop prints the last line."""
