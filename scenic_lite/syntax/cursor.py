"""The walk over the tokens that all parts of the parser share: look, take, expect, build a node, report an error.

Read next: `parser_expressions`.
"""

from __future__ import annotations

import ast
import difflib
import keyword
from collections.abc import Iterable
from typing import NoReturn, TypeVar

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.hints import REFUSED
from scenic_lite.syntax.lexer import Source, Token

Node = TypeVar("Node", bound=ast.AST)

LOAD, STORE, DELETE = ast.Load(), ast.Store(), ast.Del()

PYTHON_KEYWORDS = frozenset(keyword.kwlist)
# Words that dialect 3 keeps for itself. In dialect 2 they are names wherever no form of the language wants them.
SCENIC_KEYWORDS = frozenset({"at", "by", "do", "new", "of", "on", "require", "to", "until"})
VALUES = frozenset({"True", "False", "None", "not", "lambda"})

# Python's own limit on recursion is 1000 calls; eight calls or so parse one level of nesting.
MAX_NESTING = 90
MAX_CHAIN = 100


class Cursor:
    """A place in a list of tokens. `token` is the one to be read next, `dialect` 2 or 3 (0: Python alone)."""

    def __init__(self, source: Source, tokens: list[Token], dialect: int) -> None:
        self.source = source
        self.tokens = tokens
        self.dialect = dialect
        self.scenic = dialect != 0
        self.index = 0
        self.token = tokens[0]
        self.nesting = 0
        self.brackets = 0  # how many are open: outside of them a line's end ends a statement
        self.keywords = PYTHON_KEYWORDS | SCENIC_KEYWORDS if dialect == 3 else PYTHON_KEYWORDS

        # Where the longer reading of a word operator's first operand was tried in vain.
        self.no_partner: set[Token] = set()

    # The two productions that lower layers refer to before they are defined.

    def expression(self) -> ast.expr:
        """`disjunction [if disjunction else expression] | lambda`; defined in parser_expressions."""
        raise NotImplementedError

    def operation(self, level: int) -> ast.expr:
        """An expression whose operators bind at `level` or tighter; defined in parser_expressions."""
        raise NotImplementedError

    # ------------------------------------------------------------ looking

    def peek(self, ahead: int = 1) -> Token:
        """The token that many places ahead."""
        index = self.index + ahead
        return self.tokens[index] if index < len(self.tokens) else self.tokens[-1]

    def sees(self, *words: str) -> bool:
        """Do these words (or signs) come next?"""
        if self.token.text != words[0]:
            return False
        return all(self.peek(k).text == word for k, word in enumerate(words[1:], 1))

    def is_name(self, token: Token) -> bool:
        """May the token be a name?"""
        return token.kind == "name" and token.text not in self.keywords

    def is_plain_name(self, token: Token) -> bool:
        """Is the token a name in every dialect?"""
        return self.is_name(token) and token.text not in SCENIC_KEYWORDS

    def starts_value(self, token: Token, signs: str = "([{") -> bool:
        """Could a value begin with this token? `signs`: the operators that count."""
        if token.kind == "name":
            return self.is_plain_name(token) or token.text in VALUES or token.text == "new"
        return token.kind in ("number", "string") or (token.kind == "operator" and token.text in signs)

    @property
    def previous(self) -> Token:
        """The token read last."""
        return self.tokens[self.index - 1] if self.index else self.token

    def last_word(self) -> Token | None:
        """The token read last that is more than layout."""
        index = self.index - 1
        while index >= 0 and self.tokens[index].kind in LAYOUT:
            index -= 1
        return self.tokens[index] if index >= 0 else None

    # ------------------------------------------------------------ moving

    def advance(self) -> Token:
        """Read one token."""
        token = self.token
        if token.kind != "end":
            self.index += 1
            self.token = self.tokens[self.index]
        return token

    def skip(self, count: int) -> None:
        """Read several tokens, known not to reach the end."""
        self.index += count
        self.token = self.tokens[self.index]

    def go_back(self, index: int) -> None:
        """Return to a place kept from before."""
        self.index = index
        self.token = self.tokens[index]

    def accept(self, *words: str) -> bool:
        """Read these words if they come next."""
        if self.token.text != words[0] or not self.sees(*words):
            return False
        self.skip(len(words))
        return True

    def expect(self, word: str, purpose: str = "", hint: str = "") -> Token:
        """Read this word; `purpose` completes the message 'expected "word" ...'."""
        if self.token.text != word:
            wanted = f'expected "{word}"' + (f" {purpose}" if purpose else "")
            self.fail(f"{wanted}, found {describe(self.token)}", hint)
        return self.advance()

    def name(self, what: str) -> Token:
        """Read a name; `what` says of what ("a class name")."""
        if not self.is_name(self.token):
            if self.token.kind == "name":
                language = "the language" if self.token.text in PYTHON_KEYWORDS else "Scenic 3"
                self.fail(f'"{self.token.text}" is a word of {language} and cannot be {what}')
            self.fail(f"expected {what}, found {describe(self.token)}")
        return self.advance()

    # ------------------------------------------------------------ building

    def at(self, start: Token | ast.AST, node: Node) -> Node:
        """Give the node its place: from `start` to the token read last."""
        if isinstance(start, Token):
            _, _, node.lineno, node.col_offset, _, _ = start  # type: ignore[attr-defined]
        else:
            node.lineno, node.col_offset = start.lineno, start.col_offset  # type: ignore[attr-defined]
        _, _, _, _, node.end_lineno, node.end_col_offset = self.tokens[self.index - 1]  # type: ignore[attr-defined]
        return node

    def stored(self, target: ast.expr, context: ast.expr_context = STORE) -> ast.expr:
        """Turn what was read as a value into what is assigned to."""
        if isinstance(target, ast.Name | ast.Attribute | ast.Subscript):
            target.ctx = context
        elif isinstance(target, ast.Starred) and context is not DELETE:
            target.ctx = context
            self.stored(target.value, context)
        elif isinstance(target, ast.Tuple | ast.List):
            target.ctx = context
            for element in target.elts:
                self.stored(element, context)
        else:
            verb = "delete" if context is DELETE else "assign to"
            self.fail(f"cannot {verb} {kind_of(target)}", at=target)
        return target

    # ------------------------------------------------------------ limits and errors

    def deeper(self) -> None:
        """Count one more level of nesting."""
        self.nesting += 1
        if self.nesting > MAX_NESTING:
            self.fail("the program is nested too deeply here", "give parts of it names", kind="budget")

    def check_chain(self, links: int, what: str = "operators") -> None:
        """Refuse endless rows of operators, whose trees would be too deep for whoever walks them."""
        if links > MAX_CHAIN:
            self.fail(f"more than {MAX_CHAIN} {what} in one row", "give parts of it names", kind="budget")

    def fail(
        self, message: str, hint: str = "", *, at: Token | ast.AST | None = None, kind: str = "syntax"
    ) -> NoReturn:
        """Raise a ScenicError at a token or node; by default at the next token."""
        raise self.error(message, hint, at=at, kind=kind)

    def refuse(self, form: str, at: Token | ast.AST | None = None) -> NoReturn:
        """Report a form of Python that the language leaves out, by its key in `REFUSED`."""
        message, hint = REFUSED[form]
        self.fail(message, hint, at=at, kind="unsupported")

    def error(
        self, message: str, hint: str = "", *, at: Token | ast.AST | None = None, kind: str = "syntax"
    ) -> ScenicError:
        """The ScenicError that `fail` raises."""
        if isinstance(at, ast.AST):
            place = (at.lineno, at.col_offset, at.end_lineno, at.end_col_offset)  # type: ignore[attr-defined]
        else:
            token = at or self.token
            # The end of a line is reported just behind its last word, wherever comments or blanks end it.
            last = self.last_word() if token is self.token and token.kind in LAYOUT else None
            if last is not None and token.kind != "indent":
                place = (last.end_line, last.end_column, last.end_line, last.end_column + 1)
            else:
                place = (token.line, token.column, token.end_line, token.end_column)
        return self.source.error(message, place, hint, kind)


LAYOUT = ("newline", "indent", "dedent", "end")


def describe(token: Token) -> str:
    """A token in words, for error messages."""
    if token.kind in LAYOUT:
        return {
            "newline": "the end of the line",
            "indent": "a deeper indentation",
            "dedent": "the end of the block",
            "end": "the end of the program",
        }[token.kind]
    text = token.text if len(token.text) <= 30 and "\n" not in token.text else token.text[:20].split("\n")[0] + "..."
    return f"'{text}'" if '"' in text else f'"{text}"'


def nearest(word: str, candidates: Iterable[str]) -> str:
    """The hint 'did you mean "..."?', or nothing when no candidate is near."""
    found = difflib.get_close_matches(word, sorted(candidates), 1, 0.7)
    return f'did you mean "{found[0]}"?' if found else ""


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
    ast.Set: "a set",
    ast.GeneratorExp: "a comprehension",
    ast.ListComp: "a comprehension",
    ast.Starred: "a starred expression",
    ast.NamedExpr: "an assignment",
}


def kind_of(node: ast.expr) -> str:
    """What an expression is, in words."""
    if isinstance(node, ast.Constant) and isinstance(node.value, bool | None):
        return str(node.value)
    return _KINDS.get(type(node), "this")
