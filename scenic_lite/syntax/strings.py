"""Strings: joined when they stand side by side, and f-strings with the expressions inside them.

As in Python 3.11: an expression in an f-string holds neither a backslash nor the quotes that delimit the string.
Read next: `parser_specifiers`.
"""

from __future__ import annotations

import ast
import re
from typing import NoReturn

from scenic_lite.syntax import literals
from scenic_lite.syntax.cursor import Cursor
from scenic_lite.syntax.lexer import Token, lex_part

_PLAIN = re.compile(r"[^{}]+|\{\{|\}\}")
# The escape \N{...} of a string that is not raw belongs to the text.
_PLAIN_ESCAPED = re.compile(r"(?:\\N\{[^{}]*\}|\\.|[^{}\\])+|\{\{|\}\}", re.DOTALL)
_CONVERSIONS = {"s": 115, "r": 114, "a": 97}
MAX_FORMAT_DEPTH = 2


class Strings(Cursor):
    """The production `STRING+`."""

    def strings(self) -> ast.expr:
        """One or more string tokens side by side: a Constant, or a JoinedStr if one of them is an f-string."""
        start = self.advance()
        if self.token.kind != "string" and start.text[0] in "'\"" and "\\" not in start.text:
            width = 3 if start.text[:3] in ("'''", '"""') else 1
            return self.at(start, ast.Constant(start.text[width:-width]))
        pieces = [start]
        while self.token.kind == "string":
            pieces.append(self.advance())
        prefixes = [literals.split_string(piece.text)[0] for piece in pieces]
        if any("b" in prefix for prefix in prefixes):
            self.refuse("bytes", start)
        kind = "u" if prefixes[0] == "u" else None
        parts = [part for piece in pieces for part in self.parts(piece, start)]
        if not any("f" in prefix for prefix in prefixes):
            return self.at(start, ast.Constant("".join(part for part in parts if isinstance(part, str)), kind))
        return self.at(start, ast.JoinedStr(self.joined(parts, start, kind)))

    def joined(self, parts: list[str | ast.expr], start: Token, kind: str | None = None) -> list[ast.expr]:
        """Make each run of text one Constant."""
        values: list[ast.expr] = []
        text = ""
        for part in [*parts, None]:
            if isinstance(part, str):
                text += part
                continue
            if text:
                values.append(self.at(start, ast.Constant(text, kind)))
                text = ""
            if part is not None:
                values.append(part)
        return values

    def parts(self, token: Token, start: Token) -> list[str | ast.expr]:
        """The texts and values of one string token. `start`: the first of the tokens joined."""
        prefix, offset, content = literals.split_string(token.text)
        if "f" not in prefix:
            return [self.text(content, "r" in prefix, token)]
        base = self.source.offset(token.line, token.column) + offset
        return _FormatString(self, start, token, "r" in prefix).parts(base, base + len(content), 0)

    def text(self, content: str, raw: bool, token: Token) -> str:
        """The text that `content` stands for."""
        try:
            return content if raw else literals.unescape(content)
        except ValueError as error:
            self.fail(str(error), at=token)

    def inner_expression(self, start: int, end: int) -> ast.expr:
        """Parse text[start:end] with this parser's settings; a comma makes a tuple, as in brackets."""
        outer = (self.tokens, self.index, self.token)
        self.tokens = lex_part(self.source, start, end)
        self.brackets += 1
        self.go_back(0)
        try:
            value = self.inside_brackets()
            if self.token.kind != "end":
                self.fail(f'unexpected "{self.token.text}" in the f-string')
            return value
        finally:  # an operand that was only tried goes on behind the f-string
            self.tokens, self.index, self.token = outer
            self.brackets -= 1

    def inside_brackets(self) -> ast.expr:
        """What may stand in round brackets, up to the end; defined in parser_displays."""
        raise NotImplementedError


class _FormatString:
    """One f-string token being taken apart; positions are offsets in the program's text."""

    def __init__(self, parser: Strings, start: Token, token: Token, raw: bool) -> None:
        self.parser = parser
        self.source = parser.source
        self.program = parser.source.text
        self.start = start
        self.token = token
        self.raw = raw

    def parts(self, position: int, end: int, depth: int) -> list[str | ast.expr]:
        """Texts and FormattedValues of program[position:end]. `depth`: 0 outside of format specifications."""
        found: list[str | ast.expr] = []
        plain = _PLAIN if self.raw else _PLAIN_ESCAPED
        while position < end:
            match = plain.match(self.program, position, end)
            if match:
                position = match.end()
                braces = match[0] in ("{{", "}}")
                text = match[0]
                found.append(text[0] if braces else self.parser.text(text, self.raw, self.token))
            elif self.program[position] == "{":
                position = self.value(position, end, depth, found)
            else:
                self.fail('a single "}" in an f-string', position, 'write "}}" for the character')
        return found

    def value(self, opening: int, end: int, depth: int, found: list[str | ast.expr]) -> int:
        """Append one `{expression[=][!conversion][:format]}`; returns the position behind it."""
        if depth >= MAX_FORMAT_DEPTH:
            self.fail("the f-string is nested too deeply", opening)
        stop = self.expression_end(opening + 1, end)
        if not self.program[opening + 1 : stop].strip(" \t\n\f"):
            self.fail("an empty {} in an f-string", opening, "put a value between the braces")
        value = self.parser.inner_expression(opening + 1, stop)
        position = stop
        conversion = -1
        specification: ast.expr | None = None
        debug = self.character(position, end) == "="
        if debug:
            position += 1
            while self.character(position, end) in (" ", "\t", "\n", "\f"):
                position += 1
            found.append(self.program[opening + 1 : position])
        if self.character(position, end) == "!":
            conversion = _CONVERSIONS.get(self.character(position + 1, end), -1)
            if conversion < 0:
                self.fail('expected "!r", "!s" or "!a" in the f-string', position)
            position += 2
        if self.character(position, end) == ":":
            stop = self.format_end(position + 1, end)
            parts = self.parts(position + 1, stop, depth + 1)
            specification = self.parser.at(self.start, ast.JoinedStr(self.parser.joined(parts, self.start)))
            position = stop
        if self.character(position, end) != "}":
            self.fail('a "{" in an f-string is never closed', opening, 'write "{{" for the character')
        if debug and conversion < 0 and specification is None:
            conversion = _CONVERSIONS["r"]
        found.append(self.parser.at(self.start, ast.FormattedValue(value, conversion, specification)))
        return position + 1

    def expression_end(self, position: int, end: int) -> int:
        """Where the expression that begins at `position` ends: at a bare `!`, `:`, `=` or `}`."""
        depth, quote = 0, ""
        while position < end:
            character = self.program[position]
            if character == "\\":
                self.fail("a backslash inside {} of an f-string", position, "compute the value before")
            if quote:
                if self.program.startswith(quote, position):
                    position += len(quote) - 1
                    quote = ""
            elif character in "'\"":
                quote = character * 3 if self.program.startswith(character * 3, position) else character
                position += len(quote) - 1
            elif character == "#":
                self.fail("a comment inside {} of an f-string", position)
            elif character in "([{":
                depth += 1
            elif depth:
                depth -= character in ")]}"
            elif character in ":})]":
                return position
            elif character in "!=<>":
                if self.program[position + 1 : position + 2] == "=":
                    position += 1
                elif character in "!=":
                    return position
            position += 1
        return position

    def format_end(self, position: int, end: int) -> int:
        """Where the format specification that begins at `position` ends: at the `}` that closes the value."""
        depth = 0
        while position < end:
            character = self.program[position]
            if character == "{":
                depth += 1
            elif character == "}":
                if depth == 0:
                    return position
                depth -= 1
            position += 1
        return position

    def character(self, position: int, end: int) -> str:
        return self.program[position] if position < end else ""

    def fail(self, message: str, position: int, hint: str = "") -> NoReturn:
        line, column = self.source.line_and_column(position)
        raise self.source.error(message, (line, column, line, column + 1), hint)
