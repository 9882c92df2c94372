"""Names to objects: the only place that knows which minigame, method or program a word stands for.

Everything heavy is imported when it is asked for. Read next: `commands.train`.
"""

from __future__ import annotations

import ast
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.run.errors import UsageError, nearest
from ued.methods import METHODS

if TYPE_CHECKING:
    from envs.football.config import FootballConfig
    from envs.football.scenic.lineup import Lineup
    from envs.football.vector_env import FootballVectorEnv
    from envs.football.view.render import FootballPainter
    from experiments.run.config import ProgramConfig, TrainConfig
    from minigames.suites import Minigame
    from scenic_lite import Domain, Program

COMPILE_SECONDS = 20  # of all kernels, on a slow core

TRAINING_SCENE = "training distribution"  # uniform θ of the training program: tested beside the test scenes


def find_minigame(name: str) -> Minigame:
    """Return the minigame of this name, or the test scene `<minigame>/<test>` as a game without tests of its own.

    The path of a .scenic program counts as one without tests, too. Raises `UsageError` for other names.
    """
    from minigames.suites import NAMED, Minigame

    if name in NAMED:
        return NAMED[name]
    path = Path(name)
    if path.suffix == ".scenic":
        if not path.is_file():
            raise UsageError(f"there is no program {name}")
        return Minigame(path.stem, path, (), "a program of yours")
    raise UsageError(
        f"unknown minigame {name!r}{nearest(name, NAMED, 3)}; regista list shows all, or give a .scenic file"
    )


def canonical_name(name: str) -> str:
    """Return a minigame's name as a run keeps it: that of a program of one's own holds in every working directory."""
    from minigames.suites import NAMED

    program = find_minigame(name).program
    return name if name in NAMED else str(program.resolve())


def starting_point(preset: str, minigame: str) -> TrainConfig:
    """Return the settings of a preset for a minigame, whose agents move whom they move there, and are paid for that."""
    from experiments.run.config import presets

    config, game = presets()[preset], find_minigame(minigame)
    return replace(config, env=replace(config.env, control=game.control, rewards=game.rewards))


def find_method(name: str) -> str:
    """Return the name back if there is such a method. Raises `UsageError` otherwise."""
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}{nearest(name, METHODS)}; known are {', '.join(METHODS)}")
    return name


def load_scenes(config: TrainConfig) -> dict[str, Program]:
    """Compile the programs of a run's minigame, by label: what is trained on, then what its students are tested on.

    The settings of `config.program` are the training program's; the test scenes stay as they are.
    """
    game, dialect = find_minigame(config.minigame), config.env.dialect
    tests = {label: load_program(path, dialect) for label, path in game.tests}
    return {TRAINING_SCENE: load_program(game.program, dialect, config.program), **tests}


def load_program(path: Path, dialect: int | None, settings: ProgramConfig | None = None) -> Program:
    """Compile a program of football, and print what looks like a slip in it. Raises `ScenicError` for a broken one."""
    from envs.football.scenic.domain import FOOTBALL

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
    from envs.football.scenic.world import FOOTBALL_WORLD
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


def make_upomdp(program: Program, num_envs: int, config: FootballConfig, seed: int, threads: int) -> FootballVectorEnv:
    """Make a program into `num_envs` environments, with seeded streams, stepped by `threads` threads."""
    import numba

    from envs.football.batch import step_batch
    from envs.football.vector_env import FootballVectorEnv
    from scenic_lite.kernels.jit import compiled

    if config.engine == "regista" and not compiled(step_batch):
        warn(f"compiling kernels (once, about {COMPILE_SECONDS} s)")
    settings: Any = numba.config
    numba.set_num_threads(min(threads, settings.NUMBA_NUM_THREADS))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        upomdp = FootballVectorEnv(program, num_envs, config=config)
    for warning in caught:
        warn(f"warning: {warning.message}")
    upomdp.reset(seed=seed)
    return upomdp


def make_method(config: TrainConfig, upomdp: Any) -> Any:
    """Make the method that trains on `upomdp`.

    Raises `UsageError` for an unknown one, and for an environment on which it cannot train.
    """
    import torch

    method = METHODS[find_method(config.method)]
    torch.set_num_threads(config.threads)
    try:
        return method.load()(upomdp, config.ppo, getattr(config, method.group), config.seed)
    except (ValueError, ImportError, NotImplementedError) as error:
        raise UsageError(f"{config.method} cannot train on {config.minigame}: {error}") from error


def make_painter(program: Program, lineup: Lineup | None = None) -> FootballPainter:
    """Make what draws the levels of a program; `lineup` is that of its environment, if there is one."""
    from envs.football.scenic.lineup import Lineup
    from envs.football.view.render import FootballPainter

    return FootballPainter(lineup or Lineup(program))
