"""What the studies of curricula say, as parts of RESULTS.md: tables and curves, drawn from CSV files alone.

Read next: `studies.rows`, what is in the files; `run.results`, how intervals are estimated.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from regista.experiments.pictures import plots
from regista.experiments.pictures.results_page import put
from regista.experiments.run import build
from regista.experiments.run import results as estimate
from regista.experiments.run.progress import count
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import Result, Scores, unique
from regista.experiments.studies.curricula import COMPARISONS
from regista.experiments.studies.measuring import HELD_OUT, THIRDS
from regista.experiments.studies.rows import TRAIN, Point, Row, check_present, load, played_on
from regista.experiments.studies.runs import Places
from ued.statistics import Interval, bootstrap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS, PANEL = 3, (3.9, 2.7)  # panels in a row, inches of one
OTHERS = ("#0f766e", "#b45309", "#6d28d9", "#be185d", "#4d7c0f", "#0369a1", "#78350f", "#334155")  # of variants
HEADINGS = {
    "curricula": "All methods, game by game",
    "rare": "Where what is hard is rare",
    "ablations": "Ablations of PAIRED, one change at a time",
    "tuning": "Domain randomisation, one change of PPO at a time",
}
NOTE = (
    "Goals in % of episodes on held-out levels, the mean of their parts, and how far above {first} that is; bold "
    "where the 95% interval, bootstrap over whole runs and their episodes (5 at least), excludes 0. Below, P: "
    "that a run is above one of {first}; at equal time: the mean return over the game's scenes once the quickest "
    "method has ended, less that of {first}."
)


def rows_file(places: Places, name: str) -> Path:
    """Return the file of what students scored in a study."""
    return places.results / f"{name}.csv"


def curves_file(places: Places, name: str) -> Path:
    """Return the file of their learning curves."""
    return places.results / f"{name}_curves.csv"


class Game(NamedTuple):
    """All that was measured on one game. `variants` are in the order of the study, the first is compared with."""

    name: str
    variants: Sequence[str]
    rows: Sequence[Row]
    points: Sequence[Point]

    @property
    def first(self) -> str:
        return self.variants[0]

    @property
    def steps(self) -> int:
        """Simulated steps of a run of the first variant."""
        return max(row.env_steps for row in self.rows if row.agent == self.first)

    @property
    def scenes(self) -> list[str]:
        """The held-out ones, then the training distribution and the tests."""
        names = unique([row.scene for row in self.rows])
        tests = [name for name in names if name not in self.held_out and name != TRAIN]
        return [*self.held_out, TRAIN, *tests]

    @property
    def held_out(self) -> list[str]:
        """The scenes that count: thirds from the lowest to the highest, or others."""
        names = unique([row.scene for row in self.rows if row.scene.startswith(HELD_OUT)])
        return [name for name in THIRDS if name in names] or names

    def results(self, variant: str, scenes: Sequence[str]) -> list[Result]:
        """Return what a variant's runs reached on these scenes."""
        return [row.result() for row in self.rows if row.agent == variant and row.scene in scenes]

    def scores(self, variant: str) -> Scores:
        """Return what a variant's runs reached on the held-out scenes."""
        return estimate.scores(self.results(variant, self.held_out), variant)

    def gain(self, variant: str) -> Interval:
        """Estimate by how much a variant is above the first on held-out levels."""
        return estimate.score_advantage(self.scores(variant), self.scores(self.first))

    def seconds(self, variant: str) -> float:
        """Return the mean time that a run of a variant took."""
        return float(np.mean([row.seconds for row in self.rows if row.agent == variant and row.scene == TRAIN]))

    def curves(self, variant: str, at: str = "env_steps") -> list[np.ndarray]:
        """Return each run's curve `[2, P]`: steps, or seconds, and mean returns."""
        mine = [point for point in self.points if point.agent == variant]
        seeds = dict.fromkeys(point.seed for point in mine)
        by_seed = [[point for point in mine if point.seed == seed] for seed in seeds]
        return [np.array([[getattr(p, at) for p in points], [p.mean_return for p in points]]) for points in by_seed]

    def gain_in_time(self, variant: str) -> Interval:
        """Estimate by how much a variant's mean return is above the first's once the quickest of all has ended."""
        end = min(map(self.seconds, self.variants))
        one, other = (
            bootstrap(np.array([np.interp(end, *curve) for curve in self.curves(name, "seconds")]), _rng())
            for name in (variant, self.first)
        )
        return (one - other).interval()


def _rng() -> np.random.Generator:
    return np.random.default_rng(estimate.BOOTSTRAP_SEED)


def write_page(places: Places) -> None:
    """Put what is measured of each study into the page. Raises `CommandError` if the disk refuses."""
    places.pictures.mkdir(parents=True, exist_ok=True)
    page = places.page.read_text() if places.page.exists() else "# Results\n"
    for name in COMPARISONS:
        games = read_games(places, name)
        if games:
            page = put(page, name, section(name, games, places))
    write_text(places.page, page)


def read(places: Places, name: str) -> tuple[list[Row], list[Point]]:
    """Return what was measured in a study. Raises `CommandError` for what is of another version of the simulator."""
    rows, points = load(rows_file(places, name)), load(curves_file(places, name), Point)
    check_present(rows_file(places, name), rows)
    check_present(curves_file(places, name), points)
    return rows, points


def read_games(places: Places, name: str) -> list[Game]:
    """Return what was measured, by game in the order of the study, with the variants of which there are runs."""
    rows, points = read(places, name)
    order = [*COMPARISONS[name].games, *unique([row.game for row in rows])]
    games = []
    for game in unique(order):
        mine = [row for row in rows if row.game == game]
        variants = [variant for variant in COMPARISONS[name].variants if any(row.agent == variant for row in mine)]
        if variants:
            games.append(Game(game, variants, mine, [point for point in points if point.game == game]))
    return games


def section(name: str, games: Sequence[Game], places: Places) -> str:
    """Return what a study says: all games, their curves, then a table for each."""
    picture = places.pictures / f"{name}_curves.png"
    draw_curves(games, picture)
    link = Path(os.path.relpath(picture, places.page.parent)).as_posix()
    commits = ", ".join(unique([row.commit for game in games for row in game.rows if row.commit]))
    played = played_on(row for game in games for row in game.rows)
    variants = unique([variant for game in games for variant in game.variants])
    return "\n\n".join(
        [
            f"## {HEADINGS[name]}",
            f"```sh\nregista study {name}\n```",
            as_markdown(over_games(games, variants)),
            f"{NOTE.format(first=plots.title(games[0].first))} Measured on {played}, commit {commits or 'unknown'}.",
            f"![Learning curves]({link})",
            *(f"### {build.short_name(game.name)}\n\n{as_markdown(by_scene(game))}" for game in games),
        ]
    )


def over_games(games: Sequence[Game], variants: Sequence[str]) -> list[list[str]]:
    """Return variants x games: goals on held-out levels, and how far above the first variant that is."""
    table = [["", *(f"{build.short_name(game.name)}, {count(game.steps)} steps" for game in games)]]
    for variant in variants:
        cells = []
        for game in games:
            mine = variant in game.variants
            value = percent(estimate.mean_score(game.scores(variant))) if mine else ""
            gain = f"; {in_points(game.gain(variant))}" if mine and variant != game.first else ""
            cells.append(value + gain)
        table.append([plots.title(variant), *cells])
    return table


def by_scene(game: Game) -> list[list[str]]:
    """Return scenes x variants, and below what is said of all held-out levels."""
    table = [["", *map(plots.title, game.variants)]]
    for scene in game.scenes:
        cells = [percent(estimate.goal_rate(game.results(variant, [scene]))) for variant in game.variants]
        table.append([scene, *cells])
    others = game.variants[1:]
    chances = [estimate.chance_of_better(game.scores(variant), game.scores(game.first)) for variant in others]
    runs = [len({row.seed for row in game.rows if row.agent == variant}) for variant in game.variants]
    return [
        *table,
        [f"held out − {game.first}", "", *(in_points(game.gain(variant)) for variant in others)],
        [f"P(better than {game.first})", "", *(spell(chance, "{:.2f}") for chance in chances)],
        [
            f"return at equal time − {game.first}",
            "",
            *(spell(game.gain_in_time(variant), "{:+.2f}") for variant in others),
        ],
        [
            "runs × seconds",
            *(f"{many} × {game.seconds(variant):.0f}" for many, variant in zip(runs, game.variants, strict=True)),
        ],
    ]


def percent(interval: Interval) -> str:
    """Return a share with its interval, in %."""
    return spell(Interval(*(100 * value for value in interval)), "{:.0f}")


def in_points(interval: Interval) -> str:
    """Return a difference of shares in points of %, bold where its interval excludes 0."""
    text = spell(Interval(*(100 * value for value in interval)), "{:+.0f}")
    return f"**{text}**" if interval.low > 0 or interval.high < 0 else text


def spell(interval: Interval, form: str) -> str:
    """Return an estimate with its interval, if it has one."""
    middle, low, high = (form.format(value) for value in interval)
    return f"{middle} [{low}, {high}]" if interval.known else middle


def draw_curves(games: Sequence[Game], path: Path) -> None:
    """Draw the mean return over a game's scenes as runs learn, a panel for each game."""
    import matplotlib.pyplot as plt

    variants = unique([variant for game in games for variant in game.variants])
    columns = min(COLUMNS, len(games))
    rows = -(-len(games) // columns)
    legend = 0.2 + 0.2 * -(-len(variants) // plots.LEGEND_COLUMNS)  # inches
    with plots.style():
        figure, grid = plt.subplots(
            rows, columns, figsize=(max(PANEL[0] * columns, 7.0), PANEL[1] * rows + legend), squeeze=False
        )
        for axes, game in zip(grid.flat, games, strict=False):
            for variant in game.variants:
                draw_mean(axes, game.curves(variant), variant, colour(variant, variants))
            axes.set_title(f"{build.short_name(game.name)}: return on all scenes")
            plots.label_steps(axes)
        for axes in grid.flat[len(games) :]:
            axes.set_visible(False)
        drawn = (axes.get_legend_handles_labels() for axes in grid.flat)
        handles = {label: line for lines, labels in drawn for line, label in zip(lines, labels, strict=True)}
        figure.legend(
            handles.values(), handles.keys(), loc="upper left", ncols=min(plots.LEGEND_COLUMNS, len(variants))
        )
        figure.tight_layout(rect=(0, 0, 1, 1 - legend / figure.get_figheight()))
        plots.save(figure, path)


def draw_mean(axes: Axes, curves: Sequence[np.ndarray], variant: str, shade: str) -> None:
    """Draw the mean of the runs' curves `[2, P]`, and its standard error as a band."""
    steps = curves[0][0]
    values = np.stack([np.interp(steps, *curve) for curve in curves])  # [R, P]
    middle, error = values.mean(0), values.std(0) / max(1, len(values) - 1) ** 0.5
    axes.fill_between(steps, middle - error, middle + error, color=shade, alpha=0.12, linewidth=0)
    axes.plot(steps, middle, color=shade, linewidth=1.6, label=plots.title(variant))


def colour(variant: str, variants: Sequence[str]) -> str:
    """Return the colour of a variant: that of its method, or the next of others."""
    named = [name for name in variants if plots.colour(name) == plots.OTHER_COLOUR]
    return OTHERS[named.index(variant) % len(OTHERS)] if variant in named else plots.colour(variant)
