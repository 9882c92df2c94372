"""Who trains a run: a lock, and where file locks mean nothing, as on some network disks, a name and a heartbeat.

`owner.json` in the run folder says who it is. A file lock decides between processes of one machine; of a process
elsewhere the owner counts for as long as its file is touched. Times are those of the disk, whatever clocks machines
have. Read next: `run.folder`.
"""

from __future__ import annotations

import fcntl
import json
import os
import platform
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from glob import escape
from pathlib import Path

from regista.experiments.run.errors import CommandError
from regista.experiments.run.table import cannot_write
from ued.core.files import PARTIAL

OWNER = "owner.json"
BEAT_SECONDS = 10.0  # between signs of life
SILENT_SECONDS = 60.0  # without one, after which an owner elsewhere counts as dead


_held: set[int] = set()  # the locks of this process


def _forget_locks() -> None:
    """Close the locks in a forked process: an environment's worker would keep a run locked after a kill of its own."""
    for handle in _held:
        os.close(handle)
    _held.clear()


os.register_at_fork(after_in_child=_forget_locks)


class BusyError(CommandError):
    """Somebody else trains this run just now."""


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Keep other processes, here and on other machines, from training this run. Raises `BusyError` if one does."""
    with _lock(folder) as locked:
        try:
            _claim(folder, locked)
        except OSError as error:
            raise cannot_write(folder / OWNER, error) from error
        ended = threading.Event()
        beating = threading.Thread(target=_beat, args=(folder / OWNER, ended), daemon=True)
        beating.start()
        try:
            yield
        finally:
            ended.set()
            beating.join()
            if _owner(folder) == _myself():
                with suppress(OSError):  # the next one of this machine takes it over
                    (folder / OWNER).unlink()
            with suppress(OSError):  # once more, if the disk did not do it before
                _mine(folder).unlink()


@contextmanager
def _lock(folder: Path) -> Iterator[bool]:
    """Lock a folder itself, for what lies in it may be replaced; give whether its disk has locks."""
    handle = os.open(folder, os.O_RDONLY)
    _held.add(handle)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            locked = True
        except BlockingIOError:
            raise BusyError(f"{folder} is being trained by another process") from None
        except OSError:
            locked = False
        yield locked
    finally:
        if handle in _held:
            _held.remove(handle)
            os.close(handle)


def _claim(folder: Path, locked: bool) -> None:
    """Become the owner of a folder, or raise `BusyError`: two who try at the same time cannot both become it."""
    mine = _mine(folder)
    try:
        if locked:  # whoever of this machine was killed in these lines holds no lock any more
            for left in folder.glob(f".owner.{escape(platform.node())}.*{PARTIAL}"):
                left.unlink(missing_ok=True)
        mine.write_text(json.dumps(_myself()))
        other = _owner(folder)
        if other is None:
            with suppress(FileExistsError):
                os.link(mine, folder / OWNER)
            other = _owner(folder)
        if other is not None and other != _myself():
            here = other.get("boot") == _boot()
            silent = mine.stat().st_mtime - _touched(folder)
            if not (here and locked) and silent < SILENT_SECONDS:
                who = f"process {other.get('pid')} of {other.get('host')}"
                raise BusyError(f"{folder} is being trained by {who}, last heard of {max(silent, 0):.0f} s ago")
            os.replace(mine, folder / OWNER)
    finally:
        with suppress(OSError):
            mine.unlink()


def _mine(folder: Path) -> Path:
    """Return where a claim is written before it is made."""
    return folder / f".owner.{platform.node()}.{os.getpid()}{PARTIAL}"


def _owner(folder: Path) -> dict | None:
    """Return what the owner says of itself, None if there is none."""
    try:
        said = json.loads((folder / OWNER).read_text())
    except (OSError, ValueError, RecursionError):
        return None
    return said if isinstance(said, dict) else None


def _touched(folder: Path) -> float:
    """Return when the owner gave its last sign of life; long ago, if it has just let go."""
    try:
        return (folder / OWNER).stat().st_mtime
    except OSError:
        return 0.0


def _beat(path: Path, ended: threading.Event) -> None:
    """Give signs of life until it is over; a disk that refuses one gets the next."""
    while not ended.wait(BEAT_SECONDS):
        with suppress(OSError):
            os.utime(path)


def _myself() -> dict[str, str | int]:
    return {"host": platform.node(), "boot": _boot(), "pid": os.getpid()}


@cache
def _boot() -> str:
    """Return what tells this machine, as long as it is up, from any other: names may be the same."""
    with suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return platform.node()
