"""A level from the table of a run's levels, in an environment at its start.

Read next: `ued.levels.table`, which reads the row; `commands.play`, which plays it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from regista.experiments.run import build
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder

if TYPE_CHECKING:
    from regista.experiments.run.config import EngineConfig


class PlayedTask(NamedTuple):
    """An episode: its steps, return, whether it ended, and its rendered frames, if any."""

    steps: int
    total: float
    ended: bool
    frames: list[np.ndarray]


@dataclass(frozen=True)
class LevelStage:
    """A single environment at the start of a level.

    Attributes:
        env: the vector environment, of size 1.
        level: the level, a record `[1]`; `visit`: the visit whose random numbers it uses.
    """

    env: Any
    level: np.ndarray
    visit: int

    @classmethod
    def of_run(cls, path: Path, id: int, visit: int | None, playing: EngineConfig) -> LevelStage:
        """Make the environment of a run and reset it to one of its levels.

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
            watched = config.watched(playing)
        except ValueError as error:
            raise UsageError(str(error)) from error
        game, level = build.find_game(config.minigame).of_level(level, config)
        env = build.make_upomdp(game.task(config, watched).make, 1, config.seed)
        if env.levels.dtype != level.dtype:
            dims = env.theta_dim, level["theta"].shape[1]
            raise CommandError(f"{path} has levels of {dims[1]} parameters, its environments now have {dims[0]}")
        _, info = env.reset_to_levels(level, None, visit)
        if info["replaced"][0]:
            raise CommandError(f"level {id} of {path} is no longer valid: its environments have changed")
        return cls(env, level, visit)

    @property
    def is_match(self) -> bool:
        """Whether the environment is a football match that a player of raw observations can play."""
        return hasattr(self.env, "matches") and self.env.config.representation == "raw"

    def describe(self) -> str:
        """Describe the level: its seed, its visit, and the parameters of θ."""
        values = self.env.describe(self.level["theta"])[0]
        spelled = ", ".join(
            f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in values.items()
        )
        return f"seed {int(self.level['seed'][0])}, visit {self.visit}: {spelled or 'no parameters'}"

    def play(self, steps: int, seed: int, idle: bool) -> PlayedTask:
        """Play the episode for at most this many steps, with random actions or, if `idle`, a constant one."""
        space, total, ended = self.env.single_action_space, 0.0, False
        space.seed(seed)
        same, frames = space.sample(), [self._frame()]
        while len(frames) <= steps and not ended:
            action = np.zeros_like(same) if idle else space.sample()
            _, reward, terminated, truncated, _ = self.env.advance(np.asarray(action)[None])
            total, ended = total + float(reward[0]), bool(terminated[0] or truncated[0])
            frames.append(self._frame())
        return PlayedTask(len(frames) - 1, total, ended, [frame for frame in frames if frame is not None])

    def _frame(self) -> np.ndarray | None:
        images = self.env.render() if self.env.render_mode == "rgb_array" else None
        return None if images is None else np.asarray(images[0], np.uint8)
