"""The tables of operators: what they are called, how tightly they bind, which node they make.

The levels are those of the Scenic 3 grammar, Python's included. Read next: `parser_expressions`, which climbs them.
"""

from __future__ import annotations

import ast
from typing import NamedTuple

# Loosest first. UNTIL and IMPLIES exist in `require` alone.
UNTIL, IMPLIES, OR, AND, NOT, COMPARE, SEE, ALONG, RELATIVE, AT, PREFIX, SUM, TERM, UNARY = range(14)


class Infix(NamedTuple):
    """An operator between two values: its words, how tightly it binds, how its node is made."""

    words: tuple[str, ...]
    level: int
    how: str  # which of parser_expressions.CONTINUATIONS reads what follows
    node: ast.operator | ast.cmpop | ast.boolop | None = None


PYTHON_OPERATORS = (
    Infix(("or",), OR, "logic", ast.Or()),
    Infix(("and",), AND, "logic", ast.And()),
    Infix(("<",), COMPARE, "comparison", ast.Lt()),
    Infix((">",), COMPARE, "comparison", ast.Gt()),
    Infix(("<=",), COMPARE, "comparison", ast.LtE()),
    Infix((">=",), COMPARE, "comparison", ast.GtE()),
    Infix(("==",), COMPARE, "comparison", ast.Eq()),
    Infix(("!=",), COMPARE, "comparison", ast.NotEq()),
    Infix(("in",), COMPARE, "comparison", ast.In()),
    Infix(("not", "in"), COMPARE, "comparison", ast.NotIn()),
    Infix(("is", "not"), COMPARE, "comparison", ast.IsNot()),
    Infix(("is",), COMPARE, "comparison", ast.Is()),
    Infix(("|",), SEE, "arithmetic", ast.BitOr()),
    Infix(("^",), ALONG, "arithmetic", ast.BitXor()),
    Infix(("&",), RELATIVE, "arithmetic", ast.BitAnd()),
    Infix(("<<",), AT, "arithmetic", ast.LShift()),
    Infix((">>",), AT, "arithmetic", ast.RShift()),
    Infix(("+",), SUM, "arithmetic", ast.Add()),
    Infix(("-",), SUM, "arithmetic", ast.Sub()),
    Infix(("*",), TERM, "arithmetic", ast.Mult()),
    Infix(("/",), TERM, "arithmetic", ast.Div()),
    Infix(("//",), TERM, "arithmetic", ast.FloorDiv()),
    Infix(("%",), TERM, "arithmetic", ast.Mod()),
    Infix(("@",), TERM, "arithmetic", ast.MatMult()),
)
SCENIC_OPERATORS = (
    Infix(("can", "see"), SEE, "words"),
    Infix(("intersects",), SEE, "words"),
    Infix(("visible", "from"), SEE, "words"),
    Infix(("not", "visible", "from"), SEE, "words"),
    Infix(("offset", "along"), ALONG, "along"),
    Infix(("relative", "to"), RELATIVE, "words"),
    Infix(("offset", "by"), RELATIVE, "words"),
    Infix(("at",), AT, "words"),
    Infix(("deg",), TERM, "degrees"),
)
TEMPORAL_OPERATORS = (
    Infix(("until",), UNTIL, "words"),
    Infix(("implies",), IMPLIES, "words"),
)


def _by_first_word(operators: tuple[Infix, ...]) -> dict[str, tuple[Infix, ...]]:
    table: dict[str, tuple[Infix, ...]] = {}
    for operator in operators:
        first = operator.words[0]
        table[first] = (*table.get(first, ()), operator)
    return table


PYTHON_TABLE = _by_first_word(PYTHON_OPERATORS)
SCENIC_TABLE = _by_first_word(PYTHON_OPERATORS + SCENIC_OPERATORS)
TEMPORAL_TABLE = _by_first_word(PYTHON_OPERATORS + SCENIC_OPERATORS + TEMPORAL_OPERATORS)

SIGNS: dict[str, type[ast.unaryop]] = {"+": ast.UAdd, "-": ast.USub, "~": ast.Invert}

# Word operators before a value, by their words: the node's name, and the word before the second operand.
PREFIXES: dict[tuple[str, ...], tuple[str, str]] = {
    ("distance", "from"): ("distance", "to"),
    ("distance", "to"): ("distance", "from"),
    ("distance", "past"): ("distance past", "of"),
    ("angle", "from"): ("angle", "to"),
    ("angle", "to"): ("angle", "from"),
    ("relative", "heading", "of"): ("relative heading of", "from"),
    ("relative", "position", "of"): ("relative position of", "from"),
    ("apparent", "heading", "of"): ("apparent heading of", "from"),
    ("front", "of"): ("front of", ""),
    ("back", "of"): ("back of", ""),
    ("left", "of"): ("left of", ""),
    ("right", "of"): ("right of", ""),
    ("front", "left", "of"): ("front left of", ""),
    ("front", "right", "of"): ("front right of", ""),
    ("back", "left", "of"): ("back left of", ""),
    ("back", "right", "of"): ("back right of", ""),
}
PREFIX_WORDS: dict[str, list[tuple[str, ...]]] = {}
for _words in PREFIXES:
    PREFIX_WORDS.setdefault(_words[0], []).append(_words)

# Words that begin something else than a name; everything else goes straight to `power`.
SPECIAL = frozenset({"not", "lambda", "visible", "follow", "initial", *PREFIX_WORDS})
TEMPORAL = frozenset({"always", "eventually", "next"})

# Words that may follow a value without being a specifier.
INFIX_WORDS = frozenset(word for word in TEMPORAL_TABLE if word.isalpha())
