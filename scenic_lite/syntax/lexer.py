"""From program text to tokens with places: Python's lexical rules in one regular expression.

The standard library's `tokenize` is slower, and splits f-strings differently from Python 3.12 on. For invalid text it
gives neither the place (an open bracket: "EOF") nor a hint. This lexer drops comments and blank lines; NEWLINE, INDENT
and DEDENT tokens represent the layout. An INDENT after a comma, without a NEWLINE before it or a DEDENT after it, marks
a continued line. Columns count characters, so that carets align.
Read next: `syntax.cursor`, which iterates over the tokens.
"""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect_right
from functools import cached_property
from typing import NamedTuple

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax.grammar import LOOKALIKES

MAX_CHARACTERS = 2_000_000
MAX_INDENTS = 80
MAX_BRACKETS = 80
TAB = 8

_DIGITS = r"[0-9](?:_?[0-9])*"
_FLOAT = rf"(?:{_DIGITS}\.(?:{_DIGITS})?|\.{_DIGITS})(?:[eE][-+]?{_DIGITS})?|{_DIGITS}[eE][-+]?{_DIGITS}"
_NUMBER = rf"0[xX](?:_?[0-9a-fA-F])+|0[bB](?:_?[01])+|0[oO](?:_?[0-7])+|{_FLOAT}|{_DIGITS}"
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
    rf"[ \f\t]*(?:(?P<name>(?!{_PREFIX}['\"])[^\W\d]\w*)|(?P<number>{_NUMBER})|(?P<operator>{_OPERATOR})"
    rf"|(?P<newline>\n)|(?P<string>{_STRING})|(?P<open_string>{_PREFIX}(?:'''|\"\"\"|'|\"))|(?P<comment>\#[^\n]*)"
    r"|(?P<continuation>\\\n)|(?P<end>\Z))",
    re.DOTALL,
)
_INDENTATION = re.compile(r"[ \t\f]*")
_BLANK_LINE = re.compile(r"(?:\#[^\n]*)?(?:\n|\Z)")
_NEXT_LINE = re.compile(r"(?:[ \t\f]*+(?:\#[^\n]*+)?\n)*+([ \t\f]*+)(?=[^\s#])")
_WORD = re.compile(r"\w*")

_CLOSING = {"(": ")", "[": "]", "{": "}"}
# Words that may follow a number without a space, as in `1if x else 2` and `30deg`.
_AFTER_NUMBER = frozenset({"", "and", "or", "not", "if", "else", "for", "in", "is", "deg", "by"})

Place = tuple[int, int, int, int]  # line, column, end line, end column


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
    """The text of a program, with access to its lines and errors at places of the text."""

    def __init__(self, text: str, file: str) -> None:
        self.text = unified(text)
        self.file = file

    @cached_property
    def line_starts(self) -> list[int]:
        """The offset of the first character of each line."""
        return [0, *(match.end() for match in re.finditer("\n", self.text))]

    def line(self, number: int) -> str:
        """Return the text of a line, counted from 1; "" after the last line."""
        if not 0 < number <= len(self.line_starts):
            return ""
        start = self.line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]

    def offset(self, line: int, column: int) -> int:
        """Return the offset in the text of a line (from 1) and column (from 0)."""
        return self.line_starts[line - 1] + column

    def line_and_column(self, offset: int) -> tuple[int, int]:
        """Return the line (from 1) and column (from 0) of an offset in the text."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1]

    def error(self, message: str, place: Place, hint: str = "", kind: str = "syntax") -> ScenicError:
        """Return an error at a place."""
        return ScenicError(kind, message, SourceSpan(self.file, *place), hint=hint, source_line=self.line(place[0]))


def unified(text: str) -> str:
    """Return a text without a byte order mark, with all line ends converted to line feeds."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def lex(source: Source) -> list[Token]:
    """Return the tokens of a whole program; the last one is of kind `end`.

    Raises ScenicError (`syntax`, or `budget` for a text of more than 2 million characters).
    """
    if len(source.text) > MAX_CHARACTERS:
        message = f"the program has {len(source.text):,} characters; at most {MAX_CHARACTERS:,} are read"
        raise source.error(message, (1, 0, 1, 1), kind="budget")
    lexer = _Lexer(source, 0, len(source.text))
    lexer.indentation()
    return lexer.run()


def lex_part(source: Source, start: int, end: int) -> list[Token]:
    """Return the tokens of a part of a line, such as the value in an f-string."""
    return _Lexer(source, start, end).run()


class _Lexer:
    """The state of one pass over text[start:end]; `run` is the main loop."""

    def __init__(self, source: Source, start: int, end: int) -> None:
        self.source, self.text = source, source.text
        self.position, self.end = start, end
        self.line, column = source.line_and_column(start)
        self.line_start = start - column
        self.brackets: list[Token] = []
        self.indents = [(0, 0)]  # (column with tabs of 8, column with tabs of 1)
        self.tokens: list[Token] = []

    def run(self) -> list[Token]:
        """Return the tokens of the whole range."""
        match, text, end, tokens = _TOKEN.match, self.text, self.end, self.tokens
        while True:
            matched = match(text, self.position, end)
            kind = matched.lastgroup if matched else None
            if matched is None or kind is None:
                raise self.bad_character()
            start, self.position = matched.span(kind)
            if kind in ("name", "operator", "number"):
                column = start - self.line_start
                word = matched[kind]
                token = Token(kind, word, self.line, column, self.line, column + len(word))
                if kind == "operator":
                    if word in "()[]{}":
                        self.bracket(token)
                elif kind == "number" or not word.isascii():
                    token = self.checked(token)
                tokens.append(token)
            elif kind == "string":
                self.string(matched[kind], start)
            elif kind == "newline":
                if self.brackets:
                    self.next_line()
                elif not tokens or tokens[-1].text != "," or not self.goes_on():
                    column = start - self.line_start
                    tokens.append(Token("newline", "\n", self.line, column, self.line, column + 1))
                    self.next_line()
                    self.indentation()
            elif kind == "continuation":
                self.next_line()
            elif kind == "end":
                return self.finish(start)
            elif kind == "open_string":
                raise self.unterminated(matched[kind], start)

    def next_line(self) -> None:
        self.line += 1
        self.line_start = self.position

    def finish(self, end: int) -> list[Token]:
        """Emit the final NEWLINE, DEDENTs and end token."""
        self.position = end
        column = end - self.line_start
        if self.brackets:
            opening = self.brackets[-1]
            raise self.source.error(f'"{opening.text}" is never closed', opening[2:])
        if self.tokens and self.tokens[-1].kind not in ("newline", "dedent"):
            self.tokens.append(Token("newline", "", self.line, column, self.line, column + 1))
        # After a final line feed, the end of the file is on a line of its own.
        self.tokens += [Token("dedent", "", self.line, 0, self.line, 0) for _ in self.indents[1:]]
        self.tokens.append(Token("end", "", self.line, column, self.line, column))
        return self.tokens

    def indentation(self) -> None:
        """Skip blank lines; emit an INDENT, or one DEDENT for each block that ends before the next line."""
        while True:
            blanks = _INDENTATION.match(self.text, self.position, self.end)[0]  # type: ignore[index]  # always matches
            start = self.position + len(blanks)
            empty = _BLANK_LINE.match(self.text, start, self.end)
            if empty is None:
                break
            self.position = empty.end()
            if self.position >= self.end and not empty[0].endswith("\n"):
                return
            self.next_line()
        self.position = start
        blanks = blanks.rpartition("\f")[2]
        width = len(blanks.expandtabs(TAB)), len(blanks)
        token = Token("indent", "", self.line, 0, self.line, start - self.line_start)
        if width[0] > self.indents[-1][0]:
            if len(self.indents) > MAX_INDENTS:
                raise self.source.error(f"blocks are nested more than {MAX_INDENTS} deep", token[2:], kind="budget")
            mixed = width[1] <= self.indents[-1][1]
            self.indents.append(width)
            self.tokens.append(token)
        else:
            while width[0] < self.indents[-1][0]:
                self.indents.pop()
                self.tokens.append(Token("dedent", "", token.line, token.end_column, token.line, token.end_column))
            if width[0] != self.indents[-1][0]:
                hint = "line it up with the block it belongs to"
                raise self.source.error("the indentation fits no block above", token[2:], hint)
            mixed = width[1] != self.indents[-1][1]
        if mixed:
            hint = "indent the whole block with one of them"
            raise self.source.error("tabs and spaces are mixed in the indentation", token[2:], hint)

    def goes_on(self) -> bool:
        """Continue a line after a comma if the next line is indented deeper, as for specifiers; return whether."""
        line = _NEXT_LINE.match(self.text, self.position, self.end)
        if line is None or len(line[1].rpartition("\f")[2].expandtabs(TAB)) <= self.indents[-1][0]:
            return False
        self.line += line[0].count("\n") + 1
        self.line_start, self.position = line.span(1)
        self.tokens.append(Token("indent", "", self.line, 0, self.line, len(line[1])))
        return True

    def bracket(self, token: Token) -> None:
        """Push an opening bracket, or match a closing bracket with its opening bracket."""
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
        """Emit a string, which may span several lines."""
        line, column = self.line, start - self.line_start
        if "\n" in text:
            self.line += text.count("\n")
            self.line_start = start + text.rfind("\n") + 1
        self.tokens.append(Token("string", text, line, column, self.line, self.position - self.line_start))

    def error(self, message: str, start: int, end: int, hint: str = "") -> ScenicError:
        """Return an error from one offset to another in the present line."""
        place = (self.line, start - self.line_start, self.line, end - self.line_start)
        return self.source.error(message, place, hint)

    def unterminated(self, opening: str, start: int) -> ScenicError:
        if opening.endswith(("'''", '"""')):
            return self.error(f"the string that {opening[-3:]} opens is never closed", start, start + len(opening))
        end = self.text.find("\n", start)
        end = self.end if end < 0 else end
        return self.error("the string is not closed in its line", start, end, f"it lacks a {opening[-1]}")

    def checked(self, token: Token) -> Token:
        """Check a number or name: no letters may follow a number, and a name is normalized (NFKC) to an identifier."""
        start = self.line_start + token.column
        if token.kind == "name":
            name = unicodedata.normalize("NFKC", token.text)
            if not name.isidentifier():
                raise self.error(f'"{token.text}" is not a name', start, self.position)
            return token._replace(text=name)
        tail = _WORD.match(self.text, self.position, self.end)[0]  # type: ignore[index]  # always matches
        if tail not in _AFTER_NUMBER:
            message = f'"{token.text}{tail}" is neither a number nor a name'
            raise self.error(message, start, self.position + len(tail))
        if re.fullmatch("0[0-9_]*[1-9][0-9_]*", token.text):
            hint = f"write {token.text.lstrip('0_')}"
            raise self.error("a whole number does not begin with 0", start, self.position, hint)
        return token

    def bad_character(self) -> ScenicError:
        start = _INDENTATION.match(self.text, self.position, self.end).end()  # type: ignore[union-attr]  # always
        character = self.text[start]
        shown = f'the character "{character}"' if character.isprintable() else f"the character U+{ord(character):04X}"
        message, hint = f"{shown} is not part of the language", LOOKALIKES.get(character, "")
        if character == "\0":
            message = "the program contains a null byte"
        elif character == "\\":
            message = "a backslash may only end a line"
        return self.error(message, start, start + 1, hint)
