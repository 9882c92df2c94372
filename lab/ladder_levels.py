"""Which games of the mixture `AcademyLadder` does each teacher choose, and how well does its student play each of them?

From the runs of the study of curricula: the success on each game beside DR's, the share of each game among the levels
that the teacher chose, PAIRED beside DR at equal student steps, and a picture of the shares over training. Levels that
are drawn at random are not counted.

    python -m lab.ladder_levels                                       # tables of the stored rows
    python -m lab.ladder_levels runs/curricula/curricula --publish    # rows, tables, picture
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.studies.cells import percent
from lab.studies.curricula import COMPARISONS, LADDER
from lab.studies.curricula_study import PAGE
from lab.studies.measuring import HELD_OUT
from lab.studies.rows import RESULTS, Row
from lab.studies.runs import ROOT
from lab.studies.tables import gains_of, held_out_scores, put, stored
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.pictures import plots
from regista.experiments.run import results as estimate
from regista.experiments.run import significance, versions
from regista.experiments.run.errors import CommandError, run_command
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.report import as_markdown, save_rows
from regista.experiments.run.table import read_columns, read_rows
from ued.statistics import bootstrap

GAMES = (  # of the mixture, in the order of the picture
    *("empty_goal_close", "empty_goal", "run_to_score"),
    *("run_to_score_with_keeper", "pass_and_shoot_with_keeper", "3_vs_1_with_keeper"),
)
FOLDER = "grf/"  # prefix of their names
SHARES, SUCCESS = ([f"{kind}/{game}" for game in GAMES] for kind in ("share", "success"))
PART = 2_000_000  # env steps of a part of a run
PARTS = 10
HALF = PARTS // 2  # parts in which DR trains its student as long as PAIRED in all
COLUMNS = ("agent", "seed", "simulator", "part", *SHARES, *SUCCESS)
STORED = ROOT / "lab" / "results" / "ladder_levels.csv"
PICTURE = ROOT / "experiments" / "gallery" / "ladder_levels.png"
COMMAND = "python -m lab.ladder_levels"
ONE = "largest share of one game"
AGENTS = tuple(COMPARISONS["curricula"].variants)
Rows = Sequence[Mapping[str, Any]]


# ---------------------------------------------------------------- rows


def read_run(run: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return two arrays `[P, GAMES]` over the parts of a run.

    The first has the share of each game among the levels that the teacher chose, nan in a part without such levels;
    the second the success on each game in the evaluation nearest to the end of the part.
    """
    metrics = read_columns(run / "metrics.csv")
    steps, evaluated = metrics["env_steps"], np.isfinite(metrics[f"eval_success/{FOLDER}{GAMES[0]}"])
    parts = max(1, round(steps[-1] / PART))
    levels = read_levels(run, "update", "source", "program")
    part = np.minimum((steps[levels["update"].astype(int) - 1] - 1) // PART, parts - 1)
    chosen = levels["source"] != "random"
    is_game = np.stack([levels["program"] == FOLDER + game for game in GAMES], 1)  # [L, GAMES]
    shares = np.stack([_mean(is_game[chosen & (part == k)]) for k in range(parts)])
    success = np.stack([metrics[f"eval_success/{FOLDER}{game}"][evaluated] for game in GAMES], 1)  # [E, GAMES]
    nearest = [np.abs(steps[evaluated] - (k + 1) * PART).argmin() for k in range(parts)]
    return shares, success[nearest]


def _mean(chosen: np.ndarray) -> np.ndarray:
    return chosen.mean(0) if len(chosen) else np.full(len(GAMES), np.nan)


def read_runs(folder: Path) -> list[dict[str, Any]]:
    """Return a row for each part of each finished run in the study's folder.

    Raises `CommandError` for runs of another version of the simulator, and if there are none.
    """
    rows = []
    for path in sorted(folder.glob(f"{LADDER}-*/config.json")):
        run = RunFolder.open(path.parent)
        if not run.finished():
            continue
        versions.check_present(run.simulator, f"{run.path} was trained on", "its levels cannot be published")
        about = {"agent": run.config.method, "seed": run.config.seed, "simulator": SIMULATOR_VERSION}
        for part, (shares, success) in enumerate(zip(*read_run(run.path), strict=True)):
            values = np.concatenate([shares, success]).round(4).tolist()
            spelled = ["" if np.isnan(value) else value for value in values]
            rows.append(about | {"part": part} | dict(zip((*SHARES, *SUCCESS), spelled, strict=True)))
    if not rows:
        raise CommandError(f"{folder}: no finished runs of {LADDER}; python -m lab.studies curricula trains them")
    return rows


def by_agent(rows: Rows, columns: Sequence[str]) -> dict[str, np.ndarray]:
    """Return columns of the runs of each agent that has numbers, `[R, P, columns]`; nan: unknown."""
    found = {}
    for agent in AGENTS:
        mine = [row for row in rows if row["agent"] == agent]
        seeds = sorted({int(row["seed"]) for row in mine})
        values = np.full((len(seeds), 1 + max((int(row["part"]) for row in mine), default=0), len(columns)), np.nan)
        for row in mine:
            numbers = [float(row[name]) if row[name] != "" else np.nan for name in columns]
            values[seeds.index(int(row["seed"])), int(row["part"])] = numbers
        if np.isfinite(values).any():
            found[agent] = values
    return found


# ---------------------------------------------------------------- tables


def text_of(rows: Rows, played: Sequence[Row]) -> str:
    """Return the tables in Markdown, each with its note: success, from `played` rows of the study, and choices."""
    success, legend = success_table(played)
    shares, rates = by_agent(rows, SHARES), by_agent(rows, SUCCESS)
    about_success = (
        "Success on random levels of each game in percent, and differences in percentage points, after 20M simulated "
        f"steps; 95% bootstrap intervals over runs. {legend}"
    )
    about_shares = (
        "Share of each game among the levels that the teacher chose, in the second half of training; among random "
        f"levels it is 17%. {ONE[0].upper()}{ONE[1:]}: the mean over runs of the largest number of each run."
    )
    equal, legend = equal_table(rates)
    about_equal = (
        "Success on each game in percent, in 64 episodes of each run, after 10M student steps, and differences in "
        f"percentage points; 95% bootstrap intervals over runs. {legend} "
        f"Measured on simulator version {SIMULATOR_VERSION}; `{COMMAND}`."
    )
    made = [as_markdown(success), about_success, as_markdown(share_table(shares)), about_shares]
    return "\n\n".join([*made, as_markdown(equal), about_equal])


def success_table(played: Sequence[Row]) -> tuple[list[list[str]], str]:
    """Return games x methods, success of the first method and differences to it, and the legend of the marks."""
    scores = {game: held_out_scores(rows_on(played, game), "curricula") for game in GAMES}
    gains = {(game, name): gain for game, mine in scores.items() for name, gain in gains_of(mine).items()}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    first, *others = next(iter(scores.values()))
    table = [["game", first, *(f"{name} minus {first}" for name in others)]]
    for game, mine in scores.items():
        cells = [significance.points(gains[game, name], marks[game, name]) for name in others]
        table.append([f"`{game}`", percent(estimate.mean_score(mine[first])), *cells])
    return table, significance.sentences(significance.legend([gain.p for gain in gains.values()]))


def rows_on(played: Sequence[Row], game: str) -> list[Row]:
    """Return the rows of random levels of one game of the mixture."""
    return [row for row in played if row.game == LADDER and row.scene == f"{HELD_OUT}{FOLDER}{game}"]


def share_table(shares: Mapping[str, np.ndarray]) -> list[list[str]]:
    """Return games x methods, mean shares in the second half of training, and the largest of each run."""
    late = {name: np.nanmean(mine[:, HALF:], 1) for name, mine in shares.items()}  # [R, GAMES]
    table = [["game", *late]]
    for index, game in enumerate(GAMES):
        table.append([f"`{game}`", *(_cell(mine[:, index]) for mine in late.values())])
    table.append([ONE, *(_cell(mine.max(1)) for mine in late.values())])
    return table


def equal_table(rates: Mapping[str, np.ndarray]) -> tuple[list[list[str]], str]:
    """Return games x success of DR, of PAIRED, and the difference, at equal student steps; and the legend of its mark.

    PAIRED's tested student has half of the simulated steps, so DR is taken in the middle of its training.
    """
    dr, paired = rates["dr"][:, HALF - 1], rates["paired"][:, PARTS - 1]  # [R, GAMES]
    gains = [significance.difference_of_means(paired[:, k], dr[:, k]) for k in range(len(GAMES))]
    marks = significance.marks(gains)
    table = [["game", "dr, 10M simulated steps", "paired, 20M simulated steps", "paired minus dr"]]
    for k, game in enumerate(GAMES):
        table.append([f"`{game}`", _cell(dr[:, k]), _cell(paired[:, k]), significance.points(gains[k], marks[k])])
    return table, significance.sentences(significance.legend([gain.p for gain in gains]))


def _cell(values: np.ndarray) -> str:
    found = bootstrap(values, np.random.default_rng(0)).interval()
    return percent(found._replace(low=max(found.low, 0.0), high=min(found.high, 1.0)))


# ---------------------------------------------------------------- picture


def draw(shares: Mapping[str, np.ndarray], path: Path = PICTURE) -> None:
    """Draw a row for each method, a panel for each run: the share of each game, stacked, over env steps.

    Args:
        shares: `[R, P, GAMES]` of each method.
        path: of the picture.
    """
    with plots.style():
        import matplotlib
        import matplotlib.pyplot as plt

        columns = max(len(mine) for mine in shares.values())
        colors = matplotlib.colormaps["viridis"](np.linspace(0, 1, len(GAMES)))
        size = (2.3 * columns, 1.75 * len(shares) + 0.9)
        figure, grid = plt.subplots(
            len(shares), columns, figsize=size, sharex=True, sharey=True, squeeze=False, layout="constrained"
        )
        for panels, (name, runs) in zip(grid, shares.items(), strict=True):
            panels[0].set_ylabel(plots.title(name))
            for axes in panels[len(runs) :]:
                axes.set_visible(False)
            for axes, run in zip(panels, runs, strict=False):
                known = ~np.isnan(run).any(1)
                centers = (np.arange(len(run)) + 0.5) * PART
                areas = axes.stackplot(centers[known], run[known].T, colors=colors, linewidth=0)
                plots.rate_axis(axes)
        for column, axes in enumerate(grid[0]):
            axes.set_title(f"run {column + 1}")
        for axes in grid[-1]:
            axes.set_xlim(PART / 2, (PARTS - 0.5) * PART)
            plots.shorten_steps(axes)
        figure.supxlabel("simulated steps, all students", fontsize=10)
        order = dict(zip(GAMES, areas, strict=True))
        figure.legend(order.values(), order, loc="outside upper center", ncols=3, title="game (bottom to top)")
        plots.save(figure, path)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog=COMMAND, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("folder", type=Path, nargs="?", help="of the study's runs; without: the stored rows")
    made.add_argument("--publish", action="store_true", help=f"keep the rows, draw the picture, tables into {PAGE}")
    return made


def main(argv: Sequence[str]) -> int:
    """Print or publish the tables; return the exit code."""
    options = parser().parse_args(argv)
    rows = read_runs(options.folder) if options.folder else read_rows(STORED)
    text = text_of(rows, stored(RESULTS, "curricula"))
    if not options.publish:
        print(text)
        return 0
    if options.folder:
        save_rows(rows, COLUMNS, STORED)
    draw(by_agent(rows, SHARES))
    put(ROOT / PAGE, "ladder: levels", text, f"Levels of {LADDER}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
