"""Python's `match` statement and its patterns.

Read next: `parser_blocks`.
"""

from __future__ import annotations

import ast

from scenic_lite.syntax.cursor import LOAD, describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.operators import SUM
from scenic_lite.syntax.statements import SimpleStatements

_CONSTANTS = {"True": True, "False": False, "None": None}


class Patterns(SimpleStatements):
    """The productions of `match`."""

    def block(self, owner: str, of_class: bool = False) -> list[ast.stmt]:
        """The statements after a colon; defined in parser_blocks."""
        raise NotImplementedError

    def indented(self, owner: str) -> None:
        """The beginning of an indented block; defined in parser_blocks."""
        raise NotImplementedError

    def end_block(self) -> None:
        """The end of an indented block; defined in parser_blocks."""
        raise NotImplementedError

    def begins_match(self) -> bool:
        """Is `match` the statement and not a name? Only then a line that ends in ":" and an indented `case` follow."""
        following = self.peek()
        if following.kind == "newline" or following.text in ("=", ".", ",", ")", ":"):
            return False
        ahead = 1
        while self.peek(ahead).kind not in ("newline", "end"):
            ahead += 1
        if self.peek(ahead - 1).text != ":" or self.peek(ahead + 1).kind != "indent":
            return False
        return self.peek(ahead + 2).text == "case"

    def match_statement(self) -> ast.stmt:
        """`match values:` with its cases."""
        start = self.advance()
        subject = self.element()
        if self.token.text == ",":
            subject = self.at(subject, ast.Tuple(self.elements(":", subject), LOAD))
        self.expect(":", 'after the value of "match"')
        self.indented('the value of "match"')
        cases: list[ast.match_case] = []
        while self.token.kind != "dedent":
            cases.append(self.case())
        self.end_block()
        node = ast.Match(subject, cases)
        node.lineno, node.col_offset = start.line, start.column
        last = cases[-1].body[-1]
        node.end_lineno, node.end_col_offset = last.end_lineno, last.end_col_offset
        return node

    def case(self) -> ast.match_case:
        """`case patterns [if condition]: ...`."""
        self.expect("case", 'in the block of "match"')
        pattern = self.patterns()
        guard = self.assignment_expression() if self.accept("if") else None
        return ast.match_case(pattern, guard, self.block('the pattern of "case"'))

    def patterns(self) -> ast.pattern:
        """`pattern`, or several without brackets: a sequence."""
        start = self.token
        first = self.starred_pattern()
        if self.token.text != ",":
            if isinstance(first, ast.MatchStar):
                self.fail("a starred pattern cannot stand alone", at=start)
            return first
        found = [first]
        while self.accept(","):
            if self.token.text in (":", "if"):
                break
            found.append(self.starred_pattern())
        return self.at(start, ast.MatchSequence(found))

    def starred_pattern(self) -> ast.pattern:
        """`*name`, or a pattern."""
        start = self.token
        if not self.accept("*"):
            return self.pattern()
        name = self.name("a variable").text
        return self.at(start, ast.MatchStar(None if name == "_" else name))

    def pattern(self) -> ast.pattern:
        """`pattern | pattern [as name]`."""
        self.deeper()
        start = self.token
        found = [self.closed_pattern()]
        while self.accept("|"):
            found.append(self.closed_pattern())
        value = found[0] if len(found) == 1 else self.at(start, ast.MatchOr(found))
        if self.accept("as"):
            value = self.at(start, ast.MatchAs(value, self.name("a variable").text))
        self.nesting -= 1
        return value

    def closed_pattern(self) -> ast.pattern:
        """A pattern without `|` and `as`."""
        token = self.token
        if token.text in _CONSTANTS:
            self.advance()
            return self.at(token, ast.MatchSingleton(_CONSTANTS[token.text]))
        if token.kind in ("number", "string") or token.text == "-":
            return self.at(token, ast.MatchValue(self.operation(SUM)))
        if token.text in ("(", "["):
            return self.sequence_pattern()
        if token.text == "{":
            return self.mapping_pattern()
        if not self.is_name(token):
            self.fail(f"expected a pattern, found {describe(token)}")
        return self.name_pattern(token)

    def name_pattern(self, token: Token) -> ast.pattern:
        """`_`, a variable, `a.b`, `Class(...)`."""
        self.advance()
        if self.token.text not in (".", "("):
            return self.at(token, ast.MatchAs(None, None if token.text == "_" else token.text))
        value: ast.expr = self.at(token, ast.Name(token.text, LOAD))
        while self.accept("."):
            value = self.at(token, ast.Attribute(value, self.attribute(), LOAD))
        if self.token.text == "(":
            return self.class_pattern(token, value)
        return self.at(token, ast.MatchValue(value))

    def sequence_pattern(self) -> ast.pattern:
        """`(pattern)`, `(a, b)`, `[a, b]`."""
        opening = self.token
        closing = ")" if opening.text == "(" else "]"
        self.open()
        found: list[ast.pattern] = []
        comma = False
        while self.token.text != closing:
            found.append(self.starred_pattern())
            if not self.accept(","):
                break
            comma = True
        single = closing == ")" and len(found) == 1 and not comma and not isinstance(found[0], ast.MatchStar)
        self.close(closing, opening, False)
        return found[0] if single else self.at(opening, ast.MatchSequence(found))

    def mapping_pattern(self) -> ast.pattern:
        """`{key: pattern, **rest}`."""
        opening = self.token
        self.open()
        keys: list[ast.expr] = []
        patterns: list[ast.pattern] = []
        rest = None
        while self.token.text != "}":
            if self.accept("**"):
                rest = self.name("a variable").text
            else:
                keys.append(self.operation(SUM))
                self.expect(":", "after the key of the pattern")
                patterns.append(self.pattern())
            if not self.accept(","):
                break
        self.close("}", opening, False)
        return self.at(opening, ast.MatchMapping(keys, patterns, rest))

    def class_pattern(self, start: Token, cls: ast.expr) -> ast.pattern:
        """`Class(pattern, name=pattern)`."""
        opening = self.token
        self.open()
        patterns: list[ast.pattern] = []
        names: list[str] = []
        named: list[ast.pattern] = []
        while self.token.text != ")":
            if self.is_name(self.token) and self.peek().text == "=":
                names.append(self.advance().text)
                self.advance()
                named.append(self.pattern())
            elif names:
                self.fail("a pattern without a name follows one with a name")
            else:
                patterns.append(self.pattern())
            if not self.accept(","):
                break
        self.close(")", opening, False)
        return self.at(start, ast.MatchClass(cls, patterns, names, named))
