"""The style of all pictures. Matplotlib is imported when a picture is drawn.

Each method has the same color in all pictures. These colors differ from those of teams, and color-blind readers can
distinguish them. Variants of a method share its hue, see `pictures.variants`. In pictures of many methods, curves also
have markers, which remain distinct in grayscale.

Read next: `pictures.keys`, legends; `pictures.curves`, `pictures.level_plots`; then `pictures.overview`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from regista.experiments.pictures.variants import Look, looks
from regista.experiments.run.progress import count
from regista.experiments.run.results import BASELINE
from regista.experiments.run.table import cannot_write
from ued.core.files import write_whole
from ued.methods import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ued.statistics import Interval

INK = "#22262b"
FAINT = "#8a9199"
REFERENCE = "#b0006d"  # of references: weights of a program, measurements
BASELINES = {
    "shoot": ("shoot at once", "#9aa3ab"),
    "random": ("random", "#cfd5da"),
    "built-in": ("built-in AI", "#6f7a84"),
}
METHOD_COLORS = {name: row.color for name, row in METHODS.items()} | {k: color for k, (_, color) in BASELINES.items()}
OTHER_COLOR = "#5f6670"
METHOD_NAMES = {name: row.title for name, row in METHODS.items()} | {k: title for k, (title, _) in BASELINES.items()}
CYCLE = ("#b0006d", "#005f3c", "#cc79a7", "#7a9a01", "#4d7f17", "#e377e0")  # of things other than methods
MARKERS = {name: row.marker for name, row in METHODS.items()}  # of their curves
SLIGHT = {"*": 1.7, "X": 1.2, "P": 1.2, "p": 1.15}  # size factors of markers that look smaller than others
MANY = 5  # minimum number of methods in a picture for markers on curves
BETWEEN_MARKERS = 0.12  # distance on a curve, relative to the diagonal of its axes
ABOVE_AXES = 2.6  # zorder of curves: with a lower one, the axis would cover a curve at 0
LEGEND_COLUMNS = 6  # maximum number of columns in a legend
CHARACTER = 0.084  # inches, mean width of a character of a heading

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],  # an SVG lists all, for machines without the first
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
    "axes.prop_cycle": f"cycler('color', {list(CYCLE)})",
    "savefig.dpi": 160,
    "pdf.fonttype": 42,  # TrueType: publishers reject Type 3
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "regista",  # the same picture gives the same file
}

PictureFormat = Literal["png", "svg", "pdf"]
FORMATS: tuple[str, ...] = get_args(PictureFormat)
FORMAT_HELP = "file format of pictures"
UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}  # no timestamps, for reproducible files


def style() -> AbstractContextManager:
    """Return the Matplotlib style context of all pictures."""
    import matplotlib

    matplotlib.use("Agg")
    return matplotlib.rc_context(STYLE)


_variants: dict[str, Look] = {}  # looks of the current comparison's variants
_methods: dict[str, str] = {}  # their methods


def distinguish(variants: Mapping[str, str]) -> None:
    """Assign each variant of a comparison its own look in the hue of its method; `variants` maps variant to method."""
    _variants.clear()
    _variants.update(looks(variants, METHOD_COLORS))
    _methods.clear()
    _methods.update(variants)


def color(method: str) -> str:
    """Return the color of a method, a variant or a baseline."""
    if method in _variants:
        return _variants[method].color
    return METHOD_COLORS.get(method.removesuffix(BASELINE), OTHER_COLOR)


def bar_look(method: str) -> dict[str, Any]:
    """Return the style of bars and patches of a method or a variant; those of variants are hatched."""
    hatch = {"hatch": _variants[method].hatch, "edgecolor": "white"} if method in _variants else {}
    return {"facecolor": color(method), "linewidth": 0} | hatch


def sequence(count: int) -> list[Any]:
    """Return `count` colors from light to dark, in an order that color-blind readers can recognize."""
    from matplotlib import colormaps

    return list(colormaps["viridis_r"](np.linspace(0.15, 1, count)))


def line_style(method: str) -> Any:
    """Return the line style of a method's curves; those of variants are dashed."""
    return _variants[method].dashes if method in _variants else "-"


def curve_look(method: str, among: int = 1) -> dict[str, Any]:
    """Return the style of curves of a method or a variant: color, line style, and a marker among MANY or more."""
    look: dict[str, Any] = {"color": color(method), "linestyle": line_style(method)}
    return look | marker_look(method, 5.5) if among >= MANY else look


def marker_look(method: str, size: float) -> dict[str, Any]:
    """Return the marker style of a method's curves. A variant has the marker of its method.

    Markers of different methods start at different offsets along the curve, so they do not cover each other.
    """
    known = _methods.get(method, method)
    begin = [*MARKERS].index(known) / len(MARKERS) * BETWEEN_MARKERS if known in MARKERS else 0.0
    marker = MARKERS.get(known, "o")
    look = {"marker": marker, "markersize": size * SLIGHT.get(marker, 1.0), "markeredgecolor": "white"}
    return look | {"markeredgewidth": 0.6, "markevery": (begin, BETWEEN_MARKERS)}


def whisker(axes: Axes, at: float, interval: Interval, method: str) -> None:
    """Draw an interval at position `at` of the horizontal axis, with the method's marker at the estimate.

    Without a known interval, draw nothing.
    """
    if interval.known:
        low, high = interval.estimate - interval.low, interval.high - interval.estimate
        span = [[max(low, 0.0)], [max(high, 0.0)]]  # rounding errors may make a length negative
        shade = color(method)
        axes.errorbar(at, interval.estimate, span, color=shade, elinewidth=1.3, capsize=2.5)
        mark = {key: value for key, value in marker_look(method, 5.0).items() if key != "markevery"}
        axes.plot([at], [interval.estimate], color=shade, linestyle="", zorder=ABOVE_AXES, clip_on=False, **mark)


def leave_room(axes: Axes, end: float, until: float) -> None:
    """Extend the horizontal axis from 0 to `until`, to make room for whiskers beyond the `end` of the curves.

    There are no ticks beyond `end`, since the positions of whiskers are not numbers of steps.
    """
    axes.set_xlim(0, until)
    axes.set_xticks([tick for tick in axes.get_xticks() if 0 <= tick <= 1.001 * end])


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
    """Return the path of a picture with the extension of a file format; None: that of the path, or png.

    Raises `ValueError` for an unknown extension without a format.
    """
    if kind is None and path.suffix[1:].lower() in FORMATS:
        return path
    if kind is None and path.suffix:
        endings = " or ".join(f".{name}" for name in FORMATS)
        raise ValueError(f"{path.name}: the name of a picture must end in {endings}; --format chooses one, too")
    known = path.suffix[1:].lower() in FORMATS
    return path.with_suffix(f".{kind or 'png'}") if known else path.with_name(f"{path.name}.{kind or 'png'}")


def heading(axes: Axes, text: str) -> int:
    """Set the title of axes, wrapped at their width; return the number of lines."""
    figure: Any = axes.get_figure(root=True)
    lines = textwrap.wrap(text, fitting(figure.get_figwidth() * axes.get_position().width))
    axes.set_title("\n".join(lines))
    return len(lines)


def fitting(inches: float) -> int:
    """Return the number of characters of a heading that fit this width."""
    return max(8, int(inches / CHARACTER))


def rate_axis(axes: Axes) -> None:
    """Set the limits of the vertical axis of rates to [0, 1], with labels in percent."""
    from matplotlib.ticker import PercentFormatter

    axes.set_ylim(0, 1)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))


def begin_at_zero(axes: Axes) -> None:
    """Start the horizontal axis at 0 steps, and the vertical axis at 0 if no value is negative."""
    axes.set_xlim(left=0)
    curves = [np.asarray(line.get_ydata(), float) for line in axes.lines]
    ends = [np.nanmin(curve) for curve in curves if len(curve)]
    if ends and min(ends) >= 0:
        axes.set_ylim(bottom=0)


def marker_legend(figure: Figure, painter: Any, places: np.ndarray) -> None:
    """Add a legend of marker colors below a figure, for classes with `places` `[L, K, 2]` inside the bounds."""
    from matplotlib.lines import Line2D

    from regista.envs.football.view.render import PAPER_COLORS

    x_low, x_high, y_low, y_high = painter.bounds
    inside = ((places >= (x_low, y_low)) & (places <= (x_high, y_high))).all(2).any(0)  # [K]
    handles = [
        Line2D([], [], marker="o", linestyle="", color=PAPER_COLORS[kind], label=painter.markers[kind][0])
        for kind in np.unique(painter.classes[inside])
    ]
    handles.append(Line2D([], [], color=FAINT, linewidth=1.6, label="heading"))
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), bbox_to_anchor=(0.5, 0.0))


def label_steps(axes: Axes) -> None:
    """Label the horizontal axis as steps, with short numbers."""
    axes.set_xlabel("simulated steps, all students")
    shorten_steps(axes)


def shorten_steps(axes: Axes) -> None:
    """Format the numbers of the horizontal axis as 500k, 2M."""
    axes.xaxis.set_major_formatter(lambda value, _: count(value))
