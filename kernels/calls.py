"""Calls of kernels from Python. Read next: `envs.football.engine`, which calls them for every step."""

from __future__ import annotations

from typing import Any

import numba


def compiles() -> bool:
    """Return whether kernels are compiled; `NUMBA_DISABLE_JIT=1` disables this."""
    config: Any = numba.config
    return not config.DISABLE_JIT


def overload_of(function: Any, arguments: tuple[Any, ...]) -> Any:
    """Return a kernel's machine code for arguments of these types; calling it skips type inference."""
    if not hasattr(function, "get_overload"):
        return function
    types = tuple(map(numba.typeof, arguments))
    function.compile(types)
    return function.get_overload(types)
