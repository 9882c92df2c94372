"""The floors of the house: the rooms of every package from the ground up, and what its files import.

A file may import from its own room and from the rooms below it. Read next: `tests/test_architecture.py`.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
LINKED = (
    "kernels",
    "envs",
    "minigames",
    "experiments",
)  # imported as regista.envs ..., the folder of that name being a link

# A room is a folder or a single file. A package's `__init__` is its roof: nothing inside the package imports it.
FLOORS = {
    "kernels": (
        "notices",
        "numba_cache",
        "numba_linking",
        "jit",
        "calls",
        "rng",
        "rollout",  # policy and bookkeeping of whole rollouts
    ),
    "scenic_lite": (
        "errors",
        "syntax",  # text -> checked tree
        "values",  # random expressions, operations, the plane
        "core",  # scopes, types, budget: what every chapter stands on
        "language",  # chapters of the manual
        "evaluation",  # the tree, walked once
        "scene",  # theta -> scenes
        "loader",
        "dynamics.machine",  # what runs in the kernel
        "dynamics.compiler",  # behaviors -> its code
        "dynamics",
    ),
    "envs": (
        "toy_world",  # the smallest, for programs of nothing that is known
        "football.version",
        "football.constants",
        "football.config",
        "football.field_kinds",  # what fields may hold
        "football.state",  # the record of a match
        "football.limits",  # whether a record keeps to that
        "football.physics",  # bodies and ball
        "football.rules",  # the laws of the game: restarts, fouls, offside
        "football.skills",  # what players do to the ball and to each other
        "football.control",  # agents, keys, reward, the end of an episode
        "football.ai",  # the built-in players
        "football.kick_off",  # matches about to begin
        "football.frames",  # the ten frames of a step
        "football.scenic",  # football as programs see it
        "football.simulator",  # a step
        "football.observation",  # what agents see
        "football.batch",  # N matches, parallel
        "football.rollout",  # whole rollouts
        "football.engine",  # what plays them: the simulator, or
        "grf",  # Google Research Football
        "football.view",  # pictures
        "football.vector_env",
        "football.gym_env",
        "football.parallel_env",  # PettingZoo
        "football.task",  # programs as a task
        "football.replay",
        "maze.config",
        "maze.grid",  # the arrays of mazes
        "maze.view",  # what agents see
        "maze.dynamics",  # a step
        "maze.builder",  # an adversary's steps
        "maze.paths",  # how far the goal is
        "maze.levels",
        "maze.rollout",
        "maze.picture",
        "maze.env",
        "maze.gym_env",
        "maze.drawings",  # test mazes, as text
        "maze.generators",  # test mazes, drawn at random
        "maze.named_mazes",  # all of them by name
        "maze.shortest_path",  # a policy
        "maze.painter",  # mazes in recordings
        "maze.task",
        "scenic3.names",  # Scenic 3 itself: what is random, by name and line
        "scenic3.columns",  # as columns of theta
        "scenic3.program",  # theta -> scenes
        "scenic3.view",  # as pictures
        "scenic3.episode",  # a simulation, step by step
        "scenic3.vector_env",  # processes of them
    ),
    "ued": (
        "core.own_code",  # functions and classes of the user, by name
        "settings",  # how they are declared
        "student_config",
        "lesson_config",  # plans as text
        "config",  # hyperparameters
        "statistics",
        "core.seeding",
        "core.resumable",  # states by a list of names
        "core.parts",  # observations of several parts
        "core.sparse_image",  # binary images as coordinates
        "core.room",  # how much memory there is
        "core.files",
        "core.renamed",  # names in older files
        "core.columns",  # tables on disk, by column
        "core.checkpoint",
        "core.cells",  # of columns with finitely many values
        "core.families",  # levels that are not vectors of parameters
        "core.processes",  # what a process asks of the system
        "core.parameters",  # what the columns of theta are
        "core.level_space",  # levels, and which there are
        "core.compiled",  # what rollouts in one kernel are given
        "core.begun",  # which environments have been reset
        "core.upomdp",  # the seam
        "core.episode_limit",
        "core.curriculum",
        "core.painter",  # how levels look
        "core.baselines",  # untrained policies
        "core.task",  # what a run trains on
        "probes",
        "learning",  # student, rollout, PPO
        "levels",  # records, queue, buffer, scores, teacher
        "methods.method",  # what methods are made of
        "methods",  # the papers
        "evaluation",
        "adapters",  # Gymnasium, Stable-Baselines3, TorchRL; a trained student, elsewhere
        "recorder",
    ),
    "experiments": (
        "run",
        "pictures",
        "imitation",  # demonstrations and clones
        "transfer",  # policies, played in both engines
        "commands",
        "loaded",  # their tables as data
        "calls",  # the same from Python
        "__main__",
    ),
}


def modules(package: str) -> dict[str, Path]:
    """Return the files of a package by module name; a folder's `__init__` has the folder's name."""
    files = {}
    for path in sorted((ROOT / package.replace(".", "/")).rglob("*.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        files[name.removesuffix(".__init__")] = path
    return files


@cache
def imported(path: Path) -> tuple[str, ...]:
    """Return what a file imports anywhere: at the top, in functions, for types alone; `from a import b` is `a.b`."""
    return tuple(_imported(tree(path), path))


@cache
def tree(path: Path) -> ast.Module:
    """Return what a file says, parsed once."""
    return ast.parse(path.read_text())


def _imported(tree: ast.Module, path: Path) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (own_name(alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import; write the package's name"
            yield from (own_name(f"{node.module}.{alias.name}") for alias in node.names)


def own_name(name: str) -> str:
    """Return the name of the folder that a module lies in: `regista.envs` is a link to `envs`."""
    inside = name.removeprefix("regista.")
    return inside if inside.partition(".")[0] in LINKED else name


def arrows(package: str) -> dict[str, set[str]]:
    """Return for each module of a package the modules of the package that it imports."""
    known = modules(package)
    graph: dict[str, set[str]] = {}
    for name, path in known.items():
        targets = {full if full in known else full.rpartition(".")[0] for full in imported(path)}
        graph[name] = (targets & known.keys()) - {name}
    return graph


def floor(package: str, module: str) -> int:
    """Return on which floor a module is, 0 at the ground."""
    inside = module.removeprefix(package + ".")
    rooms = [room for room in FLOORS[package] if inside == room or inside.startswith(room + ".")]
    if module == package or (not rooms and any(room.startswith(inside + ".") for room in FLOORS[package])):
        return len(FLOORS[package])  # a roof
    assert rooms, f"{module} is in no room of tests/floors.py"
    return FLOORS[package].index(max(rooms, key=len))


def upward(package: str) -> set[str]:
    """Return the imports of a package that lead to a higher floor, as "here -> there"."""
    return {
        f"{module} -> {target}"
        for module, targets in arrows(package).items()
        for target in targets
        if floor(package, target) > floor(package, module)
    }


def ringed(package: str) -> set[str]:
    """Return the modules of a package from which imports lead back to themselves."""
    graph = arrows(package)

    def reachable(start: str) -> set[str]:
        reached, ahead = set(), [start]
        while ahead:
            new = graph[ahead.pop()] - reached
            reached |= new
            ahead += new
        return reached

    return {module for module in graph if module in reachable(module)}
