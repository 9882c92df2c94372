"""`try / interrupt`, `do ... until`, `do ... for`: blocks with a slot each, and a scan that chooses among them.

Every block has a slot: the row where it goes on, 0 while it is not running. Entering the statement clears the slots of
the handlers and lets the block around it go on at the scan, so that whenever time has passed the outermost scan runs
first. The scan asks the handlers from the last to the first: one that is running, or whose condition is true, goes on;
if there is none, the body. A handler that ends clears its slot and scans again in the same step. Read next:
`compiler_watchers`.
"""

from __future__ import annotations

from collections.abc import Callable

from scenic_lite.dynamics.bytecode import Op
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.conditions import jump_on
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.frame import Compilation, LiveFrame, assigned_names
from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes

Limit = Callable[[Label], None]  # rows that jump when it is over


def try_interrupt(c: Compilation, frame: LiveFrame, node: nodes.TryInterrupt) -> None:
    if node.handlers or node.orelse or node.finalbody:
        raise ScenicError("unsupported", "`except`, `else` and `finally` cannot be compiled for a match")
    frame.pin(assigned_names(node))
    code, written = c.code, c.written()
    body = code.variables.take(1 + len(node.interrupts))
    slots = [body + 1 + i for i in range(len(node.interrupts))]
    begin, scan, end = Label(), Label(), Label()
    starts = [Label() for _ in slots]
    for slot in slots:
        register_of(code, 0, slot)
    enter(c, frame, body, begin, scan)
    for slot, handler, start in reversed(list(zip(slots, node.interrupts, starts, strict=True))):
        code.row(Op.RESUME_IF_RUNNING, slot)
        with code.statement():
            code.place = frame.place(handler.condition)
            jump_on(c, frame, handler.condition, start, when=True)
    code.row(Op.RESUME, body)
    with frame.living(), c.guarded():
        code.put(begin)
        begin.used = code.reachable = True
        with c.block(body):
            frame.run(node.body)
        code.row(Op.JUMP, c=end)
        for slot, handler, start in zip(slots, node.interrupts, starts, strict=True):
            code.put(start)
            frame.scope.aborts.append(end)
            with c.block(slot), c.repeated():
                frame.run(handler.body)
            frame.scope.aborts.pop()
            register_of(code, 0, slot)
            code.row(Op.AGAIN, c=scan)
    code.put(end)
    c.give_up(written)


def enter(c: Compilation, frame: LiveFrame, body: int, begin: Label, scan: Label) -> None:
    """Rows that enter a statement with a scan, up to the scan itself; after time has passed invariants come first."""
    from scenic_lite.dynamics.compiler.behaviors import check_invariants

    code = c.code
    behavior = frame.scope.behavior
    resumed = Label() if behavior is not None and behavior.node.invariants else scan
    code.row(Op.SET_SLOT, body, c=begin)
    code.row(Op.SET_SLOT, c.slot, c=resumed)
    if resumed is not scan:
        code.row(Op.JUMP, c=scan)
        code.put(resumed)
        check_invariants(c, frame)
    code.put_loop(scan)


def limited(c: Compilation, frame: LiveFrame, over: Limit, run: Callable[[], None]) -> None:
    """A body that ends when its limit says so, looked at before it is begun and whenever it would be resumed."""
    code, written = c.code, c.written()
    body = code.variables.take()
    begin, scan, end = Label(), Label(), Label()
    enter(c, frame, body, begin, scan)
    with code.statement():
        over(end)
    code.row(Op.RESUME, body)
    code.put(begin)
    begin.used = code.reachable = True
    with frame.living(), c.guarded(), c.block(body):
        run()
    code.put(end)
    c.give_up(written)


def abort(c: Compilation, frame: LiveFrame, node: nodes.Abort) -> None:
    c.code.row(Op.JUMP, c=frame.scope.aborts[-1])
