"""θ in a recording: quantiles and histograms by column, and densities over updates.

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
MOST_COLUMNS = 40  # shown columns of θ
MAP_COLUMNS = 400  # maximum width of the densities over updates
MAP_BLUR = 1.2  # of those densities, in columns and bins
HISTOGRAM_EVERY = 5  # updates; bar charts cost a millisecond each
MAP_GROWTH = 1.25  # ratio of the updates at which densities are rewritten, which bounds the file size


class ThetaLog:
    """Writes `/theta/...` of a recording, in the units of the parameters if their range is finite."""

    def __init__(self, stream: rerun.RecordingStream, draws: Sequence[Parameter]) -> None:
        draws = draws[:MOST_COLUMNS]
        axes = [axis_of(parameter) for parameter in draws]
        shown = zip(unique_names(draws), axes, strict=True)
        self.stream, self.names = stream, [axis.note.format(name) for name, axis in shown]
        low, high = np.array([(axis.low, axis.high) for axis in axes], float).reshape(-1, 2).T
        finite = np.isfinite(low) & np.isfinite(high)
        self.low, self.high = np.where(finite, low, -1.0), np.where(finite, high, 1.0)  # [D]; else θ is shown
        self._cells = [choice_in(draw) for draw in draws]
        self._horizon = 1  # estimated number of updates of the run
        self._density = np.zeros((len(self.names), 1, BINS))  # [D, columns, bins]
        self._mapped = 0  # the last update at which the densities were written

    def values(self, theta: np.ndarray) -> np.ndarray:
        """Return the shown columns of θ `[..., D]`, in the units of the parameters."""
        theta = theta[..., : len(self.names)]
        return self.low + (theta + 1) / 2 * (self.high - self.low)

    def expect(self, updates: int) -> None:
        """Allocate the densities for this many updates, before the first update."""
        if self._horizon == 1:
            self._horizon = max(2, updates)
            self._density = np.zeros((len(self.names), min(self._horizon, MAP_COLUMNS), BINS))

    def open(self) -> None:
        """Write the styles of the curves, and the uniform distribution for comparison."""
        for name in self.names:
            shades = [(90, 130, 170), (130, 200, 255), (90, 130, 170)]
            quantiles = rerun.SeriesLines(colors=shades, names=["10%", name, "90%"], widths=[1, 2.5, 1])
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
        """Write the quantiles of an update's levels `[L, D]`, and periodically histograms and densities."""
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
        """Count the levels `[L]` in each bin of the densities; the options of a choice get equal numbers of bins."""
        known = self._cells[d]
        if known is None:
            return np.bincount(np.clip(((theta + 1) / 2 * BINS).astype(int), 0, BINS - 1), minlength=BINS)
        options = np.bincount(known.index(theta), minlength=known.count)
        return options[np.arange(BINS) * known.count // BINS]

    def _bars(self, name: str, heights: np.ndarray, width: float, colour: tuple[int, ...]) -> rerun.BarChart:
        edges = np.linspace(*self._range(name), len(heights) + 1)  # for a choice, one bar per option
        widths = (np.diff(edges) * width).astype(np.float32)
        return rerun.BarChart(heights, abscissa=(edges[1:] + edges[:-1]) / 2, widths=widths, color=colour)

    def record_densities(self, update: int) -> None:
        """Write the densities of all columns of θ over updates, stacked in one view."""
        columns, ticks, texts = self._density.shape[1], [], []
        band = MAP_HEIGHT / max(len(self.names), 1)
        for d, name in enumerate(self.names):
            density = smooth(self._density[d], MAP_BLUR)  # [columns, bins]: a single update has few levels
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
