"""Values without operators: names, constants, strings, brackets with their content, calls, functions.

Read next: `syntax.operators`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from itertools import groupby
from typing import TypeVar

from scenic_lite.syntax import grammar
from scenic_lite.syntax.cursor import LOAD, Cursor
from scenic_lite.syntax.grammar import COMPARES, INFIX, PYTHON_KEYWORDS, SCENIC_KEYWORDS, SPECIFIER_WORDS, Level
from scenic_lite.syntax.lexer import Token, lex_part

Item = TypeVar("Item")

CONSTANTS = {"True": True, "False": False, "None": None}
_STRING = re.compile(r"(\w*)('''|\"\"\"|'|\")(.*)\2", re.DOTALL)
_ESCAPE = re.compile(
    r"\\(?:[\n\\'\"abfnrtv]|[0-7]{1,3}|x[0-9a-fA-F]{,2}|u[0-9a-fA-F]{,4}|U[0-9a-fA-F]{,8}|N(?:\{[^{}]*\})?)"
)
_TEXT = re.compile(r"(?:[^{}]|\{\{|\}\})+")  # text between the fields of an f-string


def atom(c: Cursor, token: Token) -> ast.expr:
    """Read a name, a constant, or a value in brackets; `token` is the next token."""
    kind, text = token.kind, token.text
    if kind == "name":
        if text in PYTHON_KEYWORDS or text in SCENIC_KEYWORDS:
            return keyword_value(c, token)
        c.advance()
        return c.at(token, ast.Name(text, LOAD))
    if kind == "number":
        c.advance()
        return c.at(token, ast.Constant(number(c, token)))
    if kind == "string":
        return strings(c)
    if text == "{":
        return dictionary(c, token)
    if text == "(" or text == "[":
        return display(c, token)
    if text == "...":
        c.fail('"..." is not a value', 'write "pass" where nothing is done')
    text = f"{c.peek(-2).text} end" if kind == "newline" and c.index > 1 else text
    c.missing("a value", grammar.NO_VALUE.get(f"{c.previous.text} {text}", "") or grammar.NO_VALUE.get(text, ""))


def number(c: Cursor, token: Token) -> int | float:
    """Return the value of a number token."""
    text = token.text.lower()
    try:
        return float(text) if text[:2] != "0x" and ("." in text or "e" in text) else int(text, 0)
    except ValueError:
        c.fail("a whole number of more than 4300 digits", at=token, kind="budget")


def keyword_value(c: Cursor, token: Token) -> ast.expr:
    """Read a keyword that is a value, or a keyword of Scenic 3 that is a name in dialect 2."""
    text, following = token.text, c.peek()
    if text in ("async", "await", "yield"):
        c.refuse(text)
    if text in CONSTANTS:
        c.advance()
        return c.at(token, ast.Constant(CONSTANTS[text]))
    if text in c.keywords:
        c.fail(f'expected a value, found the word "{text}"', grammar.NO_VALUE.get(text, ""))
    if c.starts_value(following, "") and following.text not in INFIX:
        c.fail(f'unexpected "{text}"', grammar.NO_VALUE.get(text, ""))
    c.advance()
    return c.at(token, ast.Name(text, LOAD))


def strings(c: Cursor) -> ast.expr:
    """Read one or more adjacent strings: a Constant, or a JoinedStr if one of them is an f-string."""
    start = c.advance()
    pieces = [start]
    while c.token.kind == "string":
        pieces.append(c.advance())
    parts: list[str | ast.expr] = []
    formatted = False
    for piece in pieces:
        match = _STRING.fullmatch(piece.text)
        assert match is not None
        prefix = match[1].lower()
        if "b" in prefix:
            c.refuse("bytes", start)
        if "f" in prefix:
            formatted = True
            offset = c.source.offset(piece.line, piece.column)
            parts += fields(c, start, piece, "r" in prefix, offset + match.start(3), offset + match.end(3))
        else:
            parts.append(unescaped(c, piece, "r" in prefix, match[3]))
    values: list[ast.expr] = []
    for value, run in groupby(parts, lambda part: part if isinstance(part, ast.expr) else None):
        if isinstance(value, ast.expr):
            values.append(value)
        elif text := "".join(map(str, run)):
            values.append(c.at(start, ast.Constant(text)))
    if formatted:
        return c.at(start, ast.JoinedStr(values))
    return values[0] if values else c.at(start, ast.Constant(""))


def unescaped(c: Cursor, token: Token, raw: bool, text: str) -> str:
    """Return the text of a part of a string, with escape sequences replaced."""
    if raw or "\\" not in text:
        return text
    try:
        return _ESCAPE.sub(lambda match: match[0].encode().decode("unicode_escape"), text)
    except UnicodeDecodeError as error:
        c.fail(f'"{error.object.decode()}" is not a character', at=token)


def fields(c: Cursor, start: Token, token: Token, raw: bool, position: int, end: int) -> Iterator[str | ast.expr]:
    """Yield the texts and FormattedValues of an f-string with content program[position:end]."""
    program = c.source.text
    while position < end:
        if text := _TEXT.match(program, position, end):
            position = text.end()
            yield unescaped(c, token, raw, text[0].replace("{{", "{").replace("}}", "}"))
            continue
        line, column = c.source.line_and_column(position)
        brace = Token("operator", program[position], line, column, line, column + 1)
        if brace.text == "}":
            c.fail('a single "}" in an f-string', 'write "}}" for the character', at=brace)
        stop = end_of_value(program, position + 1, end)
        closing = program.find("}", stop, end)
        form = program[stop + 1 : closing]
        if closing < 0:
            c.fail('a "{" in an f-string is never closed', 'write "{{" for the character', at=brace)
        if program[stop] == "!" or "{" in form or not program[position + 1 : stop].strip():
            c.refuse("{", brace)
        value = field_value(c, lex_part(c.source, position + 1, stop))
        position = closing + 1
        spec = c.at(start, ast.JoinedStr([c.at(start, ast.Constant(form))])) if form else None
        yield c.at(start, ast.FormattedValue(value, -1, spec))


def end_of_value(text: str, start: int, end: int) -> int:
    """Return the end of the value in an f-string field: the first end sign outside brackets."""
    depth = 0
    for at in range(start, end):
        if depth == 0 and text[at] in ":!}" and text[at : at + 2] != "!=":
            return at
        depth += (text[at] in "([{") - (text[at] in ")]}")
    return end


def field_value(c: Cursor, tokens: list[Token]) -> ast.expr:
    """Read the value in an f-string field; a comma creates a tuple, as in brackets."""
    outer = (c.tokens, c.index, c.token, c.temporal)
    c.tokens, c.temporal = tokens, False
    c.go_to(0)
    try:
        value = row(c, element)
        if not c.ends_statement():
            c.fail(f'unexpected "{c.token.text}" in the f-string')
        return value
    finally:  # after a failed attempt at an operand, parsing resumes after the f-string
        c.tokens, c.index, c.token, c.temporal = outer


def opened(c: Cursor, temporal: bool = False) -> None:
    """Read an opening bracket; a requirement may continue inside it."""
    c.brackets.append((c.advance(), c.temporal))
    c.temporal = temporal


def close(c: Cursor, sign: str) -> None:
    """Read the closing bracket of the last open bracket."""
    opening, temporal = c.brackets[-1]
    if c.token.text != sign:
        hint = COMPARES if c.token.text == "=" else ""
        if c.token.kind in ("name", "number", "string"):
            hint = missing_operator_hint(c) or "is a comma missing?"
        where = "" if opening.line == c.token.line else f" of line {opening.line}"
        c.missing(f'"{sign}" to close the "{opening.text}"{where}', hint)
    c.advance()
    c.brackets.pop()
    c.temporal = temporal


def listed(c: Cursor, read: Callable[[Cursor], Item], closing: str = "") -> list[Item]:
    """Read `value, value, ...`; the list may be empty, or end with a comma before the closing sign."""
    items: list[Item] = []
    while not closing or c.token.text != closing:
        items.append(read(c))
        if not c.accept(","):
            break
    return items


def missing_operator_hint(c: Cursor) -> str:
    """Return a hint about a possibly missing operator or comma before the current token."""
    token, before = c.token, c.previous
    if token.text in grammar.FOREIGN:
        return grammar.FOREIGN[token.text]
    if before.text == ",":
        return "no comma stands between a class and its first specifier" if token.text in SPECIFIER_WORDS else ""
    if before.text in grammar.UNFINISHED:
        return grammar.UNFINISHED[before.text]
    if c.class_body and before.kind == "name":
        return f'a property is written "{before.text}: default"'
    return "is an operator or a comma missing?" if c.starts_value(token) else ""


def display(c: Cursor, start: Token) -> ast.expr:
    """Read `(value)`, a tuple, a list or a comprehension; a requirement continues in round brackets."""
    closing = ")" if start.text == "(" else "]"
    opened(c, c.temporal and closing == ")")
    values = listed(c, element, closing)
    single = len(values) == 1 and c.previous.text != ","
    node: ast.expr | None = None
    if single and begins_comprehension(c):
        node = (ast.GeneratorExp if closing == ")" else ast.ListComp)(values[0], comprehensions(c))
    elif closing == "]":
        node = ast.List(values, LOAD)
    elif not single:
        node = ast.Tuple(values, LOAD)
    close(c, closing)
    return not_starred(c, values[0]) if node is None else c.at(start, node)


def dictionary(c: Cursor, start: Token) -> ast.expr:
    """Read `{key: value, ...}` or a dictionary comprehension."""
    opened(c)
    pairs = listed(c, entry, "}")
    keys, values = [key for key, _ in pairs], [value for _, value in pairs]
    node: ast.expr = ast.Dict([*keys], values)
    if len(pairs) == 1 and begins_comprehension(c):
        node = ast.DictComp(keys[0], values[0], comprehensions(c))
    close(c, "}")
    return c.at(start, node)


def entry(c: Cursor) -> tuple[ast.expr, ast.expr]:
    """Read `key: value` of a dictionary."""
    first = c.previous
    if c.token.text == "**":
        c.refuse("**")
    key = element(c)
    if first.text == "{" and c.token.text != ":":
        if c.token.text in (",", "}") or begins_comprehension(c):
            c.refuse("set" if c.token.text != "for" else "set comprehension", first)
        close(c, "}")  # raises the error about the missing part
    c.expect(":", "after the key of the dictionary")
    return key, c.expression()


def element(c: Cursor) -> ast.expr:
    """Read `*operation` or an expression."""
    start = c.token
    if start.text == "*":
        c.advance()
        return c.at(start, ast.Starred(c.operation(Level.SEE), LOAD))
    value = c.expression()
    if c.token.text == ":=":
        c.refuse(":=")
    return value


def item(c: Cursor) -> ast.expr:
    """Read `*operation` or `expression`."""
    return element(c) if c.token.text == "*" else c.expression()


def row(c: Cursor, read: Callable[[Cursor], ast.expr] = item) -> ast.expr:
    """Read `value [, value]*`, with stars allowed; a comma creates a tuple."""
    start = c.token
    first = read(c)
    if c.token.text != ",":
        return not_starred(c, first)
    values = [first]
    while c.accept(","):
        word = c.is_name(c.token) and c.token.text in SCENIC_KEYWORDS  # a Scenic 3 keyword, a name in dialect 2
        if not c.starts_value(c.token, "([{-+~*") and not word:
            break
        values.append(read(c))
    return c.at(start, ast.Tuple(values, LOAD))


def not_starred(c: Cursor, value: ast.expr) -> ast.expr:
    """Return a single value, which must not be starred."""
    if isinstance(value, ast.Starred):
        c.fail("a starred expression cannot stand alone", at=value)
    return value


def begins_comprehension(c: Cursor) -> bool:
    """Return whether `for` follows."""
    if c.token.text == "async":
        c.refuse("async")
    return c.token.text == "for"


def comprehensions(c: Cursor) -> list[ast.comprehension]:
    """Read `for targets in operation [if condition]`, once or more."""
    clauses = []
    while begins_comprehension(c):
        c.advance()
        target = targets(c)
        c.expect("in", "after the variable of the comprehension")
        values = c.operation(Level.OR)
        conditions = []
        while c.accept("if"):  # no `if else`
            conditions.append(c.operation(Level.OR))
        clauses.append(ast.comprehension(target, values, conditions, 0))
        c.check_chain(len(clauses), '"for"')
    return clauses


def targets(c: Cursor) -> ast.expr:
    """Read the targets of a `for`."""
    return c.stored(row(c, lambda c: element(c) if c.token.text == "*" else c.operation(Level.SEE)))


def arguments(c: Cursor) -> tuple[list[ast.expr], list[ast.keyword]]:
    """Read `(value, *values, name=value)`."""
    opening = c.token
    opened(c)
    values: list[ast.expr] = []
    keywords: list[ast.keyword] = []
    generator: ast.expr | None = None
    while c.token.text != ")":
        start = c.token
        if start.text == "**":
            c.refuse("**")
        if start.kind == "name" and c.tokens[c.index + 1].text == "=":
            if start.text in PYTHON_KEYWORDS:
                c.fail(f'"{start.text}" is a word of the language and cannot be the name of an argument')
            c.go_to(c.index + 2)
            keywords.append(c.at(start, ast.keyword(start.text, c.expression())))
        else:
            if keywords and start.text != "*":
                c.fail("an argument without a name follows one with a name")
            if c.accept("*"):
                values.append(c.at(start, ast.Starred(c.expression(), LOAD)))
            else:
                values.append(element(c))
                if begins_comprehension(c):
                    generator = values[-1] = c.at(start, ast.GeneratorExp(values[-1], comprehensions(c)))
        if not c.accept(","):
            break
    close(c, ")")
    if generator is not None:
        if len(values) > 1 or keywords:
            c.fail("a generator beside other arguments needs brackets of its own", at=generator)
        c.at(opening, generator)  # in Python, the call's brackets belong to the generator
    return values, keywords


def index(c: Cursor) -> ast.expr:
    """Read `[index]`, `[a, b]`, `[low:high:step]`."""
    opened(c)
    start = c.token
    if start.text == "]":
        c.fail("an index is missing between the brackets")
    value: ast.expr | None = None if start.text == ":" else row(c, element)
    if c.token.text == ":":
        bounds: list[ast.expr | None] = [value, None, None]
        for k in (1, 2):
            if c.accept(":") and c.token.text not in (":", "]"):
                bounds[k] = c.expression()
        value = c.at(start, ast.Slice(*bounds))
    close(c, "]")
    assert value is not None
    return value


def bracketed_parameters(c: Cursor, owner: str) -> ast.arguments:
    """Read `(parameters)`."""
    if c.token.text != "(":
        c.missing(f'"(" after {owner}', 'write "()" if it takes nothing')
    opened(c)
    signature = parameters(c, ")")
    close(c, ")")
    return signature


def condition(c: Cursor) -> ast.expr:
    """Read a condition, which cannot begin with an instance; `=` is a frequent mistake."""
    c.asks_truth = True
    value = element(c)
    if c.token.text == "=":
        c.fail('"=" assigns and cannot stand in a condition', COMPARES)
    return value


def parameters(c: Cursor, closing: str) -> ast.arguments:
    """Read `a, b=1, *rest`, up to the closing sign; parameters in brackets may have an `: annotation`."""
    signature = ast.arguments([], [], None, [], [], None, [])
    names: set[str] = set()
    while c.token.text != closing:
        if c.token.text == "**" or signature.vararg is not None:
            c.refuse("**" if c.token.text == "**" else "* parameter")
        if c.accept("*"):
            signature.vararg = parameter(c, closing, names)
        else:
            name = parameter(c, closing, names)
            default = c.expression() if c.accept("=") else None
            if default is None and signature.defaults:
                c.fail("a parameter without a default follows one with a default", at=name)
            signature.args.append(name)
            signature.defaults += [default] if default else []
        if not c.accept(","):
            break
    return signature


def parameter(c: Cursor, closing: str, names: set[str]) -> ast.arg:
    """Read `name [: annotation]`; a duplicate name is an error."""
    start = c.name("a parameter")
    if start.text in names:
        c.fail(f'the parameter "{start.text}" occurs twice', at=start)
    names.add(start.text)
    annotation = c.expression() if closing == ")" and c.accept(":") else None
    return c.at(start, ast.arg(start.text, annotation))
