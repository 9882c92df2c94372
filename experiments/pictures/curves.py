"""Learning curves: returns on test scenes and properties of training levels, over environment steps.

Read next: `pictures.plots`, the style of all pictures; `pictures.keys`, legends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from regista.experiments.pictures import keys, plots
from regista.experiments.run.table import read_columns, read_header

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WINDOW = 0.04  # window of the running mean, relative to the curve's length
FEW = 15  # with fewer values per run, each value has a marker, since a line alone suggests more data
APART = 0.01  # minimum distance between markers, relative to the curve: runs are evaluated at slightly different steps
EPISODES = 20  # minimum number of finished episodes per plotted value on training levels


class Curve(NamedTuple):
    """One metric of several runs on a common axis: `steps` [X], `values` [R, X] (NaN before a run's first value).

    `few`: each run has fewer than FEW values, and the axis consists of their steps.
    """

    steps: np.ndarray
    values: np.ndarray
    few: bool = False


def learning_curves(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Write `learning_figure` to a file; write nothing without a finished update."""
    with plots.style():
        figure = learning_figure(runs)
        if figure is not None:
            plots.save(figure, path)


def learning_figure(runs: Mapping[str, Sequence[Path]]) -> Figure | None:
    """Draw the return on every test scene, and return, success, regret and spread of θ on the training levels.

    `runs` gives the run folders of each method. Curves are over env_steps; a line bridges updates without finished
    levels. Returns None without a finished update. The figure is not registered with pyplot.
    """
    import matplotlib
    from matplotlib.figure import Figure

    panels = _panels(runs)
    if not panels:
        return None
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    wide = 3.9 * columns  # inches, as below
    handles = keys.method_handles(runs, keys.RUNS if any(len(paths) > 1 for paths in runs.values()) else ())
    across = keys.columns_for(handles, wide)
    legend = 0.1 + 0.18 * -(-len(handles) // across)
    with matplotlib.rc_context(plots.STYLE):
        figure = Figure(figsize=(wide, 2.75 * rows + legend))
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, (name, panel) in zip(grid.flat, panels.items(), strict=False):
            _draw_panel(axes, name, panel, len(runs))
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(panels) - columns) : len(panels)]:
            plots.label_steps(axes)
        figure.legend(handles=handles, loc="upper left", ncols=across, bbox_to_anchor=(0.01, 1.0))
        figure.tight_layout(rect=(0, 0, 1, 1 - legend / figure.get_figheight()))
    return figure


class Panel(NamedTuple):
    """Content of one panel: its unit, the curve of each method that has one, and whether its values are rates."""

    unit: str
    curves: list[tuple[str, Curve]]
    rate: bool = False


def _draw_panel(axes: Axes, name: str, panel: Panel, among: int) -> None:
    for method, curve in panel.curves:
        draw_curve(axes, curve, method, among=among)
    plots.heading(axes, name)
    axes.set_ylabel(panel.unit)
    axes.margins(x=0.01)
    plots.begin_at_zero(axes)
    if panel.rate:
        plots.rate_axis(axes)
    plots.shorten_steps(axes)


def _panels(runs: Mapping[str, Sequence[Path]]) -> dict[str, Panel]:
    """Return panels by heading: the test scenes, then properties of the training levels."""
    headers = {
        method: [*dict.fromkeys(name for path in paths for name in read_header(path / "metrics.csv"))]
        for method, paths in runs.items()
    }
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
            curve = read_curve(paths, column, weights=_episodes_of(column)) if column else None
            if curve is not None:
                curves.append((method, curve))
        if curves:
            panels[heading] = Panel(unit, curves, rate=name == "success")
    return panels


def _is_column(column: str, name: str) -> bool:
    """Return whether a column has this name. The first return column belongs to the evaluated student."""
    return column.startswith(name) if name.endswith("/") else column == name


def _episodes_of(column: str) -> str | None:
    """Return the column with the number of episodes per value; None for test scenes and θ.

    For success and regret, it is the number of levels that all students have finished, a lower bound on episodes.
    """
    if column.startswith("return/"):
        return column.replace("return/", "episodes/", 1)
    return "levels" if column in ("success", "regret") else None


def _scene_heading(scene: str) -> str:
    return f"return on the {scene}" if "distribution" in scene else f"return on test scene “{scene}”"


def read_curve(runs: Sequence[Path], column: str, points: int = 200, weights: str | None = None) -> Curve | None:
    """Read a column of the runs' metrics onto a common axis of env_steps; None if no run has it.

    `weights`: column with the number of episodes per value, if any; see `pooled`.
    """
    curves = []
    for run in runs:
        table = read_columns(run / "metrics.csv")
        if column in table:
            known = np.isfinite(table[column])
            if known.any():
                x, y = table["env_steps"][known], table[column][known]
                curves.append(pooled(x, y, table[weights][known]) if weights in table else (x, y))
    if not curves:
        return None
    few = max(len(x) for x, _ in curves) < FEW
    steps = np.linspace(min(x[0] for x, _ in curves), max(x[-1] for x, _ in curves), points)
    if few:
        steps = np.unique(np.concatenate([x for x, _ in curves]))
    return Curve(steps, np.stack([_on_axis(steps, x, _running_mean(y)) for x, y in curves]), few)


def pooled(x: np.ndarray, y: np.ndarray, episodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pool neighboring values `y` at `x` `[N]` until each pool has EPISODES episodes; return steps and means `[M]`.

    A pooled value is the mean over episodes, at the last step of its pool; the last pool includes the remainder. The
    first updates of a run finish only few and short episodes, so their means are unreliable.
    """
    count = np.nan_to_num(episodes)
    ends, behind = [], 0.0
    for index, more in enumerate(count):
        behind += more
        if behind >= EPISODES:
            ends.append(index)
            behind = 0.0
    ends = [*ends[:-1], len(x) - 1]  # the last pool includes the remainder
    begins = np.array([0, *(end + 1 for end in ends[:-1])])
    total = np.add.reduceat(count, begins)
    mean = np.add.reduceat(count * y, begins) / np.maximum(total, 1e-9)
    return x[ends], np.where(total > 0, mean, y[ends])


def _on_axis(steps: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Interpolate a run's values `y` at `x` onto the axis `[X]`: NaN before the first and after the last value."""
    values = np.interp(steps, x, y, left=np.nan, right=np.nan)
    if not np.isfinite(values).any():  # all values lie between two points of the axis
        values[np.abs(steps - x[-1]).argmin()] = y[-1]
    return values


def draw_curve(axes: Axes, curve: Curve, method: str, label: str | None = None, among: int = 1) -> None:
    """Draw the mean of the runs, the runs themselves as thin lines, and the range between them as a band.

    `among`: the number of methods in the picture; see `plots.curve_look`.
    """
    shade = plots.color(method)
    steps, values = curve.steps, curve.values
    known = np.isfinite(values).any(0)
    steps, values = steps[known], values[:, known]
    if len(values) > 1:
        axes.fill_between(steps, np.nanmin(values, 0), np.nanmax(values, 0), color=shade, alpha=0.14, linewidth=0)
        for row in values:
            axes.plot(steps, row, color=shade, linewidth=0.7, alpha=0.45, marker=_mark_of(steps, row), markersize=2.5)
    of_all = np.isfinite(values).all(0)  # the mean ends with the shortest run: beyond it, the mean would jump
    steps, mean = steps[of_all], values[:, of_all].mean(0)
    look = plots.curve_look(method, among)
    if curve.few or _mark_of(steps, mean):
        look |= {"marker": "o", "markersize": 4.5} | look | {"markevery": _marked(steps)}
    axes.plot(steps, mean, linewidth=2.0, label=label or plots.title(method), zorder=plots.ABOVE_AXES, **look)


def _mark_of(steps: np.ndarray, values: np.ndarray) -> str:
    """Return the marker of a curve: a dot for a single point, since a line would not show it."""
    return "o" if len(np.unique(steps[np.isfinite(values)])) == 1 else ""


def _marked(steps: np.ndarray) -> list[int]:
    """Return the indices of steps with a marker; close steps of several runs share one marker."""
    found: list[int] = []
    for index, step in enumerate(steps):
        if not found or step - steps[found[-1]] > APART * (steps[-1] - steps[0]):
            found.append(index)
    return found


def _running_mean(values: np.ndarray) -> np.ndarray:
    """Smooth with a running mean over WINDOW of the curve; windows are shorter at the ends."""
    width = max(1, int(WINDOW * len(values)))
    if len(values) < 40 or width < 2:
        return values
    kernel = np.ones(width)
    return np.convolve(values, kernel, "same") / np.convolve(np.ones(len(values)), kernel, "same")
