"""Picture of the rare levels: success on them by method, and how often PAIRED's adversary proposes them.

Drawn from the rows of `lab/paired_football.py`, which calls it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.thesis.figures import run_handle
from regista.experiments.pictures import keys, plots
from regista.experiments.run.results import unique
from ued.statistics import bootstrap

PICTURE = Path(__file__).parents[1] / "experiments" / "gallery" / "rare_levels.png"
EVEN, ENTROPY = "dr, equally likely options", "paired, adversary entropy 0.1"
VARIANTS = {EVEN: "dr", ENTROPY: "paired"}  # their methods
NAMES = {"dr": "DR", EVEN: "DR, equally\nlikely options", ENTROPY: "PAIRED,\nentropy 0.1"}
BARS = "Three bars of a method, from left to right: the program lists the rare option first, in the middle, last"
A_RUN, MEAN = "a run of PAIRED", "mean of {}"  # labels of lines
Rows = Sequence[Mapping[str, str]]


def draw(rows: Rows, fifths: int, path: Path = PICTURE) -> None:
    """Draw a column for each game: success on its rare scene, and the rare option's share of PAIRED's proposals.

    Args:
        rows: of runs, with percents of success in `scene_0` and shares in `rare_share_0`, `rare_share_1`, ...
        fifths: number of parts of a run with such shares.
        path: of the picture.
    """
    games = unique([row["game"] for row in rows])
    plots.distinguish(VARIANTS)
    with plots.style():
        import matplotlib.pyplot as plt

        size = (5.6 * len(games), 5.6)
        figure, grid = plt.subplots(2, len(games), figsize=size, sharey="row", squeeze=False, layout="constrained")
        for column, game in enumerate(games):
            mine = [row for row in rows if row["game"] == game]
            draw_success(grid[0, column], mine)
            draw_shares(grid[1, column], mine, fifths)
            grid[0, column].set_title(game)
        grid[0, 0].set_ylabel("success on the rare scene")
        grid[1, 0].set_ylabel("rare option's share\nof the proposals")
        lines = [line_handle(name) for name in ("paired", ENTROPY) if any(row["variant"] == name for row in rows)]
        marks = [keys.mark_handle(keys.WHISKER), run_handle(), thin_handle(), *lines]
        figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), title=BARS, title_fontsize=9)
        plots.save(figure, path)


def draw_success(axes: Any, rows: Rows) -> None:
    """Draw a group of bars for each setting, a bar for each order of the options, a dot for each run."""
    settings = unique([row["variant"] for row in rows])
    for place, setting in enumerate(settings):
        orders = unique([row["order"] for row in rows if row["variant"] == setting])
        for at, order in zip(places_of(place, len(orders)), orders, strict=True):
            chosen = [row for row in rows if (row["variant"], row["order"]) == (setting, order)]
            values = np.array([float(row["scene_0"]) / 100 for row in chosen])
            found = bootstrap(values, np.random.default_rng(0)).interval()
            axes.bar(at, found.estimate, WIDTH * 0.92, **plots.bar_look(setting))
            if found.known:
                axes.plot([at, at], [found.low, found.high], color=plots.INK, linewidth=1.3)
            spread = at + np.linspace(-0.3, 0.3, len(values)) * WIDTH
            axes.plot(spread, values, ".", color=plots.INK, markersize=3, alpha=0.55)
    axes.set_xticks(range(len(settings)), [NAMES.get(name, plots.title(name)) for name in settings])
    axes.grid(False, axis="x")
    plots.rate_axis(axes)


WIDTH = 0.26  # of a bar


def places_of(place: int, bars: int) -> np.ndarray:
    """Return the positions of the bars of a group: side by side around the group's position."""
    return place + (np.arange(bars) - (bars - 1) / 2) * WIDTH


def line_handle(setting: str) -> Any:
    """Return the legend handle for the mean over the runs of a PAIRED setting."""
    from matplotlib.lines import Line2D

    name = NAMES.get(setting, plots.title(setting)).replace("\n", " ")
    return Line2D([], [], linewidth=2.4, label=MEAN.format(name), **plots.curve_look(setting))


def thin_handle() -> Any:
    """Return the legend handle for a single run of PAIRED."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=A_RUN, **THIN)


THIN: dict[str, Any] = {"color": plots.FAINT, "linewidth": 0.6, "alpha": 0.6}  # of a run


def draw_shares(axes: Any, rows: Rows, fifths: int) -> None:
    """Draw the rare option's share of PAIRED's proposals in each part of a run: single runs, and means of settings."""
    centers = (np.arange(fifths) + 0.5) / fifths
    found: dict[str, list[list[float]]] = {}
    for row in rows:
        shares = [float(row[f"rare_share_{k}"] or "nan") for k in range(fifths)]
        if not np.all(np.isnan(shares)):
            found.setdefault(row["variant"], []).append(shares)
            axes.plot(centers, shares, **THIN)
    for name, runs in found.items():
        axes.plot(centers, np.nanmean(runs, 0), linewidth=2.4, zorder=plots.ABOVE_AXES, **plots.curve_look(name))
    axes.set_xlim(0, 1)
    axes.set_xlabel("fraction of training")
    plots.rate_axis(axes)
