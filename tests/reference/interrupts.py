"""`try: ... interrupt when c: ...`, the heart of reactive behaviors, and `do`, which is built on it.

The statement has a body and handlers h1 .. hk in the order of the text. Whenever it begins or is resumed:

1. the handlers are looked through from hk to h1: the first that is running, or whose condition is true now, is chosen;
   if there is none, the body. Nothing is looked at after that, nor is the condition of a handler that is running.
2. The chosen block is begun or resumed. If it lets time pass, that is the step of the whole statement; when it is
   resumed, the invariants of the thread are checked, then all begins with 1.
3. If a handler ends, all begins with 1 at once, in the same step. If the body ends, the statement ends.
4. `abort` in a handler ends the statement; `break`, `continue` and `return` in a block leave it for the loop or the
   behavior around the statement; errors go through it. All its other blocks are given up.

So outer statements decide before inner ones, and a handler is itself interrupted by those below it in the text. A
condition that cannot be computed because it names a variable of a scenario that has no value yet counts as false.

`do B(x)`: B and its arguments are evaluated, its preconditions and invariants are checked, then its body runs in place
until it ends; while it does, the invariants of the behavior that called it are not checked, but afterwards.
`for` and `until` are an interrupt around it that aborts: the condition is looked at before B is begun and whenever it
would be resumed. `do B() for n steps` takes n steps if B does; a duration in seconds is divided by the timestep.
`do choose` draws one of those whose guards hold now (nothing is drawn if there is only one), `do shuffle` goes on so
with the others; where none can be chosen the episode is rejected. `wait for` and `wait until` are a `do` of a behavior
that always waits. In a compose block the same is done with scenarios, which may be several at once. Read next:
`dynamics.reference.scenarios`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from functools import partial
from itertools import repeat
from typing import NamedTuple

from scenic_lite.core.types import BehaviorCall
from scenic_lite.errors import UnsetVariable
from scenic_lite.evaluation.calls import named_by_do
from scenic_lite.syntax import nodes
from tests.reference.episode import Rejected
from tests.reference.threads import Step, Thread

Steps = Iterator[Step]
Weighted = list[tuple[BehaviorCall, float]]


class Aborted(Exception):
    """Ends the `try` statement around a handler."""


class Handler(NamedTuple):
    """When to interrupt, and by what."""

    condition: Callable[[], bool]
    block: Callable[[], Steps]


def try_interrupt(thread: Thread, node: nodes.TryInterrupt) -> Steps:
    """Run `try` with `interrupt when`."""
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
    return thread.scope.certain_truth(value, node.condition)


def interruptible(thread: Thread, body: Steps, handlers: list[Handler]) -> Steps:
    """Run a body under the eyes of some handlers, of which the last comes first."""
    running: list[Steps | None] = [body, *(None for _ in handlers)]  # each block that has begun and not ended
    try:
        while True:
            order = range(len(handlers), 0, -1)
            at = next((k for k in order if running[k] is not None or handlers[k - 1].condition()), 0)
            block = running[at] = running[at] or handlers[at - 1].block()
            try:
                step = next(block)
            except StopIteration:
                if block is body:
                    return
                running[at] = None
                thread.episode.mode.budget.round()
            else:
                yield step
                thread.check_invariants()
    except Aborted:
        return
    except Rejected:
        running = []  # the episode is over, and with it all blocks
        raise
    finally:
        for given_up in running:
            if isinstance(given_up, Generator):
                given_up.close()


def abort(thread: Thread, node: nodes.Abort | nodes.Do | nodes.Wait) -> Steps:
    raise Aborted
    yield ()


# ------------------------------------------------------------ do, wait
def wait(thread: Thread, node: nodes.Wait) -> Steps:
    return iter([()]) if node.duration is None and node.until is None else limited(thread, node, repeat(()))


def do(thread: Thread, node: nodes.Do) -> Steps:
    kind = "scenario" if thread.call.behavior.kind == "scenario" else "behavior"
    calls = named_by_do(thread.scope, node, kind)
    if node.how == "choose":
        run = thread.invoked([pick(thread, calls)])
    elif node.how == "shuffle":
        run = shuffled(thread, calls)
    else:
        run = thread.invoked([call for call, _ in calls])
    return run if node.duration is None and node.until is None else limited(thread, node, run)


def pick(thread: Thread, calls: Weighted) -> BehaviorCall:
    """Return one of those that can start now, by weight. Raises Rejected if none can."""
    able = [(call, weight) for call, weight in calls if thread.can_start(call)]
    if not able:
        raise Rejected('deadlock in "do choose/shuffle"')
    if len(able) == 1:
        return able[0][0]
    mark = thread.episode.uniform() * sum(weight for _, weight in able)
    for call, weight in able:
        mark -= weight
        if mark < 0:
            return call
    return able[-1][0]


def shuffled(thread: Thread, calls: Weighted) -> Steps:
    left = list(calls)
    while left:
        call = pick(thread, left)
        left = [pair for pair in left if pair[0] is not call]
        yield from thread.invoked([call])


def limited(thread: Thread, node: nodes.Do | nodes.Wait, body: Steps) -> Steps:
    """Run a body that is aborted when the time is over or the condition is true."""
    return interruptible(thread, body, [Handler(end_of(thread, node), partial(abort, thread, node))])


def end_of(thread: Thread, node: nodes.Do | nodes.Wait) -> Callable[[], bool]:
    """Return when to end; a duration is evaluated now, a condition each time."""
    if node.until is not None:
        condition = node.until
        return lambda: thread.scope.truth(condition)
    assert node.duration is not None
    episode, duration = thread.episode, thread.scope.value(node.duration)
    start, steps = episode.time, episode.in_steps(duration, thread.scope, node.duration, node.unit)
    return lambda: episode.time - start >= steps
