"""Python's simple statements, the end of a statement, and the hints for statements that go wrong.

Read next: `parser_blocks`, for the statements that have other statements in them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import NoReturn

from scenic_lite.syntax.cursor import DELETE, PYTHON_KEYWORDS, describe, nearest
from scenic_lite.syntax.expressions import Expressions
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import New
from scenic_lite.syntax.operators import INFIX_WORDS
from scenic_lite.syntax.specifiers import SPECIFIER_WORDS, specifier_hint

AUGMENTED: dict[str, ast.operator] = {
    "+=": ast.Add(),
    "-=": ast.Sub(),
    "*=": ast.Mult(),
    "/=": ast.Div(),
    "//=": ast.FloorDiv(),
    "%=": ast.Mod(),
    "**=": ast.Pow(),
    ">>=": ast.RShift(),
    "<<=": ast.LShift(),
    "&=": ast.BitAnd(),
    "^=": ast.BitXor(),
    "|=": ast.BitOr(),
    "@=": ast.MatMult(),
}

_WORDS = """
abort behavior class compose def do elif else except finally for from if import interrupt invariant model monitor mutate
override param precondition raise record require return scenario setup simulator take terminate try wait while with
"""
STATEMENT_WORDS = frozenset(_WORDS.split())
# What other languages, or other spellings, would write.
_FOREIGN = {
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


class SimpleStatements(Expressions):
    """The productions of Python's statements that fit on a line."""

    class_body = False  # directly in the body of a class

    def simple_line(self) -> list[ast.stmt]:
        """`statement [; statement]*` up to the end of the line."""
        found = [self.simple_statement()]
        while self.accept(";"):
            if self.token.kind == "newline":
                break
            found.append(self.simple_statement())
        self.end_of_line(found[-1])
        return found

    def simple_statement(self) -> ast.stmt:
        """One statement."""
        start = self.token
        if start.kind == "name":
            keyword = PYTHON_STATEMENTS.get(start.text)
            if keyword is not None:
                return self.at(start, keyword(self))
            if self.scenic:
                found = self.scenic_statement(start)
                if found is not None:
                    return self.at(start, found)
        return self.expression_statement()

    def scenic_statement(self, start: Token) -> ast.stmt | None:
        """A statement of Scenic that fits on a line; defined in parser_scenic."""
        raise NotImplementedError

    def end_of_line(self, last: ast.stmt) -> None:
        """Read the end of the line, and the end of the block in which its specifiers stood."""
        if self.token.kind == "newline":
            self.advance()
        elif self.token.kind != "end":
            self.unexpected_end(last)
        for _ in range(self.specifier_indents):
            if self.token.kind != "dedent":
                self.fail("the line belongs neither to the specifiers above nor to the block before", "indent it less")
            self.advance()
        self.specifier_indents = 0

    # ------------------------------------------------------------ hints

    def unexpected_end(self, last: ast.stmt) -> NoReturn:
        """Report what follows a statement on its line."""
        token, before = self.token, self.previous
        found = describe(token)
        if token.text == ":":
            self.fail(f"unexpected {found} after the statement", self.colon_hint(last))
        if token.text in ("&", "|", "!"):
            self.fail(f"unexpected {found}", 'the logical operators are "and", "or", "not"')
        if token.kind == "name" and before.kind == "name":
            self.two_words(last, token, before)
        hint = _FOREIGN.get(token.text, "") or self.missing_operator_hint()
        self.fail(f"unexpected {found} after the end of the statement", hint)

    def two_words(self, last: ast.stmt, token: Token, before: Token) -> None:
        """Two names side by side: a misspelt first word, or a misspelt specifier."""
        alone = isinstance(last, ast.Expr) and isinstance(last.value, New | ast.Name)
        if alone and before.text in _FOREIGN:
            self.fail(f'unknown statement "{before.text}"', _FOREIGN[before.text], at=before)
        if alone and (hint := nearest(before.text, STATEMENT_WORDS)):
            self.fail(f'unknown statement "{before.text}"', hint, at=before)
        if token.text == "with":
            self.fail(f'expected a property name after "with", found {describe(self.peek())}', at=self.peek())
        if before.text[:1].isupper() and token.text not in INFIX_WORDS:
            self.fail(f'unknown specifier "{token.text}"', specifier_hint(token.text))
        if token.text in SPECIFIER_WORDS and token.text not in INFIX_WORDS:
            self.fail(f'unexpected specifier "{token.text}"', 'specifiers follow a class: "Ball ahead of ego by 2"')

    def colon_hint(self, last: ast.stmt) -> str:
        """Which statement might have been meant that ends with a colon?"""
        value = last.value if isinstance(last, ast.Expr) else None
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name):
            return nearest(value.func.id, STATEMENT_WORDS)
        return ""

    def missing_operator_hint(self) -> str:
        """What might be missing before the present token."""
        token, before = self.token, self.previous
        if token.text in _FOREIGN:
            return _FOREIGN[token.text]
        if before.text == ",":
            return "no comma stands between a class and its first specifier" if token.text in SPECIFIER_WORDS else ""
        if before.text in ("relative", "apparent"):
            return f'write "{before.text} heading of X"'
        if before.text in ("distance", "angle"):
            return f'write "{before.text} from X to Y"'
        if before.text == "print":
            return 'a function is called with brackets: "print(...)"'
        if self.class_body and before.kind == "name":
            return f'a property is written "{before.text}: default"'
        return "is an operator or a comma missing?" if self.starts_value(token) else ""

    # ------------------------------------------------------------ expressions and assignments

    def expression_statement(self) -> ast.stmt:
        """`value`, `target = ... = value`, `target += value`, `target: annotation [= value]`."""
        start = self.token
        value = self.expressions()
        text = self.token.text
        if text == "=":
            return self.assignment(start, value)
        if text in AUGMENTED:
            if not isinstance(value, ast.Name | ast.Attribute | ast.Subscript):
                self.fail(f'cannot use "{text}" here', at=value)
            self.advance()
            self.stored(value)
            return self.at(start, ast.AugAssign(value, AUGMENTED[text], self.assigned_value()))
        if text == ":" and isinstance(value, ast.Name | ast.Attribute | ast.Subscript):
            return self.annotation(start, value)
        return self.at(start, ast.Expr(self.lone_class(value, start)))

    def assignment(self, start: Token, value: ast.expr) -> ast.stmt:
        """`target = ... = value`."""
        targets: list[ast.expr] = []
        while self.accept("="):
            targets.append(self.stored(self.not_an_instance(value)))
            place = self.token
            value = self.assigned_value()
            self.check_chain(len(targets), "targets")
        return self.at(start, ast.Assign(targets, self.lone_class(value, place)))

    def not_an_instance(self, value: ast.expr) -> ast.expr:
        """A target that reads like an instance is a mistake worth its own words."""
        if isinstance(value, New):
            self.fail("cannot assign to an instance", 'write "name = Class specifiers"', at=value)
        return value

    def assigned_value(self) -> ast.expr:
        """What follows an `=`."""
        if self.token.kind in ("newline", "end"):
            self.fail('expected a value after "="')
        return self.expressions()

    def annotation(self, start: Token, target: ast.Name | ast.Attribute | ast.Subscript) -> ast.stmt:
        """`target: annotation [= value]`."""
        self.advance()
        if self.token.kind == "newline":
            if hint := self.word_hint(start):
                self.fail(f'unknown statement "{start.text}"', hint, at=start)
            self.fail('expected an annotation after ":"')
        annotation = self.expression()
        value = self.assigned_value() if self.accept("=") else None
        simple = int(isinstance(target, ast.Name) and start.text != "(")
        self.stored(target)
        return self.at(start, ast.AnnAssign(target, annotation, value, simple))

    def word_hint(self, start: Token) -> str:
        """For `esle:` and its like."""
        return _FOREIGN.get(start.text, "") or nearest(start.text, STATEMENT_WORDS)

    # ------------------------------------------------------------ keywords

    def pass_statement(self) -> ast.stmt:
        self.advance()
        return ast.Pass()

    def break_statement(self) -> ast.stmt:
        self.advance()
        return ast.Break()

    def continue_statement(self) -> ast.stmt:
        self.advance()
        return ast.Continue()

    def ends_here(self) -> bool:
        """Does the statement end before the next token?"""
        return self.token.kind in ("newline", "end") or self.token.text == ";"

    def return_statement(self) -> ast.stmt:
        """`return [values]`."""
        self.advance()
        return ast.Return(None if self.ends_here() else self.expressions())

    def assert_statement(self) -> ast.stmt:
        """`assert condition [, message]`."""
        self.advance()
        self.asks_truth = True
        condition = self.expression()
        return ast.Assert(condition, self.expression() if self.accept(",") else None)

    def delete_statement(self) -> ast.stmt:
        """`del targets`."""
        self.advance()
        found: list[ast.expr] = []
        while not found or self.accept(","):
            if found and self.ends_here():
                break
            found.append(self.stored(self.operation(0), DELETE))
        return ast.Delete(found)

    def global_statement(self) -> ast.stmt:
        """`global names`, `nonlocal names`."""
        make = ast.Global if self.advance().text == "global" else ast.Nonlocal
        names = [self.name("a variable").text]
        while self.accept(","):
            names.append(self.name("a variable").text)
        return make(names)

    def import_statement(self) -> ast.stmt:
        """`import a.b [as c], ...`."""
        self.advance()
        found: list[ast.alias] = []
        while not found or self.accept(","):
            start = self.token
            module = self.dotted_name("a module")
            found.append(self.at(start, ast.alias(module, self.name("a name").text if self.accept("as") else None)))
        return ast.Import(found)

    def import_from_statement(self) -> ast.stmt:
        """`from module import names`."""
        self.advance()
        level = 0
        while self.token.text in (".", "..."):
            level += len(self.advance().text)
        module = None if level and self.token.text == "import" else self.dotted_name("a module")
        self.expect("import", 'after "from" and a module', 'write "from module import name"')
        if self.token.text == "*":
            start = self.advance()
            return ast.ImportFrom(module, [self.at(start, ast.alias("*", None))], level)
        bracket = self.token
        if bracket.text == "(":
            self.open()
        found: list[ast.alias] = []
        while not found or self.accept(","):
            if found and bracket.text == "(" and self.token.text == ")":
                break
            start = self.name("a name to import")
            name = self.name("a name").text if self.accept("as") else None
            found.append(self.at(start, ast.alias(start.text, name)))
        if bracket.text == "(":
            self.close(")", bracket, False)
        return ast.ImportFrom(module, found, level)

    def dotted_name(self, what: str) -> str:
        """`a.b.c`."""
        parts = [self.module_part(what)]
        while self.accept("."):
            parts.append(self.module_part(what))
        return ".".join(parts)

    def module_part(self, what: str) -> str:
        """One part of a dotted name; words of Scenic are no obstacle there."""
        if self.token.kind != "name" or self.token.text in PYTHON_KEYWORDS:
            self.fail(f"expected the name of {what}, found {describe(self.token)}")
        return self.advance().text

    def refused(self) -> ast.stmt:
        """A statement of Python that the language leaves out."""
        if self.peek().text == "=":
            self.fail(f'"{self.token.text}" is a word of the language and cannot be the name of a variable')
        self.refuse(self.token.text)

    def misplaced(self) -> ast.stmt:
        """A word that only continues a statement which is not there."""
        word = self.token.text
        owner = {"elif": "if", "else": "if", "except": "try", "finally": "try", "in": "for"}.get(word, "")
        if self.peek().text == "=":
            self.fail(f'"{word}" is a word of the language and cannot be the name of a variable')
        self.fail(f'"{word}" without "{owner}" before it' if owner else f'a statement cannot begin with "{word}"')


PYTHON_STATEMENTS: dict[str, Callable[[SimpleStatements], ast.stmt]] = {
    "pass": SimpleStatements.pass_statement,
    "break": SimpleStatements.break_statement,
    "continue": SimpleStatements.continue_statement,
    "return": SimpleStatements.return_statement,
    "assert": SimpleStatements.assert_statement,
    "del": SimpleStatements.delete_statement,
    "global": SimpleStatements.global_statement,
    "nonlocal": SimpleStatements.global_statement,
    "raise": SimpleStatements.refused,
    "yield": SimpleStatements.refused,
    "async": SimpleStatements.refused,
    "import": SimpleStatements.import_statement,
    "from": SimpleStatements.import_from_statement,
    "elif": SimpleStatements.misplaced,
    "else": SimpleStatements.misplaced,
    "except": SimpleStatements.misplaced,
    "finally": SimpleStatements.misplaced,
    "in": SimpleStatements.misplaced,
    "is": SimpleStatements.misplaced,
    "and": SimpleStatements.misplaced,
    "or": SimpleStatements.misplaced,
    "as": SimpleStatements.misplaced,
}
