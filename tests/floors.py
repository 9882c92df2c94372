"""The import layers ("floors") of each package, from the lowest up, and the imports of its files.

Each floor has one module or folder, its room. A file may import from its own room and from the rooms below it. Read
next: `tests/test_architecture.py`.
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
)  # imported as `regista.envs` ...: `regista` has a symbolic link to each of these folders

# A room is a folder or a single file. A package's `__init__` is its roof: no module inside the package imports it.
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
        "core",  # scopes, types, budget: the basis of the language
        "language",  # chapters of the manual
        "evaluation",  # values of expressions, effects of statements
        "scene",  # theta -> scenes
        "loader",
        "dynamics.machine",  # the virtual machine inside the kernel
        "dynamics.compiler",  # behaviors -> code of the machine
        "dynamics",
    ),
    "envs": (
        "toy_world",  # the smallest world: objects drift, actions change nothing
        "football.version",
        "football.constants",
        "football.config",
        "football.field_kinds",  # kinds of fields, with limits
        "football.state",  # the record of a match
        "football.limits",  # checks of external records
        "football.physics",  # bodies and ball
        "football.rules",  # the laws of the game: restarts, fouls, offside
        "football.skills",  # kicks, tackles and other actions of players
        "football.control",  # agents, actions, reward, the end of an episode
        "football.ai",  # the built-in players
        "football.kick_off",  # start states of matches
        "football.frames",  # the ten frames of a step
        "football.scenic",  # the football domain of Scenic programs
        "football.simulator",  # a step
        "football.observation",  # observations of agents
        "football.batch",  # N matches, parallel
        "football.rollout",  # whole rollouts
        "football.engine",  # the interface of both engines: our simulator and GRF
        "grf",  # Google Research Football
        "football.view",  # pictures
        "football.vector_env",
        "football.gym_env",
        "football.parallel_env",  # PettingZoo
        "football.task",  # programs as a task
        "football.replay",
        "maze.config",
        "maze.grid",  # the arrays of mazes
        "maze.view",  # observations of agents
        "maze.dynamics",  # a step
        "maze.builder",  # an adversary's steps
        "maze.paths",  # distances to the goal
        "maze.levels",
        "maze.rollout",
        "maze.picture",
        "maze.env",
        "maze.gym_env",
        "maze.drawings",  # test mazes, as text
        "maze.generators",  # random test mazes
        "maze.named_mazes",  # all test mazes by name
        "maze.shortest_path",  # a policy that follows shortest paths
        "maze.painter",  # mazes in recordings
        "maze.task",
        "scenic3.names",  # random values of Scenic 3 programs, by name and line
        "scenic3.columns",  # random values as columns of theta
        "scenic3.program",  # theta -> scenes
        "scenic3.view",  # pictures of scenes
        "scenic3.episode",  # a simulation, step by step
        "scenic3.vector_env",  # simulations in parallel processes
    ),
    "ued": (
        "core.own_code",  # user code, by name
        "settings",  # declaration and checks of settings
        "student_config",
        "lesson_config",  # plans as text
        "config",  # hyperparameters
        "statistics",
        "core.seeding",
        "core.resumable",  # saving and resuming by a list of names
        "core.parts",  # observations of several parts
        "core.sparse_image",  # binary images as coordinates
        "core.room",  # memory checks
        "core.files",
        "core.renamed",  # names in older files
        "core.columns",  # tables on disk, read by column
        "core.checkpoint",
        "core.cells",  # columns of theta with finitely many values
        "core.families",  # levels that are not vectors of parameters
        "core.processes",  # settings of worker processes
        "core.parameters",  # parameters as columns of theta
        "core.level_space",  # levels, and the space of levels
        "core.compiled",  # arguments of rollouts in one kernel
        "core.begun",  # checks that environments have been reset
        "core.upomdp",  # the interface of environments and methods
        "core.episode_limit",
        "core.curriculum",
        "core.painter",  # drawings of levels
        "core.baselines",  # untrained policies
        "core.task",  # environments and test levels of a run
        "probes",
        "learning",  # student, rollout, PPO
        "levels",  # records, queue, buffer, scores, teacher
        "methods.method",  # the parts of a method
        "methods",  # the papers
        "evaluation",
        "adapters",  # Gymnasium, Stable-Baselines3, TorchRL; trained policies for other programs
        "recorder",
    ),
    "experiments": (
        "run",
        "pictures",
        "imitation",  # demonstrations and clones
        "transfer",  # policies in our simulator and in GRF
        "commands",
        "loaded",  # tables of results as DataFrames
        "calls",  # the commands as Python functions
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
    """Return all imports of a file, also those in functions and for types only; `from a import b` gives `a.b`."""
    return tuple(_imported(tree(path), path))


@cache
def tree(path: Path) -> ast.Module:
    """Return the syntax tree of a file, parsed once."""
    return ast.parse(path.read_text())


def _imported(tree: ast.Module, path: Path) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (own_name(alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import; write the package's name"
            yield from (own_name(f"{node.module}.{alias.name}") for alias in node.names)


def own_name(name: str) -> str:
    """Return a module's name by its real folder: `envs.x` for `regista.envs.x`, since `regista/envs` is a link."""
    inside = name.removeprefix("regista.")
    return inside if inside.partition(".")[0] in LINKED else name


def arrows(package: str) -> dict[str, set[str]]:
    """Return the imports of each module of a package, limited to modules of the same package."""
    known = modules(package)
    graph: dict[str, set[str]] = {}
    for name, path in known.items():
        targets = {full if full in known else full.rpartition(".")[0] for full in imported(path)}
        graph[name] = (targets & known.keys()) - {name}
    return graph


def floor(package: str, module: str) -> int:
    """Return the floor of a module, from 0 for the lowest."""
    inside = module.removeprefix(package + ".")
    rooms = [room for room in FLOORS[package] if inside == room or inside.startswith(room + ".")]
    if module == package or (not rooms and any(room.startswith(inside + ".") for room in FLOORS[package])):
        return len(FLOORS[package])  # a roof
    assert rooms, f"{module} is in no room of tests/floors.py"
    return FLOORS[package].index(max(rooms, key=len))


def upward(package: str) -> set[str]:
    """Return the imports of a package from a higher floor, as "module -> imported module"."""
    return {
        f"{module} -> {target}"
        for module, targets in arrows(package).items()
        for target in targets
        if floor(package, target) > floor(package, module)
    }


def ringed(package: str) -> set[str]:
    """Return the modules of a package that are part of an import cycle."""
    graph = arrows(package)

    def reachable(start: str) -> set[str]:
        reached, ahead = set(), [start]
        while ahead:
            new = graph[ahead.pop()] - reached
            reached |= new
            ahead += new
        return reached

    return {module for module in graph if module in reachable(module)}
