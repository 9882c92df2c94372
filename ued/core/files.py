"""Atomic writes: even after a crash, a file has either its new content or its old one.

Read next: `checkpoint`, the largest of them.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

PARTIAL = ".partial"  # the end of the name of a file that is being written


def write_whole(path: Path, content: bytes | memoryview | str) -> None:
    """Write a file atomically: to a temporary file, synced, renamed.

    Raises OSError with the name of the file, which then stays unchanged. See `partial_of` for the temporary file.
    """
    partial = partial_of(path)
    try:
        with open(partial, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except OSError as error:  # write errors carry no file name
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with suppress(OSError):  # missing after the renaming, or if the folder is missing
            partial.unlink()
    _sync_folder(path.parent)


def partial_of(path: Path) -> Path:
    """Return the temporary file of this process for a file; remove those of ended processes."""
    _tidy(path)
    return path.with_name(f".{path.name}.{os.getpid()}{PARTIAL}")


def is_partial(name: str) -> bool:
    """Return whether this is the name of a temporary file."""
    return name.startswith(".") and name.endswith(PARTIAL)


def _tidy(path: Path) -> None:
    """Remove the temporary files of ended processes for a file."""
    with suppress(OSError):
        for left in path.parent.iterdir():
            number = left.name.removeprefix(f".{path.name}.").removesuffix(PARTIAL)
            if is_partial(left.name) and number.isdecimal() and not _lives(int(number)):
                left.unlink()


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return process != os.getpid()  # this process removes its own on failure


def _sync_folder(folder: Path) -> None:
    """Sync the renaming to the disk, if the system supports it."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
