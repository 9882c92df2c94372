"""Does a curriculum help early, late or never? Differences to domain randomization after parts of the budget.

`python -m lab.studies.tables curricula` prints the table; `python -m lab.studies curricula --publish` also draws the
picture. Rates come from evaluations during training on the games' test scenes; held-out scenes are evaluated once, at
the end. Read next: `lab/studies/tables.py`, the tables of held-out scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lab.studies.curricula import COMPARISONS
from lab.studies.rows import Point, played_on
from lab.studies.runs import ROOT
from regista.experiments.pictures import keys, plots
from regista.experiments.run import significance
from regista.experiments.run.progress import count
from regista.experiments.run.report import as_markdown
from regista.experiments.run.results import unique
from ued.statistics import LEAST, Difference, bootstrap, detectable

COMMAND = "python -m lab.studies.tables curricula"
PARTS = (0.1, 0.3, 0.5, 1.0)  # of the budget
MOST_COLUMNS = 4  # maximum number of panels in a row of the picture
APART = 0.045  # gap between the final intervals of two methods, relative to the curves
EQUAL, SIMULATED = "equal student steps", "equal simulated steps"
PICTURE = ROOT / "experiments" / "gallery" / "curricula.png"
LINK = """![Success on test scenes over simulated steps](../../experiments/gallery/curricula.png)

*Means over runs, with their 95% intervals at the end: `python -m lab.studies curricula --publish`.*"""  # on a page


def section(points: Sequence[Point]) -> str:
    """Return the table of differences by budget with its legend, in Markdown; "" if no game has two methods."""
    points, names = comparable(points)
    if len(names) < 2:
        return ""
    first, *others = names
    gains: dict[tuple[str, float | str], Difference] = {}
    gains |= {(name, part): gain(points, name, first, part) for name in others for part in PARTS}
    learned = {name: share_learned(points, name) for name in others}
    equal = {name: at_equal_student_steps(points, name, first, learned[name]) for name in others if learned[name]}
    gains |= {(name, EQUAL): found for name, found in equal.items()}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    budget = max(point.env_steps for point in points)
    table = [["method", *(f"{count(part * budget)} steps" for part in PARTS)]]
    columns: list[float | str] = [*PARTS]
    if equal:
        table[0] += ["learns from", EQUAL]
        columns.append(EQUAL)
    for name in others:
        cells = [significance.points(gains[name, at], marks[name, at]) if (name, at) in gains else "" for at in columns]
        if equal:
            cells.insert(-1, f"{learned[name]:.0%}")
        table.append([name, *cells])
    games, runs = len({point.game for point in points}), [len(rates(points, name, 1.0)) for name in names]
    mean = f"mean over {games} games, " if games > 1 else ""
    about = (
        f"Success on test scenes, {mean}minus {first}, in percentage points; 95% bootstrap "
        f"intervals over {significance.spread(runs)} runs."
    )
    if equal:
        about += (
            f" {EQUAL[0].upper()}{EQUAL[1:]}: after {count(budget)} steps, minus {first} after as many as the method's "
            "tested student learned from, at the nearest evaluation."
        )
    size = 100 * detectable([rates(points, name, 1.0).mean(1) for name in names])
    legend = significance.legend([found.p for found in gains.values()])
    said = significance.sentences(legend, significance.visible([size], runs, "{:.0f} points at the end"))
    below = [about, said, f"Measured on {played_on(points)}; `{COMMAND}`."]
    parts = [as_markdown(table), " ".join(filter(None, below)), by_game(points, names) if equal else ""]
    return "\n\n".join(filter(None, parts))


def by_game(points: Sequence[Point], names: Sequence[str]) -> str:
    """Return the table of differences at equal simulated and at equal student steps on each game, with its legend."""
    first, *others = names
    gains: dict[tuple[str, str, str], Difference] = {}
    for game in (games := unique([point.game for point in points])):
        mine = [point for point in points if point.game == game]
        for name in others:
            gains[game, name, SIMULATED] = gain(mine, name, first, 1.0)
            if learned := share_learned(mine, name):
                gains[game, name, EQUAL] = at_equal_student_steps(mine, name, first, learned)
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    table = [["game", f"minus {first}, at", *others]]
    for game in games:
        for steps in (SIMULATED, EQUAL):
            keys_of = [(game, name, steps) for name in others]
            cells = [significance.points(gains[key], marks[key]) if key in gains else "" for key in keys_of]
            table.append([game if steps == SIMULATED else "", steps, *cells])
    legend = significance.sentences(significance.legend([found.p for found in gains.values()]))
    about = "Success on the test scenes of each game, in percentage points, with all runs."
    return f"{as_markdown(table)}\n\n{about} {legend} Measured on {played_on(points)}; `{COMMAND}`."


def methods(points: Sequence[Point]) -> list[str]:
    """Return the methods with points, in the order of the study."""
    found = {point.agent for point in points}
    return [name for name in COMPARISONS["curricula"].variants if name in found]


def comparable(points: Sequence[Point]) -> tuple[list[Point], list[str]]:
    """Return the points of games that all methods have, and the methods; an unfinished study also has other games.

    If some of these games have enough runs of each method for an interval, the others are left out, too.
    """
    names, games = methods(points), unique([point.game for point in points])
    have = {(point.game, point.agent, point.seed) for point in points}
    runs = {game: min(sum((game, name) == found[:2] for found in have) for name in names) for game in games}
    shared = [game for game in games if runs[game] >= LEAST] or [game for game in games if runs[game]]
    kept = [point for point in points if point.game in shared]
    return kept, [name for name in names if len(rates(kept, name, 1.0))]


def gain(points: Sequence[Point], name: str, first: str, part: float) -> Difference:
    """Return the difference of two methods after a part of the budget."""
    return significance.difference_of_means(rates(points, name, part), rates(points, first, part))


def share_learned(points: Sequence[Point], name: str) -> float:
    """Return the share of the simulated steps that a method's tested student learned from; 0 if unknown."""
    ends: dict[tuple[str, int], Point] = {}
    for point in points:
        if point.agent == name:
            ends[point.game, point.seed] = max(
                point, ends.get((point.game, point.seed), point), key=lambda p: p.env_steps
            )
    return float(np.mean([point.trained_steps / point.env_steps for point in ends.values()]))


def at_equal_student_steps(points: Sequence[Point], name: str, first: str, share: float) -> Difference:
    """Return the difference between a method at its end and the first method after an equal number of student steps."""
    return significance.difference_of_means(rates(points, name, 1.0), rates(points, first, share))


def rates(points: Sequence[Point], agent: str, part: float) -> np.ndarray:
    """Return the success rates `[R, G]` of a method on all games after a part of the budget.

    A run is a seed with its students of all games; incomplete seeds are left out.
    """
    games = unique([point.game for point in points])
    found: dict[tuple[int, str], list[Point]] = {}
    for point in points:
        if point.agent == agent:
            found.setdefault((point.seed, point.game), []).append(point)
    whole = [seed for seed in sorted({seed for seed, _ in found}) if all((seed, game) in found for game in games)]
    return np.array([[nearest(found[seed, game], part).success for game in games] for seed in whole])


def nearest(curve: Sequence[Point], part: float) -> Point:
    """Return the evaluation of a run nearest to a part of its budget; methods evaluate at slightly different steps."""
    budget = max(point.env_steps for point in curve)
    return min(curve, key=lambda point: abs(point.env_steps - part * budget))


def draw(points: Sequence[Point], path: Path = PICTURE) -> None:
    """Draw success on the test scenes over training steps: one panel per game, means and intervals over runs."""
    games, names = unique([point.game for point in points]), methods(points)
    rows = -(-len(games) // MOST_COLUMNS)
    columns = -(-len(games) // rows)
    with plots.style():
        import matplotlib.pyplot as plt

        wide = max(6.5, 1 + 2.6 * columns)  # inches, for the legend
        figure = plt.figure(figsize=(wide, 2.7 * rows + 0.5), layout="constrained")
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for index, (axes, game) in enumerate(zip(grid.flat, games, strict=False)):
            draw_game(axes, [point for point in points if point.game == game], names)
            axes.set_title(game)
            if index + columns < len(games):
                plots.shorten_steps(axes)
            else:  # no panel below this one
                plots.label_steps(axes)
        for axes in grid.flat[len(games) :]:
            axes.set_visible(False)
        for row in grid:
            row[0].set_ylabel("success on test scenes")
        handles = keys.method_handles(names, (keys.MEAN, keys.WHISKER))
        across = keys.columns_for(handles, wide)
        figure.legend(handles=handles, loc="outside lower center", ncols=across, handlelength=3)
        plots.save(figure, path)


def draw_game(axes: plots.Axes, points: Sequence[Point], names: Sequence[str]) -> None:
    """Draw the mean over each method's runs of one game, and the final 95% intervals side by side."""
    budget, rng = max(point.env_steps for point in points), np.random.default_rng(0)
    parts = np.linspace(0.1, 1, 10)
    for place, name in enumerate(names):
        curve = [mine for part in parts if len(mine := rates(points, name, part))]
        if curve:
            means = [float(mine.mean()) for mine in curve]
            look = plots.curve_look(name, len(names)) | {"linewidth": 1.3, "clip_on": False}
            axes.plot(budget * parts, means, label=plots.title(name), **look)
            plots.whisker(axes, budget * (1.05 + APART * place), bootstrap(curve[-1], rng).interval(), name)
    plots.leave_room(axes, budget, budget * (1.05 + APART * len(names)))
    plots.rate_axis(axes)
