"""`regista play`: play a match, an episode of a task, a level of a run, or a record; write a video or a record of it.

    regista play 3v2FourBehaviors --video match.gif
    regista play mine.scenic --player random --record match.npz
    regista play 1v1Free --engine grf                              # the same match in Google Research Football
    regista play maze --scene Labyrinth --player runs/accel --video maze.gif      # the student of a run
    regista play --level runs/paired --id 1234                     # the level with this id in the run's levels.csv
    regista play --replay match.npz --video match.gif              # a recorded match, replayed exactly

Read next: `regista.envs.football.replay`, what a record is; `regista.envs.football.view.bot`, the default player.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import EngineConfig, ProgramConfig
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.games import single_game
from regista.experiments.run.programs import load_program
from regista.experiments.run.table import cannot_write
from regista.experiments.run.tasks import PythonTask
from ued.config import LARGEST_SEED, Checked, setting
from ued.core.files import write_whole
from ued.core.task import TRAINING_SCENE

if TYPE_CHECKING:
    from regista.envs.football.replay import Record
    from regista.experiments.run.level_stage import LevelStage

DESCRIPTION = (
    "Play one match of a program, an episode of a task, a level of a run, or a recorded match, and write a video or a "
    "record of it."
)
PLAYERS = ("bot", "random", "idle")  # of football
WITH_REPLAY = {"replay", "match", "video", "speed"}


@dataclass(frozen=True)
class PlayConfig(Checked):
    """Arguments of `regista play`."""

    program: str = positional("minigame, path of a .scenic program, or task", default="")
    player: str = setting(
        "bot", "policy of the agents: bot (tasks: random), random, idle; of a task also a baseline or a run folder"
    )
    scene: str = setting(TRAINING_SCENE, "with a task: the test whose level is played")
    control: str = setting("active", "left players of agents: active, closest1 to closest3, all, a number, ...")
    steps: int = setting(600, "maximum number of steps of 0.1 s; the match may end earlier", ">=1", most=1_000_000)
    seed: int = setting(
        0, "seed of the level and the match; with --level, only of a random player", ">=0", most=LARGEST_SEED
    )
    level: Path | None = setting(None, "instead of a program: play a level of this run folder")
    id: int | None = setting(None, "id of that level: column id of the table of levels", least=0, most=LARGEST_SEED)
    visit: int | None = setting(
        None,
        "visit of the level whose random numbers are replayed: column visit (default: the first)",
        least=0,
        most=LARGEST_SEED,
    )
    video: Path | None = setting(None, "write a video: .gif, .webp, or .mp4 with imageio-ffmpeg")
    speed: float = setting(1.0, "playback speed of the video; 1: real time", ">0", most=1_000)
    record: Path | None = setting(None, "write a record (.npz) for --replay")
    replay: Path | None = setting(None, "replay this record and check that it gives the recorded result")
    match: int = setting(0, "with --replay: index of the match in the record", ">=0", most=10**9)
    reading: ProgramConfig = group(ProgramConfig, "the program")
    playing: EngineConfig = group(EngineConfig, "engine")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    typed = arguments.typed_settings(PlayConfig(), argv, "play", DESCRIPTION)
    config = arguments.replace_paths(PlayConfig(), typed)
    if not config.program and config.level is None and config.replay is None:
        raise UsageError(
            "play needs a program: a minigame's name, the path of a .scenic file or a task; or --level RUN --id N, or "
            "--replay RECORD"
        )
    if config.replay is not None:
        if typed.keys() - WITH_REPLAY:
            raise UsageError("--replay repeats a recorded match: it takes --match, --video and --speed alone")
        return _replay(config)
    if "match" in typed:
        raise UsageError("--match needs --replay RECORD")
    if config.visit is not None and config.level is None:
        raise UsageError("--visit needs --level RUN --id N")
    if (config.id is None) != (config.level is None) or (config.program and config.level):
        raise UsageError("to play a level of a run, give --level RUN --id N, without a program")
    check_film_of(config.video)
    if config.record and config.record.suffix != ".npz":
        raise UsageError(f"{config.record}: the name of a record must end in .npz")
    if config.program and not isinstance(build.find_game(config.program), PythonTask):
        if "scene" in typed:
            raise UsageError(f"--scene needs a Python task; give a test scene of a minigame as {config.program}/TEST")
        _check_player(config)
        return play_match(config, _match_of_program(config))
    stage = _stage(config)
    print(stage.describe())
    if not stage.is_match:
        return _play_task(config, stage)
    _check_player(config)
    return play_match(config, stage.env)


def _stage(config: PlayConfig) -> LevelStage:
    """Return the environment of a level of a run, or of a task."""
    from regista.experiments.run.level_stage import LevelStage

    usual = PlayConfig()
    if (config.control, config.reading) != (usual.control, usual.reading):
        raise UsageError("tasks and levels of runs have their own settings: omit --control and those of programs")
    if config.level is None:
        if config.playing != usual.playing:
            raise UsageError("--engine applies to football; a task brings its own environments")
        return LevelStage.of_task(build.find_game(config.program), config.scene, config.seed)
    assert config.id is not None
    if config.scene != usual.scene:
        raise UsageError("--scene and --level exclude each other: --level RUN --id N selects the level")
    return LevelStage.of_run(config.level, config.id, config.visit, config.playing)


def _check_player(config: PlayConfig) -> None:
    """Raise `UsageError` unless the player can play football."""
    if config.player not in PLAYERS:
        raise UsageError(f"--player of a football match is {', '.join(PLAYERS)}, not {config.player!r}")


def _match_of_program(config: PlayConfig) -> Any:
    """Return a match of the program, on a random level."""
    from regista.envs.football.config import FootballConfig

    program = load_program(single_game(config.program).minigame.program, None, config.reading)
    try:
        settings = config.playing.instead_of(FootballConfig(representation="raw", control=config.control))
    except ValueError as error:
        raise UsageError(str(error)) from error
    return build.make_matches(program, 1, settings, config.seed)


def _replay(config: PlayConfig) -> int:
    """Replay a recorded match, and write a video with `--video`."""
    from regista.envs.football.replay import RecordError, load_record, replay

    assert config.replay is not None
    check_film_of(config.video)
    try:
        record = load_record(config.replay)
        if config.match >= len(record.last):
            raise UsageError(f"--match must be below {len(record.last)}, the matches of {config.replay}")
        moments = [matches[config.match] for matches in replay(record, endings=True)]
    except RecordError as error:
        raise CommandError(str(error)) from error
    if record.lengths is not None:
        moments = moments[: record.lengths[config.match] + 1]
    left, right = moments[-1]["score"]
    matches = f", match {config.match} of {len(record.last)}" if len(record.last) > 1 else ""
    print(f"{len(moments) - 1} steps replayed exactly as recorded{matches}; final score {left} : {right}")
    if config.video:
        film(config.video, moments, config.speed)
    return 0


def play_match(config: PlayConfig, env: Any) -> int:
    """Play a match from its start; print the result, and write the requested video and record."""
    from regista.envs.football.gym_env import ENDINGS
    from regista.envs.football.replay import Recorder

    recorder, choose = Recorder(env), _player(config)
    observations, ended = env.observe(), 0
    moments = [env.matches[0]]
    while len(moments) <= config.steps and not ended:
        observations, rewards, _, _, info = recorder.advance(np.array([choose(observations)]))
        ended = int(info["ended"][0])
        moments.append(env.matches[0])
    left, right = moments[-1]["score"]
    end = f", then {ENDINGS[ended]}{f' ({rewards[0]:+g})' if rewards[0] else ''}" if ended else ""
    print(f"{len(moments) - 1} steps, {left} : {right}{end}")
    if config.record:
        _save(recorder.record(), config.record)
    if config.video:
        film(config.video, moments, config.speed)
    return 0


def _play_task(config: PlayConfig, stage: LevelStage) -> int:
    """Play an episode of a Python task; write its rendered frames as a video."""
    from regista.experiments.run.players import task_player

    if config.record:
        raise UsageError("--record supports football matches only; use --video for other environments")
    if config.video and stage.env.render_mode != "rgb_array":
        raise UsageError("--video requires environments with render_mode='rgb_array'")
    player = task_player(config.player, stage, config.seed)
    played = stage.play(config.steps, player.choose)
    print(f"{played.steps} steps by {player.name}, return {played.total:g}{', ended' * played.ended}")
    if config.video:
        from regista.envs.football.view.picture import write_video

        write_video(config.video, played.frames, config.speed)
    return 0


def _save(record: Record, path: Path) -> None:
    """Write a record atomically."""
    from regista.envs.football.replay import save_record

    content = io.BytesIO()
    save_record(record, content)
    try:
        write_whole(path, content.getbuffer())
    except OSError as error:
        raise cannot_write(path, error) from error


def check_film_of(path: Path | None) -> None:
    """Raise `UsageError` if a video cannot be written to this path."""
    if path is None:
        return
    from regista.envs.football.view.picture import check_film

    try:
        check_film(path)
    except (ValueError, ImportError) as error:
        raise UsageError(str(error)) from error


def film(path: Path, moments: Sequence[Any], speed: float) -> None:
    """Draw moments of a match and write them as a video; call `check_film_of` first."""
    from regista.envs.football.view.picture import draw_match, write_video

    write_video(path, (draw_match(moment) for moment in moments), speed)


def _player(config: PlayConfig) -> Callable[[Any], Any]:
    """Return the policy of the agents: it gives actions `[A]`, or one number for a single agent."""
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
