"""The look of all pictures, and learning curves. Matplotlib is imported when a picture is drawn.

Colours: one per method everywhere; blue and red are the teams. Read next: `level_plots`, then `overview`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from experiments.table import cannot_write, read_columns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#22262b"
FAINT = "#8a9199"
METHOD_COLOURS = {"paired": "#e4572e", "dr": "#4a6fa5", "shoot": "#9aa3ab", "random": "#cfd5da"}
OTHER_COLOURS = ("#2a9d8f", "#8e6bbf", "#c99700", "#b5446e")
METHOD_NAMES = {"paired": "PAIRED", "dr": "domain randomisation", "shoot": "shoot at once", "random": "random"}
WINDOW = 0.04  # of a curve's length: its running mean

STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#c6ccd2",
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#eceff1",
    "grid.linewidth": 0.8,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.dpi": 160,
}


class Curve(NamedTuple):
    """One metric of several runs on a common axis: `steps` [X], `values` [R, X] (NaN before a run's first value)."""

    steps: np.ndarray
    values: np.ndarray


def style() -> AbstractContextManager:
    """Give the context in which pictures are drawn."""
    import matplotlib

    matplotlib.use("Agg")
    return matplotlib.rc_context(STYLE)


def colour(method: str) -> str:
    """Give the colour of a method."""
    if method in METHOD_COLOURS:
        return METHOD_COLOURS[method]
    return OTHER_COLOURS[sum(map(ord, method)) % len(OTHER_COLOURS)]


def title(method: str) -> str:
    """Give the name of a method as a picture shows it."""
    return METHOD_NAMES.get(method, method)


def save(figure: Figure, path: Path) -> None:
    """Write a picture and free it. Raises `CommandError` if the disk refuses."""
    import matplotlib.pyplot as plt

    try:
        figure.savefig(path, bbox_inches="tight", pad_inches=0.15)
    except OSError as error:
        raise cannot_write(path, error) from error
    finally:
        plt.close(figure)


def marker_legend(figure: Figure, painter: Any) -> None:
    """Say beneath a figure which colour stands for whom, for those who are there."""
    from matplotlib.lines import Line2D

    from envs.football.render import PAPER_COLOURS

    handles = [
        Line2D([], [], marker="o", linestyle="", color=PAPER_COLOURS[kind], label=painter.markers[kind][0])
        for kind in sorted(set(painter.classes.tolist()))
    ]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), bbox_to_anchor=(0.5, 0.0))


# ---------------------------------------------------------------- learning curves


def read_curve(runs: Sequence[Path], column: str, points: int = 200) -> Curve | None:
    """Read a column of the runs' metrics onto a common axis of env_steps; None if no run has it."""
    found = []
    for run in runs:
        table = read_columns(run / "metrics.csv")
        if column in table:
            known = np.isfinite(table[column])
            if known.any():
                found.append((table["env_steps"][known], table[column][known]))
    if not found:
        return None
    steps = np.linspace(min(x[0] for x, _ in found), max(x[-1] for x, _ in found), points)
    values = np.stack([np.interp(steps, x, _running_mean(y), left=np.nan, right=np.nan) for x, y in found])
    return Curve(steps, values)


def draw_curve(axes: Axes, curve: Curve, method: str, label: str | None = None) -> None:
    """Draw the mean of the runs, the runs themselves as thin lines, and the range between them as a band."""
    shade = colour(method)
    steps, values = curve.steps / 1e6, curve.values
    known = np.isfinite(values).any(0)
    steps, values = steps[known], values[:, known]
    if len(values) > 1:
        axes.fill_between(steps, np.nanmin(values, 0), np.nanmax(values, 0), color=shade, alpha=0.14, linewidth=0)
        for row in values:
            axes.plot(steps, row, color=shade, linewidth=0.7, alpha=0.45)
    axes.plot(steps, np.nanmean(values, 0), color=shade, linewidth=2.0, label=label or title(method))


def learning_curves(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Draw the return on every test scene, on the levels trained on, and the regret, over env_steps.

    `runs` gives the run folders of each method.
    """
    import matplotlib.pyplot as plt

    panels = _panels(runs)
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    with style():
        figure, grid = plt.subplots(rows, columns, figsize=(3.9 * columns, 2.75 * rows), squeeze=False)
        for axes, (heading, curves) in zip(grid.flat, panels.items(), strict=False):
            for method, curve in curves:
                draw_curve(axes, curve, method)
            axes.set_title(heading)
            axes.margins(x=0.01)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        for axes in grid[-1]:
            axes.set_xlabel("simulated steps, all students (millions)")
        for line in grid[:, 0]:
            line.set_ylabel("mean return")
        _legend(figure, grid.flat[0])
        figure.tight_layout(rect=(0, 0, 1, 1 - 0.28 / figure.get_figheight()))
        save(figure, path)


def _panels(runs: Mapping[str, Sequence[Path]]) -> dict[str, list[tuple[str, Curve]]]:
    """Give heading to (method, curve): the test scenes, then what the method trained on, then regret."""
    columns: dict[str, tuple[str, ...]] = {}
    for paths in runs.values():
        for name in read_columns(paths[0] / "metrics.csv"):
            if name.startswith("eval/"):
                columns.setdefault(_scene_heading(name.removeprefix("eval/")), (name,))
    columns["return on the levels trained on"] = ("return/student", "return/protagonist")
    columns["regret of the levels trained on"] = ("regret",)
    panels = {}
    for heading, names in columns.items():
        curves = [(method, read_curve(paths, name)) for method, paths in runs.items() for name in names]
        known = [(method, curve) for method, curve in curves if curve is not None]
        if known:
            panels[heading] = known
    return panels


def _scene_heading(scene: str) -> str:
    return f"return on the {scene}" if "distribution" in scene else f"return on test scene “{scene}”"


def _running_mean(values: np.ndarray) -> np.ndarray:
    """Average over a window of WINDOW of the curve; its ends use what there is."""
    width = max(1, int(WINDOW * len(values)))
    if len(values) < 40 or width < 2:
        return values
    kernel = np.ones(width)
    return np.convolve(values, kernel, "same") / np.convolve(np.ones(len(values)), kernel, "same")


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper left", ncols=len(labels), bbox_to_anchor=(0.01, 1.0))
