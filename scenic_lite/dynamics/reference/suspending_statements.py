"""The statements in which time may pass, as generators: control flow, `take`, `wait`, `terminate`.

Order of one `take`: its actions are evaluated from left to right, then checked by the world; when the thread is
resumed its invariants are checked before the next statement. The same after `wait`, `terminate` (a behavior whose own
scenario has ended may go on) and the end of a `do`. Read next: `dynamics.reference.interrupts`, then
`dynamics.reference.do_statement`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Generator, Iterator
from typing import Any

from scenic_lite.core.exceptions import fault_of
from scenic_lite.dynamics.reference.do_statement import do, wait
from scenic_lite.dynamics.reference.episode import settled
from scenic_lite.dynamics.reference.interrupts import abort, try_interrupt
from scenic_lite.dynamics.reference.threads import End, Step, Thread
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.assignments import unpack
from scenic_lite.evaluation.matching import chosen_case
from scenic_lite.evaluation.statements import Break, Continue, went_round
from scenic_lite.evaluation.trying import handler_for
from scenic_lite.syntax import nodes


def branch(thread: Thread, node: ast.If) -> Iterator[Step]:
    return thread.block(node.body if thread.scope.truth(node.test) else node.orelse)


def choose(thread: Thread, node: ast.Match) -> Iterator[Step]:
    return thread.block(chosen_case(thread.scope, node))


def repeat(thread: Thread, node: ast.For) -> Iterator[Step]:
    """`for`: over the elements that there are when the loop begins."""
    scope = thread.scope
    items = scope.value(node.iter)
    for element in scope.elements(items, node.iter):
        unpack(scope, node.target, element)
        if not (yield from one_round(thread, node.body)):
            return
        went_round(scope, items)
    yield from thread.block(node.orelse)


def repeat_while(thread: Thread, node: ast.While) -> Iterator[Step]:
    while thread.scope.truth(node.test):
        if not (yield from one_round(thread, node.body)):
            return
        thread.scope.mode.budget.round()
    yield from thread.block(node.orelse)


def one_round(thread: Thread, body: list[ast.stmt]) -> Generator[Step, None, bool]:
    """Run the body of a loop; whether the loop goes on."""
    try:
        yield from thread.block(body)
    except Continue:
        return True
    except Break:
        return False
    return True


def attempt(thread: Thread, node: ast.Try) -> Iterator[Step]:
    """`try` with any of `except`, `else`, `finally`."""
    return guarded(thread, node, thread.block(node.body))


def interruptible(thread: Thread, node: nodes.TryInterrupt) -> Iterator[Step]:
    """`try` with `interrupt when`, and with whatever else it has."""
    return guarded(thread, node, try_interrupt(thread, node))


def guarded(thread: Thread, node: ast.Try | nodes.TryInterrupt, body: Iterator[Step]) -> Iterator[Step]:
    """The body and what stands around it; a statement that is given up for good does not run its `finally`."""
    try:
        yield from excepting(thread, node, body)
    except GeneratorExit:
        raise
    except BaseException:
        yield from thread.block(node.finalbody)
        raise
    yield from thread.block(node.finalbody)


def excepting(thread: Thread, node: ast.Try | nodes.TryInterrupt, body: Iterator[Step]) -> Iterator[Step]:
    """The body with the `except` and `else` blocks of its statement."""
    scope = thread.scope
    try:
        yield from body
    except ScenicError as error:
        fault = fault_of(error)
        handler = None if fault is None else handler_for(scope, node, fault)
        if fault is None or handler is None:
            raise
        if handler.name is not None:
            scope.assign(handler.name, fault)
        rest = handling(thread, error, thread.block(handler.body))
    else:
        rest = thread.block(node.orelse)
    yield from rest


def handling(thread: Thread, error: ScenicError, block: Iterator[Step]) -> Iterator[Step]:
    """The block of an `except`, in which `raise` alone raises the error again."""
    handled = thread.scope.state.handled
    while True:
        handled.append(error)
        try:
            step = next(block)
        except StopIteration:
            return
        finally:
            handled.pop()
        yield step


def take(thread: Thread, node: nodes.Take) -> Iterator[Step]:
    """`take a, b`; a single tuple or list stands for its elements."""
    row = thread.episode.row
    actions = [settled(thread.scope.value(each), row) for each in node.actions]
    if len(actions) == 1 and isinstance(actions[0], list | tuple):
        actions = list(actions[0])
    assert thread.agent is not None, "the checker lets only behaviors take actions"
    yield tuple(thread.episode.world.command(each, thread.agent) for each in actions)
    thread.check_invariants()


def terminate(thread: Thread, node: nodes.Terminate) -> Iterator[Step]:
    """`terminate`, which in Scenic 2 always means the simulation."""
    extent = "simulation" if thread.episode.program.dialect == 2 else node.scope
    yield End(extent, "terminate" if node.scope == "scenario" else "terminate simulation", node.lineno)
    thread.check_invariants()


SUSPENDING: dict[type, Callable[[Thread, Any], Iterator[Step]]] = {
    ast.If: branch,
    ast.For: repeat,
    ast.While: repeat_while,
    ast.Try: attempt,
    ast.Match: choose,
    nodes.TryInterrupt: interruptible,
    nodes.Take: take,
    nodes.Wait: wait,
    nodes.Do: do,
    nodes.Terminate: terminate,
    nodes.Abort: abort,
}
