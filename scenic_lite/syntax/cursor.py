"""The token cursor that all parts of the parser share: look ahead, read, expect, build a node, report errors.

The productions are functions of a cursor in the other modules, and their docstrings are the grammar. A module calls
productions of later modules through the cursor, where `parse` registers them: a bracket contains expressions, a block
contains statements.
Read next: `syntax.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeVar

from scenic_lite.syntax.grammar import PYTHON_KEYWORDS, REFUSED, SCENIC_KEYWORDS, Form, Forms
from scenic_lite.syntax.lexer import Place, Source, Token, lex

Node = TypeVar("Node", bound=ast.AST)

LOAD, STORE = ast.Load(), ast.Store()

VALUES = frozenset({"True", "False", "None", "not", "lambda"})
LAYOUT = {
    "newline": "the end of the line",
    "indent": "a deeper indentation",
    "dedent": "the end of the block",
    "end": "the end of the program",
}

# Python's recursion limit is 1000 calls; one level of nesting takes about eight calls.
MAX_NESTING = 90
MAX_CHAIN = 100


class Cursor:
    """A position in the tokens of a program. `token` is the next token, `dialect` is 2 or 3."""

    expression: Callable[[], ast.expr]  # operators.expression
    operation: Callable[[int], ast.expr]  # operators.operation
    statements: Mapping[str, Any]  # parser.STATEMENTS
    blocks: Mapping[str, Any]  # parser.BLOCKS

    def __init__(self, source: Source, dialect: int) -> None:
        self.source = source
        self.dialect = dialect
        self.keywords = PYTHON_KEYWORDS | SCENIC_KEYWORDS if dialect == 3 else PYTHON_KEYWORDS
        self.tokens = lex(source)
        self.index = 0
        self.token = self.tokens[0]
        self.nesting = 0
        self.brackets: list[tuple[Token, bool]] = []  # open brackets, each with the value of `temporal` outside
        self.temporal = False  # within the condition of a `require`
        self.asks_truth = False  # the next expression is a condition, which cannot begin with an instance
        self.in_target = False  # inside the object of `override`, where no instance may begin
        self.class_body = False  # directly in the body of a class
        # Tokens at which the longer reading of a word operator's first operand has failed.
        self.no_partner: set[Token] = set()

    def peek(self, ahead: int = 1) -> Token:
        """Return the token `ahead` places after the next token."""
        index = self.index + ahead
        return self.tokens[index] if index < len(self.tokens) else self.tokens[-1]

    def sees(self, *words: str) -> bool:
        """Return whether these words (or signs) follow."""
        if self.token.text != words[0]:
            return False
        return all(self.peek(k).text == word for k, word in enumerate(words[1:], 1))

    def form(self, table: Forms) -> Form | None:
        """Return the form of a table whose words follow, or None."""
        for form in table.get(self.token.text, ()):
            if len(form.words) == 1 or self.sees(*form.words):
                return form
        return None

    def is_name(self, token: Token) -> bool:
        """Return whether the token may be a name."""
        return token.kind == "name" and token.text not in self.keywords

    def is_plain_name(self, token: Token) -> bool:
        """Return whether the token is a name in every dialect."""
        return token.kind == "name" and token.text not in PYTHON_KEYWORDS and token.text not in SCENIC_KEYWORDS

    def starts_value(self, token: Token, signs: str = "([{") -> bool:
        """Return whether a value can begin with this token; `signs`: operators with which a value can begin."""
        if token.kind == "name":
            return self.is_plain_name(token) or token.text in VALUES or token.text == "new"
        return token.kind in ("number", "string") or (token.kind == "operator" and token.text in signs)

    def ends_statement(self, token: Token | None = None) -> bool:
        """Return whether a statement ends before a token, by default the next token."""
        token = token or self.token
        return token.kind in ("newline", "end") or token.text == ";"

    @property
    def previous(self) -> Token:
        """Return the last token read."""
        return self.tokens[self.index - 1] if self.index else self.token

    def last_word(self) -> Token | None:
        """Return the last token read, ignoring layout."""
        words = (self.tokens[k] for k in range(self.index - 1, -1, -1) if self.tokens[k].kind not in LAYOUT)
        return next(words, None)

    def advance(self) -> Token:
        """Read one token."""
        token = self.token
        if token.kind != "end":
            self.index += 1
            self.token = self.tokens[self.index]
        return token

    def go_to(self, index: int) -> None:
        """Move to an index: back to a saved index, or forward to a known index."""
        self.index = index
        self.token = self.tokens[index]

    def accept(self, *words: str) -> bool:
        """Read these words if they follow, and return whether they do."""
        if self.token.text != words[0] or not self.sees(*words):
            return False
        self.go_to(self.index + len(words))
        return True

    def expect(self, word: str, purpose: str = "", hint: str = "") -> Token:
        """Read this word; `purpose` completes the message 'expected "word" ...'."""
        if self.token.text != word:
            self.missing(f'"{word}"' + (f" {purpose}" if purpose else ""), hint)
        return self.advance()

    def name(self, what: str) -> Token:
        """Read a name; `what` describes the name in messages ("a class name")."""
        if not self.is_name(self.token):
            if self.token.kind == "name":
                language = "the language" if self.token.text in PYTHON_KEYWORDS else "Scenic 3"
                self.fail(f'"{self.token.text}" is a word of {language} and cannot be {what}')
            self.missing(what)
        return self.advance()

    def word(self, what: str) -> str:
        """Read a name that may be a Scenic keyword: an attribute, or part of a module's name."""
        if self.token.kind != "name" or self.token.text in PYTHON_KEYWORDS:
            self.missing(what)
        return self.advance().text

    def at(self, start: Token, node: Node) -> Node:
        """Set the place of a node, from `start` to the last token read, ignoring layout."""
        last = self.tokens[self.index - 1]
        if last.kind in LAYOUT:
            last = self.last_word() or start
        _, _, node.lineno, node.col_offset, _, _ = start  # type: ignore[attr-defined]
        _, _, _, _, node.end_lineno, node.end_col_offset = last  # type: ignore[attr-defined]
        return node

    def stored(self, target: ast.expr) -> ast.expr:
        """Turn an expression into an assignment target."""
        if isinstance(target, ast.Starred):
            self.refuse("* variable", target)
        if not isinstance(target, ast.Name | ast.Attribute | ast.Subscript | ast.Tuple | ast.List):
            self.fail("this cannot be assigned to", at=target)
        target.ctx = STORE
        for part in target.elts if isinstance(target, ast.Tuple | ast.List) else ():
            self.stored(part)
        return target

    def deeper(self) -> None:
        """Count one more level of nesting."""
        self.nesting += 1
        if self.nesting > MAX_NESTING:
            self.fail("the program is nested too deeply here", "give parts of it names", kind="budget")

    def check_chain(self, links: int, what: str = "operators") -> None:
        """Reject very long chains of operators, whose trees would be too deep for recursive functions."""
        if links > MAX_CHAIN:
            self.fail(f"more than {MAX_CHAIN} {what} in one row", "give parts of it names", kind="budget")

    def fail(
        self, message: str, hint: str = "", *, at: Token | ast.AST | None = None, kind: str = "syntax"
    ) -> NoReturn:
        """Raise a ScenicError at a token or node, by default at the next token."""
        raise self.source.error(message, self.place(at), hint, kind)

    def missing(self, wanted: str, hint: str = "") -> NoReturn:
        """Raise ScenicError, since `wanted` was expected instead of the next token."""
        self.fail(f"expected {wanted}, found {describe(self.token)}", hint)

    def refuse(self, form: str, at: Token | ast.AST | None = None) -> NoReturn:
        """Raise ScenicError for an unsupported form of Python, given by its key in `REFUSED`."""
        message, hint = REFUSED[form]
        self.fail(message, hint, at=at, kind="unsupported")

    def place(self, at: Token | ast.AST | None = None) -> Place:
        """Return the place of an error at a token or node, by default at the next token."""
        if isinstance(at, ast.AST):
            return (at.lineno, at.col_offset, at.end_lineno, at.end_col_offset)  # type: ignore[attr-defined]
        token = at or self.token
        # An error at the end of a line has its place just after the last word, before comments and blanks.
        last = self.last_word() if token is self.token and token.kind in LAYOUT else None
        if last is not None and token.kind != "indent":
            return (last.end_line, last.end_column, last.end_line, last.end_column + 1)
        return token[2:]


def describe(token: Token) -> str:
    """Describe a token, for error messages."""
    if token.kind in LAYOUT:
        return LAYOUT[token.kind]
    text = token.text if len(token.text) <= 30 and "\n" not in token.text else token.text[:20].split("\n")[0] + "..."
    return f"'{text}'" if '"' in text else f'"{text}"'
