"""Policies that play an episode: scripted policies, baselines of a task, students of runs.

Read next: `run.level_stage`, the episode; `commands.play`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run.errors import UsageError
from regista.experiments.run.level_stage import Choose, LevelStage
from regista.experiments.run.shipped import located

SCRIPTED = ("bot", "random", "idle")  # football policies without training


class Actor(NamedTuple):
    """A policy, and its name in messages; `choose(seed)` returns the function that acts in an episode."""

    choose: Callable[[int], Choose]
    name: str


def task_player(name: str, stage: LevelStage, greedy: bool = False) -> Actor:
    """Return the player of a name: random, idle, a baseline of the task, a shipped policy, or a student's run folder.

    Raises `UsageError` for another name, and for a student with other observations or actions.
    """
    if name == "idle":
        return Actor(partial(_constant, stage.env), "always the first action")
    if name in ("bot", "random"):  # bots play football only
        return Actor(partial(_random, stage.env), "random actions")
    baselines = stage.game.task(stage.game.start("fast")).make_baselines(stage.env)
    if name in baselines:
        return Actor(partial(_policy, baselines[name]), f"the baseline '{name}'")
    if not located(name).is_dir():
        known = ", ".join(("idle", *baselines))
        raise UsageError(f"--player must be {known}, a shipped policy or a run folder; there is no folder {name}")
    return _student(name, stage, greedy)


def _student(name: str, stage: LevelStage, greedy: bool) -> Actor:
    from regista.experiments.run.build import find_game
    from regista.experiments.run.evaluator import load_method
    from regista.experiments.run.folder import RunFolder

    run = RunFolder.open(located(name))
    game = stage.game if run.config.minigame == stage.game.name else find_game(run.config.minigame)
    method, (env_steps, _) = load_method(run, game)
    for what in ("observation", "action"):
        trained, found = (getattr(each, f"single_{what}_space") for each in (method.upomdp, stage.env))
        if trained != found:
            raise UsageError(
                f"{name} is a run on {game.short}, whose {what}s are {trained}; it cannot play {stage.game.short}, "
                f"whose {what}s are {found}"
            )
    return Actor(partial(_policy, method.student, greedy=greedy), _named(run, env_steps))


def _named(run: Any, env_steps: int) -> str:
    return f"{run.label} after {env_steps:_} env_steps"


def _policy(policy: Any, seed: int, greedy: bool = False) -> Choose:
    from ued.core.seeding import torch_generator
    from ued.learning.student import Player

    return Player(policy, torch_generator(seed), greedy)


def _random(env: Any, seed: int) -> Choose:
    env.single_action_space.seed(seed)
    return lambda observation: np.asarray(env.single_action_space.sample())[None]


def _constant(env: Any, seed: int) -> Choose:
    action = np.zeros_like(env.single_action_space.sample())[None]
    return lambda observation: action


# ---------------------------------------------------------------- football


@dataclass(frozen=True)
class MatchStudent:
    """The student of a run on football; it plays matches with the settings of its training."""

    run: Any
    game: Any

    @classmethod
    def open(cls, path: str) -> MatchStudent:
        """Return the student of a run folder or a shipped policy.

        Raises `UsageError` for another folder, or a run on another task.
        """
        from regista.experiments.run.build import find_game
        from regista.experiments.run.folder import RunFolder

        if not located(path).is_dir():
            known = ", ".join(SCRIPTED)
            raise UsageError(
                f"--player must be {known}, a shipped policy or a run folder of football; there is no folder {path}"
            )
        run = RunFolder.open(located(path))
        game = find_game(run.config.minigame)
        if run.config.engine is None:
            raise UsageError(f"{path} is a run on {game.short}; it cannot play football")
        return cls(run, game)

    def settings(self, playing: Any) -> Any:
        """Return the settings of its matches, on another engine if `playing` has one."""
        return self.run.config.scored().on_engine(playing).env

    def actor(self, env: Any, greedy: bool) -> Actor:
        """Return the policy for matches. Raises `UsageError` if it was trained with other observations or actions."""
        from regista.experiments.run.evaluator import load_method

        method, (env_steps, _) = load_method(self.run, self.game)
        for what in ("observation", "action"):
            trained, found = (getattr(each, f"single_{what}_space").shape for each in (method.upomdp, env))
            if trained != found:
                raise UsageError(
                    f"{self.run.path} was trained with {what}s of shape {trained} on {self.game.short}; "
                    f"{env.program.file} has {found}"
                )
        return Actor(partial(_policy, method.student, greedy=greedy), _named(self.run, env_steps))


def scripted_player(name: str) -> Actor:
    """Return a policy of SCRIPTED, for matches with raw observations."""
    return Actor(partial(_scripted, name), name)


def _scripted(name: str, seed: int) -> Choose:
    from regista.envs.football.observation.raw import row
    from regista.envs.football.view.bot import act

    rng = np.random.default_rng(seed)

    def move(observation: Any) -> int:
        if name == "bot":
            return act(row(observation, 0))
        return int(rng.integers(19)) if name == "random" else 0

    def choose(observations: Any) -> np.ndarray:
        several = isinstance(observations, tuple)
        return np.array([[move(each) for each in observations] if several else move(observations)])

    return choose
