"""What a recording shows of θ: quantiles and histograms by column, and densities over updates.

Read next: `recorder.scene_log`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun

from ued.core.parameters import Parameter, axis_of, choice_in
from ued.recorder.layout import MAP_GAP, MAP_HEIGHT, MAP_WIDTH
from ued.recorder.shades import smooth, unique_names

BINS = 24  # of a histogram of θ
MOST_COLUMNS = 40  # of θ that are shown
MAP_COLUMNS = 400  # of the densities over updates, at most
MAP_BLUR = 1.2  # of those densities, in columns and bins
HISTOGRAM_EVERY = 5  # updates; bar charts cost a millisecond each
MAP_GROWTH = 1.25  # of the updates between two writings of the densities, so that the file grows by a factor only


class ThetaLog:
    """Writes `/theta/...` of a recording, in the units of the parameters where these are finite."""

    def __init__(self, stream: rerun.RecordingStream, draws: Sequence[Parameter]) -> None:
        draws = draws[:MOST_COLUMNS]
        axes = [axis_of(parameter) for parameter in draws]
        shown = zip(unique_names(draws), axes, strict=True)
        self.stream, self.names = stream, [axis.note.format(name) for name, axis in shown]
        low, high = np.array([(axis.low, axis.high) for axis in axes], float).reshape(-1, 2).T
        finite = np.isfinite(low) & np.isfinite(high)
        self.low, self.high = np.where(finite, low, -1.0), np.where(finite, high, 1.0)  # [D]; else θ itself is shown
        self._cells = [choice_in(draw) for draw in draws]
        self._horizon = 1  # updates that the run will take, as far as is known
        self._density = np.zeros((len(self.names), 1, BINS))  # [D, columns, bins]
        self._mapped = 0  # the last update at which the densities were written

    def values(self, theta: np.ndarray) -> np.ndarray:
        """Return the columns that are shown of θ `[..., D]`, in the units of the parameters."""
        theta = theta[..., : len(self.names)]
        return self.low + (theta + 1) / 2 * (self.high - self.low)

    def expect(self, updates: int) -> None:
        """Make room for this many updates, if none has been noted yet."""
        if self._horizon == 1:
            self._horizon = max(2, updates)
            self._density = np.zeros((len(self.names), min(self._horizon, MAP_COLUMNS), BINS))

    def open(self) -> None:
        """Write the looks of the curves, and the uniform to compare histograms with."""
        for name in self.names:
            shades = [(90, 130, 170), (130, 200, 255), (90, 130, 170)]
            quantiles = rerun.SeriesLines(colors=shades, names=["10 %", name, "90 %"], widths=[1, 2.5, 1])
            self.stream.log(["theta", name, "quantiles"], quantiles, static=True)
            known = self._cells[self.names.index(name)]
            weights = np.full(BINS, 1 / BINS) if known is None else known.shares
            prior = self._bars(name, weights, 1.0, (120, 120, 120, 60))
            self.stream.log(["theta", name, "uniform"], prior, static=True)

    def note(self, update: int, theta: np.ndarray) -> None:
        """Add the levels `[L, D]` of an update to the densities over updates."""
        last = self._density.shape[1] - 1
        column = min(update * (last + 1) // self._horizon, last)
        for d in range(len(self.names)):
            self._density[d, column] += self._shade(d, theta[:, d])

    def record(self, update: int, theta: np.ndarray) -> None:
        """Write the quantiles of the levels `[L, D]` of an update, now and then their histograms and densities."""
        values = self.values(theta)  # [L, D]
        for d, name in enumerate(self.names):
            self.stream.log(["theta", name, "quantiles"], rerun.Scalars(np.quantile(values[:, d], [0.1, 0.5, 0.9])))
            if update % HISTOGRAM_EVERY == 0 or update == 1:
                known = self._cells[d]
                counts = (
                    np.histogram(values[:, d], bins=BINS, range=self._range(name))[0]
                    if known is None
                    else np.bincount(known.index(theta[:, d]), minlength=known.count)
                )
                chart = self._bars(name, counts / len(values), 0.92, (130, 200, 255))
                self.stream.log(["theta", name, "histogram"], chart)
        x = (update + 0.5) / self._horizon * MAP_WIDTH
        cursor = rerun.LineStrips2D([[[x, -2.0], [x, MAP_HEIGHT]]], colors=(255, 255, 255), radii=-0.8)
        self.stream.log("theta/over_time/cursor", cursor)
        if update >= MAP_GROWTH * self._mapped:
            self.record_densities(update)

    def _shade(self, d: int, theta: np.ndarray) -> np.ndarray:
        """Return how many levels `[L]` are in each bin of the densities: of a choice each option has as many bins."""
        known = self._cells[d]
        if known is None:
            return np.bincount(np.clip(((theta + 1) / 2 * BINS).astype(int), 0, BINS - 1), minlength=BINS)
        options = np.bincount(known.index(theta), minlength=known.count)
        return options[np.arange(BINS) * known.count // BINS]

    def _bars(self, name: str, heights: np.ndarray, width: float, colour: tuple[int, ...]) -> rerun.BarChart:
        edges = np.linspace(*self._range(name), len(heights) + 1)  # of a choice a bar for each option
        widths = (np.diff(edges) * width).astype(np.float32)
        return rerun.BarChart(heights, abscissa=(edges[1:] + edges[:-1]) / 2, widths=widths, color=colour)

    def record_densities(self, update: int) -> None:
        """Write the densities of all columns of θ over updates, stacked in one view."""
        columns, ticks, texts = self._density.shape[1], [], []
        band = MAP_HEIGHT / max(len(self.names), 1)
        for d, name in enumerate(self.names):
            density = smooth(self._density[d], MAP_BLUR)  # [columns, bins]: an update alone has too few levels
            density /= np.maximum(density.max(1, keepdims=True), 1e-9)
            scale = [MAP_WIDTH / columns, (band - MAP_GAP) / BINS, 1.0]
            place = rerun.Transform3D(translation=[0, d * band, 0], scale=scale)
            self.stream.log(f"theta/over_time/{d}", place, static=True)
            pixels = np.ascontiguousarray(density.T[::-1], np.float32)
            image = rerun.DepthImage(pixels, colormap="inferno", depth_range=[0.0, 1.0], draw_order=-5)
            self.stream.log(f"theta/over_time/{d}/map", image, static=True)
            ticks.append([-32, (d + 0.5) * band])
            texts.append(f"{name}: {self.low[d]:g} to {self.high[d]:g}")
        for mark in np.linspace(0, self._horizon, 5):
            ticks.append([mark / self._horizon * MAP_WIDTH, MAP_HEIGHT])
            texts.append(f"#{mark:.0f}")
        axis = rerun.Points2D(ticks, labels=texts, radii=0.001, colors=(205, 210, 215), show_labels=True)
        self.stream.log("theta/over_time/axis", axis, static=True)
        self._mapped = update

    def _range(self, name: str) -> tuple[float, float]:
        d = self.names.index(name)
        return self.low[d], max(self.high[d], self.low[d] + 1e-9)
