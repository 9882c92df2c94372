"""The statements and blocks that Scenic adds to Python.

All their words but Scenic 3's hard keywords are names elsewhere, so each production first looks at what follows.
Read next: `syntax.nodes`, for what they become, and `syntax.parser`, which puts all together.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.syntax import nodes, statements
from scenic_lite.syntax.cursor import LOAD, STORE, Cursor, describe
from scenic_lite.syntax.expressions import arguments, atom, bracketed_parameters, element, strings
from scenic_lite.syntax.hints import COMPARES, nearest
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.operators import INFIX, SIGNS, begins_operand, condition, expression, primary
from scenic_lite.syntax.specifiers import begins_specifier, more_specifiers, specifier
from scenic_lite.syntax.statements import Rule

UNITS = ("seconds", "steps")
ATTRIBUTES = ("additive", "dynamic", "final")  # of a property


def begins_value(c: Cursor, following: Token) -> bool:
    """Return whether a value follows the word, so that it is a statement: `take -x` is one, `take - x` a difference."""
    if following.text in SIGNS or following.text == "*":
        adjacent = c.peek(2).column == following.end_column
        return adjacent and following.column > c.token.end_column
    return begins_operand(c, 1)


def begins_action(c: Cursor, following: Token) -> bool:
    """Return what `begins_value` does, after `take` and `do`, which do not stand alone."""
    if following.kind in ("newline", "end") and c.token.text == "take":
        c.fail('expected an action after "take"', 'to do nothing for a step, write "wait"', at=following)
    if following.kind in ("newline", "end"):
        c.fail('expected a behavior after "do"', 'write "do Behavior()"', at=following)
    return begins_value(c, following)


def stands_alone(c: Cursor, following: Token) -> bool:
    """Return whether nothing follows the word."""
    return following.kind in ("newline", "end") or following.text == ";"


def begins_definition(c: Cursor, following: Token) -> bool:
    """Return whether a name follows `behavior`, `monitor` or `scenario`."""
    return following.kind == "name" and following.text not in INFIX


def begins_interrupt(c: Cursor, following: Token) -> bool:
    """Refuse an `interrupt when` that belongs to no `try`."""
    if following.text == "when":
        c.fail('"interrupt when" without "try" before it', 'indent it like the "try" to which it belongs')
    return False


def param(c: Cursor, start: Token) -> ast.stmt:
    """Read `param name = value, 'quoted name' = value`."""
    names: list[str] = []
    places: list[ast.expr] = []
    values: list[ast.expr] = []
    while not names or c.accept(","):
        place, name = param_name(c)
        c.expect("=", f'after the name of the parameter "{name}"', 'write "param name = value"')
        places.append(place)
        names.append(name)
        values.append(expression(c))
    node = nodes.Param(names, values)
    node.places = places
    return node


def param_name(c: Cursor) -> tuple[ast.expr, str]:
    """Read a name, or one in quotes; returns its place and its text."""
    start = c.token
    if start.kind != "string":
        c.name("the name of a parameter")
        return c.at(start, ast.Name(start.text, LOAD)), start.text
    value = strings(c)
    if not isinstance(value, ast.Constant) or not isinstance(value.value, str):
        c.fail("a name in quotes must be plain text", at=start)
    return value, value.value


def require(c: Cursor, start: Token) -> ast.stmt:
    """Read `require[p] condition [as name]`, `require monitor M(...)`."""
    if c.token.text == "monitor" and c.is_name(c.peek()):
        c.advance()
        return nodes.RequireMonitor(expression(c))
    probability = soft(c) if c.token.text == "[" else None
    if c.ends_statement:
        c.fail('expected a condition after "require"')
    c.temporal = c.asks_truth = True
    test = expression(c)
    c.temporal = False
    if c.token.text == "=":
        c.fail('"=" assigns and cannot stand in a condition', COMPARES)
    return nodes.Require(test, probability, as_name(c))


def soft(c: Cursor) -> ast.expr:
    """Read `[p]` of a soft requirement: a number between 0 and 1."""
    c.advance()
    start = c.token
    if start.kind != "number" or c.peek().text != "]":
        hint = 'write "require[0.5] condition"'
        c.fail("the probability of a soft requirement must be a number between 0 and 1", hint)
    value = atom(c, start)
    if isinstance(value, ast.Constant) and not 0 <= value.value <= 1:  # type: ignore[operator]  # of a number
        c.fail(f"the probability of a soft requirement must lie between 0 and 1, not {start.text}", at=start)
    c.advance()
    return value


def as_name(c: Cursor) -> str | None:
    """Read `[as name]`; the name may stand in quotes."""
    if not c.accept("as"):
        return None
    return param_name(c)[1] if c.token.kind == "string" else c.name("the name of a requirement or record").text


def mutate(c: Cursor, start: Token) -> ast.stmt:
    """Read `mutate [objects] [by scale]`."""
    targets = [] if c.ends_statement or c.token.text == "by" else listed(c)
    return nodes.Mutate(targets, expression(c) if c.accept("by") else None)


def listed(c: Cursor, read: Callable[[Cursor], ast.expr] = expression) -> list[ast.expr]:
    """Read `value, value, ...`."""
    found = [read(c)]
    while c.accept(","):
        found.append(read(c))
    return found


def record(c: Cursor, start: Token) -> ast.stmt:
    """Read `record [initial | final] value [every ...] [after ...] [as name] [to file]`."""
    when = "each"
    if c.token.text in ("initial", "final") and begins_value(c, c.peek()) and c.peek().text != "scenario":
        when = c.advance().text
    value = expression(c)
    every, every_unit = optional_duration(c, "every")
    delay, delay_unit = optional_duration(c, "after")
    name = as_name(c)
    file = expression(c) if c.accept("to") else None
    return nodes.Record(value, when, name, every, every_unit, delay, delay_unit, file)


def override(c: Cursor, start: Token) -> ast.stmt:
    """Read `override object specifier, ...`."""
    c.in_target = True
    target = primary(c, c.token)
    c.in_target = False
    if not begins_specifier(c):
        hint = nearest(c.token.text, ["with"]) or 'write "override ego with property value"'
        c.missing("a specifier after the object", hint)
    return nodes.Override(target, more_specifiers(c, [specifier(c)]))


def take(c: Cursor, start: Token) -> ast.stmt:
    """Read `take action, action, ...`; a starred one stands for several."""
    return nodes.Take(listed(c, element))


def wait(c: Cursor, start: Token) -> ast.stmt:
    """Read `wait`, `wait for n steps`, `wait until condition`."""
    if c.accept("until"):
        return nodes.Wait(None, None, condition(c))
    length, unit = optional_duration(c, "for")
    return nodes.Wait(length, unit, None)


def do(c: Cursor, start: Token) -> ast.stmt:
    """Read `do B(), C() [for n steps | until condition]`, `do choose ...`, `do shuffle ...`."""
    how = "all"
    if c.token.text in ("choose", "shuffle") and begins_value(c, c.peek()):
        called = c.peek().text == "(" and c.dialect == 2
        how = how if called else c.advance().text
    calls, weights = listed(c), None
    if how != "all" and isinstance(table := calls[0], ast.Dict):
        calls, weights = [key for key in table.keys if key is not None], table.values
        if len(calls) < len(weights):
            c.fail('"**" has no place among the behaviors', at=table)
    if c.accept("until"):
        return nodes.Do(calls, how, weights, None, None, condition(c))
    length, unit = optional_duration(c, "for")
    if c.token.kind == "name" and (hint := nearest(c.token.text, ("until", "for"))):
        c.fail(f"unexpected {describe(c.token)} after the behavior", hint)
    if c.token.text == "until":
        c.fail('"for" and "until" cannot both stand after "do"')
    return nodes.Do(calls, how, weights, length, unit, None)


def optional_duration(c: Cursor, word: str) -> tuple[ast.expr, str] | tuple[None, None]:
    """Read `[word n seconds | steps]`."""
    return duration(c, word) if c.accept(word) else (None, None)


def duration(c: Cursor, word: str) -> tuple[ast.expr, str]:
    """Read `n seconds`, `n steps`; without a unit seconds are meant, which Scenic 3 does not allow."""
    value = expression(c)
    if c.token.text in UNITS:
        return value, c.advance().text
    if c.token.text in ("second", "step"):
        c.fail(f'unknown unit "{c.token.text}"', f'write "{c.token.text}s"')
    if c.dialect == 3 or (c.token.kind == "name" and not c.ends_statement):
        hint = nearest(c.token.text, UNITS) or f'write "{word} 3 seconds" or "{word} 3 steps"'
        c.missing('"seconds" or "steps"', hint)
    return value, "seconds"


def terminate(c: Cursor, start: Token) -> ast.stmt:
    """Read `terminate`, `terminate simulation`, `terminate [simulation] when condition`, `terminate after n steps`."""
    scope = "simulation" if c.accept("simulation") else "scenario"
    if c.accept("when"):
        return nodes.TerminateWhen(condition(c), scope, as_name(c))
    if scope == "scenario" and c.accept("after"):
        return nodes.TerminateAfter(*duration(c, "after"))
    if not c.ends_statement:
        hint = 'write "terminate when condition", "terminate after 10 seconds" or "terminate" alone'
        c.fail(f'unexpected {describe(c.token)} after "terminate"', hint)
    return nodes.Terminate(scope)


def behavior(c: Cursor, start: Token) -> ast.stmt:
    """Read `behavior B(args):`, `monitor M[(args)]:`."""
    kind = start.text
    name = c.name(f"the name of a {kind}").text
    bare = c.token.text != "(" and kind == "monitor"
    arguments = NONE if bare else bracketed_parameters(c, f'the name of the {kind} "{name}"')
    docstring, preconditions, invariants = head(c, f'the {kind} "{name}"')
    body = statements.rest_of_block(c)
    node = nodes.Behavior(name, arguments, preconditions, invariants, body, kind, docstring)
    node.started = bare
    return c.spanning(start, node)


def scenario(c: Cursor, start: Token) -> ast.stmt:
    """Read `scenario S[(args)]:` with `setup:` and `compose:` blocks, or statements that are its setup."""
    name = c.name("the name of a scenario").text
    owner = f'the scenario "{name}"'
    arguments = bracketed_parameters(c, owner) if c.token.text == "(" else NONE
    docstring, preconditions, invariants = head(c, owner)
    setup: list[ast.stmt] = []
    compose: list[ast.stmt] = []
    if c.token.text in ("setup", "compose") and c.peek().text == ":":
        if c.accept("setup"):
            setup = statements.block(c, '"setup"')
        if c.accept("compose"):
            compose = statements.block(c, '"compose"')
        if c.token.kind != "dedent":
            c.fail('only "setup:" and "compose:", in this order, may stand in a scenario that has one of them')
    setup += statements.rest_of_block(c)
    return c.spanning(start, nodes.Scenario(name, arguments, preconditions, invariants, setup, compose, docstring))


NONE = ast.arguments([], [], None, [], [], None, [])


def head(c: Cursor, owner: str) -> tuple[str | None, list[ast.expr], list[ast.expr]]:
    """Read the colon, a string alone on the first line, and the `precondition: c` and `invariant: c` lines."""
    statements.colon(c, owner)
    if c.token.kind != "newline":
        c.missing(f"a new line after the colon of {owner}")
    statements.indent(c, owner)
    c.class_body = False
    docstring = None
    if c.token.kind == "string" and c.peek().kind == "newline":
        value = strings(c)
        docstring = str(value.value) if isinstance(value, ast.Constant) else None
        c.advance()
    guards: dict[str, list[ast.expr]] = {"precondition": [], "invariant": []}
    while c.token.text in guards and c.peek().text == ":":
        kind = c.advance().text
        c.advance()
        guards[kind].append(condition(c))
        if c.token.kind != "newline":
            c.missing(f"the end of the line after the {kind}")
        c.advance()
    return docstring, guards["precondition"], guards["invariant"]


def class_statement(c: Cursor, start: Token) -> ast.stmt:
    """Read `class Name(bases): ...`."""
    name = c.name("the name of a class").text
    bases, keywords = arguments(c) if c.token.text == "(" else ([], [])
    body = statements.block(c, f'the head of the class "{name}"', of_class=True)
    node = ast.ClassDef(name, bases, keywords, body, [])
    node.type_params = []  # type: ignore[attr-defined]
    return c.spanning(start, node)


def property_default(c: Cursor, start: Token) -> ast.stmt:
    """Read `property[attributes]: default`; with a further `= value` it is Python's annotation."""
    attributes: list[str] = []
    if c.accept("["):
        while not c.accept("]"):
            if c.token.text not in ATTRIBUTES:
                hint = nearest(c.token.text, ATTRIBUTES) or f"attributes are: {', '.join(ATTRIBUTES)}"
                c.fail(f'unknown attribute "{c.token.text}" of a property', hint)
            attributes.append(c.advance().text)
            c.accept(",")
    c.advance()
    if c.ends_statement:
        c.fail(f'expected a default value for the property "{start.text}"')
    value = c.expression()
    if c.token.text != "=" or attributes:
        return nodes.PropertyDefault(start.text, attributes, value)
    c.advance()
    target = ast.Name(start.text, STORE)
    target.lineno, target.col_offset, target.end_lineno, target.end_col_offset = start[2:]
    return ast.AnnAssign(target, value, statements.assigned_value(c), 1)


# ---------------------------------------------------------------- the tables

STATEMENTS = {
    **statements.SIMPLE,
    ":": Rule(property_default),  # in the body of a class
    "model": Rule(lambda c, _: nodes.Model(statements.dotted_name(c, "a model")), lambda c, then: then.kind == "name"),
    "param": Rule(param, lambda c, then: then.kind in ("name", "string")),
    "require": Rule(require, lambda c, then: begins_value(c, then) or stands_alone(c, then)),
    "mutate": Rule(mutate, lambda c, then: c.is_name(then) or then.text == "by" or stands_alone(c, then)),
    "record": Rule(record, begins_value),
    "simulator": Rule(lambda c, _: nodes.Simulator(expression(c)), begins_value),
    "override": Rule(override, Cursor.is_name),
    "take": Rule(take, begins_action),
    "wait": Rule(wait, lambda c, then: then.text in ("for", "until") or stands_alone(c, then)),
    "do": Rule(do, begins_action),
    "abort": Rule(lambda c, _: nodes.Abort(), stands_alone),
    "terminate": Rule(terminate, lambda c, then: then.kind != "operator" or then.text == ";"),
    "interrupt": Rule(statements.refused, begins_interrupt),
}
BLOCKS = {
    **statements.BLOCKS,
    "class": Rule(class_statement),
    **dict.fromkeys(("behavior", "monitor"), Rule(behavior, begins_definition)),
    "scenario": Rule(scenario, begins_definition),
}
