"""Scenic's statements `take`, `wait`, `do`, `terminate` and `require`; threads contain their behaviors inline.

The reference interpreter defines the meaning of each statement, and the evaluation order of its parts. Read next:
`dynamics.compiler.compile`, which compiles behaviors to threads.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from contextlib import nullcontext
from functools import partial
from typing import Any

from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice
from scenic_lite.core.world import packed
from scenic_lite.dynamics.compiler import interrupts
from scenic_lite.dynamics.compiler.choices import jump_on, over_options
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.lists import by_length, is_list
from scenic_lite.dynamics.compiler.registers import store_in_register
from scenic_lite.dynamics.compiler.scenarios import require_later, run_scenarios
from scenic_lite.dynamics.compiler.types import RegisterList
from scenic_lite.dynamics.compiler.watchers import in_registers
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import COMPLETE, MESSAGE_SLOT
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.calls import named_by_do, refuse_as_action
from scenic_lite.language.requirements import is_temporal, probability_of, source_text
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import RandomExpr, Value

Called = tuple[BehaviorCall, Value]  # a call with its weight


def take(c: Compilation, scope: CompiledScope, node: nodes.Take) -> None:
    """Compile `take a, b`; a single tuple or list is replaced by its elements."""
    actions, on = [scope.value(action) for action in node.actions], Label()
    several = actions[0] if len(actions) == 1 and is_list(actions[0], any) else actions
    number = register_of(c.code, command(c, several))
    c.code.row(op.TAKE, number, c.site.slot, on)
    c.code.put(on)
    interrupts.check_invariants(c, scope)


def command(c: Compilation, actions: Value) -> Value:
    """Return the number of a command: its packed actions, or its index in the list of commands; -1 without actions."""
    if isinstance(actions, RegisterList):
        actions = by_length(actions)
    if isinstance(actions, RandomChoice):
        return over_options(c, actions, partial(command, c))
    actions = tuple(checked(c, action) for action in (actions if isinstance(actions, list | tuple) else [actions]))
    remember(c, actions)
    if not actions:
        return -1
    if c.world.actions is not None:
        return packed(actions, c.world.actions)
    c.output.commands.append(tuple(in_registers(c, store_in_register(c.code, action)) for action in actions))
    return len(c.output.commands) - 1


def checked(c: Compilation, action: Value) -> Value:
    """Return an action in the world's format; the code faults on an invalid action."""
    if isinstance(action, RandomChoice):
        return over_options(c, action, partial(checked, c))
    assert c.site.agent is not None, "the checker lets only behaviors take actions"
    refuse_as_action(action)
    action = c.world.command(action, c.site.agent)
    if c.world.actions is not None and isinstance(action, RandomExpr):
        register, known = register_of(c.code, action), c.code.temporaries.take()
        c.code.row(op.IS_INDEX, known, register, c.code.constant(c.world.actions))
        c.code.fault_unless(known, c.world.no_action(MESSAGE_SLOT), register)
    return action


def wait(c: Compilation, scope: CompiledScope, node: nodes.Wait) -> None:
    if node.duration is None and node.until is None:
        interrupts.pause(c)
    else:
        interrupts.limited(c, scope, node, partial(idle, c))
    interrupts.check_invariants(c, scope)


def idle(c: Compilation) -> None:
    """Let time pass until another statement ends the block."""
    again = Label()
    c.code.put_loop(again)
    interrupts.suspend(c, again)


def terminate(c: Compilation, scope: CompiledScope, node: nodes.Terminate) -> None:
    """Compile `terminate`, which ends a scenario or the match; in Scenic 2 always the match."""
    word = "terminate simulation" if node.scope == "simulation" else "terminate"
    statement = f'"{word}" executed on line {node.lineno}'
    whole = node.scope == "simulation" or c.program.dialect == 2
    part, code = c.site.part, c.code
    if part is not None and c.site.composing:
        if whole or part.parent is None:
            register_of(code, RegisterValue(c.reason(f"scenarioComplete: {statement}")), COMPLETE)
        code.row(op.JUMP, c=part.kill if whole else part.over)
        return
    who, on, less = "Monitor" if c.site.agent is None else "Behavior", Label(), Label()
    if part is not None and c.site.agent is None and whole:
        register_of(code, 1, part.halted)
    elif part is not None and c.site.agent is None:
        code.row(op.JUMP_IF, part.halted, c=less)
    code.row(op.TERMINATE, c.reason(f"terminatedBy{who}: {statement}"), c.site.slot, on)
    code.put(less)
    interrupts.suspend(c, on)
    code.put(on)
    interrupts.check_invariants(c, scope)


def require(c: Compilation, scope: CompiledScope, node: nodes.Require) -> None:
    """Compile `require[p] condition` in a behavior or monitor: reject the match if the condition is now false."""
    if is_temporal(node.condition):
        require_later(c, scope, node)
        return
    fine = Label()
    probability = probability_of(scope, node)
    if probability < 1:
        mark = c.code.temporaries.take()
        c.code.row(op.DRAW, mark, c.code.constant(0), c.code.constant(1))
        c.code.row(op.JUMP_LESS, c.code.constant(probability), mark, fine)
    jump_on(c, scope, node.condition, fine, when=True)
    c.reject(node.name or source_text(scope, node))
    c.code.put(fine)


# ------------------------------------------------------------ the objects' last actions

LATELY = {2: "(actions of this step)", 3: "lastActions"}


def remember(c: Compilation, actions: tuple[Value, ...]) -> None:
    """Record the actions of the present object, if the program reads `lastActions`."""
    if c.remembering:
        assert c.site.agent is not None
        c.keep(("object", c.site.agent.label, LATELY[c.program.dialect]), actions)


def renew(c: Compilation, agents: list[Instance]) -> None:
    """Clear the actions of all objects at the start of a step; dialect 2 publishes and clears them at its end."""
    for agent in agents:
        lately = ("object", agent.label, LATELY[c.program.dialect])
        if c.program.dialect == 2:
            c.keep(("object", agent.label, "lastActions"), c.shared_variable(lately).load() or ())
        c.keep(lately, ())


# ------------------------------------------------------------ nested behaviors
def run_behavior(c: Compilation, call: BehaviorCall, node: ast.AST, guards: bool = True) -> None:
    """Write an inlined behavior: its guards, then its body."""
    with c.entered(call.behavior, node, call.place):
        scope = interrupts.frame_of(c, call)
        if guards:
            interrupts.check_guards(c, scope)
        scope.run(call.behavior.node.body)  # type: ignore[union-attr]
        c.code.put(scope.inlined.end)


def do(c: Compilation, scope: CompiledScope, node: nodes.Do) -> None:
    named = named_by_do(scope, node, "scenario" if c.site.composing else "behavior")
    calls = [(store_in_register(c.code, call), store_in_register(c.code, weight)) for call, weight in named]
    if node.how == "choose":
        chosen = pick(c, calls, node)  # before any condition is evaluated
        run = partial(run_one_of, c, [call for call, _ in calls], node, chosen)
    elif node.how == "shuffle":
        run = partial(shuffle, c, calls, node)
    else:
        run = partial(run_called, c, [call for call, _ in calls], node)
    if node.duration is not None or node.until is not None:
        interrupts.limited(c, scope, node, run)
    else:
        run()
    interrupts.check_invariants(c, scope)


def run_called(c: Compilation, calls: list[Value], node: nodes.Do) -> None:
    """Run a behavior, possibly chosen by the match; in a compose block, run scenarios."""
    if c.site.composing:
        run_scenarios(c, calls, node)
    elif isinstance(calls[0], BehaviorCall):
        run_behavior(c, calls[0], node)
    else:
        run_one_of(c, calls[0].options, node, register_of(c.code, calls[0].index))


def run_one_of(c: Compilation, calls: Iterable[Value], node: nodes.Do, chosen: int) -> None:
    """Run one of several calls, with its number in a register."""

    def run(number: int, call: Value) -> None:
        with c.round(node, number):
            run_called(c, [call], node)

    c.code.dispatch(chosen, {i: partial(run, i, call) for i, call in enumerate(calls)})


# ------------------------------------------------------------ one of several
def shuffle(c: Compilation, calls: list[Called], node: nodes.Do) -> None:
    """Compile `do shuffle`: repeatedly choose one of the remaining calls."""
    code = c.code
    left = code.variables.take(len(calls))
    for i in range(len(calls)):
        register_of(code, 1, left + i)
    with code.rounds(code.constant(len(calls))):
        chosen = pick(c, calls, node, left)
        code.row(op.STORE, left, chosen, code.constant(0))
        run_one_of(c, [call for call, _ in calls], node, chosen)


def pick(c: Compilation, calls: list[Called], node: nodes.Do, left: int | None = None) -> int:
    """Return a register with the number of a call, drawn by weight among remaining calls whose guards hold now."""
    able = c.code.variables.take(len(calls))
    for i, (call, _) in enumerate(calls):
        register_of(c.code, 0, able + i)
        with nullcontext() if left is None else c.code.when(left + i):
            can_start(c, call, node, i, able + i)
    return drawn(c, [weight for _, weight in calls], able)


def can_start(c: Compilation, call: Value, node: nodes.Do, number: int, able: int) -> None:
    """Put 1 into a register if the guards of a behavior hold now."""
    if not isinstance(call, BehaviorCall):
        raise ScenicError("unsupported", "`do choose` and `do shuffle` of a random behavior")
    fails = Label()
    with c.round(node, -1 - number), c.entered(call.behavior, node, call.place):
        scope = interrupts.frame_of(c, call)
        for condition in [*call.behavior.node.preconditions, *call.behavior.node.invariants]:
            jump_on(c, scope, condition, fails, when=False)
        register_of(c.code, 1, able)
    c.code.put(fails)


def drawn(c: Compilation, weights: list[Value], able: int) -> int:
    """Return a register with the index of an enabled call, drawn by weight; a single enabled call needs no draw."""
    code = c.code
    total, count, mark, share = (code.temporaries.take() for _ in range(4))
    chosen = code.variables.take()
    for register in (total, count, mark):
        register_of(code, 0, register)
    for i, weight in enumerate(weights):
        code.row(op.MULTIPLY, share, register_of(code, weight), able + i)
        code.row(op.ADD, total, total, share)
        code.row(op.ADD, count, count, able + i)
    some, certain, end = Label(), Label(), Label()
    code.row(op.JUMP_IF, count, c=some)
    c.reject('deadlock in "do choose/shuffle"')
    code.put(some)
    code.row(op.JUMP_EQUAL, count, code.constant(1), certain)
    code.row(op.DRAW, mark, code.constant(0), total)
    code.put(certain)
    for i, weight in enumerate(weights):
        with code.when(able + i):
            register_of(code, i, chosen)  # the last enabled call, in case of rounding errors
            code.row(op.SUBTRACT, mark, mark, register_of(code, weight))
            code.row(op.JUMP_LESS, mark, code.constant(0), end)
    code.put(end)
    return chosen


DYNAMIC: dict[type, Callable[[Compilation, CompiledScope, Any], None]] = {
    nodes.Take: take,
    nodes.Wait: wait,
    nodes.Terminate: terminate,
    nodes.Require: require,
    nodes.Do: do,
    nodes.TryInterrupt: interrupts.try_interrupt,
    nodes.Abort: interrupts.abort,
}
