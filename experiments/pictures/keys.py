"""Legends: methods, the meaning of lines, bands and whiskers, and the scales of densities.

Read next: `pictures.level_plots`, which draws the densities.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from regista.experiments.pictures import plots

MEAN, RUN, WHISKER = "mean of runs", "a run", "95% CI"
RANGE, MIDDLE, INTERVAL = "range of runs", "middle half of runs", "95% CI of the mean"  # bands
RUNS = (MEAN, RUN, RANGE)
OPACITY, POWER = 0.88, 0.6  # at the highest density; exponent, which makes low densities visible
SCALE_HEIGHT = 0.62  # inches below a figure for the scales of densities
BAR_HEIGHT = 0.09  # inches, of a scale


def method_handles(methods: Iterable[str], marks: Sequence[str] = (), filled: bool = False) -> list[Any]:
    """Return the handles of a legend: methods as lines or `filled` patches, then the `marks` in gray."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    names = list(methods)
    for name in names:
        label, look = plots.title(name), plots.curve_look(name, len(names))
        line = Line2D([], [], linewidth=2.0, label=label, **look)
        handles.append(Patch(**plots.bar_look(name), label=label) if filled else line)
    return handles + [mark_handle(mark) for mark in marks]


def mark_handle(mark: str) -> Any:
    """Return the handle of a kind of mark: MEAN, RUN, WHISKER or a band."""
    from matplotlib.container import ErrorbarContainer
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    if mark in (RANGE, MIDDLE, INTERVAL):
        return Patch(facecolor=plots.FAINT, alpha=0.3, linewidth=0, label=mark)
    if mark == WHISKER:
        line = Line2D([], [], color=plots.INK, linewidth=0)
        cap: Any = Line2D([], [], color=plots.INK, marker="_", linewidth=0)
        return ErrorbarContainer((line, (cap,), (_bar(),)), has_yerr=True, label=mark)
    return Line2D([], [], color=plots.FAINT, linewidth=2.0 if mark == MEAN else 0.7, label=mark)


def _bar() -> Any:
    from matplotlib.collections import LineCollection

    return LineCollection([], colors=[plots.INK], linewidths=[0.9])


def columns_for(handles: Sequence[Any], inches: float) -> int:
    """Return the number of legend columns for a width, at most `plots.LEGEND_COLUMNS`, in rows of similar length."""
    longest = max(len(handle.get_label()) for handle in handles)
    most = int(np.clip(inches / (0.55 + 0.075 * longest), 1, min(plots.LEGEND_COLUMNS, len(handles))))
    rows = -(-len(handles) // most)
    return -(-len(handles) // rows)


def opacity(density: np.ndarray) -> np.ndarray:
    """Return the opacity of densities relative to the maximum of their panel."""
    return OPACITY * np.clip(density, 0, 1) ** POWER


def density_scales(figure: Any, kinds: Sequence[tuple[str, Any]]) -> None:
    """Draw a density scale for each kind (name, color) of points, `SCALE_HEIGHT` inches high, below a (sub)figure."""
    from matplotlib.colors import to_rgb

    box = figure.bbox.transformed(figure.dpi_scale_trans.inverted())
    width, height = box.width, box.height
    share = np.linspace(0, 1, 128)
    for index, (name, shade) in enumerate(kinds):
        bar = min(2.2, 0.75 * width / len(kinds))  # inches
        left = (index + 0.5) * width / len(kinds) - bar / 2
        axes = figure.add_axes((left / width, 0.33 / height, bar / width, BAR_HEIGHT / height))
        veil = np.ones((1, len(share), 4))
        veil[..., :3], veil[..., 3] = to_rgb(shade), opacity(share)
        axes.imshow(veil, extent=(0, 1, 0, 1), aspect="auto", origin="lower")
        axes.set(yticks=[], xticks=[0, 0.5, 1], xticklabels=["0", "0.5", "1"])
        axes.tick_params(length=2, labelsize=7, pad=1)
        axes.set_xlabel("density / maximum of its panel", fontsize=7, labelpad=1, color=plots.FAINT)
        axes.set_title(name, fontsize=8.5, fontweight="normal", loc="center", pad=2)
        axes.grid(False)
