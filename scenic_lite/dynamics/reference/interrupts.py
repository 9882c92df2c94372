"""`try: ... interrupt when c: ...`, the heart of reactive behaviors.

The statement has a body and handlers h1 .. hk in the order of the text. Whenever it begins or is resumed:

1. the handlers are looked through from hk to h1: the first that is running, or whose condition is true now, is chosen;
   if there is none, the body. Nothing is looked at after that, nor is the condition of a handler that is running.
2. The chosen block is begun or resumed. If it lets time pass, that is the step of the whole statement; when it is
   resumed, the invariants of the thread are checked, then all begins with 1.
3. If a handler ends, all begins with 1 at once, in the same step. If the body ends, the statement ends.
4. `abort` in a handler ends the statement; `break`, `continue` and `return` in a block leave it for the loop or the
   behavior around the statement; errors go through it. All its other blocks are given up.

So outer statements decide before inner ones, and a handler is itself interrupted by those below it in the text. A
condition that cannot be computed because it names a variable of a scenario that has no value yet counts as false. Read
next: `dynamics.reference.do`, which is built on this.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from functools import partial
from typing import NamedTuple

from scenic_lite.core.types import BehaviorCall
from scenic_lite.dynamics.reference.episode import Rejected
from scenic_lite.dynamics.reference.threads import Step, Thread
from scenic_lite.errors import UnsetVariable
from scenic_lite.syntax import nodes

Steps = Iterator[Step]


class Aborted(Exception):
    """Ends the `try` statement around a handler."""


class Handler(NamedTuple):
    """When to interrupt, and by what."""

    condition: Callable[[], bool]
    block: Callable[[], Steps]


def try_interrupt(thread: Thread, node: nodes.TryInterrupt) -> Steps:
    """`try` with `interrupt when`."""
    handlers = [
        Handler(partial(condition_holds, thread, handler), partial(thread.block, handler.body))
        for handler in node.interrupts
    ]
    return interruptible(thread, thread.block(node.body), handlers)


def condition_holds(thread: Thread, node: nodes.Interrupt) -> bool:
    try:
        value = thread.scope.value(node.condition)
    except UnsetVariable:
        if thread.call.behavior.kind == "scenario":
            return False
        raise
    if isinstance(value, BehaviorCall):
        raise thread.scope.error("type", "a behavior cannot be called in a condition", node.condition)
    return thread.scope.certain_truth(value, node.condition)


def interruptible(thread: Thread, body: Steps, handlers: list[Handler]) -> Steps:
    """Run a body under the eyes of some handlers, of which the last comes first."""
    running: list[Steps | None] = [None] * len(handlers)
    try:
        yield from watched(thread, body, handlers, running)
    except Aborted:
        pass
    except Rejected:
        raise  # the episode is over, and with it all blocks
    except BaseException:
        close_all(body, *running)
        raise
    close_all(body, *running)


def watched(thread: Thread, body: Steps, handlers: list[Handler], running: list[Steps | None]) -> Steps:
    """As `interruptible`; `running` holds the blocks of the handlers that have begun and not ended."""
    while True:
        at = chosen(handlers, running)
        block = body if at is None else running[at] or handlers[at].block()
        try:
            step = next(block)
        except StopIteration:
            if at is None:
                return
            running[at] = None
            thread.episode.mode.budget.round()
            continue
        if at is not None:
            running[at] = block
        yield step
        thread.check_invariants()


def close_all(*blocks: Steps | None) -> None:
    """Give up some blocks for good."""
    for block in blocks:
        if isinstance(block, Generator):
            block.close()


def chosen(handlers: list[Handler], running: list[Steps | None]) -> int | None:
    """Return the index of the handler to run now, None for the body."""
    for at in reversed(range(len(handlers))):
        if running[at] is not None or handlers[at].condition():
            return at
    return None


def abort(thread: Thread, node: nodes.Abort) -> Steps:
    raise Aborted
    yield ()
