"""Values that are not operators: names, constants, strings, brackets with what is in them, calls, functions.

Read next: `syntax.operators`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from itertools import groupby

from scenic_lite.syntax.cursor import LOAD, PYTHON_KEYWORDS, SCENIC_KEYWORDS, STORE, Cursor, Level
from scenic_lite.syntax.hints import COMPARES, FOREIGN, NO_VALUE, UNFINISHED
from scenic_lite.syntax.lexer import Token, lex_field
from scenic_lite.syntax.specifiers import SPECIFIER_WORDS, new_instance

CONSTANTS = {"True": True, "False": False, "None": None}
_STRING = re.compile(r"(\w*)('''|\"\"\"|'|\")(.*)\2", re.DOTALL)
_ESCAPE = re.compile(
    r"\\(?:[\n\\'\"abfnrtv]|[0-7]{1,3}|x[0-9a-fA-F]{,2}|u[0-9a-fA-F]{,4}|U[0-9a-fA-F]{,8}|N(?:\{[^{}]*\})?)"
)
# Text between the fields of an f-string; the escape \N{...} of one that is not raw belongs to it.
_PLAIN = re.compile(r"[^{}]+|\{\{|\}\}")
_PLAIN_ESCAPED = re.compile(r"(?:\\N\{[^{}]*\}|\\.|[^{}\\])+|\{\{|\}\}", re.DOTALL)


def atom(c: Cursor, token: Token) -> ast.expr:
    """Read a name, a constant, or something in brackets; `token` is the next one."""
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
        c.fail('"..." is no value', 'write "pass" where nothing is done')
    text = f"{c.peek(-2).text} end" if kind == "newline" and c.index > 1 else text
    c.missing("a value", NO_VALUE.get(f"{c.previous.text} {text}", "") or NO_VALUE.get(text, ""))


def number(c: Cursor, token: Token) -> int | float:
    """Return the value of a number token."""
    text = token.text.lower()
    try:
        return float(text) if text[:2] != "0x" and ("." in text or "e" in text) else int(text, 0)
    except ValueError:
        c.fail("a whole number of more than 4300 digits", at=token, kind="budget")


def keyword_value(c: Cursor, token: Token) -> ast.expr:
    """Read a value that is a keyword, or a keyword of Scenic 3 used as a name in dialect 2."""
    text, following = token.text, c.peek()
    if text == "new" and (following.kind == "name" or c.dialect == 3):
        return new_instance(c)
    if text in ("async", "await", "yield"):
        c.refuse(text)
    if text in CONSTANTS:
        c.advance()
        return c.at(token, ast.Constant(CONSTANTS[text]))
    if text in c.keywords:
        c.fail(f'expected a value, found the word "{text}"', NO_VALUE.get(text, ""))
    if c.starts_value(following, "") and following.text not in c.operators:
        c.fail(f'unexpected "{text}"', NO_VALUE.get(text, ""))
    c.advance()
    return c.at(token, ast.Name(text, LOAD))


def strings(c: Cursor) -> ast.expr:
    """Read one or more strings side by side: a Constant, or a JoinedStr if one of them is an f-string."""
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
    """Return the text that a part of a string stands for."""
    if raw or "\\" not in text:
        return text
    try:
        return _ESCAPE.sub(lambda match: match[0].encode().decode("unicode_escape"), text)
    except UnicodeDecodeError as error:
        c.fail(f'"{error.object.decode()}" stands for no character', at=token)


def fields(c: Cursor, start: Token, token: Token, raw: bool, position: int, end: int) -> Iterator[str | ast.expr]:
    """Yield the texts and FormattedValues of an f-string, whose content is program[position:end]."""
    program, plain = c.source.text, _PLAIN if raw else _PLAIN_ESCAPED
    while position < end:
        match = plain.match(program, position, end)
        if match:
            position = match.end()
            yield match[0][0] if match[0] in ("{{", "}}") else unescaped(c, token, raw, match[0])
            continue
        if program[position] == "}":
            line, column = c.source.line_and_column(position)
            place = (line, column, line, column + 1)
            raise c.source.error('a single "}" in an f-string', place, 'write "}}" for the character')
        tokens, position = lex_field(c.source, position, end)
        if len(tokens) == 2:
            c.fail("an empty {} in an f-string", "put a value between the braces", at=tokens[0])
        value = field_value(c, tokens)
        form: ast.expr | None = None
        if program[position:end].startswith("!"):
            c.refuse("!", tokens[-1])
        if program[position:end].startswith(":"):
            first, position = position + 1, program.find("}", position, end)
            if "{" in program[first:position]:
                c.refuse("{", tokens[-1])
            parts = [c.at(start, ast.Constant(program[first:position]))] if first < position else []
            form = c.at(start, ast.JoinedStr(list(parts)))
        if program[position:end][:1] != "}":
            c.fail('a "{" in an f-string is never closed', 'write "{{" for the character', at=tokens[0])
        position += 1
        yield c.at(start, ast.FormattedValue(value, -1, form))


def field_value(c: Cursor, tokens: list[Token]) -> ast.expr:
    """Read the value in the field of an f-string; a comma makes a tuple, as in brackets."""
    outer = (c.tokens, c.index, c.token, c.temporal)
    c.tokens, c.temporal = tokens, False
    c.brackets += 1
    c.go_back(1)
    try:
        value = row(c, element)
        if c.token.kind != "end":
            c.fail(f'unexpected "{c.token.text}" in the f-string')
        return value
    finally:  # an operand that was only tried goes on behind the f-string
        c.tokens, c.index, c.token, c.temporal = outer
        c.brackets -= 1


def opened(c: Cursor, temporal: bool = False) -> bool:
    """Read an opening bracket, inside of which a requirement goes on or not; returns what `close` wants back."""
    c.brackets += 1
    c.advance()
    outer, c.temporal = c.temporal, temporal
    return outer


def close(c: Cursor, sign: str, opening: Token, outer: bool) -> None:
    """Read the closing bracket."""
    if c.token.text != sign:
        hint = COMPARES if c.token.text == "=" else ""
        if c.token.kind in ("name", "number", "string"):
            hint = missing_operator_hint(c) or "is a comma missing?"
        where = "" if opening.line == c.token.line else f" of line {opening.line}"
        c.missing(f'"{sign}" to close the "{opening.text}"{where}', hint)
    c.advance()
    c.brackets -= 1
    c.temporal = outer


def missing_operator_hint(c: Cursor) -> str:
    """Return what might be missing before the present token."""
    token, before = c.token, c.previous
    if token.text in FOREIGN:
        return FOREIGN[token.text]
    if before.text == ",":
        return "no comma stands between a class and its first specifier" if token.text in SPECIFIER_WORDS else ""
    if before.text in UNFINISHED:
        return UNFINISHED[before.text]
    if c.class_body and before.kind == "name":
        return f'a property is written "{before.text}: default"'
    return "is an operator or a comma missing?" if c.starts_value(token) else ""


def display(c: Cursor, start: Token) -> ast.expr:
    """Read `(value)`, a tuple, a list, a comprehension; a requirement goes on in round brackets."""
    closing = ")" if start.text == "(" else "]"
    outer = opened(c, c.temporal and closing == ")")
    node: ast.expr | None = None
    values: list[ast.expr] = []
    comma = False
    while c.token.text != closing:
        values.append(element(c))
        if not comma and begins_comprehension(c):
            make = ast.GeneratorExp if closing == ")" else ast.ListComp
            node = make(values[0], comprehensions(c))
            break
        if not c.accept(","):
            break
        comma = True
    close(c, closing, start, outer)
    if node is None:
        if len(values) == 1 and not comma and closing == ")":
            return not_starred(c, values[0])
        node = ast.Tuple(values, LOAD) if closing == ")" else ast.List(values, LOAD)
    return c.at(start, node)


def dictionary(c: Cursor, start: Token) -> ast.expr:
    """Read `{key: value, **more}` or a comprehension of one."""
    outer = opened(c)
    keys: list[ast.expr | None] = []
    values: list[ast.expr] = []
    node: ast.expr = ast.Dict(keys, values)
    while c.token.text != "}":
        if c.accept("**"):
            keys.append(None)
            values.append(c.operation(Level.SEE))
        else:
            keys.append(element(c))
            if len(keys) == 1 and c.token.text != ":":
                if begins_comprehension(c) or c.token.text in (",", "}"):
                    c.refuse("set" if c.token.text != "for" else "set comprehension", start)
                close(c, "}", start, outer)
            c.expect(":", "after the key of the dictionary")
            values.append(c.expression())
            if len(keys) == 1 and begins_comprehension(c):
                node = ast.DictComp(keys[0], values[0], comprehensions(c))  # type: ignore[arg-type]
                break
        if not c.accept(","):
            break
    close(c, "}", start, outer)
    return c.at(start, node)


def element(c: Cursor) -> ast.expr:
    """Read `*operation` or `[name :=] expression`."""
    start = c.token
    if start.text == "*":
        c.advance()
        return c.at(start, ast.Starred(c.operation(Level.SEE), LOAD))
    if start.kind == "name" and c.tokens[c.index + 1].text == ":=":
        c.name("what is assigned to")
        target = c.at(start, ast.Name(start.text, STORE))
        c.advance()
        return c.at(start, ast.NamedExpr(target, c.expression()))
    return c.expression()


def item(c: Cursor) -> ast.expr:
    """Read `*operation` or `expression`."""
    return element(c) if c.token.text == "*" else c.expression()


def row(c: Cursor, read: Callable[[Cursor], ast.expr] = item) -> ast.expr:
    """Read `value [, value]*`, stars allowed: a tuple where there is a comma."""
    start = c.token
    first = read(c)
    if c.token.text != ",":
        return not_starred(c, first)
    values = [first]
    while c.accept(","):
        word = c.is_name(c.token) and c.token.text in SCENIC_KEYWORDS  # of Scenic 3, a name in dialect 2
        if not c.starts_value(c.token, "([{-+~*") and not word:
            break
        values.append(read(c))
    return c.at(start, ast.Tuple(values, LOAD))


def not_starred(c: Cursor, value: ast.expr) -> ast.expr:
    """Return a value that stands alone, and so has no star."""
    if isinstance(value, ast.Starred):
        c.fail("a starred expression cannot stand alone", at=value)
    return value


def begins_comprehension(c: Cursor) -> bool:
    """Return whether `for` comes next."""
    if c.token.text == "async":
        c.refuse("async")
    return c.token.text == "for"


def comprehensions(c: Cursor) -> list[ast.comprehension]:
    """Read `for targets in operation [if condition]`, once or more."""
    found = []
    while begins_comprehension(c):
        c.advance()
        target = targets(c)
        c.expect("in", "after the variable of the comprehension")
        values = c.operation(Level.OR)
        conditions = []
        while c.accept("if"):  # no `if else`, but perhaps a `:=`
            conditions.append(element(c) if c.peek().text == ":=" else c.operation(Level.OR))
        found.append(ast.comprehension(target, values, conditions, 0))
        c.check_chain(len(found), '"for"')
    return found


def targets(c: Cursor) -> ast.expr:
    """Read what a `for` assigns to."""
    return c.stored(row(c, lambda c: element(c) if c.token.text == "*" else c.operation(Level.SEE)))


def arguments(c: Cursor) -> tuple[list[ast.expr], list[ast.keyword]]:
    """Read `(value, *values, name=value, **more)`."""
    opening = c.token
    outer = opened(c)
    values: list[ast.expr] = []
    keywords: list[ast.keyword] = []
    generator: ast.expr | None = None
    while c.token.text != ")":
        start = c.token
        if c.accept("**"):
            keywords.append(c.at(start, ast.keyword(None, c.expression())))
        elif start.kind == "name" and c.tokens[c.index + 1].text == "=":
            if start.text in PYTHON_KEYWORDS:
                c.fail(f'"{start.text}" is a word of the language and cannot be the name of an argument')
            c.skip(2)
            keywords.append(c.at(start, ast.keyword(start.text, c.expression())))
        else:
            if keywords and (start.text != "*" or any(keyword.arg is None for keyword in keywords)):
                c.fail("an argument without a name follows one with a name")
            if c.accept("*"):
                values.append(c.at(start, ast.Starred(c.expression(), LOAD)))
            else:
                values.append(element(c))
                if begins_comprehension(c):
                    generator = values[-1] = c.at(start, ast.GeneratorExp(values[-1], comprehensions(c)))
        if not c.accept(","):
            break
    close(c, ")", opening, outer)
    if generator is not None:
        if len(values) > 1 or keywords:
            c.fail("a generator beside other arguments needs brackets of its own", at=generator)
        c.at(opening, generator)  # Python counts the call's brackets as its own
    return values, keywords


def index(c: Cursor) -> ast.expr:
    """Read `[index]`, `[low:high:step]`, `[a, b]`."""
    opening = c.token
    outer = opened(c)
    start = c.token
    if start.text == "]":
        c.fail("an index is missing between the brackets")
    value = index_element(c)
    if c.token.text == "," or isinstance(value, ast.Starred):
        values = [value]
        while c.accept(",") and c.token.text != "]":
            values.append(index_element(c))
        value = c.at(start, ast.Tuple(values, LOAD))
    close(c, "]", opening, outer)
    return value


def index_element(c: Cursor) -> ast.expr:
    """Read an index, a slice, or `*values`."""
    start = c.token
    lower = None if start.text == ":" else element(c)
    if c.token.text != ":" and lower is not None:
        return lower
    bounds: list[ast.expr | None] = [None, None]
    for k in range(2):
        if not c.accept(":"):
            break
        if c.token.text not in (":", ",", "]"):
            bounds[k] = c.expression()
    return c.at(start, ast.Slice(lower, *bounds))


def bracketed_parameters(c: Cursor, owner: str) -> ast.arguments:
    """Read `(parameters)`."""
    opening = c.token
    if opening.text != "(":
        c.missing(f'"(" after {owner}', 'write "()" if it takes nothing')
    outer = opened(c)
    found = parameters(c, ")")
    close(c, ")", opening, outer)
    return found


def parameters(c: Cursor, closing: str) -> ast.arguments:
    """Read `a, b=1, *rest, d, **more`, up to but without the closing sign; in brackets with `: annotation`."""
    found = ast.arguments([], [], None, [], [], None, [])
    star = False
    names: set[str] = set()
    while c.token.text != closing:
        start = c.token
        if c.accept("**"):
            found.kwarg = parameter(c, closing, names)
            c.accept(",")
            break
        if c.accept("*"):
            if star:
                c.fail('a second "*" among the parameters', at=start)
            star = True
            if c.token.text != ",":
                found.vararg = parameter(c, closing, names)
            elif c.peek().text in (closing, "**"):
                c.fail('names must follow a bare "*"', at=start)
        else:
            name = parameter(c, closing, names)
            default = c.expression() if c.accept("=") else None
            if star:
                found.kwonlyargs.append(name)
                found.kw_defaults.append(default)
            else:
                if default is None and found.defaults:
                    c.fail("a parameter without a default follows one with a default", at=name)
                found.args.append(name)
                found.defaults += [default] if default else []
        if not c.accept(","):
            break
    return found


def parameter(c: Cursor, closing: str, names: set[str]) -> ast.arg:
    """Read `name [: annotation]`; a name used twice is an error."""
    start = c.name("a parameter")
    if start.text in names:
        c.fail(f'the parameter "{start.text}" occurs twice', at=start)
    names.add(start.text)
    annotation = c.expression() if closing == ")" and c.accept(":") else None
    return c.at(start, ast.arg(start.text, annotation))
