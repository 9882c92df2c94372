"""Do differences between methods hold in Google Research Football (GRF)?

Plays the trained runs of two studies in both engines: of `1v1RareLine` on its held-out scenes, of `3v2FourBehaviors` on
its test scenes. Needs GRF (`make grf`) and the folders of the runs. A stopped call continues with the same command.

    python -m lab.paired_football --csv lab/results/paired_order.csv    # trains runs
    python -m lab.thesis paired                                         # trains runs
    python -m lab.methods_in_grf --publish                              # plays them: half an hour on 2 cores

Read next: `lab/transfer.py`, which asks how many of its goals a policy keeps.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lab import paired_football
from lab.studies.cells import percent
from lab.studies.curricula_study import PAGE
from lab.studies.rows import add, check_present, load, played_on
from lab.studies.runs import ROOT, StudyRuns
from lab.studies.tables import put
from lab.thesis import plan
from regista.experiments.run import build, significance, versions
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.errors import CommandError, run_command
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import as_markdown
from regista.experiments.run.significance import difference_of_means, points
from ued.core.task import TRAINING_SCENE
from ued.statistics import Difference, bootstrap, detectable

ENGINES = {"ours": "regista", "GRF": "grf"}
HEADS = {"ours": "our simulator", "GRF": "GRF"}  # of tables
EPISODES = {"ours": 300, "GRF": 50}  # on each scene
ROWS = ROOT / "lab" / "results" / "methods_in_grf.csv"
RARE_GAME, DUEL = "1v1RareLine", "3v2FourBehaviors"
METHODS = {
    RARE_GAME: ("dr", "dr, equally likely options", "paired", "plr"),
    DUEL: ("dr", "paired_dennis2020", "paired"),
}


class Trained(NamedTuple):
    """A run: `order` is the place of the rare option in its program, "" in a game without one; `open` opens the run."""

    game: str
    agent: str
    order: str
    seed: int
    open: Callable[[], RunFolder]


class Played(NamedTuple):
    """A run's episodes on a scene in an engine; `simulator` is the version on which the run was trained."""

    engine: str
    game: str
    agent: str
    order: str
    seed: int
    scene: str
    env_steps: int
    episodes: int
    scored: int
    simulator: str

    def key(self) -> tuple[str, str, str, str, int, str]:
        """Return the key of the row; a later row with the same key replaces it."""
        return self[:6]


# ---------------------------------------------------------------- the runs


def rare_runs(folder: Path) -> Iterator[Trained]:
    """Yield the runs of `lab.paired_football` on the game, seed by seed."""
    study = paired_football.STUDY
    base = paired_football.runs_of(study, folder / "paired_football")
    for seed in study.seeds:
        for cell in study.cells:
            if cell.game == RARE_GAME and cell.variant in METHODS[RARE_GAME]:
                opened = partial(paired_football.begin, base, cell, seed)
                yield Trained(cell.game, cell.variant, cell.order, seed, opened)


def duel_runs(folder: Path) -> Iterator[Trained]:
    """Yield the runs of `lab.thesis paired` on the game, seed by seed."""
    studies = StudyRuns(folder / "thesis" / "paired" / "fast", plan.base("fast"), {})
    for arm in plan.paired_arms([DUEL], METHODS[DUEL], plan.Budget()):
        opened = partial(studies.open, arm.game, arm.seed, arm.settings, f"{arm.agent}-")
        yield Trained(arm.game, arm.agent, "", arm.seed, opened)


RUNS = {RARE_GAME: rare_runs, DUEL: duel_runs}
TRAINED_BY = {RARE_GAME: "python -m lab.paired_football", DUEL: "python -m lab.thesis paired"}


# ---------------------------------------------------------------- playing


def play(folder: Path, rows: Path) -> None:
    """Play each run that has no row yet in both engines. Raises `CommandError` for a run that is not trained."""
    done = {row.key()[:5] for row in load(rows, Played)}
    for runs in RUNS.values():
        scenes: dict[str, EvalScenes] = {}  # of one game, by engine
        for trained in runs(folder):
            for engine in ENGINES:
                if (engine, *trained[:4]) not in done:
                    add(rows, measure(trained, engine, scenes), Played)


def measure(trained: Trained, engine: str, scenes: dict[str, EvalScenes]) -> list[Played]:
    """Play a run in an engine, making the engine's scenes if necessary; return a row for each scene."""
    run, game = trained.open(), build.find_game(trained.game)
    if not run.finished():
        raise CommandError(f"{run.path} is not trained; first: {TRAINED_BY[trained.game]}")
    if engine not in scenes:
        config = replace(run.config, minigame=trained.game).scored().on_engine(EngineConfig(engine=ENGINES[engine]))
        scenes[engine] = EvalScenes(config, game, EPISODES[engine], held_out=trained.game == RARE_GAME)
    student, (env_steps, _) = load_student(run, game)
    tests = [label for label in scenes[engine].scenes if label != TRAINING_SCENE]
    return [
        Played(
            *(engine, *trained[:4], label, env_steps, len(result.returns), int((result.returns > 0).sum())),
            simulator=versions.spelled(run.simulator),
        )
        for label, result in scenes[engine].play(student, tests).items()
    ]


# ---------------------------------------------------------------- the table


def rates(rows: Sequence[Played]) -> np.ndarray:
    """Return the success `[R]` of each seed, the mean over scenes and over orders of the options."""
    seeds = sorted({row.seed for row in rows})
    return np.array([np.mean([row.scored / row.episodes for row in rows if row.seed == seed]) for seed in seeds])


def table(rows: Sequence[Played]) -> str:
    """Return success in both engines by game and method, with differences to the first method, in Markdown."""
    played = {(row.game, row.agent) for row in rows}
    kinds = [(game, name) for game, names in METHODS.items() for name in names if (game, name) in played]
    groups = {
        (game, name, engine): mine
        for game, name in kinds
        for engine in ENGINES
        if (mine := [row for row in rows if (row.game, row.agent, row.engine) == (game, name, engine)])
    }
    gains = differences(groups)
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    told = [["game", "method", "runs", *(f"{HEADS[name]}{text}" for name in ENGINES for text in ("", ": minus dr"))]]
    for game, name in kinds:
        cells = []
        for engine in ENGINES:
            key = (game, name, engine)
            cells.append(interval(rates(groups[key])) if key in groups else "")
            cells.append(points(gains[key], marks[key]) if key in gains else "")
        seeds = {row.seed for row in rows if (row.game, row.agent) == (game, name)}
        told.append([game, name, str(len(seeds)), *cells])
    return f"{as_markdown(told)}\n\n{below(groups, list(gains.values()))}"


Groups = Mapping[tuple[str, str, str], Sequence[Played]]  # by game, method, engine


def differences(groups: Groups) -> dict[tuple[str, str, str], Difference]:
    """Return the difference between each method and the first one, in each engine."""
    found = {}
    for game, name, engine in groups:
        first = (game, METHODS[game][0], engine)
        if first in groups and name != METHODS[game][0]:
            found[game, name, engine] = difference_of_means(rates(groups[game, name, engine]), rates(groups[first]))
    return found


def interval(values: np.ndarray) -> str:
    """Return a mean over runs in percent, with its interval."""
    return percent(bootstrap(values, np.random.default_rng(0)).interval())


def below(groups: Groups, gains: Sequence[Difference]) -> str:
    """Return the note below the table."""
    sizes = [
        100 * detectable([rates(mine) for (at, _, engine), mine in groups.items() if (at, engine) == (game, word)])
        for game in METHODS
        for word in ENGINES
        if any((at, engine) == (game, word) for at, _, engine in groups)
    ]
    runs = [len(rates(mine)) for mine in groups.values()]
    played = " and ".join(f"{EPISODES[name]} episodes of each scene in {HEADS[name]}" for name in ENGINES)
    said = significance.sentences(
        f"episodes with a goal, mean of the scenes; {played}; 95% bootstrap intervals over runs",
        significance.legend([gain.p for gain in gains]),
        significance.visible(sizes, runs, "{:.0f} points", "game"),
    )
    orders = f"Of `{RARE_GAME}`, each seed's mean over the orders of the options counts as one run."
    everything = [row for mine in groups.values() for row in mine]
    return f"{said} {orders} Trained on {played_on(everything)}; `python -m lab.methods_in_grf`."


def main(argv: Sequence[str]) -> int:
    """Play the runs without rows, and print or publish the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=Path, default=Path("runs"), help="folder of the studies' runs")
    parser.add_argument("--csv", type=Path, default=ROWS, help="file of the rows")
    parser.add_argument("--table", action="store_true", help="play nothing, print what the CSV file has")
    parser.add_argument("--publish", action="store_true", help=f"write the table into {PAGE}")
    options = parser.parse_args(argv)
    check_present(options.csv, load(options.csv, Played))
    if not options.table:
        options.csv.parent.mkdir(parents=True, exist_ok=True)
        play(options.runs, options.csv)
    rows = load(options.csv, Played)
    if not rows:
        print(f"{options.csv} has no rows")
    elif options.publish:
        put(ROOT / PAGE, "grf", table(rows), "In Google Research Football")
    else:
        print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
