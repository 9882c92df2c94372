"""Names to objects: the only place that knows which minigame, method or program a word stands for.

Everything heavy is imported when it is asked for. Read next: `commands.train`.
"""

from __future__ import annotations

import ast
import itertools
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from regista.experiments.run import tasks
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.tasks import TaskScene
from ued.core.room import RoomError, check_environments, space_bytes
from ued.methods import METHODS

if TYPE_CHECKING:
    import torch

    from regista.envs.football.config import FootballConfig
    from regista.experiments.run.config import ProgramConfig, TrainConfig
    from regista.experiments.run.mixed import MixedProgram
    from regista.minigames.suites import Minigame
    from scenic_lite import Domain, Program

COMPILE_SECONDS = 20  # of all kernels, on a slow core
MANY = 1_024  # environments, above which one is made first, to see whether they fit
STATE_COPIES = 3  # of a match, while it is stepped
ENGINE_BYTES = 55_000_000  # of one engine of Google Research Football

TRAINING_SCENE = "training distribution"  # uniform θ of the training program: tested beside the test scenes


def find_minigame(name: str) -> Minigame:
    """Return the minigame of this name, or the test scene `<minigame>/<test>` as a game without tests of its own.

    The path of a .scenic program counts as one without tests, too. Raises `UsageError` for other names, and for a
    mixture, which is several minigames.
    """
    from regista.minigames.suites import NAMED, Minigame

    if len(parts_of(name)) > 1:
        raise UsageError(f"{name} is a mixture; here one of its minigames is wanted: {', '.join(parts_of(name))}")

    if name in NAMED:
        return NAMED[name]
    path = Path(name)
    if path.suffix == ".scenic":
        if not path.is_file():
            raise UsageError(f"there is no program {name}")
        return Minigame(path.stem, path, (), "a program of yours")
    if path.suffix == ".py" or ".py:" in name:
        raise UsageError(f"a task of yours is called file.py:name, got {name!r}")
    raise UsageError(
        f"unknown minigame {name!r}{nearest(name, NAMED, 3)}; regista list shows all, or give a .scenic file"
    )


def parts_of(name: str) -> list[str]:
    """Return the names of the minigames that a mixture is made of: `a+b`, or a name of its own; of others the name."""
    from regista.minigames.suites import MIXTURES

    return list(MIXTURES[name]) if name in MIXTURES else name.split("+")


def short_name(name: str) -> str:
    """Return what a minigame, or a mixture, is called in the names of folders and on pictures."""
    from regista.minigames.suites import MIXTURES

    if tasks.is_task(name):
        return tasks.short(name)
    return name if name in MIXTURES else "+".join(find_minigame(part).name for part in parts_of(name))


def canonical_name(name: str) -> str:
    """Return a minigame's name as a run keeps it: that of a program of one's own holds in every working directory."""
    from regista.minigames.suites import MIXTURES, NAMED

    if tasks.is_task(name):
        return tasks.canonical(name)
    if name in MIXTURES or name in NAMED:
        return name
    if len(parts_of(name)) > 1:
        return "+".join(map(canonical_name, parts_of(name)))
    return str(find_minigame(name).program.resolve())


def starting_point(preset: str, minigame: str) -> Any:
    """Return the settings of a preset for a minigame, whose agents move whom they move there, and are paid for that.

    The thesis pays for goals alone. Of a mixture, those of its first minigame; of a task of one's own, those of
    `TaskTrainConfig`.
    """
    from regista.experiments.run.config import presets, task_presets

    if tasks.is_task(minigame):
        return task_presets()[preset]
    config, game = presets()[preset], find_minigame(parts_of(minigame)[0])
    rewards = config.env.rewards if preset == "thesis" else game.rewards
    return replace(config, env=replace(config.env, control=game.control, rewards=rewards))


def all_starting_points(preset: str = "fast") -> list[Any]:
    """Return the settings of a preset for each minigame."""
    from regista.minigames.suites import NAMED

    return [starting_point(preset, name) for name in NAMED]


def settings_for(argv: Sequence[str]) -> Any:
    """Return the settings that a command line begins with, as its preset and its game or task have them."""
    from regista.experiments.run.config import TrainConfig

    return starting_point(preset_of(argv), _named(argv) or TrainConfig().minigame)


def _named(argv: Sequence[str]) -> str | None:
    """Return the game or the task that is typed, if there is one."""
    return next((word for word in argv if tasks.is_task(word) or _is_game(word)), None)


def preset_of(argv: Sequence[str]) -> str:
    """Return the preset that is typed, `fast` where none is."""
    from regista.experiments.run.config import presets

    pairs = [*itertools.pairwise(argv), *(word.partition("=")[::2] for word in argv)]
    typed = [value for flag, value in pairs if flag == "--preset" and value in presets()]
    return typed[-1] if typed else "fast"


def _is_game(word: str) -> bool:
    try:
        return not word.startswith("-") and bool([find_minigame(part) for part in parts_of(word)])
    except UsageError:
        return False


def other_settings(argv: Sequence[str]) -> dict[str, list[Any]]:
    """Return by case what a command line would begin with if something else were typed, for its help."""
    from regista.experiments.run.config import TrainConfig, presets, task_presets

    typed, game, usual = preset_of(argv), _named(argv), TrainConfig().minigame
    others = [name for name in presets() if name != typed]
    cases = {f"with --preset {name}": [starting_point(name, game or usual)] for name in others}
    if game is None:
        cases["for other games"] = all_starting_points(typed)
    if game is None or not tasks.is_task(game):
        cases["for tasks"] = [task_presets()[typed]]
    return cases


def find_method(name: str) -> str:
    """Return the name back if there is such a method. Raises `UsageError` otherwise."""
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}{nearest(name, METHODS)}; known are {', '.join(METHODS)}")
    return name


def load_scenes(config: TrainConfig, held_out: bool = False) -> dict[str, Any]:
    """Compile the programs of a run's minigame, by label: what is trained on, then what its students are tested on.

    `held_out`: its held-out scenes instead of its tests. Raises `UsageError` where it has none.

    The settings of `config.program` are the training program's; the test scenes stay as they are. A mixture is tested
    on all of its programs, and on their test scenes. Of a task of one's own the scenes are `TaskScene`.
    """
    if not is_football(config):
        if held_out:
            raise UsageError(f"{config.minigame} has no held-out scenes: a task of your own has tests alone")
        return dict(tasks.load_scenes(config.minigame, TRAINING_SCENE))
    games, dialect = [find_minigame(part) for part in parts_of(config.minigame)], config.env.dialect
    programs = [load_program(game.program, dialect, config.program) for game in games]
    tests = [{label: load_program(path, dialect) for label, path in tests_of(game, held_out)} for game in games]
    if len(games) == 1:
        return {TRAINING_SCENE: programs[0], **tests[0]}
    from regista.experiments.run.mixed import MixedProgram

    mixed = MixedProgram(tuple(game.name for game in games), tuple(programs))
    scenes: dict[str, Any] = {TRAINING_SCENE: mixed}
    for k, name in enumerate(mixed.names):
        scenes[name] = mixed.single_program(k, programs[k])
        scenes |= {f"{name}/{label}": mixed.single_program(k, program) for label, program in tests[k].items()}
    return scenes


def tests_of(game: Minigame, held_out: bool) -> tuple[tuple[str, Path], ...]:
    """Return the tests of a minigame, or its held-out scenes. Raises `UsageError` where it has none of these."""
    if held_out and not game.held_out:
        raise UsageError(f"{game.name} has no held-out scenes")
    return game.held_out if held_out else game.tests


def load_program(path: Path, dialect: int | None, settings: ProgramConfig | None = None) -> Program:
    """Compile a program of football, and print what looks like a slip in it. Raises `ScenicError` for a broken one."""
    from regista.envs.football.scenic.domain import FOOTBALL

    return _load(path, FOOTBALL, dialect, settings)


def load_any_program(path: Path, dialect: int | None, settings: ProgramConfig) -> tuple[Program, bool]:
    """Compile a program of football or of anything else; return whether it is football: it needs its library then."""
    from scenic_lite import ScenicError

    try:
        return _load(path, None, dialect, settings), False
    except ScenicError:
        return load_program(path, dialect, settings), True


def _load(path: Path, domain: Domain | None, dialect: int | None, settings: ProgramConfig | None) -> Program:
    from scenic_lite import load

    if settings is None:
        program = load(path, domain, dialect)
    else:
        program = load(path, domain, dialect, settings.scenario, read_params(settings.param), settings.model)
    for line in program.printed:
        print(f"{program.file} prints: {line}", file=sys.stderr)
    for warning in program.warnings:
        warn(f"warning: {warning}")
    return program


def read_params(texts: Sequence[str]) -> dict[str, object]:
    """Return global parameters from `name=value`: a number, True, False, None or a list of them; else a text."""
    params: dict[str, object] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise UsageError(f"--param takes name=value, got '{text}'")
        try:
            params[name] = ast.literal_eval(value)
        except (ValueError, SyntaxError):
            params[name] = value
    return params


def warn_of_play(program: Program) -> None:
    """Print what in a program of football would stop a match, or keeps all matches from being played."""
    from regista.envs.football.scenic.world import FOOTBALL_WORLD
    from scenic_lite import ScenicError
    from scenic_lite.dynamics.compiler.compile import compile_program

    try:
        lines: tuple[object, ...] = compile_program(program, FOOTBALL_WORLD).warnings
    except ScenicError as error:
        lines = (f"no match can be played: {error}",)
    for line in lines:
        warn(f"warning: {line}")


@cache
def warn(text: str) -> None:
    """Print a note on stderr, the first time that it comes up: a program is compiled for many purposes."""
    print(text, file=sys.stderr, flush=True)


@contextmanager
def telling_warnings() -> Iterator[None]:
    """Print warnings of the kind that users should act on as notes, each once, without the line of code they are of."""
    show = warnings.showwarning

    def tell(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if category is UserWarning:
            warn(f"warning: {message}")
        else:
            show(message, category, *place, **more)

    warnings.showwarning = tell
    try:
        yield
    finally:
        warnings.showwarning = show


def make_upomdp(program: Any, num_envs: int, config: FootballConfig | None, seed: int, threads: int) -> Any:
    """Make a program, a mixture or a scene of one's own into `num_envs` environments, with seeded streams.

    `config` and `threads`, which step them, are football's. Raises `UsageError` for programs that do not go together.
    """
    if isinstance(program, TaskScene):
        if num_envs > MANY:
            with room_for("environments"):
                check_environments(num_envs, _bytes_of_one(tasks.make_upomdp(program, 1, seed), seed))
        return tasks.make_upomdp(program, num_envs, seed)
    assert config is not None
    import numba

    from regista.envs.football.batch import step_batch
    from regista.kernels.jit import compiled

    if config.engine == "regista" and not compiled(step_batch):
        warn(f"compiling kernels (once, about {COMPILE_SECONDS} s)")
    settings: Any = numba.config
    numba.set_num_threads(min(threads, settings.NUMBA_NUM_THREADS))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        if num_envs > MANY:
            with room_for("environments"):
                check_environments(num_envs, _bytes_of_one(_environments(program, 1, config), seed))
        upomdp = _environments(program, num_envs, config)
    for warning in caught:
        warn(f"warning: {warning.message}")
    upomdp.reset(seed=seed)
    return upomdp


@contextmanager
def room_for(what: str) -> Iterator[None]:
    """Raise settings for which there is no memory as a `UsageError` that names their flags."""
    try:
        yield
    except RoomError as error:
        flags = " and ".join(f"--{name.replace('_', '-')}" for name in error.settings)
        raise UsageError(f"{flags}: too much for the {what}: {error}") from error


def _bytes_of_one(upomdp: Any, seed: int) -> int:
    """Return the bytes that one environment needs at least: its state and what is seen of it; closes it."""
    if getattr(getattr(upomdp, "config", None), "engine", None) == "grf":
        return ENGINE_BYTES
    upomdp.reset(seed=seed)
    held = upomdp.get_state().values() if upomdp.supports_state else ()
    upomdp.close()
    kept = sum(getattr(value, "nbytes", 0) for value in held)
    return STATE_COPIES * kept + 2 * space_bytes(upomdp.agent_observation_space) * upomdp.num_agents


def _environments(program: Program | MixedProgram, num_envs: int, config: FootballConfig) -> Any:
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.experiments.run.mixed import MixedProgram

    if not isinstance(program, MixedProgram):
        return FootballVectorEnv(program, num_envs, config=config)
    from ued.adapters.mixture import Mixture

    members = [FootballVectorEnv(member, num_envs, config=config) for member in program.programs]
    try:
        return Mixture(members, program.names, program.only)
    except ValueError as error:
        raise UsageError(f"these minigames are no mixture: {error}") from error


def make_method(config: TrainConfig, upomdp: Any) -> Any:
    """Make the method that trains on `upomdp`.

    Raises `UsageError` for an unknown one, and for an environment on which it cannot train.
    """
    import torch

    method, device = METHODS[find_method(config.method)], find_device(config.device)
    torch.set_num_threads(config.threads)
    try:
        with room_for("students"):
            made = method.load()(upomdp, config.ppo, getattr(config, method.group), config.seed, config.total_env_steps)
    except (ValueError, ImportError, NotImplementedError) as error:
        raise UsageError(f"{config.method} cannot train on {config.minigame}: {error}") from error
    if device.type != "cpu":
        os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # before its first use, for the same sums each time
        torch.use_deterministic_algorithms(True, warn_only=True)
    for learner in made.learners:
        learner.to(device)
    return made


def find_device(name: str) -> torch.device:
    """Return the device of this name; auto: a GPU if there is one. Raises `UsageError` for one that is not there."""
    import torch

    gpus = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if name == "cpu" or (name == "auto" and not gpus):
        return torch.device("cpu")
    device = torch.device("cuda" if name == "auto" else name)
    if (device.index or 0) >= gpus:
        seen = {0: "no GPU", 1: "one GPU, cuda:0"}.get(gpus, f"{gpus} GPUs")
        raise UsageError(f"there is no device {name}: torch sees {seen} here; --device cpu needs none")
    return device


def is_football(config: Any) -> bool:
    """Return whether the settings of a run are of football, not of a task of one's own."""
    from regista.experiments.run.config import FootballRunConfig

    return isinstance(config, FootballRunConfig)


def check_football(minigame: str) -> None:
    """Raise `UsageError` for a task of one's own, of which there are no demonstrations."""
    if tasks.is_task(minigame):
        raise UsageError(f"{minigame} is a task of your own: demonstrations are of football alone")


def make_painter(program: Any, upomdp: Any = None) -> Any:
    """Make what draws the levels of a program, a mixture or a scene of one's own; None where a task has no painter.

    `upomdp` are its environments: a task needs them, a program's lineup need not be made again.
    """
    if isinstance(program, TaskScene):
        return program.task.painter(upomdp) if program.task.painter else None
    from regista.envs.football.scenic.lineup import Lineup
    from regista.envs.football.view.render import FootballPainter
    from regista.experiments.run.mixed import MixedPainter, MixedProgram

    if isinstance(program, MixedProgram):
        painters = [FootballPainter(Lineup(member)) for member in program.programs]
        return MixedPainter(painters, [member.dim for member in program.programs])
    return FootballPainter(Lineup(program) if upomdp is None else upomdp.lineup)
