"""Rules of the language that need the whole tree: what may stand where, what may occur only once, what never ends.

All findings are returned together, sorted by place. Names that are defined nowhere are not looked for here: that needs
the imported library. Read next: `syntax.check_loops`, for endless loops, and `loader`, which runs the static half.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import NamedTuple

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes
from scenic_lite.syntax.check_doubts import BUILT_IN, doubts
from scenic_lite.syntax.check_loops import endless_loop, suspends
from scenic_lite.syntax.lexer import Source

DYNAMIC = ("behavior", "monitor", "compose")
TEMPORAL = frozenset({"always", "eventually", "next", "until", "implies"})


class Context(NamedTuple):
    """Where a statement stands."""

    kind: str = "top"  # top, function, behavior, monitor, compose
    name: str = ""  # of the function, behavior or monitor
    loop: bool = False
    handler: bool = False  # in the block of an `interrupt when`

    def words(self) -> str:
        """The place in words."""
        if self.kind == "compose":
            return "in a compose block"
        return f'in the {self.kind} "{self.name}"' if self.name else "at the top level"


def check(tree: ast.Module, text: str, file: str, dialect: int = 3) -> list[ScenicError]:
    """Every breach of the context rules in a parsed program, sorted by place; doubtful ones are of kind `warning`."""
    checker = _Checker(tree, Source(text, file), dialect)
    for specifier, message, hint in doubts(tree):
        checker.report(specifier, message, hint, kind="warning")
    pending: list[tuple[ast.AST, Context]] = [(tree, Context())]
    while pending:
        node, context = pending.pop()
        rule = RULES.get(type(node))
        if rule is not None:
            rule(checker, node, context)
        pending.extend(_children(node, context))
    return sorted(checker.errors, key=lambda error: error.place[1:] if error.place else ())


def _children(node: ast.AST, context: Context) -> Iterator[tuple[ast.AST, Context]]:
    """The nodes below a node, each with its context."""
    if isinstance(node, nodes.Behavior):
        context = Context(node.kind, node.name)
    elif isinstance(node, nodes.Scenario):
        for statement in node.compose:
            yield statement, Context("compose")
        context = Context()
        node = ast.Module([*node.setup, *map(ast.Expr, [*node.preconditions, *node.invariants])], [])
    elif isinstance(node, ast.FunctionDef):
        context = Context("function", node.name)
    elif isinstance(node, ast.Lambda):
        context = Context("function", "lambda")
    elif isinstance(node, ast.ClassDef):
        context = Context("top" if context.kind == "top" else context.kind, context.name)
    elif isinstance(node, ast.For | ast.While):
        yield from ((statement, context) for statement in node.orelse)
        context = context._replace(loop=True)
    elif isinstance(node, nodes.Interrupt):
        context = context._replace(handler=True)
    for name, value in ast.iter_fields(node):
        if name == "orelse" and isinstance(node, ast.For | ast.While):
            continue
        if isinstance(value, ast.AST):
            yield value, context
        elif isinstance(value, list):
            yield from ((each, context) for each in value if isinstance(each, ast.AST))


class _Checker:
    """Collects errors; the methods are the rules of `RULES`."""

    def __init__(self, tree: ast.Module, source: Source, dialect: int) -> None:
        self.source, self.dialect = source, dialect
        self.errors: list[ScenicError] = []
        self.monitors: set[str] = set()
        self.idle: dict[str, nodes.Behavior] = {}  # behaviors and monitors that never let time pass
        for node in ast.walk(tree):
            if isinstance(node, nodes.Behavior):
                if node.kind == "monitor":
                    self.monitors.add(node.name)
                if not suspends(node.body):
                    self.idle[node.name] = node

    def report(self, node: ast.AST, message: str, hint: str = "", kind: str = "syntax") -> None:
        """Add an error at the first line of a node."""
        line, column = node.lineno, node.col_offset  # type: ignore[attr-defined]
        end_line, end_column = node.end_lineno, node.end_col_offset  # type: ignore[attr-defined]
        if end_line != line:
            end_line, end_column = line, len(self.source.line(line).split("#")[0].rstrip())
        self.errors.append(self.source.error(message, (line, column, end_line, end_column), hint, kind))

    # ------------------------------------------------------------ what may stand where

    def take(self, node: nodes.Take, context: Context) -> None:
        if context.kind != "behavior":
            hint = 'a monitor may "wait"' if context.kind == "monitor" else ""
            self.report(node, f'"take" may only stand in a behavior, not {context.words()}', hint)

    def dynamic(self, node: ast.stmt, context: Context) -> None:
        """`wait`, `do`, `terminate`, `try` with `interrupt when`."""
        if context.kind in DYNAMIC:
            return
        word = {nodes.Wait: "wait", nodes.Do: "do", nodes.Terminate: "terminate"}.get(type(node), "interrupt when")
        allowed = "a behavior, a monitor or a compose block"
        hint = 'write "terminate when condition"' if word == "terminate" else ""
        self.report(node, f'"{word}" may only stand in {allowed}, not {context.words()}', hint)

    def do(self, node: nodes.Do, context: Context) -> None:
        self.dynamic(node, context)
        if len(node.calls) > 1 and node.how == "all" and context.kind in ("behavior", "monitor"):
            hint = "write one after another, or choose one"
            self.report(node, '"do" takes one behavior here; several at once only in a compose block', hint)

    def static(self, node: ast.stmt, context: Context) -> None:
        """Statements about the whole scene, and definitions."""
        if context.kind not in DYNAMIC:
            return
        word = STATIC_WORDS[type(node)]
        if isinstance(node, nodes.Behavior):
            word = f"a {node.kind}"
        hint = 'write "if condition:" and "terminate" in it' if isinstance(node, nodes.TerminateWhen) else ""
        self.report(node, f"{word} cannot stand {context.words()}", hint)

    def param(self, node: nodes.Param, context: Context) -> None:
        self.static(node, context)
        seen: set[str] = set()
        for name, place in zip(node.names, node.places, strict=True):
            if name in seen:
                self.report(place, f'the parameter "{name}" occurs twice in one statement')
            seen.add(name)

    def abort(self, node: nodes.Abort, context: Context) -> None:
        if not context.handler:
            self.report(node, '"abort" may only stand in the block of an "interrupt when"')

    def loop_exit(self, node: ast.Break | ast.Continue, context: Context) -> None:
        if not context.loop:
            word = "break" if isinstance(node, ast.Break) else "continue"
            self.report(node, f'"{word}" may only stand in a loop')

    def guard(self, node: ast.AnnAssign, context: Context) -> None:
        """`invariant: c` behind the first statement, where Python takes it for the type of a variable."""
        name = node.target.id if isinstance(node.target, ast.Name) else ""
        if context.kind in DYNAMIC and node.value is None and name in ("precondition", "invariant"):
            self.report(node, f'"{name}" may only stand before the first statement')

    def return_value(self, node: ast.Return, context: Context) -> None:
        if context.kind == "top":
            self.report(node, '"return" may only stand in a function or a behavior')

    # ------------------------------------------------------------ classes, behaviors, monitors

    def class_body(self, node: ast.ClassDef, context: Context) -> None:
        seen: set[str] = set()
        declared = BUILT_IN | {each.name for each in node.body if isinstance(each, nodes.PropertyDefault)}
        for statement in node.body:
            for target in statement.targets if isinstance(statement, ast.Assign) else ():
                if isinstance(target, ast.Name) and target.id in declared:
                    message = f'"{target.id}" is a property of objects, and this sets an attribute of the class'
                    kind = "syntax" if self.dialect == 3 else "warning"  # Scenic 2 lets it pass without effect
                    self.report(statement, message, f'write "{target.id}: value"', kind)
            if not isinstance(statement, nodes.PropertyDefault):
                continue
            if statement.name in seen:
                self.report(statement, f'the property "{statement.name}" occurs twice in the class "{node.name}"')
            seen.add(statement.name)

    def behavior(self, node: nodes.Behavior, context: Context) -> None:
        self.static(node, context)
        if node.started and node.name in self.idle:
            self.never(node, self.idle.pop(node.name))

    def scenario(self, node: nodes.Scenario, context: Context) -> None:
        self.static(node, context)
        if node.compose and not suspends(node.compose):
            hint = 'is a "do" or "wait" missing?'
            self.report(node, f'the compose block of the scenario "{node.name}" runs nothing', hint)

    def loop(self, node: ast.While, context: Context) -> None:
        if context.kind in DYNAMIC and endless_loop(node):
            wanted = '"wait"' if context.kind != "behavior" else '"take", "wait" or "do"'
            message = f"this loop never lets time pass: there is no {wanted} in it"
            if context.kind == "monitor":
                message = f'the monitor "{context.name}" never waits: there is no "wait" in this loop'
            self.report(node, message, f"indent the {wanted} as deep as the block of the loop")

    def call(self, node: ast.Call, context: Context) -> None:
        """A call of a behavior that does nothing."""
        if isinstance(node.func, ast.Name) and node.func.id in self.idle:
            self.never(node, self.idle.pop(node.func.id))

    def never(self, node: ast.AST, definition: nodes.Behavior) -> None:
        """Report a behavior that takes no action, or a monitor that never waits, where it is to be run."""
        monitor = definition.kind == "monitor"
        does = "waits" if monitor else "takes an action"
        message = f'the {definition.kind} "{definition.name}" of line {definition.lineno} never {does}'
        self.report(node, message, 'is a "wait" missing?' if monitor else 'is a "take", "wait" or "do" missing?')

    # ------------------------------------------------------------ requirements

    def require(self, node: nodes.Require, context: Context) -> None:
        condition = node.condition
        if isinstance(condition, ast.Call) and isinstance(condition.func, ast.Name):
            name = condition.func.id
            if name in self.monitors:
                self.report(condition, f'"{name}" is a monitor', f'write "require monitor {name}(...)"')
        if not any(isinstance(each, nodes.Operator) and each.name in TEMPORAL for each in ast.walk(condition)):
            return
        if node.probability is not None:
            self.report(condition, "a temporal requirement cannot have a probability")
        self.misplaced_temporal(condition)

    def misplaced_temporal(self, condition: ast.expr) -> None:
        """A temporal operator may be an operand of logic alone."""
        pending: list[tuple[ast.AST, bool]] = [(condition, True)]
        while pending:
            node, logical = pending.pop()
            logic = isinstance(node, ast.BoolOp)
            if isinstance(node, nodes.Operator) and node.name in TEMPORAL:
                logic = True
                if not logical:
                    hint = "only of and, or, not, implies, until"
                    self.report(node, f'"{node.name}" cannot be an operand here', hint)
            elif isinstance(node, ast.UnaryOp):
                logic = isinstance(node.op, ast.Not)
            pending.extend((child, logical and logic) for child in ast.iter_child_nodes(node))


STATIC_WORDS = {
    nodes.Param: '"param"',
    nodes.Mutate: '"mutate"',
    nodes.Model: '"model"',
    nodes.Simulator: '"simulator"',
    nodes.Record: '"record"',
    nodes.TerminateWhen: '"terminate when"',
    nodes.TerminateAfter: '"terminate after"',
    nodes.Behavior: "a behavior",
    nodes.Scenario: "a scenario",
}

RULES: dict[type[ast.AST], Callable[..., None]] = {
    nodes.Take: _Checker.take,
    nodes.Wait: _Checker.dynamic,
    nodes.Do: _Checker.do,
    nodes.Terminate: _Checker.dynamic,
    nodes.TryInterrupt: _Checker.dynamic,
    nodes.Abort: _Checker.abort,
    nodes.Param: _Checker.param,
    nodes.Mutate: _Checker.static,
    nodes.Model: _Checker.static,
    nodes.Simulator: _Checker.static,
    nodes.Record: _Checker.static,
    nodes.TerminateWhen: _Checker.static,
    nodes.TerminateAfter: _Checker.static,
    nodes.Behavior: _Checker.behavior,
    nodes.Scenario: _Checker.scenario,
    nodes.Require: _Checker.require,
    ast.ClassDef: _Checker.class_body,
    ast.While: _Checker.loop,
    ast.Call: _Checker.call,
    ast.Break: _Checker.loop_exit,
    ast.Continue: _Checker.loop_exit,
    ast.Return: _Checker.return_value,
    ast.AnnAssign: _Checker.guard,
}
