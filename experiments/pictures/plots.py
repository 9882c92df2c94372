"""The style of all pictures, and learning curves. Matplotlib is imported when a picture is drawn.

Each method has the same color in all pictures, which no team has and which readers with a color vision deficiency can
tell from the others. Read next: `pictures.keys`, legends; `pictures.level_plots`, then `pictures.overview`.
"""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

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
REFERENCE = "#b0006d"  # of what is compared with: weights of a program, measurements
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
VARIANT_COLOURS = ("#b0006d", "#005f3c", "#cc79a7", "#7a9a01", "#4d7f17", "#e377e0")  # of dashed curves
LEGEND_COLUMNS = 6  # maximum number of columns in a legend
CHARACTER = 0.084  # inches, mean width of a character of a heading
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
    "axes.prop_cycle": f"cycler('color', {list(VARIANT_COLOURS)})",  # of what is no method
    "savefig.dpi": 160,
    "pdf.fonttype": 42,  # TrueType: publishers reject Type 3
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "regista",  # the same picture gives the same file
}

PictureFormat = Literal["png", "svg", "pdf"]
FORMATS: tuple[str, ...] = get_args(PictureFormat)
FORMAT_HELP = "file format of pictures"
UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}  # metadata that would differ from call to call


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
    """Give the variants of a comparison colors of their own; those of more than six repeat."""
    _variant_colours.clear()
    _variant_colours.update(zip(variants, itertools.cycle(VARIANT_COLOURS), strict=False))


def colour(method: str) -> str:
    """Return the color of a method or a variant."""
    return METHOD_COLOURS.get(method) or _variant_colours.get(method, OTHER_COLOUR)


def line_style(method: str) -> Literal["-", "--"]:
    """Return the line style of a method's curves; those of variants are dashed."""
    return "--" if method in _variant_colours else "-"


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

    drawn, kind = BytesIO(), path.suffix[1:].lower() or "png"
    figure.savefig(drawn, format=kind, bbox_inches="tight", pad_inches=0.15, metadata=UNDATED.get(kind))
    plt.close(figure)
    try:
        write_whole(path, drawn.getvalue())
    except OSError as error:
        raise cannot_write(path, error) from error


def in_format(path: Path, kind: str | None) -> Path:
    """Return the path of a picture in a file format; without one it is the ending of the path, or png."""
    if kind is None and path.suffix[1:].lower() in FORMATS:
        return path
    known = path.suffix[1:].lower() in FORMATS
    return path.with_suffix(f".{kind or 'png'}") if known else path.with_name(f"{path.name}.{kind or 'png'}")


def heading(axes: Axes, text: str) -> int:
    """Set the title of axes, in as many lines as their width needs; return the number of lines."""
    figure: Any = axes.get_figure(root=True)
    lines = textwrap.wrap(text, fitting(figure.get_figwidth() * axes.get_position().width))
    axes.set_title("\n".join(lines))
    return len(lines)


def fitting(inches: float) -> int:
    """Return the number of characters of a heading that fit this width."""
    return max(8, int(inches / CHARACTER))


def rate_axis(axes: Axes) -> None:
    """Let the vertical axis of rates go from 0 to 1, with labels in percent."""
    from matplotlib.ticker import PercentFormatter

    axes.set_ylim(0, 1)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))


def begin_at_zero(axes: Axes) -> None:
    """Let curves begin at no steps, and the vertical axis at 0 where no value is negative."""
    axes.set_xlim(left=0)
    curves = [np.asarray(line.get_ydata(), float) for line in axes.lines]
    ends = [np.nanmin(curve) for curve in curves if len(curve)]
    if ends and min(ends) >= 0:
        axes.set_ylim(bottom=0)


def marker_legend(figure: Figure, painter: Any) -> None:
    """Add a legend of the present marker colors below a figure."""
    from matplotlib.lines import Line2D

    from regista.envs.football.view.render import PAPER_COLOURS

    handles = [
        Line2D([], [], marker="o", linestyle="", color=PAPER_COLOURS[kind], label=painter.markers[kind][0])
        for kind in sorted(set(painter.classes.tolist()))
    ]
    handles.append(Line2D([], [], color=FAINT, linewidth=1.6, label="heading"))
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
    label, dashes = label or title(method), line_style(method)
    axes.plot(steps, np.nanmean(values, 0), color=shade, linewidth=2.0, linestyle=dashes, label=label)


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

    from regista.experiments.pictures import keys

    panels = _panels(runs)
    if not panels:
        return None
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    wide = 3.9 * columns  # inches, as below
    handles = keys.method_handles(runs, keys.RUNS if any(len(paths) > 1 for paths in runs.values()) else ())
    across = keys.columns_for(handles, wide)
    legend = 0.1 + 0.18 * -(-len(handles) // across)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(wide, 2.75 * rows + legend))
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (name, panel) in zip(grid.flat, panels.items(), strict=False):
            _draw_panel(axes, name, panel)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(panels) - columns) : len(panels)]:
            label_steps(axes)
        figure.legend(handles=handles, loc="upper left", ncols=across, bbox_to_anchor=(0.01, 1.0))
        figure.tight_layout(rect=(0, 0, 1, 1 - legend / figure.get_figheight()))
    return figure


class Panel(NamedTuple):
    """Content of one panel: its unit, the curve of each method that has one, and whether its values are rates."""

    unit: str
    curves: list[tuple[str, Curve]]
    rate: bool = False


def _draw_panel(axes: Axes, name: str, panel: Panel) -> None:
    for method, curve in panel.curves:
        draw_curve(axes, curve, method)
    heading(axes, name)
    axes.set_ylabel(panel.unit)
    axes.margins(x=0.01)
    begin_at_zero(axes)
    if panel.rate:
        rate_axis(axes)
    shorten_steps(axes)


def _panels(runs: Mapping[str, Sequence[Path]]) -> dict[str, Panel]:
    """Return panels by heading: the test scenes, then properties of the training levels."""
    headers = {method: read_header(paths[0] / "metrics.csv") for method, paths in runs.items()}
    scenes = dict.fromkeys(name for header in headers.values() for name in header if name.startswith("eval/"))
    quantities = {_scene_heading(name.removeprefix("eval/")): (name, "mean return") for name in scenes}
    quantities["return on training levels"] = ("return/", "mean return")
    quantities["success on training levels"] = ("success", "share of episodes")
    quantities["regret of training levels"] = ("regret", "regret")
    quantities["spread of training levels"] = ("theta_std", "std of θ (uniform: 0.58)")
    panels = {}
    for heading, (name, unit) in quantities.items():
        curves = []
        for method, paths in runs.items():
            column = next((header for header in headers[method] if _is_column(header, name)), None)
            curve = read_curve(paths, column) if column else None
            if curve is not None:
                curves.append((method, curve))
        if curves:
            panels[heading] = Panel(unit, curves, rate=name == "success")
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
