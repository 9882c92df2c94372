"""Notes on stderr, each printed once per process. Read next: `run.errors`, errors that end a command."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


@cache
def warn(text: str) -> None:
    """Print a note on stderr unless it was printed before, since a program may be compiled several times."""
    print(text, file=sys.stderr, flush=True)


@contextmanager
def telling_warnings() -> Iterator[None]:
    """Print each `UserWarning` as a note, once, without its source line."""
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
