"""Files that are there whole or as they were, whatever happens while they are written.

Read next: `checkpoint`, the largest of them.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

PARTIAL = ".partial"  # the end of the name of a file that is being written


def write_whole(path: Path, content: bytes | memoryview | str) -> None:
    """Write a file in one stroke: beside, forced to the disk, renamed.

    Raises OSError with its name; then it is as it was. What a process that was killed has left of it is removed.
    """
    _tidy(path)
    partial = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL}")
    try:
        with open(partial, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except OSError as error:  # an error of writing has no name of itself
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with suppress(OSError):  # there is none after the renaming, nor where there is no folder
            partial.unlink()
    _sync_folder(path.parent)


def is_partial(name: str) -> bool:
    """Return whether a file of this name was being written when its process ended, or is."""
    return name.startswith(".") and name.endswith(PARTIAL)


def _tidy(path: Path) -> None:
    """Remove what processes that are no more have left of a file."""
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
    return process != os.getpid()  # ours are removed when they fail


def _sync_folder(folder: Path) -> None:
    """Force the renaming itself to the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
