"""Policies that play an episode of a Python task: random, a constant action, a baseline, the student of a run.

Read next: `run.level_stage`, the episode; `commands.play`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run.errors import UsageError
from regista.experiments.run.level_stage import Choose, LevelStage


class TaskPlayer(NamedTuple):
    """A policy, and its name in messages."""

    choose: Choose
    name: str


def task_player(name: str, stage: LevelStage, seed: int) -> TaskPlayer:
    """Return the player of a name: random, idle, a baseline of the task, or the run folder of a student.

    Raises `UsageError` for another name, and for a student of another task.
    """
    if name == "idle":
        return TaskPlayer(_constant(stage.env), "always the first action")
    if name in ("bot", "random"):  # bots play football only
        return TaskPlayer(_random(stage.env, seed), "random actions")
    baselines = stage.game.task(stage.game.start("fast")).make_baselines(stage.env)
    if name in baselines:
        return TaskPlayer(_policy(baselines[name], seed), f"the baseline '{name}'")
    if not Path(name).is_dir():
        known = ", ".join(("idle", *baselines))
        raise UsageError(f"--player is {known} or a run folder, and there is no folder {name}")
    return _student(Path(name), stage, seed)


def _student(path: Path, stage: LevelStage, seed: int) -> TaskPlayer:
    from regista.experiments.run.evaluator import load_student
    from regista.experiments.run.folder import RunFolder

    run = RunFolder.open(path)
    if run.config.minigame != stage.game.name:
        raise UsageError(f"{path} is a run on {run.config.minigame}; it cannot play {stage.game.name}")
    student, (env_steps, _) = load_student(run, stage.game)
    return TaskPlayer(_policy(student, seed), f"{run.config.method} after {env_steps:_} env_steps")


def _policy(policy: Any, seed: int) -> Choose:
    from ued.core.seeding import torch_generator
    from ued.learning.student import Player

    return Player(policy, torch_generator(seed))


def _random(env: Any, seed: int) -> Choose:
    env.single_action_space.seed(seed)
    return lambda observation: np.asarray(env.single_action_space.sample())[None]


def _constant(env: Any) -> Choose:
    action = np.zeros_like(env.single_action_space.sample())[None]
    return lambda observation: action
