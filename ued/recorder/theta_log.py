"""θ in a recording: quantiles and histograms by column, and densities over updates.

Read next: `recorder.scene_log`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun

from ued.core.parameters import Parameter, axis_of, cells_in, choice_in
from ued.recorder.layout import MAP_GAP, MAP_HEIGHT, MAP_LEFT, MAP_WIDTH
from ued.recorder.rows import Rows
from ued.recorder.shades import smooth, unique_names

BINS = 24  # bins of a histogram of θ
MOST_COLUMNS = 40  # maximum number of shown columns of θ
MAP_COLUMNS = 400  # maximum width of the densities over updates
MAP_BLUR = 1.2  # width of the blur of these densities, in columns and bins
HEIGHTS = "BarChart:values"  # the only part of a histogram that changes
HISTOGRAM_EVERY = 5  # updates; bar charts cost a millisecond each
MOST_LABELS = 10  # maximum number of labels of the densities over updates
LABEL_CHARACTER, LABEL_BELOW = 3.6, 6.0  # width of a character, distance below its point, in units of the densities
NARROW_GAP = 0.2  # between the densities of many columns, as a share of their height
MAP_GROWTH = 1.25  # ratio of the updates at which densities are rewritten, which bounds the file size


class ThetaLog:
    """Writes `/theta/...` of a recording, in the units of the parameters if their range is finite."""

    def __init__(self, stream: rerun.RecordingStream, rows: Rows, draws: Sequence[Parameter]) -> None:
        draws = draws[:MOST_COLUMNS]
        axes = [axis_of(parameter) for parameter in draws]
        shown = zip(unique_names(draws), axes, strict=True)
        self.stream, self.rows = stream, rows
        self.names = [axis.note.format(name) for name, axis in shown]
        low, high = np.array([(axis.low, axis.high) for axis in axes], float).reshape(-1, 2).T
        finite = np.isfinite(low) & np.isfinite(high)
        self.low, self.high = np.where(finite, low, -1.0), np.where(finite, high, 1.0)  # [D]; else θ is shown
        self._cells = [choice_in(draw) for draw in draws]
        self._values = [cells_in(draw) for draw in draws]  # cells of columns with finitely many values
        self._horizon = 1  # estimated number of updates of the run
        self._density = np.zeros((len(self.names), 1, BINS))  # [D, columns, bins]
        self._mapped = 0  # the last update at which the densities were written

    def values(self, theta: np.ndarray) -> np.ndarray:
        """Return the shown columns of θ `[..., D]` in the units of the parameters."""
        share = (theta[..., : len(self.names)] + 1) / 2
        for d, known in enumerate(self._values):  # cells of unequal width are not linear on the axis of values
            if known is not None:
                share[..., d] = (known.index(theta[..., d]) + 0.5) / known.count
        return self.low + share * (self.high - self.low)

    def expect(self, updates: int) -> None:
        """Allocate the densities for this many updates, before the first update."""
        if self._horizon == 1:
            self._horizon = max(2, updates)
            self._density = np.zeros((len(self.names), min(self._horizon, MAP_COLUMNS), BINS))

    def open(self) -> None:
        """Write the static content: styles, the uniform distribution for comparison, and the axes."""
        for d, name in enumerate(self.names):
            shades = [(90, 130, 170), (130, 200, 255), (90, 130, 170)]
            quantiles = rerun.SeriesLines(colors=shades, names=["10%", name, "90%"], widths=[1, 2.5, 1])
            self.stream.log(["theta", name, "quantiles"], quantiles, static=True)
            known = self._cells[d]
            weights = np.full(BINS, 1 / BINS) if known is None else known.shares
            prior = self._bars(d, len(weights), 1.0, (120, 120, 120, 60))
            heights = weights.astype(np.float32)
            self.stream.log(["theta", name, "uniform"], rerun.BarChart(heights, **prior), static=True)
            bars = rerun.BarChart(heights, **self._bars(d, len(weights), 0.92, (130, 200, 255)))
            style = [part for part in bars.as_component_batches() if part.component_descriptor().component != HEIGHTS]
            self.stream.log(["theta", name, "histogram"], style, static=True)
        line = rerun.LineStrips2D.from_fields(colors=(255, 255, 255), radii=-0.8)
        self.stream.log("theta/over_time/cursor", line, static=True)
        self._axes()

    def note(self, update: int, theta: np.ndarray) -> None:
        """Add the levels `[L, D]` of an update to the densities over updates."""
        last = self._density.shape[1] - 1
        column = min((update - 1) * (last + 1) // self._horizon, last)  # update 1 is between #0 and #1
        for d in range(len(self.names)):
            self._density[d, column] += self._shade(d, theta[:, d])

    def record(self, update: int, theta: np.ndarray) -> None:
        """Write the quantiles of an update's levels `[L, D]`, and periodically histograms."""
        values = self.values(theta)  # [L, D]
        quantiles = np.quantile(values, [0.1, 0.5, 0.9], axis=0)  # [3, D]
        for d, name in enumerate(self.names):
            self.rows.scalars(["theta", name, "quantiles"], quantiles[:, d])
            if update % HISTOGRAM_EVERY == 0 or update == 1:
                known, column = self._cells[d], theta[:, d]
                counts = binned(column) if known is None else np.bincount(known.index(column), minlength=known.count)
                heights = (counts / len(values)).astype(np.float32)
                self.stream.log(["theta", name, "histogram"], rerun.BarChart.from_fields(values=heights))
        x = (update - 0.5) / self._horizon * MAP_WIDTH
        cursor = rerun.LineStrips2D.from_fields(strips=[[[x, -2.0], [x, MAP_HEIGHT]]])
        self.stream.log("theta/over_time/cursor", cursor)

    def _shade(self, d: int, theta: np.ndarray) -> np.ndarray:
        """Count the levels `[L]` in each bin of the densities; the options of a choice get equal numbers of bins."""
        known = self._cells[d]
        if known is None:
            return binned(theta)
        options = np.bincount(known.index(theta), minlength=known.count)
        return options[np.arange(BINS) * known.count // BINS]

    def _bars(self, d: int, count: int, width: float, color: tuple[int, ...]) -> dict[str, Any]:
        """Return places, widths and color of `count` bars of a column."""
        edges = np.linspace(*self._range(d), count + 1)  # for a choice, one bar per option
        return bars_between(edges, width) | {"color": color}

    def record_densities(self, update: int, growth: float = MAP_GROWTH) -> None:
        """Write the densities of all columns of θ over updates, stacked in one view.

        Nothing is written until the number of updates has grown by the factor `growth` since the last time.
        """
        if update < growth * self._mapped or update == self._mapped:
            return
        for d in range(len(self.names)):
            density = smooth(self._density[d], MAP_BLUR)  # [columns, bins]: a single update has few levels
            density /= np.maximum(density.max(1, keepdims=True), 1e-9)
            pixels = np.ascontiguousarray((255 * density.T[::-1]).round(), np.uint8)
            image = rerun.DepthImage(pixels, colormap="inferno", depth_range=[0.0, 255.0], draw_order=-5)
            self.stream.log(f"theta/over_time/{d}/map", image, static=True)
        self._mapped = update

    def _axes(self) -> None:
        """Write the places of the densities and their labels."""
        columns, band = self._density.shape[1], MAP_HEIGHT / max(len(self.names), 1)
        scale = [MAP_WIDTH / columns, (band - min(MAP_GAP, NARROW_GAP * band)) / BINS, 1.0]
        every = -(-len(self.names) // MOST_LABELS)  # more labels would cover each other
        ticks, texts = [], []
        for d, name in enumerate(self.names):
            place = rerun.Transform3D(translation=[0, d * band, 0], scale=scale)
            self.stream.log(f"theta/over_time/{d}", place, static=True)
            if d % every == 0:
                text = axis_label(name, self.low[d], self.high[d])
                ticks.append([-MAP_GAP - LABEL_CHARACTER * (len(text) + 2) / 2, (d + 0.5) * band - LABEL_BELOW])
                texts.append(text)
        for mark in np.unique(np.linspace(0, self._horizon, 5).round()):
            ticks.append([mark / self._horizon * MAP_WIDTH, MAP_HEIGHT])
            texts.append(f"#{mark:.0f}")
        axis = rerun.Points2D(ticks, labels=texts, radii=0.001, colors=(205, 210, 215), show_labels=True)
        self.stream.log("theta/over_time/axis", axis, static=True)

    def _range(self, d: int) -> tuple[float, float]:
        return self.low[d], max(self.high[d], self.low[d] + 1e-9)


def binned(theta: np.ndarray) -> np.ndarray:
    """Count the entries of θ `[L]` in equal bins of [-1, 1]: `[BINS]`. Rounding drops no entry at the ends."""
    return np.bincount(np.clip(((theta + 1) / 2 * BINS).astype(int), 0, BINS - 1), minlength=BINS)


def bars_between(edges: np.ndarray, width: float) -> dict[str, Any]:
    """Return places and widths of bars centered between `edges` `[n + 1]`; `width` is their share of the distance.

    The viewer draws a bar to the right of its place.
    """
    steps = np.diff(edges)
    places, widths = edges[:-1] + (1 - width) / 2 * steps, width * steps
    return {"abscissa": places.astype(np.float32), "widths": widths.astype(np.float32)}


def axis_label(name: str, low: float, high: float) -> str:
    """Return the label of a column's densities: its name, shortened to the available room, and its range."""
    span = f": {low:g} to {high:g}"
    room = max(int((MAP_LEFT - MAP_GAP) / LABEL_CHARACTER) - 2 - len(span), 4)
    return (name if len(name) <= room else name[: room - 1] + "…") + span
