"""Operators, and instances, which resemble operators: `[new] Class specifier, specifier, ...`.

Precedence climbing parses the operators of Python and Scenic, with the levels of the Scenic 3 grammar. Dialect 2
differs in two points. The last operand of a word operator such as `distance from X to Y` also takes `relative to` and
`offset by` (in Scenic 2 this operand extends to the end of the bracket). A word operator may be an operand of a sum.
After a class without `new`, most specifiers are unambiguous (`Name on R`, `Name with P V`). Specifiers that might also
be operators are parsed both ways. Read next: `syntax.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import grammar
from scenic_lite.syntax.cursor import LOAD, Cursor
from scenic_lite.syntax.expressions import arguments, atom, index, parameters
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import New, Operator, Specifier

BEHIND_CLASSES = grammar.OPERATOR_WORDS | {"."}


def expression(c: Cursor) -> ast.expr:
    """Read `lambda ...`, or `operation [if operation else expression]`; an instance without `new` may begin here."""
    c.deeper()
    start = c.token
    asks_truth, c.asks_truth = c.asks_truth, False
    value: ast.expr | None = None
    if start.text == "lambda":
        c.advance()
        signature = parameters(c, ":")
        c.expect(":", 'after the parameters of "lambda"')
        value = c.at(start, ast.Lambda(signature, expression(c)))
    elif start.kind == "name" and not asks_truth and c.tokens[c.index + 1].text in BEHIND_CLASSES:
        value = possible_instance(c)
    if value is None:
        value = conditional(c, operation(c, grammar.Level.UNTIL if c.temporal else grammar.Level.OR), start)
    c.nesting -= 1
    return value


def conditional(c: Cursor, value: ast.expr, start: Token) -> ast.expr:
    """Read `[if operation else expression]` after a value."""
    if c.token.text != "if":
        return value
    c.advance()
    condition = operation(c, grammar.Level.OR)
    c.expect("else", "to complete the conditional expression", 'write "a if condition else b"')
    return c.at(start, ast.IfExp(condition, value, expression(c)))


def operation(c: Cursor, level: int) -> ast.expr:
    """Read values joined by operators that bind at `level` or tighter."""
    start = c.token
    return continued(c, operand(c, level), level, start)


def continued(c: Cursor, left: ast.expr, level: int, start: Token) -> ast.expr:
    """Continue after a value that begins at `start`, while operators that bind at `level` or tighter follow."""
    links = 0
    while c.token.text in grammar.INFIX:
        infix = c.form(grammar.INFIX)
        if infix is None or infix.level < level:
            return left
        links += 1
        c.check_chain(links)
        left = c.at(start, joined(c, left, infix))
    return left


def refuse_bits(c: Cursor, sign: str) -> None:
    if sign in grammar.BITS and c.peek().text != sign:  # `&&` is another mistake
        c.refuse(sign)


def joined(c: Cursor, left: ast.expr, infix: grammar.Form) -> ast.expr:
    """Read an operator and its right operands; `left and right and ...` and `left < middle < ...` are one node."""
    node, sign = infix.node, c.token
    if isinstance(node, ast.operator):
        refuse_bits(c, sign.text)
        c.advance()
        if sign.text == "%" and isinstance(left.value if isinstance(left, ast.Constant) else left, str | ast.JoinedStr):
            c.refuse("%", sign)
        return ast.BinOp(left, node, operation(c, infix.level + 1))
    if node is None:
        return Operator(infix.name, [left, *operands(c, infix, lambda _: operation(c, infix.level + 1))])
    values: list[ast.expr] = []
    if isinstance(node, ast.boolop):
        while c.accept(infix.name):
            values.append(operation(c, infix.level + 1))
        return ast.BoolOp(node, [left, *values])
    signs: list[ast.cmpop] = []
    following: grammar.Form | None = infix
    while following is not None and isinstance(following.node, ast.cmpop):
        c.go_to(c.index + len(following.words))
        signs.append(following.node)
        values.append(operation(c, grammar.Level.SEE))
        following = c.form(grammar.INFIX)
    return ast.Compare(left, signs, values)


def operands(
    c: Cursor, form: grammar.Form, read: Callable[[str], ast.expr], reach: bool = False
) -> list[ast.expr | None]:
    """Read the words and values of a form; None is an omitted value.

    `read` takes the words before a value and reads it; `reach`: a value may extend up to the words of the next value.
    """
    c.go_to(c.index + len(form.words))
    start = c.token
    values: list[ast.expr | None] = [read(form.name)] if form.value else []
    for word, needed in form.parts:
        if reach:
            values[-1] = up_to(c, word, values[-1], start)  # type: ignore[arg-type]  # only the last can be omitted
        if needed and c.token.text != word:
            c.missing(f'"{word}" in "{form.name}"', f'write "{form.text}"')
        written = c.accept(word)
        start = c.token
        values.append(read(f"{form.name} ... {word}") if written else None)
    return values


def operand(c: Cursor, level: int) -> ast.expr:
    """Read a value with its prefixes: a sign, `not` or a word operator."""
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
    """Read a sign and its value, such as `-value`."""
    refuse_bits(c, token.text)
    c.advance()
    return c.at(token, ast.UnaryOp(grammar.SIGNS[token.text](), operand(c, grammar.Level.UNARY)))


def negation(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read `not operation` or `not visible region`."""
    if (region := measure(c, token, level)) is not None:
        return region
    if level > grammar.Level.NOT:
        c.fail('"not" needs brackets here', 'write "(not ...)"')
    c.advance()
    return c.at(token, ast.UnaryOp(ast.Not(), operation(c, grammar.Level.NOT)))


def always(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read `always | eventually | next` in a requirement."""
    if not c.temporal or not c.starts_value(c.peek(), "("):
        return None
    if level > grammar.Level.NOT:
        c.fail(f'"{token.text}" needs brackets here', f'write "({token.text} ...)"')
    c.advance()
    return c.at(token, Operator(token.text, [operation(c, grammar.Level.IMPLIES)]))


def begins_operand(c: Cursor, ahead: int, signs: str = "([{") -> bool:
    """Return whether the token `ahead` places later begins a value, not an operator between two values."""
    token, following = c.peek(ahead), c.peek(ahead + 1)
    if not c.starts_value(token, signs):
        return False
    if token.text in ("not", "visible"):
        return following.text != ("in" if token.text == "not" else "from")
    if token.text == "relative":
        return following.text in ("heading", "position") and c.peek(ahead + 2).text == "of"
    return token.text not in grammar.INFIX


def measure(c: Cursor, token: Token, level: int) -> ast.expr | None:
    """Read a word operator of `MEASURES` with its operands; None if the word is a name."""
    form = c.form(grammar.MEASURES)
    if form is None:
        return None
    signs = grammar.NAMES.get(form.words[-1])
    if signs is not None and not begins_operand(c, len(form.words), signs):
        return None
    if c.dialect == 3 and level > grammar.Level.PREFIX:  # in dialect 3 it cannot be an operand of a sum or product
        text = f"{token.text} {c.peek().text}"
        c.fail(f'"{text}" needs brackets here', f'write "({text} ...)"')
    reach = grammar.Level.ALONG if c.dialect == 2 else grammar.Level.PREFIX
    ends = operands(c, form, lambda _: operation(c, reach), reach=True)
    if form.name in ("distance to", "angle to"):
        ends.reverse()
    return c.at(token, Operator(form.name.removesuffix(" from").removesuffix(" to"), ends))


def up_to(c: Cursor, partner: str, first: ast.expr, start: Token) -> ast.expr:
    """Extend the first operand to a full expression if the expression ends at the word before the second operand."""
    if c.token.text == partner or c.token in c.no_partner:
        return first
    index, nesting, brackets, temporal = c.index, c.nesting, len(c.brackets), c.temporal
    try:
        longer = conditional(c, continued(c, first, grammar.Level.OR, start), start)
    except ScenicError as error:
        if error.kind == "budget":
            raise
        longer = first
    if longer is not first and c.token.text == partner:
        return longer
    c.nesting, c.temporal, c.brackets[brackets:] = nesting, temporal, []
    c.go_to(index)
    c.no_partner.add(c.token)
    return first


# Prefixes by first word or sign; a parser returns None if the word is a name in its context.
PREFIXES: dict[str, Callable[[Cursor, Token, int], ast.expr | None]] = {
    **dict.fromkeys(grammar.SIGNS, signed),
    **dict.fromkeys(grammar.MEASURES, measure),
    **dict.fromkeys(("always", "eventually", "next"), always),
    "not": negation,
}


def primary(c: Cursor, start: Token) -> ast.expr:
    """Read `atom` followed by attributes, calls and indices, then by specifiers or `** operand`."""
    value = (new_instance(c, start) if start.text == "new" else None) or atom(c, start)
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
    if c.token.text in grammar.SPECIFIER_WORDS and isinstance(value, ast.Name | ast.Attribute) and starts_instance(c):
        value = instance(c, start, value)
    if c.token.text != "**":
        return value
    c.advance()
    c.deeper()
    value = c.at(start, ast.BinOp(value, ast.Pow(), operand(c, grammar.Level.UNARY)))
    c.nesting -= 1
    return value


# ---------------------------------------------------------------- instances
def new_instance(c: Cursor, start: Token) -> ast.expr | None:
    """Read `new Class [specifiers]`; None if `new` is a name, which dialect 2 allows."""
    if c.peek().kind != "name" and c.dialect == 2:
        return None
    c.advance()
    if not c.is_plain_name(c.token):
        c.missing('a class name after "new"', 'write "new Class at X"' if c.token.kind in ("newline", "end") else "")
    return instance(c, start, class_name(c))


def class_name(c: Cursor) -> ast.expr:
    """Read `Name` or `module.Name`."""
    start = c.name("a class name")
    name: ast.expr = c.at(start, ast.Name(start.text, LOAD))
    while c.token.text == "." and c.is_name(c.peek()):
        c.advance()
        name = c.at(start, ast.Attribute(name, c.advance().text, LOAD))
    return name


def instance(c: Cursor, start: Token, cls: ast.expr) -> ast.expr:
    """Read the specifiers after a class, if any."""
    specifiers: list[Specifier] = []
    if begins_specifier(c):
        specifiers = more_specifiers(c, [specifier(c)])
    elif c.is_name(c.token) and c.token.text not in grammar.INFIX:
        c.fail(f'unknown specifier "{c.token.text}"', grammar.specifier_hint(c.token.text))
    return c.at(start, New(cls, specifiers))


def possible_instance(c: Cursor) -> ast.expr | None:
    """Read `Name at V` and similar forms at the start of an expression: New with both readings, or None."""
    ahead = 1
    while c.peek(ahead).text == "." and c.peek(ahead + 1).kind == "name":
        ahead += 2
    if c.peek(ahead).text not in grammar.OPERATOR_WORDS or not c.peek(ahead - 1).text[0].isupper():
        return None
    if c.in_target or c.temporal or not c.is_name(c.token):
        return None
    start, index = c.token, c.index
    cls = class_name(c)
    infix = c.form(grammar.INFIX)
    if infix is None or infix.words == ("not", "in"):
        c.go_to(index)
        return None
    return both_readings(c, start, cls, infix)


def both_readings(c: Cursor, start: Token, cls: ast.expr, infix: grammar.Form) -> ast.expr:
    """Read the continuation once, and build both the instance and the operator from it."""
    place, begins = c.token, [c.token]

    def read(words: str) -> ast.expr:
        begins.append(c.token)
        return specifier_value(c, words, infix.level + 1)

    values = operands(c, infix, read)
    *before, value = values
    assert value is not None
    operator: ast.expr = Operator(infix.name, [cls, *values])
    if infix.name == "in":
        operator = ast.Compare(cls, [ast.In()], [value])
    c.at(start, operator)
    if infix.name == "in" and c.form(grammar.INFIX):  # a region has no looser operators: a comparison
        return conditional(c, continued(c, operator, grammar.Level.OR, start), start)
    whole = conditional(c, continued(c, value, grammar.Level.OR, begins[-1]), begins[-1])
    specifier = c.at(place, Specifier(infix.name.removesuffix(" from"), [*before, whole]))
    specifiers = more_specifiers(c, [specifier])
    node = c.at(start, New(cls, specifiers))
    if len(specifiers) == 1 and whole is value:
        node.certain, node.operator = False, operator
    return node


def starts_instance(c: Cursor) -> bool:
    """Return whether a specifier that cannot be an operator follows after a name."""
    if c.in_target or c.token.text == "with":
        return not c.in_target and c.is_name(c.peek())
    form = next_form(c)
    if form is None or form.words[0] not in grammar.OPERATOR_WORDS:
        return form is not None
    # `visible` and `not visible` without `from` are not operators.
    return form.words[-1] == "visible" and c.peek(len(form.words)).text != "from"


def more_specifiers(c: Cursor, specifiers: list[Specifier]) -> list[Specifier]:
    """Read `, specifier` repeatedly; a line may end after a comma if the next one is indented."""
    while True:
        if begins_specifier(c):
            c.fail(f'expected a comma before the specifier "{c.token.text}"')
        if c.token.text != ",":
            return specifiers
        index, comma = c.index, c.advance()
        next_line = c.token.kind == "indent"
        if next_line:
            c.advance()
        if c.token.kind == "newline":
            hint = "take the comma away, or indent the next specifier"
            c.fail("a comma ends the line, but no indented specifier follows", hint, at=comma)
        if begins_specifier(c):
            specifiers.append(specifier(c))
            continue
        if is_misspelt(c):
            c.fail(f'unknown specifier "{c.token.text}"', grammar.specifier_hint(c.token.text))
        # Outside brackets, another instance after a comma creates a tuple.
        tuple_of_instances = c.token.kind == "name" and (c.token.text == "new" or c.token.text[0].isupper())
        if next_line or (not c.brackets and not tuple_of_instances):
            hint = f'write "with {c.token.text} value"' if c.peek().text == "=" else ""
            hint = 'a place is written "3 @ 4"' if c.token.kind == "number" else hint
            c.missing("a specifier after the comma", hint)
        c.go_to(index)
        return specifiers


def begins_specifier(c: Cursor) -> bool:
    """Return whether a specifier follows."""
    return c.token.text == "with" or next_form(c) is not None


def next_form(c: Cursor) -> grammar.Form | None:
    """Return the specifier form whose words follow, if the next token can continue the form."""
    for form in grammar.SPECIFIERS.get(c.token.text, ()):
        if c.sees(*form.words):
            following = c.peek(len(form.words))
            if len(form.words) == 1 and form.value and following.text in (".", "=", ")", "]", "}", ",", ":"):
                continue
            if form.words[0] == "facing" and len(form.words) > 1 and not c.starts_value(following, "([-"):
                continue
            return form
    return None


def specifier(c: Cursor) -> Specifier:
    """Read one specifier."""
    start = c.token
    if start.text == "with":
        return with_property(c)
    form = next_form(c)
    assert form is not None
    node = c.at(start, Specifier(form.name, operands(c, form, lambda words: specifier_value(c, words))))
    if c.token.kind == "number" and ("by", False) in form.parts:
        c.fail(f'expected "by" before the distance of "{form.name}"', f'write "{form.name} X by {c.token.text}"')
    return node


def with_property(c: Cursor) -> Specifier:
    """Read `with property value`."""
    start = c.advance()
    word = c.name("a property name")
    if c.token.text in ("=", ":"):
        c.fail(f'"{c.token.text}" between a property and its value', f'write "with {word.text} value"')
    name = c.at(word, ast.Constant(word.text))
    return c.at(start, Specifier("with", [name, specifier_value(c, f"with {word.text}")]))


def specifier_value(c: Cursor, name: str, level: int | None = None) -> ast.expr:
    """Read the value after the words of a specifier: an expression, or an operation of the given level."""
    if name == "facing" and c.token.text in ("to", "at", "towards") and c.starts_value(c.peek(), ""):
        c.fail(f'unknown specifier "facing {c.token.text}"', 'did you mean "facing toward"?')
    if c.token.kind in ("newline", "end") or c.token.text in (",", ")"):
        c.missing(f'a value after "{name}"')
    return expression(c) if level is None else operation(c, level)


def is_misspelt(c: Cursor) -> bool:
    """Return whether two adjacent words follow with which no expression can begin."""
    token, following = c.token, c.peek()
    if not c.is_plain_name(token) or token.text in grammar.INFIX or token.text in PREFIXES:
        return False
    if following.kind in ("number", "string"):
        return True
    return (
        c.is_plain_name(following)
        and following.text not in grammar.INFIX
        and following.text not in grammar.SPECIFIER_WORDS
    )
