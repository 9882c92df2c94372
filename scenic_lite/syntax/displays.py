"""Values that are not operators: names, constants, brackets with what is in them.

Read next: `parser_calls`.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from typing import NoReturn

from scenic_lite.syntax import literals
from scenic_lite.syntax.cursor import LOAD, PYTHON_KEYWORDS, SCENIC_KEYWORDS, STORE, describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.operators import OR, SEE
from scenic_lite.syntax.specifiers import Instances

_CONSTANTS = {"True": True, "False": False, "None": None}
_MISPLACED = {
    "by": 'a distance follows its specifier: "ahead of X by 2"',
    "at": 'an instance is written "Class at X"',
    "else": 'a choice is written "a if condition else b"',
    "to": 'write "distance from X to Y"',
}


class Displays(Instances):
    """The productions of values."""

    operators: Mapping[str, object]

    def set_temporal(self, on: bool) -> bool:
        """Let `always`, `until` ... count, or not; returns what was before. Defined in parser_expressions."""
        raise NotImplementedError

    def atom(self, token: Token) -> ast.expr:
        """A name, a constant, or something in brackets; `token` is the next one."""
        kind, text = token.kind, token.text
        if kind == "name":
            if text not in PYTHON_KEYWORDS and text not in SCENIC_KEYWORDS:
                self.advance()
                return self.at(token, ast.Name(text, LOAD))
            return self.keyword_atom(token)
        if kind == "number":
            self.advance()
            return self.at(token, ast.Constant(self.number(token)))
        if kind == "string":
            return self.strings()
        if text == "(":
            return self.group()
        if text == "[":
            return self.list_display()
        if text == "{":
            return self.braces()
        if text == "...":
            self.advance()
            return self.at(token, ast.Constant(...))
        self.no_value(token)

    def no_value(self, token: Token) -> NoReturn:
        """Report a sign where a value should be."""
        before, hint = self.previous.text, ""
        if token.text in ("&", "|") and before == token.text:
            hint = f'it is written "{"and" if before == "&" else "or"}"'
        elif token.kind == "newline" and before in ("+", "-") and self.index > 1 and self.peek(-2).text == before:
            hint = f'write "{before}= 1"'
        elif token.text == ">" and before == "<":
            hint = '"!=" compares'
        elif token.text in ("/", "//") or (token.text == "*" and before == "/"):
            hint = 'a comment begins with "#"'
        elif token.text == "=":
            hint = '"==" compares'
        self.fail(f"expected a value, found {describe(token)}", hint)

    def number(self, token: Token) -> int | float | complex:
        """The value of a number token."""
        try:
            return literals.number(token.text)
        except ValueError:
            self.fail("a whole number of more than 4300 digits", at=token, kind="budget")

    def keyword_atom(self, token: Token) -> ast.expr:
        """A value that is a keyword, or a keyword of Scenic 3 used as a name in dialect 2."""
        text = token.text
        if text in _CONSTANTS:
            self.advance()
            return self.at(token, ast.Constant(_CONSTANTS[text]))
        following = self.peek()
        if text == "new" and self.scenic and (following.kind == "name" or self.dialect == 3):
            return self.new_instance()
        if text in ("async", "await", "yield"):
            self.refuse(text)
        if text in self.keywords:
            self.fail(f'expected a value, found the word "{text}"', _MISPLACED.get(text, ""))
        if self.scenic and self.starts_value(following, "") and following.text not in self.operators:
            self.fail(f'unexpected "{text}"', _MISPLACED.get(text, ""))
        self.advance()
        return self.at(token, ast.Name(text, LOAD))

    # ------------------------------------------------------------ brackets

    def open(self) -> bool:
        """Read an opening bracket; returns what `close` wants back."""
        self.brackets += 1
        self.advance()
        return self.set_temporal(False)

    def close(self, sign: str, opening: Token, temporal: bool) -> None:
        """Read the closing bracket."""
        if self.token.text != sign:
            self.unexpected_inside(sign, opening)
        self.advance()
        self.brackets -= 1
        if temporal:
            self.set_temporal(True)

    def unexpected_inside(self, sign: str, opening: Token) -> NoReturn:
        """Report what neither continues nor closes a bracket."""
        found, hint = describe(self.token), ""
        if self.token.text == "=":
            hint = '"==" compares'
        elif self.token.kind in ("name", "number", "string"):
            hint = self.missing_operator_hint() or "is a comma missing?"
        where = "" if opening.line == self.token.line else f" of line {opening.line}"
        self.fail(f'expected "{sign}" to close the "{opening.text}"{where}, found {found}', hint)

    def missing_operator_hint(self) -> str:
        """What might be missing before the present token; more in parser_statements."""
        return ""

    def inside_brackets(self) -> ast.expr:
        """What may stand in round brackets, up to but without the closing one: the value inside an f-string."""
        temporal = self.set_temporal(False)
        start = self.token
        value = self.element()
        if self.token.text == ",":
            value = self.at(start, ast.Tuple(self.elements("", value), LOAD))
        if temporal:
            self.set_temporal(True)
        return value

    def group(self) -> ast.expr:
        """`()`, `(value)`, a tuple, a comprehension."""
        start = self.token
        self.brackets += 1  # a requirement goes on in round brackets, so `temporal` stays
        self.advance()
        value = self.rest_of_group(start)
        self.brackets -= 1
        return value

    def rest_of_group(self, start: Token) -> ast.expr:
        """What follows an opening round bracket, the closing one included."""
        if self.accept(")"):
            return self.at(start, ast.Tuple([], LOAD))
        first = self.element()
        if self.begins_comprehension():
            value: ast.expr = ast.GeneratorExp(first, self.comprehensions())
            self.end_group(start)
            return self.at(start, value)
        if self.token.text == ",":
            elements = self.elements(")", first)
            self.end_group(start)
            return self.at(start, ast.Tuple(elements, LOAD))
        self.end_group(start)
        if isinstance(first, ast.Starred):
            self.fail("a starred expression cannot stand alone", at=first)
        return first

    def end_group(self, start: Token) -> None:
        """Read the closing round bracket."""
        if self.token.text != ")":
            self.unexpected_inside(")", start)
        self.advance()

    def list_display(self) -> ast.expr:
        """`[a, b]` or a list comprehension."""
        start = self.token
        temporal = self.open()
        value: ast.expr
        if self.token.text == "]":
            value = ast.List([], LOAD)
        else:
            first = self.element()
            if self.begins_comprehension():
                value = ast.ListComp(first, self.comprehensions())
            else:
                value = ast.List(self.elements("]", first), LOAD)
        self.close("]", start, temporal)
        return self.at(start, value)

    def braces(self) -> ast.expr:
        """A dictionary, or a comprehension of one."""
        start = self.token
        temporal = self.open()
        value: ast.expr
        if self.token.text in ("}", "**"):
            value = self.dictionary(None)
        else:
            first = self.element()
            if self.token.text == ":":
                value = self.dictionary(first)
            elif self.begins_comprehension():
                self.refuse("set comprehension", start)
            elif self.token.text in (",", "}"):
                self.refuse("set", start)
            else:
                self.unexpected_inside("}", start)
        self.close("}", start, temporal)
        return self.at(start, value)

    def dictionary(self, key: ast.expr | None) -> ast.expr:
        """`key: value, **more` up to the closing bracket; `key`: the first one, if read already."""
        keys: list[ast.expr | None] = []
        values: list[ast.expr] = []
        while self.token.text != "}":
            if key is None and self.accept("**"):
                keys.append(None)
                values.append(self.operation(SEE))
            else:
                key = key or self.expression()
                self.expect(":", "after the key of the dictionary")
                value = self.expression()
                if not keys and self.begins_comprehension():
                    return ast.DictComp(key, value, self.comprehensions())
                keys.append(key)
                values.append(value)
                key = None
            if not self.accept(","):
                break
        return ast.Dict(keys, values)

    def elements(self, closing: str, first: ast.expr) -> list[ast.expr]:
        """`first, second, ...` up to the closing bracket ("": the end)."""
        found = [first]
        while self.accept(","):
            if self.token.text == closing or self.token.kind == "end":
                break
            found.append(self.element())
        return found

    def element(self) -> ast.expr:
        """`*operation` or `[name :=] expression`."""
        start = self.token
        if start.text == "*":
            self.advance()
            return self.at(start, ast.Starred(self.operation(SEE), LOAD))
        return self.assignment_expression()

    def assignment_expression(self) -> ast.expr:
        """`[name :=] expression`."""
        start = self.token
        if start.kind == "name" and self.peek().text == ":=":
            self.name("what is assigned to")
            target = self.at(start, ast.Name(start.text, STORE))
            self.advance()
            return self.at(start, ast.NamedExpr(target, self.expression()))
        return self.expression()

    # ------------------------------------------------------------ comprehensions

    def begins_comprehension(self) -> bool:
        """Does `for` come next?"""
        if self.token.text == "async":
            self.refuse("async")
        return self.token.text == "for"

    def comprehensions(self) -> list[ast.comprehension]:
        """`for targets in operation [if condition]`, once or more."""
        found = []
        while self.begins_comprehension():
            self.advance()
            target = self.targets()
            self.expect("in", "after the variable of the comprehension")
            values = self.operation(OR)
            conditions = []
            while self.accept("if"):
                conditions.append(self.filter())
            found.append(ast.comprehension(target, values, conditions, 0))
            self.check_chain(len(found), '"for"')
        return found

    def filter(self) -> ast.expr:
        """The condition of a comprehension: no `if else`, but perhaps a `:=`."""
        if self.token.kind == "name" and self.peek().text == ":=":
            return self.assignment_expression()
        return self.operation(OR)

    def targets(self) -> ast.expr:
        """What a `for` assigns to."""
        start = self.token
        first = self.target()
        if self.token.text != ",":
            return self.stored(first)
        found = [first]
        while self.accept(","):
            if self.token.text in ("in", "="):
                break
            found.append(self.target())
        return self.stored(self.at(start, ast.Tuple(found, LOAD)))

    def target(self) -> ast.expr:
        """One variable of a `for`."""
        start = self.token
        if start.text == "*":
            self.advance()
            return self.at(start, ast.Starred(self.operation(SEE), LOAD))
        return self.operation(SEE)

    # ------------------------------------------------------------ rows of values

    def expressions(self) -> ast.expr:
        """`expression [, expression]*`, stars allowed: a tuple where there is a comma."""
        start = self.token
        first = self.element_without_assignment()
        if self.token.text != ",":
            if isinstance(first, ast.Starred):
                self.fail("a starred expression cannot stand alone", at=first)
            return first
        found = [first]
        while self.accept(","):
            if not self.starts_value(self.token, "([{-+~*...") and not self.begins_word_value():
                break
            found.append(self.element_without_assignment())
        return self.at(start, ast.Tuple(found, LOAD))

    def begins_word_value(self) -> bool:
        """In dialect 2: is a keyword of Scenic 3 used as a name?"""
        return self.is_name(self.token) and self.token.text in SCENIC_KEYWORDS

    def element_without_assignment(self) -> ast.expr:
        """`*operation` or `expression`."""
        if self.token.text == "*":
            return self.element()
        return self.expression()
