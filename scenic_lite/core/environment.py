"""The names visible at one point of a program, and how errors are given their place in its text.

A function keeps the environment it was defined in. What its body means is decided by whoever calls it: a `Scope` adds
that. Read next: `core.state`, `core.scope`.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenic_lite.errors import ScenicError, SourceSpan

Value = Any


@dataclass(frozen=True)
class Source:
    """One file of program text."""

    file: str
    lines: tuple[str, ...]
    folder: Path | None  # where modules named by the program are looked for
    library: bool  # of the domain, not of the user

    def line(self, number: int) -> str:
        return self.lines[number - 1] if 0 < number <= len(self.lines) else ""


class Environment:
    """The variables of one module, function, comprehension or class body, inside those around it."""

    __slots__ = (
        "assigned",
        "globals",
        "locals",
        "module_names",
        "nonlocals",
        "outer",
        "source",
        "transparent",
    )

    def __init__(self, source: Source, names: dict[str, Value], outer: Environment | None = None) -> None:
        self.source = source
        self.locals = names
        self.outer = outer
        self.globals: set[str] = set()  # declared `global` here
        self.nonlocals: set[str] = set()
        self.assigned: frozenset[str] = frozenset()  # the names of a function that it has before they have a value
        self.transparent = False  # of a comprehension, whose `:=` binds outside
        self.module_names: dict[str, Value] = outer.module_names if outer else names

    def names_of(self, name: str) -> dict[str, Value]:
        """Return where an assignment to the name goes."""
        if name in self.globals:
            return self.module_names
        scope: Environment | None = self.outer if name in self.nonlocals else None
        while scope is not None:
            if name in scope.locals:
                return scope.names_of(name)
            scope = scope.outer
        return self.locals

    def place(self, node: ast.AST) -> SourceSpan:
        if not isinstance(node, ast.expr | ast.stmt):
            return SourceSpan(self.source.file, 1, 0, 1, 1)
        end_line, end_column = node.end_lineno or node.lineno, node.end_col_offset or node.col_offset + 1
        return SourceSpan(self.source.file, node.lineno, node.col_offset, end_line, end_column)

    def error(self, kind: str, message: str, node: ast.AST, hint: str = "", notes: Iterable[str] = ()) -> ScenicError:
        """Return an error at `node`."""
        return self.placed(ScenicError(kind, message, hint=hint, notes=notes), node)

    def placed(self, error: ScenicError, node: ast.AST) -> ScenicError:
        """Give an error its place, unless it has one. A node that no text made leaves that to whoever is above."""
        if error.place is None and "lineno" in vars(node):
            error.place = self.place(node)
            error.source_line = self.source.line(error.place.line)
        return error


def near(name: str, names: Iterable[str]) -> str:
    """Return a hint with the nearest spelling, or nothing."""
    public = [candidate for candidate in names if not candidate.startswith("_")]
    same = [
        candidate for candidate in public if sorted(candidate.lower()) == sorted(name.lower())
    ]  # or two letters swapped
    close = same or difflib.get_close_matches(name, public, 1, 0.7)
    return f"did you mean '{close[0]}'?" if close else ""
