"""Texts: how values are written, `%` and `.format`, and the methods of texts; within the budget.

Read next: `evaluation.containers`, the methods of lists, dictionaries and sets.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.builtin_tables import needs_context, plain
from scenic_lite.core.exceptions import ExceptionClass, Fault
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState
from scenic_lite.core.types import Builtin, Instance, RandomChoice, ScenicClass, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import INTEGER, TEXT

DIRECTIVE = re.compile(
    r"%(?:\((?P<key>[^()]*)\))?(?P<flags>[#0\- +]*)(?P<width>\*|\d+)?(?:\.(?P<digits>\*|\d+))?(.)", re.S
)
FIELD = re.compile(r"\{\{|\}\}|\{(?P<name>[^{}!:]*)(?:!(?P<conversion>[rsa]))?(?::(?P<spec>[^{}]*))?\}|[{}]")
DEEPEST = 50  # containers inside each other that are written out


def written(state: LoadState, value: Value, depth: int = 0) -> str:
    """`repr(value)`; of a text too."""
    if isinstance(value, list | tuple | set | dict):
        state.budget.container(len(value))
        if depth > DEEPEST:
            raise exceeded("a text of collections that are nested too deeply")
        return collection(state, value, depth + 1)
    if isinstance(value, Vector):
        x, y = written(state, value.x), written(state, value.y)
        return f"({x} @ {y})" if state.dialect == 2 else f"Vector({x}, {y}, 0)"
    if isinstance(value, Fault):
        return f"{value.cls.name}({', '.join(written(state, each) for each in value.arguments)})"
    if isinstance(value, ScenicClass | ExceptionClass):
        return f"<class '{value.name}'>"
    if isinstance(value, Instance):
        return value.title()
    if isinstance(value, int | float | str | bytes | complex | range | type(None)):
        return repr(value)
    if isinstance(value, Builtin) and value.types:
        return f"<class '{value.name}'>"
    return describe_kind(value)


def collection(state: LoadState, value: Any, depth: int) -> str:
    if isinstance(value, dict):
        pairs = (f"{written(state, k, depth)}: {written(state, v, depth)}" for k, v in value.items())
        return f"{{{', '.join(pairs)}}}"
    parts = [written(state, each, depth) for each in value]
    inside = ", ".join(parts)
    state.budget.text(len(inside))
    if isinstance(value, list):
        return f"[{inside}]"
    if isinstance(value, tuple):
        return f"({inside},)" if len(parts) == 1 else f"({inside})"
    return f"{{{inside}}}" if parts else "set()"


def text_of(scope: Scope, value: Value, spec: str = "") -> Value:
    """`str(value)`, or its formatted text; row by row if it is random."""
    if any(len(number) > 3 for number in re.findall(r"\d+", spec)):
        raise exceeded("a text format wider than 999")
    if isinstance(value, RandomExpr):
        if spec:
            format("" if value.kind == "text" else 1, spec)  # raises ValueError if the spec is none
        return RandomExpr(TEXT.array if not spec else FormatEach(spec), (value,), "text")
    if isinstance(value, RandomChoice):
        return value.map_options([text_of(scope, option, spec) for option in value.options])
    if spec and not isinstance(value, int | float | str):
        raise ScenicError("type", f"{describe_kind(value)} takes no format")
    if isinstance(value, str):
        return format(value, spec)
    if isinstance(value, Fault):
        return value.text()
    return format(value, spec) if spec else written(scope.state, value)


class FormatEach:
    """Write each element of an array [N] with one format."""

    def __init__(self, spec: str) -> None:
        self.spec = spec

    def __call__(self, values: Any) -> Any:
        texts = [format(value.item() if hasattr(value, "item") else value, self.spec) for value in values]
        return np.array(texts + [None], dtype=object)[:-1]


def joined(scope: Scope, pieces: list[Value]) -> Value:
    """One text of several; random ones row by row."""
    result: Value = ""
    for piece in pieces:
        result = piece if result == "" else result + piece
        scope.mode.budget.keep(result)
    return result


def whole_number(value: Value) -> Value:
    return apply(INTEGER, value)


def represented(scope: Scope, node: Any, value: Value) -> Value:
    """`repr(value)`, of a random text or number row by row."""
    if isinstance(value, RandomExpr) and value.kind != "text":
        return text_of(scope, value, "")
    if isinstance(value, RandomExpr | RandomChoice):
        raise ScenicError("unsupported", "repr() of a random value", hint="write str(x)")
    return written(scope.state, value)


# ------------------------------------------------------------ formats


def percent(scope: Scope, template: str, values: Value) -> Value:
    """`template % values`; random values are written row by row."""
    given = list(values) if isinstance(values, tuple) else [values]
    by_name = isinstance(values, dict)
    pieces: list[Value] = []
    at = 0
    for match in DIRECTIVE.finditer(template):
        pieces.append(template[at : match.start()])
        at = match.end()
        letter = match[5]
        if letter == "%":
            pieces.append("%")
            continue
        if "*" in (match["width"], match["digits"]) or letter not in "diouxXeEfFgGcrsa":
            raise ScenicError("value", f"the format '{match[0]}' is not known")
        if match["key"] is not None:
            if not by_name:
                raise ScenicError("type", f"'{match[0]}' needs a dictionary after the %")
            value = values[match["key"]]
        elif not given:
            raise ScenicError("type", "not enough values for the format")
        else:
            value = given.pop(0)
        pieces.append(one_percent(scope, match, value))
    if "%" in template[at:]:
        raise ScenicError("value", "the format ends in an incomplete '%'")
    if given and not by_name:
        raise ScenicError("type", "more values than the format has places for")
    return joined(scope, [*pieces, template[at:]])


def one_percent(scope: Scope, match: re.Match[str], value: Value) -> Value:
    """One `%5.2f`, by way of the formats of f-strings."""
    letter, flags = match[5], match["flags"]
    if letter in "rsa":
        text = represented(scope, None, value) if letter != "s" else text_of(scope, value, "")
        if not match["width"] and not match["digits"]:
            return text
        digits = f".{match['digits']}" if match["digits"] else ""
        return text_of(scope, text, f"{'<' if '-' in flags else '>'}{match['width'] or ''}{digits}")
    if letter == "c":
        text = chr(value) if isinstance(value, int) else value
        if not isinstance(text, str) or len(text) != 1:
            raise ScenicError("type", f"'{match[0]}' needs one character, not {describe_kind(value)}")
        return text_of(scope, text, f"{'<' if '-' in flags else '>'}{match['width'] or ''}")
    if isinstance(value, str) or not isinstance(value, int | float | RandomExpr):
        raise ScenicError("type", f"'{match[0]}' needs a number, not {describe_kind(value)}")
    if letter in "diu":
        letter, value = "d", whole_number(value)
    align = "<" if "-" in flags else ""
    sign = next((each for each in "+ " if each in flags), "")
    fill = "0" if "0" in flags and not align else ""
    digits = f".{match['digits']}" if match["digits"] and letter != "d" else ""
    return text_of(
        scope, value, f"{align}{sign}{'#' if '#' in flags else ''}{fill}{match['width'] or ''}{digits}{letter}"
    )


def text_format(scope: Scope, node: Any, self: str, *values: Value, **named: Value) -> Value:
    """`self.format(...)`: places by number or by name, with a format each; no attributes and no items."""
    pieces: list[Value] = []
    at = count = 0
    for match in FIELD.finditer(self):
        pieces.append(self[at : match.start()])
        at = match.end()
        if match[0] in ("{{", "}}"):
            pieces.append(match[0][0])
            continue
        if match["name"] is None:
            raise ScenicError("value", f"a single '{match[0]}' in a format")
        name = match["name"]
        if "." in name or "[" in name:
            raise ScenicError("unsupported", "a format reads no attributes and no items", hint='write f"{x.y}"')
        if not name:
            name, count = str(count), count + 1
        if name.isdigit() and int(name) < len(values):
            value = values[int(name)]
        elif name in named:
            value = named[name]
        else:
            raise ScenicError("value", f"the format has a place '{{{name}}}', but no value for it")
        if match["conversion"] in ("r", "a"):
            value = represented(scope, node, value)
        pieces.append(text_of(scope, value, match["spec"] or ""))
    return joined(scope, [*pieces, self[at:]])


# ------------------------------------------------------------ methods


def text_join(scope: Scope, node: Any, self: str, items: Value) -> Value:
    items = scope.elements(items, node)
    scope.mode.budget.text(sum(len(item) + len(self) for item in items if isinstance(item, str)))
    if any(isinstance(item, RandomExpr) for item in items):
        return joined(scope, [part for item in items for part in (self, item)][1:])
    return self.join(items)


def text_replace(scope: Scope, node: Any, self: str, old: str, new: str, count: int = -1) -> str:
    scope.mode.budget.text(len(self) + (len(self) + 1) * len(new))
    return self.replace(old, new, count)


def text_split(scope: Scope, node: Any, self: str, sep: str | None = None, maxsplit: int = -1) -> list:
    scope.mode.budget.container(len(self))
    return self.split(sep, maxsplit)


def text_rsplit(scope: Scope, node: Any, self: str, sep: str | None = None, maxsplit: int = -1) -> list:
    scope.mode.budget.container(len(self))
    return self.rsplit(sep, maxsplit)


def text_lines(scope: Scope, node: Any, self: str, keepends: bool = False) -> list:
    scope.mode.budget.container(len(self))
    return self.splitlines(keepends)


def text_centre(scope: Scope, node: Any, self: str, width: int, fill: str = " ") -> str:
    scope.mode.budget.text(width)
    return self.center(width, fill)


def text_left(scope: Scope, node: Any, self: str, width: int, fill: str = " ") -> str:
    scope.mode.budget.text(width)
    return self.ljust(width, fill)


def text_right(scope: Scope, node: Any, self: str, width: int, fill: str = " ") -> str:
    scope.mode.budget.text(width)
    return self.rjust(width, fill)


def text_zeros(scope: Scope, node: Any, self: str, width: int) -> str:
    scope.mode.budget.text(width)
    return self.zfill(width)


METHODS: dict[str, Builtin] = plain(
    "lower", "upper", "title", "capitalize", "swapcase", "casefold", "strip", "lstrip", "rstrip", "startswith",
    "endswith", "removeprefix", "removesuffix", "find", "rfind", "index", "rindex", "count", "partition", "rpartition",
    "isdigit", "isalpha", "isalnum", "isspace", "isupper", "islower", "isdecimal", "isnumeric", "isidentifier",
    "istitle", "isascii", of=str,
) | needs_context(
    join=text_join, replace=text_replace, split=text_split, rsplit=text_rsplit, splitlines=text_lines,
    center=text_centre, ljust=text_left, rjust=text_right, zfill=text_zeros, format=text_format,
)  # fmt: skip
