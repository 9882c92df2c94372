"""What an error says beside what is wrong: what was meant, perhaps, or what to write instead. Tables by the culprit.

Read next: `syntax.lexer`.
"""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterable

# Forms of Python that the language leaves out: the message, and what to write instead.
REFUSED = {
    "%": ("`%` formats no text", 'write f"{value}", or f"{value:.2f}" with two digits'),
    "!": ("`!` in an f-string is not supported", 'write "{value}" or "{value:.2f}"'),
    "{": ("a value in the format of an f-string is not supported", 'write "{value}" or "{value:.2f}"'),
    "async": ("`async` is not supported", 'functions are written "def name(...):"'),
    "await": ("`await` is not supported", '"wait" lets a step pass, and "do" runs a behavior'),
    "bytes": ("bytes are not supported", 'write a text, without the "b"'),
    "decorator": ("decorators are not supported", 'call the function: "name = decorator(name)"'),
    "else": ("`else` after `try` is not supported", "write its statements at the end of the block above"),
    "except": ("`except` is not supported", 'ask with "if" before what may fail'),
    "finally": ("`finally` is not supported", 'write its statements behind the "try"'),
    "match": ("`match` is not supported", 'write "if", "elif" and "else"'),
    "raise": ("`raise` is not supported", 'write "assert condition, message"'),
    "set": ("sets are not supported", 'write a tuple, "(a, b)", or a list, "[a, b]"'),
    "set comprehension": ("sets are not supported", 'write a list, "[... for ...]"'),
    "with": ("`with` blocks are not supported", "a program opens no files"),
    "yield": ("`yield` is not supported", 'an action is taken with "take", and a function returns a list'),
}

# What other languages, or other spellings, would write.
FOREIGN = {
    "behaviour": 'it is spelt "behavior"',
    "function": 'functions are written "def name(...):"',
    "elseif": 'it is written "elif"',
    "elsif": 'it is written "elif"',
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
    "\u00a0": "it looks like a blank, but is none",
    "!": 'negation is written "not"',
    "&": 'it is written "and"',
    "?": 'a choice is written "a if condition else b"',
}

COMPARES = '"==" compares'
# Words, and signs after a sign, where a value should be.
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
# Words after which something should follow that does not.
UNFINISHED = {
    "relative": 'write "relative heading of X"',
    "apparent": 'write "apparent heading of X"',
    "distance": 'write "distance from X to Y"',
    "angle": 'write "angle from X to Y"',
    "print": 'a function is called with brackets: "print(...)"',
}

_STATEMENTS = """
abort behavior class compose def do elif else except finally for from if import interrupt invariant model monitor mutate
override param precondition raise record require return scenario setup simulator take terminate try wait while with
"""
STATEMENT_WORDS = frozenset(_STATEMENTS.split())

_KINDS = {
    ast.Call: "a call",
    ast.Constant: "a constant",
    ast.Compare: "a comparison",
    ast.BinOp: "an operation",
    ast.UnaryOp: "an operation",
    ast.BoolOp: "an operation",
    ast.JoinedStr: "a string",
    ast.Lambda: "a lambda",
    ast.IfExp: "a conditional expression",
    ast.Dict: "a dictionary",
    ast.GeneratorExp: "a comprehension",
    ast.ListComp: "a comprehension",
    ast.Starred: "a starred expression",
    ast.NamedExpr: "an assignment",
}


def nearest(word: str, candidates: Iterable[str]) -> str:
    """Return the hint 'did you mean "..."?', or nothing when no candidate is near."""
    found = difflib.get_close_matches(word, sorted(candidates), 1, 0.7)
    return f'did you mean "{found[0]}"?' if found else ""


def statement_hint(word: str) -> str:
    """Return which statement a first word was perhaps meant to begin."""
    return FOREIGN.get(word, "") or nearest(word, STATEMENT_WORDS)


def kind_of(node: ast.expr) -> str:
    """Return what an expression is, in words."""
    if isinstance(node, ast.Constant) and isinstance(node.value, bool | None):
        return str(node.value)
    return _KINDS.get(type(node), "this")
