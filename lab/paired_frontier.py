"""Which regret, how many episodes per level and which entropy does PAIRED need on the frontier?

Trains PAIRED on `ued.probes.frontier` with one setting changed at a time, on seeds that the table of the frontier in
RESULTS.md does not use. Writes a row for each run: the share of the task that its protagonist has learned at the end.
Runs with rows in the file are skipped:

    python -m lab.paired_frontier --csv lab/results/paired_frontier.csv
"""

from __future__ import annotations

import argparse
import csv
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from regista.experiments.run import build
from regista.experiments.run.arguments import replace_paths
from regista.experiments.run.config import task_presets
from ued.evaluation import evaluate
from ued.probes import LONGEST, Frontier, frontier
from ued.statistics import bootstrap

TANH = {"adversary.distribution": "tanh_gaussian", "adversary.update_epochs": 20}
SETTINGS: dict[str, dict[str, Any]] = {
    "population, 2 episodes, entropy 0.03": {},
    "flexible": {"roles": "flexible"},
    "dennis2020": {"roles": "dennis2020"},
    "dennis2020, mean_mean": {"roles": "dennis2020", "regret": "mean_mean"},
    "1 episode": {"episodes_per_level": 1},
    "4 episodes": {"episodes_per_level": 4},
    "8 episodes": {"episodes_per_level": 8},
    "entropy 0.1": {"adversary.ent_coef": 0.1},
    "entropy 0.3": {"adversary.ent_coef": 0.3},
    "tanh_gaussian": TANH,
    "tanh_gaussian, entropy 0.1": {**TANH, "adversary.ent_coef": 0.1},
}
SEEDS = range(20, 30)
TESTS = 20  # evaluations of a run
EPISODES = 5  # on each test level, per evaluation
COLUMNS = ("setting", "seed", "env_steps", "known")


def train(setting: str, seed: int) -> dict[str, Any]:
    """Train one run, evaluate it `TESTS` times, and return its row."""
    torch.set_num_threads(1)
    changed = {f"paired.{name}": value for name, value in SETTINGS[setting].items()}
    config = replace_paths(task_presets()["fast"], {**frontier.defaults, **changed})
    config = replace(config, method="paired", seed=seed)
    method = build.make_method(config, Frontier(config.num_envs, LONGEST))
    test, known, tested = Frontier(32, LONGEST), 0.0, 0
    test.reset(seed=0)
    levels = test.test_levels()
    while method.env_steps < config.total_env_steps:
        method.update()
        if method.env_steps >= (tested + 1) * config.total_env_steps / TESTS:
            tested, steps = tested + 1, method.env_steps
            known = float(evaluate(method.student, test, EPISODES * LONGEST, 1, levels).returns.mean())
    return {"setting": setting, "seed": seed, "env_steps": steps, "known": round(known, 4)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--processes", type=int, default=1)
    arguments = parser.parse_args()
    rows: list[dict[str, Any]] = []
    if arguments.csv.exists():
        with open(arguments.csv, newline="") as file:
            rows = list(csv.DictReader(file))
    done = {(row["setting"], int(row["seed"])) for row in rows}
    missing = [(name, seed) for name in SETTINGS for seed in SEEDS if (name, seed) not in done]
    with ProcessPoolExecutor(arguments.processes) as pool, open(arguments.csv, "a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not rows:
            writer.writeheader()
        for row in pool.map(train, *zip(*missing, strict=True)) if missing else ():
            rows.append(row)
            writer.writerow(row)
            file.flush()
    for name in SETTINGS:
        known = np.array([float(row["known"]) for row in rows if row["setting"] == name])
        found = bootstrap(known, np.random.default_rng(0)).interval()
        print(f"{name:40s} {found.estimate:.2f} [{found.low:.2f}, {found.high:.2f}]")


if __name__ == "__main__":
    main()
