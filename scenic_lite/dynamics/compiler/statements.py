"""Python's statements: branches, loops, assignments, `return`.

What is fixed is decided now: a branch on `self.team == "right"` leaves one side, a loop over a fixed list is unrolled.
What the match decides becomes jumps. Read next: `dynamics.compiler.behaviors`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

from scenic_lite.core.exceptions import ExceptionClass, Fault, raised
from scenic_lite.core.types import BehaviorCall, RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.attributes import set_attribute
from scenic_lite.dynamics.compiler.cases import SUBJECT, branches_of
from scenic_lite.dynamics.compiler.changing import mutated
from scenic_lite.dynamics.compiler.choices import combination
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import (
    Compilation,
    CompiledScope,
    Loop,
    Snapshot,
    assigned_names,
    suspends,
)
from scenic_lite.dynamics.compiler.conditions import jump_on, live_branch
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.lists import LiveRange, among_objects, changed_item, element_at, elements
from scenic_lite.dynamics.compiler.registers import Slot, copied, kept, settled
from scenic_lite.dynamics.compiler.types import RegisterList, varies
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.assignments import TRACKED
from scenic_lite.evaluation.calls import Return
from scenic_lite.evaluation.expressions import item_of
from scenic_lite.evaluation.matching import chosen_case
from scenic_lite.evaluation.statements import define_function, nothing
from scenic_lite.syntax.nodes import walk_own
from scenic_lite.values.graph import RandomExpr, Value

MOST_UNROLLED = 64  # rounds of a loop over a fixed list


def expression(c: Compilation, scope: CompiledScope, node: ast.Expr) -> None:
    value = scope.value(node.value)
    settled(c.code, value)
    if isinstance(value, BehaviorCall):
        name = value.behavior.name
        message = f'the behavior "{name}" is named here, but not run'
        c.doubts.append(scope.error("warning", message, node, f"write do {name}(...)"))


def assign(c: Compilation, scope: CompiledScope, node: ast.Assign) -> None:
    value = scope.value(node.value)
    for target in node.targets:
        bind(c, scope, target, value)


def annotated(c: Compilation, scope: CompiledScope, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind(c, scope, node.target, scope.value(node.value))


def augmented(c: Compilation, scope: CompiledScope, node: ast.AugAssign) -> None:
    target = node.target
    old = scope.lookup(target.id) if isinstance(target, ast.Name) else scope.value(loading(target))
    bind(c, scope, target, combination(c, scope, node, old, scope.value(node.value)))


def loading(target: ast.expr) -> ast.expr:
    """The expression that reads what an assignment writes."""
    if isinstance(target, ast.Subscript):
        return ast.copy_location(ast.Subscript(target.value, target.slice, ast.Load()), target)
    assert isinstance(target, ast.Attribute)
    return ast.copy_location(ast.Attribute(target.value, target.attr, ast.Load()), target)


def bind(c: Compilation, scope: CompiledScope, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, an element or an attribute."""
    if isinstance(target, ast.Name):
        track(c, scope, target, value)
        scope.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        parts = elements(c, scope, value, target)
        parts = spread(scope, target, parts)
        parts = [copied(c.code, each) for each in parts]  # `a, b = b, a`
        for each, part in zip(target.elts, parts, strict=True):
            bind(c, scope, each.value if isinstance(each, ast.Starred) else each, part)
    elif isinstance(target, ast.Attribute):
        set_attribute(c, scope, target, scope.value(target.value), value)
    elif isinstance(target, ast.Subscript):
        container, index = scope.value(target.value), scope.value(target.slice)
        bind_item(c, scope, target, changed_item(c, scope, container, index, value))
    else:
        raise scope.error("syntax", "this cannot be assigned to", target)


def track(c: Compilation, scope: CompiledScope, target: ast.Name, value: Value) -> None:
    """`ego = ...` in the setup of a scenario that a match starts: it lasts as long as that."""
    if target.id not in TRACKED:
        return
    if not c.setting_up or scope.inlined.live or scope.inlined.behavior is not c.part_behavior:
        hint = "only the setup of a scenario may, and not in a branch"
        raise ScenicError("unsupported", f"no match can change {target.id} here", hint=hint)
    TRACKED[target.id](scope, target, value)


def spread(scope: CompiledScope, target: ast.Tuple | ast.List, parts: list[Value]) -> list[Value]:
    """One value for each of several names; what stands behind a star takes those that are left."""
    count = len(target.elts)
    star = next((i for i, each in enumerate(target.elts) if isinstance(each, ast.Starred)), None)
    if star is not None and len(parts) >= count - 1:
        after = len(parts) - (count - star - 1)
        parts = [*parts[:star], parts[star:after], *parts[after:]]
    if len(parts) != count:
        raise scope.error("value", f"{len(parts)} values for {count} names", target)
    return parts


def bind_item(c: Compilation, scope: CompiledScope, target: ast.Subscript, container: Value) -> None:
    """Assigning an element assigns a changed container, to a variable wherever that belongs."""
    if container is None:
        return
    if isinstance(target.value, ast.Name):
        scope.assign_where_it_is(target.value.id, container)
    else:
        bind(c, scope, target.value, container)


# ------------------------------------------------------------ branches and loops


def branch(c: Compilation, scope: CompiledScope, node: ast.If) -> None:
    def run(no: Label, live: bool) -> None:
        end = Label()
        with scope.in_dynamic_branch() if live else nullcontext():
            scope.run(node.body)
            c.code.row(op.JUMP, c=end)
            c.code.put(no)
            scope.run(node.orelse)
        c.code.put(end)

    live_branch(c, scope, node.test, [node.body, node.orelse], run)


def repeat_while(c: Compilation, scope: CompiledScope, node: ast.While) -> None:
    scope.pin(assigned_names(node.test, *node.body))
    again, failed, loop = Label(), Label(), Loop(Label(), Label())
    c.code.put_loop(again)
    jump_on(c, scope, node.test, failed, when=False)
    with scope.in_dynamic_branch():
        in_loop(scope, loop, node.body)
        c.code.put(loop.again)
        c.code.row(op.LOOP_BACK, c=again)
        c.code.put(failed)
        scope.run(node.orelse)
    c.code.put(loop.exit)


def in_loop(scope: CompiledScope, loop: Loop, body: list[ast.stmt]) -> None:
    loop.parts = scope.compilation.written()
    scope.inlined.loops.append(loop)
    try:
        with scope.compilation.repeated():
            scope.run(body)
    finally:
        scope.inlined.loops.pop()


def repeat(c: Compilation, scope: CompiledScope, node: ast.For) -> None:
    items = scope.value(node.iter)
    if isinstance(items, range) and len(items) > 0:
        items = LiveRange(items.start, items.stop, items.step)
    if isinstance(items, LiveRange):
        count_through(c, scope, node, items)
    elif isinstance(items, RegisterList):
        go_through(c, scope, node, items)
    else:
        go_through_fixed(c, scope, node, elements(c, scope, items, node.iter))


def count_through(c: Compilation, scope: CompiledScope, node: ast.For, numbers: LiveRange) -> None:
    """`for i in range(...)`."""
    code = c.code
    counter, stop = code.variables.take(), code.variables.take()
    register_of(code, numbers.start, counter)
    register_of(code, numbers.stop, stop)

    def done(label: Label) -> None:
        first, second = (counter, stop) if numbers.step > 0 else (stop, counter)
        code.row(op.JUMP_NOT_LESS, first, second, label)

    def count() -> None:
        code.row(op.ADD, counter, counter, code.constant(numbers.step))

    live_loop(c, scope, node, done, count, lambda: RegisterValue(counter, whole=numbers.whole), op.LOOP_BACK)


def go_through(c: Compilation, scope: CompiledScope, node: ast.For, items: RegisterList) -> None:
    """`for x in items` of a list whose length varies; the list is as it was when the loop began."""
    code = c.code
    items = kept(code, items)
    counter = code.variables.take()
    register_of(code, 0, counter)

    def done(label: Label) -> None:
        code.row(op.JUMP_NOT_LESS, counter, items.length.register, label)

    def count() -> None:
        code.row(op.ADD, counter, counter, code.constant(1))

    live_loop(c, scope, node, done, count, lambda: element_at(c, items, RegisterValue(counter, whole=True)))


def go_through_fixed(c: Compilation, scope: CompiledScope, node: ast.For, items: list[Value]) -> None:
    """`for x in items` of a fixed list: one body for many objects if that can be done, else one for each."""
    if among_objects(items, 0) is None:
        unroll(c, scope, node, items)
        return
    before = Snapshot(c, scope)
    try:
        go_through_objects(c, scope, node, items)
    except ScenicError as error:
        if error.kind != "unsupported":
            raise
        before.restore()
        unroll(c, scope, node, items)


def go_through_objects(c: Compilation, scope: CompiledScope, node: ast.For, items: list[Value]) -> None:
    code = c.code
    counter = code.variables.take()
    register_of(code, 0, counter)

    def done(label: Label) -> None:
        code.row(op.JUMP_NOT_LESS, counter, code.constant(len(items)), label)

    def count() -> None:
        code.row(op.ADD, counter, counter, code.constant(1))

    live_loop(c, scope, node, done, count, lambda: among_objects(items, counter))


def live_loop(
    c: Compilation,
    scope: CompiledScope,
    node: ast.For,
    done: Callable[[Label], None],
    count: Callable[[], None],
    element: Callable[[], Value],
    back: int = op.JUMP,
) -> None:
    """A loop whose rounds share their rows; `back` leads from one to the next."""
    code = c.code
    scope.pin(assigned_names(*node.body))
    again, over, loop = Label(), Label(), Loop(Label(), Label())
    code.put_loop(again)
    done(over)
    with scope.in_dynamic_branch():
        bind(c, scope, node.target, element())
        in_loop(scope, loop, node.body)
        code.put(loop.again)
        count()
        code.row(back, c=again)
        code.put(over)
        scope.run(node.orelse)
    code.put(loop.exit)


def unroll(c: Compilation, scope: CompiledScope, node: ast.For, items: list[Value]) -> None:
    """A loop over a fixed list: every round has rows of its own, in which the element is known."""
    code = c.code
    if suspends(node.body):
        items = [kept(code, each) for each in items]
    else:
        items = [settled(code, each) for each in items]
    jumps = [each for each in walk_own(*node.body) if isinstance(each, ast.Break | ast.Continue)]
    if jumps:
        scope.pin(assigned_names(*node.body))
    exit_ = Label()
    last = LastTarget(c, scope, node) if any(isinstance(each, ast.Break) for each in jumps) else None
    for i, item in enumerate(items):
        loop = Loop(exit_, Label(), last.store if last is not None else None)
        with c.round(node, i), code.statement():
            bind(c, scope, node.target, item)
            in_loop(scope, loop, node.body)
            code.put(loop.again)
    if last is not None and items:
        last.store()
    scope.run(node.orelse)
    code.put(exit_)
    if last is not None:
        last.load()


class LastTarget:
    """The target of an unrolled loop after it: which element it holds depends on where the loop was left."""

    def __init__(self, c: Compilation, scope: CompiledScope, node: ast.For) -> None:
        names = {each.id for each in ast.walk(node.target) if isinstance(each, ast.Name)}
        inside = sum(1 for each in ast.walk(node) if is_read(each, names))
        read_after = sum(1 for tree in scope.inlined.body for each in ast.walk(tree) if is_read(each, names)) > inside
        self.scope = scope
        self.slots = {
            name: Slot(c.code, c.shapes, (*c.path, id(node), "last", name))
            for name in sorted(names)
            if read_after and name not in scope.slots
        }

    def store(self) -> None:
        for name, slot in self.slots.items():
            if name in self.scope.locals:
                slot.store(self.scope.locals[name])

    def load(self) -> None:
        for name, slot in self.slots.items():
            if slot.shape is not None:
                self.scope.locals[name] = slot.value


def is_read(node: ast.AST, names: set[str]) -> bool:
    return isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load)


def leave_loop(c: Compilation, scope: CompiledScope, node: ast.Break) -> None:
    loop = scope.inlined.loops[-1]
    if loop.leave is not None:
        loop.leave()
    c.give_up(loop.parts)
    c.code.row(op.JUMP, c=loop.exit)


def next_round(c: Compilation, scope: CompiledScope, node: ast.Continue) -> None:
    loop = scope.inlined.loops[-1]
    c.give_up(loop.parts)
    c.code.row(op.JUMP, c=loop.again)


def give_back(c: Compilation, scope: CompiledScope, node: ast.Return) -> None:
    """`return`: of a behavior its end; of a function its value, in registers if it returns from several places."""
    inlined = scope.inlined
    if inlined.behavior is not None:
        c.code.row(op.JUMP, c=inlined.end)
        return
    value = None if node.value is None else scope.value(node.value)
    if inlined.live == 0 and inlined.result is None and not inlined.loops:
        value = settled(c.code, value)
        inlined.level = c.code.temporaries.used
        raise Return(value)
    if inlined.result is None:
        inlined.result = Slot(c.code, c.shapes, (*inlined.path, "return"), varying=True)
    inlined.result.store(value)
    c.code.row(op.JUMP, c=inlined.end)


def certify(c: Compilation, scope: CompiledScope, node: ast.Assert) -> None:
    """`assert`: a fault of the match if it does not hold."""
    fine = Label()
    jump_on(c, scope, node.test, fine, when=True)
    c.code.fault("the assertion does not hold")
    c.code.put(fine)


def refuse(c: Compilation, scope: CompiledScope, node: ast.stmt) -> None:
    words = {ast.Try: "`except`", ast.With: "`with`"}
    word = words.get(type(node), f"`{type(node).__name__.lower()}`")
    raise ScenicError("unsupported", f"{word} cannot be compiled for a match")


def define(c: Compilation, scope: CompiledScope, node: ast.FunctionDef) -> None:
    scope.pin({name for each in ast.walk(node) if isinstance(each, ast.Nonlocal) for name in each.names})
    define_function(scope, node)


def delete(c: Compilation, scope: CompiledScope, node: ast.Delete) -> None:
    """`del x`, `del items[i]`."""
    for target in node.targets:
        if isinstance(target, ast.Name):
            if scope.inlined.live:
                raise ScenicError("unsupported", f"whether '{target.id}' is deleted cannot be decided in a match")
            scope.lookup(target.id)
            scope.locals.pop(target.id, None)
            scope.slots.pop(target.id, None)
        elif isinstance(target, ast.Subscript):
            bind_item(c, scope, target, without_item(c, scope, target))
        else:
            raise ScenicError("unsupported", "attributes cannot be deleted in a match")


def without_item(c: Compilation, scope: CompiledScope, target: ast.Subscript) -> Value:
    container, index = scope.value(target.value), scope.value(target.slice)
    if isinstance(container, dict) and not isinstance(index, RandomExpr | RandomChoice):
        item_of(scope, container, index)
        return {key: value for key, value in container.items() if key != index}
    if isinstance(container, list | RegisterList) and not isinstance(index, slice):
        return mutated(c, scope, target, container, "pop", [index], {})[0]
    raise ScenicError("unsupported", "this cannot be deleted in a match")


def throw(c: Compilation, scope: CompiledScope, node: ast.Raise) -> None:
    """`raise`: a fault of the match, since nothing catches it there; no slip of the program that is to be warned of."""
    value = None if node.exc is None else scope.value(node.exc)
    if isinstance(value, ExceptionClass):
        value = Fault(value)
    if not isinstance(value, Fault):
        raise scope.error("type", f"`raise` needs an exception, not {describe_kind(value)}", node)
    fixed = not any(map(varies, value.arguments))
    c.code.fault(raised(value if fixed else Fault(value.cls)).message)


def match(c: Compilation, scope: CompiledScope, node: ast.Match) -> None:
    """`match`, as the branches that it is."""
    subject = scope.value(node.subject)
    if not varies(subject):
        scope.run(chosen_case(scope, node))
        return
    scope.assign(SUBJECT, subject)
    scope.run(branches_of(node))


def declare_global(c: Compilation, scope: CompiledScope, node: ast.Global) -> None:
    scope.globals.update(node.names)


def declare_nonlocal(c: Compilation, scope: CompiledScope, node: ast.Nonlocal) -> None:
    scope.nonlocals.update(node.names)


def skip(c: Compilation, scope: CompiledScope, node: ast.stmt) -> None:
    nothing(scope, node)


STATEMENTS: dict[type, Callable[[Compilation, CompiledScope, Any], None]] = {
    ast.Expr: expression,
    ast.Assign: assign,
    ast.AnnAssign: annotated,
    ast.AugAssign: augmented,
    ast.If: branch,
    ast.While: repeat_while,
    ast.For: repeat,
    ast.Break: leave_loop,
    ast.Continue: next_round,
    ast.Return: give_back,
    ast.Assert: certify,
    ast.Pass: skip,
    ast.FunctionDef: define,
    ast.Try: refuse,
    ast.Raise: throw,
    ast.With: refuse,
    ast.Delete: delete,
    ast.Global: declare_global,
    ast.Nonlocal: declare_nonlocal,
    ast.Match: match,
    ast.ClassDef: refuse,
}
