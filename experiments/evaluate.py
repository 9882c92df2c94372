"""`regista evaluate`: play trained runs, and baselines, on the test scenes of their minigame.

    regista evaluate runs/1v1Restricted-paired-0 --episodes 500

Read next: `testing`, which plays; `results`, which counts.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from experiments import arguments, build
from experiments.arguments import positional
from experiments.baselines import make_baselines
from experiments.config import TrainConfig
from experiments.errors import CommandError, UsageError
from experiments.results import Result, render_table, save_csv, summarise
from experiments.run import RunFolder
from experiments.testing import TestScenes
from ued.config import check_at_least_1, setting

DESCRIPTION = "Play runs on the test scenes of their minigame and on its training distribution, with 95 % intervals."


@dataclass(frozen=True)
class EvaluateConfig:
    """What is typed after `regista evaluate`."""

    runs: tuple[Path, ...] = positional("run folders, all of one minigame", default=())
    episodes: int = setting(500, "whole episodes on each scene")
    baselines: bool = setting(True, "evaluate 'shoot' and 'random' beside the runs")
    threads: int = setting(1, "threads for the simulator and for the networks")
    csv: Path | None = setting(None, "also write the results to this CSV file")
    json: bool = setting(False, "print JSON instead of a table")

    def __post_init__(self) -> None:
        check_at_least_1(self, "episodes", "threads")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(EvaluateConfig(), argv, "evaluate", DESCRIPTION)
    if not config.runs:
        raise UsageError("evaluate needs at least one run folder, such as runs/1v1Restricted-paired-0")
    runs = [RunFolder.open(path) for path in config.runs]
    games = {run.config.minigame for run in runs}
    if len(games) > 1:
        raise CommandError(f"these runs are of different minigames: {', '.join(sorted(games))}; evaluate them apart")
    scenes = TestScenes(replace(runs[0].config, threads=config.threads), config.episodes)
    results = [row for run in runs for row in evaluate_run(run, scenes)]
    if config.baselines:
        results += evaluate_baselines(scenes)
    print(json.dumps([asdict(row) for row in results], indent=2) if config.json else render_table(results))
    if config.csv is not None:
        save_csv(results, config.csv)
    return 0


def evaluate_run(run: RunFolder, scenes: TestScenes) -> list[Result]:
    """Play the student of a run's checkpoint. Raises `CommandError` if the run has none yet."""
    if not run.checkpoint.exists():
        raise CommandError(f"{run.path} has no checkpoint yet; train it first: regista train --resume {run.path}")
    student, trained = load_student(run, scenes)
    return [
        summarise(found, run.config.method, run.config.seed, label, trained)
        for label, found in scenes.play(student).items()
    ]


def evaluate_baselines(scenes: TestScenes) -> list[Result]:
    """Play the policies that need no training."""
    space = scenes.scenes[build.TRAINING_SCENE].single_action_space
    return [
        summarise(found, name, 0, label)
        for name, policy in make_baselines(space).items()
        for label, found in scenes.play(policy).items()
    ]


def load_student(run: RunFolder, scenes: TestScenes) -> tuple[Any, tuple[int, int]]:
    """Give the student of a run's checkpoint, and the env_steps and updates that it was trained for."""
    from ued import checkpoint

    config: TrainConfig = run.config
    program = build.find_minigame(config.minigame).program
    upomdp = build.make_upomdp(program, config.num_envs, config.env, config.seed, config.threads)
    method = build.make_method(config, upomdp)
    method.load_state_dict(checkpoint.load(run.checkpoint)["method"])
    return method.student, (method.env_steps, method.updates)
