"""Tasks of one's own on the command line: `module:name` or `path.py:name`, a `ued.Task` or a function `make(num_envs)`.

What a run trains on and is tested on are scenes here, which stand where programs stand in football. The file is
imported, so it is code that runs: `run.trust` says whose. Read next: `run.build`, which makes environments of scenes
and of programs.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import re
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from regista.experiments.run import trust
from regista.experiments.run.errors import EXTRAS, CommandError, UsageError, exit_code, nearest

if TYPE_CHECKING:
    import numpy as np

    from ued.core.task import Make, Task
    from ued.core.upomdp import UPOMDP

NAME = re.compile(r"(.+\.py|[\w./\\~-]+):[A-Za-z_]\w*")  # what a task is called; no minigame has a colon


@dataclass(frozen=True)
class TaskScene:
    """Environments of a task: those to train on, or a test of it, which may be of certain levels.

    Attributes:
        task: what it belongs to.
        make: makes so many environments.
        levels: what a test is of, as `Task.tests` has it; None: of random levels.
        source: the text of the file that the task is in.
    """

    task: Task
    make: Make
    levels: Any = None
    source: str = ""

    def theta(self, upomdp: UPOMDP) -> np.ndarray | None:
        """Return θ `[L, D]` of the levels of a test, None for random ones. Raises `CommandError` for none of it."""
        from ued.core.level_space import check_theta

        if self.levels is None:
            return None
        rows = self.levels
        try:
            if isinstance(rows, dict):
                rows = [rows]
            if len(rows) and (isinstance(rows[0], dict) or upomdp.level_family is not None):
                rows = [upomdp.theta_of(values) for values in rows]  # type: ignore[attr-defined]
            return check_theta(rows, upomdp.theta_dim)
        except (ValueError, TypeError, AttributeError) as error:
            raise CommandError(
                f"the levels of a test are no θ [L, {upomdp.theta_dim}] and no values: {error}"
            ) from error


def is_task(name: str) -> bool:
    """Return whether a word is the name of a task, not of a minigame."""
    return NAME.fullmatch(name) is not None


def canonical(name: str) -> str:
    """Return a task's name as a run keeps it: the path of its file holds in every working directory."""
    place, _, attribute = name.rpartition(":")
    return f"{Path(place).expanduser().resolve()}:{attribute}" if place.endswith(".py") else name


def short(name: str) -> str:
    """Return what a task is called in the names of folders and on pictures."""
    place, _, attribute = name.rpartition(":")
    return f"{Path(place).stem if place.endswith('.py') else place.rpartition('.')[2]}-{attribute}"


def name_of(task: Any) -> str:
    """Return the name under which a task, or a function that makes environments, is found again.

    Raises `UsageError` for one that has none: it must stand at the top of a file.
    """
    from ued.core.task import Task

    make = task.make if isinstance(task, Task) else task
    module = inspect.getmodule(make)
    known = [key for key, value in vars(module).items() if value is task] if module else []
    if module is None or not known or getattr(module, "__file__", None) is None:
        raise UsageError("a task must be a name at the top of a file, so that a run can be continued")
    return canonical(f"{module.__file__}:{known[0]}")


def load_task(name: str) -> tuple[Task, str]:
    """Return the task of a name, and the text of its file.

    Raises `UsageError` where there is none, `TrustError` for one that only a run folder names.
    """
    from ued.core.task import Task

    place, _, attribute = name.rpartition(":")
    if not place.endswith(".py") or Path(place).expanduser().is_file():
        trust.check(name)
    with _yours(f"{place} cannot be imported"):
        module = _import(place)
    if not hasattr(module, attribute):
        raise UsageError(f"{place} has no '{attribute}'{nearest(attribute, vars(module))}")
    task = getattr(module, attribute)
    if not isinstance(task, Task) and not callable(task):
        raise UsageError(f"{name} must be a ued.Task or a function make(num_envs), got {task!r}")
    trust.remember(name)
    file = getattr(module, "__file__", None)
    return task if isinstance(task, Task) else Task(task), Path(file).read_text() if file else ""


@contextmanager
def _yours(what: str) -> Iterator[None]:
    """Raise what goes wrong in the user's code as a `CommandError` that tells its line."""
    try:
        yield
    except Exception as error:
        if exit_code(error) or (isinstance(error, ModuleNotFoundError) and error.name in EXTRAS):
            raise
        raise CommandError(f"{what}: {type(error).__name__}: {error}{_line_of(error)}; see --debug") from error


def _line_of(error: Exception) -> str:
    """Return the last line of an error's traceback that is in no installed package and not ours, or nothing."""
    import ued

    others = ("<", sysconfig.get_path("stdlib"), *(str(Path(file).parent) for file in (ued.__file__, __file__)))
    frames = traceback.extract_tb(error.__traceback__)
    lines = [
        frame for frame in frames if not frame.filename.startswith(others) and "site-packages" not in frame.filename
    ]
    return f" ({lines[-1].filename}, line {lines[-1].lineno})" if lines else ""


def _import(place: str) -> ModuleType:
    if not place.endswith(".py"):
        if "" not in sys.path:
            sys.path.insert(0, "")  # as `python -m` has it
        try:
            return importlib.import_module(place)
        except ModuleNotFoundError as error:
            raise UsageError(f"there is no module {error.name}, which {place} needs or is") from error
    path = Path(place).expanduser().resolve()
    if not path.is_file():
        raise UsageError(f"there is no file {place}")
    main = sys.modules.get("__main__")
    if main is not None and Path(getattr(main, "__file__", None) or "").resolve() == path:
        return main  # a script that trains on a task of its own
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))  # as Python does for a script
    known = sys.modules.get(path.stem)
    if known is not None and Path(getattr(known, "__file__", None) or "").resolve() == path:
        return known
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)  # dataclasses and pickles look a class's module up
    try:
        spec.loader.exec_module(module)
    except BaseException:
        if sys.modules[path.stem] is module:
            del sys.modules[path.stem]  # half of it: the next attempt reads the file again
        raise
    return module


def load_scenes(name: str, training: str) -> dict[str, TaskScene]:
    """Return the scenes of a task by label: what is trained on, labelled `training`, then its tests."""
    task, source = load_task(name)
    if training in task.tests:
        raise CommandError(f"a test cannot be called '{training}', as what is trained on is called")
    scenes = {training: TaskScene(task, task.make, None, source)}
    for label, test in task.tests.items():
        scenes[label] = TaskScene(task, test) if callable(test) else TaskScene(task, task.make, test)
    return scenes


def make_upomdp(scene: TaskScene, num_envs: int, seed: int) -> UPOMDP:
    """Make `num_envs` environments of a scene, with seeded streams. Raises `CommandError` for what is no UPOMDP."""
    from ued.core.upomdp import UPOMDP

    with _yours(f"make({num_envs}) failed"):
        upomdp = scene.make(num_envs)
    if not isinstance(upomdp, UPOMDP) or upomdp.num_envs != num_envs:
        raise CommandError(f"make({num_envs}) must return a UPOMDP of {num_envs} environments, got {upomdp!r}")
    with _yours("the environments cannot be reset"):
        upomdp.reset(seed=seed)
    return upomdp
