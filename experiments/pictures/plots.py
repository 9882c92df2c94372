"""The style of all pictures, and learning curves. Matplotlib is imported when a picture is drawn.

Each method has the same color in all pictures; blue and red are the teams. Read next: `pictures.level_plots`, then
`pictures.overview`.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from regista.experiments.run.progress import count
from regista.experiments.run.table import cannot_write, read_columns, read_header
from ued.core.files import write_whole
from ued.methods import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#22262b"
FAINT = "#8a9199"
BASELINES = {
    "shoot": ("shoot at once", "#9aa3ab"),
    "random": ("random", "#cfd5da"),
    "built-in": ("built-in AI", "#6f7a84"),
}
METHOD_COLOURS = {name: row.colour for name, row in METHODS.items()} | {
    k: colour for k, (_, colour) in BASELINES.items()
}
OTHER_COLOUR = "#5f6670"
METHOD_NAMES = {name: row.title for name, row in METHODS.items()} | {k: title for k, (title, _) in BASELINES.items()}
VARIANT_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")  # Okabe and Ito 2008
LEGEND_COLUMNS = 6  # maximum number of columns in a legend
WINDOW = 0.04  # window of the running mean, relative to the curve's length

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
    """Return the Matplotlib style context of all pictures."""
    import matplotlib

    matplotlib.use("Agg")
    return matplotlib.rc_context(STYLE)


_variant_colours: dict[str, str] = {}  # of the comparison that is drawn


def distinguish(variants: Sequence[str]) -> None:
    """Give the variants of a comparison colors of their own; those of more than seven repeat."""
    _variant_colours.clear()
    _variant_colours.update(zip(variants, itertools.cycle(VARIANT_COLOURS), strict=False))


def colour(method: str) -> str:
    """Return the color of a method or a variant."""
    return METHOD_COLOURS.get(method) or _variant_colours.get(method, OTHER_COLOUR)


def title(method: str) -> str:
    """Return the display name of a method."""
    return METHOD_NAMES.get(method, method)


def listed(methods: Sequence[str]) -> str:
    """Return the display names of methods as an enumeration."""
    *others, last = map(title, methods)
    return f"{', '.join(others)} and {last}" if others else last


def save(figure: Figure, path: Path) -> None:
    """Write a picture atomically and close the figure. Raises `CommandError` if it cannot be written."""
    import matplotlib.pyplot as plt

    drawn = BytesIO()
    figure.savefig(drawn, format=path.suffix[1:] or None, bbox_inches="tight", pad_inches=0.15)
    plt.close(figure)
    try:
        write_whole(path, drawn.getvalue())
    except OSError as error:
        raise cannot_write(path, error) from error


def marker_legend(figure: Figure, painter: Any) -> None:
    """Add a legend of the present marker colors below a figure."""
    from matplotlib.lines import Line2D

    from regista.envs.football.view.render import PAPER_COLOURS

    handles = [
        Line2D([], [], marker="o", linestyle="", color=PAPER_COLOURS[kind], label=painter.markers[kind][0])
        for kind in sorted(set(painter.classes.tolist()))
    ]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), bbox_to_anchor=(0.5, 0.0))


# ---------------------------------------------------------------- learning curves


def read_curve(runs: Sequence[Path], column: str, points: int = 200) -> Curve | None:
    """Read a column of the runs' metrics onto a common axis of env_steps; None if no run has it."""
    curves = []
    for run in runs:
        table = read_columns(run / "metrics.csv")
        if column in table:
            known = np.isfinite(table[column])
            if known.any():
                curves.append((table["env_steps"][known], table[column][known]))
    if not curves:
        return None
    steps = np.linspace(min(x[0] for x, _ in curves), max(x[-1] for x, _ in curves), points)
    values = np.stack([np.interp(steps, x, _running_mean(y), left=np.nan, right=np.nan) for x, y in curves])
    return Curve(steps, values)


def draw_curve(axes: Axes, curve: Curve, method: str, label: str | None = None) -> None:
    """Draw the mean of the runs, the runs themselves as thin lines, and the range between them as a band."""
    shade = colour(method)
    steps, values = curve.steps, curve.values
    known = np.isfinite(values).any(0)
    steps, values = steps[known], values[:, known]
    if len(values) > 1:
        axes.fill_between(steps, np.nanmin(values, 0), np.nanmax(values, 0), color=shade, alpha=0.14, linewidth=0)
        for row in values:
            axes.plot(steps, row, color=shade, linewidth=0.7, alpha=0.45)
    axes.plot(steps, np.nanmean(values, 0), color=shade, linewidth=2.0, label=label or title(method))


def label_steps(axes: Axes) -> None:
    """Label the horizontal axis, with short numbers."""
    axes.set_xlabel("simulated steps, all students")
    shorten_steps(axes)


def shorten_steps(axes: Axes) -> None:
    """Format the numbers of the horizontal axis as 500k, 2M."""
    axes.xaxis.set_major_formatter(lambda value, _: count(value))


def learning_curves(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Write `learning_figure` to a file; none without a finished update."""
    with style():
        figure = learning_figure(runs)
        if figure is not None:
            save(figure, path)


def learning_figure(runs: Mapping[str, Sequence[Path]]) -> Figure | None:
    """Draw the return on every test scene, and return, success, regret and spread of θ on the training levels.

    `runs` gives the run folders of each method. Curves are over env_steps, with gaps where no level was finished.
    Returns None without a finished update. The figure belongs to no window of pyplot.
    """
    import matplotlib
    from matplotlib.figure import Figure

    panels = _panels(runs)
    if not panels:
        return None
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    legend = 0.1 + 0.18 * -(-len(runs) // LEGEND_COLUMNS)  # inches
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(3.9 * columns, 2.75 * rows + legend))
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (heading, panel) in zip(grid.flat, panels.items(), strict=False):
            for method, curve in panel.curves:
                draw_curve(axes, curve, method)
            axes.set_title(heading)
            axes.set_ylabel(panel.unit)
            axes.margins(x=0.01)
            shorten_steps(axes)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(panels) - columns) : len(panels)]:
            label_steps(axes)
        _legend(figure, runs)
        figure.tight_layout(rect=(0, 0, 1, 1 - legend / figure.get_figheight()))
    return figure


class Panel(NamedTuple):
    """Content of one panel: its unit, and the curve of each method that has one."""

    unit: str
    curves: list[tuple[str, Curve]]


def _panels(runs: Mapping[str, Sequence[Path]]) -> dict[str, Panel]:
    """Return panels by heading: the test scenes, then properties of the training levels."""
    headers = {method: read_header(paths[0] / "metrics.csv") for method, paths in runs.items()}
    scenes = dict.fromkeys(name for header in headers.values() for name in header if name.startswith("eval/"))
    quantities = {_scene_heading(name.removeprefix("eval/")): (name, "mean return") for name in scenes}
    quantities["return on training levels"] = ("return/", "mean return")
    quantities["success on training levels"] = ("success", "share of episodes")
    quantities["regret of training levels"] = ("regret", "regret")
    quantities["spread of training levels"] = ("theta_std", "standard deviation of θ (uniform: 0.58)")
    panels = {}
    for heading, (name, unit) in quantities.items():
        curves = []
        for method, paths in runs.items():
            column = next((header for header in headers[method] if _is_column(header, name)), None)
            curve = read_curve(paths, column) if column else None
            if curve is not None:
                curves.append((method, curve))
        if curves:
            panels[heading] = Panel(unit, curves)
    return panels


def _is_column(column: str, name: str) -> bool:
    """Return whether a column has this name. The first return column belongs to the evaluated student."""
    return column.startswith(name) if name.endswith("/") else column == name


def _scene_heading(scene: str) -> str:
    return f"return on the {scene}" if "distribution" in scene else f"return on test scene “{scene}”"


def _running_mean(values: np.ndarray) -> np.ndarray:
    """Smooth with a running mean over WINDOW of the curve; windows are shorter at the ends."""
    width = max(1, int(WINDOW * len(values)))
    if len(values) < 40 or width < 2:
        return values
    kernel = np.ones(width)
    return np.convolve(values, kernel, "same") / np.convolve(np.ones(len(values)), kernel, "same")


def _legend(figure: Figure, methods: Iterable[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=colour(method), linewidth=2.0, label=title(method)) for method in methods]
    columns = min(LEGEND_COLUMNS, len(handles))
    figure.legend(handles=handles, loc="upper left", ncols=columns, bbox_to_anchor=(0.01, 1.0))
