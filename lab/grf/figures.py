"""Pictures of comparisons: small panels, each with a curve or points of ours and the original's.

Matplotlib is imported when a picture is drawn. Read next: a family, which fills the panels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy.typing as npt

from regista.experiments.pictures.plots import FAINT, save, style

OURS, GRF = "#e4572e", "#22262b"


@dataclass(frozen=True)
class Panel:
    """One small picture: x and y of the original's curve and of ours; with `points`, dots instead of lines."""

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
        figure, grid = plt.subplots(rows, columns, figsize=(2.4 * columns, 1.9 * rows), squeeze=False)
        for axes, panel in zip(grid.flat, panels, strict=False):
            marks = {"linestyle": "", "marker": "o", "markersize": 3} if panel.points else {"linewidth": 1.4}
            axes.plot(*panel.grf, color=GRF, **marks)
            axes.plot(*panel.ours, color=OURS, alpha=0.85, **marks)
            axes.set_title(panel.title, fontsize=8)
            axes.set_xlabel(panel.across, fontsize=7, color=FAINT)
            axes.set_ylabel(panel.up, fontsize=7, color=FAINT)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        figure.suptitle(f"{title}: ours (orange) and Google Research Football's (black)", x=0.02, ha="left")
        figure.tight_layout(rect=(0, 0, 1, 1 - 0.3 / (1.9 * rows)))
        save(figure, path)
