"""How the tables of built-in functions and methods are written down.

Nothing of Python's own is reachable for a program but what such a table holds. Read next: `evaluation.strings`,
`evaluation.containers`, `evaluation.math_builtins`.
"""

from __future__ import annotations

from collections.abc import Callable

from scenic_lite.core.types import Builtin
from scenic_lite.values.graph import Value


def plain(*names: str, of: type) -> dict[str, Builtin]:
    """Methods of a Python container that cannot grow it and run no code of the program's."""
    return {name: Builtin(name, vars(of)[name], over_choices=False) for name in names}


def own(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Functions of values alone, mapped over a random choice of them."""
    return {name: Builtin(name, function) for name, function in functions.items()}


def needs_context(**functions: Callable[..., Value]) -> dict[str, Builtin]:
    """Functions that also receive the frame and the call."""
    return {
        name: Builtin(name, function, needs_context=True, over_choices=False) for name, function in functions.items()
    }


def typed(name: str, function: Callable[..., Value], *types: type) -> Builtin:
    """A function that is also a type: `isinstance(x, int)`."""
    return Builtin(name, function, needs_context=True, types=types, over_choices=False)
