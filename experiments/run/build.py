"""Names to objects: the only place that knows which minigame, method or program a word stands for.

Everything heavy is imported when it is asked for. Read next: `commands.train`.
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.run.errors import UsageError, nearest
from ued.methods import METHODS

if TYPE_CHECKING:
    from envs.football.config import FootballConfig
    from envs.football.vector_env import FootballVectorEnv
    from envs.football.view.render import FootballPainter
    from experiments.run.config import TrainConfig
    from minigames.suites import Minigame
    from scenic_lite import Program

COMPILE_SECONDS = 20  # of all kernels, on a slow core

TRAINING_SCENE = "training distribution"  # uniform θ of the training program: tested beside the test scenes


def find_minigame(name: str) -> Minigame:
    """Give the minigame of this name; the path of a .scenic program counts as one without tests.

    Raises `UsageError` for a name that is neither.
    """
    from minigames.suites import MINIGAMES, Minigame

    if name in MINIGAMES:
        return MINIGAMES[name]
    path = Path(name)
    if path.suffix == ".scenic":
        if not path.is_file():
            raise UsageError(f"there is no program {name}")
        return Minigame(path.stem, path, (), "a program of yours")
    raise UsageError(
        f"unknown minigame {name!r}{nearest(name, MINIGAMES)}; known are {', '.join(MINIGAMES)}, or give a .scenic file"
    )


def settled_name(name: str) -> str:
    """Give a minigame's name as a run keeps it: that of a program of one's own holds in every working directory."""
    from minigames.suites import MINIGAMES

    program = find_minigame(name).program
    return name if name in MINIGAMES else str(program.resolve())


def find_method(name: str) -> str:
    """Give the name back if there is such a method. Raises `UsageError` otherwise."""
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}{nearest(name, METHODS)}; known are {', '.join(METHODS)}")
    return name


def test_scenes(game: Minigame) -> dict[str, Path]:
    """Give the programs on which students of a minigame are tested, by label."""
    return {TRAINING_SCENE: game.program, **dict(game.tests)}


def load_program(path: Path, dialect: int | None) -> Program:
    """Compile a program of football, and print what looks like a slip in it. Raises `ScenicError` for a broken one."""
    from envs.football.scenic.domain import FOOTBALL
    from scenic_lite import load

    program = load(path, FOOTBALL, dialect)
    for warning in program.warnings:
        warn(f"warning: {warning}")
    return program


def load_any_program(path: Path, dialect: int | None) -> tuple[Program, bool]:
    """Compile a program of football or of anything else, and say whether it is football: it needs its library then."""
    from scenic_lite import ScenicError, load

    try:
        program = load(path, None, dialect)
    except ScenicError:
        return load_program(path, dialect), True
    for warning in program.warnings:
        warn(f"warning: {warning}")
    return program, False


def warn_of_play(program: Program) -> None:
    """Print what in a program of football would stop a match, or keeps all matches from being played."""
    from envs.football.scenic.world import FOOTBALL_WORLD
    from scenic_lite import ScenicError
    from scenic_lite.dynamics.compiler.compile import compile_program

    try:
        found = compile_program(program, FOOTBALL_WORLD).warnings
    except ScenicError as error:
        found = (f"no match can be played: {error}",)
    for each in found:
        warn(f"warning: {each}")


@cache
def warn(text: str) -> None:
    """Print a warning on stderr, the first time that it comes up: a program is compiled for many purposes."""
    print(text, file=sys.stderr, flush=True)


def make_upomdp(program: Path, num_envs: int, config: FootballConfig, seed: int, threads: int) -> FootballVectorEnv:
    """Compile a program into `num_envs` environments, with seeded streams, stepped by `threads` threads."""
    import numba

    from envs.football.batch import step_batch
    from envs.football.vector_env import FootballVectorEnv
    from scenic_lite.kernels.jit import compiled

    if not compiled(step_batch):
        print(f"compiling kernels (once, about {COMPILE_SECONDS} s)", file=sys.stderr, flush=True)
    settings: Any = numba.config
    numba.set_num_threads(min(threads, settings.NUMBA_NUM_THREADS))
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", UserWarning)
        upomdp = FootballVectorEnv(load_program(program, config.dialect), num_envs, config=config)
    for each in found:
        warn(f"warning: {each.message}")
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


def make_painter(program: Program) -> FootballPainter:
    """Make what draws the levels of a program."""
    from envs.football.scenic.lineup import Casting
    from envs.football.view.render import FootballPainter

    return FootballPainter(Casting(program))
