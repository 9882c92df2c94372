"""Games, methods, devices and environments by name, with seeded random streams.

Heavy packages are imported on use. Read next: `run.games` and `run.tasks`, the kinds of names; `commands.train`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from regista.experiments.run import games, tasks
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.games import Game
from regista.experiments.run.heap import keep_freed_memory
from regista.experiments.run.notes import telling_warnings
from ued.core.room import RoomError, check_environments, space_bytes
from ued.methods import METHODS

if TYPE_CHECKING:
    import torch

    from regista.envs.football.config import FootballConfig
    from scenic_lite import Program
    from ued.core.task import Make

MANY = 1_024  # environments; for more, `make_upomdp` first makes one and checks whether all fit into memory
STATE_COPIES = 3  # copies of a match's state during a step
ENGINE_BYTES = 55_000_000  # one engine of Google Research Football


def find_game(name: str) -> Game:
    """Return the game of a name: football, a built-in task, a Python task. Raises `UsageError` for an unknown name."""
    is_task = name in BUILT_IN or tasks.NAME.fullmatch(name)
    return tasks.PythonTask(name) if is_task else games.football_game(name)


def find_method(name: str) -> str:
    """Return the name of a method unchanged. Raises `UsageError` for an unknown method."""
    if not isinstance(name, str):
        raise UsageError(f"a method is a name, such as 'plr', got {name!r:.100}")
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}{nearest(name, METHODS)}; methods are {', '.join(METHODS)}")
    return name


def check_used(names: Iterable[str], methods: Iterable[str]) -> None:
    """Raise `UsageError` for a setting that none of these methods uses, such as `paired.roles` for plr.

    Names of settings that no method groups, such as `num_envs`, are ignored.
    """
    methods = list(dict.fromkeys(methods))
    groups = {METHODS[find_method(name)].group for name in methods}
    for name in names:
        group, _, rest = name.partition(".")
        users = [row.name for row in METHODS.values() if row.group == group]
        if users and group not in groups:
            flag = f"--{group}.{rest}".replace("_", "-") if rest else group
            raise UsageError(f"{flag} is a setting of {' and '.join(users)}; {' and '.join(methods)} would not use it")


def find_device(name: str) -> torch.device:
    """Return the device of this name; auto: a GPU if there is one. Raises `UsageError` for a missing device."""
    import torch

    gpus = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if name == "cpu" or (name == "auto" and not gpus):
        return torch.device("cpu")
    device = torch.device("cuda" if name == "auto" else name)
    if (device.index or 0) >= gpus:
        seen = {0: "no GPU", 1: "one GPU, cuda:0"}.get(gpus, f"{gpus} GPUs")
        raise UsageError(f"there is no device {name}: torch finds {seen}; use --device cpu")
    return device


def make_upomdp(make: Make, num_envs: int, seed: int) -> Any:
    """Make `num_envs` environments with seeded random streams. Raises `UsageError` if they do not fit into memory."""
    with telling_warnings():
        if num_envs > MANY:
            with room_for("environments"):
                check_environments(num_envs, _bytes_of_one(make(1), seed))
        upomdp = make(num_envs)
    with tasks.user_code("the environments cannot be reset"):
        upomdp.reset(seed=seed)
    return upomdp


def make_matches(program: Program, num_envs: int, env: FootballConfig, seed: int, threads: int = 1) -> Any:
    """Make `num_envs` environments of a football program, with seeded random streams."""
    from regista.envs.football.vector_env import FootballVectorEnv

    games.prepare_kernels(env, threads)
    return make_upomdp(partial(FootballVectorEnv, program, config=env), num_envs, seed)


def make_method(config: Any, upomdp: Any) -> Any:
    """Make the method that trains on `upomdp`.

    Raises `UsageError` for an unknown method, and for an environment that the method does not support.
    """
    import torch

    method, device = METHODS[find_method(config.method)], find_device(config.device)
    torch.set_num_threads(config.threads)
    keep_freed_memory()
    try:
        with room_for("students"):
            made = method.load()(upomdp, config.ppo, getattr(config, method.group), config.seed, config.total_env_steps)
    except (ValueError, ImportError, NotImplementedError) as error:
        raise UsageError(f"{config.method} cannot train on {config.minigame}: {error}") from error
    if device.type != "cpu":
        os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # before cuBLAS starts: deterministic sums
        torch.use_deterministic_algorithms(True, warn_only=True)
    for learner in made.learners:
        learner.to(device)
    return made


@contextmanager
def room_for(what: str) -> Iterator[None]:
    """Convert the error of settings that exceed the memory into a `UsageError` that names their flags."""
    try:
        yield
    except RoomError as error:
        flags = " and ".join(f"--{name.replace('_', '-')}" for name in error.settings)
        raise UsageError(f"{flags}: too large for the {what}: {error}") from error


def _bytes_of_one(upomdp: Any, seed: int) -> int:
    """Return a lower bound on the bytes of an environment (its state and observations), and close it."""
    if getattr(getattr(upomdp, "config", None), "engine", None) == "grf":
        return ENGINE_BYTES
    upomdp.reset(seed=seed)
    held = upomdp.get_state().values() if upomdp.supports_state else ()
    upomdp.close()
    kept = sum(getattr(value, "nbytes", 0) for value in held)
    return STATE_COPIES * kept + 2 * space_bytes(upomdp.agent_observation_space) * upomdp.num_agents
