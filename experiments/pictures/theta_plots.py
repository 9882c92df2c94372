"""Levels of a method, for tasks without a painter: histograms of the columns of θ, early and late in training.

Read next: `pictures.level_plots`, the same on a pitch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from regista.experiments.pictures import plots
from regista.experiments.pictures.level_plots import read_periods
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.proposals import PERIODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_COLUMNS = 8  # drawn columns of θ
BINS = 20


def levels(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Draw methods x columns of θ: histograms of levels in the first, a middle and the last tenth of training."""
    import matplotlib.pyplot as plt

    nothing = np.zeros(0, np.int64)  # names alone
    tables = (read_levels(run, "theta/", rows=nothing) for paths in runs.values() for run in paths)
    names = next((_names(table) for table in tables if table), [])[:MOST_COLUMNS]
    if not names:
        return
    with plots.style():
        size = (2.6 * len(names) + 0.6, 1.9 * len(runs) + 0.5)
        figure, grid = plt.subplots(
            len(runs), len(names), figsize=size, sharey="col", squeeze=False, layout="constrained"
        )
        for line, (method, paths) in zip(grid, runs.items(), strict=True):
            thetas = zip(*(read_periods(run, PERIODS.values()) for run in paths), strict=True)
            found = dict(zip(PERIODS, thetas, strict=True))
            for column, (axes, name) in enumerate(zip(line, names, strict=True)):
                _draw(axes, column, found)
                plots.heading(axes, f"{plots.title(method)}: {name}")
            line[0].set_ylabel("share of levels")
        for axes in grid[-1]:
            axes.set_xlabel("θ (lowest to highest value)")
            axes.set_ylim(bottom=0)  # of the whole column, after all of it is drawn
        handles, labels = grid[0][0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside lower center", ncols=4, fontsize=8, title="levels of", title_fontsize=8
        )
        plots.save(figure, path)


def _names(table: Mapping[str, np.ndarray]) -> list[str]:
    return [name.removeprefix("theta/") for name in table if name.startswith("theta/")]


def _draw(axes: Axes, column: int, found: Mapping[str, Sequence[np.ndarray]]) -> None:
    """Draw the histogram of a column in each period; `found` has θ `[L, D]` of each run and period."""
    for shade, (period, thetas) in zip(plots.sequence(len(found)), found.items(), strict=True):
        known = [theta[:, column] for theta in thetas if len(theta)]
        if known:
            share, edges = np.histogram(np.concatenate(known), BINS, (-1, 1))
            axes.stairs(share / share.sum(), edges, color=shade, linewidth=1.3, label=f"the {period} of training")
    axes.axhline(1 / BINS, color=plots.FAINT, linestyle=":", linewidth=0.8, label="a uniform distribution")
    axes.set_xlim(-1, 1)
