"""Python functions for training and evaluation, exported by `import regista`.

Read next: `commands.train`, the same on the command line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from regista.experiments.run import build, tasks, trust
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.evaluator import EvalScenes, Evaluator, check_one_game
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import Report
from regista.experiments.run.run_folders import open_runs, warn_of_mixtures


def train(task: Any, method: str | None = None, seed: int = 0, out: str | Path | None = None, **settings: Any) -> Path:
    """Train on a task and return its run folder; an existing run is continued to its budget.

    Args:
        task: a `ued.Task`, a function `make(num_envs)`, or the name of a minigame or a task.
        method: a name of `ued.METHODS`; None: the default of `regista train`, which is the task's own or `paired`.
        seed: seed of every random stream.
        out: the run folder, by default runs/TASK-METHOD-SEED.
        settings: any setting listed by `regista train --help all`, such as `total_env_steps`, `num_envs`,
            `ppo=PPOConfig(...)`, or those of a method, `accel=ACCELConfig(...)`.

    Ctrl-C saves and returns. Raises `UsageError` for unknown names, and
    `CommandError` if the folder holds a run with other settings.
    """
    from regista.experiments.commands.train import train as train_run
    from regista.experiments.run.launch.signals import StopRequest

    game = build.find_game(task if isinstance(task, str) else tasks.name_of(task))
    trust.allow(game.name)
    config = game.start("fast")
    unknown = [key for key in settings if key not in vars(config)]
    if unknown:
        raise UsageError(f"unknown setting '{unknown[0]}'{nearest(unknown[0], vars(config))}")
    method = build.find_method(config.method if method is None else method)
    config = replace(config, minigame=game.name, method=method, seed=seed, **settings)
    path = Path(out) if out is not None else Path("runs") / f"{game.short}-{method}-{seed}"
    run = RunFolder.create_or_extend(path, config)
    with run.locked(), StopRequest() as stop:
        train_run(run, stop)
    return path


def evaluate(
    runs: str | Path | Sequence[str | Path],
    episodes: int = 100,
    levels: int = 0,
    level_episodes: int = 10,
    trusted: bool = False,
) -> Report:
    """Evaluate the students of runs of one task and a random policy on its tests; return tables of the results.

    A folder of runs, such as that of `regista compare`, stands for all of them; runs of one method are one row.
    With `levels` random levels, `level_episodes` on each, the report includes the success rate on the worst tenth.
    Raises `CommandError` for runs of several tasks or without a checkpoint, `UsageError` without runs, and `ValueError`
    for numbers that are too small. Evaluating executes the file of a Python task, so a task that only the run folder
    names raises `CommandError` unless `trusted`.
    """
    from regista.experiments.commands.evaluate import check_levels

    if episodes < 1:
        raise ValueError(f"episodes must be at least 1, got {episodes}")
    check_levels(levels, level_episodes)
    paths = [runs] if isinstance(runs, str | Path) else list(runs)
    folders = open_runs(map(Path, paths))
    if not folders:
        raise UsageError("evaluate needs at least one run folder")
    check_one_game(folders)
    warn_of_mixtures(folders)
    config = folders[0].config
    if trusted:
        trust.allow(config.minigame)
    scenes = EvalScenes(config, build.find_game(config.minigame), episodes)
    return Evaluator(scenes, levels, level_episodes).report(folders)
