"""`regista play`: play a match, an episode of a task, a level of a run, or a record; write a video or a record of it.

    regista play --player shipped:maze --video maze.gif            # a policy that is installed with Regista
    regista play --player runs/paired --video policy.mp4           # the student of a run, in the run's own game
    regista play 1v1Free --scene hard --player runs/paired --episodes 5 --video hard.gif
    regista play maze --scene Labyrinth --player runs/accel --video maze.gif
    regista play 3v2FourBehaviors --video match.gif                # the rule-based player
    regista play mine.scenic --player random --record match.npz
    regista play 1v1Free --engine grf                              # the same match in Google Research Football
    regista play --level runs/paired --id 1234                     # the level with this id in the run's levels.csv
    regista play --replay match.npz --video match.gif              # a recorded match, replayed exactly

Read next: `run.players`, the players; `run.level_stage`, levels; `regista.envs.football.replay`, the records.
"""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import EngineConfig, ProgramConfig
from regista.experiments.run.errors import CommandError, UsageError, nearest
from regista.experiments.run.games import single_game
from regista.experiments.run.players import SCRIPTED, Actor, MatchStudent, scripted_player, task_player
from regista.experiments.run.programs import load_program
from regista.experiments.run.progress import counted
from regista.experiments.run.rendering import fitted
from regista.experiments.run.shipped import is_name as is_shipped
from regista.experiments.run.shipped import located
from regista.experiments.run.table import cannot_write
from regista.experiments.run.tasks import PythonTask
from ued.config import LARGEST_SEED, Checked, setting
from ued.core.files import write_whole
from ued.core.task import TRAINING_SCENE

if TYPE_CHECKING:
    from regista.envs.football.replay import Record
    from regista.experiments.run.level_stage import LevelStage
    from regista.minigames.suites import Minigame

DESCRIPTION = (
    "Play matches of a program, episodes of a task, a level of a run, or a recorded match, and write a video or a "
    "record of it. --player RUN shows a trained student, --player shipped:NAME one that is installed with Regista."
)
WITH_REPLAY = {"replay", "match", "video", "speed"}


@dataclass(frozen=True)
class PlayConfig(Checked):
    """Arguments of `regista play`."""

    program: str = positional(
        "minigame, path of a .scenic program, or task (default: that of --player RUN)", default=""
    )
    player: str = setting(
        "bot",
        "policy of the agents: a run folder, a shipped policy such as shipped:maze, bot (tasks: random), random, idle; "
        "for tasks also a baseline",
    )
    greedy: bool = setting(False, "the student of a run takes its most likely actions")
    scene: str = setting(TRAINING_SCENE, "test scene to play")
    episodes: int = setting(
        1, "number of episodes, with consecutive seeds from --seed; a video shows all", ">=1", most=10_000
    )
    control: str = setting(
        "active",
        "left players of agents: active, closest1 to closest3, all, a number, ...; a run has its own",
    )
    steps: int = setting(600, "maximum number of steps of an episode (0.1 s each in football)", ">=1", most=1_000_000)
    seed: int = setting(
        0, "seed of the level and the episode; with --level, only of the actions", ">=0", most=LARGEST_SEED
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
    if config.replay is not None:
        if typed.keys() - WITH_REPLAY:
            raise UsageError("--replay repeats a recorded match: it supports only --match, --video and --speed")
        return _replay(config)
    if not config.program and config.level is None:
        config = replace(config, program=_game_of_player(config.player))
    if config.program:
        _check_program(config.program)
    _check(config, typed)
    if config.program and not isinstance(build.find_game(config.program), PythonTask):
        return _play_program(config, "control" in typed)
    return _play_stage(config)


def _game_of_player(player: str) -> str:
    """Return the game of a player's run. Raises `UsageError` if the player is neither a run nor a shipped policy."""
    if player in SCRIPTED or not located(player).is_dir():
        missing = "" if player in SCRIPTED else f"there is no folder {player}; "
        raise UsageError(
            f"{missing}play needs a program: a minigame's name, the path of a .scenic file or a task; or --player RUN, "
            "such as shipped:maze, --level RUN --id N, --replay RECORD"
        )
    from regista.experiments.run.folder import RunFolder

    return str(RunFolder.open(located(player)).config.minigame)


def _check_program(name: str) -> None:
    """Raise `UsageError` unless a name is that of a game or program; for a run, the message suggests --player."""
    meant = f"{name} is a run, not a game; add --player: regista play --player {name}"
    if is_shipped(name):  # `shipped:NAME` looks like a task, module:name
        raise UsageError(meant)
    try:
        build.find_game(name)
    except UsageError as error:
        raise UsageError(meant) if (Path(name) / "config.json").exists() else error from None


def _check(config: PlayConfig, typed: dict[str, Any]) -> None:
    """Raise `UsageError` for settings that exclude each other, and for files that cannot be written."""
    if "match" in typed:
        raise UsageError("--match needs --replay RECORD")
    if config.visit is not None and config.level is None:
        raise UsageError("--visit needs --level RUN --id N")
    if (config.id is None) != (config.level is None) or (config.program and config.level):
        raise UsageError("to play a level of a run, give --level RUN --id N, without a program")
    check_film_of(config.video)
    if config.record and config.record.suffix != ".npz":
        raise UsageError(f"{config.record}: the name of a record must end in .npz")
    if config.record and config.episodes > 1:
        raise UsageError("--record writes one match: omit --episodes, and select the match by --seed")
    if config.seed + config.episodes - 1 > LARGEST_SEED:
        raise UsageError(f"--seed {config.seed} --episodes {config.episodes} needs seeds above {LARGEST_SEED}")


def _play_program(config: PlayConfig, controlled: bool) -> int:
    """Play matches of a program on random levels; `controlled`: --control is given."""
    student = None if config.player in SCRIPTED else MatchStudent.open(config.player)
    if student and controlled:
        raise UsageError("--control and --player RUN exclude each other: a student keeps the control of its training")
    env = build.make_matches(_program(config, student), 1, _match_settings(config, student), config.seed)
    actor = student.actor(env, config.greedy) if student else scripted_player(config.player)
    return play_matches(config, env, actor, lambda episode: env.reset(seed=config.seed + episode))


def _program(config: PlayConfig, student: MatchStudent | None) -> Any:
    """Return the compiled program: that of the game or of one of its test scenes.

    A run's own program is read with its training settings, unless others are given.
    """
    game = single_game(config.program)
    path, reading = _scene(game.minigame, config.scene), config.reading
    dialect = student.run.config.env.dialect if student else None
    own = student is not None and student.run.config.minigame == game.name and path == game.minigame.program
    if student and own and reading == PlayConfig().reading:
        reading = student.run.config.program
    return load_program(path, dialect, reading)


def _scene(minigame: Minigame, name: str) -> Path:
    """Return the program of a test scene, by its label or the last part of its name."""
    from regista.minigames.suites import slug

    if name == TRAINING_SCENE:
        return minigame.program
    tests = (*minigame.tests, *minigame.held_out)
    for label, path in tests:
        if name in (label, slug(label)):
            return path
    labels = [label for label, _ in tests]
    known = f"it has {', '.join(labels)}" if labels else "it has none"
    raise UsageError(f"{minigame.name} has no test {name!r}{nearest(name, labels)}; {known}")


def _match_settings(config: PlayConfig, student: MatchStudent | None) -> Any:
    """Return the settings of matches: the student's training settings, or raw observations for a scripted player."""
    from regista.envs.football.config import FootballConfig

    try:
        if student:
            return student.settings(config.playing)
        return config.playing.instead_of(FootballConfig(representation="raw", control=config.control))
    except ValueError as error:
        raise UsageError(str(error)) from error


def _play_stage(config: PlayConfig) -> int:
    """Play a level of a run, or a task."""
    student = None
    if config.level is not None and _is_football(config.level):
        student = None if config.player in SCRIPTED else MatchStudent.open(config.player)
    stage = _stage(config, student)
    if isinstance(stage.game, PythonTask):
        return _play_task(config, stage)
    print(stage.describe())
    actor = student.actor(stage.env, config.greedy) if student else scripted_player(config.player)

    def again(episode: int) -> None:
        stage.env.reset_to_levels(stage.level, None, stage.visit + episode)

    return play_matches(config, stage.env, actor, again)


def _is_football(path: Path) -> bool:
    """Return whether a run is on football; this includes Python tasks whose environments are matches."""
    from regista.experiments.run.folder import RunFolder

    return RunFolder.open(path).config.engine is not None


def _stage(config: PlayConfig, student: MatchStudent | None) -> LevelStage:
    """Return the environment of a level of a run, or of a task."""
    from regista.experiments.run.level_stage import LevelStage

    usual = PlayConfig()
    if (config.control, config.reading) != (usual.control, usual.reading):
        raise UsageError("tasks and levels of runs have their own settings: omit --control and those of programs")
    if config.level is None:
        if config.playing != usual.playing:
            raise UsageError("--engine applies to football; a task has its own environments")
        return LevelStage.of_task(build.find_game(config.program), config.scene, config.seed)
    assert config.id is not None
    if config.scene != usual.scene:
        raise UsageError("--scene and --level exclude each other: --level RUN --id N selects the level")
    env = _match_settings(config, student) if student else None
    return LevelStage.of_run(config.level, config.id, config.visit, config.playing, env)


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
    print(f"{counted(len(moments) - 1, 'step')} replayed exactly as recorded{matches}; final score {left} : {right}")
    if config.video:
        film(config.video, moments, config.speed)
    return 0


@dataclass
class Tally:
    """Returns and successes of the episodes played so far."""

    returns: list[float] = field(default_factory=list)
    successes: int = 0

    def add(self, total: float, success: bool) -> None:
        """Count an episode."""
        self.returns.append(total)
        self.successes += success

    def tell(self) -> None:
        """Print the mean return and the success rate of several episodes."""
        count = len(self.returns)
        if count > 1:
            print(f"{count} episodes: mean return {np.mean(self.returns):.3g}, success {self.successes} of {count}")


def play_matches(config: PlayConfig, env: Any, actor: Actor, again: Callable[[int], Any]) -> int:
    """Play the matches, the first from its current state; print results, and write the requested video and record.

    `again(episode)` resets the match for the episodes 1, 2, ...
    """
    tally = Tally()

    def moments() -> Iterator[Any]:
        for episode in range(config.episodes):
            if episode:
                again(episode)
            yield from _play_match(config, env, actor, episode, tally)

    if config.video:
        film(config.video, moments(), config.speed)
    else:
        deque(moments(), maxlen=0)
    tally.tell()
    return 0


def _play_match(config: PlayConfig, env: Any, actor: Actor, episode: int, tally: Tally) -> Iterator[Any]:
    """Play a match from its start and yield its moments; print the result, and write the record."""
    from regista.envs.football.gym_env import ENDINGS
    from regista.envs.football.replay import Recorder
    from ued.core.upomdp import successes

    recorder, observations, choose = Recorder(env), env.observe(), actor.choose(config.seed + episode)
    ended, steps, total, rewards, info = 0, 0, 0.0, np.zeros(1), {}
    moment = env.matches[0]
    yield moment
    while steps < config.steps and not ended:
        observations, rewards, _, _, info = recorder.advance(choose(observations))
        ended, steps, total = int(info["ended"][0]), steps + 1, total + float(rewards[0])
        moment = env.matches[0]
        yield moment
    tally.add(total, bool(ended and successes(info, np.array([0]), np.array([total]))[0]))
    left, right = moment["score"]
    end = f", then {ENDINGS[ended]}{f' ({rewards[0]:+g})' if rewards[0] else ''}" if ended else ""
    print(f"{counted(steps, 'step')}{'' if actor.name in SCRIPTED else f' by {actor.name}'}, {left} : {right}{end}")
    if config.record:
        _save(recorder.record(), config.record)


def _play_task(config: PlayConfig, stage: LevelStage) -> int:
    """Play episodes of a Python task; write its rendered frames as a video."""
    if config.record:
        raise UsageError("--record supports football matches only; use --video for other environments")
    if config.video and not stage.is_visible:
        raise UsageError(
            f"--video requires environments made with render_mode='rgb_array', those of {stage.game.short} have "
            f'{stage.env.render_mode!r}: write gymnasium.make(..., render_mode="rgb_array") in the task'
        )
    player, tally = task_player(config.player, stage, config.greedy), Tally()
    frames = _task_frames(config, stage, player, tally)
    if config.video:
        from regista.envs.football.view.picture import FRAMES_PER_SECOND, write_video

        write_video(config.video, frames, config.speed * stage.frames_per_second / FRAMES_PER_SECOND)
    else:
        deque(frames, maxlen=0)
    tally.tell()
    return 0


def _task_frames(config: PlayConfig, stage: LevelStage, player: Actor, tally: Tally) -> Iterator[np.ndarray]:
    """Play the episodes of a task, print their results, and yield their frames, all of one size."""
    first: np.ndarray | None = None
    for episode in range(config.episodes):
        if episode and config.level is None:
            stage = stage.on_next_level(config.seed + episode, episode)
        elif episode:
            stage = stage.on_next_visit()
        print(stage.describe())
        choose = player.choose(config.seed + episode)
        played = stage.play(config.steps, choose, film=config.video is not None)
        tally.add(played.total, played.success)
        end = f", ended {'with' if played.success else 'without'} success" if played.ended else ""
        print(f"{counted(played.steps, 'step')} by {player.name}, return {played.total:g}{end}")
        for frame in played.frames:
            first = frame if first is None else first
            yield fitted(frame, first)


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


def film(path: Path, moments: Iterable[Any], speed: float) -> None:
    """Write the moments of a match as a video; call `check_film_of` first."""
    from regista.envs.football.view.picture import draw_match, write_video

    write_video(path, (draw_match(moment) for moment in moments), speed)
