"""How do methods of UED compare on the maze benchmark, and with published rows? Trains, and stores the rows.

    python -m lab.mazes train main --out runs/mazes          # what is missing; stop it whenever you like
    python -m lab.mazes rows main --out runs/mazes           # of finished runs, into lab/results/maze_*.csv
    python -m lab.maze_tables --publish                      # the tables and the picture of docs/benchmarks/maze.md

Parts: main, the published methods on mazes of 25 walls; recent, methods published since; sixty, mazes of 0 to 59 walls;
long, single runs of 250M steps. Read next: `lab.maze_tables`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from regista.experiments.__main__ import main as regista
from regista.experiments.run import build
from regista.experiments.run.evaluator import EvalScenes, Evaluator
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import save_rows
from regista.experiments.run.table import read_columns, read_rows
from ued.core.task import TRAINING_SCENE

ROWS = Path("lab/results")
SEEDS = 5
EPISODES, LEVELS = 100, 1000  # episodes on each test maze; random mazes, each played 10 times


class Part(NamedTuple):
    """One comparison: its task, the number of runs of each row, their budget, and the rows as `compare --variants`.

    `walls` names the published rows beside it, `beside` the part whose row of DR is the reference, if not this one.
    """

    task: str
    walls: str
    seeds: int
    env_steps: int
    rows: dict[str, str]
    beside: str = ""


BUDGET = 25_000_000
PARTS = {
    "main": Part(
        "maze",
        "25 blocks",
        SEEDS,
        BUDGET,
        {
            "dr": "--method dr",
            "plr": "--method plr",
            "robust_plr": "--method robust_plr",
            "accel": "--method accel",
            "accel_empty": "--method accel --accel.new-levels simplest",
            "paired_steps": "--method paired --ent-coef 0",
            "paired_direct": "--method paired --ent-coef 0 --paired.adversary.builder direct --paired.dr-fraction 0.25 "
            "--paired.adversary.ent-coef 0.1",
            "sfl": "--method sfl",
        },
    ),
    "recent": Part(
        "maze",
        "25 blocks",
        SEEDS,
        BUDGET,
        {
            "mna": "--method robust_plr --plr.score mna",
            "cenie": "--method cenie",
            "ncc": "--method ncc",
            "general_sfl": "--method sfl --sfl.score generalized_learnability",
            "published_plr": "--method robust_plr --plr.buffer.temperature 0.1",
        },
        beside="main",
    ),
    "sixty": Part(
        "maze60",
        "60 blocks uniform",
        SEEDS,
        BUDGET,
        {
            "dr": "--method dr",
            "robust_plr": "--method robust_plr",
            "accel_empty": "--method accel --accel.new-levels simplest",
        },
    ),
    "long": Part(
        "maze",
        "25 blocks",
        1,
        250_000_000,
        {"dr": "--method dr", "robust_plr": "--method robust_plr", "accel": "--method accel"},
    ),
}


# ---------------------------------------------------------------- training


def train(name: str, out: Path, processes: int) -> int:
    """Train and evaluate what is missing of a part; return the exit code."""
    part, folder = PARTS[name], out / name
    rows = [f"{row}: {flags}" for row, flags in part.rows.items()]
    budget = ["--seeds", str(part.seeds), "--total-env-steps", str(part.env_steps), "--processes", str(processes)]
    tests = ["--episodes", str(EPISODES), "--levels", str(LEVELS), "--no-record", "--levels-format", "parquet"]
    failed = regista(["compare", part.task, "--variants", *rows, *budget, *tests, "--out", str(folder)])
    if failed:
        return failed
    runs = runs_of(folder)
    scenes = EvalScenes(runs[0].config, build.find_game(part.task), EPISODES, held_out=True)
    Evaluator(scenes, 0, 0, alike=True, processes=processes).report(runs).save_csv(folder / "held_out.csv")
    return 0


def runs_of(folder: Path) -> list[RunFolder]:
    """Return the runs of a comparison."""
    return [RunFolder.open(path.parent) for path in sorted(folder.glob("*/config.json"))]


# ---------------------------------------------------------------- rows


def store(name: str, out: Path) -> None:
    """Write the rows of a part: `maze_tests.csv`, `maze_levels.csv` and `maze_curves.csv`; other parts' rows stay."""
    folder, task = out / name, PARTS[name].task
    held_out = [row for row in read_rows(folder / "held_out.csv") if row["scene"] != TRAINING_SCENE]  # not twice
    tests = [
        {"part": name, "task": task, "method": row["method"], "seed": row["seed"], "maze": row["scene"]}
        | {key: row[key] for key in ("episodes", "goals", "mean_return", "env_steps")}
        for row in (*read_rows(folder / "results.csv"), *held_out)
    ]
    levels = [{"part": name, "task": task} | row for row in read_rows(folder / "levels.csv")]
    for row in levels:
        del row["simulator"]
    curves = [{"part": name, "task": task} | row for run in runs_of(folder) for row in curve(run)]
    for kind, rows in (("tests", tests), ("levels", levels), ("curves", curves)):
        path = ROWS / f"maze_{kind}.csv"
        others = [row for row in read_rows(path) if row["part"] != name] if path.exists() else []
        save_rows([*others, *rows], list(rows[0]), path)


def curve(run: RunFolder) -> Iterator[dict[str, object]]:
    """Yield a row for each evaluation of a run: steps simulated and learned from, and the share of mazes solved."""
    columns = read_columns(run.path / "metrics.csv")
    tests = [name for name in columns if name.startswith("eval_success/") and not name.endswith(TRAINING_SCENE)]
    student = next(name for name in columns if name.endswith("/trained_steps"))
    trained = np.cumsum(np.nan_to_num(columns[student]))
    solved = np.stack([columns[name] for name in tests], 1)
    for at in np.flatnonzero(np.isfinite(solved).all(1)):
        yield {
            "method": run.name,
            "seed": run.config.seed,
            "env_steps": int(columns["env_steps"][at]),
            "trained_steps": int(trained[at]),
            "solved": round(float(solved[at].mean()), 4),
            "random_levels": float(columns[f"eval_success/{TRAINING_SCENE}"][at]),
        }


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=("train", "rows"))
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--out", type=Path, default=Path("runs/mazes"))
    parser.add_argument("--processes", type=int, default=2)
    typed = parser.parse_args(argv)
    if typed.action == "train":
        return train(typed.part, typed.out, typed.processes)
    store(typed.part, typed.out)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
