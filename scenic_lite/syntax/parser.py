"""Program text to syntax tree: a hand-written recursive descent over the tokens, for Scenic 2 and 3 in one grammar.

Each file is one layer of a class, in this order: `parser_cursor` walks the tokens; `parser_strings`,
`parser_specifiers`, `parser_displays`, `parser_calls` and `parser_expressions` read values; `parser_statements`,
`parser_patterns`, `parser_blocks` and `parser_scenic` read statements. No text is ever given to Python's compiler.
Read next: `syntax.nodes`, for what comes out, and `syntax.check`, for the rules that need the whole tree.
"""

from __future__ import annotations

import ast

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.lexer import Source, lex
from scenic_lite.syntax.operators import PYTHON_TABLE, SCENIC_TABLE
from scenic_lite.syntax.scenic import ScenicStatements


class Parser(ScenicStatements):
    """All productions together."""

    def __init__(self, source: Source, dialect: int) -> None:
        super().__init__(source, lex(source), dialect)
        self.operators = SCENIC_TABLE if dialect else PYTHON_TABLE


def parse(text: str, file: str = "<program>", dialect: int = 2) -> ast.Module:
    """Parse a program into Python's `ast` nodes and those of `nodes`.

    Dialect 2 or 3 is the version of Scenic that decides where they differ; 0 is Python alone, whose trees equal those
    of `ast.parse`. Columns count characters, not bytes as Python's do.

    Raises ScenicError: `syntax`, or `budget` for a program that is too long or nested too deeply.
    """
    if dialect not in (0, 2, 3):
        raise ValueError(f"dialect must be 2 or 3 (or 0 for Python alone), not {dialect!r}")
    parser = Parser(Source(text, file), dialect)
    try:
        return parser.module()
    except RecursionError:
        error: ScenicError = parser.error("the program is nested too deeply here", kind="budget")
    raise error
