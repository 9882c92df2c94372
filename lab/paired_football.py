"""How does PAIRED choose levels on football, and is it independent of how a program lists its options?

Each part trains runs in a folder, plays their students on held-out scenes, and writes a row for each run. `order`:
PAIRED and PLR with the rare branch first, in the middle and last, DR, and DR with all branches equally likely.
`restricted`: a game without a rare branch. `settings`: of PAIRED, one change at a time, on seeds that no final table
uses. A part that was stopped goes on with the same command; `--table` prints means and intervals of its CSV file:

    python -m lab.paired_football order --csv lab/results/paired_order.csv
    python -m lab.paired_football order --csv lab/results/paired_order.csv --table --publish    # into RESULTS.md
"""

from __future__ import annotations

import argparse
import csv
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lab.studies.curricula import LONG, replay
from lab.studies.runs import ROOT, StudyRuns, training
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import build, significance
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import single_game
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.workers import LaunchConfig, train_unfinished
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.significance import difference_of_means, points
from regista.experiments.run.table import read_rows
from regista.minigames.suites import NAMED
from ued.core.parameters import choice_in
from ued.core.task import TRAINING_SCENE
from ued.statistics import Difference, bootstrap

FIFTHS = 5  # of a run, in each of which the rare branch's share of the proposals is counted
EPISODES = 300  # on each held-out scene
SIDES = {"left": "Range(-25, -6)", "right": "Range(6, 25)"}
OUT = "beside(ego, Range(60, 80), {})"
BRANCHES = {  # of each game: what its program says, the text that is replaced, and the options
    "1v1Rare": ("Discrete({Range(-2, 2): 1, Range(-25, -6): 25, Range(6, 25): 25})", {"rare": "Range(-2, 2)", **SIDES}),
    "1v1RareLine": (
        f"Discrete({{{OUT.format('aside')}: 50, 99 @ Range(-2, 2): 1}})",
        {"rare": "99 @ Range(-2, 2)"} | {name: OUT.format(side) for name, side in SIDES.items()},
    ),
}
ORDERS = {"first": "rare left right", "middle": "left rare right", "last": "left right rare"}
TANH = {"paired.adversary.distribution": "tanh_gaussian", "paired.adversary.update_epochs": 20}
ENTROPY = "paired.adversary.ent_coef"


class Cell(NamedTuple):
    """Runs of one setting: a game, in which order its options stand, the name of the setting, and what it is."""

    game: str
    order: str
    variant: str
    method: str
    settings: dict[str, Any]


class Part(NamedTuple):
    """Cells with their seeds and budget."""

    cells: list[Cell]
    seeds: range
    env_steps: int


def paired(game: str, order: str, variant: str, **settings: Any) -> Cell:
    """Return a cell of PAIRED; `ent` and other settings of its adversary are named in full."""
    return Cell(game, order, variant, "paired", settings)


def order_part() -> Iterator[Cell]:
    """Yield DR, DR with all options equally likely, and PAIRED and PLR with each order."""
    for game in BRANCHES:
        yield Cell(game, "first", "dr", "dr", {})
        yield Cell(game, "even", "dr, even branches", "dr", {})
        for order in ORDERS:
            yield paired(game, order, "paired", **{ENTROPY: 0.1})
        for order in ORDERS:
            yield Cell(game, order, "plr", "plr", replay("plr", "learnability"))


SETTINGS: dict[str, dict[str, Any]] = {  # one change of PAIRED at a time
    "population, 2 episodes": {},
    "dennis2020": {"paired.roles": "dennis2020"},
    "flexible": {"paired.roles": "flexible"},
    "dennis2020, mean_mean": {"paired.roles": "dennis2020", "paired.regret": "mean_mean"},
    "1 episode": {"paired.episodes_per_level": 1},
    "4 episodes": {"paired.episodes_per_level": 4},
    "half random levels": {"paired.dr_fraction": 0.5},
}
ROLES = list(SETTINGS)[:3]


def settings_part() -> Iterator[Cell]:
    """Yield PAIRED with each setting on the rare game, its branch in the middle; each role on another game, too."""
    for name, more in SETTINGS.items():
        yield paired("1v1Rare", "middle", name, **{ENTROPY: 0.1} | more)
    for name in ROLES:
        yield paired("1v1Restricted", "", name, **{ENTROPY: 0.1} | SETTINGS[name])


PARTS = {
    "order": Part(list(order_part()), range(20, 25), 4_000_000),
    "restricted": Part(
        [
            Cell("1v1Restricted", "", "dr", "dr", {}),
            paired("1v1Restricted", "", "paired"),
            paired("1v1Restricted", "", "tanh_gaussian", **TANH),
        ],
        range(20, 25),
        500_000,
    ),
    "settings": Part(list(settings_part()), range(1000, 1005), 1_000_000),
}


# ---------------------------------------------------------------- the programs


def program(game: str, order: str, folder: Path) -> str:
    """Return what to train on: a minigame, or its program with the options in another order, written to a file."""
    if not order:
        return game
    source = NAMED[game].program
    stands, options = BRANCHES[game]
    text = source.read_text()
    if text.count(stands) != 1:
        raise SystemExit(f"{source} has no {stands}")
    weights = {name: 1 if name == "rare" or order == "even" else 25 for name in options}
    names = ORDERS.get(order, ORDERS["first"]).split()
    listed = ", ".join(f"{options[name]}: {weights[name]}" for name in names)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{game}_{order}.scenic"
    path.write_text(text.replace(stands, f"Discrete({{{listed}}})"))
    (folder / "places.scenic").write_text((source.parent / "places.scenic").read_text())
    return str(path)


# ---------------------------------------------------------------- what a run did


def rare_shares(run: RunFolder) -> list[float]:
    """Return the share of the rarest option of a choice among the adversary's levels, in each fifth of a run."""
    draws = single_game(run.config.minigame).program(run.config).draws
    name, cells = min(
        ((draw.name, cells) for draw in draws if (cells := choice_in(draw)) is not None),
        key=lambda pair: pair[1].shares.min(),
    )
    table = read_levels(run.path, "update", "source", f"theta/{name}")
    proposed = table["source"] == "proposed"
    mine = cells.index(table[f"theta/{name}"]) == cells.shares.argmin()
    fifth = ((table["update"] - 1) / table["update"].max() * FIFTHS).astype(int)
    return [float(mine[proposed & (fifth == k)].mean()) for k in range(FIFTHS)]


def measure(run: RunFolder, cell: Cell) -> dict[str, Any]:
    """Return the row of a run: success on each held-out scene in percent, and the rare branch's share."""
    config = replace(run.config, minigame=cell.game)
    game = build.find_game(cell.game)
    student, (env_steps, _) = load_student(run, game)
    played = EvalScenes(config, game, EPISODES, held_out=True).play(student)
    rates = {label: 100 * float((result.returns > 0).mean()) for label, result in played.items()}
    train = rates.pop(TRAINING_SCENE)
    shares = rare_shares(run) if cell.order in ORDERS and cell.method == "paired" else []
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
    return row | {f"rare_share_{k}": share for k, share in enumerate(shares)}


COLUMNS = ["game", "order", "variant", "seed", "simulator", "env_steps", "held_out", "train"]
COLUMNS += [*(f"scene_{k}" for k in range(3)), "scenes", *(f"rare_share_{k}" for k in range(FIFTHS))]


SHOWN = {  # columns of the table, in percent
    "held_out": "held-out success",
    "scene_0": "first scene",
    "scene_1": "second scene",
    f"rare_share_{FIFTHS - 1}": "rare option in proposals",
}


def table(rows: list[dict[str, str]]) -> str:
    """Return means over the runs of each setting in percent, with 95% bootstrap intervals over runs, in Markdown.

    The first setting of a game is the reference of its differences.
    """
    kinds = list(dict.fromkeys((row["game"], row["order"], row["variant"]) for row in rows))
    runs = {kind: [row for row in rows if (row["game"], row["order"], row["variant"]) == kind] for kind in kinds}
    first = {game: next(kind for kind in kinds if kind[0] == game) for game, _, _ in kinds}
    gains = {kind: gain(runs[kind], runs[first[kind[0]]]) for kind in kinds if kind not in first.values()}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    head, told = ["game", "order", "setting", "runs", *SHOWN.values(), "minus dr"], []
    for kind in kinds:
        cells = [cell(runs[kind], column) for column in SHOWN]
        told.append(
            [
                *kind,
                str(len(runs[kind])),
                *cells,
                points(gains[kind], marks[kind]) if kind in gains else "",
            ]
        )
    legend = significance.legend([found.p for found in gains.values()])
    versions = ", ".join(sorted({row["simulator"] for row in rows}))
    steps = max(int(row["env_steps"]) for row in rows) / 1e6
    about = (
        f"Percent, {steps:.1f}M env steps; 95% intervals: bootstrap over runs. {legend} Simulator version {versions}."
    )
    return f"{as_markdown([head, *told])}\n\n{about}"


def gain(mine: list[dict[str, str]], base: list[dict[str, str]]) -> Difference:
    """Return the difference in held-out success, as a share."""
    rates = ([float(row["held_out"]) / 100 for row in rows] for rows in (mine, base))
    return difference_of_means(*rates)


def cell(rows: list[dict[str, str]], column: str) -> str:
    """Return the mean of a column in percent with its interval, nothing where no run has the column."""
    scale = 100 if column.startswith("rare") else 1
    values = np.array([scale * float(row[column]) for row in rows if row[column]])
    if not len(values):
        return ""
    found = bootstrap(values, np.random.default_rng(0)).interval()
    low, high = np.clip((found.low, found.high), 0, 100)
    return f"{found.estimate:.0f}" + (f" [{low:.0f}, {high:.0f}]" if found.known else "")


def publish(part: str, text: str, page: Path = ROOT / "RESULTS.md") -> None:
    """Write the table of a part between its marks on a page. Raises SystemExit if the page has no marks."""
    begin, end, old = f"<!-- rare: {part} -->", "<!-- end -->", page.read_text()
    found = re.search(f"{begin}.*?{end}", old, re.S)
    if found is None:
        raise SystemExit(f"{page.name} has no '{begin}' ... '{end}'")
    write_text(page, f"{old[: found.start()]}{begin}\n{text}\n{end}{old[found.end() :]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--out", type=Path, default=Path("runs/paired_football"), help="folder of the runs")
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--processes", type=int, default=0, help="runs at a time; 0: one for each core")
    parser.add_argument("--table", action="store_true", help="train nothing, print what the CSV file has")
    parser.add_argument("--publish", action="store_true", help="write the table into RESULTS.md")
    arguments = parser.parse_args()
    if not arguments.table:
        train(PARTS[arguments.part], arguments.out / arguments.part, arguments.csv, arguments.processes)
    text = table(read_rows(arguments.csv))
    if arguments.publish:
        publish(arguments.part, text)
    else:
        print(text)


def train(part: Part, out: Path, path: Path, processes: int) -> None:
    """Train all runs of a part, and write their rows."""
    base = StudyRuns(out, training(), {"total_env_steps": part.env_steps, **LONG})
    runs = [
        (base.open(program(cell.game, cell.order, out / "programs"), seed, chosen, f"{cell.variant}-"), cell)
        for seed in part.seeds
        for cell in part.cells
        for chosen in ({"method": cell.method, **cell.settings},)
    ]
    with StopRequest() as stop:
        if not train_unfinished([run for run, _ in runs], LaunchConfig(processes=processes), stop):
            raise SystemExit(stop.exit_code)
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for run, cell in runs:
            row = measure(run, cell)
            writer.writerow({name: f"{v:.4g}" if isinstance(v, float) else v for name, v in row.items()})


if __name__ == "__main__":
    main()
