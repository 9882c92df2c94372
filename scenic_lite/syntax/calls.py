"""What follows a value in brackets, calls and indices, and the parameters of functions.

Read next: `parser_expressions`.
"""

from __future__ import annotations

import ast

from scenic_lite.syntax.cursor import LOAD, PYTHON_KEYWORDS
from scenic_lite.syntax.displays import Displays
from scenic_lite.syntax.lexer import Token


class Calls(Displays):
    """The productions of calls, indices and parameters."""

    bare_generator: ast.expr | None = None  # the one argument read last that is a generator without brackets

    # ------------------------------------------------------------ calls and indices

    def call(self, function: ast.expr, start: Token) -> ast.Call:
        """`function(arguments)`."""
        arguments, keywords = self.arguments()
        return self.at(start, ast.Call(function, arguments, keywords))

    def arguments(self) -> tuple[list[ast.expr], list[ast.keyword]]:
        """`(value, *values, name=value, **more)`."""
        opening = self.token
        temporal = self.open()
        arguments: list[ast.expr] = []
        keywords: list[ast.keyword] = []
        while self.token.text != ")":
            start = self.token
            if start.text == "**":
                self.advance()
                keywords.append(self.at(start, ast.keyword(None, self.expression())))
            elif start.kind == "name" and self.peek().text == "=":
                keywords.append(self.keyword_argument())
            else:
                self.check_order(start, keywords)
                arguments.append(self.argument(start))
            if not self.accept(","):
                break
        self.close(")", opening, temporal)
        self.check_generators(arguments, keywords, opening)
        return arguments, keywords

    def keyword_argument(self) -> ast.keyword:
        """`name=value`."""
        start = self.token
        if start.text in PYTHON_KEYWORDS:
            self.fail(f'"{start.text}" is a word of the language and cannot be the name of an argument')
        self.skip(2)
        return self.at(start, ast.keyword(start.text, self.expression()))

    def check_order(self, start: Token, keywords: list[ast.keyword]) -> None:
        """No argument without a name behind one with a name."""
        if keywords and (start.text != "*" or any(keyword.arg is None for keyword in keywords)):
            self.fail("an argument without a name follows one with a name")

    def argument(self, start: Token) -> ast.expr:
        """`*value`, `value`, or a generator without brackets of its own."""
        if start.text == "*":
            self.advance()
            return self.at(start, ast.Starred(self.expression(), LOAD))
        value = self.assignment_expression()
        if self.begins_comprehension():
            value = self.at(start, ast.GeneratorExp(value, self.comprehensions()))
            self.bare_generator = value
        return value

    def check_generators(self, arguments: list[ast.expr], keywords: list[ast.keyword], opening: Token) -> None:
        """A generator without brackets must be the only argument; Python counts the call's brackets as its own."""
        bare, self.bare_generator = self.bare_generator, None
        if bare is None or bare not in arguments:
            return
        if len(arguments) > 1 or keywords:
            self.fail("a generator beside other arguments needs brackets of its own", at=bare)
        self.at(opening, bare)

    def index_expression(self) -> ast.expr:
        """`[index]`, `[low:high:step]`, `[a, b]`."""
        opening = self.token
        temporal = self.open()
        start = self.token
        if start.text == "]":
            self.fail("an index is missing between the brackets")
        found = [self.index_element()]
        comma = False
        while self.accept(","):
            comma = True
            if self.token.text == "]":
                break
            found.append(self.index_element())
        value = found[0]
        if comma or isinstance(value, ast.Starred):
            value = self.at(start, ast.Tuple(found, LOAD))
        self.close("]", opening, temporal)
        return value

    def index_element(self) -> ast.expr:
        """An index, a slice, or `*values`."""
        start = self.token
        lower = None if start.text == ":" else self.element()
        if self.token.text != ":" and lower is not None:
            return lower
        self.expect(":")
        bounds: list[ast.expr | None] = [None, None]
        for k in range(2):
            if self.token.text not in (":", ",", "]"):
                bounds[k] = self.expression()
            if k or not self.accept(":"):
                break
        return self.at(start, ast.Slice(lower, *bounds))

    # ------------------------------------------------------------ functions

    def lambda_expression(self) -> ast.expr:
        """`lambda parameters: expression`."""
        start = self.advance()
        parameters = self.parameters(":", annotated=False)
        self.expect(":", 'after the parameters of "lambda"')
        return self.at(start, ast.Lambda(parameters, self.expression()))

    def parameters(self, closing: str, annotated: bool) -> ast.arguments:
        """`a, b, /, c=1, *rest, d, **more`, up to but without the closing sign."""
        found = ast.arguments([], [], None, [], [], None, [])
        star = False
        names: set[str] = set()
        while self.token.text != closing:
            start = self.token
            if self.accept("/"):
                if found.posonlyargs or star or not found.args:
                    self.fail('"/" stands once, behind at least one parameter', at=start)
                found.posonlyargs, found.args = found.args, []
            elif self.accept("**"):
                found.kwarg = self.parameter(names, annotated)
                self.accept(",")
                break
            elif self.accept("*"):
                if star:
                    self.fail('a second "*" among the parameters', at=start)
                star = True
                if self.token.text != ",":
                    found.vararg = self.parameter(names, annotated, starred=True)
                elif self.peek().text in (closing, "**"):
                    self.fail('names must follow a bare "*"', at=start)
            else:
                self.plain_parameter(found, star, names, annotated)
            if not self.accept(","):
                break
        return found

    def plain_parameter(self, found: ast.arguments, star: bool, names: set[str], annotated: bool) -> None:
        """`name [: annotation] [= default]`."""
        parameter = self.parameter(names, annotated)
        default = self.expression() if self.accept("=") else None
        if star:
            found.kwonlyargs.append(parameter)
            found.kw_defaults.append(default)
            return
        found.args.append(parameter)
        if default is not None:
            found.defaults.append(default)
        elif found.defaults:
            self.fail("a parameter without a default follows one with a default", at=parameter)

    def parameter(self, names: set[str], annotated: bool, starred: bool = False) -> ast.arg:
        """`name [: annotation]`; a name used twice is an error."""
        start = self.name("a parameter")
        if start.text in names:
            self.fail(f'the parameter "{start.text}" occurs twice', at=start)
        names.add(start.text)
        annotation = None
        if annotated and self.accept(":"):
            annotation = self.element_without_assignment() if starred else self.expression()
        return self.at(start, ast.arg(start.text, annotation))
