"""Pictures of comparisons: small panels, each with a curve or points of our simulator and of GRF.

Matplotlib is imported when a picture is drawn. Read next: a family, which fills the panels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy.typing as npt

from regista.experiments.pictures.plots import ABOVE_AXES, FAINT, INK, REFERENCE, rate_axis, save, style

OURS, GRF = "our simulator", "Google Research Football"
COLORS = {GRF: REFERENCE, OURS: INK}
SHOWN: dict[str, Any] = {"clip_on": False, "zorder": ABOVE_AXES}  # also at 0% and 100%
LINES: dict[str, dict[str, Any]] = {
    GRF: {"color": COLORS[GRF], "linewidth": 1.6, **SHOWN},
    OURS: {"color": COLORS[OURS], "linewidth": 1.2, "linestyle": "--", **SHOWN},
}
POINT: dict[str, Any] = {"linestyle": "", "marker": "o", **SHOWN}
POINTS: dict[str, dict[str, Any]] = {
    GRF: {"color": COLORS[GRF], "markersize": 4.5, "markerfacecolor": "none", **POINT},
    OURS: {"color": COLORS[OURS], "markersize": 2.5, **POINT},
}
SHARE = "share"  # label of the vertical axis of rates
HEAD, FOOT = 0.3, 0.3  # inches, for the title and the legend of a figure


@dataclass(frozen=True)
class Panel:
    """One small picture: x and y of GRF's curve and of ours; with `points`, dots instead of lines."""

    title: str
    grf: tuple[npt.ArrayLike, npt.ArrayLike]
    ours: tuple[npt.ArrayLike, npt.ArrayLike]
    across: str = ""
    up: str = ""
    points: bool = False


def draw_panels(path: Path, title: str, panels: Sequence[Panel], columns: int = 6) -> None:
    """Draw the panels in rows, with one legend. Raises CommandError if the file cannot be written."""
    import matplotlib.pyplot as plt

    columns = min(columns, len(panels))
    rows = math.ceil(len(panels) / columns)
    with style():
        height = 1.9 * rows + HEAD + FOOT
        figure, grid = plt.subplots(rows, columns, figsize=(2.4 * columns, height), squeeze=False)
        for axes, panel in zip(grid.flat, panels, strict=False):
            marks = POINTS if panel.points else LINES
            axes.plot(*panel.grf, **marks[GRF])
            axes.plot(*panel.ours, **marks[OURS])
            axes.set_title(panel.title, fontsize=8)
            axes.set_xlabel(panel.across, fontsize=7, color=FAINT)
            axes.set_ylabel(panel.up, fontsize=7, color=FAINT)
            if panel.up == SHARE:
                rate_axis(axes)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        figure.suptitle(title, x=0.02, ha="left")
        figure.legend(handles=_handles(panels), loc="lower center", ncols=4)
        figure.tight_layout(rect=(0, FOOT / height, 1, 1))  # leaves room for the title
        save(figure, path)


def _handles(panels: Sequence[Panel]) -> list[Any]:
    """Return the handles of a legend: both simulators, as lines or points like in the panels."""
    from matplotlib.lines import Line2D

    kinds = [marks for marks, points in ((LINES, False), (POINTS, True)) if points in {row.points for row in panels}]
    return [Line2D([], [], label=name, **marks[name]) for marks in kinds for name in (GRF, OURS)]
