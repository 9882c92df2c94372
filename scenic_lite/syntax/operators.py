"""Operators: the tables, one row for each, and the climb over them by precedence, Python's and Scenic's alike.

Dialect 2 differs from 3 in two points: the last operand of a word operator such as `distance from X to Y` also takes
`relative to` and `offset by` (Scenic 2 lets it run to the end of the bracket), and a word operator may be an operand
of a sum. The levels are those of the Scenic 3 grammar, Python's included. Read next: `syntax.statements`.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable
from typing import NamedTuple

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import specifiers
from scenic_lite.syntax.cursor import LOAD, Cursor, Level
from scenic_lite.syntax.expressions import arguments, atom, element, index, parameters
from scenic_lite.syntax.hints import COMPARES
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import New, Operator, Specifier


def expression(c: Cursor) -> ast.expr:
    """Read `lambda ...`, or `operation [if operation else expression]`; an instance without `new` may begin here."""
    c.deeper()
    start = c.token
    asks_truth, c.asks_truth = c.asks_truth, False
    value: ast.expr | None = None
    if start.text == "lambda":
        c.advance()
        found = parameters(c, ":")
        c.expect(":", 'after the parameters of "lambda"')
        value = c.at(start, ast.Lambda(found, expression(c)))
    elif start.kind == "name" and not asks_truth and c.tokens[c.index + 1].text in BEHIND_CLASSES:
        value = possible_instance(c)
    if value is None:
        value = conditional(c, operation(c, Level.UNTIL if c.temporal else Level.OR), start)
    c.nesting -= 1
    return value


def conditional(c: Cursor, value: ast.expr, start: Token) -> ast.expr:
    """Read `[if operation else expression]` after a value."""
    if c.token.text != "if":
        return value
    c.advance()
    condition = operation(c, Level.OR)
    c.expect("else", "to complete the conditional expression", 'write "a if condition else b"')
    return c.at(start, ast.IfExp(condition, value, expression(c)))


def condition(c: Cursor) -> ast.expr:
    """Read what is asked whether it is true: no instance begins it; `=` in it is a frequent slip."""
    c.asks_truth = True
    value = element(c)
    if c.token.text == "=":
        c.fail('"=" assigns and cannot stand in a condition', COMPARES)
    return value


def operation(c: Cursor, level: int) -> ast.expr:
    """Read values joined by operators that bind at `level` or tighter."""
    start = c.token
    return continued(c, operand(c, level), level, start)


def continued(c: Cursor, left: ast.expr, level: int, start: Token) -> ast.expr:
    """Read on after a value that begins at `start`, as long as operators of `level` or tighter follow."""
    links = 0
    while c.token.text in INFIX:
        infix = next_infix(c)
        if infix is None or infix.level < level:
            return left
        links += 1
        c.check_chain(links)
        left = infix.read(c, left, infix, start)
    return left


def next_infix(c: Cursor) -> Infix | None:
    """Return the operator that comes next."""
    for infix in INFIX.get(c.token.text, ()):
        if len(infix.words) == 1 or c.sees(*infix.words):
            return infix
    return None


def arithmetic(c: Cursor, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
    """Read `left + right` and its like, from left to right."""
    sign = c.advance()
    if sign.text == "%" and is_text(left):
        c.refuse("%", sign)
    right = operation(c, infix.level + 1)
    return c.at(start, ast.BinOp(left, infix.node, right))  # type: ignore[arg-type]


def is_text(value: ast.expr) -> bool:
    """Return whether a value is a text as it stands."""
    return isinstance(value, ast.JoinedStr) or (isinstance(value, ast.Constant) and isinstance(value.value, str))


def logic(c: Cursor, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
    """Read `left and right and ...`: one node for the whole row."""
    values = [left]
    while c.accept(infix.words[0]):
        values.append(operation(c, infix.level + 1))
    return c.at(start, ast.BoolOp(infix.node, values))  # type: ignore[arg-type]


def comparison(c: Cursor, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
    """Read `left < middle < ...`: one node for the whole chain."""
    signs: list[ast.cmpop] = []
    values: list[ast.expr] = []
    following: Infix | None = infix
    while following is not None and following.level == Level.COMPARE:
        c.skip(len(following.words))
        signs.append(following.node)  # type: ignore[arg-type]
        values.append(operation(c, Level.SEE))
        following = next_infix(c)
    return c.at(start, ast.Compare(left, signs, values))


def words(c: Cursor, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
    """Read `left relative to right` and its like, `left deg`."""
    c.skip(len(infix.words))
    operands: list[ast.expr | None] = [left] if infix.words == ("deg",) else [left, operation(c, infix.level + 1)]
    return c.at(start, Operator(" ".join(infix.words), operands))


def along(c: Cursor, left: ast.expr, infix: Infix, start: Token) -> ast.expr:
    """Read `left offset along heading by vector`."""
    c.skip(2)
    heading = operation(c, Level.RELATIVE)
    c.expect("by", 'after "offset along" and its heading', 'write "X offset along H by V"')
    return c.at(start, Operator("offset along", [left, heading, operation(c, Level.RELATIVE)]))


def operand(c: Cursor, level: int) -> ast.expr:
    """Read a value with what stands before it: a sign, `not`, a word operator."""
    token = c.token
    read = PREFIXES.get(token.text)
    if read is not None:
        c.deeper()
        value = read(c, token, level)
        c.nesting -= 1
        if value is not None:
            return value
    return primary(c, token)


def signed(c: Cursor, token: Token, level: int) -> ast.expr:
    """Read `-value` and its like."""
    c.advance()
    return c.at(token, ast.UnaryOp(SIGNS[token.text](), operand(c, Level.UNARY)))


def negation(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read `not operation`, `not visible region`."""
    if (region := measure(c, token, level)) is not None:
        return region
    if level > Level.NOT:
        c.fail('"not" needs brackets here', 'write "(not ...)"')
    c.advance()
    return c.at(token, ast.UnaryOp(ast.Not(), operation(c, Level.NOT)))


def always(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read `always | eventually | next` in a requirement."""
    if not c.temporal or not c.starts_value(c.peek(), "("):
        return None
    if level > Level.NOT:
        c.fail(f'"{token.text}" needs brackets here', f'write "({token.text} ...)"')
    c.advance()
    return c.at(token, Operator(token.text, [operation(c, Level.IMPLIES)]))


def begins_operand(c: Cursor, ahead: int, signs: str = "([{") -> bool:
    """Return whether a value begins that many tokens ahead, and no operator between two values."""
    token, following = c.peek(ahead), c.peek(ahead + 1)
    if not c.starts_value(token, signs):
        return False
    if token.text == "not":
        return following.text != "in"
    if token.text == "visible":
        return following.text != "from"
    if token.text == "relative":
        return following.text in ("heading", "position") and c.peek(ahead + 2).text == "of"
    return token.text not in INFIX


def measure(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read a word operator of `MEASURES` with its operands; None if the word is a name."""
    form = next((form for form in MEASURES[token.text] if c.sees(*form.words)), None)
    if form is None:
        return None
    signs = NAMES.get(form.words[-1])
    if signs is not None and not begins_operand(c, len(form.words), signs):
        return None
    if c.dialect == 3 and level > Level.PREFIX:  # there it is not itself an operand of a sum or product
        text = f"{token.text} {c.peek().text}"
        c.fail(f'"{text}" needs brackets here', f'write "({text} ...)"')
    c.skip(len(form.words))
    operands: list[ast.expr | None] = []
    start, value = c.token, last_operand(c) if form.value else None
    for partner, needed in form.parts:
        operands.append(up_to(c, partner, value, start))  # type: ignore[arg-type]  # partners stand behind values
        if needed and c.token.text != partner:
            c.missing(f'"{partner}" in "{form.words[0]}"', f'write "{form.text}"')
        found = c.accept(partner)
        start, value = c.token, last_operand(c) if found else None
    name = " ".join(form.words)
    operands += [value] if form.value else []
    if name in ("distance to", "angle to"):
        operands.reverse()
    return c.at(token, Operator(name.removesuffix(" from").removesuffix(" to"), operands))


def last_operand(c: Cursor) -> ast.expr:
    """Read the last operand of a word operator."""
    return operation(c, Level.ALONG if c.dialect == 2 else Level.PREFIX)


def up_to(c: Cursor, partner: str, first: ast.expr, start: Token) -> ast.expr:
    """Extend the first operand to a full expression if that reaches the word before the second one."""
    if c.token.text == partner or c.token in c.no_partner:
        return first
    index, nesting, brackets, temporal = c.index, c.nesting, c.brackets, c.temporal
    try:
        longer = conditional(c, continued(c, first, Level.OR, start), start)
    except ScenicError as error:
        if error.kind == "budget":
            raise
        longer = first
    if longer is not first and c.token.text == partner:
        return longer
    c.nesting, c.brackets, c.temporal = nesting, brackets, temporal
    c.go_back(index)
    c.no_partner.add(c.token)
    return first


def primary(c: Cursor, start: Token) -> ast.expr:
    """Read `atom` followed by attributes, calls and indices; by specifiers, or by `** operand`."""
    value = atom(c, start)
    links = 0
    while c.token.text in (".", "(", "["):
        if c.token.text == "(":
            value = c.at(start, ast.Call(value, *arguments(c)))
        elif c.token.text == "[":
            value = c.at(start, ast.Subscript(value, index(c), LOAD))
        else:
            c.advance()
            value = c.at(start, ast.Attribute(value, c.word('a name after "."'), LOAD))
        links += 1
        c.check_chain(links)
    if isinstance(value, ast.Name | ast.Attribute) and specifiers.starts_instance(c):
        value = specifiers.instance(c, start, value)
    if c.token.text != "**":
        return value
    c.advance()
    c.deeper()
    value = c.at(start, ast.BinOp(value, ast.Pow(), operand(c, Level.UNARY)))
    c.nesting -= 1
    return value


def possible_instance(c: Cursor) -> ast.expr | None:
    """Read `Name at V` and the like at the start of an expression: New with both readings, or None."""
    ahead = 1
    while c.peek(ahead).text == "." and c.peek(ahead + 1).kind == "name":
        ahead += 2
    if c.peek(ahead).text not in specifiers.OPERATOR_WORDS or not c.peek(ahead - 1).text[0].isupper():
        return None
    if c.in_target or c.temporal or not c.is_name(c.token):
        return None
    start, index = c.token, c.index
    cls = specifiers.class_name(c)
    infix = next_infix(c)
    if infix is None or infix.words == ("not", "in"):
        c.go_back(index)
        return None
    return both_readings(c, start, cls, infix)


def both_readings(c: Cursor, start: Token, cls: ast.expr, infix: Infix) -> ast.expr:
    """Read what follows once, and build the instance and the operator from it."""
    place, name = c.token, " ".join(infix.words)
    heading: list[ast.expr] = []
    c.skip(len(infix.words))
    if name == "offset along":
        heading = [operation(c, Level.RELATIVE)]
        c.expect("by", 'after "offset along" and its heading', 'write "offset along H by V"')
    value_start = c.token
    value = specifiers.specifier_value(c, name, infix.level + 1)
    operator: ast.expr = Operator(name, [cls, *heading, value])
    if name == "in":
        operator = ast.Compare(cls, [ast.In()], [value])
    c.at(start, operator)
    whole = conditional(c, continued(c, value, Level.OR, value_start), value_start)
    specifier = c.at(place, Specifier(name.removesuffix(" from"), [*heading, whole]))
    found = specifiers.more_specifiers(c, [specifier])
    node = c.at(start, New(cls, found))
    if len(found) == 1:
        node.certain = False
        node.operator = grafted(whole, value, operator)
    return node


BEHIND_CLASSES = specifiers.OPERATOR_WORDS | {"."}

# Where an operator between values keeps the first of them.
LEFT = {ast.BinOp: "left", ast.Compare: "left", ast.IfExp: "body", ast.BoolOp: "values", Operator: "operands"}


def grafted(whole: ast.expr, old: ast.expr, new: ast.expr) -> ast.expr:
    """Return a copy of `whole` with `new` for its leftmost value `old`: how precedence would have grouped it."""
    if whole is old:
        return new
    grown, name = copy.copy(whole), LEFT[type(whole)]
    left = whole.__dict__[name]
    new = grafted(left[0] if isinstance(left, list) else left, old, new)
    if isinstance(grown, ast.Compare) and isinstance(new, ast.Compare):  # two in a row become one chain
        grown.left, grown.ops, grown.comparators = new.left, new.ops + grown.ops, new.comparators + grown.comparators
    else:
        grown.__dict__[name] = [new, *left[1:]] if isinstance(left, list) else new
    grown.lineno, grown.col_offset = new.lineno, new.col_offset
    return grown


# ---------------------------------------------------------------- the tables


class Infix(NamedTuple):
    """An operator between two values: its words, how tightly it binds, what reads on, the sign in Python's node."""

    words: tuple[str, ...]
    level: int
    read: Callable[[Cursor, ast.expr, Infix, Token], ast.expr]
    node: ast.operator | ast.cmpop | ast.boolop | None = None


_ROWS = (
    Infix(("until",), Level.UNTIL, words),
    Infix(("implies",), Level.IMPLIES, words),
    Infix(("or",), Level.OR, logic, ast.Or()),
    Infix(("and",), Level.AND, logic, ast.And()),
    Infix(("<",), Level.COMPARE, comparison, ast.Lt()),
    Infix((">",), Level.COMPARE, comparison, ast.Gt()),
    Infix(("<=",), Level.COMPARE, comparison, ast.LtE()),
    Infix((">=",), Level.COMPARE, comparison, ast.GtE()),
    Infix(("==",), Level.COMPARE, comparison, ast.Eq()),
    Infix(("!=",), Level.COMPARE, comparison, ast.NotEq()),
    Infix(("in",), Level.COMPARE, comparison, ast.In()),
    Infix(("not", "in"), Level.COMPARE, comparison, ast.NotIn()),
    Infix(("is", "not"), Level.COMPARE, comparison, ast.IsNot()),
    Infix(("is",), Level.COMPARE, comparison, ast.Is()),
    Infix(("can", "see"), Level.SEE, words),
    Infix(("intersects",), Level.SEE, words),
    Infix(("visible", "from"), Level.SEE, words),
    Infix(("not", "visible", "from"), Level.SEE, words),
    Infix(("|",), Level.SEE, arithmetic, ast.BitOr()),
    Infix(("offset", "along"), Level.ALONG, along),
    Infix(("^",), Level.ALONG, arithmetic, ast.BitXor()),
    Infix(("relative", "to"), Level.RELATIVE, words),
    Infix(("offset", "by"), Level.RELATIVE, words),
    Infix(("&",), Level.RELATIVE, arithmetic, ast.BitAnd()),
    Infix(("at",), Level.AT, words),
    Infix(("<<",), Level.AT, arithmetic, ast.LShift()),
    Infix((">>",), Level.AT, arithmetic, ast.RShift()),
    Infix(("+",), Level.SUM, arithmetic, ast.Add()),
    Infix(("-",), Level.SUM, arithmetic, ast.Sub()),
    Infix(("*",), Level.TERM, arithmetic, ast.Mult()),
    Infix(("/",), Level.TERM, arithmetic, ast.Div()),
    Infix(("//",), Level.TERM, arithmetic, ast.FloorDiv()),
    Infix(("%",), Level.TERM, arithmetic, ast.Mod()),
    Infix(("@",), Level.TERM, arithmetic, ast.MatMult()),
    Infix(("deg",), Level.TERM, words),
)
INFIX: dict[str, list[Infix]] = {}
for _row in _ROWS:
    INFIX.setdefault(_row.words[0], []).append(_row)

AUGMENTED = {f"{row.words[0]}=": row.node for row in _ROWS if isinstance(row.node, ast.operator)} | {"**=": ast.Pow()}
SIGNS: dict[str, type[ast.unaryop]] = {"+": ast.UAdd, "-": ast.USub, "~": ast.Invert}
# Word operators before a value; their operands are in the order of the letters.
MEASURES = specifiers.forms("""
distance from X [to Y]
distance to Y [from X]
distance past V [of X]
angle from X [to Y]
angle to Y [from X]
relative heading of H [from X]
relative position of X [from Y]
apparent heading of P [from V]
front left of X
front right of X
back left of X
back right of X
front of X
back of X
left of X
right of X
visible R
not visible R
follow F from V for D
initial scenario
""")
# Those that may be names: by their last word, which signs may begin the operand.
NAMES = {"visible": "(", "follow": ""}
# What a word or sign before a value begins; None from it if the word is a name there.
PREFIXES: dict[str, Callable[[Cursor, Token, int], ast.expr | None]] = {
    **dict.fromkeys(SIGNS, signed),
    **dict.fromkeys(MEASURES, measure),
    **dict.fromkeys(("always", "eventually", "next"), always),
    "not": negation,
}
