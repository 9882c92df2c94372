"""Numbers of a recording, sent in columns for many updates at once: a hundred times cheaper than row by row.

Read next: `recorder.recorder`, which sends them at every checkpoint.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import rerun

MOVIE_SECONDS = 1.0  # seconds of the `movie` timeline per update


class Pending(NamedTuple):
    """Rows of an entity: the update, the env_steps and K numbers of each row."""

    updates: list[int]
    env_steps: list[int]
    values: list[Sequence[float]]


class Rows:
    """Collects rows of numbers by entity, until `send`.

    Curves that no view shows, see `shown`, have no row on timeline `movie`, which is only for animations.
    """

    def __init__(self, stream: rerun.RecordingStream, shown: Callable[[str], bool]) -> None:
        self.stream, self.shown = stream, shown
        self._now = 0, 0
        self._scalars: dict[tuple[str, ...], Pending] = {}
        self._bands: dict[tuple[str, ...], Pending] = {}

    def at(self, update: int, env_steps: int) -> None:
        """Set the time of the next rows."""
        self._now = update, env_steps

    def scalars(self, path: Sequence[str], values: Sequence[float]) -> None:
        """Add a row of K curves."""
        self._add(self._scalars, path, values)

    def band(self, path: Sequence[str], values: np.ndarray) -> None:
        """Add the mean and the variance of values `[n]`, n > 0."""
        self._add(self._bands, path, (float(values.mean()), float(values.var())))

    def send(self) -> None:
        """Send all rows."""
        for path, rows in self._scalars.items():
            values = np.array(rows.values, float)  # [R, K]
            columns = rerun.Scalars.columns(scalars=values.reshape(-1))
            lengths = np.full(len(values), values.shape[1])
            self._send(path, rows, columns if values.shape[1] == 1 else columns.partition(lengths))
        for path, rows in self._bands.items():
            means, variances = np.array(rows.values, float).T
            self._send(path, rows, rerun.Measurements.columns(values=means, variances=variances))
        self._scalars.clear()
        self._bands.clear()

    def _add(self, into: dict[tuple[str, ...], Pending], path: Sequence[str], values: Sequence[float]) -> None:
        rows = into.setdefault(tuple(path), Pending([], [], []))
        rows.updates.append(self._now[0])
        rows.env_steps.append(self._now[1])
        rows.values.append(values)

    def _send(self, path: Sequence[str], rows: Pending, columns: rerun.ComponentColumnList) -> None:
        times = [
            rerun.TimeColumn("update", sequence=rows.updates),
            rerun.TimeColumn("env_steps", sequence=rows.env_steps),
        ]
        if self.shown("/".join(path)):
            times.append(rerun.TimeColumn("movie", duration=np.array(rows.updates) * MOVIE_SECONDS))
        self.stream.send_columns(rerun.new_entity_path(list(path)), times, columns)  # a name may contain spaces
