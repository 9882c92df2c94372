"""Program text to tokens: Python's lexical rules, read by one regular expression, each token with its place.

Comments and blank lines are dropped; NEWLINE, INDENT and DEDENT tokens carry the layout. Columns count characters,
so that a caret under a column stands right. Read next: `parser_cursor`, which walks the tokens.
"""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect_right
from functools import cached_property
from typing import NamedTuple

from scenic_lite.errors import ScenicError, SourceSpan

MAX_CHARACTERS = 2_000_000
MAX_INDENTS = 80
MAX_BRACKETS = 80
TAB = 8

_DIGITS = r"[0-9](?:_?[0-9])*"
_FLOAT = rf"(?:{_DIGITS}\.(?:{_DIGITS})?|\.{_DIGITS})(?:[eE][-+]?{_DIGITS})?|{_DIGITS}[eE][-+]?{_DIGITS}"
_NUMBER = rf"0[xX](?:_?[0-9a-fA-F])+|0[bB](?:_?[01])+|0[oO](?:_?[0-7])+|(?:{_FLOAT})[jJ]?|{_DIGITS}[jJ]?"
_PREFIX = r"(?:[rR][bBfF]?|[bBfF][rR]?|[uU])?"
_STRING = (
    _PREFIX + r"(?:"
    r"'''[^'\\]*(?:(?:\\.|'(?!''))[^'\\]*)*'''|"
    r'"""[^"\\]*(?:(?:\\.|"(?!""))[^"\\]*)*"""|'
    r"'(?!'')[^\n'\\]*(?:\\.[^\n'\\]*)*'|"
    r'"(?!"")[^\n"\\]*(?:\\.[^\n"\\]*)*"'
    r")"
)
_OPERATOR = r"\*\*=?|//=?|>>=?|<<=?|\.\.\.|->|:=|[-+*/%@&|^=<>!]=|[-+*/%@&|^=<>~()\[\]{},:;.]"
_TOKEN = re.compile(
    rf"[ \f\t]*(?:(?P<string>{_STRING})|(?P<open_string>{_PREFIX}(?:'''|\"\"\"|'|\"))|(?P<name>[^\W\d]\w*)"
    rf"|(?P<number>{_NUMBER})|(?P<operator>{_OPERATOR})|(?P<newline>\n)|(?P<comment>\#[^\n]*)"
    r"|(?P<continuation>\\\n)|(?P<end>\Z))",
    re.DOTALL,
)
_INDENTATION = re.compile(r"[ \t\f]*")
_BLANK_LINE = re.compile(r"(?:\#[^\n]*)?(?:\n|\Z)")

_CLOSING = {"(": ")", "[": "]", "{": "}"}
# Words that may stand directly after a number, as in `1if x else 2` and `30deg`.
_AFTER_NUMBER = frozenset({"and", "or", "not", "if", "else", "for", "in", "is", "deg", "by"})
_LOOKALIKES = {
    "“": "quotes are written '...' or \"...\"",
    "”": "quotes are written '...' or \"...\"",
    "‘": "quotes are written '...' or \"...\"",
    "’": "quotes are written '...' or \"...\"",
    "−": 'the minus sign is written "-"',
    "–": 'the minus sign is written "-"',
    "—": 'the minus sign is written "-"',
    "×": 'multiplication is written "*"',
    "≤": 'it is written "<="',
    "≥": 'it is written ">="',
    "≠": 'it is written "!="',
    "°": 'degrees are written "deg"',
    "\u00a0": "it looks like a blank, but is none",
    "!": 'negation is written "not"',
    "&": 'it is written "and"',
    "?": 'a choice is written "a if condition else b"',
    "$": "",
}


class Token(NamedTuple):
    """One token; `kind` is name, number, string, operator, newline, indent, dedent or end.

    Lines count from 1, columns from 0; the end is exclusive.
    """

    kind: str
    text: str
    line: int
    column: int
    end_line: int
    end_column: int


class Source:
    """A program's text with its lines, and the errors that point into it."""

    def __init__(self, text: str, file: str) -> None:
        self.text = unified(text)
        self.file = file

    @cached_property
    def line_starts(self) -> list[int]:
        """The offset in the text at which each line begins."""
        return [0, *(match.end() for match in re.finditer("\n", self.text))]

    def line(self, number: int) -> str:
        """The text of a line, counted from 1; empty beyond the last."""
        if not 0 < number <= len(self.line_starts):
            return ""
        start = self.line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]

    def offset(self, line: int, column: int) -> int:
        """The offset in the text of a line (from 1) and column (from 0)."""
        return self.line_starts[line - 1] + column

    def line_and_column(self, offset: int) -> tuple[int, int]:
        """The line (from 1) and column (from 0) of an offset in the text."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1]

    def error(
        self, message: str, place: tuple[int, int, int, int], hint: str = "", kind: str = "syntax"
    ) -> ScenicError:
        """An error at place (line, column, end line, end column)."""
        return ScenicError(kind, message, SourceSpan(self.file, *place), hint=hint, source_line=self.line(place[0]))


def unified(text: str) -> str:
    """A text without byte order mark, and with the line feed as its only line end."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def tokens(text: str, file: str = "<program>") -> list[Token]:
    """Split a program into tokens; the last one is of kind `end`.

    Raises ScenicError (`syntax`, or `budget` for a text of more than 2 million characters).
    """
    return lex(Source(text, file))


def lex(source: Source) -> list[Token]:
    """The tokens of a whole source."""
    if len(source.text) > MAX_CHARACTERS:
        message = f"the program has {len(source.text):,} characters; at most {MAX_CHARACTERS:,} are read"
        raise source.error(message, (1, 0, 1, 1), kind="budget")
    return _Lexer(source).run()


def lex_part(source: Source, start: int, end: int) -> list[Token]:
    """The tokens of text[start:end], read as if in brackets: the expressions inside f-strings."""
    lexer = _Lexer(source, start, end)
    lexer.brackets.append(Token("operator", "{", lexer.line, 0, lexer.line, 1))
    lexer.inside_string = True
    return lexer.run()


class _Lexer:
    """The state of one pass over the text; `run` is the loop."""

    def __init__(self, source: Source, start: int = 0, end: int | None = None) -> None:
        self.source = source
        self.text = source.text
        self.position = start
        self.end = len(source.text) if end is None else end
        self.line, column = source.line_and_column(start)
        self.line_start = start - column
        self.brackets: list[Token] = []
        self.indents = [(0, 0)]  # (column with tabs of 8, column with tabs of 1)
        self.tokens: list[Token] = []
        self.inside_string = False

    def run(self) -> list[Token]:
        """Read everything."""
        if not self.brackets:
            self.indentation()
        match, text, end, tokens = _TOKEN.match, self.text, self.end, self.tokens
        while True:
            found = match(text, self.position, end)
            kind = found.lastgroup if found else None
            if found is None or kind is None:
                raise self.bad_character()
            start, self.position = found.span(kind)
            if kind in ("name", "operator", "number"):
                column = start - self.line_start
                word = found[kind]
                token = Token(kind, word, self.line, column, self.line, column + len(word))
                if kind == "operator":
                    if word in "()[]{}":
                        self.bracket(token)
                elif kind == "number" or not word.isascii():
                    token = self.checked(token)
                tokens.append(token)
            elif kind == "string":
                self.string(found[kind], start)
            elif kind == "newline":
                self.newline(start)
            elif kind == "continuation":
                self.next_line(self.position)
            elif kind == "end":
                return self.finish(start)
            elif kind == "open_string":
                raise self.unterminated(found[kind], start)

    def place(self, start: int, end: int) -> tuple[int, int, int, int]:
        """The place of text[start:end], which lies in the present line."""
        return (self.line, start - self.line_start, self.line, end - self.line_start)

    def next_line(self, start: int) -> None:
        self.line += 1
        self.line_start = start

    def newline(self, start: int) -> None:
        if not self.brackets:
            column = start - self.line_start
            self.tokens.append(Token("newline", "\n", self.line, column, self.line, column + 1))
            self.next_line(self.position)
            self.indentation()
        else:
            self.next_line(self.position)

    def finish(self, end: int) -> list[Token]:
        """Close the last line and every block."""
        if self.brackets and not self.inside_string:
            opening = self.brackets[-1]
            raise self.source.error(f'"{opening.text}" is never closed', opening[2:])
        column = end - self.line_start
        if self.tokens and self.tokens[-1].kind not in ("newline", "dedent") and not self.inside_string:
            self.tokens.append(Token("newline", "", self.line, column, self.line, column + 1))
        # A last line that ends with its newline leaves the end of the file on a line of its own.
        for _ in self.indents[1:]:
            self.tokens.append(Token("dedent", "", self.line, 0, self.line, 0))
        self.tokens.append(Token("end", "", self.line, column, self.line, column))
        return self.tokens

    def indentation(self) -> None:
        """Skip blank lines; compare the indentation of the next line with those of the open blocks."""
        while True:
            blank = _INDENTATION.match(self.text, self.position, self.end)
            start = blank.end() if blank else self.position
            empty = _BLANK_LINE.match(self.text, start, self.end)
            if empty is None:
                break
            self.position = empty.end()
            if self.position >= self.end and not empty[0].endswith("\n"):
                return
            self.next_line(self.position)
        column, plain = _width(self.text[self.position : start])
        token = Token("indent", "", self.line, 0, self.line, start - self.position)
        self.position = start
        self.open_or_close(column, plain, token)

    def open_or_close(self, column: int, plain: int, token: Token) -> None:
        """Emit INDENT, or as many DEDENTs as blocks end."""
        if column > self.indents[-1][0]:
            if plain <= self.indents[-1][1]:
                raise self.mixed_tabs(token)
            if len(self.indents) > MAX_INDENTS:
                raise self.source.error(f"blocks are nested more than {MAX_INDENTS} deep", token[2:], kind="budget")
            self.indents.append((column, plain))
            self.tokens.append(token)
            return
        while column < self.indents[-1][0]:
            self.indents.pop()
            self.tokens.append(Token("dedent", "", token.line, token.end_column, token.line, token.end_column))
        if column != self.indents[-1][0]:
            raise self.source.error(
                "the indentation fits no block above", token[2:], "line it up with the block it belongs to"
            )
        if plain != self.indents[-1][1]:
            raise self.mixed_tabs(token)

    def mixed_tabs(self, token: Token) -> ScenicError:
        return self.source.error(
            "tabs and spaces are mixed in the indentation", token[2:], "indent the whole block with one of them"
        )

    def bracket(self, token: Token) -> None:
        """Push an opening bracket, or compare a closing one with its partner."""
        if token.text in _CLOSING:
            if len(self.brackets) >= MAX_BRACKETS:
                raise self.source.error(f"brackets are nested more than {MAX_BRACKETS} deep", token[2:], kind="budget")
            self.brackets.append(token)
            return
        if not self.brackets:
            raise self.source.error(f'"{token.text}" closes no bracket', token[2:])
        opening = self.brackets.pop()
        if _CLOSING[opening.text] != token.text:
            message = f'"{token.text}" does not match the "{opening.text}" of line {opening.line}'
            raise self.source.error(message, token[2:], f'close it with "{_CLOSING[opening.text]}" first')

    def string(self, text: str, start: int) -> None:
        """Emit a string, which may span lines."""
        line, column = self.line, start - self.line_start
        if "\n" in text:
            self.line += text.count("\n")
            self.line_start = start + text.rfind("\n") + 1
        token = Token("string", text, line, column, self.line, self.position - self.line_start)
        self.tokens.append(token)

    def unterminated(self, opening: str, start: int) -> ScenicError:
        if opening.endswith(("'''", '"""')):
            place = self.place(start, start + len(opening))
            return self.source.error(f"the string that {opening[-3:]} opens is never closed", place)
        end = self.text.find("\n", start)
        place = self.place(start, self.end if end < 0 else end)
        return self.source.error("the string is not closed in its line", place, f"it lacks a {opening[-1]}")

    def checked(self, token: Token) -> Token:
        """A number is not followed by letters; a name is an identifier, in normal form."""
        if token.kind == "name":
            name = unicodedata.normalize("NFKC", token.text)
            if not name.isidentifier():
                raise self.source.error(f'"{token.text}" is not a name', token[2:])
            return token._replace(text=name)
        tail = re.compile(r"\w*").match(self.text, self.position, self.end)
        word = tail[0] if tail else ""
        if word and word not in _AFTER_NUMBER:
            place = (token.line, token.column, token.line, token.end_column + len(word))
            raise self.source.error(f'"{token.text}{word}" is neither a number nor a name', place)
        if re.fullmatch("0[0-9_]*[1-9][0-9_]*", token.text):
            hint = f"write {token.text.lstrip('0_')}"
            raise self.source.error("a whole number does not begin with 0", token[2:], hint)
        return token

    def bad_character(self) -> ScenicError:
        blank = _INDENTATION.match(self.text, self.position, self.end)
        start = blank.end() if blank else self.position
        character = self.text[start]
        place = self.place(start, start + 1)
        if character == "\\":
            return self.source.error("a backslash may only end a line", place)
        if character == "\0":
            return self.source.error("the program contains a null byte", place)
        if character in "!$?`" or character.isprintable():
            found = f'the character "{character}"'
        else:
            found = f"the character U+{ord(character):04X}"
        return self.source.error(f"{found} is not part of the language", place, _LOOKALIKES.get(character, ""))


def _width(blanks: str) -> tuple[int, int]:
    """The column that blanks reach, with tab stops every 8 and every 1 column."""
    column = plain = 0
    for blank in blanks:
        if blank == "\t":
            column = (column // TAB + 1) * TAB
            plain += 1
        elif blank == "\f":
            column = plain = 0
        else:
            column += 1
            plain += 1
    return column, plain
