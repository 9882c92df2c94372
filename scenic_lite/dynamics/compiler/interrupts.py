"""`try / interrupt`, `do ... until`, `do ... for`: blocks with a slot each, and a scan that chooses among them.

Every block has a slot: the row where it goes on, 0 while it is not running. Entering the statement clears the slots of
the handlers and lets the block around it go on at the scan, so that whenever time has passed the outermost scan runs
first. The scan asks the handlers from the last to the first: one that is running, or whose condition is true, goes on;
if there is none, the body. A handler that ends clears its slot and scans again in the same step. Read next:
`dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from scenic_lite.dynamics.compiler.choices import jump_on
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, assigned_names
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes

Limit = Callable[[Label], None]  # rows that jump when it is over


def try_interrupt(c: Compilation, scope: CompiledScope, node: nodes.TryInterrupt) -> None:
    if node.handlers or node.orelse or node.finalbody:
        raise ScenicError("unsupported", "`except`, `else` and `finally` cannot be compiled for a match")
    given = expect(c, scope, node)
    scope.pin(assigned_names(node))
    code, written = c.code, c.written()
    body = code.variables.take(1 + len(node.interrupts))
    slots = [body + 1 + i for i in range(len(node.interrupts))]
    begin, scan, end = Label(), Label(), Label()
    starts = [Label() for _ in slots]
    for slot in slots:
        register_of(code, 0, slot)
    enter(c, scope, body, begin, scan)
    for slot, handler, start in reversed(list(zip(slots, node.interrupts, starts, strict=True))):
        code.row(op.RESUME_IF_RUNNING, slot)
        with code.statement():
            code.place = scope.place(handler.condition)
            with once_set(c, scope, surely_read(handler.condition) & given.keys()) as readable:
                if readable:
                    jump_on(c, scope, handler.condition, start, when=True)
    code.row(op.RESUME, body)
    with scope.in_dynamic_branch(), c.suspends_others():
        code.put(begin)
        begin.used = code.reachable = True
        with c.block(body):
            scope.run(node.body)
        code.row(op.JUMP, c=end)
        for slot, handler, start in zip(slots, node.interrupts, starts, strict=True):
            code.put(start)
            scope.inlined.aborts.append(end)
            with c.block(slot), c.repeated():
                scope.run(handler.body)
            scope.inlined.aborts.pop()
            register_of(code, 0, slot)
            code.row(op.LOOP_BACK, c=scan)
    code.put(end)
    c.give_up(written)


def expect(c: Compilation, scope: CompiledScope, node: nodes.TryInterrupt) -> dict[str, int]:
    """In a compose block: registers that say whether variables that conditions read by now have a value.

    One that has none makes the condition false; in a behavior it is a fault, and so it is here within a loop.
    """
    if not c.composing or c.repeating:
        return {}
    names = {name for handler in node.interrupts for name in surely_read(handler.condition)}
    given = {name: c.code.variables.take() for name in sorted(names & assigned_names(node) - scope.locals.keys())}
    for register in given.values():
        register_of(c.code, 0, register)
    scope.given |= given
    return given


def surely_read(condition: ast.expr) -> set[str]:
    """The names in a condition; what stands behind an `or` might not be come to."""
    if any(isinstance(each, ast.Or | ast.IfExp) for each in ast.walk(condition)):
        return set()
    return {each.id for each in ast.walk(condition) if isinstance(each, ast.Name)}


@contextmanager
def once_set(c: Compilation, scope: CompiledScope, names: set[str]) -> Iterator[bool]:
    """Rows written inside, a condition, are only come to when these variables have a value; whether they may be."""
    unset = Label()
    before = dict(scope.locals)
    for name in sorted(names):
        c.code.row(op.JUMP_UNLESS, scope.given[name], c=unset)
        c.types.read.add(scope.variables[name].key)  # also while nothing is known of it
        scope.locals[name] = scope.variables[name].load()
    yield all(scope.variables[name].place is not None for name in names)
    scope.locals.clear()
    scope.locals.update(before)
    c.code.put(unset)


def enter(c: Compilation, scope: CompiledScope, body: int, begin: Label, scan: Label) -> None:
    """Rows that enter a statement with a scan, up to the scan itself; after time has passed invariants come first."""
    from scenic_lite.dynamics.compiler.behaviors import check_invariants

    code = c.code
    behavior = scope.inlined.behavior
    resumed = Label() if behavior is not None and behavior.node.invariants else scan
    code.row(op.SET_SLOT, body, c=begin)
    code.row(op.SET_SLOT, c.slot, c=resumed)
    if resumed is not scan:
        code.row(op.JUMP, c=scan)
        code.put(resumed)
        check_invariants(c, scope)
    code.put_loop(scan)


def limited(c: Compilation, scope: CompiledScope, over: Limit, run: Callable[[], None]) -> None:
    """A body that ends when its limit says so, looked at before it is begun and whenever it would be resumed."""
    code, written = c.code, c.written()
    body = code.variables.take()
    begin, scan, end = Label(), Label(), Label()
    enter(c, scope, body, begin, scan)
    with code.statement():
        over(end)
    code.row(op.RESUME, body)
    code.put(begin)
    begin.used = code.reachable = True
    with scope.in_dynamic_branch(), c.suspends_others(), c.block(body):
        run()
    code.put(end)
    c.give_up(written)


def abort(c: Compilation, scope: CompiledScope, node: nodes.Abort) -> None:
    c.code.row(op.JUMP, c=scope.inlined.aborts[-1])
