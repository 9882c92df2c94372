"""Expressions: the operator tables climbed by precedence, for Python's operators and for Scenic's.

Dialect 2 differs from 3 in two points: the last operand of a word operator such as `distance from X to Y` also takes
`relative to` and `offset by` (Scenic 2 lets it run to the end of the bracket), and a word operator may be an operand
of a sum. Read next: `parser_statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.calls import Calls
from scenic_lite.syntax.cursor import LOAD, PYTHON_KEYWORDS, describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import Operator
from scenic_lite.syntax.operators import (
    ALONG,
    COMPARE,
    IMPLIES,
    NOT,
    OR,
    PREFIX,
    PREFIX_WORDS,
    PREFIXES,
    PYTHON_TABLE,
    RELATIVE,
    SCENIC_TABLE,
    SEE,
    SIGNS,
    SPECIAL,
    TEMPORAL,
    TEMPORAL_TABLE,
    UNARY,
    UNTIL,
    Infix,
)


class Expressions(Calls):
    """The productions of expressions, loosest first."""

    operators: Mapping[str, tuple[Infix, ...]] = PYTHON_TABLE
    temporal = False  # within the condition of a `require`

    def set_temporal(self, on: bool) -> bool:
        """Let `always`, `until` ... count, or not; returns what was before."""
        before, self.temporal = self.temporal, on
        if before != on:
            self.operators = TEMPORAL_TABLE if on else SCENIC_TABLE
        return before

    @property
    def last_level(self) -> int:
        """How far the last operand of a word operator reaches."""
        return ALONG if self.dialect == 2 else PREFIX

    def expression(self) -> ast.expr:
        """`lambda ...`, or `operation [if operation else expression]`; an instance without `new` may begin here."""
        self.deeper()
        start = self.token
        asks_truth, self.asks_truth = self.asks_truth, False
        value: ast.expr | None
        if start.text == "lambda":
            value = self.lambda_expression()
        else:
            instance = self.scenic and start.kind == "name" and not asks_truth
            value = self.possible_instance() if instance else None
            if value is None:
                value = self.conditional(self.operation(UNTIL if self.temporal else OR), start)
        self.nesting -= 1
        return value

    def conditional(self, value: ast.expr, start: Token) -> ast.expr:
        """`[if operation else expression]` after a value."""
        if self.token.text != "if":
            return value
        self.advance()
        condition = self.operation(OR)
        self.expect("else", "to complete the conditional expression", 'write "a if condition else b"')
        return self.at(start, ast.IfExp(condition, value, self.expression()))

    # ------------------------------------------------------------ between values

    def operation(self, level: int) -> ast.expr:
        """Values joined by operators that bind at `level` or tighter."""
        start = self.token
        return self.continued(self.operand(level), level, start)

    def continued(self, left: ast.expr, level: int, start: Token) -> ast.expr:
        """Read on after a value that begins at `start`, as long as operators of `level` or tighter follow."""
        links = 0
        while True:
            candidates = self.operators.get(self.token.text)
            if candidates is None:
                return left
            infix = candidates[0]
            if len(infix.words) > 1 or len(candidates) > 1:
                found = next((each for each in candidates if self.sees(*each.words)), None)
                if found is None:
                    return left
                infix = found
            if infix.level < level:
                return left
            links += 1
            self.check_chain(links)
            left = CONTINUATIONS[infix.how](self, left, infix, start)

    def arithmetic(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left + right` and its like, from left to right."""
        sign = self.advance()
        if sign.text == "%" and is_text(left):
            self.refuse("%", sign)
        right = self.operation(infix.level + 1)
        return self.at(start, ast.BinOp(left, infix.node, right))  # type: ignore[arg-type]

    def logic(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left and right and ...`: one node for the whole row."""
        values = [left]
        while self.token.text == infix.words[0]:
            self.advance()
            values.append(self.operation(infix.level + 1))
        return self.at(start, ast.BoolOp(infix.node, values))  # type: ignore[arg-type]

    def comparison(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left < middle < ...`: one node for the whole chain."""
        signs: list[ast.cmpop] = []
        values: list[ast.expr] = []
        following: Infix | None = infix
        while following is not None:
            self.skip(len(following.words))
            signs.append(following.node)  # type: ignore[arg-type]
            values.append(self.operation(SEE))
            candidates = self.operators.get(self.token.text, ())
            following = next((each for each in candidates if self.sees(*each.words)), None)
            if following is not None and following.level != COMPARE:
                following = None
        return self.at(start, ast.Compare(left, signs, values))

    def words(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left relative to right` and its like."""
        self.skip(len(infix.words))
        right = self.operation(infix.level + 1)
        return self.at(start, Operator(" ".join(infix.words), [left, right]))

    def along(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left offset along heading by vector`."""
        self.skip(2)
        heading = self.operation(RELATIVE)
        self.expect("by", 'after "offset along" and its heading', 'write "X offset along H by V"')
        return self.at(start, Operator("offset along", [left, heading, self.operation(RELATIVE)]))

    def degrees(self, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
        """`left deg`."""
        self.advance()
        return self.at(start, Operator("deg", [left]))

    # ------------------------------------------------------------ before a value

    def operand(self, level: int) -> ast.expr:
        """A value with what stands before it: a sign, `not`, a word operator."""
        token = self.token
        if token.kind == "name":
            if token.text in SPECIAL and (value := self.special(token, level)) is not None:
                return value
            if self.temporal and token.text in TEMPORAL and self.starts_value(self.peek(), "("):
                return self.always(token, level)
        elif token.kind == "operator" and token.text in SIGNS:
            self.advance()
            self.deeper()
            value = self.at(token, ast.UnaryOp(SIGNS[token.text](), self.operand(UNARY)))
            self.nesting -= 1
            return value
        return self.power()

    def special(self, token: Token, level: int) -> ast.expr | None:
        """What begins with a word of SPECIAL; None if the word is a name here."""
        word, following = token.text, self.peek()
        if word == "lambda":
            self.fail('a "lambda" needs brackets here')
        if word == "not" and not (self.scenic and following.text == "visible" and self.begins_operand(2, "(")):
            return self.negation(token, level)
        if not self.scenic:
            return None
        self.deeper()
        value: ast.expr | None = None
        if word == "not" or (word == "visible" and self.begins_operand(1, "(")):
            value = self.visible_part(token, level)
        elif word == "follow":
            value = self.follow(token, level)
        elif word == "initial":
            if following.text == "scenario":
                self.skip(2)
                value = self.at(token, Operator("initial scenario", []))
        else:
            for words in PREFIX_WORDS.get(word, ()):
                if self.sees(*words):
                    value = self.measure(token, words, level)
                    break
        self.nesting -= 1
        return value

    def negation(self, token: Token, level: int) -> ast.expr:
        """`not operation`."""
        if level > NOT:
            self.fail('"not" needs brackets here', 'write "(not ...)"')
        self.advance()
        self.deeper()
        value = self.at(token, ast.UnaryOp(ast.Not(), self.operation(NOT)))
        self.nesting -= 1
        return value

    def always(self, token: Token, level: int) -> ast.expr:
        """`always | eventually | next` in a requirement."""
        if level > NOT:
            self.fail(f'"{token.text}" needs brackets here', f'write "({token.text} ...)"')
        self.advance()
        self.deeper()
        value = self.at(token, Operator(token.text, [self.operation(IMPLIES)]))
        self.nesting -= 1
        return value

    def begins_operand(self, ahead: int, signs: str = "([{") -> bool:
        """Does a value begin that many tokens ahead, and no operator between two values?"""
        token, following = self.peek(ahead), self.peek(ahead + 1)
        if not self.starts_value(token, signs):
            return False
        if token.text == "not":
            return following.text != "in"
        if token.text == "visible":
            return following.text != "from"
        if token.text == "relative":
            return following.text in ("heading", "position") and self.peek(ahead + 2).text == "of"
        return token.text not in self.operators

    def visible_part(self, token: Token, level: int) -> ast.expr:
        """`visible region`, `not visible region`."""
        self.check_level(token, level)
        name = "visible" if token.text == "visible" else "not visible"
        self.skip(1 if name == "visible" else 2)
        return self.at(token, Operator(name, [self.operation(self.last_level)]))

    def follow(self, token: Token, level: int) -> ast.expr | None:
        """`follow field from vector for distance`."""
        if not self.is_name(self.peek()) or not self.begins_operand(1):
            return None
        self.check_level(token, level)
        form = 'write "follow F from V for D"'
        self.advance()
        field = self.expression()
        self.expect("from", 'after "follow" and its field', form)
        start = self.expression()
        self.expect("for", 'after "follow F from V"', form)
        return self.at(token, Operator("follow", [field, start, self.operation(self.last_level)]))

    def measure(self, token: Token, words: tuple[str, ...], level: int) -> ast.expr:
        """A word operator of PREFIXES with its one or two operands."""
        self.check_level(token, level)
        name, partner = PREFIXES[words]
        self.skip(len(words))
        start = self.token
        first = self.operation(self.last_level)
        second: ast.expr | None = None
        if partner:
            first = self.up_to(partner, first, start)
            if self.accept(partner):
                second = self.operation(self.last_level)
        if name in ("distance", "angle") and words[1] == "to":
            first, second = second, first  # type: ignore[assignment]
        return self.at(token, Operator(name, [first, second] if partner else [first]))

    def up_to(self, partner: str, first: ast.expr, start: Token) -> ast.expr:
        """Extend the first operand to a full expression if that reaches the word before the second one."""
        if self.token.text == partner or self.token in self.no_partner:
            return first
        index, nesting, brackets = self.index, self.nesting, self.brackets
        try:
            longer = self.conditional(self.continued(first, OR, start), start)
        except ScenicError as error:
            if error.kind == "budget":
                raise
            longer = first
        if longer is not first and self.token.text == partner:
            return longer
        self.nesting, self.brackets = nesting, brackets
        self.go_back(index)
        self.no_partner.add(self.token)
        return first

    def check_level(self, token: Token, level: int) -> None:
        """In dialect 3 a word operator is not itself an operand of a sum or product."""
        if self.dialect == 3 and level > PREFIX:
            text = f"{token.text} {self.peek().text}"
            self.fail(f'"{text}" needs brackets here', f'write "({text} ...)"')

    # ------------------------------------------------------------ values

    def power(self) -> ast.expr:
        """`primary [** operand]`."""
        start = self.token
        value = self.primary(start)
        if self.token.text != "**":
            return value
        self.advance()
        self.deeper()
        value = self.at(start, ast.BinOp(value, ast.Pow(), self.operand(UNARY)))
        self.nesting -= 1
        return value

    def primary(self, start: Token) -> ast.expr:
        """`atom` followed by attributes, calls and indices."""
        value = self.atom(start)
        links = 0
        while True:
            text = self.token.text
            if text == ".":
                self.advance()
                value = self.at(start, ast.Attribute(value, self.attribute(), LOAD))
            elif text == "(":
                value = self.call(value, start)
            elif text == "[":
                value = self.at(start, ast.Subscript(value, self.index_expression(), LOAD))
            else:
                break
            links += 1
            self.check_chain(links)
        if self.scenic and isinstance(value, ast.Name | ast.Attribute) and self.starts_instance():
            return self.instance(start, value)
        return value

    def attribute(self) -> str:
        """The name after a dot."""
        if self.token.kind != "name" or self.token.text in PYTHON_KEYWORDS:
            self.fail(f'expected a name after ".", found {describe(self.token)}')
        return self.advance().text

    def condition(self) -> ast.expr:
        """An expression that is asked whether it is true: no instance begins it; `=` in it is a frequent slip."""
        self.asks_truth = True
        value = self.assignment_expression()
        if self.token.text == "=":
            self.fail('"=" assigns and cannot stand in a condition', '"==" compares')
        return value


def is_text(value: ast.expr) -> bool:
    """Return whether a value is a text as it stands."""
    return isinstance(value, ast.JoinedStr) or (isinstance(value, ast.Constant) and isinstance(value.value, str))


# What reads on after an operator, by `Infix.how`.
CONTINUATIONS: dict[str, Callable[[Expressions, ast.expr, Infix, Token], ast.expr]] = {
    "arithmetic": Expressions.arithmetic,
    "logic": Expressions.logic,
    "comparison": Expressions.comparison,
    "words": Expressions.words,
    "along": Expressions.along,
    "degrees": Expressions.degrees,
}
