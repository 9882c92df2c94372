"""Choices, that is, values with several options: an object or None, a player found in a loop, one of two texts.

An operation on a choice applies to each option. If an option needs code, the code is behind jumps, so that a match only
computes the actual option. If the operation fails for some options (None has no position), a match with one of these
options stops at the program's line. This module also compiles conditions with short circuits: a guard protects the
operands after it, and unused operands draw nothing. Read next: `dynamics.compiler.lists`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from scenic_lite.core.checks import FAULTS, as_error
from scenic_lite.core.scope import Scope, no_condition
from scenic_lite.core.types import BehaviorCall, Function, RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.code import Label, Row
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import is_live, jump, register_of
from scenic_lite.dynamics.compiler.registers import Place, materialize, place_for, renumbered
from scenic_lite.dynamics.compiler.types import RegisterList, flatten
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import AND, EQUAL, NOT, NOT_EQUAL, OR

Computed = tuple[list[Row], Value]  # (the rows that compute a value, the value)


def over_options(c: Compilation, choice: RandomChoice, of_one: Callable[[Value], Value]) -> Value:
    """Return `of_one` of the actual option. Raises the first option's error if `of_one` fails for all options."""
    computed: dict[int, Computed] = {}
    failed: dict[int, ScenicError] = {}
    for i, option in enumerate(choice.options):
        with c.code.captured() as rows:
            try:
                computed[i] = rows, of_one(option)
            except FAULTS as fault:
                failed[i] = as_error(fault)
    if not computed:
        raise failed[0]
    for i, failure in failed.items():
        if failure.kind == "rejection":
            with c.code.when(register_of(c.code, apply(EQUAL, choice.index, i))):
                c.reject(failure.message)
            continue
        differs = apply(NOT_EQUAL, choice.index, i)
        c.code.fault_unless(register_of(c.code, differs), failure.message)
    some = next(iter(computed.values()))
    if all(not rows and costs_nothing(value) for rows, value in computed.values()):
        return choose(choice.index, [computed.get(i, some)[1] for i in range(len(choice.options))])
    return switch(c, choice, computed)


def costs_nothing(value: Value) -> bool:
    """Return whether a value needs no code."""
    if isinstance(value, RegisterValue) or not isinstance(value, RandomExpr | RandomChoice):
        apart = None if isinstance(value, RegisterValue) else flatten(value)
        return apart is None or all(map(costs_nothing, apart[1]))
    if isinstance(value, RandomChoice):
        return costs_nothing(value.index) and all(map(costs_nothing, value.options))
    return not is_live(value)


def switch(c: Compilation, choice: RandomChoice, results: dict[int, Computed]) -> Value:
    """Write the rows of all results behind jumps, so that only the actual option is computed."""
    place = place_for(c.code, [value for _, value in results.values()])
    cases = {i: partial(compute_into, c, place, computed) for i, computed in results.items()}
    c.code.dispatch(register_of(c.code, choice.index), cases)
    return place.load()


def compute_into(c: Compilation, place: Place, computed: Computed) -> None:
    rows, value = computed
    c.code.rows.extend(rows)
    place.store(value)


def whole_choice(value: Value, c: Compilation) -> Value:
    """Return a choice without the option None; a match in which the value is None faults."""
    if not isinstance(value, RandomChoice) or value.options[-1] is not None:
        return value
    there = apply(NOT_EQUAL, value.index, len(value.options) - 1)
    c.code.fault_unless(register_of(c.code, there), "None is not an object, a number or a vector")
    options = value.options[:-1]
    return options[0] if len(options) == 1 else choose(value.index, options)


# ------------------------------------------------------------ conditions
def truth(value: Value) -> Value:
    """Return the truth of a fixed or live value."""
    if isinstance(value, RandomChoice):
        return choose(value.index, [truth(option) for option in value.options])
    if isinstance(value, RegisterList):
        return apply(NOT_EQUAL, value.length, 0)
    if isinstance(value, RandomExpr):
        return apply(NOT_EQUAL, value, "") if value.kind == "text" else value
    return bool(value)


def opposite(value: Value) -> Value:
    return apply(NOT, value) if isinstance(value, RandomExpr) else not value


def jump_on(c: Compilation, scope: Scope, node: ast.expr, target: Label, when: bool) -> None:
    """Jump to the target if the truth of an expression is `when`; otherwise continue."""
    if isinstance(node, ast.BoolOp):
        if isinstance(node.op, ast.And) != when:  # every operand can decide the jump
            for operand in node.values:
                jump_on(c, scope, operand, target, when)
            return
        on = Label()
        for operand in node.values[:-1]:
            jump_on(c, scope, operand, on, not when)
        jump_on(c, scope, node.values[-1], target, when)
        c.code.put(on)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        jump_on(c, scope, node.operand, target, not when)
    elif c.code.reachable:
        value = scope.value(node)
        if isinstance(value, BehaviorCall):
            error = no_condition(scope, node)
            c.output.diagnostics.append(error)
            c.stop_with(error)
        else:
            jump(c.code, truth(value), target, when)


@contextmanager
def branch(c: Compilation, scope: Scope, condition: ast.expr, when: bool = True) -> Iterator[None]:
    """Execute the rows written inside the context only if the truth of a condition is `when`."""
    otherwise = Label()
    jump_on(c, scope, condition, otherwise, not when)
    yield
    c.code.put(otherwise)


def boolean(c: Compilation, scope: Scope, node: ast.BoolOp) -> Value:
    """Return the value of `and` or `or`: the first deciding operand, or the last operand."""
    return in_turn(c, isinstance(node.op, ast.And), [partial(scope.value, operand) for operand in node.values])


def in_turn(c: Compilation, is_and: bool, operands: list[Callable[[], Value]]) -> Value:
    """Return the first deciding operand, or the last operand; operands after it are not evaluated."""
    value = operands[0]()
    for evaluate in operands[1:]:
        known = truth(value)
        if not isinstance(known, RandomExpr):
            if known != is_and:
                return value
            value = evaluate()
            continue
        with c.code.captured() as rows:
            other = evaluate()
        if not rows and is_condition(value) and is_condition(other):
            value = value if other is is_and else apply(AND if is_and else OR, value, other)
        else:
            yes, no = ((rows, other), ([], value)) if is_and else (([], value), (rows, other))
            value = either(c, known, yes, no)
    return value


def is_condition(value: Value) -> bool:
    return isinstance(value, bool) or (isinstance(value, RandomExpr) and value.kind == "truth")


def conditional(c: Compilation, scope: Scope, node: ast.IfExp) -> Value:
    """Return the value of `a if test else b`."""
    test = truth(scope.value(node.test))
    if not isinstance(test, RandomExpr):
        return scope.value(node.body if test else node.orelse)
    test = materialize(c.code, test)
    with c.code.captured() as yes_rows:
        yes = scope.value(node.body)
    with c.code.captured() as no_rows:
        no = scope.value(node.orelse)
    return either(c, test, (yes_rows, yes), (no_rows, no))


def either(c: Compilation, test: Value, yes: Computed, no: Computed) -> Value:
    """Return `yes` if the test holds, otherwise `no`; execute only the rows of the returned value."""
    otherwise, end = Label(), Label()
    jump(c.code, materialize(c.code, test), otherwise, when=False)
    place = place_for(c.code, [yes[1], no[1]])
    compute_into(c, place, yes)
    c.code.row(op.JUMP, c=end)
    c.code.put(otherwise)
    compute_into(c, place, no)
    c.code.put(end)
    return place.load()


# ------------------------------------------------------------ comparisons of two values
def same_thing(left: Value, right: Value) -> Value:
    """Return whether `left is right`."""
    if isinstance(left, RandomChoice) and isinstance(right, RandomChoice):
        things = list({id(option): option for option in (*left.options, *right.options)}.values())
        if not any(isinstance(thing, RandomExpr | str | int | float) for thing in things):
            first, second = numbered(left, things), numbered(right, things)
            return apply(EQUAL, first, second)
    if isinstance(left, RandomChoice):
        return choose(left.index, [same_thing(option, right) for option in left.options])
    if isinstance(right, RandomChoice):
        return choose(right.index, [same_thing(left, option) for option in right.options])
    live = isinstance(left, RandomExpr) or isinstance(right, RandomExpr)
    if live and all(isinstance(side, RandomExpr | bool | int | float | str) for side in (left, right)):
        return apply(EQUAL, left, right)
    if isinstance(left, Function) and isinstance(right, Function):
        return left.body is right.body
    return left is right


def numbered(choice: RandomChoice, things: list[Value]) -> Value:
    """Return the index of the chosen option in `things`."""
    places = [next(i for i, thing in enumerate(things) if thing is option) for option in choice.options]
    return renumbered(choice.index, places)


def in_steps(c: Compilation, duration: Value, unit: str | None) -> Value:
    """Convert a duration in steps or in seconds to a number of steps."""
    if isinstance(duration, RandomChoice | RegisterList) or not isinstance(duration, int | float | RandomExpr):
        raise ScenicError("type", f"a duration is a number, not {describe_kind(duration)}")
    return duration if unit == "steps" else duration / c.world.timestep
