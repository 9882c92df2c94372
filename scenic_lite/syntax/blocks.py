"""Python's compound statements: conditions, loops, functions, classes; Scenic's `try`.

Read next: `parser_scenic`, for the blocks and statements of Scenic.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import NoReturn

from scenic_lite.syntax.cursor import describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import Interrupt, TryInterrupt
from scenic_lite.syntax.specifiers import SPECIFIER_WORDS
from scenic_lite.syntax.statements import SimpleStatements

COMPOUND = frozenset(["if", "while", "for", "try", "def", "class"])


class Blocks(SimpleStatements):
    """The productions of Python's statements that contain others."""

    def module(self) -> ast.Module:
        """The whole program."""
        body: list[ast.stmt] = []
        while self.token.kind != "end":
            body.extend(self.statement())
        return ast.Module(body, [])

    def statement(self) -> list[ast.stmt]:
        """One compound statement, or a line of simple ones."""
        start = self.token
        if start.kind == "indent":
            self.unexpected_indent()
        if start.kind == "name":
            if start.text in COMPOUND:
                return [self.compound(start)]
            if start.text in ("match", "with"):
                self.refuse_block(start)
            if self.scenic and (found := self.scenic_block(start)) is not None:
                return [found]
        elif start.text == "@":
            self.refuse("decorator")
        return self.simple_line()

    def unexpected_indent(self) -> NoReturn:
        """Report an indented line that no colon or comma announces."""
        hint = "only a block is indented, after a colon"
        if self.peek().text in SPECIFIER_WORDS:
            hint = "a comma at the end of the line before lets its specifiers go on"
        self.fail("the line is indented deeper than the one before", hint, at=self.peek())

    def compound(self, start: Token) -> ast.stmt:
        """A statement that begins with a word of COMPOUND."""
        if self.peek().text == "=":
            self.fail(f'"{start.text}" is a word of the language and cannot be the name of a variable')
        if start.text == "if":
            return self.if_statement()
        if start.text == "while":
            return self.while_statement()
        if start.text == "for":
            return self.for_statement()
        if start.text == "try":
            return self.try_statement()
        if start.text == "def":
            return self.function()
        return self.class_statement()

    def refuse_block(self, start: Token) -> None:
        """Refuse Python's `match` and `with`, each by what follows; `match` may also be a name, `with` a specifier."""
        ahead = 1
        while self.peek(ahead).kind not in ("newline", "end"):
            ahead += 1
        case = self.peek(ahead + 1).kind == "indent" and self.peek(ahead + 2).text == "case"
        if case if start.text == "match" else ":" in [self.peek(k).text for k in range(ahead)]:
            self.refuse(start.text)
        if start.text == "with":
            hint = "a specifier follows a class, or a comma after another specifier"
            self.fail('expected a value, found the word "with"', hint)

    def scenic_block(self, start: Token) -> ast.stmt | None:
        """A block of Scenic; defined in parser_scenic."""
        raise NotImplementedError

    # ------------------------------------------------------------ blocks

    def block(self, owner: str, of_class: bool = False) -> list[ast.stmt]:
        """`: statements`, on the same line or indented below; `owner` says whose, for messages."""
        self.colon(owner)
        outer, self.class_body = self.class_body, of_class
        if self.token.kind == "newline":
            self.indented(owner)
            body: list[ast.stmt] = []
            while self.token.kind != "dedent":
                body.extend(self.statement())
            self.end_block()
        else:
            self.deeper()
            body = self.simple_line()
            self.nesting -= 1
        self.class_body = outer
        return body

    def colon(self, owner: str) -> None:
        """The colon before a block."""
        if self.token.text == "=":
            self.fail('"=" assigns and cannot stand in a condition', '"==" compares')
        if self.token.text != ":":
            self.fail(f'expected ":" after {owner}, found {describe(self.token)}', self.missing_operator_hint())
        self.advance()

    def indented(self, owner: str) -> None:
        """The line's end and the indentation that begin a block."""
        self.deeper()
        if self.token.kind != "newline":
            self.fail(f"expected a new line after {owner}, found {describe(self.token)}")
        self.advance()
        if self.token.kind != "indent":
            line = self.previous.line
            self.fail(f"expected an indented block after {owner} in line {line}, found {describe(self.token)}")
        self.advance()

    def end_block(self) -> None:
        """The end of an indented block."""
        self.advance()
        self.nesting -= 1

    def spanning(self, start: Token, node: ast.stmt, last: Sequence[ast.stmt]) -> ast.stmt:
        """Place a statement that ends where the last of its blocks ends."""
        node.lineno, node.col_offset = start.line, start.column
        node.end_lineno, node.end_col_offset = last[-1].end_lineno, last[-1].end_col_offset
        return node

    def else_block(self) -> list[ast.stmt]:
        """`else: ...`, if it is there."""
        if self.token.text != "else":
            return []
        self.advance()
        if self.token.text == "if":
            self.fail('"else if" is written "elif"')
        return self.block('"else"')

    # ------------------------------------------------------------ conditions and loops

    def if_statement(self) -> ast.stmt:
        """`if ...: ... elif ...: ... else: ...`; a long row of `elif` is read in a loop."""
        parts: list[tuple[Token, ast.expr, list[ast.stmt]]] = []
        while not parts or self.token.text == "elif":
            start = self.advance()
            condition = self.condition()
            parts.append((start, condition, self.block(f'the condition of "{start.text}"')))
            self.check_chain(len(parts), "conditions")
        rest = self.else_block()
        for start, condition, body in reversed(parts):
            rest = [self.spanning(start, ast.If(condition, body, rest), rest or body)]
        return rest[0]

    def while_statement(self) -> ast.stmt:
        """`while condition: ... else: ...`."""
        start = self.advance()
        condition = self.condition()
        body = self.block('the condition of "while"')
        rest = self.else_block()
        return self.spanning(start, ast.While(condition, body, rest), rest or body)

    def for_statement(self) -> ast.stmt:
        """`for targets in values: ... else: ...`."""
        start = self.advance()
        target = self.targets()
        self.expect("in", 'after the variable of "for"', 'write "for x in values:"')
        values = self.expressions()
        body = self.block('the head of "for"')
        rest = self.else_block()
        return self.spanning(start, ast.For(target, values, body, rest), rest or body)

    # ------------------------------------------------------------ try

    def try_statement(self) -> ast.stmt:
        """`try: ... interrupt when condition: ...`."""
        start = self.advance()
        body = self.block('"try"')
        interrupts: list[Interrupt] = []
        while self.sees("interrupt"):
            interrupts.append(self.interrupt())
        if self.token.text in ("except", "finally") or (interrupts and self.token.text == "else"):
            self.refuse(self.token.text)
        if not interrupts:
            self.fail(f'expected "interrupt when" after the block of "try", found {describe(self.token)}')
        return self.spanning(start, TryInterrupt(body, interrupts, [], [], []), interrupts)

    def interrupt(self) -> Interrupt:
        """`interrupt when condition: ...`."""
        start = self.advance()
        self.expect("when", 'after "interrupt"', 'write "interrupt when condition:"')
        condition = self.condition()
        body = self.block('the condition of "interrupt when"')
        return self.spanning(start, Interrupt(condition, body), body)  # type: ignore[return-value]

    # ------------------------------------------------------------ functions and classes

    def function(self) -> ast.stmt:
        """`def name(parameters) [-> annotation]: ...`."""
        start = self.advance()
        name = self.name("the name of a function").text
        parameters = self.bracketed_parameters(f'the name of the function "{name}"')
        returns = self.expression() if self.accept("->") else None
        body = self.block(f'the head of the function "{name}"')
        node = ast.FunctionDef(name, parameters, body, [], returns)
        node.type_params = []  # type: ignore[attr-defined]  # a field from Python 3.12 on
        return self.spanning(start, node, body)

    def bracketed_parameters(self, owner: str) -> ast.arguments:
        """`(parameters)`."""
        if self.token.text != "(":
            self.fail(f'expected "(" after {owner}, found {describe(self.token)}', 'write "()" if it takes nothing')
        opening = self.token
        temporal = self.open()
        parameters = self.parameters(")", annotated=True)
        self.close(")", opening, temporal)
        return parameters

    def class_statement(self) -> ast.stmt:
        """`class Name(bases): ...`."""
        start = self.advance()
        name = self.name("the name of a class").text
        bases: list[ast.expr] = []
        keywords: list[ast.keyword] = []
        if self.token.text == "(":
            bases, keywords = self.arguments()
        body = self.block(f'the head of the class "{name}"', of_class=True)
        node = ast.ClassDef(name, bases, keywords, body, [])
        node.type_params = []  # type: ignore[attr-defined]
        return self.spanning(start, node, body)
