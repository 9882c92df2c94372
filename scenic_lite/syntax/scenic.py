"""The statements and blocks that Scenic adds to Python.

All their words but Scenic 3's hard keywords are names elsewhere, so each production first looks at what follows.
Read next: `syntax.nodes`, for what they become, and `syntax.parser`, which puts everything together.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.syntax import nodes
from scenic_lite.syntax.blocks import Blocks
from scenic_lite.syntax.cursor import LOAD, STORE, describe, nearest
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.operators import SIGNS
from scenic_lite.syntax.statements import AUGMENTED

UNITS = ("seconds", "steps")
ATTRIBUTES = ("additive", "dynamic", "final")
# After one of these signs the word before is a name that is assigned to, read or called.
_NAME_SIGNS = frozenset({"=", ".", ",", ")", "]", "}", ":", "->", ":=", *AUGMENTED})


class ScenicStatements(Blocks):
    """The productions of Scenic's statements."""

    # ------------------------------------------------------------ which statement?

    def scenic_statement(self, start: Token) -> ast.stmt | None:
        """A statement of Scenic that fits on a line, or None if the word is a name here."""
        following = self.peek()
        if self.class_body and self.begins_property(following):
            return self.property_default()
        production = SIMPLE.get(start.text)
        if production is None or (following.kind == "operator" and following.text in _NAME_SIGNS):
            if start.text in self.keywords and following.text in ("=", *AUGMENTED):
                self.fail(f'"{start.text}" is a word of the language and cannot be the name of a variable')
            return None
        return production(self, following)

    def scenic_block(self, start: Token) -> ast.stmt | None:
        """A behavior, monitor or scenario, or None if the word is a name here."""
        text = start.text
        if text not in ("behavior", "monitor", "scenario") or self.peek().kind != "name":
            return None
        if self.peek().text in self.operators:
            return None
        return self.scenario() if text == "scenario" else self.behavior()

    def is_statement(self, following: Token) -> bool:
        """Does a value follow the word, so that it is a statement? `take -x` is one, `take - x` is a difference."""
        if following.text in SIGNS or following.text == "*":
            adjacent = self.peek(2).column == following.end_column
            return adjacent and following.column > self.token.end_column
        return self.begins_operand(1)

    # ------------------------------------------------------------ the whole scene

    def model(self, following: Token) -> ast.stmt | None:
        """`model a.b.c`."""
        if following.kind != "name":
            return None
        self.advance()
        return nodes.Model(self.dotted_name("a model"))

    def param(self, following: Token) -> ast.stmt | None:
        """`param name = value, 'quoted name' = value`."""
        if following.kind not in ("name", "string"):
            return None
        self.advance()
        names: list[str] = []
        places: list[ast.expr] = []
        values: list[ast.expr] = []
        while not names or self.accept(","):
            place, name = self.param_name()
            self.expect("=", f'after the name of the parameter "{name}"', 'write "param name = value"')
            places.append(place)
            names.append(name)
            values.append(self.expression())
        node = nodes.Param(names, values)
        node.places = places
        return node

    def param_name(self) -> tuple[ast.expr, str]:
        """A name, or one in quotes: its place and its text."""
        start = self.token
        if start.kind != "string":
            self.name("the name of a parameter")
            return self.at(start, ast.Name(start.text, LOAD)), start.text
        value = self.strings()
        if not isinstance(value, ast.Constant) or not isinstance(value.value, str):
            self.fail("a name in quotes must be plain text", at=start)
        return value, value.value

    def require(self, following: Token) -> ast.stmt | None:
        """`require[p] condition [as name]`, `require monitor M(...)`."""
        if not self.is_statement(following) and following.kind not in ("newline", "end"):
            return None
        self.advance()
        if following.text == "monitor" and self.is_name(self.peek()):
            self.advance()
            return nodes.RequireMonitor(self.expression())
        probability = self.probability() if following.text == "[" else None
        if self.ends_here():
            self.fail('expected a condition after "require"')
        condition = self.requirement()
        return nodes.Require(condition, probability, self.as_name())

    def probability(self) -> ast.expr:
        """`[p]` of a soft requirement: a number between 0 and 1."""
        self.advance()
        start = self.token
        if start.kind != "number" or self.peek().text != "]":
            hint = 'write "require[0.5] condition"'
            self.fail("the probability of a soft requirement must be a number between 0 and 1", hint)
        value = self.number(self.advance())
        if isinstance(value, complex) or not 0 <= value <= 1:
            message = f"the probability of a soft requirement must lie between 0 and 1, not {start.text}"
            self.fail(message, at=start)
        node = self.at(start, ast.Constant(value))
        self.advance()
        return node

    def requirement(self) -> ast.expr:
        """A condition in which `always`, `eventually`, `next`, `until` and `implies` count."""
        self.set_temporal(True)
        self.asks_truth = True
        condition = self.expression()
        self.set_temporal(False)
        if self.token.text == "=":
            self.fail('"=" assigns and cannot stand in a condition', '"==" compares')
        return condition

    def as_name(self) -> str | None:
        """`[as name]`; the name may stand in quotes."""
        if not self.accept("as"):
            return None
        if self.token.kind == "string":
            return self.param_name()[1]
        return self.name("the name of a requirement or record").text

    def mutate(self, following: Token) -> ast.stmt | None:
        """`mutate [objects] [by scale]`."""
        if not self.is_name(following) and following.text != "by" and following.kind not in ("newline", "end"):
            return None
        self.advance()
        targets: list[ast.expr] = []
        if not self.ends_here() and self.token.text != "by":
            targets.append(self.expression())
            while self.accept(","):
                targets.append(self.expression())
        return nodes.Mutate(targets, self.expression() if self.accept("by") else None)

    def record(self, following: Token) -> ast.stmt | None:
        """`record [initial | final] value [every ...] [after ...] [as name] [to file]`."""
        if not self.is_statement(following):
            return None
        self.advance()
        when = "each"
        if self.token.text in ("initial", "final") and self.is_statement(self.peek()):
            when = self.advance().text if self.peek().text != "scenario" else when
        value = self.expression()
        every, every_unit = self.optional_duration("every")
        delay, delay_unit = self.optional_duration("after")
        name = self.as_name()
        file = self.expression() if self.accept("to") else None
        return nodes.Record(value, when, name, every, every_unit, delay, delay_unit, file)

    def simulator(self, following: Token) -> ast.stmt | None:
        """`simulator value`."""
        if not self.is_statement(following):
            return None
        self.advance()
        return nodes.Simulator(self.expression())

    def override(self, following: Token) -> ast.stmt | None:
        """`override object specifier, ...`."""
        if not self.is_name(following):
            return None
        self.advance()
        self.in_target = True
        target = self.primary(self.token)
        self.in_target = False
        if not self.begins_specifier():
            hint = nearest(self.token.text, ["with"]) or 'write "override ego with property value"'
            self.fail(f"expected a specifier after the object, found {describe(self.token)}", hint)
        specifiers = [self.specifier()]
        self.more_specifiers(specifiers)
        return nodes.Override(target, specifiers)

    # ------------------------------------------------------------ within behaviors

    def take(self, following: Token) -> ast.stmt | None:
        """`take action, action, ...`."""
        if following.kind in ("newline", "end"):
            self.fail('expected an action after "take"', 'to do nothing for a step, write "wait"', at=following)
        if not self.is_statement(following):
            return None
        self.advance()
        actions = [self.action()]
        while self.accept(","):
            actions.append(self.action())
        return nodes.Take(actions)

    def action(self) -> ast.expr:
        """One action; a starred one stands for several."""
        return self.element_without_assignment()

    def wait(self, following: Token) -> ast.stmt | None:
        """`wait`, `wait for n steps`, `wait until condition`."""
        if following.text == "for":
            self.skip(2)
            return nodes.Wait(*self.duration("for"), None)
        if following.text == "until":
            self.skip(2)
            return nodes.Wait(None, None, self.condition())
        if following.kind not in ("newline", "end") and following.text != ";":
            return None
        self.advance()
        return nodes.Wait(None, None, None)

    def do(self, following: Token) -> ast.stmt | None:
        """`do B(), C() [for n steps | until condition]`, `do choose ...`, `do shuffle ...`."""
        if following.kind in ("newline", "end"):
            self.fail('expected a behavior after "do"', 'write "do Behavior()"', at=following)
        if not self.is_statement(following):
            return None
        self.advance()
        how = "all"
        if self.token.text in ("choose", "shuffle") and self.is_statement(self.peek()):
            called = self.peek().text == "(" and self.dialect == 2
            how = how if called else self.advance().text
        calls, weights = self.calls(how)
        if self.accept("until"):
            return nodes.Do(calls, how, weights, None, None, self.condition())
        length, unit = self.optional_duration("for")
        if self.token.kind == "name" and (hint := nearest(self.token.text, ("until", "for"))):
            self.fail(f"unexpected {describe(self.token)} after the behavior", hint)
        if self.token.text == "until":
            self.fail('"for" and "until" cannot both stand after "do"')
        return nodes.Do(calls, how, weights, length, unit, None)

    def calls(self, how: str) -> tuple[list[ast.expr], list[ast.expr] | None]:
        """The behaviors after `do`; with weights if `choose` or `shuffle` has a dictionary."""
        first = self.expression()
        if how != "all" and isinstance(first, ast.Dict):
            if None in first.keys:
                self.fail('"**" has no place among the behaviors', at=first)
            return list(first.keys), first.values  # type: ignore[arg-type]
        found = [first]
        while self.accept(","):
            found.append(self.expression())
        return found, None

    def optional_duration(self, word: str) -> tuple[ast.expr, str] | tuple[None, None]:
        """`[word n seconds | steps]`."""
        return self.duration(word) if self.accept(word) else (None, None)

    def duration(self, word: str) -> tuple[ast.expr, str]:
        """`n seconds`, `n steps`; without a unit seconds are meant, which Scenic 3 does not allow."""
        value = self.expression()
        if self.token.text in UNITS:
            return value, self.advance().text
        if self.token.text in ("second", "step"):
            self.fail(f'unknown unit "{self.token.text}"', f'write "{self.token.text}s"')
        if self.dialect == 3 or (self.token.kind == "name" and not self.ends_here()):
            hint = nearest(self.token.text, UNITS) or f'write "{word} 3 seconds" or "{word} 3 steps"'
            self.fail(f'expected "seconds" or "steps", found {describe(self.token)}', hint)
        return value, "seconds"

    def abort(self, following: Token) -> ast.stmt | None:
        """`abort`."""
        if following.kind not in ("newline", "end") and following.text != ";":
            return None
        self.advance()
        return nodes.Abort()

    def terminate(self, following: Token) -> ast.stmt | None:
        """`terminate`, `terminate simulation`, `terminate [simulation] when condition`, `terminate after n steps`."""
        if following.kind == "operator" and following.text != ";":
            return None
        self.advance()
        scope = "simulation" if self.accept("simulation") else "scenario"
        if self.accept("when"):
            return nodes.TerminateWhen(self.condition(), scope, self.as_name())
        if scope == "scenario" and self.accept("after"):
            return nodes.TerminateAfter(*self.duration("after"))
        if not self.ends_here():
            hint = 'write "terminate when condition", "terminate after 10 seconds" or "terminate" alone'
            self.fail(f'unexpected {describe(self.token)} after "terminate"', hint)
        return nodes.Terminate(scope)

    def interrupt_alone(self, following: Token) -> ast.stmt | None:
        """`interrupt when` that belongs to no `try`."""
        if following.text == "when":
            self.fail('"interrupt when" without "try" before it', 'indent it like the "try" to which it belongs')
        return None

    # ------------------------------------------------------------ classes

    def begins_property(self, following: Token) -> bool:
        """Does `name: default` or `name[attributes]: default` come next?"""
        if following.text == ":":
            return self.is_name(self.token) or self.token.text == "behavior"
        return following.text == "[" and self.peek(2).kind == "name" and self.bracket_before_colon()

    def bracket_before_colon(self) -> bool:
        """Is `[word, word]:` next?"""
        ahead = 2
        while self.peek(ahead).kind == "name" or self.peek(ahead).text == ",":
            ahead += 1
        return self.peek(ahead).text == "]" and self.peek(ahead + 1).text == ":"

    def property_default(self) -> ast.stmt:
        """`property[attributes]: default`; with a further `= value` it is Python's annotation."""
        start = self.advance()
        attributes: list[str] = []
        if self.accept("["):
            while not self.accept("]"):
                if self.token.text not in ATTRIBUTES:
                    hint = nearest(self.token.text, ATTRIBUTES) or f"attributes are: {', '.join(ATTRIBUTES)}"
                    self.fail(f'unknown attribute "{self.token.text}" of a property', hint)
                attributes.append(self.advance().text)
                self.accept(",")
        self.advance()
        if self.ends_here():
            self.fail(f'expected a default value for the property "{start.text}"')
        value = self.expression()
        if self.token.text == "=" and not attributes:
            self.advance()
            target = ast.Name(start.text, STORE)
            target.lineno, target.col_offset, target.end_lineno, target.end_col_offset = start[2:]
            return ast.AnnAssign(target, value, self.assigned_value(), 1)
        return nodes.PropertyDefault(start.text, attributes, value)

    # ------------------------------------------------------------ behaviors, monitors, scenarios

    def behavior(self) -> ast.stmt:
        """`behavior B(args):`, `monitor M[(args)]:`."""
        start = self.advance()
        kind = start.text
        name = self.name(f"the name of a {kind}").text
        owner = f'the {kind} "{name}"'
        brackets = self.token.text == "("
        if brackets or kind == "behavior":
            arguments = self.bracketed_parameters(f'the name of the {kind} "{name}"')
        else:
            arguments = _no_arguments()
        self.begin_definition(owner)
        docstring = self.docstring()
        preconditions, invariants = self.guards()
        body: list[ast.stmt] = []
        while self.token.kind != "dedent":
            body.extend(self.statement())
        self.end_block()
        node = nodes.Behavior(name, arguments, preconditions, invariants, body, kind, docstring)
        node.started = kind == "monitor" and not brackets
        return self.at_last_line(start, node)

    def begin_definition(self, owner: str) -> None:
        """The colon and the indentation of a definition; its body is not the body of a class."""
        self.colon(owner)
        if self.token.kind != "newline":
            self.fail(f"expected a new line after the colon of {owner}, found {describe(self.token)}")
        self.indented(owner)
        self.class_body = False

    def at_last_line(self, start: Token, node: ast.stmt) -> ast.stmt:
        """Place a node from `start` to the last token that is not layout."""
        index = self.index - 1
        while self.tokens[index].kind in ("dedent", "newline", "indent"):
            index -= 1
        last = self.tokens[index]
        node.lineno, node.col_offset = start.line, start.column
        node.end_lineno, node.end_col_offset = last.end_line, last.end_column
        return node

    def docstring(self) -> str | None:
        """A string alone on the first line of a definition."""
        if self.token.kind != "string" or self.peek().kind != "newline":
            return None
        value = self.strings()
        self.advance()
        return value.value if isinstance(value, ast.Constant) and isinstance(value.value, str) else None

    def guards(self) -> tuple[list[ast.expr], list[ast.expr]]:
        """`precondition: condition` and `invariant: condition` lines."""
        found: dict[str, list[ast.expr]] = {"precondition": [], "invariant": []}
        while self.token.text in found and self.peek().text == ":":
            kind = self.advance().text
            self.advance()
            found[kind].append(self.condition())
            if self.token.kind != "newline":
                self.fail(f"expected the end of the line after the {kind}, found {describe(self.token)}")
            self.advance()
        return found["precondition"], found["invariant"]

    def scenario(self) -> ast.stmt:
        """`scenario S[(args)]:` with `setup:` and `compose:` blocks, or statements that are its setup."""
        start = self.advance()
        name = self.name("the name of a scenario").text
        owner = f'the scenario "{name}"'
        arguments = self.bracketed_parameters(owner) if self.token.text == "(" else _no_arguments()
        self.begin_definition(owner)
        docstring = self.docstring()
        preconditions, invariants = self.guards()
        setup: list[ast.stmt] = []
        compose: list[ast.stmt] = []
        if self.token.text in ("setup", "compose") and self.peek().text == ":":
            if self.accept("setup"):
                setup = self.block('"setup"')
            if self.token.text == "compose" and self.accept("compose"):
                compose = self.block('"compose"')
            if self.token.kind != "dedent":
                self.fail('only "setup:" and "compose:", in this order, may stand in a scenario that has one of them')
        while self.token.kind != "dedent":
            setup.extend(self.statement())
        self.end_block()
        node = nodes.Scenario(name, arguments, preconditions, invariants, setup, compose, docstring)
        return self.at_last_line(start, node)


def _no_arguments() -> ast.arguments:
    return ast.arguments([], [], None, [], [], None, [])


SIMPLE: dict[str, Callable[[ScenicStatements, Token], ast.stmt | None]] = {
    "model": ScenicStatements.model,
    "param": ScenicStatements.param,
    "require": ScenicStatements.require,
    "mutate": ScenicStatements.mutate,
    "record": ScenicStatements.record,
    "simulator": ScenicStatements.simulator,
    "override": ScenicStatements.override,
    "take": ScenicStatements.take,
    "wait": ScenicStatements.wait,
    "do": ScenicStatements.do,
    "abort": ScenicStatements.abort,
    "terminate": ScenicStatements.terminate,
    "interrupt": ScenicStatements.interrupt_alone,
}
