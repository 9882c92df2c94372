"""Conditions: jumps for `and`, `or`, `not` and comparisons, with Python's short circuit, and conditional values.

What need not be evaluated is not, so that a guard protects what stands behind it and no draw is made in vain. Read
next: `compiler_calls`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.choices import over_options, same_thing
from scenic_lite.dynamics.compiler.code import Label, Row
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, assigned_names
from scenic_lite.dynamics.compiler.emit import jump
from scenic_lite.dynamics.compiler.lists import contains
from scenic_lite.dynamics.compiler.registers import Slot, settled
from scenic_lite.dynamics.compiler.types import RegisterList
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.comparisons import compared
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import AND, NOT, NOT_EQUAL, OR


def jump_on(c: Compilation, scope: Scope, node: ast.expr, target: Label, when: bool) -> None:
    """Go to the target if the truth of an expression is `when`, else on."""
    if isinstance(node, ast.BoolOp):
        if isinstance(node.op, ast.And) != when:  # any operand decides
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
        jump(c.code, truth(scope.value(node)), target, when)


def truth(value: Value) -> Value:
    """The truth of a value, fixed or live."""
    if isinstance(value, RandomChoice):
        return choose(value.index, [truth(option) for option in value.options])
    if isinstance(value, RegisterList):
        return apply(NOT_EQUAL, value.length, 0, kind="truth")
    if isinstance(value, RandomExpr):
        return apply(NOT_EQUAL, value, "", kind="truth") if value.kind == "text" else value
    return bool(value)


def negation(c: Compilation, scope: Scope, node: ast.UnaryOp) -> Value:
    value = truth(scope.value(node.operand))
    return apply(NOT, value, kind="truth") if isinstance(value, RandomExpr) else not value


def boolean(c: Compilation, scope: Scope, node: ast.BoolOp) -> Value:
    """`and`, `or`: the operand that decides, or the last one."""
    is_and = isinstance(node.op, ast.And)
    value = scope.value(node.values[0])
    for i, operand in enumerate(node.values[1:]):
        known = truth(value)
        if not isinstance(known, RandomExpr):
            if known != is_and:
                return value
            value = scope.value(operand)
            continue
        with c.code.captured() as rows:
            other = scope.value(operand)
        if not rows and is_condition(value) and is_condition(other):
            value = apply(AND if is_and else OR, value, other, kind="truth")
        else:
            decided: Way = ([], value)
            yes, no = ((rows, other), decided) if is_and else (decided, (rows, other))
            value = either(c, known, yes, no, (id(node), i))
    return value


def is_condition(value: Value) -> bool:
    return isinstance(value, bool) or (isinstance(value, RandomExpr) and value.kind == "truth")


def conditional(c: Compilation, scope: Scope, node: ast.IfExp) -> Value:
    """`a if test else b`."""
    with c.code.captured() as test_rows:
        no = Label()
        jump_on(c, scope, node.test, no, when=False)
        reachable = c.code.reachable
    c.code.rows.extend(test_rows)
    c.code.known.clear()
    if not no.used:
        return scope.value(node.body)
    c.code.reachable = True
    if not reachable:
        c.code.put(no)
        return scope.value(node.orelse)
    with c.code.captured() as yes_rows:
        yes = scope.value(node.body)
    with c.code.captured() as no_rows:
        other = scope.value(node.orelse)
    return joined(c, no, (yes_rows, yes), (no_rows, other), id(node))


Way = tuple[list[Row], Value]  # a value, and the rows that compute it


def either(c: Compilation, test: Value, yes: Way, no: Way, key: object) -> Value:
    """yes if the test holds, else no; each with the rows that compute it."""
    otherwise = Label()
    test = settled(c.code, test)
    jump(c.code, test, otherwise, when=False)
    return joined(c, otherwise, yes, no, key)


def joined(c: Compilation, otherwise: Label, yes: Way, no: Way, key: object) -> Value:
    """The value after two ways: one that follows, one that begins at a label."""
    slot = Slot(c.code, c.shapes, (*c.path, "either", key))
    slot.widen(yes[1])
    slot.widen(no[1])
    end = Label()
    c.code.rows.extend(yes[0])
    slot.store(yes[1])
    c.code.row(op.JUMP, c=end)
    c.code.put(otherwise)
    c.code.rows.extend(no[0])
    slot.store(no[1])
    c.code.put(end)
    return slot.value


# ------------------------------------------------------------ comparisons


def comparison(c: Compilation, scope: Scope, node: ast.Compare) -> Value:
    """A chain of comparisons; what stands behind a link that fails is not evaluated."""
    left = settled(c.code, scope.value(node.left))
    result: Value = True
    for i, (sign, operand) in enumerate(zip(node.ops, node.comparators, strict=True)):
        with c.code.captured() as rows:
            right = settled(c.code, scope.value(operand))
            found = link(c, scope, node, sign, left, right)
        if result is True or not rows:
            c.code.rows.extend(rows)
            result = found if result is True else both(result, found)
        else:
            result = either(c, result, (rows, found), ([], False), (id(node), i))
        if result is False:
            return False
        left = right
    return result


def both(a: Value, b: Value) -> Value:
    if a is True or b is True:
        return b if a is True else a
    return False if b is False else apply(AND, a, b, kind="truth")


def link(c: Compilation, scope: Scope, node: ast.Compare, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """One comparison."""
    if isinstance(sign, ast.Is | ast.IsNot):
        same = same_thing(left, right)
        return same if isinstance(sign, ast.Is) else opposite(same)
    if isinstance(sign, ast.In | ast.NotIn):
        inside = contains(c, scope, node, right, left)
        return inside if isinstance(sign, ast.In) else opposite(inside)
    for side, remake in (
        (left, lambda each: link(c, scope, node, sign, each, right)),
        (right, lambda each: link(c, scope, node, sign, left, each)),
    ):
        if isinstance(side, RandomChoice):
            return over_options(c, side, remake, (id(node), id(sign)))
    if isinstance(left, RegisterList) or isinstance(right, RegisterList):
        raise ScenicError("unsupported", "lists whose length varies cannot be compared in a match")
    if type(left) is not type(right) and None in (left, right) and isinstance(sign, ast.Eq | ast.NotEq):
        return isinstance(sign, ast.NotEq)
    return compared(scope, node, sign, left, right)


def opposite(value: Value) -> Value:
    return apply(NOT, value, kind="truth") if isinstance(value, RandomExpr) else not value


def live_branch(
    c: Compilation,
    scope: CompiledScope,
    test: ast.expr,
    blocks: list[list[ast.stmt]],
    run: Callable[[Label, bool], None],
) -> None:
    """Evaluate a test; `run(no, live)` compiles what follows, where `no` is where control goes if it fails."""
    no = Label()
    with c.code.captured() as rows:
        jump_on(c, scope, test, no, when=False)
        reachable = c.code.reachable
    c.code.reachable = True
    live = no.used and reachable
    if live:
        scope.pin(assigned_names(*(each for block in blocks for each in block)))
    c.code.rows.extend(rows)
    c.code.reachable = reachable
    run(no, live)


def needs_number(value: Value, what: str) -> Value:
    if isinstance(value, RandomChoice | RegisterList) or not isinstance(value, int | float | RandomExpr):
        raise ScenicError("type", f"{what} is a number, not {describe_kind(value)}")
    return value
