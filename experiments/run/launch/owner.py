"""Ownership of a run folder: a file lock, and a heartbeat file for network disks without working locks.

`owner.json` in the run folder names the owner. A file lock decides between processes on one machine; an owner on
another machine is valid as long as it updates the file. Times come from the disk, so clocks of machines need not
agree. Read next: `run.folder`.
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
BEAT_SECONDS = 10.0  # between heartbeats
SILENT_SECONDS = 60.0  # without a heartbeat, after which an owner on another machine counts as dead


_held: set[int] = set()  # the locks of this process


def _forget_locks() -> None:
    """Close the locks in a forked process; otherwise an environment's worker could hold a lock after the run's end."""
    for handle in _held:
        os.close(handle)
    _held.clear()


os.register_at_fork(after_in_child=_forget_locks)


class BusyError(CommandError):
    """Another process is training this run."""


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Lock this run against other processes on any machine. Raises `BusyError` if one is training it."""
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
                with suppress(OSError):  # on failure, the next process on this machine takes it over
                    (folder / OWNER).unlink()
            with suppress(OSError):  # again, in case the first attempt failed
                _mine(folder).unlink()


@contextmanager
def _lock(folder: Path) -> Iterator[bool]:
    """Lock the folder itself, since files in it are replaced; yield whether its disk supports locks."""
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
    """Claim a folder, or raise `BusyError`; of two simultaneous claims, at most one succeeds."""
    mine = _mine(folder)
    try:
        if locked:  # a killed process on this machine no longer holds the lock
            for left in folder.glob(f".owner.{escape(platform.node())}.*{PARTIAL}"):
                left.unlink(missing_ok=True)
        mine.write_text(json.dumps(_myself()))
        other = _owner(folder)
        if other is None:
            with suppress(FileExistsError):
                os.link(mine, folder / OWNER)
            other = _owner(folder)
        if other is not None and other != _myself():
            same_machine = other.get("boot") == _boot()
            silent = mine.stat().st_mtime - _touched(folder)
            if not (same_machine and locked) and silent < SILENT_SECONDS:
                who = f"process {other.get('pid')} of {other.get('host')}"
                raise BusyError(f"{folder} is being trained by {who}, last heartbeat {max(silent, 0):.0f} s ago")
            os.replace(mine, folder / OWNER)
    finally:
        with suppress(OSError):
            mine.unlink()


def _mine(folder: Path) -> Path:
    """Return the path of a claim before it is published."""
    return folder / f".owner.{platform.node()}.{os.getpid()}{PARTIAL}"


def _owner(folder: Path) -> dict | None:
    """Return the content of owner.json, None if there is no owner."""
    try:
        content = json.loads((folder / OWNER).read_text())
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None


def _touched(folder: Path) -> float:
    """Return the time of the owner's last heartbeat; 0 if it has just released the folder."""
    try:
        return (folder / OWNER).stat().st_mtime
    except OSError:
        return 0.0


def _beat(path: Path, ended: threading.Event) -> None:
    """Write heartbeats until stopped; a failed one is retried at the next beat."""
    while not ended.wait(BEAT_SECONDS):
        with suppress(OSError):
            os.utime(path)


def _myself() -> dict[str, str | int]:
    return {"host": platform.node(), "boot": _boot(), "pid": os.getpid()}


@cache
def _boot() -> str:
    """Return an identifier of this machine since its last boot, as host names may coincide."""
    with suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return platform.node()
