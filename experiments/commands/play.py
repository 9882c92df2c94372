"""`regista play`: play one match of a program, and keep it as a film or as a record that can be replayed.

    regista play 3v2FourBehaviors --video match.gif
    regista play mine.scenic --player random --record match.npz
    regista play 1v1Free --engine grf                              # the same match in Google Research Football

Read next: `commands.replay`; `regista.envs.football.view.bot`, who plays unless told otherwise.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import EngineConfig, ProgramConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.table import cannot_write
from ued.config import LARGEST_SEED, Checked, setting
from ued.files import write_whole

if TYPE_CHECKING:
    from regista.envs.football.replay import Record

DESCRIPTION = "Play one match of a program, and write a film or a record of it."


@dataclass(frozen=True)
class PlayConfig(Checked):
    """What is typed after `regista play`."""

    program: str = positional("a minigame's name, or the path of a .scenic program", default="")
    player: Literal["bot", "random", "idle"] = setting("bot", "who moves the agents' players")
    control: str = setting("active", "left players that agents move: active, closest1 to closest3, all, a number, ...")
    steps: int = setting(600, "tenths of a second at most; the match may end sooner", ">=1", most=1_000_000)
    seed: int = setting(0, "seed of the level and of chance", ">=0", most=LARGEST_SEED)
    video: Path | None = setting(None, "write a film: .gif, .webp, or .mp4 with imageio-ffmpeg")
    speed: float = setting(1.0, "of the film, times life", ">0", most=1_000)
    record: Path | None = setting(None, "write a record, .npz, for regista replay")
    reading: ProgramConfig = group(ProgramConfig, "the program")
    playing: EngineConfig = group(EngineConfig, "engine")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(PlayConfig(), argv, "play", DESCRIPTION)
    if not config.program:
        raise UsageError("play needs a program: a minigame's name or the path of a .scenic file")
    check_film_of(config.video)
    if config.record and config.record.suffix != ".npz":
        raise UsageError(f"{config.record}: a record ends in .npz")
    from regista.envs.football.config import FootballConfig
    from regista.envs.football.gym_env import ENDINGS
    from regista.envs.football.replay import Recorder, after_step

    program = build.load_program(build.find_minigame(config.program).program, None, config.reading)
    try:
        settings = config.playing.instead_of(FootballConfig(representation="raw", control=config.control))
    except ValueError as error:
        raise UsageError(str(error)) from error
    env = build.make_upomdp(program, 1, settings, config.seed, 1)
    env.keep_endings()
    recorder, choose = Recorder(env), _player(config)
    observations, ended = env.observe(), 0
    moments = [env.matches[0]]
    while len(moments) <= config.steps and not ended:
        observations, rewards, _, _, info = recorder.step(np.array([choose(observations)]))
        ended = int(info["ended"][0])
        moments.append(after_step(env, info["ended"] > 0)[0])
    left, right = moments[-1]["score"]
    end = f", then {ENDINGS[ended]}{f' ({rewards[0]:+g})' if rewards[0] else ''}" if ended else ""
    print(f"{len(moments) - 1} steps, {left} : {right}{end}")
    if config.record:
        _keep(recorder.record(), config.record)
    if config.video:
        film(config.video, moments, config.speed)
    return 0


def _keep(record: Record, path: Path) -> None:
    """Write a record, whole or not at all."""
    from regista.envs.football.replay import save_record

    content = io.BytesIO()
    save_record(record, content)
    try:
        write_whole(path, content.getbuffer())
    except OSError as error:
        raise cannot_write(path, error) from error


def check_film_of(path: Path | None) -> None:
    """Raise `UsageError` if a film is wanted that cannot be written."""
    if path is None:
        return
    from regista.envs.football.view.picture import check_film

    try:
        check_film(path)
    except (ValueError, ImportError) as error:
        raise UsageError(str(error)) from error


def film(path: Path, moments: Sequence[Any], speed: float) -> None:
    """Draw moments of a match and write them as a film; `check_film_of` has passed."""
    from regista.envs.football.view.picture import draw_match, write_video

    write_video(path, (draw_match(moment) for moment in moments), speed)


def _player(config: PlayConfig) -> Callable[[Any], Any]:
    """Return what chooses the actions of the agents: `[A]`, or one number if there is one agent."""
    from regista.envs.football.observation.raw import row
    from regista.envs.football.view.bot import act

    rng = np.random.default_rng(config.seed)

    def move(observation: dict[str, np.ndarray]) -> int:
        if config.player == "bot":
            return act(row(observation, 0))
        return int(rng.integers(19)) if config.player == "random" else 0

    def choose(observations: Any) -> Any:
        return (
            [move(observation) for observation in observations]
            if isinstance(observations, tuple)
            else move(observations)
        )

    return choose
