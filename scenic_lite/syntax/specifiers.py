"""Instances: `[new] Class specifier, specifier, ...`, on one line or several.

After a class without `new` most specifiers leave no doubt (`Name on R`, `Name with P V`); those that might also be
operators are read in `operators`. Read next: `syntax.expressions`.
"""

from __future__ import annotations

import ast
import difflib
import re
from typing import NamedTuple, NoReturn

from scenic_lite.syntax.cursor import LOAD, Cursor
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import New, Specifier


class Form(NamedTuple):
    """How words and values follow each other: the words, whether a value follows, and the words before further ones."""

    text: str
    words: tuple[str, ...]
    value: bool
    parts: tuple[tuple[str, bool], ...]  # (word, must it stand there?)


def forms(rows: str) -> dict[str, list[Form]]:
    """Return the forms that are written like `beyond X by D [from Y]`, by their first word."""
    table: dict[str, list[Form]] = {}
    for row in rows.strip().splitlines():
        words, value, rest = re.fullmatch(r"([a-z ]*[a-z])( [A-Z])?((?: \[?[a-z]+ [A-Z]\]?)*)", row).groups()  # type: ignore[union-attr]
        parts = tuple((word, not bracket) for bracket, word in re.findall(r"(\[?)([a-z]+) [A-Z]", rest))
        form = Form(row, tuple(words.split()), value is not None, parts)
        table.setdefault(form.words[0], []).append(form)
    return table


FORMS = forms("""
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
""")
SPECIFIER_WORDS = frozenset(FORMS) | {"with"}
SPECIFIER_NAMES = sorted({" ".join(form.words) for rows in FORMS.values() for form in rows} | SPECIFIER_WORDS)
LIST_OF_SPECIFIERS = (
    "specifiers are: with, at, in, on, left of, right of, ahead of, behind, beyond, offset by, offset along, facing, "
    "facing toward, facing away from, apparently facing, following, visible"
)
# The first words of those that might be operators: `Name at V` and the like.
OPERATOR_WORDS = frozenset({"at", "in", "offset", "visible", "not"})


def new_instance(c: Cursor) -> ast.expr:
    """Read `new Class [specifiers]`."""
    start = c.advance()
    if not c.is_plain_name(c.token):
        c.missing('a class name after "new"', 'write "new Class at X"' if c.token.kind in ("newline", "end") else "")
    return instance(c, start, class_name(c))


def class_name(c: Cursor) -> ast.expr:
    """Read `Name` or `module.Name`."""
    start = c.name("a class name")
    name: ast.expr = c.at(start, ast.Name(start.text, LOAD))
    while c.token.text == "." and c.is_name(c.peek()):
        c.advance()
        name = c.at(start, ast.Attribute(name, c.advance().text, LOAD))
    return name


def instance(c: Cursor, start: Token, cls: ast.expr) -> ast.expr:
    """Read the specifiers after a class, if any."""
    specifiers: list[Specifier] = []
    if begins_specifier(c):
        specifiers = more_specifiers(c, [specifier(c)])
    elif c.is_name(c.token) and c.token.text not in c.operators:
        unknown_specifier(c)
    return c.at(start, New(cls, specifiers))


def starts_instance(c: Cursor) -> bool:
    """Return whether, after a name, a specifier follows that cannot be an operator."""
    token = c.token
    if token.kind != "name" or token.text not in SPECIFIER_WORDS or c.in_target:
        return False
    if token.text == "with":
        return c.is_name(c.peek())
    form = next_form(c)
    if form is None or form.words[0] not in OPERATOR_WORDS:
        return form is not None
    # `visible` and `not visible` without `from` are no operators.
    return form.words[-1] == "visible" and c.peek(len(form.words)).text != "from"


def more_specifiers(c: Cursor, found: list[Specifier]) -> list[Specifier]:
    """Read `, specifier` as often as it comes; a line may end after a comma if the next one is indented."""
    while True:
        if begins_specifier(c):
            c.fail(f'expected a comma before the specifier "{c.token.text}"')
        if c.token.text != ",":
            return found
        index, indents = c.index, c.specifier_indents
        comma = c.advance()
        if c.brackets == 0 and c.token.kind == "newline":
            next_line(c, comma)
        if begins_specifier(c):
            found.append(specifier(c))
            continue
        if is_misspelt(c):
            unknown_specifier(c)
        # After a comma outside of brackets another instance makes a tuple.
        tuple_of_instances = c.token.kind == "name" and (c.token.text == "new" or c.token.text[0].isupper())
        if c.specifier_indents or (c.brackets == 0 and not tuple_of_instances):
            c.missing("a specifier after the comma", 'a place is written "3 @ 4"' if c.token.kind == "number" else "")
        c.specifier_indents = indents
        c.go_back(index)
        return found


def next_line(c: Cursor, comma: Token) -> None:
    """Go to the next line, which must be indented deeper than the statement."""
    c.advance()
    while c.token.kind in ("indent", "dedent"):
        c.specifier_indents += 1 if c.token.kind == "indent" else -1
        if c.specifier_indents <= 0:
            break
        c.advance()
    if c.specifier_indents <= 0:
        hint = "take the comma away, or indent the next specifier"
        c.fail("a comma ends the line, but no indented specifier follows", hint, at=comma)


def begins_specifier(c: Cursor) -> bool:
    """Return whether a specifier comes next."""
    token = c.token
    if token.kind != "name" or token.text not in SPECIFIER_WORDS:
        return False
    return token.text == "with" or next_form(c) is not None


def next_form(c: Cursor) -> Form | None:
    """Return the form whose words come next, and after them what it needs."""
    for form in FORMS.get(c.token.text, ()):
        if c.sees(*form.words):
            following = c.peek(len(form.words))
            if len(form.words) == 1 and form.value and following.text in (".", "=", ")", "]", "}", ",", ":"):
                continue
            if form.words[0] == "facing" and len(form.words) > 1 and not c.starts_value(following, "([-"):
                continue
            return form
    return None


def specifier(c: Cursor) -> Specifier:
    """Read one specifier."""
    start = c.token
    if start.text == "with":
        return with_property(c)
    form = next_form(c)
    assert form is not None
    c.skip(len(form.words))
    name = " ".join(form.words)
    arguments: list[ast.expr | None] = [specifier_value(c, name)] if form.value else []
    for word, needed in form.parts:
        if c.accept(word):
            arguments.append(specifier_value(c, f"{name} ... {word}"))
        elif needed:
            c.missing(f'"{word}" in "{name}"', f'write "{form.text}"')
        else:
            arguments.append(None)
    node = c.at(start, Specifier(name, arguments))
    if c.token.kind == "number" and ("by", False) in form.parts:
        c.fail(f'expected "by" before the distance of "{name}"', f'write "{name} X by {c.token.text}"')
    return node


def with_property(c: Cursor) -> Specifier:
    """Read `with property value`."""
    start = c.advance()
    word = c.name("a property name")
    if c.token.text in ("=", ":"):
        c.fail(f'"{c.token.text}" between a property and its value', f'write "with {word.text} value"')
    name = c.at(word, ast.Constant(word.text))
    return c.at(start, Specifier("with", [name, specifier_value(c, f"with {word.text}")]))


def specifier_value(c: Cursor, name: str, level: int | None = None) -> ast.expr:
    """Read the value after the words of a specifier: an expression, or operators of a level."""
    if name == "facing" and c.token.text in ("to", "at", "towards") and c.starts_value(c.peek(), ""):
        c.fail(f'unknown specifier "facing {c.token.text}"', 'did you mean "facing toward"?')
    if c.token.kind in ("newline", "end") or c.token.text in (",", ")"):
        c.missing(f'a value after "{name}"')
    return c.expression() if level is None else c.operation(level)


def is_misspelt(c: Cursor) -> bool:
    """Return whether two words stand side by side that no expression begins with."""
    token, following = c.token, c.peek()
    if not c.is_plain_name(token) or token.text in c.operators or token.text in c.prefixes:
        return False
    if following.kind in ("number", "string"):
        return True
    return c.is_plain_name(following) and following.text not in c.operators and following.text not in SPECIFIER_WORDS


def unknown_specifier(c: Cursor) -> NoReturn:
    """Report a word that is no specifier, with the nearest one that is."""
    c.fail(f'unknown specifier "{c.token.text}"', specifier_hint(c.token.text))


def specifier_hint(word: str) -> str:
    """Return the specifier that a word was perhaps meant to begin, or all there are."""
    close = difflib.get_close_matches(word, SPECIFIER_NAMES, 1, 0.7)
    if not close:
        return LIST_OF_SPECIFIERS
    whole = [" ".join(form.words) for form in FORMS.get(close[0], ())]  # of a first word such as "ahead"
    return f'did you mean "{close[0] if close[0] in whole or not whole else whole[0]}"?'
