"""How time passes in a behavior: guards, `try / interrupt`, `do ... until`, `do ... for`; blocks with a slot each.

Every block has a slot: the row where it goes on, 0 while it is not running. Entering a statement clears the slots of
its handlers and lets the block around it go on at a scan, so that whenever time has passed the outermost scan runs
first. The scan asks the handlers from the last to the first: one that is running, or whose condition is true, goes on;
if there is none, the body. A handler that ends clears its slot and scans again in the same step. Read next:
`dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from scenic_lite.core.types import BehaviorCall
from scenic_lite.dynamics.compiler.choices import jump_on, needs_number, truth
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody, assigned_names
from scenic_lite.dynamics.compiler.emit import jump, register_of
from scenic_lite.dynamics.compiler.registers import store_in_register
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.syntax import nodes

Limit = Callable[[Label], None]  # rows that jump when it is over


def suspend(c: Compilation, on: Label) -> None:
    """Let time pass and go on at a label. A compose block lets the step of its scenario go on."""
    if c.site.part is not None and c.site.composing:
        c.code.row(op.SET_SLOT, c.site.slot, c=on)
        c.code.row(op.JUMP, c=c.site.part.after)
    else:
        c.code.row(op.WAIT, 0, c.site.slot, on)


def pause(c: Compilation) -> None:
    """Let time pass once."""
    on = Label()
    suspend(c, on)
    c.code.put(on)


# ------------------------------------------------------------ behaviors and their guards


def frame_of(c: Compilation, call: BehaviorCall) -> CompiledScope:
    """Return the variables of a behavior that begins."""
    behavior = call.behavior
    names = {name: store_in_register(c.code, value) for name, value in call.arguments.items()} | {"self": c.site.agent}
    scope = CompiledScope(c, behavior.scope.source, names, behavior.scope, InlinedBody(c.site.path, Label(), behavior))
    scope.assigned = behavior.assigned
    return scope


def check_guards(c: Compilation, scope: CompiledScope) -> None:
    """Check what must hold when a behavior begins."""
    behavior = scope.inlined.behavior
    assert behavior is not None
    check(c, scope, "precondition", behavior.node.preconditions)
    check_invariants(c, scope)


def check_invariants(c: Compilation, scope: CompiledScope) -> None:
    """Check what must hold whenever a thread goes on after time has passed."""
    behavior = scope.inlined.behavior
    if behavior is not None:
        check(c, scope, "invariant", behavior.node.invariants)


def check(c: Compilation, scope: CompiledScope, word: str, conditions: list[ast.expr]) -> None:
    for condition in conditions:
        fine = Label()
        with c.code.statement():
            jump_on(c, scope, condition, fine, when=True)
            c.reject(f"violated {word} of {scope.inlined.behavior.name} on line {condition.lineno}")  # type: ignore[union-attr]
            c.code.put(fine)


# ------------------------------------------------------------ interrupts


def try_interrupt(c: Compilation, scope: CompiledScope, node: nodes.TryInterrupt) -> None:
    flags = flags_of_unset(c, scope, node)
    scope.pin(assigned_names(node))
    code, begun = c.code, c.scenarios_begun()
    body = code.variables.take(1 + len(node.interrupts))
    slots = [body + 1 + i for i in range(len(node.interrupts))]
    begin, scan, end = Label(), Label(), Label()
    handlers = [(slot, handler, Label()) for slot, handler in zip(slots, node.interrupts, strict=True)]
    for slot in slots:
        register_of(code, 0, slot)
    enter(c, scope, body, begin, scan)
    for slot, handler, start in reversed(handlers):
        code.row(op.RESUME_IF_RUNNING, slot)
        with code.statement():
            code.place = scope.place(handler.condition)
            with once_set(c, scope, surely_read(handler.condition) & flags.keys()) as readable:
                if readable:
                    interrupt_on(c, scope, handler.condition, start)
    code.row(op.RESUME, body)
    with scope.in_dynamic_branch(), c.at(suspending=c.site.suspending + 1):
        code.put_reachable(begin)
        with c.at(slot=body):
            scope.run(node.body)
        code.row(op.JUMP, c=end)
        for slot, handler, start in handlers:
            code.put(start)
            scope.inlined.aborts.append(end)
            with c.at(slot=slot), c.repeated():
                scope.run(handler.body)
            scope.inlined.aborts.pop()
            register_of(code, 0, slot)
            code.row(op.LOOP_BACK, c=scan)
    code.put(end)
    c.stop_scenarios(begun)


def interrupt_on(c: Compilation, scope: CompiledScope, condition: ast.expr, start: Label) -> None:
    """Go to a handler if its condition holds, which cannot be a behavior that somebody forgot to `do`."""
    if not isinstance(condition, ast.Call) or not c.code.reachable:
        jump_on(c, scope, condition, start, when=True)
        return
    value = scope.value(condition)
    if isinstance(value, BehaviorCall):
        error = scope.error("type", "a behavior cannot be called in a condition", condition)
        c.output.doubts.append(error)
        c.stop_with(error)
    else:
        jump(c.code, truth(value), start, when=True)


def flags_of_unset(c: Compilation, scope: CompiledScope, node: nodes.TryInterrupt) -> dict[str, int]:
    """Return registers that say in a compose block whether variables that conditions read by now have a value.

    One that has none makes the condition false; in a behavior it is a fault, and so it is here within a loop.
    """
    if not c.site.composing or c.site.repeating:
        return {}
    names = {name for handler in node.interrupts for name in surely_read(handler.condition)}
    flags = {name: c.code.variables.take() for name in sorted(names & assigned_names(node) - scope.locals.keys())}
    for register in flags.values():
        register_of(c.code, 0, register)
    scope.flags |= flags
    return flags


def surely_read(condition: ast.expr) -> set[str]:
    """Return the names in a condition; what stands behind an `or` might not be come to."""
    if any(isinstance(each, ast.Or | ast.IfExp) for each in ast.walk(condition)):
        return set()
    return {each.id for each in ast.walk(condition) if isinstance(each, ast.Name)}


@contextmanager
def once_set(c: Compilation, scope: CompiledScope, names: set[str]) -> Iterator[bool]:
    """Rows written inside, a condition, are only come to when these variables have a value; whether they may be."""
    unset = Label()
    before = dict(scope.locals)
    for name in sorted(names):
        c.code.row(op.JUMP_UNLESS, scope.flags[name], c=unset)
        c.types.read.add(scope.variables[name].key)  # also while nothing is known of it
        scope.locals[name] = scope.variables[name].load()
    yield all(scope.variables[name].place is not None for name in names)
    scope.locals.clear()
    scope.locals.update(before)
    c.code.put(unset)


def enter(c: Compilation, scope: CompiledScope, body: int, begin: Label, scan: Label) -> None:
    """Write rows that enter a statement, up to the scan itself; after time has passed invariants come first."""
    code, behavior = c.code, scope.inlined.behavior
    resumed = Label() if behavior is not None and behavior.node.invariants else scan
    code.row(op.SET_SLOT, body, c=begin)
    code.row(op.SET_SLOT, c.site.slot, c=resumed)
    if resumed is not scan:
        code.row(op.JUMP, c=scan)
        code.put(resumed)
        check_invariants(c, scope)
    code.put_loop(scan)


def limited(c: Compilation, scope: CompiledScope, over: Limit, run: Callable[[], None]) -> None:
    """Compile a body that ends when its limit says so: looked at before it begins and whenever it would be resumed."""
    code, begun = c.code, c.scenarios_begun()
    body = code.variables.take()
    begin, scan, end = Label(), Label(), Label()
    enter(c, scope, body, begin, scan)
    with code.statement():
        over(end)
    code.row(op.RESUME, body)
    code.put_reachable(begin)
    with scope.in_dynamic_branch(), c.at(slot=body, suspending=c.site.suspending + 1):
        run()
    code.put(end)
    c.stop_scenarios(begun)


def limit_of(c: Compilation, scope: CompiledScope, node: nodes.Do | nodes.Wait) -> Limit:
    """Return what writes rows that jump when a `do` or `wait` is over."""
    if node.until is not None:
        until = node.until
        return lambda end: jump_on(c, scope, until, end, when=True)
    assert node.duration is not None
    duration = needs_number(scope.value(node.duration), "a duration")
    code, time = c.code, c.time()
    start = code.variables.take(2)
    register_of(code, time, start)
    register_of(code, duration if node.unit == "steps" else duration / c.world.timestep, start + 1)

    def over(end: Label) -> None:
        passed = code.temporaries.take()
        code.row(op.SUBTRACT, passed, time.register, start)
        code.row(op.JUMP_LESS_EQUAL, start + 1, passed, end)

    return over


def abort(c: Compilation, scope: CompiledScope, node: nodes.Abort) -> None:
    c.code.row(op.JUMP, c=scope.inlined.aborts[-1])
