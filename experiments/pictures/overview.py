"""One picture of a comparison: learning curves, results on the tests, distributions of levels.

Read next: `commands.compare`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.pictures import curves, keys, plots
from regista.experiments.pictures.level_plots import draw_levels, draw_scales, read_periods
from regista.experiments.run import results as estimate
from regista.experiments.run.proposals import PERIODS
from regista.experiments.run.results import Result, goal_rate, select, unique
from regista.experiments.run.significance import marks, points
from ued.core.task import TRAINING_SCENE
from ued.statistics import Interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes


WIDTH = 11.5  # inches
CURVES_HEIGHT = 2.4  # inches
TITLE_HEIGHT = 0.35  # inches, title of a pitch
LEVELS_TITLE, TITLE_GAP = 9.0, 0.45  # font size of pitch titles in points; gap between neighbors in inches
COLUMNS = 4  # pitches per row
MOST_HORIZONTAL = 7  # scenes with horizontal labels; with more scenes, labels are rotated
ROTATED_HEIGHT = 0.5  # inches, additional height for rotated labels
HEADING_LENGTH = 105  # characters per line of the heading
GAINS_LENGTH = 160  # characters per line of the differences below the heading
GAINS_LINE = 0.19  # inches
ALL = "all scenes"  # label of the mean over scenes, as in the tables

Panel = tuple[str, Sequence[Path], tuple[float, float]]  # heading that ends in ", period", runs, period of training


@dataclass(frozen=True)
class Comparison:
    """Data of a comparison: run folders by method, results, painter of levels, word for successes.

    `draws`: the known columns of θ.
    """

    minigame: str
    runs: Mapping[str, Sequence[Path]]
    results: Sequence[Result]
    painter: Any
    word: str = "goals"
    draws: Sequence[Any] = ()


def overview(comparison: Comparison, path: Path) -> None:
    """Draw the picture: learning curves and success rates at the top, a row of pitches for each method below."""
    import matplotlib.pyplot as plt

    learning = _learning(comparison)
    heading, gains, handles = _heading(comparison), _gains(comparison), _handles(comparison, learning)
    title = 0.3 + 0.2 * heading.count("\n")  # inches, like all sizes below
    head = title + GAINS_LINE * len(gains) + 0.25
    many = len(unique([row.scene for row in comparison.results])) >= MOST_HORIZONTAL  # labels include the mean
    across = keys.columns_for(handles, WIDTH)
    legend = 0.65 + ROTATED_HEIGHT * many + 0.2 * -(-len(handles) // across)
    above_height, below_height = head + CURVES_HEIGHT + legend, _levels_height(comparison)
    with plots.style():
        figure = plt.figure(figsize=(WIDTH, above_height + below_height))
        halves: Any = figure.subfigures(2, 1, height_ratios=[above_height, below_height])
        above, below = halves
        _draw_results(above, comparison, learning)
        above.suptitle(heading, x=0.01, y=1 - 0.05 / above_height, ha="left", fontsize=13, fontweight="bold")
        below_title = 1 - (title + 0.02) / above_height
        above.text(0.01, below_title, "\n".join(gains), va="top", fontsize=9, color=plots.INK)
        top, bottom = 1 - head / above_height, legend / above_height
        above.subplots_adjust(left=0.06, right=0.99, top=top, bottom=bottom, wspace=0.16)
        above.legend(handles=handles, loc="lower center", ncols=across, columnspacing=1.2)
        _draw_levels(below, comparison)
        plots.save(figure, path)


def _levels_height(comparison: Comparison) -> float:
    """Return the height of the pitches with their headings and scales, in inches."""
    x_low, x_high, y_low, y_high = comparison.painter.bounds
    rows = _level_rows(comparison.runs)
    return len(rows) * (_pitch_height(x_high - x_low, y_high - y_low) + TITLE_HEIGHT) + TITLE_HEIGHT + keys.SCALE_HEIGHT


def _pitch_height(width: float, height: float) -> float:
    return WIDTH / COLUMNS * height / width


def _draw_levels(below: Any, comparison: Comparison) -> None:
    rows, height = _level_rows(comparison.runs), _levels_height(comparison)
    shrunk = LEVELS_TITLE / plots.STYLE["axes.titlesize"]
    fitting = plots.fitting((WIDTH / COLUMNS - TITLE_GAP) / shrunk)
    grid = below.subplots(len(rows), COLUMNS, squeeze=False)
    for line, panels in zip(grid, rows, strict=True):
        for axes, (title, _, _), thetas in zip(line, panels, _read_panels(panels), strict=True):
            draw_levels(axes, comparison.painter, thetas)
            axes.set_title(_shortened(title, fitting), fontsize=LEVELS_TITLE)
    below.subplots_adjust(
        left=0.01,
        right=0.99,
        top=1 - TITLE_HEIGHT / height,
        bottom=(keys.SCALE_HEIGHT + 0.1) / height,
        wspace=0.05,
        hspace=0.16,
    )
    draw_scales(below, comparison.painter)


def _shortened(title: str, fitting: int) -> str:
    """Wrap the heading of a pitch into two lines of `fitting` characters; shorten the name, not the period."""
    lines = textwrap.wrap(title, fitting)
    if len(lines) > 2:
        name, _, period = title.rpartition(", ")
        lines = [f"{name[: fitting - 2].rstrip()} …,", period]
    return "\n".join(lines)


def _handles(comparison: Comparison, learning: Mapping[str, curves.Curve]) -> list[Any]:
    """Return the handles of the legend: methods and baselines, the curves' lines and bands, and whiskers."""
    methods = unique([row.method for row in comparison.results])
    several = any(len(curve.values) > 1 for curve in learning.values())
    known = any(_interval(comparison, method, row.scene).known for method in methods for row in comparison.results[:1])
    marks = (*(keys.RUNS if several else ()), *([keys.WHISKER] if known else []))
    return keys.method_handles(methods, marks, filled=True)


def _interval(comparison: Comparison, method: str, scene: str) -> Interval:
    return goal_rate(select(comparison.results, method, scene))


def _read_panels(panels: Sequence[Panel]) -> list[list[np.ndarray]]:
    """Return θ `[L, D]` by panel and run; each table is read once."""
    spans: dict[Path, list[tuple[float, float]]] = {}
    for _, paths, span in panels:
        for run in paths:
            spans.setdefault(run, []).append(span)
    thetas = {run: dict(zip(of_run, read_periods(run, of_run), strict=True)) for run, of_run in spans.items()}
    return [[thetas[run][span] for run in paths] for _, paths, span in panels]


def _level_rows(runs: Mapping[str, Sequence[Path]]) -> list[list[Panel]]:
    """Return a row of panels (heading, runs, period of training) for each method; for DR only if it is the only one.

    Each row starts with a reference panel: DR over all of training, since its distribution of levels is constant.
    Without DR, it is the method itself over all of training.
    """
    uniform = [("Levels: domain randomization", runs["dr"], (0.0, 1.0))] if "dr" in runs else []
    others = [method for method in runs if method != "dr"] or list(runs)
    rows = []
    for method in others:
        panels = [(f"{plots.title(method)}, {period}", runs[method], span) for period, span in PERIODS.items()]
        whole = (f"{plots.title(method)}, all of training", runs[method], (0.0, 1.0))
        rows.append([*(uniform or [whole]), *panels])
    return rows


def _heading(comparison: Comparison) -> str:
    seeds = max(len(paths) for paths in comparison.runs.values())
    whole = f"{comparison.minigame}: {plots.listed(list(comparison.runs))}, {seeds} seed{'s' * (seeds > 1)} each"
    return textwrap.fill(whole, HEADING_LENGTH)


def _gains(comparison: Comparison) -> list[str]:
    """Return lines with the difference of each method from the first in the mean over scenes; [] without intervals."""
    reference, *others = comparison.runs
    known = {name: _scores(comparison, name) for name in comparison.runs}
    base = known[reference]
    if base is None:
        return []
    found = {name: estimate.score_advantage(mine, base) for name in others if (mine := known[name]) is not None}
    found = {name: gain for name, gain in found.items() if gain.known}
    if not found:
        return []
    told = [
        f"{plots.title(name)} {points(gain, mark)}" + (", no difference detected" if gain.low <= 0 <= gain.high else "")
        for (name, gain), mark in zip(found.items(), marks(list(found.values())), strict=True)
    ]
    whole = (
        f"{comparison.word.capitalize()} on {ALL} minus {plots.title(reference)}, points [95% CI]: {'; '.join(told)}"
    )
    return textwrap.wrap(whole, GAINS_LENGTH)


def _scores(comparison: Comparison, method: str) -> estimate.Scores | None:
    """Return the rates of a method on all scenes; None if it was not evaluated on one of them."""
    scenes = unique([row.scene for row in comparison.results])
    if not all(select(comparison.results, method, scene) for scene in scenes):
        return None
    return estimate.scores(comparison.results, method)


def _learning(comparison: Comparison) -> dict[str, curves.Curve]:
    """Return the learning curve of each method that was evaluated during training."""
    found = {name: curves.read_curve(paths, f"eval/{TRAINING_SCENE}") for name, paths in comparison.runs.items()}
    return {name: curve for name, curve in found.items() if curve is not None}


def _draw_results(above: Any, comparison: Comparison, learning: Mapping[str, curves.Curve]) -> None:
    """Draw the learning curves, if any, and to their right the success rates."""
    if learning:
        left, right = above.subplots(1, 2, width_ratios=[1, 1.15])
        _draw_learning(left, learning)
    else:
        right = above.subplots()
    _draw_goals(right, comparison)


def _draw_learning(axes: Axes, learning: Mapping[str, curves.Curve]) -> None:
    for method, curve in learning.items():
        curves.draw_curve(axes, curve, method)
    axes.set_title("Return on the training distribution")
    plots.label_steps(axes)
    plots.begin_at_zero(axes)


def _draw_goals(axes: Axes, comparison: Comparison) -> None:
    """Draw the success rate of every method with its interval: the mean over more than two scenes, then each scene."""
    scenes = unique([row.scene for row in comparison.results])
    methods = unique([row.method for row in comparison.results])
    shown = [ALL, *scenes] if len(scenes) > 2 else scenes
    reach = 0.8
    for place, method in enumerate(methods):
        offset = (place - (len(methods) - 1) / 2) * reach / len(methods)
        for index, scene in enumerate(shown):
            interval = _rate(comparison, method, scene)
            if interval is not None:  # without a rate there is no bar, since an empty bar would read as 0
                _draw_rate(axes, index + offset, interval, 0.9 * reach / len(methods), plots.bar_look(method))
    rotated: dict[str, Any] = {"rotation": 25, "ha": "right", "fontsize": 8} if len(shown) > MOST_HORIZONTAL else {}
    names = [scene if rotated else scene.replace(" distribution", "\ndistribution") for scene in shown]
    axes.set_xticks(range(len(shown)), names, **rotated)
    axes.tick_params(axis="x", length=0, labelcolor=plots.INK)
    axes.grid(axis="x", visible=False)
    plots.rate_axis(axes)
    axes.set_title(f"{'Goals' if comparison.word == 'goals' else 'Success'} after training, share of episodes")


def _rate(comparison: Comparison, method: str, scene: str) -> Interval | None:
    """Return a method's rate on a scene, or its mean over all scenes; None if not available."""
    if scene == ALL:
        mine = _scores(comparison, method)
        return None if mine is None else estimate.mean_score(mine)
    return _interval(comparison, method, scene) if select(comparison.results, method, scene) else None


def _draw_rate(axes: Axes, at: float, interval: Interval, width: float, look: Mapping[str, Any]) -> None:
    """Draw a bar with its whisker."""
    axes.bar(at, interval.estimate, width, **look)
    if interval.known:
        low, high = interval.estimate - interval.low, interval.high - interval.estimate
        span = [[max(low, 0.0)], [max(high, 0.0)]]  # rounding errors may make a length negative
        axes.errorbar(at, interval.estimate, span, color=plots.INK, elinewidth=0.9, capsize=2)
