"""Execute statements: Python's, and those of Scenic that shape a scene.

Behaviors, monitors and conditions that end an episode are kept as trees for whoever runs them. Read next: `modules`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite import nodes
from scenic_lite.calls import Return, defaults_of, function_of
from scenic_lite.classes import OBJECT, is_object
from scenic_lite.errors import ScenicError
from scenic_lite.expressions import combined
from scenic_lite.frame import Frame, Termination, name_draws, near
from scenic_lite.graph import Random, Value
from scenic_lite.regions import Region
from scenic_lite.requirements import mutate, require
from scenic_lite.values import Behavior, BehaviorCall, Default, Delayed, Instance, ScenicClass, describe_kind


class Break(Exception):
    """Leaves a loop."""


class Continue(Exception):
    """Ends one round of a loop."""


def expression(frame: Frame, node: ast.Expr) -> None:
    value = frame.value(node.value)
    if isinstance(value, ScenicClass):
        frame.warn(f"class {value.name} alone makes no object", node, f"did you mean 'new {value.name}'?")


def assign(frame: Frame, node: ast.Assign) -> None:
    value = frame.value(node.value)
    for target in node.targets:
        bind_target(frame, target, value)


def annotated(frame: Frame, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind_target(frame, node.target, frame.value(node.value))


def augmented(frame: Frame, node: ast.AugAssign) -> None:
    target = node.target
    if isinstance(target, ast.Name):
        old = frame.lookup(target.id)
    elif isinstance(target, ast.Subscript):
        old = frame.value(ast.copy_location(ast.Subscript(target.value, target.slice, ast.Load()), target))
    else:
        raise ScenicError("unsupported", "properties cannot be assigned here", hint="use a `with` specifier")
    bind_target(frame, target, combined(frame, node.op, old, frame.value(node.value)))


def bind_target(frame: Frame, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, or an element of a list or dictionary."""
    if isinstance(target, ast.Name):
        if target.id in TRACKED:
            TRACKED[target.id](frame, target, value)
        frame.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        unpack(frame, target, value)
    elif isinstance(target, ast.Subscript):
        container, index = frame.value(target.value), frame.value(target.slice)
        if not isinstance(container, list | dict) or isinstance(index, Random | slice):
            raise frame.error("type", f"elements of {describe_kind(container)} cannot be assigned here", target)
        frame.session.budget.whole(index)
        container[index] = value
    else:
        message = "properties cannot be assigned outside behaviors"
        raise frame.error("unsupported", message, target, "use a `with` specifier")


def unpack(frame: Frame, target: ast.expr, value: Value) -> None:
    """`a, b = value`, or a plain name."""
    if not isinstance(target, ast.Tuple | ast.List):
        bind_target(frame, target, value)
        return
    items = frame.elements(value, target)
    stars = [i for i, each in enumerate(target.elts) if isinstance(each, ast.Starred)]
    if stars:
        after = len(target.elts) - stars[0] - 1
        if len(items) < len(target.elts) - 1:
            raise frame.error("value", f"{len(items)} values for at least {len(target.elts) - 1} names", target)
        middle = items[stars[0] : len(items) - after]
        items = [*items[: stars[0]], middle, *items[len(items) - after :]]
    if len(items) != len(target.elts):
        raise frame.error("value", f"{len(items)} values for {len(target.elts)} names", target)
    for each, item in zip(target.elts, items, strict=True):
        bind_target(frame, each.value if isinstance(each, ast.Starred) else each, item)


def set_ego(frame: Frame, node: ast.AST, value: Value) -> None:
    if not is_object(value):
        raise frame.error("type", f"ego must be an object, not {describe_kind(value)}", node)
    frame.session.ego = value


def set_workspace(frame: Frame, node: ast.AST, value: Value) -> None:
    if not isinstance(value, Region):
        hint = "write workspace = Workspace(region)"
        raise frame.error("type", f"the workspace must be a region, not {describe_kind(value)}", node, hint)
    frame.session.workspace = value


TRACKED: dict[str, Callable[[Frame, ast.AST, Value], None]] = {"ego": set_ego, "workspace": set_workspace}

# ------------------------------------------------------------ control flow


def branch(frame: Frame, node: ast.If) -> None:
    frame.run(node.body if frame.truth(node.test) else node.orelse)


def repeat(frame: Frame, node: ast.For) -> None:
    for element in frame.elements(frame.value(node.iter), node.iter):
        unpack(frame, node.target, element)
        frame.session.budget.step()
        if not one_round(frame, node.body):
            return
    frame.run(node.orelse)


def repeat_while(frame: Frame, node: ast.While) -> None:
    while frame.truth(node.test):
        if not one_round(frame, node.body):
            return
    frame.run(node.orelse)


def one_round(frame: Frame, body: list[ast.stmt]) -> bool:
    """Run the body of a loop; whether the loop goes on."""
    try:
        frame.run(body)
    except Continue:
        return True
    except Break:
        return False
    return True


def leave_loop(frame: Frame, node: ast.Break) -> None:
    raise Break


def next_round(frame: Frame, node: ast.Continue) -> None:
    raise Continue


def give_back(frame: Frame, node: ast.Return) -> None:
    raise Return(None if node.value is None else frame.value(node.value))


def nothing(frame: Frame, node: ast.AST) -> None:
    """`pass`; and `simulator ...`, which names a program of another installation."""


def certify(frame: Frame, node: ast.Assert) -> None:
    if not frame.truth(node.test):
        message = "" if node.msg is None else f": {frame.text_of(frame.value(node.msg), '')}"
        raise ScenicError("value", f"the assertion does not hold{message}")


def declare_global(frame: Frame, node: ast.Global) -> None:
    frame.globals.update(node.names)


# ------------------------------------------------------------ definitions


def define_function(frame: Frame, node: ast.FunctionDef) -> None:
    if node.decorator_list:
        raise ScenicError("unsupported", "decorators are not supported")
    frame.assign(node.name, function_of(frame, node.name, node.args, node.body))


def define_class(frame: Frame, node: ast.ClassDef) -> None:
    """A class of the language; methods see the names around the class, not those inside."""
    cls = ScenicClass(node.name, base_of(frame, node))
    body = frame.inner({})
    for statement in node.body:
        if isinstance(statement, nodes.PropertyDefault):
            if statement.name in cls.defaults:
                raise frame.error("syntax", f"the property '{statement.name}' is declared twice", statement)
            if any("final" in default.attributes for default in cls.base.defaults_of(statement.name)):
                raise frame.error("specifier", f"the property '{statement.name}' of {cls.base.name} is final", node)
            cls.defaults[statement.name] = default_of(frame, statement)
        elif isinstance(statement, ast.FunctionDef):
            cls.members[statement.name] = function_of(frame, statement.name, statement.args, statement.body)
        elif isinstance(statement, ast.Assign | ast.Pass | ast.Expr | ast.AnnAssign):
            body.run([statement])
        else:
            raise frame.error("unsupported", "only properties, methods and attributes belong into a class", statement)
    cls.members.update(body.locals)
    frame.assign(node.name, cls)


def base_of(frame: Frame, node: ast.ClassDef) -> ScenicClass:
    if node.keywords:
        raise frame.error("unsupported", "a class has a base and no other arguments", node.keywords[0].value)
    if not node.bases:
        return OBJECT
    if len(node.bases) > 1:
        raise frame.error("unsupported", "a class has one base", node.bases[1])
    base = frame.value(node.bases[0])
    if not isinstance(base, ScenicClass):
        raise frame.error("type", f"{describe_kind(base)} cannot be the base of a class", node.bases[0])
    return base


def default_of(frame: Frame, node: nodes.PropertyDefault) -> Default:
    """A default expression, evaluated for each instance anew, with `self` in sight."""
    reads = {
        each.attr
        for each in ast.walk(node.value)
        if isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and each.value.id == "self"
    }

    owners = {id(each.value) for each in ast.walk(node.value) if isinstance(each, ast.Attribute)}
    for each in ast.walk(node.value):
        if isinstance(each, ast.Name) and each.id == "self" and id(each) not in owners:
            raise frame.error("syntax", "a default reads `self.property`, never the bare `self`", each)

    def compute(self: Instance) -> Value:
        value = frame.inner({"self": self}).value(node.value)
        return value.compute(self) if isinstance(value, Delayed) else value

    return Default(compute, frozenset(reads), tuple(node.attributes))


def define_behavior(frame: Frame, node: nodes.Behavior) -> None:
    defaults, keyword_defaults = defaults_of(frame, node.args)
    behavior = Behavior(node.name, node, defaults, keyword_defaults, frame)
    frame.assign(node.name, behavior)
    frame.session.behaviors[node.name] = behavior
    if node.kind == "monitor" and frame.session.dialect == 2:  # there it starts by being defined
        frame.session.monitors.append(BehaviorCall(behavior, {}, frame.place(node)))


# ------------------------------------------------------------ the scenario


def set_params(frame: Frame, node: nodes.Param) -> None:
    """Later params win, except that a library's never replace the program's own."""
    session = frame.session
    for name, expression, place in zip(node.names, node.values, node.places, strict=True):
        value = frame.value(expression)
        name_draws(name, value)
        if frame.source.library:
            if name in session.params and name not in session.library_params:
                continue
            session.library_params.add(name)
        else:
            session.library_params.discard(name)
            doubt_param(frame, name, place)
        session.params[name], session.param_places[name] = value, frame.place(place)


def doubt_param(frame: Frame, name: str, node: ast.expr) -> None:
    """Warn of a param that nothing reads and that is almost spelt like one that the world does."""
    known = frame.session.domain.params if frame.session.domain else frozenset()
    hint = "" if name in known else near(name, known)
    if hint:
        frame.warn(f"nothing reads the parameter '{name}'", node, hint)


def require_monitor(frame: Frame, node: nodes.RequireMonitor) -> None:
    value = frame.value(node.call)
    if not isinstance(value, BehaviorCall) or value.behavior.kind != "monitor":
        raise frame.error("type", f"`require monitor` needs a monitor, not {describe_kind(value)}", node.call)
    frame.session.monitors.append(value)


def keep_termination(frame: Frame, node: nodes.TerminateWhen | nodes.TerminateAfter) -> None:
    frame.session.terminations.append(Termination(node, frame.place(node)))


def not_yet(frame: Frame, node: ast.AST) -> None:
    words = {nodes.Record: "`record`", nodes.Scenario: "a modular `scenario`"}
    raise ScenicError("unsupported", f"{words[type(node)]} is not yet supported")


def only_in_behavior(frame: Frame, node: ast.AST) -> None:
    word = type(node).__name__.lower()
    raise ScenicError("syntax", f"`{word}` belongs into a behavior")


STATEMENTS: dict[type, Callable[[Frame, Any], Any]] = {
    ast.Expr: expression,
    ast.Assign: assign,
    ast.AnnAssign: annotated,
    ast.AugAssign: augmented,
    ast.If: branch,
    ast.For: repeat,
    ast.While: repeat_while,
    ast.Break: leave_loop,
    ast.Continue: next_round,
    ast.Return: give_back,
    ast.Pass: nothing,
    ast.Assert: certify,
    ast.Global: declare_global,
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
    nodes.Record: not_yet,
    nodes.Scenario: not_yet,
    nodes.Take: only_in_behavior,
    nodes.Wait: only_in_behavior,
    nodes.Do: only_in_behavior,
    nodes.Abort: only_in_behavior,
    nodes.Terminate: only_in_behavior,
    nodes.Override: only_in_behavior,
}
