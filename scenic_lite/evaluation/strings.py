"""Texts: how values are written by f-strings and `str()`, within the budget; one by one where they are random.

Texts are put together by f-strings and `+`; they have no methods. Read next: `evaluation.builtins`.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState
from scenic_lite.core.types import Builtin, Instance, ScenicClass, broadcasts_over_choices, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value
from scenic_lite.values.operations import TEXT

DEEPEST = 50  # containers inside each other that are written out


def represent(state: LoadState, value: Value, depth: int = 0) -> str:
    """Return a value as it is written inside a container, a text in quotes."""
    if isinstance(value, list | tuple | dict):
        if depth > DEEPEST:
            raise exceeded("a text of collections that are nested too deeply")
        return represent_collection(state, value, depth + 1)
    if isinstance(value, Vector):
        x, y = represent(state, value.x), represent(state, value.y)
        return f"({x} @ {y})" if state.dialect == 2 else f"Vector({x}, {y}, 0)"
    if isinstance(value, Instance):
        return value.title()
    if isinstance(value, int | float | str | range | type(None)):
        return repr(value)
    if isinstance(value, ScenicClass) or (isinstance(value, Builtin) and value.types):
        return f"<class '{value.name}'>"
    return describe_kind(value)


def represent_collection(state: LoadState, value: Any, depth: int) -> str:
    if isinstance(value, dict):
        pairs = (f"{represent(state, k, depth)}: {represent(state, v, depth)}" for k, v in value.items())
        return f"{{{', '.join(pairs)}}}"
    parts = [represent(state, element, depth) for element in value]
    inside = ", ".join(parts)
    state.budget.text(len(inside))
    if isinstance(value, list):
        return f"[{inside}]"
    return f"({inside},)" if len(parts) == 1 else f"({inside})"


@broadcasts_over_choices(1)
def text_of(scope: Scope, value: Value, spec: str = "") -> Value:
    """`str(value)`, or its formatted text; row by row if it is random."""
    if any(len(number) > 3 for number in re.findall(r"\d+", spec)):
        raise exceeded("a text format wider than 999")
    if isinstance(value, RandomExpr):
        if spec:
            format("" if value.kind == "text" else 1, spec)  # raises ValueError if the spec is none
        return RandomExpr(TEXT.array if not spec else FormatEach(spec), (value,), "text")
    if spec and not isinstance(value, int | float | str):
        raise ScenicError("type", f"{describe_kind(value)} takes no format")
    if spec or isinstance(value, str):
        return format(value, spec)
    scope.mode.budget.whole(value)  # a part that is shared is written each time
    return represent(scope.state, value)


class FormatEach:
    """Write each element of an array [N] with one format."""

    def __init__(self, spec: str) -> None:
        self.spec = spec

    def __call__(self, values: Any) -> Any:
        texts = [format(value.item() if hasattr(value, "item") else value, self.spec) for value in values]
        return np.array(texts + [None], dtype=object)[:-1]


def concatenate(scope: Scope, pieces: list[Value]) -> Value:
    """Return one text of several; random ones row by row."""
    result: Value = ""
    for piece in pieces:
        result = piece if result == "" else result + piece
        scope.mode.budget.keep(result)
    return result


def no_method(name: str) -> ScenicError:
    hint = 'texts are put together by f"..." and +, and compared by == and in'
    return ScenicError("unsupported", f"texts have no method '{name}' here", hint=hint)
