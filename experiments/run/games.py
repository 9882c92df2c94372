"""Football games on the command line: a minigame's name, the path of a .scenic program, or a mixture `a+b`.

`run.build.find_game` makes a game from its name. `run.tasks.PythonTask` is a task in a Python file with the same
methods. Read next: `minigames.suites`, the names; `run.mixed`, mixtures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from regista.experiments.run import arguments
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.programs import load_program
from ued.core.task import Task

if TYPE_CHECKING:
    from regista.envs.football.config import FootballConfig
    from regista.minigames.suites import Minigame
    from scenic_lite import Program

COMPILE_SECONDS = 40  # approximate time for all kernels, on a slow core
PROGRAM_WITH_BEHAVIORS = "Buildup"


class Source(NamedTuple):
    """Source text that a run saves, and its file name in the run folder; a `frozen` source must not change."""

    file: str
    text: str
    frozen: bool


class Game(Protocol):
    """A game or task, selected by a name on the command line.

    Attributes:
        name: the name in config.json, valid in every working directory.
        short: short name for folders and pictures.
    """

    name: str
    short: str

    def start(self, preset: str) -> Any:
        """Return the settings of a preset for this game."""

    def task(self, config: Any, env: Any = None) -> Task:
        """Return the task for the settings of a run; `env` overrides those of its environments."""

    def source(self, config: Any) -> Source:
        """Return the source that a run with these settings saves."""

    def of_level(self, level: np.ndarray, config: Any) -> tuple[Game, np.ndarray]:
        """Return the game of a level `[1]`, and the level without its program column."""


class FootballGame:
    """One training program with its test scenes: a minigame, a test scene of one, or a .scenic file."""

    def __init__(self, minigame: Minigame, name: str) -> None:
        self.minigame, self.name, self.short = minigame, name, minigame.name
        self._loaded: dict[Any, Program] = {}

    def start(self, preset: str) -> Any:
        """Return the settings of a preset with the control and reward recommended for this game.

        The preset `thesis` rewards goals only.
        """
        from regista.experiments.run.config import presets

        defaults = self.minigame.defaults
        if preset == "thesis":
            del defaults["env.rewards"]
        return arguments.replace_paths(presets()[preset], defaults)

    def program(self, config: Any) -> Program:
        """Compile the training program with these settings; the result is cached."""
        return self._load(self.minigame.program, config.env.dialect, config.program)

    def task(self, config: Any, env: FootballConfig | None = None) -> Task:
        """Return the training program and the test scenes as a task; test scenes are compiled on use."""
        env = env or config.env
        prepare_kernels(env, config.threads)
        make = partial(self._environments, dialect=env.dialect)
        return self.minigame.task(env, self.program(config), make)

    def source(self, config: Any) -> Source:
        """Return the text of the training program, which must not change during a run."""
        return Source("program.scenic", self.program(config).source, True)

    def of_level(self, level: np.ndarray, config: Any) -> tuple[Game, np.ndarray]:
        """Return this game and the level."""
        return self, level

    def _environments(self, program: Program | Path, num_envs: int, *, config: Any, dialect: int | None) -> Any:
        from regista.envs.football.vector_env import FootballVectorEnv

        loaded = self._load(program, dialect) if isinstance(program, Path) else program
        return FootballVectorEnv(loaded, num_envs, config=config)

    def _load(self, path: Path, dialect: int | None, settings: Any = None) -> Program:
        key = path, dialect, settings
        if key not in self._loaded:
            self._loaded[key] = load_program(path, dialect, settings)
        return self._loaded[key]


def prepare_kernels(env: FootballConfig, threads: int) -> None:
    """Set the number of threads of the kernels; compile those of our simulator if they are not cached."""
    import numba

    settings: Any = numba.config
    numba.set_num_threads(min(threads, settings.NUMBA_NUM_THREADS))
    if env.engine == "regista":
        compile_football()


def compile_football() -> None:
    """Compile all kernels that Python calls, before several processes would compile their shared parts.

    The types of their arguments are the same for all programs and representations, so one match of any program with
    behaviors compiles all kernels. Processes that start together share the work.
    """
    from regista.kernels.jit import compiled, linked
    from regista.kernels.notices import COMPILING, at_work, say_once

    missing = [entry.__name__ for entry in entry_points() if not compiled(entry)]
    if not missing:
        return
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.minigames.suites import NAMED
    from ued import METHODS, PPOConfig

    if not linked():
        say_once(f"{COMPILING} (once on this machine, about {2 * COMPILE_SECONDS} s)")
    with at_work(missing, COMPILE_SECONDS):
        match = FootballVectorEnv(NAMED[PROGRAM_WITH_BEHAVIORS].program)
        match.reset(seed=0)
        match.step(np.zeros(match.action_space.shape, np.int64))
        match.set_state(match.get_state())
        match.program_actions()
        METHODS["dr"].load()(match, PPOConfig(num_steps=4, num_minibatches=1), seed=0, env_steps=4).update()


def entry_points() -> tuple[Any, ...]:
    """Return the kernels of our simulator that Python calls."""
    from regista.envs.football import batch, limits, rollout

    steps = batch.begin, batch.observe_batch, batch.step_batch
    return *steps, limits.first_outside, batch.ask_program, rollout.play_matches


class MixedGame:
    """Several games in one run; the game is a parameter of the level, so the teacher chooses among them."""

    def __init__(self, name: str, short: str, games: Sequence[FootballGame]) -> None:
        self.name, self.short, self.games = name, short, tuple(games)

    def start(self, preset: str) -> Any:
        """Return the settings of the first game."""
        return self.games[0].start(preset)

    def task(self, config: Any, env: FootballConfig | None = None) -> Task:
        """Return the mixture of the games' tasks; its tests are all games and all of their test scenes."""
        from regista.experiments.run.mixed import mixed_task

        return mixed_task(self._by_name(lambda game: game.task(config, env)))

    def source(self, config: Any) -> Source:
        """Return the texts of all programs, each after its name."""
        texts = self._by_name(lambda game: game.program(config).source)
        return Source("program.scenic", "\n".join(f"# {name}\n{text}" for name, text in texts.items()), True)

    def of_level(self, level: np.ndarray, config: Any) -> tuple[Game, np.ndarray]:
        """Return the game selected by θ's first column, and the level without that column."""
        from ued.core.cells import index_in
        from ued.core.level_space import level_dtype

        theta = level["theta"][0]
        game = self.games[int(index_in(theta[0], len(self.games)))]
        dim = game.program(config).dim
        own = np.zeros(1, level_dtype(dim))
        own["seed"], own["theta"] = level["seed"], theta[1 : 1 + dim]
        return game, own

    def _by_name(self, of: Any) -> Mapping[str, Any]:
        return {game.short: of(game) for game in self.games}


# ---------------------------------------------------------------- names


def football_game(name: str) -> FootballGame | MixedGame:
    """Return the game with a name: a minigame, `MINIGAME/TEST`, a mixture `a+b`, or the path of a .scenic program.

    Raises `UsageError` for any other name.
    """
    from regista.minigames.suites import MIXTURES, NAMED

    parts = list(MIXTURES[name]) if name in MIXTURES else name.split("+")
    games = [_single(part) for part in parts]
    if len(games) == 1:
        return games[0]
    known = name in MIXTURES or name in NAMED
    full, short = ("+".join(getattr(game, what) for game in games) for what in ("name", "short"))
    return MixedGame(name if known else full, name if known else short, games)


def single_game(name: str) -> FootballGame:
    """Return the game with a name, for a single program. Raises `UsageError` for mixtures and unknown names."""
    game = football_game(name)
    if isinstance(game, MixedGame):
        parts = ", ".join(part.short for part in game.games)
        raise UsageError(f"{name} is a mixture; give one of its minigames: {parts}")
    return game


def find_minigame(name: str) -> Minigame:
    """Return the minigame with a name, like `single_game`."""
    return single_game(name).minigame


def _single(name: str) -> FootballGame:
    from regista.minigames.suites import NAMED, Minigame

    if name in NAMED:
        return FootballGame(NAMED[name], name)
    path = Path(name)
    if path.suffix == ".scenic":
        if not path.is_file():
            raise UsageError(f"there is no program {name}")
        return FootballGame(Minigame(path.stem, path, (), "your program"), str(path.resolve()))
    if path.suffix == ".py":
        raise UsageError(f"a Python task must be file.py:name, got {name!r}")
    if ":" in name or name in BUILT_IN:
        raise UsageError(f"{name} is a Python task; this command needs a football game")
    meant = nearest(name, [*NAMED, *BUILT_IN], 3)
    raise UsageError(f"unknown minigame {name!r}{meant}; regista list shows all, or give a .scenic file")


def all_starts(preset: str = "fast") -> list[Any]:
    """Return the distinct settings of all minigames with a preset."""
    from regista.minigames.suites import NAMED

    different = {tuple(game.defaults.items()): FootballGame(game, name) for name, game in NAMED.items()}
    return [game.start(preset) for game in different.values()]
