"""Rules of the language that need the whole tree: allowed places, unique names, loops in which no time passes.

The check returns all errors together, sorted by place. A probable mistake is a warning. Undefined names and properties
are not found, since they depend on the imported library. Read next: `loader`, which runs the static part.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes
from scenic_lite.syntax.lexer import Source

DYNAMIC = ("behavior", "monitor", "compose")
BUILT_IN = frozenset(
    {
        *("position", "heading", "yaw", "width", "length", "speed", "velocity", "angularSpeed", "behavior"),
        *("viewAngle", "visibleDistance", "cameraOffset", "allowCollisions", "requireVisible", "regionContainedIn"),
        *("mutator", "mutationScale", "positionStdDev", "headingStdDev"),
    }
)
ANGLES = frozenset({"facing", "apparently facing", "heading", "yaw", "viewAngle"})


class Context(NamedTuple):
    """The context of a statement."""

    kind: str = "top"  # top, function, behavior, monitor, compose
    name: str = ""  # name of the function, behavior or monitor
    loop: bool = False
    handler: bool = False  # whether the statement is in the block of an `interrupt when`

    def words(self) -> str:
        """Describe the context, for messages."""
        if self.kind == "compose":
            return "in a compose block"
        return f'in the {self.kind} "{self.name}"' if self.name else "at the top level"


def check(tree: ast.Module, text: str, file: str, dialect: int = 3) -> list[ScenicError]:
    """Return all violations of the rules in a program, sorted by place; probable mistakes have kind `warning`."""
    checker = _Checker(tree, Source(text, file), dialect)
    pending: list[tuple[ast.AST, Context]] = [(tree, Context())]
    while pending:
        node, context = pending.pop()
        if type(node) in PLACES:
            checker.place(node, context)
        if type(node) in RULES:
            RULES[type(node)](checker, node, context)
        pending.extend(_children(node, context))
    checker.whole()
    return sorted(checker.errors, key=lambda error: error.place[1:] if error.place else ())


def _children(node: ast.AST, context: Context) -> Iterator[tuple[ast.AST, Context]]:
    """Yield the children of a node, each with its context."""
    if isinstance(node, nodes.Behavior):
        context = Context(node.kind, node.name)
    elif isinstance(node, nodes.Scenario):
        yield from ((statement, Context("compose")) for statement in node.compose)
        context = Context()
        node = ast.Module([*node.setup, *map(ast.Expr, [*node.preconditions, *node.invariants])], [])
    elif isinstance(node, ast.FunctionDef | ast.Lambda):
        context = Context("function", node.name if isinstance(node, ast.FunctionDef) else "lambda")
    elif isinstance(node, ast.ClassDef):
        context = Context(context.kind, context.name)
    elif isinstance(node, nodes.Interrupt):
        context = context._replace(handler=True)
    outer, after = context, set()
    if isinstance(node, ast.For | ast.While):
        context, after = context._replace(loop=True), set(map(id, node.orelse))
    yield from ((child, outer if id(child) in after else context) for child in ast.iter_child_nodes(node))


class _Checker:
    """The errors found so far, and the rules of `RULES` as methods."""

    def __init__(self, tree: ast.Module, source: Source, dialect: int) -> None:
        self.source, self.dialect = source, dialect
        self.errors: list[ScenicError] = []
        self.monitors: dict[str, nodes.Behavior] = {}
        self.idle: dict[str, nodes.Behavior] = {}  # behaviors and monitors in which no time passes
        self.names: set[str] = set()  # names that the program reads or sets
        self.forms: dict[int, ast.AST] = {}  # dialect -> the first form that exists in this dialect only
        self.classes: set[str] = set()  # names that certainly denote classes
        for node in ast.walk(tree):
            if isinstance(node, ast.Name):
                self.names.add(node.id)
            elif isinstance(node, ast.ClassDef):
                self.classes.add(node.name)
            elif isinstance(node, nodes.New) and has_new(node) and isinstance(node.cls, ast.Name):
                self.classes.add(node.cls.id)
            elif isinstance(node, nodes.Behavior):
                if node.kind == "monitor":
                    self.monitors[node.name] = node
                if not nodes.suspends(*node.body):
                    self.idle[node.name] = node

    def report(self, node: ast.AST, message: str, hint: str = "", kind: str = "syntax") -> None:
        """Add an error at the first line of a node."""
        line, column = node.lineno, node.col_offset  # type: ignore[attr-defined]
        end_line, end_column = node.end_lineno, node.end_col_offset  # type: ignore[attr-defined]
        if end_line != line:
            end_line, end_column = line, len(self.source.line(line).split("#")[0].rstrip())
        self.errors.append(self.source.error(message, (line, column, end_line, end_column), hint, kind))

    def warn(self, node: ast.AST, message: str, hint: str = "") -> None:
        """Add a warning."""
        self.report(node, message, hint, "warning")

    def place(self, node: ast.AST, context: Context) -> None:
        """Check the context of a statement."""
        allowed, message = PLACES[type(node)]
        if allowed(context):
            return
        word = {nodes.TryInterrupt: "interrupt when", nodes.Scenario: "a scenario"}.get(type(node))
        if isinstance(node, nodes.Behavior):
            word = f"a {node.kind}"
        word = word or re.sub("(?!^)([A-Z])", r" \1", type(node).__name__).lower()
        hint = HINTS.get((type(node), context.kind)) or HINTS.get((type(node), ""), "")
        self.report(node, message.format(word if word[:2] == "a " else f'"{word}"', context.words()), hint)

    def do(self, node: nodes.Do, context: Context) -> None:
        if len(node.calls) > 1 and node.how == "all" and context.kind in ("behavior", "monitor"):
            hint = "write one after another, or choose one"
            self.report(node, '"do" takes one behavior here; several at once only in a compose block', hint)

    def once(self, things: Iterable[tuple[str, ast.AST]], message: str) -> None:
        """Report duplicate names."""
        seen: set[str] = set()
        for name, place in things:
            if name in seen:
                self.report(place, message.format(name))
            seen.add(name)

    def param(self, node: nodes.Param, context: Context) -> None:
        self.once(zip(node.names, node.places, strict=True), 'the parameter "{}" occurs twice in one statement')

    def class_body(self, node: ast.ClassDef, context: Context) -> None:
        named = [(part.name, part) for part in node.body if isinstance(part, nodes.PropertyDefault)]
        self.once(named, f'the property "{{}}" occurs twice in the class "{node.name}"')
        declared = BUILT_IN | {name for name, _ in named}
        for statement in node.body:
            for target in statement.targets if isinstance(statement, ast.Assign) else ():
                if isinstance(target, ast.Name) and target.id in declared:
                    message = f'"{target.id}" is a property of objects, and this sets an attribute of the class'
                    kind = "syntax" if self.dialect == 3 else "warning"  # Scenic 2 accepts it without effect
                    self.report(statement, message, f'write "{target.id}: value"', kind)

    def behavior(self, node: nodes.Behavior, context: Context) -> None:
        if node.started:
            self.forms.setdefault(2, node)
            self.never(node, node.name)

    def scenario(self, node: nodes.Scenario, context: Context) -> None:
        if node.compose and not nodes.suspends(*node.compose):
            hint = 'is a "do" or "wait" missing?'
            self.report(node, f'the compose block of the scenario "{node.name}" runs nothing', hint)

    def loop(self, node: ast.While, context: Context) -> None:
        if context.kind in DYNAMIC and endless_loop(node):
            statements = '"wait"' if context.kind != "behavior" else '"take", "wait" or "do"'
            message = f"this loop never lets time pass: there is no {statements} in it"
            if context.kind == "monitor":
                message = f'the monitor "{context.name}" never waits: there is no "wait" in this loop'
            self.report(node, message, f"indent the {statements} as deep as the block of the loop")

    def call(self, node: ast.Call, context: Context) -> None:
        if isinstance(node.func, ast.Name):
            self.never(node, node.func.id)

    def never(self, node: ast.AST, name: str) -> None:
        """Report the start of a behavior that never takes an action, or of a monitor that never waits."""
        definition = self.idle.pop(name, None)
        if definition is not None:
            does, hint = "takes an action", 'is a "take", "wait" or "do" missing?'
            if definition.kind == "monitor":
                does, hint = "waits", 'is a "wait" missing?'
            calls = (part.func for part in ast.walk(definition) if isinstance(part, ast.Call))
            called = [part.id for part in calls if isinstance(part, ast.Name) and part.id in ("wait", "terminate")]
            hint = f'write "{called[0]}" without brackets' if called else hint
            self.report(node, f'the {definition.kind} "{name}" of line {definition.lineno} never {does}', hint)

    def require(self, node: nodes.Require, context: Context) -> None:
        condition = node.condition
        if isinstance(condition, ast.Call) and isinstance(condition.func, ast.Name):
            name = condition.func.id
            if name in self.monitors:
                self.report(condition, f'"{name}" is a monitor', f'write "require monitor {name}(...)"')
        if node.probability is not None and nodes.is_temporal(condition):
            self.report(condition, "a temporal requirement cannot have a probability")
        pending: list[tuple[ast.AST, bool]] = [(condition, True)]  # whether only logical operators surround it
        while pending:
            part, logical = pending.pop()
            logic = isinstance(part, ast.BoolOp) or (isinstance(part, ast.UnaryOp) and isinstance(part.op, ast.Not))
            if isinstance(part, nodes.Operator) and part.name in nodes.TEMPORAL:
                logic = True
                if not logical:
                    hint = "only of and, or, not, implies, until"
                    self.report(part, f'"{part.name}" cannot be an operand here', hint)
            pending.extend((child, logical and logic) for child in ast.iter_child_nodes(part))

    def specifier(self, node: nodes.Specifier, context: Context) -> None:
        """Warn about an angle that seems to be in degrees without `deg`."""
        name, value = node.name, node.arguments[-1] if node.arguments else None
        if name == "with" and isinstance(node.arguments[0], ast.Constant):
            name = str(node.arguments[0].value)
        if name in ANGLES and (turns := _turns(value)):
            message = f"angles are in radians, and this one makes {turns:.0f} turns"
            self.warn(node, message, 'degrees are written "90 deg"')

    def instance(self, node: nodes.New, context: Context) -> None:
        """Record the dialect of an instance, which has `new` before its class in dialect 3 only."""
        if has_new(node):
            self.forms.setdefault(3, node)
        elif node.certain or (isinstance(node.cls, ast.Name) and node.cls.id in self.classes):
            self.forms.setdefault(2, node)

    def whole(self) -> None:
        """Warn about a program that mixes dialects, and about monitors that are never started."""
        if len(self.forms) == 2:
            node, other = self.forms[5 - self.dialect], 5 - self.dialect
            hint = 'write "monitor M():" and "require monitor M()"'
            if isinstance(node, nodes.New):
                hint = 'write "new" before the class' if other == 2 else 'leave out the "new"'
            message = f"this is written as in Scenic {other}, and the program is read as Scenic {self.dialect}"
            self.warn(node, message, hint)
        for name, monitor in self.monitors.items():
            if not monitor.started and name not in self.names and "ego" in self.names:  # without an ego it is a library
                self.warn(monitor, f'the monitor "{name}" is never required', f'write "require monitor {name}()"')


def _turns(value: ast.expr | None) -> float:
    """Return the number of turns of a literal angle above two turns, which is hardly intended; otherwise 0."""
    if isinstance(value, ast.UnaryOp):
        value = value.operand
    if isinstance(value, ast.Constant) and isinstance(value.value, int | float) and value.value > 4 * math.pi:
        return value.value / (2 * math.pi)
    return 0.0


def has_new(node: nodes.New) -> bool:
    """Return whether the instance has `new` before its class."""
    return (node.lineno, node.col_offset) != (node.cls.lineno, node.cls.col_offset)


def endless_loop(loop: ast.While) -> bool:
    """Return whether a `while True` in a behavior neither lets time pass nor ends, so that the step never ends.

    A loop with an action, a wait, a `do`, a `break` or a `return` on some path is accepted. A `terminate` does not
    count, since its condition should usually be tested once per step.
    """
    leaves = (nodes.Take, nodes.Wait, nodes.Do, ast.Break, ast.Return)
    for_ever = isinstance(loop.test, ast.Constant) and bool(loop.test.value)
    return for_ever and not any(isinstance(node, leaves) for node in nodes.walk_own(*loop.body))


RUNNING = "{} may only stand in a behavior, a monitor or a compose block, not {}"
# Allowed contexts of statements, and the message in other contexts, with slots for the statement and the context.
PLACES: dict[type[ast.AST], tuple[Callable[[Context], bool], str]] = {
    **dict.fromkeys(
        (nodes.Wait, nodes.Do, nodes.Terminate, nodes.TryInterrupt), (lambda at: at.kind in DYNAMIC, RUNNING)
    ),
    **dict.fromkeys(
        (
            *(nodes.Param, nodes.Mutate, nodes.Model, nodes.Simulator, nodes.Record, nodes.TerminateWhen),
            *(nodes.TerminateAfter, nodes.Behavior, nodes.Scenario),
        ),
        (lambda at: at.kind not in DYNAMIC, "{} cannot stand {}"),
    ),
    **dict.fromkeys((ast.Break, ast.Continue), (lambda at: at.loop, "{} may only stand in a loop")),
    nodes.Take: (lambda at: at.kind == "behavior", "{} may only stand in a behavior, not {}"),
    nodes.Abort: (lambda at: at.handler, '{} may only stand in the block of an "interrupt when"'),
    ast.Return: (lambda at: at.kind != "top", "{} may only stand in a function or a behavior"),
}
HINTS = {  # by statement and kind of context; "" is any context
    (nodes.Take, "monitor"): 'a monitor may "wait"',
    (nodes.Terminate, ""): 'write "terminate when condition"',
    (nodes.TerminateWhen, ""): 'write "if condition:" and "terminate" in it',
}
RULES: dict[type[ast.AST], Callable[..., None]] = {
    nodes.Do: _Checker.do,
    nodes.Param: _Checker.param,
    nodes.Behavior: _Checker.behavior,
    nodes.Scenario: _Checker.scenario,
    nodes.Require: _Checker.require,
    nodes.Specifier: _Checker.specifier,
    nodes.New: _Checker.instance,
    ast.ClassDef: _Checker.class_body,
    ast.While: _Checker.loop,
    ast.Call: _Checker.call,
}
