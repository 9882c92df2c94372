"""Notes on stderr: each is printed once in a process. Read next: `run.errors`, for what ends a command."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


@cache
def warn(text: str) -> None:
    """Print a note on stderr, the first time that it comes up: a program is compiled for many purposes."""
    print(text, file=sys.stderr, flush=True)


@contextmanager
def telling_warnings() -> Iterator[None]:
    """Print each `UserWarning` as a note, once, without the line of code that raised it."""
    show = warnings.showwarning

    def tell(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if category is UserWarning:
            warn(f"warning: {message}")
        else:
            show(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = tell
        yield
