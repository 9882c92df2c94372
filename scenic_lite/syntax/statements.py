"""Python's simple and compound statements, and hints for mistakes.

Read next: `syntax.parser`, for the statements of Scenic.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import NamedTuple, NoReturn

from scenic_lite.syntax import expressions, grammar
from scenic_lite.syntax.cursor import Cursor, describe
from scenic_lite.syntax.expressions import condition, listed
from scenic_lite.syntax.grammar import AUGMENTED, COMPARES, INFIX, SPECIFIER_WORDS
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import Interrupt, New, TryInterrupt


class Rule(NamedTuple):
    """A statement by its first word: the parser of the rest, and a test whether the next tokens make it a statement."""

    read: Callable[[Cursor, Token], ast.stmt]
    begins: Callable[[Cursor, Token], bool] = lambda c, following: True


def module(c: Cursor) -> ast.Module:
    """Read the whole program."""
    body: list[ast.stmt] = []
    while c.token.kind != "end":
        body.extend(statement(c))
    return ast.Module(body, [])


def statement(c: Cursor) -> list[ast.stmt]:
    """Read one compound statement, or a line of simple statements."""
    if c.token.kind == "indent":
        unexpected_indent(c)
    node = by_first_word(c, c.blocks, c.token.text) if c.peek().text != "=" else None
    return simple_line(c) if node is None else [node]


def by_first_word(c: Cursor, rules: Mapping[str, Rule], word: str) -> ast.stmt | None:
    """Read a statement that begins with a word of these rules; None if the word is a name in this context."""
    rule, start = rules.get(word), c.token
    if rule is None or not rule.begins(c, c.peek()):
        return None
    c.advance()
    return c.at(start, rule.read(c, start))


def simple_line(c: Cursor) -> list[ast.stmt]:
    """Read `statement [; statement]*` up to the end of the line."""
    statements = [simple_statement(c)]
    while c.accept(";") and c.token.kind != "newline":
        statements.append(simple_statement(c))
    if c.token.kind == "newline":
        c.advance()
    elif c.token.kind != "end":
        unexpected_end(c, statements[-1])
    return statements


def simple_statement(c: Cursor) -> ast.stmt:
    """Read one statement."""
    start, following = c.token, c.peek()
    if start.kind != "name":
        return expression_statement(c)
    assigned = following.text == "=" or following.text in AUGMENTED
    if assigned and start.text in c.keywords and start.text != "return":
        c.fail(f'"{start.text}" is a word of the language and cannot be the name of a variable')
    word = ":" if c.class_body and begins_property(c, following) else start.text
    return by_first_word(c, c.statements, word) or expression_statement(c)


def begins_property(c: Cursor, following: Token) -> bool:
    """Return whether `name: default` or `name[attributes]: default` follows."""
    if following.text == ":":
        return c.is_name(c.token) or c.token.text == "behavior"
    ahead = 2
    while c.peek(ahead).kind == "name" or (ahead > 2 and c.peek(ahead).text == ","):
        ahead += 1
    return following.text == "[" and ahead > 2 and c.peek(ahead).text == "]" and c.peek(ahead + 1).text == ":"


def unexpected_indent(c: Cursor) -> NoReturn:
    """Report a line with unexpected indentation."""
    hint = "only a block is indented, after a colon"
    if c.peek().text in SPECIFIER_WORDS:
        hint = "a comma at the end of the line before lets its specifiers go on"
    c.fail("the line is indented deeper than the one before", hint, at=c.peek())


def unexpected_end(c: Cursor, last: ast.stmt) -> NoReturn:
    """Report unexpected tokens after a statement on its line."""
    token, before = c.token, c.previous
    if token.kind == "indent":
        unexpected_indent(c)
    value = last.value if isinstance(last, ast.Expr) else None
    if token.text == ":":
        called = isinstance(value, ast.Call) and isinstance(value.func, ast.Name)
        hint = grammar.nearest(value.func.id, grammar.STATEMENT_WORDS) if called else ""  # type: ignore[union-attr]
        c.fail(f"unexpected {describe(token)} after the statement", hint)
    if token.text in ("&", "|", "!"):
        c.fail(f"unexpected {describe(token)}", 'the logical operators are "and", "or", "not"')
    if token.kind == "name" and before.kind == "name":  # a misspelled first word or specifier
        if isinstance(value, New | ast.Name) and (hint := grammar.statement_hint(before.text)):
            c.fail(f'unknown statement "{before.text}"', hint, at=before)
        if token.text == "with":
            c.fail(f'expected a property name after "with", found {describe(c.peek())}', at=c.peek())
        if before.text[:1].isupper() and token.text not in INFIX:
            c.fail(f'unknown specifier "{token.text}"', grammar.specifier_hint(token.text))
        if token.text in SPECIFIER_WORDS and token.text not in INFIX:
            c.fail(f'unexpected specifier "{token.text}"', 'specifiers follow a class: "Ball ahead of ego by 2"')
    hint = (
        grammar.FOREIGN.get(token.text, "")
        or grammar.DURATIONS.get(before.text, "")
        or expressions.missing_operator_hint(c)
    )
    c.fail(f"unexpected {describe(token)} after the end of the statement", hint)


def expression_statement(c: Cursor) -> ast.stmt:
    """Read `value`, `target = ... = value`, `target += value`."""
    start = c.token
    value = expressions.row(c)
    text = c.token.text
    if text == "=":
        return assignment(c, start, value)
    if text[:-1] in grammar.BITS:
        c.refuse(text[:-1])
    if text in AUGMENTED:
        if not isinstance(value, ast.Name | ast.Attribute | ast.Subscript):
            c.fail(f'cannot use "{text}" here', at=value)
        c.advance()
        c.stored(value)
        return c.at(start, ast.AugAssign(value, AUGMENTED[text], expressions.row(c)))
    if text == ":" and isinstance(value, ast.Name | ast.Attribute | ast.Subscript):
        colon(c, start)
    return c.at(start, ast.Expr(lone_class(c, value, start)))


def assignment(c: Cursor, start: Token, value: ast.expr) -> ast.stmt:
    """Read `target = ... = value`."""
    targets: list[ast.expr] = []
    while c.accept("="):
        if isinstance(value, New):
            c.fail("cannot assign to an instance", 'write "name = Class specifiers"', at=value)
        targets.append(c.stored(value))
        place = c.token
        value = expressions.row(c)
        c.check_chain(len(targets), "targets")
    return c.at(start, ast.Assign(targets, lone_class(c, value, place)))


def colon(c: Cursor, start: Token) -> NoReturn:
    """Report `name: ...` that is not a statement: a misspelled word, a late guard, or a variable annotation."""
    if start.text in ("precondition", "invariant"):
        c.fail(f'"{start.text}" may only stand before the first statement', at=start)
    if c.peek().kind == "newline":
        c.fail(f'unknown statement "{start.text}"', grammar.statement_hint(start.text), at=start)
    c.refuse("type")


def lone_class(c: Cursor, value: ast.expr, start: Token) -> ast.expr:
    """Return a possible instance: in dialect 2, a single capitalized name as a statement or an assigned value."""
    if c.dialect != 2 or not isinstance(value, ast.Name) or not value.id[0].isupper() or start.text == "(":
        return value
    node = c.at(start, New(value, []))
    node.certain = False
    return node


def import_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `import a.b [as c], ...`."""
    return ast.Import(listed(c, lambda c: alias(c, c.token, dotted_name(c, "a module"))))


def import_from_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `from module import names`."""
    if c.token.text in (".", "..."):
        c.refuse("from .")
    module = dotted_name(c, "a module")
    c.expect("import", 'after "from" and a module', 'write "from module import name"')
    bracket = c.token
    if c.accept("*"):
        return ast.ImportFrom(module, [c.at(bracket, ast.alias("*", None))], 0)

    def imported(c: Cursor) -> ast.alias:
        return alias(c, c.token, c.name("a name to import").text)

    if bracket.text != "(":
        return ast.ImportFrom(module, listed(c, imported), 0)
    expressions.opened(c)
    aliases = listed(c, imported, ")")
    expressions.close(c, ")")
    return ast.ImportFrom(module, aliases, 0)


def alias(c: Cursor, start: Token, name: str) -> ast.alias:
    """Read `[as name]` after an import."""
    return c.at(start, ast.alias(name, c.name("a name").text if c.accept("as") else None))


def dotted_name(c: Cursor, what: str) -> str:
    """Read `a.b.c`; the parts may be Scenic keywords."""
    parts = [c.word(f"the name of {what}")]
    while c.accept("."):
        parts.append(c.word(f"the name of {what}"))
    return ".".join(parts)


def refused(c: Cursor, start: Token) -> NoReturn:
    """Reject an unsupported statement of Python."""
    c.refuse(start.text, start)


def misplaced(c: Cursor, start: Token) -> NoReturn:
    """Report a word that can only continue a statement, such as `else`."""
    owner = {"elif": "if", "else": "if", "except": "try", "finally": "try", "in": "for"}.get(start.text)
    if owner:
        c.fail(f'"{start.text}" without "{owner}" before it', at=start)
    c.fail(f'a statement cannot begin with "{start.text}"', at=start)


# ---------------------------------------------------------------- blocks
def block(c: Cursor, owner: str, begin: Callable[[], None] | None = None, *, of_class: bool = False) -> list[ast.stmt]:
    """Read `: statements` on the same line or in an indented block; `owner` describes the statement in messages.

    `begin` reads lines before the statements, and disallows statements on the same line.
    """
    if c.token.text == "=":
        c.fail('"=" assigns and cannot stand in a condition', COMPARES)
    if c.token.text != ":":
        c.missing(f'":" after {owner}', expressions.missing_operator_hint(c))
    c.advance()
    c.deeper()
    outer, c.class_body = c.class_body, of_class
    if c.token.kind == "newline":
        c.advance()
        if c.token.kind != "indent":
            c.missing(f"an indented block after {owner} in line {c.previous.line}")
        c.advance()
        if begin is not None:
            begin()
        body: list[ast.stmt] = []
        while c.token.kind != "dedent":
            body.extend(statement(c))
        c.advance()
    elif begin is not None:
        c.missing(f"a new line after the colon of {owner}")
    else:
        body = simple_line(c)
    c.nesting -= 1
    c.class_body = outer
    return body


def else_block(c: Cursor) -> list[ast.stmt]:
    """Read an optional `else: ...`."""
    if not c.accept("else"):
        return []
    if c.token.text == "if":
        c.fail('"else if" is written "elif"')
    return block(c, '"else"')


def if_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `if ...: ... elif ...: ... else: ...`; a loop reads a long chain of `elif`."""
    parts: list[tuple[Token, ast.If]] = []
    while not parts or c.token.text == "elif":
        word = c.advance() if parts else start
        test = condition(c)
        parts.append((word, ast.If(test, block(c, f'the condition of "{word.text}"'), [])))
        c.check_chain(len(parts), "conditions")
    rest = else_block(c)
    for word, node in reversed(parts):
        node.orelse = rest
        rest = [c.at(word, node)]
    return rest[0]


def while_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `while condition: ... else: ...`."""
    return ast.While(condition(c), block(c, 'the condition of "while"'), else_block(c))


def for_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `for targets in values: ... else: ...`."""
    target = expressions.targets(c)
    c.expect("in", 'after the variable of "for"', 'write "for x in values:"')
    return ast.For(target, expressions.row(c), block(c, 'the head of "for"'), else_block(c))


def try_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `try: ... interrupt when condition: ...`."""
    body = block(c, '"try"')
    interrupts: list[Interrupt] = []
    while c.token.text == "interrupt":
        word = c.advance()
        c.expect("when", 'after "interrupt"', 'write "interrupt when condition:"')
        interrupts.append(c.at(word, Interrupt(condition(c), block(c, 'the condition of "interrupt when"'))))
    if c.token.text in ("except", "finally") or (interrupts and c.token.text == "else"):
        c.refuse(c.token.text)
    if not interrupts:
        c.missing('"interrupt when" after the block of "try"')
    return TryInterrupt(body, interrupts)


def function(c: Cursor, start: Token) -> ast.stmt:
    """Read `def name(parameters) [-> annotation]: ...`."""
    name = c.name("the name of a function").text
    parameters = expressions.bracketed_parameters(c, f'the name of the function "{name}"')
    returns = c.expression() if c.accept("->") else None
    body = block(c, f'the head of the function "{name}"')
    node = ast.FunctionDef(name, parameters, body, [], returns)
    node.type_params = []  # type: ignore[attr-defined]  # a field since Python 3.12
    return node


def begins_refused(c: Cursor, following: Token) -> bool:
    """Reject Python's `match` and `with` statements, and a misplaced `with` specifier; `match` may be a name."""
    ahead = 1
    while c.peek(ahead).kind not in ("newline", "end"):
        ahead += 1
    if c.token.text == "match":
        is_refused = c.peek(ahead + 1).kind == "indent" and c.peek(ahead + 2).text == "case"
    else:
        is_refused = ":" in [c.peek(k).text for k in range(ahead)]
    if is_refused:
        c.refuse(c.token.text)
    if c.token.text == "with":
        hint = "a specifier follows a class, or a comma after another specifier"
        c.fail('expected a value, found the word "with"', hint)
    return False


SIMPLE = {
    "pass": Rule(lambda c, start: ast.Pass()),
    "break": Rule(lambda c, start: ast.Break()),
    "continue": Rule(lambda c, start: ast.Continue()),
    "return": Rule(lambda c, start: ast.Return(None if c.ends_statement() else expressions.row(c))),
    "assert": Rule(lambda c, start: ast.Assert(condition(c), c.expression() if c.accept(",") else None)),
    "import": Rule(import_statement),
    "from": Rule(import_from_statement),
    **dict.fromkeys(("raise", "yield", "async", "del", "global", "nonlocal"), Rule(refused)),
    **dict.fromkeys(("elif", "else", "except", "finally", "in", "is", "and", "or", "as"), Rule(misplaced)),
}
BLOCKS = {
    "if": Rule(if_statement),
    "while": Rule(while_statement),
    "for": Rule(for_statement),
    "try": Rule(try_statement),
    "def": Rule(function),
    "@": Rule(refused),
    **dict.fromkeys(("match", "with"), Rule(refused, begins_refused)),
}
