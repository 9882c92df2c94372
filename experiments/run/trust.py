"""Which tasks may be run: a task of one's own is Python code, and anybody can write its name into a run folder.

A task is run if this user names it: on the command line that is running, from Python, or on an earlier command line of
this machine, which is remembered below `$XDG_STATE_HOME/regista/tasks`. Whatever else a run folder, a checkpoint or a
comparison names is refused, unless `--trust` is typed. Names are compared by the file that they lead to, links and `..`
resolved. Read next: `run.tasks`, which asks before it imports anything.
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

from regista.experiments.run.errors import CommandError
from ued.core.files import write_whole

FLAG = "--trust"  # of every command

_named: set[str] = set()  # in this process, by this user
_all = False  # whether --trust was typed


class TrustError(CommandError):
    """A task that only a file names."""


@contextmanager
def of_command(words: Sequence[str]) -> Iterator[list[str]]:
    """Trust what a command line names while it runs; give its words without `--trust`."""
    global _all, _named
    before = _all, _named
    typed = {word for word in words if not os.path.isdir(word)}  # a run folder's name may look like a task's
    _all, _named = _all or FLAG in words, _named | typed
    try:
        yield [word for word in words if word != FLAG]
    finally:
        _all, _named = before


def allow(name: str) -> None:
    """Trust a task that a program of this user names."""
    _named.add(name)


def check(name: str) -> None:
    """Raise `TrustError` for a task that this user has not named."""
    if allows(name):
        return
    raise TrustError(
        f"a file names the task {name}, which is Python code that would be run now, and you have not named it on a "
        f"command line before; read {file_of(name) or 'it'}, and add {FLAG} if it is to be run"
    )


def allows(name: str) -> bool:
    """Return whether a task may be run."""
    return _all or _is_named(name) or _is_remembered(identity(name))


def flags(name: str) -> list[str]:
    """Return what a command that another process runs needs so that it trusts what this one does."""
    return [FLAG] if ":" in name and allows(name) else []


def remember(name: str) -> None:
    """Note a task that was named, and could be imported, for later commands; where that is impossible, do not."""
    if not _is_named(name) or _is_remembered(identity(name)):
        return
    place = _note(identity(name))
    with suppress(OSError):
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_whole(place, identity(name) + "\n")


def identity(name: str) -> str:
    """Return a task's name with the file that it leads to, the same for all names of one task."""
    file = file_of(name)
    return name if file is None else f"{file}:{name.rpartition(':')[2]}"


def file_of(name: str) -> Path | None:
    """Return the file of a task, None where there is none; nothing is imported for it."""
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


def _is_named(name: str) -> bool:
    return name in _named or any(identity(name) == identity(other) for other in _named if ":" in other)


def _is_remembered(name: str) -> bool:
    """Return whether a name was noted, by us: nobody else may write there."""
    place = _note(name)
    try:
        ours = all(
            path.stat().st_uid == os.geteuid() and not path.stat().st_mode & 0o022 for path in (place.parent, place)
        )
        return ours and place.read_text() == name + "\n"
    except (OSError, ValueError):
        return False


def _note(name: str) -> Path:
    """Return where a task is noted."""
    home = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    return home / "regista" / "tasks" / hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()
