"""A level from the table of a run's levels, or of a task, in an environment at its start.

Read next: `ued.levels.table`, which reads the row; `run.players`, which plays it; `commands.play`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from regista.experiments.run import build
from regista.experiments.run.errors import CommandError, UsageError, nearest
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.rendering import rendered

if TYPE_CHECKING:
    from regista.envs.football.config import FootballConfig
    from regista.experiments.run.config import EngineConfig
    from regista.experiments.run.games import Game

Choose = Callable[[Any], Any]  # observations -> actions
FRAMES_PER_SECOND = 10  # default for environments without `render_fps`


class PlayedTask(NamedTuple):
    """An episode: its steps and return, whether it ended and succeeded, and its frames if requested."""

    steps: int
    total: float
    ended: bool
    success: bool
    frames: list[np.ndarray]


@dataclass(frozen=True)
class LevelStage:
    """A single environment at the start of a level.

    Attributes:
        game: the game of the environment.
        env: the vector environment, of size 1.
        level: the level, a record `[1]`; `visit`: the visit that determines its random numbers.
        choices: θ `[L, D]` of the levels of a test scene; None: the levels are random.
    """

    game: Game
    env: Any
    level: np.ndarray
    visit: int
    choices: np.ndarray | None = None

    @classmethod
    def of_task(cls, game: Game, scene: str, seed: int) -> LevelStage:
        """Make the environment of a task on a random level of one of its scenes, or on its first level.

        Raises `UsageError` for an unknown scene, `CommandError` for levels that do not match the environments.
        """
        from regista.experiments.run.evaluator import theta_of_test

        task = game.task(game.start("fast"))
        scenes = {**task.scenes(), **task.held_out}
        if scene not in scenes:
            raise UsageError(f"{game.short} has no test {scene!r}{nearest(scene, scenes)}; it has {', '.join(scenes)}")
        env = build.make_upomdp(task.make_scene(scenes[scene]), 1, seed)
        theta = theta_of_test(scene, scenes[scene], env, game.name)
        return cls(game, env, env.levels.copy() if theta is None else env.make_levels(theta[:1]), 0, theta)

    def on_next_level(self, seed: int, episode: int) -> LevelStage:
        """Return the stage of another episode: a random level for this seed, or level `episode` of the test scene."""
        self.env.reset(seed=seed)
        if self.choices is None:
            return replace(self, level=self.env.levels.copy())
        at = episode % len(self.choices)
        return replace(self, level=self.env.make_levels(self.choices[at : at + 1]))

    def on_next_visit(self) -> LevelStage:
        """Return the stage of the next visit of the level: the same level with other random numbers."""
        return replace(self, visit=self.visit + 1)

    @classmethod
    def of_run(
        cls, path: Path, id: int, visit: int | None, playing: EngineConfig, env: FootballConfig | None = None
    ) -> LevelStage:
        """Make the environment of a run and reset it to one of its levels.

        `env` are the settings of football matches; None: those for watching, with raw observations.
        Raises `CommandError` for a run without this level, or whose environments have changed.
        """
        from ued.levels.table import read_visit

        run = RunFolder.open(path)
        try:
            level, visit = read_visit(path, id, visit)
        except FileNotFoundError as error:
            raise CommandError(f"{path} has no table of levels: no update has finished yet") from error
        except (KeyError, ValueError) as error:
            raise CommandError(str(error.args[0])) from error
        config = replace(run.config, threads=1)
        try:
            watched = env or config.watched(playing)
        except ValueError as error:
            raise UsageError(str(error)) from error
        game, level = build.find_game(config.minigame).of_level(level, config)
        made = build.make_upomdp(game.task(config, watched).make, 1, config.seed)
        if made.levels.dtype != level.dtype:
            dims = made.theta_dim, level["theta"].shape[1]
            raise CommandError(f"{path} has levels of {dims[1]} parameters, its environments now have {dims[0]}")
        _, info = made.reset_to_levels(level, None, visit)
        if info["replaced"][0]:
            raise CommandError(f"level {id} of {path} is no longer valid: its environments have changed")
        return cls(game, made, level, visit)

    @property
    def is_match(self) -> bool:
        """Whether the environment is a football match."""
        return hasattr(self.env, "matches")

    @property
    def is_visible(self) -> bool:
        """Whether the environment can be filmed: it is a match, or it renders pictures."""
        return self.is_match or self.env.render_mode == "rgb_array"

    @property
    def frames_per_second(self) -> float:
        """Frame rate for video in real time: the environment's `render_fps`, or ten."""
        return float(self.env.metadata.get("render_fps") or FRAMES_PER_SECOND)

    def describe(self) -> str:
        """Describe the level: its seed, its visit (which determines random numbers), and the parameters of θ."""
        values = self.env.describe(self.level["theta"])[0]
        spelled = ", ".join(
            f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in values.items()
        )
        numbers = f", random numbers of visit {self.visit}" if self.visit else ""
        return f"level of seed {int(self.level['seed'][0])}{numbers}: {spelled or 'no parameters'}"

    def play(self, steps: int, choose: Choose, film: bool = False) -> PlayedTask:
        """Play the episode from its start, for at most this many steps; `choose` returns the actions `[1, ...]`."""
        from ued.core.upomdp import successes

        observation, _ = self.env.reset_to_levels(self.level, None, self.visit)
        total, ended, done, info = 0.0, False, 0, {}
        frames = [self._frame()] if film else []
        while done < steps and not ended:
            observation, reward, terminated, truncated, info = self.env.advance(choose(observation))
            total, ended, done = total + float(reward[0]), bool(terminated[0] or truncated[0]), done + 1
            if film:
                frames.append(self._frame())
        success = ended and bool(successes(info, np.array([0]), np.array([total]))[0])
        return PlayedTask(done, total, ended, success, frames)

    def _frame(self) -> np.ndarray:
        if self.is_match:
            from regista.envs.football.view.picture import draw_match

            return draw_match(self.env.matches[0])
        images = rendered(self.env)
        assert images is not None, "see is_visible"
        return images[0]
