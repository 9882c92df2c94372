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
from scenic_lite.core.types import BehaviorCall, Choice, describe_kind
from scenic_lite.dynamics.compiler.attributes import set_attribute
from scenic_lite.dynamics.compiler.cases import SUBJECT, branches_of
from scenic_lite.dynamics.compiler.changing import mutated
from scenic_lite.dynamics.compiler.choices import combination
from scenic_lite.dynamics.compiler.code import Label, Live
from scenic_lite.dynamics.compiler.compilation import Compilation, LiveFrame, Loop, Snapshot, assigned_names, suspends
from scenic_lite.dynamics.compiler.conditions import jump_on, live_branch
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.lists import LiveRange, among_objects, changed_item, element_at, elements
from scenic_lite.dynamics.compiler.registers import Slot, copied, kept, settled
from scenic_lite.dynamics.compiler.types import LiveList, varies
from scenic_lite.dynamics.machine.bytecode import Op
from scenic_lite.dynamics.reference.threads import within
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.assignments import TRACKED
from scenic_lite.evaluation.calls import Return
from scenic_lite.evaluation.expressions import item_of
from scenic_lite.evaluation.matching import chosen_case
from scenic_lite.evaluation.statements import define_function, nothing
from scenic_lite.values.graph import Random, Value

MOST_UNROLLED = 64  # rounds of a loop over a fixed list


def expression(c: Compilation, frame: LiveFrame, node: ast.Expr) -> None:
    value = frame.value(node.value)
    settled(c.code, value)
    if isinstance(value, BehaviorCall):
        name = value.behavior.name
        message = f'the behavior "{name}" is named here, but not run'
        c.doubts.append(frame.error("warning", message, node, f"write do {name}(...)"))


def assign(c: Compilation, frame: LiveFrame, node: ast.Assign) -> None:
    value = frame.value(node.value)
    for target in node.targets:
        bind(c, frame, target, value)


def annotated(c: Compilation, frame: LiveFrame, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind(c, frame, node.target, frame.value(node.value))


def augmented(c: Compilation, frame: LiveFrame, node: ast.AugAssign) -> None:
    target = node.target
    old = frame.lookup(target.id) if isinstance(target, ast.Name) else frame.value(loading(target))
    bind(c, frame, target, combination(c, frame, node, old, frame.value(node.value)))


def loading(target: ast.expr) -> ast.expr:
    """The expression that reads what an assignment writes."""
    if isinstance(target, ast.Subscript):
        return ast.copy_location(ast.Subscript(target.value, target.slice, ast.Load()), target)
    assert isinstance(target, ast.Attribute)
    return ast.copy_location(ast.Attribute(target.value, target.attr, ast.Load()), target)


def bind(c: Compilation, frame: LiveFrame, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, an element or an attribute."""
    if isinstance(target, ast.Name):
        track(c, frame, target, value)
        frame.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        parts = elements(c, frame, value, target)
        parts = spread(frame, target, parts)
        parts = [copied(c.code, each) for each in parts]  # `a, b = b, a`
        for each, part in zip(target.elts, parts, strict=True):
            bind(c, frame, each.value if isinstance(each, ast.Starred) else each, part)
    elif isinstance(target, ast.Attribute):
        set_attribute(c, frame, target, frame.value(target.value), value)
    elif isinstance(target, ast.Subscript):
        container, index = frame.value(target.value), frame.value(target.slice)
        bind_item(c, frame, target, changed_item(c, frame, container, index, value))
    else:
        raise frame.error("syntax", "this cannot be assigned to", target)


def track(c: Compilation, frame: LiveFrame, target: ast.Name, value: Value) -> None:
    """`ego = ...` in the setup of a scenario that a match starts: it lasts as long as that."""
    if target.id not in TRACKED:
        return
    if not c.setting_up or frame.scope.live or frame.scope.behavior is not c.part_behavior:
        hint = "only the setup of a scenario may, and not in a branch"
        raise ScenicError("unsupported", f"no match can change {target.id} here", hint=hint)
    TRACKED[target.id](frame, target, value)


def spread(frame: LiveFrame, target: ast.Tuple | ast.List, parts: list[Value]) -> list[Value]:
    """One value for each of several names; what stands behind a star takes those that are left."""
    count = len(target.elts)
    star = next((i for i, each in enumerate(target.elts) if isinstance(each, ast.Starred)), None)
    if star is not None and len(parts) >= count - 1:
        after = len(parts) - (count - star - 1)
        parts = [*parts[:star], parts[star:after], *parts[after:]]
    if len(parts) != count:
        raise frame.error("value", f"{len(parts)} values for {count} names", target)
    return parts


def bind_item(c: Compilation, frame: LiveFrame, target: ast.Subscript, container: Value) -> None:
    """Assigning an element assigns a changed container, to a variable wherever that belongs."""
    if container is None:
        return
    if isinstance(target.value, ast.Name):
        frame.assign_where_it_is(target.value.id, container)
    else:
        bind(c, frame, target.value, container)


# ------------------------------------------------------------ branches and loops


def branch(c: Compilation, frame: LiveFrame, node: ast.If) -> None:
    def run(no: Label, live: bool) -> None:
        end = Label()
        with frame.living() if live else nullcontext():
            frame.run(node.body)
            c.code.row(Op.JUMP, c=end)
            c.code.put(no)
            frame.run(node.orelse)
        c.code.put(end)

    live_branch(c, frame, node.test, [node.body, node.orelse], run)


def repeat_while(c: Compilation, frame: LiveFrame, node: ast.While) -> None:
    frame.pin(assigned_names(node.test, *node.body))
    again, failed, loop = Label(), Label(), Loop(Label(), Label())
    c.code.put_loop(again)
    jump_on(c, frame, node.test, failed, when=False)
    with frame.living():
        in_loop(frame, loop, node.body)
        c.code.put(loop.again)
        c.code.row(Op.AGAIN, c=again)
        c.code.put(failed)
        frame.run(node.orelse)
    c.code.put(loop.exit)


def in_loop(frame: LiveFrame, loop: Loop, body: list[ast.stmt]) -> None:
    loop.parts = frame.compilation.written()
    frame.scope.loops.append(loop)
    try:
        with frame.compilation.repeated():
            frame.run(body)
    finally:
        frame.scope.loops.pop()


def repeat(c: Compilation, frame: LiveFrame, node: ast.For) -> None:
    items = frame.value(node.iter)
    if isinstance(items, range) and len(items) > 0:
        items = LiveRange(items.start, items.stop, items.step)
    if isinstance(items, LiveRange):
        count_through(c, frame, node, items)
    elif isinstance(items, LiveList):
        go_through(c, frame, node, items)
    else:
        go_through_fixed(c, frame, node, elements(c, frame, items, node.iter))


def count_through(c: Compilation, frame: LiveFrame, node: ast.For, numbers: LiveRange) -> None:
    """`for i in range(...)`."""
    code = c.code
    counter, stop = code.variables.take(), code.variables.take()
    register_of(code, numbers.start, counter)
    register_of(code, numbers.stop, stop)

    def done(label: Label) -> None:
        first, second = (counter, stop) if numbers.step > 0 else (stop, counter)
        code.row(Op.JUMP_NOT_LESS, first, second, label)

    def count() -> None:
        code.row(Op.ADD, counter, counter, code.constant(numbers.step))

    live_loop(c, frame, node, done, count, lambda: Live(counter, whole=numbers.whole), Op.AGAIN)


def go_through(c: Compilation, frame: LiveFrame, node: ast.For, items: LiveList) -> None:
    """`for x in items` of a list whose length varies; the list is as it was when the loop began."""
    code = c.code
    items = kept(code, items)
    counter = code.variables.take()
    register_of(code, 0, counter)

    def done(label: Label) -> None:
        code.row(Op.JUMP_NOT_LESS, counter, items.length.register, label)

    def count() -> None:
        code.row(Op.ADD, counter, counter, code.constant(1))

    live_loop(c, frame, node, done, count, lambda: element_at(c, items, Live(counter, whole=True)))


def go_through_fixed(c: Compilation, frame: LiveFrame, node: ast.For, items: list[Value]) -> None:
    """`for x in items` of a fixed list: one body for many objects if that can be done, else one for each."""
    if among_objects(items, 0) is None:
        unroll(c, frame, node, items)
        return
    before = Snapshot(c, frame)
    try:
        go_through_objects(c, frame, node, items)
    except ScenicError as error:
        if error.kind != "unsupported":
            raise
        before.restore()
        unroll(c, frame, node, items)


def go_through_objects(c: Compilation, frame: LiveFrame, node: ast.For, items: list[Value]) -> None:
    code = c.code
    counter = code.variables.take()
    register_of(code, 0, counter)

    def done(label: Label) -> None:
        code.row(Op.JUMP_NOT_LESS, counter, code.constant(len(items)), label)

    def count() -> None:
        code.row(Op.ADD, counter, counter, code.constant(1))

    live_loop(c, frame, node, done, count, lambda: among_objects(items, counter))


def live_loop(
    c: Compilation,
    frame: LiveFrame,
    node: ast.For,
    done: Callable[[Label], None],
    count: Callable[[], None],
    element: Callable[[], Value],
    back: Op = Op.JUMP,
) -> None:
    """A loop whose rounds share their rows; `back` leads from one to the next."""
    code = c.code
    frame.pin(assigned_names(*node.body))
    again, over, loop = Label(), Label(), Loop(Label(), Label())
    code.put_loop(again)
    done(over)
    with frame.living():
        bind(c, frame, node.target, element())
        in_loop(frame, loop, node.body)
        code.put(loop.again)
        count()
        code.row(back, c=again)
        code.put(over)
        frame.run(node.orelse)
    code.put(loop.exit)


def unroll(c: Compilation, frame: LiveFrame, node: ast.For, items: list[Value]) -> None:
    """A loop over a fixed list: every round has rows of its own, in which the element is known."""
    code = c.code
    if suspends(node.body):
        items = [kept(code, each) for each in items]
    else:
        items = [settled(code, each) for each in items]
    jumps = [each for each in within(*node.body) if isinstance(each, ast.Break | ast.Continue)]
    if jumps:
        frame.pin(assigned_names(*node.body))
    exit_ = Label()
    last = LastTarget(c, frame, node) if any(isinstance(each, ast.Break) for each in jumps) else None
    for i, item in enumerate(items):
        loop = Loop(exit_, Label(), last.store if last is not None else None)
        with c.round(node, i), code.statement():
            bind(c, frame, node.target, item)
            in_loop(frame, loop, node.body)
            code.put(loop.again)
    if last is not None and items:
        last.store()
    frame.run(node.orelse)
    code.put(exit_)
    if last is not None:
        last.load()


class LastTarget:
    """The target of an unrolled loop after it: which element it holds depends on where the loop was left."""

    def __init__(self, c: Compilation, frame: LiveFrame, node: ast.For) -> None:
        names = {each.id for each in ast.walk(node.target) if isinstance(each, ast.Name)}
        inside = sum(1 for each in ast.walk(node) if is_read(each, names))
        read_after = sum(1 for tree in frame.scope.body for each in ast.walk(tree) if is_read(each, names)) > inside
        self.frame = frame
        self.slots = {
            name: Slot(c.code, c.shapes, (*c.path, id(node), "last", name))
            for name in sorted(names)
            if read_after and name not in frame.slots
        }

    def store(self) -> None:
        for name, slot in self.slots.items():
            if name in self.frame.locals:
                slot.store(self.frame.locals[name])

    def load(self) -> None:
        for name, slot in self.slots.items():
            if slot.shape is not None:
                self.frame.locals[name] = slot.value


def is_read(node: ast.AST, names: set[str]) -> bool:
    return isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load)


def leave_loop(c: Compilation, frame: LiveFrame, node: ast.Break) -> None:
    loop = frame.scope.loops[-1]
    if loop.leave is not None:
        loop.leave()
    c.give_up(loop.parts)
    c.code.row(Op.JUMP, c=loop.exit)


def next_round(c: Compilation, frame: LiveFrame, node: ast.Continue) -> None:
    loop = frame.scope.loops[-1]
    c.give_up(loop.parts)
    c.code.row(Op.JUMP, c=loop.again)


def give_back(c: Compilation, frame: LiveFrame, node: ast.Return) -> None:
    """`return`: of a behavior its end; of a function its value, in registers if it returns from several places."""
    scope = frame.scope
    if scope.behavior is not None:
        c.code.row(Op.JUMP, c=scope.end)
        return
    value = None if node.value is None else frame.value(node.value)
    if scope.live == 0 and scope.result is None and not scope.loops:
        value = settled(c.code, value)
        scope.level = c.code.temporaries.used
        raise Return(value)
    if scope.result is None:
        scope.result = Slot(c.code, c.shapes, (*scope.path, "return"), varying=True)
    scope.result.store(value)
    c.code.row(Op.JUMP, c=scope.end)


def certify(c: Compilation, frame: LiveFrame, node: ast.Assert) -> None:
    """`assert`: a fault of the match if it does not hold."""
    fine = Label()
    jump_on(c, frame, node.test, fine, when=True)
    c.code.fault("the assertion does not hold")
    c.code.put(fine)


def refuse(c: Compilation, frame: LiveFrame, node: ast.stmt) -> None:
    words = {ast.Try: "`except`", ast.With: "`with`"}
    word = words.get(type(node), f"`{type(node).__name__.lower()}`")
    raise ScenicError("unsupported", f"{word} cannot be compiled for a match")


def define(c: Compilation, frame: LiveFrame, node: ast.FunctionDef) -> None:
    frame.pin({name for each in ast.walk(node) if isinstance(each, ast.Nonlocal) for name in each.names})
    define_function(frame, node)


def delete(c: Compilation, frame: LiveFrame, node: ast.Delete) -> None:
    """`del x`, `del items[i]`."""
    for target in node.targets:
        if isinstance(target, ast.Name):
            if frame.scope.live:
                raise ScenicError("unsupported", f"whether '{target.id}' is deleted cannot be decided in a match")
            frame.lookup(target.id)
            frame.locals.pop(target.id, None)
            frame.slots.pop(target.id, None)
        elif isinstance(target, ast.Subscript):
            bind_item(c, frame, target, without_item(c, frame, target))
        else:
            raise ScenicError("unsupported", "attributes cannot be deleted in a match")


def without_item(c: Compilation, frame: LiveFrame, target: ast.Subscript) -> Value:
    container, index = frame.value(target.value), frame.value(target.slice)
    if isinstance(container, dict) and not isinstance(index, Random | Choice):
        item_of(frame, container, index)
        return {key: value for key, value in container.items() if key != index}
    if isinstance(container, list | LiveList) and not isinstance(index, slice):
        return mutated(c, frame, target, container, "pop", [index], {})[0]
    raise ScenicError("unsupported", "this cannot be deleted in a match")


def throw(c: Compilation, frame: LiveFrame, node: ast.Raise) -> None:
    """`raise`: a fault of the match, since nothing catches it there; no slip of the program that is to be warned of."""
    value = None if node.exc is None else frame.value(node.exc)
    if isinstance(value, ExceptionClass):
        value = Fault(value)
    if not isinstance(value, Fault):
        raise frame.error("type", f"`raise` needs an exception, not {describe_kind(value)}", node)
    fixed = not any(map(varies, value.arguments))
    c.code.fault(raised(value if fixed else Fault(value.cls)).message)


def match(c: Compilation, frame: LiveFrame, node: ast.Match) -> None:
    """`match`, as the branches that it is."""
    subject = frame.value(node.subject)
    if not varies(subject):
        frame.run(chosen_case(frame, node))
        return
    frame.assign(SUBJECT, subject)
    frame.run(branches_of(node))


def declare_global(c: Compilation, frame: LiveFrame, node: ast.Global) -> None:
    frame.globals.update(node.names)


def declare_nonlocal(c: Compilation, frame: LiveFrame, node: ast.Nonlocal) -> None:
    frame.nonlocals.update(node.names)


def skip(c: Compilation, frame: LiveFrame, node: ast.stmt) -> None:
    nothing(frame, node)


STATEMENTS: dict[type, Callable[[Compilation, LiveFrame, Any], None]] = {
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
