"""Values that are one of several things: an object or None, a player found in a loop, one of two texts.

What is done to them is done to each of the things: at once if that costs nothing, else behind jumps, so that only what
is really there is computed. Where it cannot be done to some of them (None has no position) the match stops with the
program's line if one of those is met. Read next: `dynamics.compiler.conditions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import PYTHON_FAULTS, Scope, from_python
from scenic_lite.core.types import Function, RandomChoice, choose
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import is_live, register_of
from scenic_lite.dynamics.compiler.registers import Slot
from scenic_lite.dynamics.compiler.types import RegisterList, flatten, unflatten
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.expressions import combined, item_of, signed
from scenic_lite.evaluation.strings import text_of
from scenic_lite.language.scenic_operators import OPERATORS
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, apply
from scenic_lite.values.operations import EQUAL, NOT_EQUAL

MADE = Callable[[Value], Value]


def over_options(c: Compilation, choice: RandomChoice, of_one: MADE, key: object) -> Value:
    """`of_one` of whichever option it is in the match. Raises its error if it fails for all."""
    results: list[tuple[list, Value]] = []
    errors: list[ScenicError | None] = []
    for option in choice.options:
        with c.code.captured() as rows:
            try:
                results.append((rows, of_one(option)))
                errors.append(None)
            except (ScenicError, *PYTHON_FAULTS) as error:
                results.append(([], None))
                errors.append(error if isinstance(error, ScenicError) else from_python(error))
    if all(errors):
        assert errors[0] is not None
        raise errors[0]
    refuse(c, choice, errors)
    good = next(i for i, error in enumerate(errors) if error is None)
    free = all(not rows and costs_nothing(value) for rows, value in results)
    filled = [results[good][1] if errors[i] else each for i, (_, each) in enumerate(results)]
    if free:
        return choose(choice.index, filled)
    if not any(rows for rows, _ in results):
        same = aligned(choice.index, filled)
        if same is not None:
            return same
    return switch(c, choice, [None if errors[i] else each for i, each in enumerate(results)], key)


def aligned(index: Value, values: list[Value]) -> Value:
    """values[index] where all are the same computation on other numbers: the numbers are chosen, then computed with.

    None if they are not, or are something that is None.
    """
    first = values[0]
    if all(map(costs_nothing, values)):
        return choose(index, values)
    if all(isinstance(each, RandomExpr) and not isinstance(each, RegisterValue | ThetaColumn) for each in values):
        if any(each.operation is not first.operation or each.kind != first.kind for each in values):
            return None
        inputs = columns(index, [list(each.inputs) for each in values])
        return None if inputs is None else RandomExpr(first.operation, tuple(inputs), first.kind)
    apart = [None if isinstance(each, RandomExpr | RandomChoice) else flatten(each) for each in values]
    if apart[0] is None or any(each is None or each[0] != apart[0][0] for each in apart):
        return None
    parts = columns(index, [each[1] for each in apart if each is not None])
    return None if parts is None else unflatten(apart[0][0], parts)


def columns(index: Value, rows: list[list[Value]]) -> list[Value] | None:
    """One of several rows, item by item."""
    if any(len(row) != len(rows[0]) for row in rows):
        return None
    found = [aligned(index, list(column)) for column in zip(*rows, strict=True)]
    return None if any(each is None for each in found) else found


def refuse(c: Compilation, choice: RandomChoice, errors: list[ScenicError | None]) -> None:
    """A fault if the match meets an option for which there is an error."""
    for i, error in enumerate(errors):
        if error is not None:
            differs = apply(NOT_EQUAL, choice.index, i, kind="truth")
            c.code.fault_unless(register_of(c.code, differs), error.message)


def costs_nothing(value: Value) -> bool:
    """Whether a value needs no computing."""
    if isinstance(value, RegisterValue) or not isinstance(value, RandomExpr | RandomChoice):
        apart = None if isinstance(value, RegisterValue) else flatten(value)
        return apart is None or all(map(costs_nothing, apart[1]))
    if isinstance(value, RandomChoice):
        return costs_nothing(value.index) and all(map(costs_nothing, value.options))
    return not is_live(value)


def switch(c: Compilation, choice: RandomChoice, results: list[tuple[list, Value] | None], key: object) -> Value:
    """Rows that compute what belongs to the option that is met, and nothing else."""
    code = c.code
    slot = Slot(code, c.shapes, (*c.path, "switch", key))
    for each in results:
        if each is not None:
            slot.widen(each[1])
    end = Label()
    index = register_of(code, choice.index)
    for i, each in enumerate(results):
        if each is None:
            continue
        following = Label()
        code.row(op.JUMP_NOT_EQUAL, index, code.constant(i), following)
        code.rows.extend(each[0])
        slot.store(each[1])
        code.row(op.JUMP, c=end)
        code.put(following)
    code.put(end)
    return slot.value


def whole_choice(value: Value, c: Compilation) -> Value:
    """A choice without None: a fault if it is None in the match."""
    if not isinstance(value, RandomChoice) or value.options[-1] is not None:
        return value
    there = apply(NOT_EQUAL, value.index, len(value.options) - 1, kind="truth")
    c.code.fault_unless(register_of(c.code, there), "None is no object, number or vector")
    options = value.options[:-1]
    return options[0] if len(options) == 1 else choose(value.index, options)


# ------------------------------------------------------------ expressions over choices


def attribute_of(c: Compilation, scope: Scope, node: ast.Attribute) -> Value:
    return attribute_named(c, scope, scope.value(node.value), node)


def attribute_named(c: Compilation, scope: Scope, value: Value, node: ast.Attribute) -> Value:
    if isinstance(value, RandomChoice):
        return over_options(c, value, lambda option: attribute_named(c, scope, option, node), id(node))
    return attribute(scope, value, node.attr)


def binary(c: Compilation, scope: Scope, node: ast.BinOp) -> Value:
    left, right = scope.value(node.left), scope.value(node.right)
    return combination(c, scope, node, left, right)


def combination(c: Compilation, scope: Scope, node: ast.BinOp | ast.AugAssign, left: Value, right: Value) -> Value:
    """`left sign right`."""
    if isinstance(left, RandomChoice):
        return over_options(c, left, lambda each: combination(c, scope, node, each, right), (id(node), 0))
    if isinstance(right, RandomChoice):
        return over_options(c, right, lambda each: combination(c, scope, node, left, each), (id(node), 1))
    if isinstance(left, RegisterList) or isinstance(right, RegisterList):
        from scenic_lite.dynamics.compiler.lists import concatenated

        return concatenated(c, node, left, right)
    return combined(scope, node.op, left, right)


def unary(c: Compilation, scope: Scope, node: ast.UnaryOp) -> Value:
    from scenic_lite.dynamics.compiler.conditions import negation

    if isinstance(node.op, ast.Not):
        return negation(c, scope, node)
    return sign(c, node, scope.value(node.operand))


def sign(c: Compilation, node: ast.UnaryOp, value: Value) -> Value:
    if isinstance(value, RandomChoice):
        return over_options(c, value, lambda option: sign(c, node, option), id(node))
    return signed(node.op, value)


def subscript(c: Compilation, scope: Scope, node: ast.Subscript) -> Value:
    return item(c, scope, node, scope.value(node.value), scope.value(node.slice))


def item(c: Compilation, scope: Scope, node: ast.Subscript, container: Value, index: Value) -> Value:
    """`container[index]`."""
    from scenic_lite.dynamics.compiler.changing import slice_of
    from scenic_lite.dynamics.compiler.lists import as_live_list, item_at

    if isinstance(container, RandomChoice):
        return over_options(c, container, lambda each: item(c, scope, node, each, index), (id(node), 0))
    if isinstance(index, RandomChoice):
        return over_options(c, index, lambda each: item(c, scope, node, container, each), (id(node), 1))
    if isinstance(index, slice) and (isinstance(container, RegisterList) or varies_in(index)):
        if not isinstance(container, RegisterList | list):
            raise ScenicError("unsupported", "only lists can be cut where the match decides")
        return slice_of(c, as_live_list(c, container), index)
    if isinstance(container, RegisterList) or isinstance(index, RandomExpr):
        return item_at(c, scope, container, index)
    return item_of(scope, container, index)


def varies_in(part: slice) -> bool:
    return any(isinstance(each, RandomExpr) for each in (part.start, part.stop, part.step))


def formatted(c: Compilation, scope: Scope, node: ast.FormattedValue) -> Value:
    """A value in an f-string."""
    spec = "" if node.format_spec is None else scope.value(node.format_spec)
    return text_with(c, scope, node, scope.value(node.value), spec)


def text_with(c: Compilation, scope: Scope, node: ast.FormattedValue, value: Value, spec: str) -> Value:
    if isinstance(value, RandomChoice):
        return over_options(c, value, lambda option: text_with(c, scope, node, option, spec), id(node))
    if node.conversion != -1:
        raise ScenicError("unsupported", "conversions such as !r in a behavior", hint="leave it out")
    return text_of(scope, value, spec)


def scenic_operator(c: Compilation, scope: Scope, node) -> Value:
    """An operator of Scenic; operands may be choices."""
    operation = OPERATORS.get(node.name)
    if operation is None:
        raise ScenicError("unsupported", f"`{node.name}` is not supported in a behavior")
    operands = [None if each is None else whole_choice(scope.value(each), c) for each in node.operands]
    try:
        return operation(scope, *operands)
    except ScenicError:
        at = next((i for i, each in enumerate(operands) if isinstance(each, RandomChoice)), None)
        if at is None:
            raise
    choice, before, after = operands[at], operands[:at], operands[at + 1 :]
    assert isinstance(choice, RandomChoice)
    return over_options(c, choice, lambda each: operation(scope, *before, each, *after), (id(node), at))


def same_thing(left: Value, right: Value) -> Value:
    """`left is right`."""
    if isinstance(left, RandomChoice) and isinstance(right, RandomChoice):
        things = list({id(each): each for each in (*left.options, *right.options)}.values())
        if not any(isinstance(each, RandomExpr | str | int | float) for each in things):
            first, second = numbered(left, things), numbered(right, things)
            return apply(EQUAL, first, second, kind="truth")
    if isinstance(left, RandomChoice):
        return choose(left.index, [same_thing(option, right) for option in left.options])
    if isinstance(right, RandomChoice):
        return choose(right.index, [same_thing(left, option) for option in right.options])
    if isinstance(left, RandomExpr) and isinstance(right, RandomExpr | bool | int | float | str):
        return apply(EQUAL, left, right, kind="truth")
    if isinstance(right, RandomExpr) and isinstance(left, bool | int | float | str):
        return apply(EQUAL, left, right, kind="truth")
    if isinstance(left, Function) and isinstance(right, Function):
        return left.body is right.body
    return left is right


def numbered(choice: RandomChoice, things: list[Value]) -> Value:
    """The place of what is chosen in a list of things."""
    places = [next(i for i, each in enumerate(things) if each is option) for option in choice.options]
    return choice.index if places == list(range(len(places))) else choose(choice.index, places)
