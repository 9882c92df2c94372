"""Execute the statements of Python, and those of Scenic that describe a scene.

Behaviors, monitors and conditions that end an episode stay trees, for the compiler. Read next: `evaluation.modules`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from scenic_lite.core.scope import Scope, name_draws
from scenic_lite.core.state import EpisodeStatement
from scenic_lite.core.types import (
    Behavior,
    BehaviorCall,
    Default,
    Instance,
    LazyValue,
    ScenicClass,
    describe_kind,
    near,
)
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import located, read, unpack, write
from scenic_lite.evaluation.builtins import text_of
from scenic_lite.evaluation.calls import Return, function_of, names_of, signature_of
from scenic_lite.evaluation.expressions import combine
from scenic_lite.language.classes import OBJECT
from scenic_lite.language.requirements import mutate, require
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import RandomExpr, Value, is_number


class Break(Exception):
    """Control flow: leave a loop."""


class Continue(Exception):
    """Control flow: end one iteration of a loop."""


def expression(scope: Scope, node: ast.Expr) -> None:
    value = scope.value(node.value)
    if isinstance(value, ScenicClass):
        scope.warn(f"class {value.name} alone makes no object", node, f"did you mean 'new {value.name}'?")


# ------------------------------------------------------------ assignment
def assign(scope: Scope, node: ast.Assign) -> None:
    value = scope.value(node.value)
    for target in node.targets:
        unpack(scope, target, value)


def augmented(scope: Scope, node: ast.AugAssign) -> None:
    """Execute `target += value`; a list stays the same object and accepts the elements of any collection."""
    owner, key = located(scope, node.target)
    old = read(scope, node.target, owner, key)
    more = scope.value(node.value)
    if isinstance(old, list) and isinstance(node.op, ast.Add) and not isinstance(more, list):
        more = scope.elements(more, node.op)
    new = combine(scope, node.op, old, more)
    if isinstance(old, list) and isinstance(new, list):
        old[:] = new
        new = old
    write(scope, node.target, owner, key, new)


# ------------------------------------------------------------ control flow
def branch(scope: Scope, node: ast.If) -> None:
    scope.run(node.body if scope.truth(node.test) else node.orelse)


def repeat(scope: Scope, node: ast.For | ast.While) -> None:
    def at_once(body: list[ast.stmt]) -> tuple[()]:
        scope.run(body)
        return ()

    for _ in loop(scope, node, at_once):
        pass


def loop(scope: Scope, node: ast.For | ast.While, run: Callable[[list[ast.stmt]], Iterable[Any]]) -> Iterator[Any]:
    """Run a loop; `run` executes a block and yields whenever time passes in it."""
    for _ in rounds(scope, node):
        try:
            yield from run(node.body)
        except Continue:
            continue
        except Break:
            return
    yield from run(node.orelse)


def rounds(scope: Scope, node: ast.For | ast.While) -> Iterator[None]:
    """Yield before each iteration, over the elements at the start of the loop; `while` and `range` may be endless."""
    budget = scope.mode.budget
    if isinstance(node, ast.While):
        while scope.truth(node.test):
            yield
            budget.round()
        return
    items = scope.value(node.iter)
    for element in scope.elements(items, node.iter):
        unpack(scope, node.target, element)
        yield
        if isinstance(items, range):
            budget.round()
        else:
            budget.step()


def break_loop(scope: Scope, node: ast.Break) -> None:
    raise Break


def continue_loop(scope: Scope, node: ast.Continue) -> None:
    raise Continue


def return_value(scope: Scope, node: ast.Return) -> None:
    raise Return(None if node.value is None else scope.value(node.value))


def nothing(scope: Scope, node: ast.AST) -> None:
    """Do nothing, for `pass` and for `simulator ...`, which refers to another simulator."""


def check_assertion(scope: Scope, node: ast.Assert) -> None:
    if not scope.truth(node.test):
        message = "" if node.msg is None else f": {text_of(scope, scope.value(node.msg))}"
        raise ScenicError("value", f"the assertion does not hold{message}")


# ------------------------------------------------------------ definitions
def define_function(scope: Scope, node: ast.FunctionDef) -> None:
    scope.assign(node.name, function_of(scope, node.name, node.args, node.body))


def define_class(scope: Scope, node: ast.ClassDef) -> None:
    """Define a class; methods see the names around the class, not the names in its body."""
    base = base_of(scope, node)
    cls = ScenicClass(node.name, base)
    body = scope.inner({})
    for statement in node.body:
        if isinstance(statement, nodes.PropertyDefault):
            if any("final" in default.attributes for default in base.defaults_of(statement.name)):
                raise scope.error("specifier", f"the property '{statement.name}' of {base.name} is final", node)
            cls.defaults[statement.name] = default_of(scope, statement)
        elif isinstance(statement, ast.FunctionDef):
            if statement.name == "__init__":
                hint = "write `name: default` for each property"
                raise scope.error("unsupported", "objects are made by specifiers, not by __init__", statement, hint)
            body.locals[statement.name] = function_of(body, statement.name, statement.args, statement.body, True)
        elif isinstance(statement, ast.Assign | ast.Pass | ast.Expr):
            body.run([statement])
        else:
            raise scope.error("unsupported", "only properties, methods and attributes belong into a class", statement)
    cls.members.update(body.locals)
    scope.assign(node.name, cls)


def base_of(scope: Scope, node: ast.ClassDef) -> ScenicClass:
    if node.keywords:
        raise scope.error("unsupported", "a class has a base and no other arguments", node.keywords[0].value)
    if not node.bases:
        return OBJECT
    if len(node.bases) > 1:
        raise scope.error("unsupported", "a class has one base", node.bases[1])
    base = scope.value(node.bases[0])
    if not isinstance(base, ScenicClass):
        raise scope.error("type", f"{describe_kind(base)} cannot be the base of a class", node.bases[0])
    return base


def default_of(scope: Scope, node: nodes.PropertyDefault) -> Default:
    """Return the default of a property; its expression may read `self` and is evaluated for each new instance."""
    parts = list(ast.walk(node.value))
    reads = {id(part.value): part.attr for part in parts if isinstance(part, ast.Attribute)}
    selves = [part for part in parts if isinstance(part, ast.Name) and part.id == "self"]
    for part in selves:
        if id(part) not in reads:
            raise scope.error("syntax", "a default reads `self.property`, never the bare `self`", part)

    def compute(maker: Scope, self: Instance, name: str) -> Value:
        value = Scope.inside(maker.owning(self, name).mode, scope, {"self": self}).value(node.value)
        return value.compute(self) if isinstance(value, LazyValue) else value

    return Default(compute, frozenset(reads[id(part)] for part in selves), tuple(node.attributes))


def define_behavior(scope: Scope, node: nodes.Behavior) -> None:
    behavior = Behavior(node.name, signature_of(scope, node.args), scope, names_of(tuple(node.body)), node)
    scope.assign(node.name, behavior)
    scope.state.behaviors[node.name] = behavior
    if node.started:  # in Scenic 2, the definition of a monitor also starts it
        scope.state.monitors.append(BehaviorCall(behavior, {}, scope.place(node)))


def define_scenario(scope: Scope, node: nodes.Scenario) -> None:
    own = names_of((*node.setup, *node.compose))
    scenario = Behavior(node.name, signature_of(scope, node.args), scope, own, node)
    scope.assign(node.name, scenario)
    scope.state.scenarios.append(scenario)


# ------------------------------------------------------------ the scenario
def set_params(scope: Scope, node: nodes.Param) -> None:
    """Set params: later params replace earlier ones, but params of a library never replace those of the program."""
    state = scope.state
    for name, expression, place in zip(node.names, node.values, node.places, strict=True):
        value = scope.value(expression)
        name_draws(name, value)
        if name in state.fixed_params:
            state.param_places[name] = scope.place(place)
            continue
        if scope.source.library or scope.mode.in_model:
            if name in state.params and name not in state.library_params:
                continue
            state.library_params.add(name)
        else:
            state.library_params.discard(name)
            warn_of_param(scope, name, place)
        state.params[name], state.param_places[name] = value, scope.place(place)


def warn_of_param(scope: Scope, name: str, node: ast.expr) -> None:
    """Warn about a parameter that is never read but whose name resembles a parameter of the world."""
    known = scope.state.domain.params if scope.state.domain else frozenset()
    hint = "" if name in known else near(name, known)
    if hint:
        scope.warn(f"nothing reads the parameter '{name}'", node, hint)


def require_monitor(scope: Scope, node: nodes.RequireMonitor) -> None:
    value = scope.value(node.call)
    if not isinstance(value, BehaviorCall) or value.behavior.kind != "monitor":
        hint = f"write {value.name}()" if isinstance(value, Behavior) and value.kind == "monitor" else ""
        if isinstance(value, BehaviorCall):
            hint = f"{value.behavior.name} is a {value.behavior.kind}; a monitor is written monitor Name():"
        raise scope.error("type", f"`require monitor` needs a monitor, not {describe_kind(value)}", node.call, hint)
    scope.state.monitors.append(value)


def keep_termination(scope: Scope, node: nodes.TerminateWhen | nodes.TerminateAfter) -> None:
    """Store a termination condition for the episode; a duration is evaluated immediately."""
    duration, name = None, node.name if isinstance(node, nodes.TerminateWhen) else None
    if isinstance(node, nodes.TerminateAfter):
        duration = scope.value(node.duration)
        if not is_number(duration) and not isinstance(duration, RandomExpr):
            message = f"a duration is a number, not {describe_kind(duration)}"
            raise scope.error("type", message, node.duration)
    label = name or f"termination condition on line {node.lineno}"
    scope.state.terminations.append(EpisodeStatement(node, scope.place(node), scope, label, duration=duration))


def keep_record(scope: Scope, node: nodes.Record) -> None:
    """Store a `record` statement for the episode."""
    scope.state.records.append(EpisodeStatement(node, scope.place(node), scope, node.name or f"record{node.lineno}"))


STATEMENTS: dict[type, Callable[[Scope, Any], Any]] = {
    ast.Assign: assign,
    ast.AugAssign: augmented,
    ast.Assert: check_assertion,
    ast.Expr: expression,
    ast.If: branch,
    ast.For: repeat,
    ast.While: repeat,
    ast.Break: break_loop,
    ast.Continue: continue_loop,
    ast.Return: return_value,
    ast.Pass: nothing,
    ast.FunctionDef: define_function,
    ast.ClassDef: define_class,
    nodes.Behavior: define_behavior,
    nodes.Param: set_params,
    nodes.Require: require,
    nodes.RequireMonitor: require_monitor,
    nodes.Simulator: nothing,
    nodes.TerminateWhen: keep_termination,
    nodes.TerminateAfter: keep_termination,
    nodes.Mutate: mutate,
    nodes.Record: keep_record,
    nodes.Scenario: define_scenario,
}
