"""Python functions for training, evaluation, comparison and inspection, exported by `import regista`.

Read next: `commands.train`, the same on the command line; `loaded`, results as data.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.loaded import ComparisonData, as_path, load_comparison
from regista.experiments.pictures import curves
from regista.experiments.run import build, tasks, trust
from regista.experiments.run.config import ProgramConfig
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.evaluator import EvalScenes, Evaluator
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import single_game
from regista.experiments.run.programs import load_any_program
from regista.experiments.run.report import Report
from regista.experiments.run.run_folders import check_comparable, open_runs
from ued.config import own_names
from ued.settings import converted


def train(task: Any, method: str | None = None, seed: int = 0, out: str | Path | None = None, **settings: Any) -> Path:
    """Train on a task and return its run folder; an existing run is continued to its budget.

    Args:
        task: a `ued.Task`, a function `make(num_envs)`, or the name of a minigame or a task.
        method: a name of `ued.METHODS`; None: the default of `regista train`, which is the task's own or `paired`.
        seed: seed of every random stream.
        out: the run folder, by default runs/TASK-METHOD-SEED.
        settings: any setting listed by `regista train --help all`, such as `total_env_steps`, `num_envs`,
            `ppo=PPOConfig(...)`, or those of a method, `accel=ACCELConfig(...)`.

    Ctrl-C saves and returns.

    Returns:
        the run folder.

    Raises:
        UsageError: unknown names, and settings of another method.
        CommandError: if the folder holds a run with other settings.
    """
    from regista.experiments.commands.train import train as train_run
    from regista.experiments.run.launch.signals import StopRequest

    game = _game(task)
    config = _start(game, settings, ("method", "seed", "out"))
    method = build.find_method(config.method if method is None else method)
    build.check_used(settings, [method])
    config = replace(config, minigame=game.name, method=method, seed=seed)
    path = as_path("out", out) if out is not None else Path("runs") / f"{game.short}-{method}-{seed}"
    run = RunFolder.create_or_extend(path, config)
    with run.removed_if_refused(), run.locked(), StopRequest() as stop:
        train_run(run, stop)
    with suppress(ModuleNotFoundError):  # without Matplotlib `compare` has no pictures, either
        curves.learning_curves({method: [path]}, run.picture)  # written last: it marks the run as finished
    return path


def evaluate(
    runs: str | Path | Sequence[str | Path],
    episodes: int = 100,
    levels: int = 0,
    level_episodes: int = 10,
    trusted: bool = False,
) -> Report:
    """Evaluate the students of runs of one task and a random policy on its tests; return tables of the results.

    A folder of runs, such as the output of `regista compare`, adds all of its runs. Runs of one method share a row.
    With `levels` > 0, the report includes the success rate on the worst tenth of random levels.

    Args:
        runs: a run folder, a folder of runs, or several of either.
        episodes: number of episodes per run and test scene; the command `regista evaluate` plays 500 by default.
        levels: number of random levels; 0: none; the command plays 200 by default.
        level_episodes: number of episodes on each random level.
        trusted: whether to import a Python task that only the run folder names; the import executes the task's file.

    Returns:
        tables of returns and successes with 95% intervals; `text()` prints them.

    Raises:
        CommandError: runs of several tasks, runs without a checkpoint, or a task that only the run folder names, unless
            `trusted`.
        UsageError: no runs.
        ValueError: numbers that are too small.
    """
    from regista.experiments.commands.evaluate import check_levels

    episodes, levels = _whole("episodes", episodes, 1), _whole("levels", levels, 0)
    check_levels(levels, _whole("level_episodes", level_episodes, 2))
    folders = _folders(runs, trusted)
    config = folders[0].config
    scenes = EvalScenes(config, build.find_game(config.minigame), episodes)
    return Evaluator(scenes, levels, level_episodes).report(folders)


def _folders(runs: str | Path | Sequence[str | Path], trusted: bool) -> list[RunFolder]:
    """Return the runs to evaluate, all of one game; with `trusted`, allow their code to run."""
    paths = [runs] if isinstance(runs, str) or not isinstance(runs, Iterable) else runs
    folders = open_runs([as_path("a run", path) for path in paths])
    if not folders:
        raise UsageError("evaluate needs at least one run folder")
    check_comparable(folders)
    for name in (name for run in folders for name in (run.config.minigame, *own_names(run.config)) if trusted):
        trust.allow(name)
    return folders


def compare(
    task: Any,
    methods: str | Sequence[str] = ("dr", "paired"),
    seeds: int | range = 5,
    out: str | Path | None = None,
    episodes: int = 500,
    levels: int = 200,
    **settings: Any,
) -> ComparisonData:
    """Train each method with several seeds, evaluate all runs, and return their tables; finished runs are reused.

    Args:
        task: as for `train`.
        methods: a name of `ued.METHODS`, or several; differences are relative to the first.
        seeds: number of runs of each method, or their seeds, such as `range(1000, 1005)`.
        out: the folder, by default runs/compare-TASK.
        episodes: number of episodes on each test scene.
        levels: number of random levels, for the success rate on the worst tenth.
        settings: as for `train`; they apply to all runs. Settings of a method apply to its runs.

    Runs train in parallel, one per core. Their processes import the task's file, so a call of `compare` in that file
    belongs below `if __name__ == "__main__":`. The function prints progress and tables, and writes the files of
    `regista compare`. Ctrl-C saves and returns the runs so far.

    Raises:
        UsageError: unknown names, and settings of methods that are not compared.
        ValueError: numbers that are too small.
        CommandError: if the folder holds runs with other settings.
    """
    from regista.experiments.commands import compare as command

    game, chosen = _game(task), _seeds(seeds)
    base = _start(game, settings, ("methods", "seeds", "out", "episodes", "levels"))
    names = [methods] if isinstance(methods, str) or not isinstance(methods, Iterable) else methods
    config = command.CompareConfig(game.name, methods=tuple(map(build.find_method, names)), episodes=episodes)
    build.check_used(settings, config.methods)
    config = replace(config, levels=levels, seeds=len(chosen), first_seed=chosen.start, train=base)
    config = config if out is None else replace(config, out=as_path("out", out))
    command.run(config, game, most=1)  # evaluation in other processes would import the caller's script
    return load_comparison(command.folder_of(config, game))


def _seeds(seeds: int | range) -> range:
    chosen = range(seeds) if isinstance(seeds, int) and not isinstance(seeds, bool) else seeds
    if not isinstance(chosen, range) or not chosen or chosen.step != 1:
        raise ValueError(f"seeds must be a positive number, or a range of consecutive seeds, got {seeds!r}")
    return chosen


@dataclass(frozen=True)
class Inspection:
    """The parameters of a task and some of its levels.

    Attributes:
        name: name of the task.
        parameters: name, kind and range of each column of θ.
        theta: random valid levels `[n, D]`, in [-1, 1].
        values: the values of each level, by name.
        text: the output of `regista inspect`.
    """

    name: str
    parameters: tuple[Any, ...]
    theta: np.ndarray
    values: list[dict[str, Any]]
    text: str

    def __str__(self) -> str:
        return self.text


def inspect(task: Any, n: int = 6, seed: int = 0) -> Inspection:
    """Return the parameters of a task or a program, and `n` random levels of it.

    Args:
        task: as for `train`, or the path of a .scenic program.
        n, seed: number of random levels, and their seed.

    Returns:
        the output of `regista inspect`, as text and as data.

    Raises:
        UsageError: an unknown name.
        ScenicError: an invalid program.
        ValueError: unless `n` is positive.
    """
    from regista.experiments.commands.inspect import render_theta
    from regista.experiments.pictures.task_view import describe_task

    n, seed = _whole("n", n, 1), _whole("seed", seed, 0)
    game = _game(task)
    if isinstance(game, tasks.PythonTask):
        with closing(build.make_upomdp(game.task(None).make, n, seed)) as upomdp:
            theta, parameters = upomdp.levels["theta"].copy(), tuple(upomdp.parameters)
            return Inspection(
                game.short, parameters, theta, upomdp.describe(theta), describe_task(game.short, upomdp, theta)
            )
    program, _ = load_any_program(single_game(game.name).minigame.program, None, ProgramConfig())
    theta = program.sample_theta(n, np.random.default_rng(seed))
    values = [program.describe(row) for row in theta]
    return Inspection(game.short, tuple(program.draws), theta, values, render_theta(program, None))


def _whole(name: str, value: Any, least: int) -> int:
    """Return an argument as an integer. Raises `ValueError` for another type, and below `least`."""
    try:
        number = int(converted(int, value))
    except ValueError as error:
        raise ValueError(f"{name} {error}") from None
    if number < least:
        raise ValueError(f"{name} must be at least {least}, got {number}")
    return number


def _game(task: Any) -> Any:
    """Return the game of a task, a function that makes environments, or a name; allow its file to run."""
    game = build.find_game(task if isinstance(task, str) else tasks.name_of(task))
    trust.allow(game.name)
    return game


def _start(game: Any, settings: Mapping[str, Any], arguments: Sequence[str]) -> Any:
    """Return the default settings of a game with these replaced; allow the user code in `settings` to run.

    `arguments` are the names of the call's other arguments, for suggestions. The call sets task, method and seed.
    Raises `UsageError` for an unknown setting, `ValueError` for an invalid value.
    """
    config = game.start("fast")
    known = [key for key in vars(config) if key not in ("minigame", "method", "seed")]
    unknown = [key for key in settings if key not in known]
    if unknown:
        raise UsageError(f"unknown setting '{unknown[0]}'{nearest(unknown[0], [*arguments, *known])}")
    chosen = replace(config, **settings)
    for name in own_names(chosen):
        trust.allow(name)
    return chosen
