"""How do UED methods compare on the maze benchmark, and with published rows? Trains, and stores the rows.

    python -m lab.mazes main --out runs/mazes       # runs without rows, one seed at a time; may be stopped at any time
    python -m lab.maze_tables --publish             # the tables and the picture of docs/benchmarks/maze.md

Parts: main, the published methods on mazes of 25 walls; recent, newer methods; sixty, mazes of 0 to 59 walls; long,
single runs of 250M steps. Read next: `lab.maze_tables`.
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
EPISODES, LEVELS = 100, 1000  # episodes on each test maze; random mazes, each played 10 times


class Part(NamedTuple):
    """One comparison: its task, the number of runs of each row, their budget, and the rows as `compare --variants`.

    `walls` names the published rows for comparison; `beside` names the part with the DR reference, if it is not this
    one.
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
        5,
        BUDGET,
        {
            "dr": "--method dr",
            "plr": "--method plr",
            "robust_plr": "--method robust_plr",
            "accel": "--method accel",
            "paired_steps": "--method paired --ent-coef 0",
            "paired_direct": "--method paired --ent-coef 0 --paired.adversary.builder direct --paired.dr-fraction 0.25 "
            "--paired.adversary.ent-coef 0.1",
            "sfl": "--method sfl",
        },
    ),
    "recent": Part(
        "maze",
        "25 blocks",
        5,
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
        5,
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
        {name: f"--method {name} --eval-every 5_000_000" for name in ("dr", "robust_plr", "accel")},
    ),
}


# ---------------------------------------------------------------- training


def train(name: str, seed: int, out: Path, processes: int) -> int:
    """Train, evaluate and store those runs of one seed that have no rows; return the exit code."""
    part, done = PARTS[name], stored(name, seed)
    missing = {row: flags for row, flags in part.rows.items() if row not in done}
    if not missing:
        return 0
    folder = out / name / str(seed)
    budget = ["--first-seed", str(seed), "--seeds", "1", "--total-env-steps", str(part.env_steps)]
    tests = ["--episodes", str(EPISODES), "--levels", str(LEVELS), "--no-record", "--levels-format", "parquet"]
    common = [*budget, *tests, "--processes", str(processes), "--out", str(folder)]
    failed = regista(["compare", part.task, "--variants", *map(": ".join, missing.items()), *common])
    if failed:
        return failed
    found = (RunFolder.open(path.parent) for path in sorted(folder.glob("*/config.json")))
    runs = [run for run in found if run.name in missing]
    scenes = EvalScenes(runs[0].config, build.find_game(part.task), EPISODES, held_out=True)
    Evaluator(scenes, 0, 0, alike=True, processes=processes).report(runs).save_csv(folder / "held_out.csv")
    store(name, runs, folder)
    return 0


# ---------------------------------------------------------------- rows


def stored(name: str, seed: int) -> set[str]:
    """Return the rows of a part with results for this seed."""
    path = ROWS / "maze_tests.csv"
    found = read_rows(path) if path.exists() else []
    return {row["method"] for row in found if row["part"] == name and int(row["seed"]) == seed}


def store(name: str, runs: Sequence[RunFolder], folder: Path) -> None:
    """Add the rows of some runs to `maze_tests.csv`, `maze_levels.csv` and `maze_curves.csv`."""
    task = PARTS[name].task
    names = {run.name for run in runs}
    held_out = [row for row in read_rows(folder / "held_out.csv") if row["scene"] != TRAINING_SCENE]  # not twice
    tests = [
        {"part": name, "task": task, "method": row["method"], "seed": row["seed"], "maze": row["scene"]}
        | {key: row[key] for key in ("episodes", "goals", "mean_return", "env_steps")}
        for row in (*read_rows(folder / "results.csv"), *held_out)
        if row["method"] in names  # baselines have no rows
    ]
    levels = [{"part": name, "task": task} | row for row in read_rows(folder / "levels.csv") if row["method"] in names]
    for row in levels:
        del row["simulator"]
    curves = [{"part": name, "task": task} | row for run in runs for row in curve(run)]
    for kind, rows in (("levels", levels), ("curves", curves), ("tests", tests)):  # `stored` reads the last file
        path = ROWS / f"maze_{kind}.csv"
        others = read_rows(path) if path.exists() else []
        save_rows([*others, *rows], list(rows[0]), path)


def curve(run: RunFolder) -> Iterator[dict[str, object]]:
    """Yield a row for each evaluation of a run: simulated steps, steps learned from, and the share of mazes solved."""
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
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--out", type=Path, default=Path("runs/mazes"))
    parser.add_argument("--seeds", type=int, help="the first N seeds of the part; default: all")
    parser.add_argument("--processes", type=int, default=2)
    typed = parser.parse_args(argv)
    for seed in range(typed.seeds or PARTS[typed.part].seeds):
        failed = train(typed.part, seed, typed.out, typed.processes)
        if failed:
            return failed
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
