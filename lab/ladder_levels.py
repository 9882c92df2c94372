"""Which games of the mixture `AcademyLadder` does each teacher choose, and how well does its student play each of them?

From the runs of the study of curricula: the success on each game beside DR's, the share of each game among the levels
that the teacher chose, and a picture of these shares over training. Levels that are drawn at random are not counted.

    python -m lab.ladder_levels                                    # tables of the stored rows
    python -m lab.ladder_levels runs/curricula/curricula --publish # reads the runs; rows, tables and picture
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.studies.cells import percent
from lab.studies.curricula import COMPARISONS
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
from regista.experiments.run.table import read_rows
from ued.statistics import bootstrap

GAME = "AcademyLadder"
GAMES = (  # of the mixture, in the order of the picture
    *("empty_goal_close", "empty_goal", "run_to_score"),
    *("run_to_score_with_keeper", "pass_and_shoot_with_keeper", "3_vs_1_with_keeper"),
)
FOLDER = "grf/"  # prefix of their names
PARTS = 10  # of a run
COLUMNS = ("agent", "seed", "simulator", "part", *GAMES)
STORED = ROOT / "lab" / "results" / "ladder_levels.csv"
PICTURE = ROOT / "experiments" / "gallery" / "ladder_levels.png"
COMMAND = "python -m lab.ladder_levels"
ONE = "largest share of one game"
Rows = Sequence[Mapping[str, Any]]


# ---------------------------------------------------------------- rows


def shares_of(run: Path) -> np.ndarray:
    """Return the share of each game among the levels that a run's teacher chose, `[PARTS, GAMES]`.

    It is nan in a part without such levels.
    """
    table = read_levels(run, "update", "source", "program")
    chosen = table["source"] != "random"
    part = ((table["update"] - 1) * PARTS // table["update"].max()).astype(int)
    is_game = np.stack([table["program"] == FOLDER + game for game in GAMES], 1)  # [L, GAMES]
    return np.stack([_mean(is_game[chosen & (part == k)]) for k in range(PARTS)])


def _mean(chosen: np.ndarray) -> np.ndarray:
    return chosen.mean(0) if len(chosen) else np.full(len(GAMES), np.nan)


def read_runs(folder: Path) -> list[dict[str, Any]]:
    """Return a row for each run below `folder` and each part of it in which its teacher chose levels.

    Raises `CommandError` for runs of another version of the simulator, and if there are none.
    """
    rows = []
    for path in sorted(folder.glob(f"{GAME}-*/config.json")):
        run = RunFolder.open(path.parent)
        if not run.finished():
            continue
        versions.check_present(run.simulator, f"{run.path} was trained on", "its levels cannot be published")
        about = {"agent": run.config.method, "seed": run.config.seed, "simulator": SIMULATOR_VERSION}
        for part, shares in enumerate(shares_of(run.path)):
            if not np.isnan(shares).any():
                rows.append(about | {"part": part} | dict(zip(GAMES, shares.round(4).tolist(), strict=True)))
    if not rows:
        raise CommandError(f"{folder} has no finished runs of {GAME}; python -m lab.studies curricula trains them")
    return rows


def by_agent(rows: Rows) -> dict[str, np.ndarray]:
    """Return the shares of each agent's runs `[R, PARTS, GAMES]`, nan in parts without rows, in the study's order."""
    found = {}
    for agent in COMPARISONS["curricula"].variants:
        mine = [row for row in rows if row["agent"] == agent]
        seeds = sorted({int(row["seed"]) for row in mine})
        shares = np.full((len(seeds), PARTS, len(GAMES)), np.nan)
        for row in mine:
            shares[seeds.index(int(row["seed"])), int(row["part"])] = [float(row[game]) for game in GAMES]
        if seeds:
            found[agent] = shares
    return found


# ---------------------------------------------------------------- tables


def text_of(rows: Rows, played: Sequence[Row]) -> str:
    """Return both tables in Markdown: success, from `played` rows of the study, and shares, each with its note."""
    shares = by_agent(rows)
    first = (
        "Success on random levels of each game in percent, and differences in percentage points, after 20M simulated "
        "steps; 95% bootstrap intervals over runs."
    )
    second = (
        "Share of each game among the levels that the teacher chose, in the second half of training; at random, each "
        f"game has 17%. {ONE[0].upper()}{ONE[1:]}: of each run, then the mean. 95% bootstrap intervals over runs. "
        f"Measured on simulator version {SIMULATOR_VERSION}; `{COMMAND}`."
    )
    success, note = success_table(played)
    return "\n\n".join([as_markdown(success), f"{first} {note}", as_markdown(share_table(shares)), second])


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
    return [row for row in played if row.game == GAME and row.scene == f"{HELD_OUT}{FOLDER}{game}"]


def share_table(shares: Mapping[str, np.ndarray]) -> list[list[str]]:
    """Return games x methods, mean shares in the second half of training, and the largest share of one game."""
    late = {name: np.nanmean(mine[:, PARTS // 2 :], 1) for name, mine in shares.items()}  # [R, GAMES]
    table = [["game", *late]]
    for index, game in enumerate(GAMES):
        table.append([f"`{game}`", *(_cell(mine[:, index]) for mine in late.values())])
    table.append([ONE, *(_cell(mine.max(1)) for mine in late.values())])
    return table


def _cell(values: np.ndarray) -> str:
    return percent(bootstrap(values, np.random.default_rng(0)).interval())


# ---------------------------------------------------------------- picture


def draw(shares: Mapping[str, np.ndarray], path: Path = PICTURE) -> None:
    """Draw a row for each method, a panel for each run: the share of each game, stacked, over training."""
    with plots.style():
        import matplotlib
        import matplotlib.pyplot as plt

        columns = max(len(mine) for mine in shares.values())
        colors = matplotlib.colormaps["viridis"](np.linspace(0, 1, len(GAMES)))
        size = (2.3 * columns, 1.75 * len(shares) + 0.9)
        figure, grid = plt.subplots(
            len(shares), columns, figsize=size, sharex=True, sharey=True, squeeze=False, layout="constrained"
        )
        centers = (np.arange(PARTS) + 0.5) / PARTS
        for panels, (name, runs) in zip(grid, shares.items(), strict=True):
            panels[0].set_ylabel(plots.title(name))
            for axes, run in zip(panels, runs, strict=False):
                known = ~np.isnan(run).any(1)
                areas = axes.stackplot(centers[known], run[known].T, colors=colors, linewidth=0)
                axes.set_xlim(centers[0], centers[-1])
                plots.rate_axis(axes)
        for column, axes in enumerate(grid[0]):
            axes.set_title(f"run {column + 1}")
        figure.supxlabel("fraction of training", fontsize=10)
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
    rows = read_rows(STORED) if options.folder is None else read_runs(options.folder)
    text = text_of(rows, stored(RESULTS, "curricula"))
    if not options.publish:
        print(text)
        return 0
    if options.folder is not None:
        save_rows(rows, COLUMNS, STORED)
    draw(by_agent(rows))
    put(ROOT / PAGE, "ladder: levels", text, f"Levels of {GAME}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
