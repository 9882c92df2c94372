"""Levels of a method, for tasks without a painter: histograms of the columns of θ, early and late in training.

Read next: `pictures.level_plots`, the same on a pitch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.pictures import plots
from regista.experiments.pictures.level_plots import read_periods
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.proposals import PERIODS
from ued.core.cells import Cells
from ued.core.parameters import LogRange, Parameter, Range, choice_in
from ued.recorder.shades import unique_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_COLUMNS = 8  # maximum number of drawn columns of θ
BINS = 20
# Ratios high / low of a LogRange: from DECADE on, ticks at 1, 2, 5, 10, ...; from DECADES on, at powers of 10 only.
DECADE, DECADES = 10, 200
MOST_NAMES = 8  # maximum number of labels on the axis of a choice; more would overlap


def levels(runs: Mapping[str, Sequence[Path]], path: Path, draws: Sequence[Parameter] = ()) -> None:
    """Draw methods x columns of θ: histograms of levels in the first, a middle and the last tenth of training.

    A column that is a choice or a few integers according to `draws` has a bar for each value. The axis of a finite
    range has the units of the parameter.
    """
    import matplotlib.pyplot as plt

    nothing = np.zeros(0, np.int64)  # load only the names of columns
    tables = (read_levels(run, "theta/", rows=nothing) for paths in runs.values() for run in paths)
    known = next((_names(table) for table in tables if table), [])
    names, choices, scales = known[:MOST_COLUMNS], _choices(draws), _scales(draws)
    if not names:
        return
    more = f" (the first {len(names)} of {len(known)} parameters)" if len(known) > len(names) else ""
    with plots.style():
        size = (2.6 * len(names) + 0.6, 1.9 * len(runs) + 0.5)
        figure, grid = plt.subplots(
            len(runs), len(names), figsize=size, sharey="col", squeeze=False, layout="constrained"
        )
        for line, (method, paths) in zip(grid, runs.items(), strict=True):
            thetas = zip(*(read_periods(run, PERIODS.values()) for run in paths), strict=True)
            found = dict(zip(PERIODS, thetas, strict=True))
            for column, (axes, name) in enumerate(zip(line, names, strict=True)):
                _draw(axes, column, found, choices.get(name))
                if name in scales:
                    axes.set_xticks(*scales[name])
                plots.heading(axes, f"{plots.title(method)}: {name}")
            line[0].set_ylabel("share of levels")
        for axes, name in zip(grid[-1], names, strict=True):
            axes.set_xlabel("value" if name in choices or name in scales else "θ (lowest to highest value)")
            axes.set_ylim(bottom=0)  # after drawing, since the axes of a column share their limits
        handles, labels = grid[0][0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside lower center", ncols=4, fontsize=8, title=f"levels of{more}", title_fontsize=8
        )
        plots.save(figure, path)


def _names(table: Mapping[str, np.ndarray]) -> list[str]:
    return [name.removeprefix("theta/") for name in table if name.startswith("theta/")]


def _choices(draws: Sequence[Parameter]) -> dict[str, tuple[Cells, list[str]]]:
    """Return the cells and value names of each column with finitely many values, by column."""
    found = {}
    for name, draw in zip(unique_names(draws), draws, strict=True):
        cells = choice_in(draw)
        if cells is not None:
            found[name] = cells, [*(cells.names or (f"{draw.low + k:g}" for k in range(cells.count)))]
    return found


def _scales(draws: Sequence[Parameter]) -> dict[str, tuple[list[float], list[str]]]:
    """Return the tick positions in [-1, 1] and the tick labels of the other columns, by column.

    Columns without a finite range have no ticks.
    """
    from matplotlib.ticker import LogLocator, MaxNLocator

    found = {}
    for name, draw in zip(unique_names(draws), draws, strict=True):
        low, high, kind = draw.low, draw.high, getattr(draw, "kind", None)
        if choice_in(draw) is not None or not (np.isfinite([low, high]).all() and low < high):
            continue
        locator: Any = MaxNLocator(4, steps=[1, 2, 5, 10])
        if isinstance(kind, LogRange) and high >= DECADE * low:
            locator = LogLocator(subs=(1, 2, 5) if high < DECADES * low else (1,))
        values = locator.tick_values(low, high)
        slack = 1e-9 * (high - low)
        inside = [float(value) for value in values if low - slack <= value <= high + slack]
        to_unit = kind.to_unit if isinstance(kind, LogRange) else Range(low, high).to_unit
        found[name] = [to_unit(value) for value in inside], [f"{value:g}" for value in inside]
    return found


def _draw(
    axes: Axes, column: int, found: Mapping[str, Sequence[np.ndarray]], choice: tuple[Cells, list[str]] | None = None
) -> None:
    """Draw the histogram of a column in each period; `found` has θ `[L, D]` of each run and period."""
    cells, values = choice or (Cells(BINS), [])
    edges = np.linspace(-1, 1, cells.count + 1)
    for shade, (period, thetas) in zip(plots.sequence(len(found)), found.items(), strict=True):
        known = [theta[:, column] for theta in thetas if len(theta)]
        if known:
            count = np.bincount(cells.index(np.concatenate(known)), minlength=cells.count)
            axes.stairs(count / count.sum(), edges, color=shade, linewidth=1.3, label=f"the {period} of training")
    label = "random levels"
    axes.stairs(cells.shares, edges, color=plots.FAINT, linestyle=":", linewidth=0.8, baseline=None, label=label)
    axes.set_xlim(-1, 1)
    if values:
        every = -(-len(values) // MOST_NAMES)
        names = [name[:14] for name in values[::every]]
        turned: dict[str, Any] = {"rotation": 20, "ha": "right"} if max(map(len, names)) > 3 else {}
        axes.set_xticks(((edges[1:] + edges[:-1]) / 2)[::every], names, **turned)
