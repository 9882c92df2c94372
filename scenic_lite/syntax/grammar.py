"""Tables of the words of the language: keywords, operators, specifiers, unsupported forms, and hints for mistakes.

An example of a form is `left of X [by D]`: words, a value, and an optional second value.
Read next: `syntax.lexer`.
"""

from __future__ import annotations

import ast
import difflib
import keyword
import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

PYTHON_KEYWORDS = frozenset(keyword.kwlist)
# Words that dialect 3 reserves. In dialect 2 they are names in all places without a form that expects them.
SCENIC_KEYWORDS = frozenset({"at", "by", "do", "new", "of", "on", "require", "to", "until"})
_STATEMENTS = """
abort behavior class compose def do elif else except finally for from if import interrupt invariant model monitor mutate
override param precondition raise record require return scenario setup simulator take terminate try wait while with
"""
STATEMENT_WORDS = frozenset(_STATEMENTS.split())


# ---------------------------------------------------------------- forms
class Level:
    """Precedence of operators, lowest first, as in the grammar of Scenic 3; the first two exist only in `require`."""

    UNTIL, IMPLIES, OR, AND, NOT, COMPARE, SEE, ALONG, RELATIVE, AT, PREFIX, SUM, TERM, UNARY = range(14)


class Form(NamedTuple):
    """A sequence of words and values; operators between values have a level, and those of Python a node."""

    text: str
    name: str  # the first words
    words: tuple[str, ...]  # of the name
    value: bool  # whether a value follows the name
    parts: tuple[tuple[str, bool], ...]  # the words before further values, each with whether it is required
    level: int = 0
    node: ast.operator | ast.cmpop | ast.boolop | None = None


Forms = Mapping[str, list[Form]]  # forms by their first word


def form(text: str, level: int = 0, node: str = "") -> Form:
    """Parse a form such as `beyond X by D [from Y]`; `node` names a class of `ast`."""
    name, value, rest = re.fullmatch(r"([^A-Z[]*[^A-Z[ ])( [A-Z])?((?: \[?[a-z]+ [A-Z]\]?)*)", text).groups()  # type: ignore[union-attr]
    parts = tuple((word, not bracket) for bracket, word in re.findall(r"(\[?)([a-z]+) [A-Z]", rest))
    return Form(text, name, tuple(name.split()), value is not None, parts, level, vars(ast)[node]() if node else None)


def by_first_word(forms: Iterable[Form]) -> Forms:
    """Return forms by first word; of forms with the same first word, the earlier is tried first."""
    table: dict[str, list[Form]] = {}
    for form in forms:
        table.setdefault(form.words[0], []).append(form)
    return table


# Operators between two values, by level; operators of Python with the names of their nodes.
_INFIX = """
UNTIL until X
IMPLIES implies X
OR or: Or
AND and: And
COMPARE <: Lt, >: Gt, <=: LtE, >=: GtE, ==: Eq, !=: NotEq, in X: In, not in: NotIn, is not: IsNot, is: Is
SEE can see X, intersects X, visible from X, not visible from X, |: BitOr
ALONG offset along H by V, ^: BitXor
RELATIVE relative to X, offset by X, &: BitAnd
AT at X, <<: LShift, >>: RShift
SUM +: Add, -: Sub
TERM *: Mult, /: Div, //: FloorDiv, %: Mod, @: MatMult, deg
"""
INFIX = by_first_word(
    form(text, vars(Level)[level], node)
    for level, row in (line.split(" ", 1) for line in _INFIX.strip().splitlines())
    for text, _, node in (entry.partition(": ") for entry in row.split(", "))
)
SIGNS: dict[str, type[ast.unaryop]] = {"+": ast.UAdd, "-": ast.USub, "~": ast.Invert}
AUGMENTED: dict[str, ast.operator] = {"**=": ast.Pow()} | {
    f"{row.name}=": row.node for rows in INFIX.values() for row in rows if isinstance(row.node, ast.operator)
}

# Word operators before a value; their operands are in the order of the letters.
_MEASURES = """
distance from X [to Y]
distance to Y [from X]
distance past V [of X]
angle from X [to Y]
angle to Y [from X]
relative heading of H [from X]
relative position of X [from Y]
apparent heading of P [from V]
front left of X
front right of X
back left of X
back right of X
front of X
back of X
left of X
right of X
visible R
not visible R
follow F from V for D
initial scenario
"""
MEASURES = by_first_word(map(form, _MEASURES.strip().splitlines()))
# Operators that may be names: last word -> signs that may begin the operand.
NAMES = {"visible": "(", "follow": ""}

_SPECIFIERS = """
at V
in R
on R
contained in R
left of X [by D]
right of X [by D]
ahead of X [by D]
behind X [by D]
above X [by D]
below X [by D]
offset by V
offset along H by V
beyond X by D [from Y]
visible [from P]
not visible [from P]
following F [from V] for D
facing directly toward V
facing directly away from V
facing toward V
facing away from V
facing H
apparently facing H [from V]
"""
SPECIFIERS = by_first_word(map(form, _SPECIFIERS.strip().splitlines()))
SPECIFIER_WORDS = frozenset(SPECIFIERS) | {"with"}
LIST_OF_SPECIFIERS = (
    "specifiers are: with, at, in, on, left of, right of, ahead of, behind, beyond, offset by, offset along, facing, "
    "facing toward, facing away from, apparently facing, following, visible"
)
# Suggestions for misspelled specifiers; a first word maps to the whole name.
_SPELLINGS = {
    "with": "with",
    **{word: rows[0].name for word, rows in SPECIFIERS.items()},
    **{row.name: row.name for rows in SPECIFIERS.values() for row in rows},
}
# The first words of specifiers that might be operators, as in `Name at V`.
OPERATOR_WORDS = frozenset({"at", "in", "offset", "visible", "not"})


# ---------------------------------------------------------------- hints

BITS = frozenset({"&", "|", "^", "<<", ">>", "~"})
# Unsupported forms of Python: the message and the alternative.
REFUSED = {
    "%": ("`%` formats no text", 'write f"{value}", or f"{value:.2f}" with two digits'),
    "{": ("the {} of an f-string holds a value and a plain format", 'write "{value}" or "{value:.2f}"'),
    "**": ("`**` before a value or parameter is not supported", "write each name"),
    "* variable": ("`*` before a variable is not supported", "write first, rest = items[0], items[1:]"),
    "* parameter": ("a parameter behind `*` is not supported", "write it before"),
    ":=": ("`:=` is not supported", "assign on a line of its own"),
    "async": ("`async` is not supported", 'functions are written "def name(...):"'),
    "await": ("`await` is not supported", '"wait" lets a step pass, and "do" runs a behavior'),
    "bytes": ("bytes are not supported", 'write a text, without the "b"'),
    "@": ("decorators are not supported", 'call the function: "name = decorator(name)"'),
    "del": ("`del` is not supported", "make a list or dictionary without it"),
    "else": ("`else` after `try` is not supported", "write its statements at the end of the block above"),
    "except": ("`except` is not supported", 'ask with "if" before what may fail'),
    "finally": ("`finally` is not supported", 'write its statements behind the "try"'),
    "from .": ("dots before the name of a module are not supported", "write its name from the program's folder on"),
    "global": ("`global` is not supported", "return the new value, or set an attribute of an object"),
    "match": ("`match` is not supported", 'write "if", "elif" and "else"'),
    "nonlocal": ("`nonlocal` is not supported", "return the new value"),
    "raise": ("`raise` is not supported", 'write "assert condition, message"'),
    "set": ("sets are not supported", 'write a tuple, "(a, b)", or a list, "[a, b]"'),
    "set comprehension": ("sets are not supported", 'write a list, "[... for ...]"'),
    "type": ("types of variables are not supported", 'write "name = value"'),
    "with": ("`with` blocks are not supported", "a program opens no files"),
    "yield": ("`yield` is not supported", 'an action is taken with "take", and a function returns a list'),
    **dict.fromkeys(BITS, ("bit operators are not supported", 'truth values are joined by "and", "or" and "not"')),
}

# Words of other languages, or other spellings.
FOREIGN = {
    "behaviour": 'it is spelled "behavior"',
    "function": 'functions are written "def name(...):"',
    "elseif": 'it is written "elif"',
    "elsif": 'it is written "elif"',
    "while": 'write "until not condition"',
    "then": 'a ":" ends the condition',
    "parameter": 'parameters are written "param name = value"',
    "constraint": 'it is written "require condition"',
    "assume": 'it is written "require condition"',
    "degrees": 'angles are written "90 deg"',
    "degree": 'angles are written "90 deg"',
    "metres": "lengths have no unit",
    "meters": "lengths have no unit",
    "m": "lengths have no unit",
}
LOOKALIKES = {
    **dict.fromkeys("“”‘’", "quotes are written '...' or \"...\""),
    **dict.fromkeys("−–—", 'the minus sign is written "-"'),
    "×": 'multiplication is written "*"',
    "≤": 'it is written "<="',
    "≥": 'it is written ">="',
    "≠": 'it is written "!="',
    "°": 'degrees are written "deg"',
    "\u00a0": "it looks like a blank, but is another character",
    "!": 'negation is written "not"',
    "&": 'it is written "and"',
    "?": 'a choice is written "a if condition else b"',
}

COMPARES = '"==" compares'
PROPERTIES = ("behavior", "width", "length", "role", "team", "speed", "name", "requireVisible", "allowCollisions")
PLACED_BY = {"position": 'write "at x @ y"', "heading": 'write "facing 30 deg"'}
# Hints for a word, or a sign after another sign, in place of a value.
NO_VALUE = {
    "by": 'a distance follows its specifier: "ahead of X by 2"',
    "at": 'an instance is written "Class at X"',
    "else": 'a choice is written "a if condition else b"',
    "to": 'write "distance from X to Y"',
    "lambda": 'write "(lambda ...)"',
    "& &": 'it is written "and"',
    "| |": 'it is written "or"',
    "< >": '"!=" compares',
    "/ *": 'a comment begins with "#"',
    "/": 'a comment begins with "#"',
    "//": 'a comment begins with "#"',
    "=": COMPARES,
    "+ + end": 'write "+= 1"',
    "- - end": 'write "-= 1"',
}
DURATIONS = {"wait": 'write "wait for 3 steps" or "wait for 3 seconds"'}
# Hints for words without their required continuation.
UNFINISHED = {
    "relative": 'write "relative heading of X"',
    "apparent": 'write "apparent heading of X"',
    "distance": 'write "distance from X to Y"',
    "angle": 'write "angle from X to Y"',
    "print": 'a function is called with brackets: "print(...)"',
}


def nearest(word: str, candidates: Iterable[str]) -> str:
    """Return the hint 'did you mean "..."?' for the nearest spelling, or ""; a table gives replacements."""
    close = difflib.get_close_matches(word, sorted(candidates), 1, 0.7)
    if not close:
        return ""
    return f'did you mean "{candidates[close[0]] if isinstance(candidates, Mapping) else close[0]}"?'


def statement_hint(word: str) -> str:
    """Return a hint about the statement that a first word probably means."""
    return FOREIGN.get(word, "") or nearest(word, STATEMENT_WORDS)


def specifier_hint(word: str) -> str:
    """Return a hint about the specifier that a word probably means, or about the syntax of a property."""
    known = difflib.get_close_matches(word, PROPERTIES, 1, 0.8)
    hint = f'write "with {known[0]} ..."' if known else PLACED_BY.get(word, "") or nearest(word, _SPELLINGS)
    own = "" if word in SCENIC_KEYWORDS else f'write "with {word} ..." for a property; '
    return hint or own + LIST_OF_SPECIFIERS
