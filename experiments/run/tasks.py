"""Tasks in Python on the command line: `module:name` or `path.py:name`, a `ued.Task` or a function `make(num_envs)`.

Importing the file executes its code; `run.trust` determines whether it may run. Built-in tasks have short names and may
always run. Read next: `ued.core.task`; `run.games`, football games.
"""

from __future__ import annotations

import inspect
import re
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from regista.experiments.run import trust
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.errors import EXTRAS, CommandError, TaskError, UsageError, exit_code, nearest
from regista.experiments.run.games import Game, Source
from ued.core import own_code
from ued.core.own_code import FAILURES, module_of
from ued.core.painter import line_color_of

if TYPE_CHECKING:
    import numpy as np

    from ued.core.task import Make, Task
    from ued.core.upomdp import UPOMDP

NAME = re.compile(r"(.+\.py|[\w./\\~-]+):[A-Za-z_]\w*")  # of tasks; names of minigames have no colon


class PythonTask:
    """A task in a Python file or module, or a built-in one, with the interface of `run.games.Game`.

    The file is imported when its settings or environments are needed; see `load_task`.
    """

    def __init__(self, name: str) -> None:
        self.name, self.short = canonical(name), short(name)

    @cached_property
    def _loaded(self) -> tuple[Task, str]:
        return load_task(self.name)

    def start(self, preset: str) -> Any:
        """Return the settings of a preset for tasks, with the task's own defaults.

        Raises `CommandError` for defaults that name no setting or have a value of the wrong type.
        """
        from regista.experiments.run.config import changed, task_presets

        where, defaults = f"{self.name}: invalid defaults", self._loaded[0].defaults
        if "minigame" in defaults:
            raise CommandError(f"{where}: 'minigame' is the task itself")
        return changed(task_presets()[preset], defaults, where)

    def task(self, config: Any, env: Any = None) -> Task:
        """Return the task; errors in its functions report their line."""
        task = self._loaded[0]
        tests, held_out = (
            {key: _checked(test, f"the test '{key}': ") for key, test in part.items()}
            for part in (task.tests, task.held_out)
        )
        baselines = {key: partial(_policy, key, make) for key, make in task.baselines.items()}
        painter = partial(CheckedPainter, task.painter) if task.painter else None
        return replace(
            task, make=_checked(task.make), tests=tests, held_out=held_out, baselines=baselines, painter=painter
        )

    def source(self, config: Any) -> Source:
        """Return the text of the file, which may change during a run."""
        return Source("task.py", self._loaded[1], False)

    def of_level(self, level: np.ndarray, config: Any) -> tuple[Game, np.ndarray]:
        """Return this task and the level."""
        return self, level


def _checked(make: Any, where: str = "") -> Any:
    """Wrap a function that makes environments so that it raises `TaskError`; return levels unchanged."""
    return partial(_make, make, where) if callable(make) else make


def _make(make: Make, where: str, num_envs: int) -> UPOMDP:
    from ued.core.upomdp import UPOMDP

    with user_code(f"{where}make({num_envs}) failed"):
        upomdp = make(num_envs)
    if not isinstance(upomdp, UPOMDP) or upomdp.num_envs != num_envs:
        raise TaskError(f"{where}make({num_envs}) must return a UPOMDP of {num_envs} environments, got {upomdp!r}")
    return upomdp


def _policy(name: str, make: Any, upomdp: UPOMDP) -> Any:
    """Make a baseline. Raises `TaskError` if that fails, or if the result lacks the methods of a policy."""
    with user_code(f"the baseline '{name}' failed"):
        policy = make(upomdp)
    for method in ("play", "empty_memory"):
        if not callable(getattr(policy, method, None)):
            raise TaskError(f"the baseline '{name}' must be a policy with a method {method}, got {policy!r}")
    return policy


class CheckedPainter:
    """A task's painter, a `ued.core.painter.ScenePainter`, whose errors are reported with their line.

    Raises `TaskError` if the painter fails, lacks an attribute, or returns points of another shape.
    """

    def __init__(self, make: Any, upomdp: UPOMDP) -> None:
        with user_code("the painter failed"):
            self._painter = make(upomdp)
        for name in ("bounds", "reach", "background", "line_color", "markers", "classes", "focus"):
            if not hasattr(self, name):
                raise TaskError(f"the painter must have the attribute {name}, see ued.core.painter")

    def __getattr__(self, name: str) -> Any:
        return line_color_of(self._painter) if name == "line_color" else getattr(self._painter, name)

    def lines(self) -> Any:
        """Return the strips of the ground, each `[n, 2]`."""
        with user_code("the painter's lines() failed"):
            return self._painter.lines()

    def positions(self, theta: np.ndarray) -> Any:
        """Return the points of the scenes of θ `[L, D]`: `[L, K, 2]`."""
        return self._points("positions", theta, (len(theta), len(self.classes), 2))

    def frame(self, env: Any) -> Any:
        """Return the current points of the first environment of `env`: `[K, 2]`."""
        return self._points("frame", env, (len(self.classes), 2))

    def _points(self, method: str, given: Any, shape: tuple[int, ...]) -> Any:
        with user_code(f"the painter's {method}() failed"):
            points = getattr(self._painter, method)(given)
        if getattr(points, "shape", None) != shape:
            got = getattr(points, "shape", points)
            raise TaskError(f"the painter's {method}() must return an array of shape {shape}, got {got}")
        return points


def canonical(name: str) -> str:
    """Return a task's name with its module or the absolute path of its file, valid in every working directory."""
    name = BUILT_IN[name].name if name in BUILT_IN else name
    place, _, attribute = name.rpartition(":")
    return f"{Path(place).expanduser().resolve()}:{attribute}" if place.endswith(".py") else name


def typed(name: str) -> str:
    """Return a task's name for a command line: a built-in name, or a path relative to the working directory."""
    place, colon, attribute = name.rpartition(":")
    known = [key for key, task in BUILT_IN.items() if task.name == name]
    inside = place.endswith(".py") and Path(place).is_relative_to(Path.cwd())
    return known[0] if known else f"{Path(place).relative_to(Path.cwd()) if inside else place}{colon}{attribute}"


def short(name: str) -> str:
    """Return the short name of a task for folders and pictures."""
    known = [key for key, task in BUILT_IN.items() if task.name == canonical(name)]
    if known:
        return known[0]
    place, _, attribute = name.rpartition(":")
    return f"{Path(place).stem if place.endswith('.py') else place.rpartition('.')[2]}-{attribute}"


def name_of(task: Any) -> str:
    """Return the name `file.py:name` of a task, or of a function that makes environments.

    Raises `UsageError` unless it is a global name of a file, which other processes and later runs can import.
    """
    from ued.core.task import Task

    if not isinstance(task, Task) and not callable(task):
        raise UsageError(f"a task must be a ued.Task, a function make(num_envs) or a name, got {task!r}")
    own = inspect.getmodule(task.make if isinstance(task, Task) else task)  # None for a partial or an instance
    for module in filter(None, [own, *sys.modules.values()]):
        known = [key for key, value in [*vars(module).items()] if value is task]
        file = Path(getattr(module, "__file__", None) or "")  # that of code from standard input is "<stdin>"
        if known and file.suffix == ".py" and file.is_file():
            return canonical(f"{file}:{known[0]}")
    raise UsageError(
        "a task must be a global name of a Python file, so that a run can be resumed; save code from standard input, a "
        "console or a notebook in a file, such as task.py"
    )


def load_task(name: str) -> tuple[Task, str]:
    """Return the task with a name, and the text of its file.

    Raises `UsageError` for an unknown name, `TrustError` for a task that only a run folder names.
    """
    import gymnasium

    from ued.core.task import Task

    place, _, attribute = name.rpartition(":")
    built_in = name in [task.name for task in BUILT_IN.values()]
    if not built_in and (not place.endswith(".py") or Path(place).expanduser().is_file()):
        trust.check(name)
    with user_code(f"{place} cannot be imported"):
        module = _import(place, own_code.advice(name))
    if not hasattr(module, attribute):
        raise UsageError(f"{place} has no '{attribute}'{nearest(attribute, vars(module))}")
    task = getattr(module, attribute)
    if not isinstance(task, Task) and not callable(task):
        raise UsageError(f"{name} must be a ued.Task or a function make(num_envs), got {task!r}")
    if isinstance(task, type) and issubclass(task, gymnasium.Env):
        raise UsageError(
            f"{name} must be a ued.Task or a function make(num_envs) that returns a UPOMDP, got the class of one "
            "environment; make wraps environments, for example in ued.GymUPOMDP"
        )
    trust.remember(name)
    file = getattr(module, "__file__", None)
    return task if isinstance(task, Task) else Task(task), Path(file).read_text() if file else ""


@contextmanager
def user_code(what: str) -> Iterator[None]:
    """Convert errors in the user's code into a `TaskError` that reports the line."""
    try:
        yield
    except FAILURES as error:
        if exit_code(error) or (isinstance(error, ModuleNotFoundError) and error.name in EXTRAS):
            raise
        raise TaskError(f"{what}: {type(error).__name__}: {error}{_line_of(error)}; see --debug") from error


def _line_of(error: BaseException) -> str:
    """Return the last traceback line in the user's own code, or an empty string."""
    import ued

    others = ("<", sysconfig.get_path("stdlib"), *(str(Path(file).parent) for file in (ued.__file__, __file__)))
    frames = traceback.extract_tb(error.__traceback__)
    lines = [
        frame for frame in frames if not frame.filename.startswith(others) and "site-packages" not in frame.filename
    ]
    return f" ({lines[-1].filename}, line {lines[-1].lineno})" if lines else ""


def _import(place: str, advice: str) -> ModuleType:
    """Import a file or a module; `advice` ends the error of a missing one. Raises `UsageError` if it is missing."""
    if place.endswith(".py"):
        if not Path(place).expanduser().is_file():
            raise UsageError(f"there is no file {place}{advice}")
        return module_of(place)
    try:
        return module_of(place)
    except ModuleNotFoundError as error:
        raise UsageError(f"there is no module {error.name} (importing {place}){advice}") from error
