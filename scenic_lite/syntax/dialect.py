"""Which Scenic a program is written in: as the caller says, as its first line says, or as its words tell.

Read next: `loader`.
"""

from __future__ import annotations

import keyword
import re

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax.lexer import tokens

DIALECTS = (2, 3)
MARKER = re.compile(r"#!?\s*(?:scenic|dialect)\s*:\s*(?P<version>\d[^\s;,]*)\s*(?:[;,].*)?$", re.IGNORECASE)


def dialect_of(text: str, file: str, wanted: int | None) -> int:
    """2 or 3: what is wanted; else a first line like `# scenic: 3`; else 3 if `new` stands before a name, or 2.

    Raises ValueError for a wanted dialect that does not exist, ScenicError for a first line that names one.
    """
    if wanted is not None:
        if wanted not in DIALECTS:
            raise ValueError(f"dialect must be one of {DIALECTS}, not {wanted!r}")
        return wanted
    marked = marked_dialect(text, file)
    if marked is not None:
        return marked
    return 3 if makes_instances_with_new(text, file) else 2


def marked_dialect(text: str, file: str) -> int | None:
    """The dialect that the first line names."""
    first = text.removeprefix("\ufeff").split("\n", 1)[0].rstrip()
    match = MARKER.match(first)
    if match is None:
        return None
    version = match["version"].split(".")[0]
    if version not in ("2", "3"):
        start, end = match.span("version")
        message = f"there is no dialect {match['version']} of Scenic here"
        place = SourceSpan(file, 1, start, 1, end)
        raise ScenicError("syntax", message, place, hint="write # scenic: 2 or # scenic: 3", source_line=first)
    return int(version)


def makes_instances_with_new(text: str, file: str) -> bool:
    """Whether the word `new` is used as Scenic 3 does: before the name of a class, and not as a name itself."""
    if "new" not in text:
        return False
    found = tokens(text, file)
    for before, word, after in zip([None, *found], found, found[1:], strict=False):
        if word.text != "new" or word.kind != "name" or after.kind != "name" or keyword.iskeyword(after.text):
            continue
        if before is None or before.text != ".":
            return True
    return False
