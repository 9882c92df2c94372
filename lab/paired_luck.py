"""How much does a shared random stream for both students of PAIRED reduce the variance of regret?

PAIRED trains on football. At some points of a run, both students play the same levels many times: once with the same
environment seed in each pair of episodes, as in training, and once with different seeds. Students sample their actions
from separate streams in both cases. Each point of each run has a row with the variance of antagonist - protagonist
within a level, with the same and with different seeds. It also has the variance of the default regret from n episodes
of each. At the end, or of stored rows with --table, it prints the share of variance that the same seeds remove: of the
mean variances of each game, and in parentheses the range over runs.

    python -m lab.paired_luck --csv lab/results/paired_luck.csv
    python -m lab.paired_luck --csv lab/results/paired_luck.csv --table
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import arguments, build
from ued.evaluation import evaluate
from ued.levels.record import Origin
from ued.levels.scores import population_regret

GAMES = ("1v1Rare", "1v1Restricted", "3v2FourBehaviors")
POINTS = (200_000, 500_000, 1_000_000)  # env_steps at which a run is measured
LEVELS, EPISODES = 128, 16  # half of the levels are random, half are the adversary's
COUNTS = (1, 2, 4, 8)  # episodes of each student per regret
SETTINGS = {"num_envs": 16, "ppo.num_steps": 512, "ppo.ent_coef": 0.003, "paired.adversary.ent_coef": 0.1}


class OwnStream:
    """A student that samples its actions from its own random stream, regardless of the caller's."""

    def __init__(self, student: Any, seed: int) -> None:
        self.student, self.generator = student, torch.Generator().manual_seed(seed)
        self.empty_memory = student.empty_memory

    def play(self, observation: np.ndarray, generator: torch.Generator, greedy: bool, memory: torch.Tensor) -> Any:
        return self.student.play(observation, self.generator, greedy, memory)


def returns(method: Any, upomdp: Any, levels: np.ndarray, luck: tuple[int, int]) -> np.ndarray:
    """Return the returns `[2, L, EPISODES]` of both students, each with its own environment seed from `luck`."""
    played = [
        evaluate(OwnStream(student, 10 + k), upomdp, len(levels) * EPISODES, seed, levels)
        for k, (student, seed) in enumerate(zip(method.students.values(), luck, strict=True))
    ]
    return np.stack([one.returns.reshape(EPISODES, len(levels)).T for one in played])


def spread(played: np.ndarray, count: int | None = None) -> float:
    """Return the variance of antagonist - protagonist within a level, or of regret from `count` episodes of each."""
    if count is None:
        values = played[1] - played[0]
    else:
        groups = played.reshape(2, len(played[0]), -1, count)
        parts = [groups[:, :, k].swapaxes(0, 1) for k in range(groups.shape[2])]
        values = np.stack([population_regret(part, "max_mean") for part in parts], 1)
    return float(values.var(1, ddof=1).mean())


def rows_of(game: str, seed: int) -> list[dict[str, Any]]:
    """Train one run, and return a row for each of its points."""
    config = arguments.replace_paths(build.find_game(game).start("fast"), SETTINGS)
    config = replace(config, minigame=game, method="paired", seed=seed, total_env_steps=POINTS[-1])
    make = build.find_game(game).task(config).make
    method = build.make_method(config, build.make_upomdp(make, config.num_envs, seed))
    test = build.make_upomdp(make, 64, seed)
    rows = []
    for point in POINTS:
        while method.env_steps < point:
            method.update()
        proposed = method.curriculum.propose(4 * LEVELS)
        proposed = proposed["level"][proposed["origin"] == Origin.PROPOSED][: LEVELS // 2]
        levels = np.concatenate([test.sample_levels(LEVELS // 2), proposed])
        same, other = returns(method, test, levels, (1, 1)), returns(method, test, levels, (1, 2))
        row = {
            "game": game,
            "simulator": SIMULATOR_VERSION,
            "seed": seed,
            "env_steps": point,
            "success": float((same > 0).mean()),
        }
        row |= {"same": spread(same), "other": spread(other)}
        for count in COUNTS:
            row |= {f"regret_{count}_same": spread(same, count), f"regret_{count}_other": spread(other, count)}
        rows.append({name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()})
        print(rows[-1], flush=True)
    return rows


def removed(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a Markdown table: by game, the share of variance that the same seeds remove, and its range over runs."""
    table = ["| game | difference of two episodes | default regret, 2 episodes of each |", "|---|---|---|"]
    for game in dict.fromkeys(row["game"] for row in rows):
        cells = []
        for name in ("", "regret_2_"):
            runs: dict[str, list[tuple[float, float]]] = {}
            for row in rows:
                if row["game"] == game:
                    runs.setdefault(row["seed"], []).append((float(row[f"{name}same"]), float(row[f"{name}other"])))
            variances = np.array([np.mean(points, 0) for points in runs.values()])  # [R, 2]
            whole, single = (100 - 100 * of[..., 0] / of[..., 1] for of in (variances.mean(0), variances))
            cells.append(f"{whole:.0f}% ({single.min():.0f} to {single.max():.0f}%)")
        table.append("| " + " | ".join([game, *cells]) + " |")
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--games", nargs="+", default=GAMES)
    parser.add_argument("--seeds", type=int, default=3, help="runs of each game, with seeds 1000, 1001, ...")
    parser.add_argument("--csv", type=Path, required=True)
    parser.add_argument("--table", action="store_true", help="print the table of the stored rows, without training")
    parsed = parser.parse_args()
    if not parsed.table:
        measure(parsed.games, parsed.seeds, parsed.csv)
    with open(parsed.csv, newline="") as file:
        print("\n".join(removed(list(csv.DictReader(file)))))


def measure(games: Sequence[str], seeds: int, path: Path) -> None:
    """Train all runs, and write their rows."""
    torch.set_num_threads(1)
    with open(path, "w", newline="") as file:
        writer = None
        for game in games:
            for seed in range(1000, 1000 + seeds):
                for row in rows_of(game, seed):
                    writer = writer or csv.DictWriter(file, list(row))
                    if file.tell() == 0:
                        writer.writeheader()
                    writer.writerow(row)
                file.flush()


if __name__ == "__main__":
    main()
