"""One picture of a comparison: how the methods learnt, how they do on the tests, where the levels went.

Read next: `compare`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments import build, plots
from experiments.level_plots import PERIODS, draw_levels, read_theta, team_legend
from experiments.results import Result, goal_rate, select, unique

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Comparison:
    """What a comparison has brought: run folders by method, all results, and how to draw levels."""

    minigame: str
    runs: Mapping[str, Sequence[Path]]
    results: Sequence[Result]
    painter: Any


def overview(found: Comparison, path: Path) -> None:
    """Draw the picture."""
    import matplotlib.pyplot as plt

    with plots.style():
        rows = len(found.runs)
        figure = plt.figure(figsize=(11.5, 3.9 + 3.2 * rows))
        grid = figure.add_gridspec(1 + rows, 6, height_ratios=[1.15, *[1.0] * rows], hspace=0.32, wspace=0.55)
        _draw_learning(figure.add_subplot(grid[0, :3]), found)
        _draw_goals(figure.add_subplot(grid[0, 3:]), found)
        for row, (method, paths) in enumerate(found.runs.items(), start=1):
            for column, (period, span) in enumerate(PERIODS.items()):
                axes = figure.add_subplot(grid[row, 2 * column : 2 * column + 2])
                draw_levels(axes, found.painter, [read_theta(run, span) for run in paths])
                axes.set_title(f"{plots.title(method)}: levels of the {period}")
        team_legend(figure)
        figure.suptitle(_heading(found), x=0.125, y=0.995, ha="left", fontsize=13, fontweight="bold")
        plots.save(figure, path)


def _heading(found: Comparison) -> str:
    seeds = max(len(paths) for paths in found.runs.values())
    return f"{found.minigame}: {' and '.join(plots.title(m) for m in found.runs)}, {seeds} seed{'s' * (seeds > 1)} each"


def _draw_learning(axes: Axes, found: Comparison) -> None:
    for method, paths in found.runs.items():
        curve = plots.read_curve(paths, f"eval/{build.TRAINING_SCENE}")
        if curve is not None:
            plots.draw_curve(axes, curve, method)
    axes.set_title("Return on the training distribution (uniform θ)")
    axes.set_xlabel("simulated steps, all students (millions)")
    axes.legend(loc="lower right")


def _draw_goals(axes: Axes, found: Comparison) -> None:
    """Draw the goal rate of every method on every scene, with its interval."""
    scenes = unique([row.scene for row in found.results])
    methods = unique([row.method for row in found.results])
    reach = 0.8
    for place, method in enumerate(methods):
        offset = (place - (len(methods) - 1) / 2) * reach / len(methods)
        for index, scene in enumerate(scenes):
            rows = select(found.results, method, scene)
            if not rows:
                continue
            interval = goal_rate(rows)
            shade, label = plots.colour(method), plots.title(method) if index == 0 else None
            axes.bar(index + offset, 100 * interval.estimate, 0.9 * reach / len(methods), color=shade, label=label)
            span = [[100 * (interval.estimate - interval.low)], [100 * (interval.high - interval.estimate)]]
            axes.errorbar(index + offset, 100 * interval.estimate, span, color=plots.INK, elinewidth=0.9, capsize=2)
    axes.set_xticks(range(len(scenes)), [scene.replace(" distribution", "\ndistribution") for scene in scenes])
    axes.tick_params(axis="x", length=0, labelcolor=plots.INK)
    axes.grid(axis="x", visible=False)
    axes.set_ylim(0, 105)
    axes.set_title("Goals scored after training (% of episodes)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=len(methods), columnspacing=1.2)
