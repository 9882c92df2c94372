"""From program text to syntax tree: a hand-written recursive-descent parser with one grammar for Scenic 2 and 3.

The module `cursor` walks the tokens. `expressions` and `operators` read values, `statements` reads Python's statements,
and this module reads the statements that Scenic adds. The first words of these statements may also be names, except
Scenic 3's hard keywords, so the following tokens decide. No text is ever passed to Python's compiler.
Read next: `syntax.nodes`, the resulting nodes, and `syntax.check`, for the rules that need the whole tree.
"""

from __future__ import annotations

import ast
import keyword
import re
from functools import partial

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.syntax import nodes, operators, statements
from scenic_lite.syntax.cursor import LOAD, Cursor, describe
from scenic_lite.syntax.expressions import arguments, atom, bracketed_parameters, condition, element, listed, strings
from scenic_lite.syntax.grammar import INFIX, SIGNS, nearest
from scenic_lite.syntax.lexer import Source, Token, lex
from scenic_lite.syntax.statements import Rule, block

DIALECTS = (2, 3)
MARKER = re.compile(r"#!?\s*(?:scenic|dialect)\s*:\s*(?P<version>\d[^\s;,]*)\s*(?:[;,].*)?$", re.IGNORECASE)
UNITS = ("seconds", "steps")
ATTRIBUTES = ("additive", "dynamic", "final")  # attributes of a property
NO_PARAMETERS = ast.arguments([], [], None, [], [], None, [])


def parse(text: str, file: str = "<program>", dialect: int = 2) -> ast.Module:
    """Parse a program into Python's `ast` nodes and those of `nodes`.

    `dialect` 2 or 3 selects the version of Scenic. Columns count characters, unlike Python's columns, which count
    bytes. Raises ScenicError: `syntax`, `unsupported`, or `budget` if the program is too long or too deeply nested.
    """
    if dialect not in DIALECTS:
        raise ValueError(f"dialect must be 2 or 3, not {dialect!r}")
    c = Cursor(Source(text, file), dialect)
    c.statements, c.blocks = STATEMENTS, BLOCKS
    c.expression, c.operation = partial(operators.expression, c), partial(operators.operation, c)
    try:
        return statements.module(c)
    except RecursionError:
        error: ScenicError = c.source.error("the program is nested too deeply here", c.place(), kind="budget")
    raise error


def dialect_of(text: str, file: str, dialect: int | None) -> int:
    """Return the dialect: as requested, or from a first line `# scenic: 3`, or 3 if `new` precedes a class, else 2.

    Raises ValueError for an unknown requested dialect, ScenicError for an unknown dialect in the first line.
    """
    if dialect is not None:
        if dialect not in DIALECTS:
            raise ValueError(f"dialect must be one of {DIALECTS}, not {dialect!r}")
        return dialect
    first = text.removeprefix("\ufeff").split("\n", 1)[0].rstrip()
    match = MARKER.match(first)
    if match is None:
        return 3 if makes_instances_with_new(text, file) else 2
    version = match["version"].split(".")[0]
    if version not in ("2", "3"):
        message = f"there is no dialect {match['version']} of Scenic here"
        place = SourceSpan(file, 1, match.start("version"), 1, match.end("version"))
        raise ScenicError("syntax", message, place, hint="write # scenic: 2 or # scenic: 3", source_line=first)
    return int(version)


def makes_instances_with_new(text: str, file: str) -> bool:
    """Return whether the program uses the word `new` as in Scenic 3: before a class name, and not as a name."""
    if "new" not in text:
        return False
    tokens = lex(Source(text, file))
    for before, word, after in zip([None, *tokens], tokens, tokens[1:], strict=False):
        follows_dot = before is not None and before.text == "."
        if word.text == "new" and after.kind == "name" and not keyword.iskeyword(after.text) and not follows_dot:
            return True
    return False


# ---------------------------------------------------------------- after a first word
def begins_value(c: Cursor, following: Token) -> bool:
    """Return whether a value follows a first word, which makes it a statement: `take -x`, but not `take - x`."""
    if following.text in SIGNS or following.text == "*":
        adjacent = c.peek(2).column == following.end_column
        return adjacent and following.column > c.token.end_column
    return operators.begins_operand(c, 1)


def begins_action(c: Cursor, following: Token) -> bool:
    """Return the result of `begins_value` after `take` or `do`, which require an operand."""
    if following.kind in ("newline", "end") and c.token.text == "take":
        c.fail('expected an action after "take"', 'to do nothing for a step, write "wait"', at=following)
    if following.kind in ("newline", "end"):
        c.fail('expected a behavior after "do"', 'write "do Behavior()"', at=following)
    return begins_value(c, following)


def begins_definition(c: Cursor, following: Token) -> bool:
    """Return whether a name follows `behavior`, `monitor` or `scenario`."""
    return following.kind == "name" and following.text not in INFIX


def begins_interrupt(c: Cursor, following: Token) -> bool:
    """Reject an `interrupt when` without a `try`."""
    if following.text == "when":
        c.fail('"interrupt when" without "try" before it', 'indent it like the "try" to which it belongs')
    return False


# ---------------------------------------------------------------- statements
def param(c: Cursor, start: Token) -> ast.stmt:
    """Read `param name = value, 'quoted name' = value`."""
    node = nodes.Param([], [])
    node.places = listed(c, lambda c: one_param(c, node))
    return node


def one_param(c: Cursor, node: nodes.Param) -> ast.expr:
    """Read `name = value` into a statement; return the place of the name."""
    place, name = quoted_name(c, "the name of a parameter")
    c.expect("=", f'after the name of the parameter "{name}"', 'write "param name = value"')
    node.names.append(name)
    node.values.append(operators.expression(c))
    return place


def quoted_name(c: Cursor, what: str) -> tuple[ast.expr, str]:
    """Read a plain or quoted name; return its place and its text."""
    start = c.token
    if start.kind != "string":
        c.name(what)
        return c.at(start, ast.Name(start.text, LOAD)), start.text
    value = strings(c)
    if not isinstance(value, ast.Constant) or not isinstance(value.value, str):
        c.fail("a name in quotes must be plain text", at=start)
    return value, value.value


def require(c: Cursor, start: Token) -> ast.stmt:
    """Read `require[p] condition [as name]`, `require monitor M(...)`."""
    if c.token.text == "monitor" and c.is_name(c.peek()):
        c.advance()
        return nodes.RequireMonitor(operators.expression(c))
    probability = soft(c) if c.token.text == "[" else None
    if c.ends_statement():
        c.fail('expected a condition after "require"')
    c.temporal = True
    test = condition(c)
    c.temporal = False
    return nodes.Require(test, probability, as_name(c))


def soft(c: Cursor) -> ast.expr:
    """Read `[p]` of a soft requirement: a number between 0 and 1."""
    c.advance()
    start = c.token
    if start.kind != "number" or c.peek().text != "]":
        hint = 'write "require[0.5] condition"'
        c.fail("the probability of a soft requirement must be a number between 0 and 1", hint)
    value = atom(c, start)
    if isinstance(value, ast.Constant) and not 0 <= value.value <= 1:  # type: ignore[operator]  # a number
        c.fail(f"the probability of a soft requirement must lie between 0 and 1, not {start.text}", at=start)
    c.advance()
    return value


def as_name(c: Cursor) -> str | None:
    """Read `[as name]`; the name may be quoted."""
    return quoted_name(c, "the name of a requirement or record")[1] if c.accept("as") else None


def mutate(c: Cursor, start: Token) -> ast.stmt:
    """Read `mutate [objects] [by scale]`."""
    targets = [] if c.ends_statement() or c.token.text == "by" else listed(c, operators.expression)
    return nodes.Mutate(targets, operators.expression(c) if c.accept("by") else None)


def record(c: Cursor, start: Token) -> ast.stmt:
    """Read `record [initial | final] value [every ...] [after ...] [as name] [to file]`."""
    when = "each"
    if c.token.text in ("initial", "final") and begins_value(c, c.peek()) and c.peek().text != "scenario":
        when = c.advance().text
    value, every, delay, name = operators.expression(c), duration(c, "every"), duration(c, "after"), as_name(c)
    return nodes.Record(value, when, name, *every, *delay, operators.expression(c) if c.accept("to") else None)


def override(c: Cursor, start: Token) -> ast.stmt:
    """Read `override object specifier, ...`."""
    c.in_target = True
    target = operators.primary(c, c.token)
    c.in_target = False
    if not operators.begins_specifier(c):
        hint = nearest(c.token.text, ["with"]) or 'write "override ego with property value"'
        c.missing("a specifier after the object", hint)
    return nodes.Override(target, operators.more_specifiers(c, [operators.specifier(c)]))


def wait(c: Cursor, start: Token) -> ast.stmt:
    """Read `wait`, `wait for n steps`, `wait until condition`."""
    until = condition(c) if c.accept("until") else None
    return nodes.Wait(*duration(c, "for" if until is None else None), until)


def do(c: Cursor, start: Token) -> ast.stmt:
    """Read `do B(), C() [for n steps | until condition]`, `do choose ...`, `do shuffle ...`."""
    how = "all"
    called = c.peek().text == "(" and c.dialect == 2
    if c.token.text in ("choose", "shuffle") and not called and begins_value(c, c.peek()):
        how = c.advance().text
    calls, weights = listed(c, operators.expression), None
    if how != "all" and isinstance(table := calls[0], ast.Dict):
        calls, weights = [key for key in table.keys if key is not None], table.values
        if len(calls) < len(weights):
            c.fail('"**" has no place among the behaviors', at=table)
    until = condition(c) if c.accept("until") else None
    length = duration(c, "for" if until is None else None)
    if until is None and c.token.kind == "name" and (hint := nearest(c.token.text, ("until", "for"))):
        c.fail(f"unexpected {describe(c.token)} after the behavior", hint)
    if c.token.text == "until":
        c.fail('"for" and "until" cannot both stand after "do"')
    return nodes.Do(calls, how, weights, *length, until)


def duration(c: Cursor, word: str | None) -> tuple[ast.expr | None, str | None]:
    """Read `[word n seconds | steps]`; the default unit is seconds, but Scenic 3 requires a unit."""
    if word is None or not c.accept(word):
        return None, None
    value = operators.expression(c)
    if c.token.text in UNITS:
        return value, c.advance().text
    if c.token.text in ("second", "step"):
        c.fail(f'unknown unit "{c.token.text}"', f'write "{c.token.text}s"')
    if c.dialect == 3 or (c.token.kind == "name" and not c.ends_statement()):
        hint = nearest(c.token.text, UNITS) or f'write "{word} 3 seconds" or "{word} 3 steps"'
        c.missing('"seconds" or "steps"', hint)
    return value, "seconds"


def terminate(c: Cursor, start: Token) -> ast.stmt:
    """Read `terminate`, `terminate simulation`, `terminate [simulation] when condition`, `terminate after n steps`."""
    scope = "simulation" if c.accept("simulation") else "scenario"
    if c.accept("when"):
        return nodes.TerminateWhen(condition(c), scope, as_name(c))
    if scope == "scenario" and c.token.text == "after":
        return nodes.TerminateAfter(*duration(c, "after"))  # type: ignore[arg-type]  # the duration exists
    if not c.ends_statement():
        hint = 'write "terminate when condition", "terminate after 10 seconds" or "terminate" alone'
        c.fail(f'unexpected {describe(c.token)} after "terminate"', hint)
    return nodes.Terminate(scope)


def behavior(c: Cursor, start: Token) -> ast.stmt:
    """Read `behavior B(args):`, `monitor M[(args)]:`."""
    kind, name = start.text, c.name(f"the name of a {start.text}").text
    bare = c.token.text != "(" and kind == "monitor"
    arguments = NO_PARAMETERS if bare else bracketed_parameters(c, f'the name of the {kind} "{name}"')
    node = nodes.Behavior(name, arguments, [], [], [], kind, None)
    node.started = bare
    node.body = block(c, f'the {kind} "{name}"', lambda: head(c, node))
    return node


def scenario(c: Cursor, start: Token) -> ast.stmt:
    """Read `scenario S[(args)]:` with `setup:` and `compose:` blocks, or with the statements of its setup."""
    name = c.name("the name of a scenario").text
    owner = f'the scenario "{name}"'
    arguments = bracketed_parameters(c, owner) if c.token.text == "(" else NO_PARAMETERS
    node = nodes.Scenario(name, arguments, [], [], [], [], None)

    def begin() -> None:
        head(c, node)
        for word, part in (("setup", node.setup), ("compose", node.compose)):
            if c.token.text == word and c.peek().text == ":":
                c.advance()
                part += block(c, f'"{word}"')
        if (node.setup or node.compose) and c.token.kind != "dedent":
            c.fail('only "setup:" and "compose:", in this order, may stand in a scenario that has one of them')

    node.setup += block(c, owner, begin)
    return node


def head(c: Cursor, node: nodes.Behavior | nodes.Scenario) -> None:
    """Read an optional docstring, and the `precondition: c` and `invariant: c` lines."""
    if c.token.kind == "string" and c.peek().kind == "newline":
        value = strings(c)
        node.docstring = str(value.value) if isinstance(value, ast.Constant) else None
        c.advance()
    guards = {"precondition": node.preconditions, "invariant": node.invariants}
    while c.token.text in guards and c.peek().text == ":":
        kind = c.advance().text
        c.advance()
        guards[kind].append(condition(c))
        if c.token.kind != "newline":
            c.missing(f"the end of the line after the {kind}")
        c.advance()


def class_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `class Name(bases): ...`."""
    name = c.name("the name of a class").text
    bases, keywords = arguments(c) if c.token.text == "(" else ([], [])
    body = block(c, f'the head of the class "{name}"', of_class=True)
    node = ast.ClassDef(name, bases, keywords, body, [])
    node.type_params = []  # type: ignore[attr-defined]
    return node


def property_default(c: Cursor, start: Token) -> ast.stmt:
    """Read `property[attributes]: default`."""
    attributes: list[str] = []
    if c.accept("["):
        while not c.accept("]"):
            if c.token.text not in ATTRIBUTES:
                hint = nearest(c.token.text, ATTRIBUTES) or f"attributes are: {', '.join(ATTRIBUTES)}"
                c.fail(f'unknown attribute "{c.token.text}" of a property', hint)
            attributes.append(c.advance().text)
            c.accept(",")
    c.advance()
    if c.ends_statement():
        c.fail(f'expected a default value for the property "{start.text}"')
    value = c.expression()
    if c.token.text == "=":
        c.refuse("type")
    return nodes.PropertyDefault(start.text, attributes, value)


# ---------------------------------------------------------------- the tables

STATEMENTS = {
    **statements.SIMPLE,
    ":": Rule(property_default),  # in the body of a class
    "model": Rule(lambda c, _: nodes.Model(statements.dotted_name(c, "a model")), lambda c, then: then.kind == "name"),
    "param": Rule(param, lambda c, then: then.kind in ("name", "string")),
    "require": Rule(require, lambda c, then: begins_value(c, then) or c.ends_statement(then)),
    "mutate": Rule(mutate, lambda c, then: c.is_name(then) or then.text == "by" or c.ends_statement(then)),
    "record": Rule(record, begins_value),
    "simulator": Rule(lambda c, _: nodes.Simulator(operators.expression(c)), begins_value),
    "override": Rule(override, Cursor.is_name),
    "take": Rule(lambda c, _: nodes.Take(listed(c, element)), begins_action),
    "wait": Rule(wait, lambda c, then: then.text in ("for", "until") or c.ends_statement(then)),
    "do": Rule(do, begins_action),
    "abort": Rule(lambda c, _: nodes.Abort(), Cursor.ends_statement),
    "terminate": Rule(terminate, lambda c, then: then.kind != "operator" or then.text == ";"),
    "interrupt": Rule(statements.refused, begins_interrupt),
}
BLOCKS = {
    **statements.BLOCKS,
    "class": Rule(class_statement),
    **dict.fromkeys(("behavior", "monitor"), Rule(behavior, begins_definition)),
    "scenario": Rule(scenario, begins_definition),
}
