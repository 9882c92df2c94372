"""`regista compare`: train methods on a minigame over seeds, test them all, tabulate and draw.

    regista compare 1v1Restricted --methods dr paired --seeds 4 --total-env-steps 3_000_000 --out demo

Every run is a folder beneath `--out`; a second call skips what is finished and continues what is not.
Read next: `workers`, which trains; `results`, which counts; `overview`, which draws.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from experiments import arguments, build, level_plots, plots
from experiments.arguments import group, positional
from experiments.config import TrainConfig, presets
from experiments.evaluate import evaluate_baselines, evaluate_run
from experiments.overview import Comparison, overview
from experiments.results import render_table, save_csv
from experiments.run import RunFolder
from experiments.stopping import StopRequest
from experiments.table import cannot_write
from experiments.testing import TestScenes
from experiments.workers import train_all
from ued.config import check_at_least_1, check_not_negative, setting

DESCRIPTION = (
    "Train methods on one minigame over several seeds, evaluate every run and two baselines on its test scenes, and "
    "write a table and pictures. Can be stopped at any time; called again, it continues."
)
OWN = ("minigame", "method", "seed")  # settings of a run that the comparison chooses


@dataclass(frozen=True)
class CompareConfig:
    """What is typed after `regista compare`."""

    minigame: str = positional("a minigame's name, or the path of a .scenic program", default="1v1Restricted")
    methods: tuple[str, ...] = setting(("dr", "paired"), "methods to compare")
    seeds: int = setting(4, "runs of each method, with seeds 0, 1, ...")
    episodes: int = setting(500, "whole episodes on each test scene after training")
    processes: int = setting(0, "runs at a time; 0: one per core")
    out: Path | None = setting(None, "folder of the comparison (default runs/compare-MINIGAME)")
    preset: Literal["fast", "thesis"] = setting("fast", "starting point of the settings: fast, or thesis for Table 4.2")
    train: TrainConfig = group(TrainConfig, "each run", without=OWN)

    def __post_init__(self) -> None:
        check_at_least_1(self, "seeds", "episodes")
        check_not_negative(self, "processes")
        if not self.methods or len(set(self.methods)) < len(self.methods):
            raise ValueError(f"methods must be one or more, each named once, got {' '.join(self.methods) or 'none'}")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = _read(argv)
    folder = config.out or Path("runs") / f"compare-{build.find_minigame(config.minigame).name}"
    runs = prepare(config, folder)
    scenes = TestScenes(runs[0].config, config.episodes)  # compiles the kernels before there are several processes
    unfinished = [run for run in runs if not run.finished()]
    cores = os.cpu_count() or 1
    with StopRequest() as stop:
        if unfinished:
            processes = config.processes or max(1, cores // config.train.threads)
            print(
                f"{len(runs)} runs, {len(runs) - len(unfinished)} finished; {min(processes, len(unfinished))} at a time"
            )
            train_all(unfinished, processes, stop)
    if stop:
        print("continue with the same command: finished runs are kept")
        return stop.exit_code
    print(f"testing {len(runs)} runs and the baselines on {len(scenes.scenes)} scenes, {config.episodes} episodes each")
    report(runs, scenes, folder)
    return 0


def prepare(config: CompareConfig, folder: Path) -> list[RunFolder]:
    """Create the run folders that are not there yet, and open the others; they must agree with the settings."""
    runs, minigame = [], build.settled_name(config.minigame)
    for seed in range(config.seeds):
        for method in config.methods:
            wanted = replace(config.train, minigame=minigame, method=method, seed=seed)
            path = folder / f"{method}-{seed}"
            if (path / "config.json").exists():
                run = RunFolder.open(path)
                run.extend(wanted)
            else:
                run = RunFolder.create(path, wanted)
            runs.append(run)
    return runs


def report(runs: Sequence[RunFolder], scenes: TestScenes, folder: Path) -> None:
    """Evaluate all runs and the baselines; print the table; write table, CSV and pictures."""
    results = [row for run in runs for row in evaluate_run(run, scenes)] + evaluate_baselines(scenes)
    save_csv(results, folder / "results.csv")
    table = render_table(results)
    try:
        (folder / "table.txt").write_text(table + "\n")
    except OSError as error:
        raise cannot_write(folder / "table.txt", error) from error
    by_method: dict[str, list[Path]] = {}
    for run in runs:
        by_method.setdefault(run.config.method, []).append(run.path)
    painter = build.make_painter(scenes.scenes[build.TRAINING_SCENE].program)
    name = build.find_minigame(runs[0].config.minigame).name
    draw(Comparison(name, by_method, results, painter), folder)
    print(f"\n{table}\n")
    print(f"pictures and numbers: {folder}/overview.png, learning_curves.png, levels.png, results.csv")
    print(f"curriculum: rerun {runs[-1].path}/curriculum*.rrd")


def draw(found: Comparison, folder: Path) -> None:
    """Draw the three pictures of a comparison."""
    plots.learning_curves(found.runs, folder / "learning_curves.png")
    level_plots.levels(found.runs, found.painter, folder / "levels.png")
    overview(found, folder / "overview.png")


def _read(argv: Sequence[str]) -> CompareConfig:
    typed = arguments.typed_settings(CompareConfig(), argv, "compare", DESCRIPTION)
    base = CompareConfig(train=presets()[typed.get("preset", "fast")])
    config = arguments.replace_paths(base, typed)
    for method in config.methods:
        build.find_method(method)
    return config
