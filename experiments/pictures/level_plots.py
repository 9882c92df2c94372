"""Levels of a method, early and late in training: the starting positions of both teams, or a painter's points.

Read next: `pictures.overview`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.view.render import BALL, LEFT_KEEPER, MARKERS, PAPER_COLORS, RIGHT_PLAYER, draw_pitch
from regista.experiments.pictures import keys, plots
from regista.experiments.run.errors import CommandError
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.proposals import PERIODS, ColumnOfProposals, read_proposals, within
from ued.core.painter import details_of, tiles_of
from ued.core.parameters import Parameter
from ued.recorder.shades import smooth

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CELL = 1.0  # m, on a pitch
CELL_PIXELS = 24  # side of a square cell
PANEL_WIDTH, TITLE_GAP = 3.3, 0.45  # inches; the gap separates titles of neighbors
CELLS = 100  # along the longer side of the bounds, for tasks other than football
MOST_LEVELS = 5000  # per run and period
MOST_CHOICES = 2  # bar charts next to the pitches


def read_periods(run: Path, periods: Iterable[tuple[float, float]]) -> list[np.ndarray]:
    """Return θ `[L, D]` of the training levels in each of these periods, given as shares of the run's updates.

    At most `MOST_LEVELS` levels per period are loaded, evenly spaced: they suffice for a density, and a long run has
    millions of levels.
    """
    update = read_levels(run, "update").get("update", np.zeros(0))
    found = [np.flatnonzero(within(update, period)) for period in periods]
    kept = [rows[:: -(-len(rows) // MOST_LEVELS) or 1] for rows in found]
    needed = np.unique(np.concatenate([np.zeros(0, np.int64), *kept]))
    columns = [*read_levels(run, "theta/", rows=needed).values()]
    if not columns:
        return [np.zeros((0, 0)) for _ in kept]
    theta = np.stack(columns, 1)
    return [theta[np.searchsorted(needed, rows)] for rows in kept]


def levels(runs: Mapping[str, Sequence[Path]], painter: Any, path: Path, draws: Sequence[Parameter] = ()) -> None:
    """Draw methods x periods: the density of the starting positions of both teams, or of a painter's points.

    Bar charts on the right show the first choices among `draws`: bars are the shares of options in the adversary's
    proposals, lines are the program's weights.
    """
    import matplotlib.pyplot as plt

    width = painter.bounds[1] - painter.bounds[0]
    height = painter.bounds[3] - painter.bounds[2]
    choices = {method: choices_of(paths, draws) for method, paths in runs.items()}
    wide = len(PERIODS) + max(map(len, choices.values()), default=0)
    with plots.style():
        size = (PANEL_WIDTH * wide, (PANEL_WIDTH * height / width + 0.35) * len(runs) + keys.SCALE_HEIGHT)
        figure, grid = plt.subplots(len(runs), wide, figsize=size, squeeze=False)
        for line, (method, paths) in zip(grid, runs.items(), strict=True):
            for axes, column in zip(line[len(PERIODS) :], choices[method], strict=False):
                draw_shares(axes, column)
            for axes in line[len(PERIODS) + len(choices[method]) :]:
                axes.axis("off")
            found = zip(*(read_periods(run, PERIODS.values()) for run in paths), strict=True)
            for axes, period, thetas in zip(line, PERIODS, found, strict=False):
                draw_levels(axes, painter, thetas)
                axes.set_title(
                    textwrap.fill(f"{plots.title(method)}: {period}", plots.fitting(PANEL_WIDTH - TITLE_GAP))
                )
        figure.tight_layout(rect=(0, keys.SCALE_HEIGHT / figure.get_figheight(), 1, 1))
        draw_scales(figure, painter)
        plots.save(figure, path)


def choices_of(paths: Sequence[Path], draws: Sequence[Parameter]) -> list[ColumnOfProposals]:
    """Return the first choices among the columns of θ, with shares averaged over runs; empty without an adversary."""
    try:
        runs = [read_proposals(path, draws) for path in paths] if draws else []
    except CommandError:
        return []
    columns = [several for several in zip(*runs, strict=True) if several[0].choice and len(several[0].names) > 1]
    return [
        several[0]._replace(proposed=np.mean([column.proposed for column in several], 0))
        for several in columns[:MOST_CHOICES]
    ]


def draw_shares(axes: Axes, column: ColumnOfProposals) -> None:
    """Draw the share of each value in the proposals of each period, and a line at its share in random levels."""
    places, width = np.arange(len(column.names)), 0.8 / len(PERIODS)
    for k, (period, share) in enumerate(zip(PERIODS, column.proposed, strict=True)):
        axes.bar(places + (k - 1) * width, share, width, color=str(0.8 - 0.3 * k), label=period)
    axes.hlines(column.program, places - 0.45, places + 0.45, color=plots.REFERENCE, label="the program's weight")
    axes.set_xticks(places, [name[:18] for name in column.names], rotation=20, ha="right", fontsize=7)
    plots.heading(axes, f"proposed: {column.title}")
    axes.set_ylabel("share of proposals")
    if column.choice:
        plots.rate_axis(axes)
    axes.legend(fontsize=6, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)  # below the bars


def draw_proposals(columns: Sequence[ColumnOfProposals], path: Path) -> None:
    """Draw the shares of proposals for all columns of θ."""
    import matplotlib.pyplot as plt

    with plots.style():
        rows = -(-len(columns) // 3)
        figure, grid = plt.subplots(rows, 3, figsize=(11, 2.8 * rows), squeeze=False, layout="constrained")
        for axes in grid.flat[len(columns) :]:
            axes.axis("off")
        for axes, column in zip(grid.flat, columns, strict=False):
            draw_shares(axes, column)
        plots.save(figure, path)


def draw_levels(axes: Axes, painter: Any, thetas: Sequence[np.ndarray]) -> None:
    """Draw the ground and the density of the painter's points in these levels, one color for each of `kinds_of`."""
    _draw_ground(axes, painter)
    known = [theta for theta in thetas if len(theta)]
    if not known:
        middle = np.mean(painter.bounds[:2]), np.mean(painter.bounds[2:])
        axes.text(*middle, "no level was finished", ha="center", va="center", color=plots.FAINT)
        return
    places = painter.positions(np.concatenate(known))  # [L, K, 2]
    if tiles_of(painter).any():
        return _draw_cells(axes, painter, places)
    x_low, x_high, y_low, y_high = painter.bounds
    cell = CELL if _is_football(painter) else max(x_high - x_low, y_high - y_low) / CELLS
    for _, points, shade in kinds_of(painter):
        _draw_density(axes, painter.bounds, places[:, points].reshape(-1, 2), shade, cell)


def draw_scales(figure: Any, painter: Any) -> None:
    """Draw the scales of the densities below a figure, one for each kind of points."""
    keys.density_scales(figure, [(label, shade) for label, _, shade in kinds_of(painter)])


def _is_football(painter: Any) -> bool:
    return tuple(painter.markers) == MARKERS


def kinds_of(painter: Any) -> list[tuple[str, np.ndarray, Any]]:
    """Return the kinds of points: name, mask `[K]` and color. Football: teams without the left keeper; else markers."""
    classes = np.asarray(painter.classes)
    if _is_football(painter):
        opponents = (classes >= RIGHT_PLAYER) & (classes < BALL)
        first = min(classes[opponents], default=RIGHT_PLAYER)  # the keeper's color if it is the only opponent
        return [
            ("starting positions of the learner's team", classes < LEFT_KEEPER, PAPER_COLORS[0]),
            ("starting positions of opponents", opponents, PAPER_COLORS[first]),
        ]
    kept = np.unique(classes[~details_of(painter)]).tolist()
    named = [(painter.markers[kind], classes == kind) for kind in kept]
    return [(name, points, tuple(np.array(shade) / 255)) for (name, shade, _), points in named]


def _draw_ground(axes: Axes, painter: Any) -> None:
    """Draw the pitch, or the lines of another painter, without axes."""
    if _is_football(painter):
        return draw_pitch(axes, painter.bounds)
    for strip in painter.lines():
        axes.plot(strip[:, 0], strip[:, 1], color=plots.FAINT, linewidth=1.0, zorder=1)
    axes.set(xlim=painter.bounds[:2], ylim=painter.bounds[2:], aspect="equal", xticks=[], yticks=[])


def _draw_cells(axes: Axes, painter: Any, places: np.ndarray) -> None:
    """Draw the densities of points `[L, K, 2]` on a grid: tiles fill cells, other kinds are bars side by side in cells.

    Each color is blended with white by the opacity of its density. Kinds do not overlap, since that would mix colors.
    """
    tiles = tiles_of(painter)
    cell = 2 * painter.markers[painter.classes[tiles.argmax()]][2]
    found = sorted(kinds_of(painter), key=lambda kind: not tiles[kind[1]].any())  # bars cover tiles
    kinds = [
        (shade, _count(painter.bounds, places[:, points], cell), tiles[points].any()) for _, points, shade in found
    ]
    rows, columns = kinds[0][1].shape
    picture = np.ones((rows, CELL_PIXELS, columns, CELL_PIXELS, 3))
    inside = slice(CELL_PIXELS // 6, CELL_PIXELS - CELL_PIXELS // 6)
    bars = np.linspace(inside.start, inside.stop, sum(not ground for *_, ground in kinds) + 1).astype(int)
    spans = iter([slice(low, high) for low, high in pairwise(bars)])
    for shade, counts, ground in kinds:
        veil = keys.opacity(counts / max(counts.max(), 1e-9))[:, None, :, None, None]
        part = slice(None) if ground else inside, slice(None) if ground else next(spans)
        picture[:, part[0], :, part[1]] = 1 - veil * (1 - np.array(shade))
    whole = picture.reshape(rows * CELL_PIXELS, columns * CELL_PIXELS, 3)
    axes.imshow(whole, extent=painter.bounds, origin="lower", interpolation="nearest", zorder=0)


def _count(bounds: tuple[float, float, float, float], points: np.ndarray, cell: float) -> np.ndarray:
    """Count the points `[..., 2]` in each cell: `[rows, columns]`, from the lowest row up."""
    x_low, x_high, y_low, y_high = bounds
    x, y = points.reshape(-1, 2).T
    bins = (max(int((y_high - y_low) / cell), 1), max(int((x_high - x_low) / cell), 1))
    return np.histogram2d(y, x, bins, ((y_low, y_high), (x_low, x_high)))[0]


def _draw_density(
    axes: Axes, bounds: tuple[float, float, float, float], points: np.ndarray, shade: Any, cell: float
) -> None:
    """Draw the density of `points` `[n, 2]` in one color, with opacity given by `keys.opacity`."""
    from matplotlib.colors import to_rgb

    if not len(points):
        return
    counts = _count(bounds, points, cell)
    width = 5.0 * len(points) ** (-1 / 6)  # Scott's rule for a spread of 5 cells, 5 m on a pitch
    density = smooth(counts, width)
    veil = np.zeros((*density.shape, 4))
    veil[..., :3] = to_rgb(shade)
    veil[..., 3] = keys.opacity(density / max(density.max(), 1e-9))
    axes.imshow(veil, extent=bounds, origin="lower", interpolation="bicubic", zorder=2)
