"""`do` in all its forms, and `wait for`, `wait until`.

`do B(x)`: B and its arguments are evaluated, its preconditions and invariants are checked, then its body runs in place
until it ends; while it does, the invariants of the behavior that called it are not checked, but afterwards.
`for` and `until` are an interrupt around it that aborts: the condition is looked at before B is begun and whenever it
would be resumed. `do B() for n steps` takes n steps if B does; a duration in seconds is divided by the timestep.
`do choose` draws one of those whose guards hold now (nothing is drawn if there is only one), `do shuffle` goes on so
with the others; where none can be chosen the episode is rejected. `wait for` and `wait until` are a `do` of a behavior
that always waits. In a compose block the same is done with scenarios, which may be several at once (`scenarios`).
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from itertools import repeat

from scenic_lite.core.types import Behavior, BehaviorCall, describe_kind
from scenic_lite.dynamics.reference.episode import Rejected
from scenic_lite.dynamics.reference.interrupts import Aborted, Handler, interruptible
from scenic_lite.dynamics.reference.threads import Step, Thread
from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value, is_number

Weighted = list[tuple[BehaviorCall, float]]


def wait(thread: Thread, node: nodes.Wait) -> Iterator[Step]:
    if node.duration is None and node.until is None:
        yield ()
    else:
        yield from limited(thread, node, repeat(()))
    thread.check_invariants()


def do(thread: Thread, node: nodes.Do) -> Iterator[Step]:
    calls = calls_of(thread, node)
    if node.how == "choose":
        run = invoke(thread, [pick(thread, calls)], node)
    elif node.how == "shuffle":
        run = shuffled(thread, calls, node)
    else:
        run = invoke(thread, [call for call, _ in calls], node)
    if node.duration is not None or node.until is not None:
        run = limited(thread, node, run)
    yield from run
    thread.check_invariants()


def calls_of(thread: Thread, node: nodes.Do) -> Weighted:
    """Return what is to be done, each with its weight; `choose` and `shuffle` also take a dictionary of weights."""
    scope = thread.scope
    values = [scope.value(expression) for expression in node.calls]
    places: list[ast.expr] = list(node.calls)
    weights = [1.0] * len(values) if node.weights is None else [scope.value(expression) for expression in node.weights]
    if len(values) == 1 and isinstance(values[0], dict) and node.how != "all":
        values, weights = list(values[0]), list(values[0].values())
        places *= len(values)
    for weight in weights:
        if not is_number(weight) or weight < 0:
            raise scope.error("value", f"a weight is a number, and not negative: {weight!r}", node)
    calls = [called(thread, value, place) for value, place in zip(values, places, strict=True)]
    return list(zip(calls, weights, strict=True))


def called(thread: Thread, value: Value, place: ast.expr) -> BehaviorCall:
    kind = "scenario" if thread.call.behavior.kind == "scenario" else "behavior"
    if isinstance(value, BehaviorCall) and value.behavior.kind == kind:
        return value
    hint = f"write {value.name}()" if isinstance(value, Behavior) and value.kind == kind else ""
    what = describe_kind(value)
    if isinstance(value, BehaviorCall):
        what = f"the {value.behavior.kind} {value.behavior.name}"
    raise thread.scope.error("type", f"`do` needs a {kind}, not {what}", place, hint)


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


def shuffled(thread: Thread, calls: Weighted, node: nodes.Do) -> Iterator[Step]:
    left = list(calls)
    while left:
        call = pick(thread, left)
        left = [pair for pair in left if pair[0] is not call]
        yield from invoke(thread, [call], node)


def limited(thread: Thread, node: nodes.Do | nodes.Wait, body: Iterator[Step]) -> Iterator[Step]:
    """Run a body that ends when the time is over or the condition is true."""
    return interruptible(thread, body, [Handler(condition_of(thread, node), give_up)])


def give_up() -> Iterator[Step]:
    raise Aborted
    yield ()


def condition_of(thread: Thread, node: nodes.Do | nodes.Wait) -> Callable[[], bool]:
    """Return when to end; a duration is evaluated now, a condition each time."""
    if node.until is not None:
        condition = node.until
        return lambda: bool(thread.scope.truth(condition))
    assert node.duration is not None
    duration = thread.scope.value(node.duration)
    if not is_number(duration):
        raise thread.scope.error("type", f"a duration is a number, not {describe_kind(duration)}", node.duration)
    episode = thread.episode
    start, steps = episode.time, duration if node.unit == "steps" else duration / episode.timestep
    return lambda: episode.time - start >= steps


def invoke(thread: Thread, calls: list[BehaviorCall], node: nodes.Do) -> Iterator[Step]:
    """Run what is called in place."""
    try:
        yield from thread.invoked(calls)
    except ScenicError as error:
        raise thread.scope.placed(error, node) from None
