"""The exception of the language: the error, its place, and a hint for its correction.

Read next: `syntax.lexer`, which raises the first such errors.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

SHOWN = 20  # maximum number of further errors in a message
WIDEST = 160  # maximum number of characters of a source line in a message


class SourceSpan(NamedTuple):
    """A span of program text. Lines count from 1, columns from 0 (as in Python's `ast`)."""

    file: str
    line: int
    column: int
    end_line: int
    end_column: int


class ScenicError(Exception):
    """A program that cannot be loaded, compiled or sampled.

    `kind` is one of `syntax`, `name`, `type`, `value`, `specifier`, `random-control-flow`, `rejection`,
    `budget`, `import`, `unsupported`, or `warning` for a probable mistake. `str()` gives
    `file:line:column: message (hint)`, then the source line with the error underlined. Printed columns count from 1.
    `also` holds further errors found at the same time; `str()` appends them.
    """

    def __init__(
        self,
        kind: str,
        message: str,
        place: SourceSpan | None = None,
        *,
        hint: str = "",
        source_line: str = "",
        notes: Iterable[str] = (),
    ) -> None:
        super().__init__(kind, message)  # the constructor's arguments, so that errors can be pickled
        self.kind = kind
        self.message = message
        self.place = place
        self.hint = hint
        self.source_line = source_line
        self.notes = tuple(notes)
        self.also: tuple[ScenicError, ...] = ()

    @property
    def line(self) -> int | None:
        """Line of the error, from 1."""
        return self.place.line if self.place else None

    @property
    def column(self) -> int | None:
        """Column of the error, from 1."""
        return self.place.column + 1 if self.place else None

    def __str__(self) -> str:
        head = self.message + (f" ({self.hint})" if self.hint else "")
        lines = [head if self.place is None else f"{self.place.file}:{self.line}:{self.column}: {head}"]
        if self.place is not None and self.source_line:
            lines += self._underlined(self.place)
        return harmless("\n".join([*lines, *self.notes, *self._others()]))

    def _others(self) -> list[str]:
        more = len(self.also) - SHOWN
        return [*map(str, self.also[:SHOWN]), *([f"and {more} errors more"] if more > 0 else [])]

    def _underlined(self, place: SourceSpan) -> list[str]:
        text = self.source_line.rstrip("\n")
        end = place.end_column if place.end_line == place.line else len(text)
        start = max(0, place.column - WIDEST // 2) if len(text) > WIDEST else 0  # first column of the visible part
        text = text[start : start + WIDEST]
        # The margin keeps tabs, so that the carets align with the text for every tab width.
        margin = "".join(c if c == "\t" else " " for c in text[: place.column - start])
        carets = "^" * max(1, min(end, start + len(text)) - place.column)
        return ["    " + text, "    " + margin + carets]


class UnsetVariable(ScenicError):
    """A function reads a variable before the variable has a value."""


def harmless(text: str) -> str:
    """Return a text without terminal control sequences, which an untrusted program may contain."""
    return "".join(each if each.isprintable() or each in "\n\t" else "\ufffd" for each in text)
