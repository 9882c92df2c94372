"""Rules for running Python code: tasks, scores and networks are code, and an untrusted run folder can name any file.

Code may run if this user names it on the command line or in Python. Earlier command lines on this machine count, too;
they are recorded in `$XDG_STATE_HOME/regista/tasks`. Other tasks, named by a run folder, a checkpoint or a comparison,
are rejected without `--trust`. Names are compared by their resolved file, following links and `..`.
Read next: `run.tasks`, which checks before it imports anything.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from regista.experiments.run.errors import CommandError
from ued.core import own_code
from ued.core.files import write_whole

FLAG = "--trust"  # available for every command

_named: set[str] = set()  # tasks named by this user in this process
_all = False  # whether --trust was given


class TrustError(CommandError):
    """Only a file names this code, not the user."""


@contextmanager
def of_command(words: Sequence[str]) -> Iterator[list[str]]:
    """Trust the tasks on a command line while it runs; yield its words without `--trust`."""
    global _all, _named
    before = _all, _named
    typed = {word for word in words if not os.path.isdir(word)}  # the name of a run folder may look like a task's
    _all, _named = _all or FLAG in words, _named | typed
    try:
        yield [word for word in words if word != FLAG]
    finally:
        _all, _named = before


def allow(name: str) -> None:
    """Trust a task named by Python code of this user."""
    _named.add(name)


def check(name: str, what: str = "the task") -> None:
    """Raise `TrustError` for code that this user has not named."""
    if allows(name):
        return
    if file_of(name) is None:
        raise TrustError(
            f"cannot import module {name.rpartition(':')[0]} for {what} {name}, which a file names: no file of this "
            f"module is found; start the command where it can be imported{own_code.advice(name)}"
        )
    raise TrustError(
        f"a file names {what} {name}, which is Python code that this command would run, but no command line of yours "
        f"has named it; read {file_of(name)}, and add {FLAG} to run it"
    )


def allows(name: str) -> bool:
    """Return whether a task may run."""
    return _all or _is_named(name) or _is_remembered(identity(name))


def flags(*names: str) -> list[str]:
    """Return the flags that make a command in another process trust the same task and other code."""
    code = [name for name in names if ":" in name]
    return [FLAG] if code and all(map(allows, code)) else []


def remember(name: str) -> None:
    """Record a task that was named and imported, for later commands; ignore disk errors."""
    if not _is_named(name) or _is_remembered(identity(name)):
        return
    place = _note(identity(name))
    with suppress(OSError):
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_whole(place, identity(name) + "\n")


def identity(name: str) -> str:
    """Return a task's name with its resolved file, which is the same for all spellings of a task."""
    file = file_of(name)
    return name if file is None else f"{file}:{name.rpartition(':')[2]}"


def file_of(name: str) -> Path | None:
    """Return the file of a task or None, without importing anything."""
    place = name.rpartition(":")[0]
    if place.endswith(".py"):
        return Path(place).expanduser().resolve()
    first, *others = place.split(".")
    loaded = sys.modules.get(place)
    if loaded is not None and getattr(loaded, "__file__", None):
        return Path(str(loaded.__file__)).resolve()
    try:
        found = PathFinder.find_spec(first, ["", *sys.path]) or importlib.util.find_spec(first)
        for depth, _ in enumerate(others, 2):
            inside = found.submodule_search_locations if found else None
            found = PathFinder.find_spec(".".join(place.split(".")[:depth]), inside) if inside else None
    except (ImportError, ValueError, AttributeError):
        return None
    return Path(found.origin).resolve() if found and found.has_location and found.origin else None


def is_moved(old: Any, new: Any) -> bool:
    """Return whether two settings name the same function of a file with the same name, and the old file is missing."""
    if not (own_code.is_name(str(old)) and own_code.is_name(str(new))):
        return False
    file = file_of(old)
    (old_place, _, function), (new_place, _, other) = old.rpartition(":"), new.rpartition(":")
    same = function == other and _stem(old_place) == _stem(new_place)
    return same and (file is None or not file.is_file())


def _stem(place: str) -> str:
    """Return the name of a module without its folder or package."""
    return Path(place).stem if place.endswith(".py") else place.rpartition(".")[2]


def _is_named(name: str) -> bool:
    return name in _named or any(identity(name) == identity(other) for other in _named if ":" in other)


def _is_remembered(name: str) -> bool:
    """Return whether this user recorded a name; a record writable by others does not count."""
    place = _note(name)
    try:
        ours = all(
            path.stat().st_uid == os.geteuid() and not path.stat().st_mode & 0o022 for path in (place.parent, place)
        )
        return ours and place.read_text() == name + "\n"
    except (OSError, ValueError):
        return False


def _note(name: str) -> Path:
    """Return the path of a task's record."""
    home = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    return home / "regista" / "tasks" / hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()


def _check_own(name: str) -> None:
    check(name, "the function or class")


own_code.checks.append(_check_own)  # the same rules apply to scores and networks that a file names
