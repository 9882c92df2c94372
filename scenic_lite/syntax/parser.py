"""Program text to syntax tree: a hand-written recursive descent over the tokens, for Scenic 2 and 3 in one grammar.

Each file reads what the next ones are made of: `cursor` walks the tokens; `specifiers`, `expressions` and `operators`
read values; `statements` and `scenic` read statements. No text is ever given to Python's compiler.
Read next: `syntax.nodes`, for what comes out, and `syntax.check`, for the rules that need the whole tree.
"""

from __future__ import annotations

import ast
import keyword
import re
from functools import partial

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax.cursor import Cursor
from scenic_lite.syntax.lexer import Source, tokens
from scenic_lite.syntax.operators import INFIX, PREFIXES, expression, operation
from scenic_lite.syntax.scenic import BLOCKS, STATEMENTS
from scenic_lite.syntax.statements import module

DIALECTS = (2, 3)
MARKER = re.compile(r"#!?\s*(?:scenic|dialect)\s*:\s*(?P<version>\d[^\s;,]*)\s*(?:[;,].*)?$", re.IGNORECASE)


def parse(text: str, file: str = "<program>", dialect: int = 2) -> ast.Module:
    """Parse a program into Python's `ast` nodes and those of `nodes`.

    Dialect 2 or 3 is the version of Scenic that decides where they differ. Columns count characters, not bytes as
    Python's do. Raises ScenicError: `syntax`, `unsupported`, or `budget` for a program too long or nested too deeply.
    """
    if dialect not in DIALECTS:
        raise ValueError(f"dialect must be 2 or 3, not {dialect!r}")
    c = Cursor(Source(text, file), dialect)
    c.operators, c.prefixes, c.statements, c.blocks = INFIX, PREFIXES, STATEMENTS, BLOCKS
    c.expression, c.operation = partial(expression, c), partial(operation, c)
    try:
        return module(c)
    except RecursionError:
        error: ScenicError = c.source.error("the program is nested too deeply here", c.place(), kind="budget")
    raise error


def dialect_of(text: str, file: str, wanted: int | None) -> int:
    """Return 2 or 3: what is wanted; else a first line like `# scenic: 3`; else 3 if `new` stands before a name, or 2.

    Raises ValueError for a wanted dialect that does not exist, ScenicError for a first line that names one.
    """
    if wanted is not None:
        if wanted not in DIALECTS:
            raise ValueError(f"dialect must be one of {DIALECTS}, not {wanted!r}")
        return wanted
    first = text.removeprefix("\ufeff").split("\n", 1)[0].rstrip()
    match = MARKER.match(first)
    if match is None:
        return 3 if makes_instances_with_new(text, file) else 2
    version = match["version"].split(".")[0]
    if version not in ("2", "3"):
        message = f"there is no dialect {match['version']} of Scenic here"
        place = SourceSpan(file, 1, match.start("version"), 1, match.end("version"))
        raise ScenicError("syntax", message, place, hint="write # scenic: 2 or # scenic: 3", source_line=first)
    return int(version)


def makes_instances_with_new(text: str, file: str) -> bool:
    """Return whether the word `new` is used as Scenic 3 does: before the name of a class, and not as a name itself."""
    if "new" not in text:
        return False
    found = tokens(text, file)
    for before, word, after in zip([None, *found], found, found[1:], strict=False):
        follows_dot = before is not None and before.text == "."
        if word.text == "new" and after.kind == "name" and not keyword.iskeyword(after.text) and not follows_dot:
            return True
    return False
