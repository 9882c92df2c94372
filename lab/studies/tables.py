"""Markdown tables of the stored rows of a study: means over runs with 95% intervals, by game, method and scene.

Cells are success rates for the studies of curricula, goal differences per episode for the thesis's benchmark, whose
rows `fast` and `thesis` stand beside published results of Google Research Football (GRF):

    python -m lab.studies.tables curricula                          # of lab/studies/results/curricula.csv
    python -m lab.studies.tables curricula --summary                # a row for each game: differences to DR
    python -m lab.studies.tables tuning --results runs/curricula/results
    python -m lab.studies.tables fast --page BENCHMARK.md           # between <!-- study: fast --> and <!-- end -->
    python -m lab.studies.tables fast --teams                       # of teams, which have a page of their own

Read next: `lab/studies/rows.py`, what a row holds; `regista.experiments.run.results`, how intervals are estimated.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.studies import budgets, goals
from lab.studies.cells import percent, runs_and_steps
from lab.studies.curricula import COMPARISONS
from lab.studies.measuring import TEAM
from lab.studies.rows import RESULTS, TRAIN, Point, Row, check_present, load, played_on
from regista.experiments.run import arguments, significance
from regista.experiments.run import results as estimate
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import CommandError, UsageError, run_command
from regista.experiments.run.progress import count
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import select, unique
from ued.config import setting
from ued.statistics import LEAST, Difference

NOTE = (
    "95% intervals: bootstrap over runs and their episodes, for a single run over its episodes; none below 5 of either"
)
MOST_SCENES = 6  # maximum number of scenes with their own columns


@dataclass(frozen=True)
class TablesConfig:
    """Arguments of `python -m lab.studies.tables`."""

    name: str = positional("curricula, tuning, fast or thesis", default="")
    results: Path = setting(RESULTS, "folder of the CSV files of studies")
    page: Path | None = setting(None, "write the tables into this page instead of printing them")
    summary: bool = setting(False, "of curricula: one table, a row for each game")
    teams: bool = setting(False, "of fast and thesis: the table of teams")


def main(argv: Sequence[str]) -> int:
    """Print or write the tables of a study; return the exit code."""
    config = arguments.parse(TablesConfig(), argv, "python -m lab.studies.tables", "Tables of the rows of a study.")
    names = (*COMPARISONS, "fast", "thesis")
    if config.name not in names:
        raise UsageError(f"no stored rows '{config.name}'; there are {', '.join(names)}")
    if config.summary and config.name != "curricula":
        raise UsageError(f"--summary is of curricula, not of {config.name}")
    if config.teams and config.name in COMPARISONS:
        raise UsageError(f"--teams is of fast and thesis, not of {config.name}")
    if config.teams:
        publish_teams(config.results, config.name, config.page)
    elif config.summary:
        publish_summary(config.results, config.page)
    else:
        publish(config.results, config.name, config.page)
    return 0


def publish_summary(results: Path, page: Path | None = None) -> None:
    """Print the summary of the study of methods, or put it onto a page; see `publish`."""
    rows = stored(results, "curricula")
    show(summary(rows) if rows else f"{results / 'curricula.csv'} has no rows.", page, "study: summary", "Football")


def publish_teams(results: Path, name: str, page: Path | None = None) -> None:
    """Print the table of teams of a benchmark study, or put it onto a page; nothing if it has no teams."""
    rows = stored(results, name)
    if any(row.agent.startswith(TEAM) for row in rows):
        text = f"{goals.of_teams(rows)}\n\n{about(rows, name, ' --teams')}"
        show(text, page, f"study: {name}, teams", f"Teams, {name}")


def publish(results: Path, name: str, page: Path | None = None) -> None:
    """Print the tables of a file of rows, or put them between their marks on a page; without marks, at its end.

    Raises `CommandError` for rows of another version of the simulator, and if writing fails.
    """
    rows = stored(results, name)
    text = tables(rows, name) if rows else f"{results / name}.csv has no rows."
    points = load(results / f"{name}_curves.csv", Point) if name == "curricula" else []
    if points:
        text = f"{text}\n\n{budgets.section(points)}".rstrip()
        if page is not None:
            budgets.draw(points)
            text = f"{text}\n\n{budgets.LINK}"
    show(text, page, f"study: {name}", f"Study {name}")


def stored(results: Path, name: str) -> list[Row]:
    """Return the rows of a study. Raises `CommandError` for rows of another version of the simulator."""
    rows = load(results / f"{name}.csv")
    check_present(results / f"{name}.csv", rows)
    return rows


def show(text: str, page: Path | None, mark: str, heading: str) -> None:
    """Print a text, or put it onto a page; see `put`."""
    if page is None:
        print(text)
    else:
        put(page, mark, text, heading)


def put(page: Path, mark: str, text: str, heading: str) -> None:
    """Put a text between its marks on a page; a page without them gets them at its end, below a heading.

    Raises `CommandError` if a mark has no end, and if writing fails.
    """
    begin, end, old = f"<!-- {mark} -->", "<!-- end -->", page.read_text() if page.exists() else "# Results\n"
    if begin not in old:
        old = f"{old.rstrip()}\n\n## {heading}\n\n{begin}\n{end}\n"
    found = re.search(f"{re.escape(begin)}.*?{end}", old, re.S)
    if found is None:
        raise CommandError(f"{page} has the mark '{begin}' without '{end}'")
    write_text(page, f"{old[: found.start()]}{begin}\n{text}\n{end}{old[found.end() :]}")


def tables(rows: Sequence[Row], name: str) -> str:
    """Return the tables, and a note with the played episodes and the command."""
    if name == "tuning":
        return tuning_text(rows)
    if name in COMPARISONS:
        games = [[row for row in rows if row.game == game] for game in games_of(rows, name)]
        made = [f"**{game[0].game}**\n\n{as_markdown(success_table(game, name))}{below(game, name)}" for game in games]
    else:
        made = [goals.of_one_agent(rows)]
    return "\n\n".join([*made, about(rows, name)])


def about(rows: Sequence[Row], name: str, flag: str = "") -> str:
    """Return a note on the quantity of a table, the played episodes, and the command."""
    unit = "Success rates" if name in COMPARISONS else "Goal differences per episode"
    return f"{unit}. {NOTE}. Measured on {played_on(rows)}; `python -m lab.studies.tables {name}{flag}`."


def games_of(rows: Sequence[Row], name: str) -> list[str]:
    """Return the games with rows, the study's own first, in its order."""
    found = unique([row.game for row in rows])
    return [game for game in unique([*COMPARISONS[name].games, *found]) if game in found]


def summary(rows: Sequence[Row]) -> str:
    """Return one table: success of the first method on each game and on all games, and differences to it.

    "All games" are means over games of the runs with the same seed, if all games have all methods. Games with too few
    runs for an interval are not part of these means.
    """
    found = games_of(rows, "curricula")
    scores = {game: held_out_scores([row for row in rows if row.game == game], "curricula") for game in found}
    first, *others = (
        name for name in COMPARISONS["curricula"].variants if any(name in mine for mine in scores.values())
    )
    scores = {game: mine for game, mine in scores.items() if first in mine}
    enough = [game for game, mine in scores.items() if min(len(each.rates) for each in mine.values()) >= LEAST]
    whole = enough or list(scores)
    if len(whole) > 1 and all({first, *others} == set(scores[game]) for game in whole):
        seeds = shared_seeds(rows, whole, (first, *others))
        alike = [held_out_scores([r for r in rows if r.game == g and r.seed in seeds], "curricula") for g in whole]
        label = "**all games**" if len(whole) == len(scores) else f"**{len(whole)} games of {LEAST} runs**"
        if seeds:
            scores[label] = {name: over_games([mine[name] for mine in alike]) for name in (first, *others)}
    gains = {(game, name): gain for game, mine in scores.items() for name, gain in gains_of(mine).items()}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    table = [["game", first, *(f"{name} minus {first}" for name in others)]]
    for game, mine in scores.items():
        cells = [significance.points(gains[game, n], marks[game, n]) if n in mine else "" for n in others]
        table.append([game, percent(estimate.mean_score(mine[first])), *cells])
    runs = [len(each.rates) for game in whole for each in scores[game].values()]
    sizes = [100 * estimate.detectable_score(list(mine.values())) for mine in scores.values()]
    steps = unique([count(row.env_steps) for row in rows])
    played = (
        f"Success on held-out scenes in percent, and differences in percentage points, after {' to '.join(steps)} "
        f"simulated steps; 95% bootstrap intervals over {significance.spread(runs)} runs."
    )
    few = [game for game in scores if enough and game in found and game not in enough]
    played += f" Fewer than {LEAST} runs, so no interval: {', '.join(few)}." if few else ""
    legend = significance.legend([gain.p for gain in gains.values()])
    said = significance.sentences(legend, significance.visible(sizes, runs, "{:.0f} points", "game"))
    below = [played, said, f"Measured on {played_on(rows)}; `python -m lab.studies.tables curricula --summary`."]
    return f"{as_markdown(table)}\n\n{' '.join(filter(None, below))}"


def shared_seeds(rows: Sequence[Row], games: Sequence[str], names: Sequence[str]) -> set[int]:
    """Return the seeds for which all of these methods have a run on each of these games."""
    runs = {(row.game, row.agent, row.seed) for row in rows}
    seeds = {seed for _, _, seed in runs}
    return {seed for seed in seeds if all((game, name, seed) in runs for game in games for name in names)}


def over_games(scores: Sequence[estimate.Scores]) -> estimate.Scores:
    """Return the means over scenes of each game as columns `[R, G]`, for runs with the same R seeds."""
    rates = [mine.rates.mean(1) for mine in scores]
    errors = [np.sqrt((mine.errors**2).sum(1)) / mine.errors.shape[1] for mine in scores]
    return estimate.Scores(np.stack(rates, 1), np.stack(errors, 1))


def tuning_text(rows: Sequence[Row]) -> str:
    """Return a table of all tuned settings, with the best of each method in bold."""
    rates, best = tuned_rates(rows), best_settings(rows).values()
    table = [["method, setting", *games_of(rows, "tuning"), "mean"]]
    for name, each in rates.items():
        label = f"**{name}**" if name in best else name
        table.append([label, *(f"{rate:.0%}" for rate in each), f"{np.mean(each):.1%}"])
    about = (
        "Success after one run each, on the scenes by which settings are chosen: test scenes of games that also have "
        "held-out ones, random levels of the others. Bold: chosen. "
        f"Measured on {played_on(rows)}; `python -m lab.studies.tables tuning`."
    )
    return f"{as_markdown(table)}\n\n{about}"


def tuned_rates(rows: Sequence[Row]) -> dict[str, list[float]]:
    """Return the success of each setting with runs on all games, by game, in the order of the study."""
    found = games_of(rows, "tuning")
    by_name = {
        name: [[row for row in rows if (row.game, row.agent) == (game, name)] for game in found]
        for name in COMPARISONS["tuning"].variants
    }
    return {name: [validation_rate(mine) for mine in played] for name, played in by_name.items() if all(played)}


def best_settings(rows: Sequence[Row]) -> dict[str, str]:
    """Return the name of the best setting of each method, by the mean over games; the first one of equals."""
    best: dict[str, str] = {}
    rates, variants = tuned_rates(rows), COMPARISONS["tuning"].variants
    for name, each in rates.items():
        method = variants[name].method
        if method not in best or sum(each) > sum(rates[best[method]]):
            best[method] = name
    return best


def validation_rate(rows: Sequence[Row]) -> float:
    """Return the mean success of a run on its test scenes, or on random levels without other scenes."""
    tests = [row for row in rows if row.scene != TRAIN] or rows
    return float(np.mean([row.scored / row.episodes for row in tests]))


def success_table(rows: Sequence[Row], name: str) -> list[list[str]]:
    """Return methods x scenes of one game, the mean over held-out levels, and its difference to the first method.

    For games with many scenes, only random levels and the mean are shown.
    """
    tests = unique([row.scene for row in rows if row.scene != TRAIN])
    scenes = [TRAIN, *(tests if len(tests) <= MOST_SCENES else ())]
    known, scores = [row.result() for row in rows], held_out_scores(rows, name)
    first, *others = scores
    gains = gains_of(scores)
    marks = dict(zip(others, significance.marks(list(gains.values())), strict=True))
    mean = "held-out mean"
    mean += f" of {len(tests)}" if len(tests) > MOST_SCENES else ""
    table = [["method", *scenes, mean, f"minus {first}", "runs", "env steps"]]
    for method, mine in scores.items():
        cells = [percent(estimate.goal_rate(select(known, method, scene))) for scene in scenes]
        gain = significance.points(gains[method], marks[method]) if method in gains else ""
        table.append(
            [
                method,
                *cells,
                percent(estimate.mean_score(mine)),
                gain,
                *runs_and_steps([row for row in rows if row.agent == method]),
            ]
        )
    return table


def held_out_scores(rows: Sequence[Row], name: str) -> dict[str, estimate.Scores]:
    """Return the success rates of each method with rows on all scenes but random levels, in the study's order."""
    held_out = [row.result() for row in rows if row.scene != TRAIN]
    mine = {method: [row for row in held_out if row.method == method] for method in COMPARISONS[name].variants}
    return {method: estimate.scores(results, method) for method, results in mine.items() if results}


def gains_of(scores: Mapping[str, estimate.Scores]) -> dict[str, Difference]:
    """Return the difference between each method and the first one."""
    first, *others = scores
    return {method: estimate.score_advantage(scores[method], scores[first]) for method in others}


def below(rows: Sequence[Row], name: str) -> str:
    """Return the note below a game's table: the legend of its marks, and the smallest detectable difference."""
    scores = held_out_scores(rows, name)
    size = 100 * estimate.detectable_score(list(scores.values()))
    counts = [len(mine.rates) for mine in scores.values()]
    legend = significance.legend([gain.p for gain in gains_of(scores).values()])
    said = significance.sentences(legend, significance.visible([size], counts, "{:.0f} points"))
    return f"\n\n{said}" if said else ""


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
