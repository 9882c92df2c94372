"""The passing of time in a behavior: guards, `try / interrupt`, `do ... until`, `do ... for`; each block has a slot.

The slot of a block holds the row at which the block resumes, or 0 while the block is not running. The entry of a
statement clears the slots of its handlers and sets the slot of the enclosing block to a scan. The outermost scan thus
runs first after time has passed. The scan checks the handlers from last to first, and resumes the first handler that is
running or whose condition is true, otherwise the body. A handler that ends clears its slot and scans again in the same
step. Read next: `dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from scenic_lite.core.types import BehaviorCall
from scenic_lite.dynamics.compiler.choices import branch, in_steps, jump_on
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.registers import store_in_register
from scenic_lite.dynamics.compiler.statements import assigned_names
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.syntax import nodes


class Handler(NamedTuple):
    """An interrupt of a body: `ask` writes rows that jump if it occurs; a `block` of None ends the statement."""

    ask: Callable[[Label], None]
    block: list[ast.stmt] | None = None


def suspend(c: Compilation, on: Label) -> None:
    """Let time pass and resume at a label. In a compose block, the step of the scenario continues."""
    if c.site.part is not None and c.site.composing:
        c.code.row(op.SET_SLOT, c.site.slot, c=on)
        c.code.row(op.JUMP, c=c.site.part.after)
    else:
        c.code.row(op.WAIT, 0, c.site.slot, on)


def pause(c: Compilation) -> None:
    """Let one step pass."""
    on = Label()
    suspend(c, on)
    c.code.put(on)


# ------------------------------------------------------------ behaviors and their guards
def frame_of(c: Compilation, call: BehaviorCall) -> CompiledScope:
    """Return the scope of a behavior at its start."""
    behavior = call.behavior
    names = {name: store_in_register(c.code, value) for name, value in call.arguments.items()} | {"self": c.site.agent}
    scope = CompiledScope(c, behavior.scope.source, names, behavior.scope, InlinedBody(c.site.path, Label(), behavior))
    scope.assigned = behavior.assigned
    return scope


def check_guards(c: Compilation, scope: CompiledScope) -> None:
    """Check the preconditions and invariants of a behavior at its start."""
    behavior = scope.inlined.behavior
    assert behavior is not None
    check(c, scope, "precondition", behavior.node.preconditions)
    check_invariants(c, scope)


def check_invariants(c: Compilation, scope: CompiledScope) -> None:
    """Check the invariants of a behavior; required at its start and after time has passed."""
    behavior = scope.inlined.behavior
    if behavior is not None:
        check(c, scope, "invariant", behavior.node.invariants)


def check(c: Compilation, scope: CompiledScope, word: str, conditions: list[ast.expr]) -> None:
    for condition in conditions:
        with c.code.statement(), branch(c, scope, condition, when=False):
            c.reject(f"violated {word} of {scope.inlined.behavior.name} on line {condition.lineno}")  # type: ignore[union-attr]


# ------------------------------------------------------------ interrupts
def try_interrupt(c: Compilation, scope: CompiledScope, node: nodes.TryInterrupt) -> None:
    scope.pin(assigned_names(node))
    handlers = [Handler(partial(interrupt_on, c, scope, clause.condition), clause.body) for clause in node.interrupts]
    interruptible(c, scope, handlers, partial(scope.run, node.body))


def interruptible(c: Compilation, scope: CompiledScope, handlers: list[Handler], run: Callable[[], None]) -> None:
    """Compile a body with handlers; the last handler takes precedence."""
    code, begun, before = c.code, c.scenarios_begun(), set(scope.unset)
    body = code.variables.take(1 + len(handlers))
    begin, scan, end = Label(), Label(), Label()
    blocks = [(body + 1 + i, block, Label()) for i, block in enumerate(handlers)]
    for slot, handler, _ in blocks:
        if handler.block:
            register_of(code, 0, slot)
    enter(c, scope, body, begin, scan)
    for slot, handler, start in reversed(blocks):
        if handler.block:
            code.row(op.RESUME_IF_RUNNING, slot)
        with code.statement():
            handler.ask(start if handler.block else end)
    code.row(op.RESUME, body)
    with scope.in_dynamic_branch():
        code.put_reachable(begin)
        with c.at(slot=body):
            run()
        code.row(op.JUMP, c=end)
        for slot, handler, start in blocks:
            if handler.block:
                scope.unset |= before
                code.put(start)
                scope.inlined.aborts.append(end)
                with c.at(slot=slot), c.repeated():
                    scope.run(handler.block)
                scope.inlined.aborts.pop()
                register_of(code, 0, slot)
                code.row(op.LOOP_BACK, c=scan)
    code.put(end)
    c.stop_scenarios(begun)


def interrupt_on(c: Compilation, scope: CompiledScope, condition: ast.expr, start: Label) -> None:
    """Jump to a handler if its condition holds."""
    c.code.place = scope.place(condition)
    jump_on(c, scope, condition, start, when=True)


def enter(c: Compilation, scope: CompiledScope, body: int, begin: Label, scan: Label) -> None:
    """Write rows that enter a statement, up to the scan; after time has passed, invariants are checked first."""
    code, behavior = c.code, scope.inlined.behavior
    resumed = Label() if behavior is not None and behavior.node.invariants else scan
    code.row(op.SET_SLOT, body, c=begin)
    code.row(op.SET_SLOT, c.site.slot, c=resumed)
    if resumed is not scan:
        code.row(op.JUMP, c=scan)
        code.put(resumed)
        check_invariants(c, scope)
    code.put_loop(scan)


def limited(c: Compilation, scope: CompiledScope, node: nodes.Do | nodes.Wait, run: Callable[[], None]) -> None:
    """Compile a body with a limit, which is checked before the body begins and before each resumption."""
    interruptible(c, scope, [Handler(limit_of(c, scope, node))], run)


def limit_of(c: Compilation, scope: CompiledScope, node: nodes.Do | nodes.Wait) -> Callable[[Label], None]:
    """Return a function that writes rows that jump if a `do` or `wait` is over."""
    if node.until is not None:
        return partial(jump_on, c, scope, node.until, when=True)
    assert node.duration is not None
    steps = in_steps(c, scope.value(node.duration), node.unit)
    code, time = c.code, c.time()
    start = code.variables.take(2)
    register_of(code, time, start)
    register_of(code, steps, start + 1)

    def over(end: Label) -> None:
        passed = code.temporaries.take()
        code.row(op.SUBTRACT, passed, time.register, start)
        code.row(op.JUMP_LESS_EQUAL, start + 1, passed, end)

    return over


def abort(c: Compilation, scope: CompiledScope, node: nodes.Abort) -> None:
    c.code.row(op.JUMP, c=scope.inlined.aborts[-1])
