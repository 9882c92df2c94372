"""How does PAIRED choose levels on football, and is it independent of the order of options in a program?

It trains PAIRED and PLR with the rare option first, in the middle and last, DR, and DR with all options equally likely,
plays each finished run on held-out scenes, and writes its row. Every setting has ten runs, because five left both games
open by the rule of `lab/studies/curricula.py`. The same command continues a stopped study and skips finished rows;
`--table` prints means and intervals of the CSV file:

    python -m lab.paired_football --csv lab/results/paired_order.csv
    python -m lab.paired_football --csv lab/results/paired_order.csv --table --publish    # into pages
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lab import paired_football_tables as tables
from lab import rare_levels_figure
from lab.paired_football_tables import EPISODES, FIFTHS
from lab.studies.curricula import LONG, PPO, REPLAY
from lab.studies.curricula_study import PAGE
from lab.studies.runs import LONGEST, ROOT, Deadline, StudyRuns, train_and_measure, training
from lab.studies.tables import put
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import build, versions
from regista.experiments.run.errors import CommandError, UsageError, run_command
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import single_game
from regista.experiments.run.launch.workers import LaunchConfig
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.report import save_rows
from regista.experiments.run.table import read_rows
from regista.minigames.suites import NAMED
from ued.core.parameters import choice_in
from ued.core.task import TRAINING_SCENE

SIDES = {"left": "Range(-25, -6)", "right": "Range(6, 25)"}
OUT = "beside(ego, Range(60, 80), {})"
BRANCHES = {  # by game: the replaced text of its program, and the options
    "1v1Rare": ("Discrete({Range(-2, 2): 1, Range(-25, -6): 25, Range(6, 25): 25})", {"rare": "Range(-2, 2)", **SIDES}),
    "1v1RareLine": (
        f"Discrete({{{OUT.format('aside')}: 50, 99 @ Range(-2, 2): 1}})",
        {"rare": "99 @ Range(-2, 2)"} | {name: OUT.format(side) for name, side in SIDES.items()},
    ),
}
ORDERS = {"first": "rare left right", "middle": "left rare right", "last": "left right rare"}


class Cell(NamedTuple):
    """Runs of one setting: a game, the order of its options, the name of the setting, the method and its settings."""

    game: str
    order: str
    variant: str
    method: str
    settings: dict[str, Any]


class Study(NamedTuple):
    """Cells with their seeds and budget."""

    cells: list[Cell]
    seeds: range
    env_steps: int


def cells() -> Iterator[Cell]:
    """Yield DR, DR with all options equally likely, and PAIRED and PLR with each order."""
    for game in BRANCHES:
        yield Cell(game, "first", "dr", "dr", {})
        yield Cell(game, "even", "dr, equally likely options", "dr", {})
        for order in ORDERS:
            yield Cell(game, order, "paired", "paired", {})
        for order in ORDERS:
            yield Cell(game, order, "paired, adversary entropy 0.1", "paired", {"paired.adversary.ent_coef": 0.1})
        for order in ORDERS:
            yield Cell(game, order, "plr", "plr", REPLAY)


STUDY = Study(list(cells()), range(40, 50), 4_000_000)


# ---------------------------------------------------------------- the programs


def program(game: str, order: str, folder: Path) -> str:
    """Return a minigame, or the path of its program with the options in another order."""
    if not order:
        return game
    source = NAMED[game].program
    stands, options = BRANCHES[game]
    text = source.read_text()
    if text.count(stands) != 1:
        raise CommandError(f"{source} has no {stands}")
    weights = {name: 1 if name == "rare" or order == "even" else 25 for name in options}
    names = ORDERS.get(order, ORDERS["first"]).split()
    listed = ", ".join(f"{options[name]}: {weights[name]}" for name in names)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{game}_{order}.scenic"
    path.write_text(text.replace(stands, f"Discrete({{{listed}}})"))
    (folder / "places.scenic").write_text((source.parent / "places.scenic").read_text())
    return str(path)


# ---------------------------------------------------------------- measuring runs


def rare_shares(run: RunFolder) -> list[float]:
    """Return the share of the rarest option of a choice among the adversary's levels, in each fifth of a run.

    The share is nan in a fifth without such levels.
    """
    draws = single_game(run.config.minigame).program(run.config).draws
    name, cells = min(
        ((draw.name, cells) for draw in draws if (cells := choice_in(draw)) is not None),
        key=lambda pair: pair[1].shares.min(),
    )
    table = read_levels(run.path, "update", "source", f"theta/{name}")
    proposed = table["source"] == "proposed"
    mine = cells.index(table[f"theta/{name}"]) == cells.shares.argmin()
    fifth = ((table["update"] - 1) / table["update"].max() * FIFTHS).astype(int)
    parts = [mine[proposed & (fifth == k)] for k in range(FIFTHS)]
    return [float(part.mean()) if len(part) else float("nan") for part in parts]


def measure(run: RunFolder, cell: Cell) -> dict[str, Any]:
    """Return the row of a run: success on each held-out scene in percent, and the share of the rare branch."""
    config = replace(run.config, minigame=cell.game)
    game = build.find_game(cell.game)
    student, (env_steps, _) = load_student(run, game)
    played = EvalScenes(config, game, EPISODES, held_out=True).play(student)
    rates = {label: 100 * float((result.returns > 0).mean()) for label, result in played.items()}
    train = rates.pop(TRAINING_SCENE)
    told = rare_shares(run) if cell.order in ORDERS and cell.method == "paired" else []
    row = {"game": cell.game, "order": cell.order, "variant": cell.variant, "seed": run.config.seed}
    row |= {
        "simulator": SIMULATOR_VERSION,
        "env_steps": env_steps,
        "held_out": np.mean(list(rates.values())),
        "train": train,
    }
    for k, rate in enumerate(rates.values()):
        row[f"scene_{k}"] = rate
    row["scenes"] = "; ".join(rates)
    return row | {f"rare_share_{k}": share for k, share in enumerate(told) if not np.isnan(share)}


COLUMNS = ["game", "order", "variant", "seed", "simulator", "env_steps", "held_out", "train"]
COLUMNS += [*(f"scene_{k}" for k in range(3)), "scenes", *(f"rare_share_{k}" for k in range(FIFTHS))]


# ---------------------------------------------------------------- rows


def key_of(row: Mapping[str, Any]) -> tuple[str, str, str, int]:
    """Return the key of the row; a later row with the same key replaces it."""
    return row["game"], row["order"], row["variant"], int(row["seed"])


def load(path: Path) -> list[dict[str, str]]:
    """Return the rows of a file, none if the file is missing.

    Raises `CommandError` for rows of another version of the simulator, and for a file with other columns.
    """
    rows = read_rows(path) if path.exists() else []
    if rows and list(rows[0]) != COLUMNS:
        raise CommandError(f"{path} is damaged: its columns are {', '.join(rows[0])}")
    refused = "they can be neither published nor added to; move the file away to measure them again"
    for row in rows:
        versions.check_present(int(row["simulator"]), f"rows of {path} were measured on", refused)
    return rows


def add(path: Path, study: Study, cells: Mapping[Path, Cell], run: RunFolder) -> None:
    """Play a run and put its row into a file in place of an older one, in the order of the study.

    `cells`: the cell of each run, by run folder.
    """
    row = measure(run, cells[run.path])
    place = {cell[:3]: index for index, cell in enumerate(study.cells)}
    spelled = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()}
    by_key = {key_of(one): one for one in [*load(path), spelled]}
    kept = sorted(by_key, key=lambda key: (place.get(key[:3], len(place)), key))
    path.parent.mkdir(parents=True, exist_ok=True)
    save_rows([by_key[key] for key in kept], COLUMNS, path)


def train(study: Study, options: argparse.Namespace) -> int:
    """Train the runs of the study that have no row, one seed at a time; return the exit code.

    Each finished run is played, and its row is stored, while others still train.
    """
    base = runs_of(study, options.out)
    done = {key_of(row) for row in load(options.csv) if int(row["env_steps"]) >= study.env_steps}
    print(f"{len(study.cells) * len(study.seeds)} runs, {len(done)} measured", flush=True)
    with Deadline(options.hours) as stop:
        for seed in study.seeds:
            missing = [cell for cell in study.cells if (*cell[:3], seed) not in done]
            runs = [begin(base, cell, seed) for cell in missing]
            cells = {run.path: cell for run, cell in zip(runs, missing, strict=True)}
            keep = partial(add, options.csv, study, cells)
            if not train_and_measure(runs, LaunchConfig(processes=options.processes), stop, keep):
                break
    print(f"{options.csv}{', continue with the same command' if stop else ''}", flush=True)
    return stop.exit_code


def runs_of(study: Study, folder: Path) -> StudyRuns:
    """Return the folder and settings of the study's runs."""
    return StudyRuns(folder, training(), {"total_env_steps": study.env_steps, **LONG, **PPO})


def begin(base: StudyRuns, cell: Cell, seed: int) -> RunFolder:
    """Create the folder of a run, or open it if it was made with the same settings."""
    chosen = {"method": cell.method, **cell.settings}
    kind = f"{cell.variant.replace(', ', '_').replace(' ', '_')}-"
    return base.open(program(cell.game, cell.order, base.folder / "programs"), seed, chosen, kind)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog="python -m lab.paired_football",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--out", type=Path, default=Path("runs/paired_football"), help="folder of the runs")
    made.add_argument("--csv", type=Path, required=True, help="file of the rows, one for each run")
    made.add_argument("--processes", type=int, default=0, help="runs at a time; 0: one for each core")
    made.add_argument("--hours", type=float, default=LONGEST, help="stop after so long; called again, it goes on")
    made.add_argument("--table", action="store_true", help="train nothing, print what the CSV file has")
    made.add_argument("--publish", action="store_true", help=f"write the tables into {PAGE} and RESULTS.md")
    return made


def main(argv: Sequence[str]) -> int:
    """Train and play the runs, print or publish its table; return the exit code."""
    options = parser().parse_args(argv)
    if options.processes < 0 or options.hours <= 0:
        raise UsageError("--processes must be 0 or more, --hours above 0")
    code = 0 if options.table else train(STUDY, options)
    rows = load(options.csv)
    if not rows:
        print(f"{options.csv} has no rows")
        return code
    kinds = [cell[:3] for cell in STUDY.cells]
    text = tables.table(rows, kinds)
    if not options.publish:
        print(f"\n{text}")
        return code
    put(ROOT / PAGE, "rare: order", text, tables.TITLE)
    rare_levels_figure.draw(rows, FIFTHS)
    put(ROOT / "RESULTS.md", "rare: summary", tables.summary(rows, kinds), "Rare levels")
    return code


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
