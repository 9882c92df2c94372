"""Python's compound statements: conditions, loops, functions, classes, `try`, `with`.

Read next: `parser_scenic`, for the blocks and statements of Scenic.
"""

from __future__ import annotations

import ast
from typing import NoReturn

from scenic_lite.syntax.cursor import describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import Interrupt, TryInterrupt
from scenic_lite.syntax.operators import SEE
from scenic_lite.syntax.patterns import Patterns
from scenic_lite.syntax.specifiers import SPECIFIER_WORDS

COMPOUND = frozenset(["if", "while", "for", "with", "try", "def", "class", "async"])


class Blocks(Patterns):
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
            if start.text == "match" and self.begins_match():
                return [self.match_statement()]
            if self.scenic and (found := self.scenic_block(start)) is not None:
                return [found]
        elif start.text == "@":
            return [self.decorated()]
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
        if start.text == "async":
            return self.asynchronous()
        if start.text == "if":
            return self.if_statement()
        if start.text == "while":
            return self.while_statement()
        if start.text == "for":
            return self.for_statement(ast.For)
        if start.text == "with":
            return self.with_statement(ast.With)
        if start.text == "try":
            return self.try_statement()
        if start.text == "def":
            return self.function(ast.FunctionDef, [])
        return self.class_statement([])

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
            hint = self.missing_operator_hint()
            if owner == 'the head of "with"' and self.token.kind != "newline":
                hint = "a specifier follows a class, or a comma after another specifier"
            self.fail(f'expected ":" after {owner}, found {describe(self.token)}', hint)
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

    def spanning(self, start: Token, node: ast.stmt | ast.ExceptHandler, last: list[ast.stmt]) -> ast.stmt:
        """Place a statement that ends where the last of its blocks ends."""
        node.lineno, node.col_offset = start.line, start.column
        node.end_lineno, node.end_col_offset = last[-1].end_lineno, last[-1].end_col_offset
        return node  # type: ignore[return-value]

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

    def for_statement(self, make: type[ast.For] | type[ast.AsyncFor], start: Token | None = None) -> ast.stmt:
        """`for targets in values: ... else: ...`."""
        word = self.advance()
        target = self.targets()
        self.expect("in", 'after the variable of "for"', 'write "for x in values:"')
        values = self.expressions()
        body = self.block('the head of "for"')
        rest = self.else_block()
        return self.spanning(start or word, make(target, values, body, rest), rest or body)

    def asynchronous(self) -> ast.stmt:
        """`async def`, `async for`, `async with`."""
        start = self.advance()
        if self.token.text == "def":
            return self.function(ast.AsyncFunctionDef, [], start)
        if self.token.text == "for":
            return self.for_statement(ast.AsyncFor, start)
        if self.token.text == "with":
            return self.with_statement(ast.AsyncWith, start)
        self.fail(f'expected "def", "for" or "with" after "async", found {describe(self.token)}')

    # ------------------------------------------------------------ with and try

    def with_statement(self, make: type[ast.With] | type[ast.AsyncWith], start: Token | None = None) -> ast.stmt:
        """`with value as target, ...: ...`."""
        word = self.advance()
        items = self.bracketed_items() if self.token.text == "(" else None
        if items is None:
            items = self.with_items()
        body = self.block('the head of "with"')
        return self.spanning(start or word, make(items, body), body)

    def bracketed_items(self) -> list[ast.withitem] | None:
        """`(value as target, ...)`: None if the bracket belongs to a value."""
        index, depth, ahead = self.index, 0, 0
        while True:  # the lexer has matched the brackets
            token = self.peek(ahead)
            depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
            ahead += 1
            if depth == 0:
                break
        if self.peek(ahead).text != ":":
            return None
        inside = [self.peek(k) for k in range(1, ahead - 1)]
        if not _has_items(inside):
            return None
        self.go_back(index)
        self.advance()
        self.brackets += 1
        items = self.with_items()
        self.expect(")", 'to close the bracket of "with"')
        self.brackets -= 1
        return items

    def with_items(self) -> list[ast.withitem]:
        """`value [as target], ...`."""
        items: list[ast.withitem] = []
        while not items or self.accept(","):
            if items and self.token.text == ")":
                break
            value = self.expression()
            target = self.stored(self.operation(SEE)) if self.accept("as") else None
            items.append(ast.withitem(value, target))
        return items

    def try_statement(self) -> ast.stmt:
        """`try: ... interrupt when condition: ... except ...: ... else: ... finally: ...`."""
        start = self.advance()
        body = self.block('"try"')
        interrupts: list[Interrupt] = []
        while self.scenic and self.sees("interrupt"):
            interrupts.append(self.interrupt())
        handlers: list[ast.ExceptHandler] = []
        starred = self.sees("except", "*")
        while self.token.text == "except":
            handlers.append(self.handler(starred))
        rest = self.else_block() if handlers or interrupts else []
        final = self.block('"finally"') if self.accept("finally") else []
        if not handlers and not final and not interrupts:
            wanted = '"interrupt when", "except" or "finally"' if self.scenic else '"except" or "finally"'
            self.fail(f'expected {wanted} after the block of "try", found {describe(self.token)}')
        last: list = final or rest or handlers or interrupts or body
        if interrupts:
            return self.spanning(start, TryInterrupt(body, interrupts, handlers, rest, final), last)
        make = ast.TryStar if starred else ast.Try
        return self.spanning(start, make(body, handlers, rest, final), last)

    def interrupt(self) -> Interrupt:
        """`interrupt when condition: ...`."""
        start = self.advance()
        self.expect("when", 'after "interrupt"', 'write "interrupt when condition:"')
        condition = self.condition()
        body = self.block('the condition of "interrupt when"')
        return self.spanning(start, Interrupt(condition, body), body)  # type: ignore[return-value]

    def handler(self, starred: bool) -> ast.ExceptHandler:
        """`except [exceptions [as name]]: ...`."""
        start = self.advance()
        if self.accept("*") != starred:
            self.fail('"except" and "except*" cannot be mixed', at=start)
        kind = name = None
        if self.token.text != ":":
            kind = self.expression()
            if self.token.text == ",":
                self.fail("several exceptions need brackets", 'write "except (A, B):"')
            name = self.name("a variable").text if self.accept("as") else None
        body = self.block('"except"')
        return self.spanning(start, ast.ExceptHandler(kind, name, body), body)  # type: ignore[return-value]

    # ------------------------------------------------------------ functions and classes

    def function(
        self,
        make: type[ast.FunctionDef] | type[ast.AsyncFunctionDef],
        decorators: list[ast.expr],
        start: Token | None = None,
    ) -> ast.stmt:
        """`def name(parameters) [-> annotation]: ...`."""
        word = self.advance()
        name = self.name("the name of a function").text
        parameters = self.bracketed_parameters(f'the name of the function "{name}"')
        returns = self.expression() if self.accept("->") else None
        body = self.block(f'the head of the function "{name}"')
        node = make(name, parameters, body, decorators, returns)
        node.type_params = []  # type: ignore[union-attr]  # a field from Python 3.12 on
        return self.spanning(start or word, node, body)

    def bracketed_parameters(self, owner: str) -> ast.arguments:
        """`(parameters)`."""
        if self.token.text != "(":
            self.fail(f'expected "(" after {owner}, found {describe(self.token)}', 'write "()" if it takes nothing')
        opening = self.token
        temporal = self.open()
        parameters = self.parameters(")", annotated=True)
        self.close(")", opening, temporal)
        return parameters

    def class_statement(self, decorators: list[ast.expr]) -> ast.stmt:
        """`class Name(bases): ...`."""
        start = self.advance()
        name = self.name("the name of a class").text
        bases: list[ast.expr] = []
        keywords: list[ast.keyword] = []
        if self.token.text == "(":
            bases, keywords = self.arguments()
        body = self.block(f'the head of the class "{name}"', of_class=True)
        node = ast.ClassDef(name, bases, keywords, body, decorators)
        node.type_params = []  # type: ignore[attr-defined]
        return self.spanning(start, node, body)

    def decorated(self) -> ast.stmt:
        """`@decorator` lines before a function or class."""
        decorators: list[ast.expr] = []
        while self.accept("@"):
            decorators.append(self.assignment_expression())
            if self.token.kind != "newline":
                self.fail(f"expected the end of the line after the decorator, found {describe(self.token)}")
            self.advance()
        if self.token.text == "class":
            return self.class_statement(decorators)
        if self.token.text == "async":
            start = self.advance()
            return self.function(ast.AsyncFunctionDef, decorators, start)
        if self.token.text != "def":
            self.fail(f"expected a function or a class after the decorator, found {describe(self.token)}")
        return self.function(ast.FunctionDef, decorators)


def _has_items(inside: list[Token]) -> bool:
    """Are the tokens between the brackets of `with (...):` several items, or one with `as`?"""
    depth, found = 0, False
    for token in inside:
        depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
        if depth == 0:
            if token.text in ("for", "yield", ":=", "lambda", "*"):
                return False
            found = found or token.text in ("as", ",")
    return found
