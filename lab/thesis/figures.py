"""Figures 4.4 to 4.9 of the thesis, drawn from stored rows for a side-by-side comparison.

Bars are mean returns per episode with 95% intervals over runs, dots the runs. Read next: `lab/thesis/tables.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.studies.rows import TRAIN, Row
from lab.thesis.curves import CURVES, Value
from lab.thesis.plan import FIGURES, METHODS, in_order
from regista.experiments.pictures import keys, plots
from regista.experiments.run import results as estimate
from regista.experiments.run.results import unique

AXES = {"agent": "agent's return", "antagonist": "antagonist's return", "environment": "environment's return"}
RUN = "a run"
VARIANTS = {name: method.method for name, method in METHODS.items() if name not in plots.METHOD_COLORS}
DASHED = {"paired_literal": (0, (9, 2, 1.5, 2))}  # a relative of PAIRED
WIDTH = 0.8  # of a group of bars


def scene_names(rows: Sequence[Row]) -> dict[str, str]:
    """Return the scenes of a game with their names in figures."""
    scenes = unique([row.scene for row in in_order(rows)])
    tests = [scene for scene in scenes if scene != TRAIN]
    names = {scene: f"test {k}\n{scene}" for k, scene in enumerate(tests)}
    return {scene: names.get(scene, "training\ndistribution") for scene in scenes}


def draw_bars(game: str, rows: Sequence[Row], path: Path) -> None:
    """Draw one of Figures 4.5 to 4.8: the mean return of each method on each scene of a game."""
    import matplotlib.pyplot as plt

    results = [row.result() for row in rows]
    methods = [name for name in METHODS if any(row.method == name for row in results)]
    scenes = scene_names(rows)
    plots.distinguish(VARIANTS)
    with plots.style():
        figure, axes = plt.subplots(figsize=(1.6 + 1.45 * len(scenes), 3.4), layout="constrained")
        for k, name in enumerate(methods):
            places = np.arange(len(scenes)) + (k - (len(methods) - 1) / 2) * WIDTH / len(methods)
            parts = [estimate.select(results, name, scene) for scene in scenes]
            bar(axes, places, parts, WIDTH / len(methods), plots.bar_look(name), METHODS[name].title)
        finish(axes, list(scenes.values()), f"Figure {FIGURES[game].number}: {FIGURES[game].title}")
        legend(figure, axes, keys.WHISKER, RUN)
        plots.save(figure, path)


def draw_strategies(rows: Sequence[Row], path: Path) -> None:
    """Draw Figure 4.4: the mean return of the built-in AI that attacks each of the four strategies."""
    import matplotlib.pyplot as plt

    results = [row.result() for row in rows]
    scenes = unique([row.scene for row in rows])
    with plots.style():
        figure, axes = plt.subplots(figsize=(5.2, 3.2), layout="constrained")
        parts = [estimate.select(results, "built-in", scene) for scene in scenes]
        bar(axes, np.arange(len(scenes)), parts, 0.6, plots.bar_look("built-in"))
        finish(axes, [scene.replace(": ", "\n") for scene in scenes], "Figure 4.4: built-in AI against the strategies")
        axes.set_ylabel("goal difference of the built-in AI")
        legend(figure, axes, keys.WHISKER)
        plots.save(figure, path)


def legend(figure: Any, axes: Any, *marks: str) -> None:
    """Add a legend below a figure: the labeled methods, and the meaning of the marks."""
    handles = list(axes.get_legend_handles_labels()[0])
    handles += [run_handle() if mark == RUN else keys.mark_handle(mark) for mark in marks]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, handlelength=3)


def run_handle() -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], linestyle="", marker=".", markersize=4, color=plots.INK, alpha=0.55, label=RUN)


def bar(axes: Any, places: np.ndarray, parts: Sequence[Any], width: float, look: dict, label: str = "") -> None:
    """Draw a bar for each of these lists of results, with its interval, and a dot for each run if there are several.

    A list without results has no bar, since an empty bar would read as 0.
    """
    known = [index for index, part in enumerate(parts) if part]
    places, parts = places[known], [parts[index] for index in known]
    found = [estimate.mean_return(part) for part in parts]
    axes.bar(places, [one.estimate for one in found], width * 0.92, label=label or None, **look)
    for place, one, part in zip(places, found, parts, strict=True):
        if one.known:
            axes.plot([place, place], [one.low, one.high], color=plots.INK, linewidth=1.3)
        if len(part) > 1:
            spread = place + np.linspace(-0.3, 0.3, len(part)) * width
            axes.plot(spread, [run.mean_return for run in part], ".", color=plots.INK, markersize=2.5, alpha=0.55)


def finish(axes: Any, names: Sequence[str], title: str) -> None:
    """Label the axes of bars; returns lie between -1 and 1."""
    axes.set_xticks(range(len(names)), names)
    axes.grid(False, axis="x")
    axes.axhline(0, color=plots.FAINT, linewidth=0.8)
    axes.set_ylabel("mean return per episode")
    low, high = axes.get_ylim()
    axes.set_ylim(max(-1.05, min(low, 0.0)), min(1.05, max(high, 0.1)))
    axes.set_title(title)


def draw_curves(values: Sequence[Value], path: Path) -> None:
    """Draw Figure 4.9: curves of all games, a row for each curve; lines are means, bands the range of the runs."""
    import matplotlib.pyplot as plt

    games = [game for game in FIGURES if any(value.game == game for value in values)]
    plots.distinguish(VARIANTS)
    with plots.style():
        size = (1.2 + 2.6 * len(games), 6.6)
        figure, grid = plt.subplots(
            len(CURVES), len(games), figsize=size, sharex="col", sharey="row", squeeze=False, layout="constrained"
        )
        for column, game in enumerate(games):
            for row, curve in enumerate(CURVES):
                mine = [value for value in values if (value.game, value.curve) == (game, curve)]
                draw_curve(grid[row, column], mine)
            grid[0, column].set_title(FIGURES[game].title)
            grid[-1, column].set_xlim(left=0)
            plots.label_steps(grid[-1, column])
        for row, curve in enumerate(CURVES):
            grid[row, 0].set_ylabel(AXES[curve])
        figure.suptitle("Figure 4.9: training returns (bottom: regret of the adversary's levels)", x=0.01, ha="left")
        legend(figure, grid[0, 0], keys.MEAN, keys.RANGE)
        plots.save(figure, path)


def draw_curve(axes: Any, values: Sequence[Value]) -> None:
    """Draw a curve of each method in one game, without runs of half of the steps, which would end early."""
    for name, method in METHODS.items():
        if method.share < 1:
            continue
        mine = [value for value in values if value.agent == name]
        steps = sorted({value.env_steps for value in mine})
        at = [[value.value for value in mine if value.env_steps == step] for step in steps]
        if steps:
            dashes, shade = DASHED.get(name) or plots.line_style(name), plots.color(name)
            axes.plot(steps, [np.mean(runs) for runs in at], linestyle=dashes, color=shade, label=method.title)
            axes.fill_between(steps, [min(r) for r in at], [max(r) for r in at], color=shade, alpha=0.12, lw=0)
