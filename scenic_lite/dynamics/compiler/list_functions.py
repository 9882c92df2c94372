"""Built-in functions with code of their own: `min` and `max` with a key, `sorted`, `any`, `all`, `sum`, `len`, `range`.

Each returns NotImplemented where the evaluator's own function will do. Read next: `dynamics.compiler.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import partial

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.choices import truth
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import is_whole, jump, register_of
from scenic_lite.dynamics.compiler.lists import (
    LiveRange,
    decided_by,
    element_at,
    elements,
    in_registers,
    loop,
    many,
    one_list,
    refused,
)
from scenic_lite.dynamics.compiler.registers import Place, materialize, place_for
from scenic_lite.dynamics.compiler.types import RegisterList, varies
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import ADD, AND, LESS, NEGATE, OR


def length(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return arguments[0].length if arguments and isinstance(arguments[0], RegisterList) else NotImplemented


def to_range(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """Return `range` with live ends."""
    if not any(isinstance(each, RandomExpr) for each in arguments):
        return NotImplemented
    start, stop, step = [0, *arguments, 1] if len(arguments) == 1 else [*arguments, 1][:3]
    if not isinstance(step, int) or step == 0:
        raise refused("the step of a range must be a fixed integer in a match", "")
    return LiveRange(materialize(c.code, start), materialize(c.code, stop), step)


def truth_of(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return truth(arguments[0]) if arguments else False


def to_list(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    if arguments and isinstance(arguments[0], RandomChoice):
        return one_list(c, arguments[0])
    return arguments[0] if arguments and isinstance(arguments[0], RegisterList) else NotImplemented


def folded(
    decisive: bool, c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]
) -> Value:
    """Return `any`, `all` of truths that may be live."""
    if not arguments or not isinstance(arguments[0], RegisterList | list | tuple):
        return NotImplemented
    if isinstance(arguments[0], RegisterList):
        return decided_by(c.code, arguments[0], truth, decisive)
    result: Value = not decisive
    for each in map(truth, arguments[0]):
        result = apply(OR if decisive else AND, result, each)
    return result


def total(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """Return `sum` of a list in registers."""
    if not arguments or not isinstance(arguments[0], RegisterList):
        return NotImplemented
    items, result = arguments[0], c.code.variables.take()
    register_of(c.code, arguments[1] if len(arguments) > 1 else 0, result)
    with loop(c.code, items) as (item, _, _):
        register_of(c.code, apply(ADD, RegisterValue(result), item), result)
    return RegisterValue(result, whole=is_whole(items.at(0)), lasting=False)


def extreme(
    least: bool, c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]
) -> Value:
    """Return `min`, `max` with a key, or of a list in registers, or of a choice: the first of those that are equal."""
    code, key = c.code, keywords.get("key")
    items = arguments[0] if len(arguments) == 1 else arguments
    items = one_list(c, items) if isinstance(items, RandomChoice) else items
    if key is None and not isinstance(items, RegisterList):
        return NotImplemented
    number = partial(number_of, c, scope, node, key)
    if not isinstance(items, RegisterList):
        items = [materialize(code, each) for each in elements(c, scope, items, node)]
    elif "default" in keywords:
        place = place_for(code, [keywords["default"], items.at(0)])
        place.store(keywords["default"])
        with code.when(items.registers[0]):
            place.store(element_at(code, items, place_of_extreme(code, items, number, least)))
        return place.load()
    else:
        code.fault_unless(items.registers[0], NO_VALUES)
    if isinstance(items, list) and not items:
        if "default" not in keywords:
            raise ScenicError("value", NO_VALUES)
        return keywords["default"]
    return element_at(code, items, place_of_extreme(code, items, number, least))


NO_VALUES = "the least or greatest of no values"


def place_of_extreme(
    code: Assembler, items: RegisterList | list, number: Callable[[Value], Value], least: bool
) -> RegisterValue:
    """Return the place of the first element whose number is the least, or the greatest."""
    best, chosen = code.variables.take(), RegisterValue(code.variables.take(), whole=True, lasting=False)

    def compare(item: Value, place: RegisterValue | int, following: Label) -> None:
        mark, better = materialize(code, number(item)), Label()
        if isinstance(place, RegisterValue):
            code.row(op.JUMP_EQUAL, place.register, code.constant(0), better)
        if isinstance(place, RegisterValue) or place > 0:
            pair = (mark, RegisterValue(best)) if least else (RegisterValue(best), mark)
            jump(code, apply(LESS, *pair), following, when=False)
        code.put(better)
        register_of(code, mark, best)
        register_of(code, place, chosen.register)

    if isinstance(items, RegisterList) or many(items):
        with loop(code, items) as (item, place, following):
            compare(item, place, following)
    else:
        for i, item in enumerate(items):
            following = Label()
            compare(item, i, following)
            code.put(following)
    return chosen


def number_of(c: Compilation, scope: Scope, node: ast.AST, key: Value, item: Value) -> Value:
    """Return what an element is compared by."""
    return as_number_key(item if key is None else scope.call(key, [item], {}, node))


def as_number_key(mark: Value) -> Value:
    if isinstance(mark, RegisterList) or kind_of(mark) not in ("number", "truth"):
        what = f"in a match elements are compared by numbers, not by {describe_kind(mark)}"
        raise refused(what, "give a key that is a number")
    return mark


def in_order(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """Return `sorted` by live keys: a list in registers."""
    code, reverse = c.code, keywords.get("reverse", False)
    items = one_list(c, arguments[0]) if isinstance(arguments[0], RandomChoice) else arguments[0]
    if isinstance(reverse, RandomExpr):
        raise refused("whether a list is sorted in reverse must be fixed in a match", "")

    def mark(item: Value) -> Value:
        return item if keywords.get("key") is None else scope.call(keywords["key"], [item], {}, node)

    def put(number: Value, register: int) -> None:
        register_of(code, apply(NEGATE, as_number_key(number)) if reverse else as_number_key(number), register)

    if isinstance(items, RegisterList):
        keys, order, key = (code.variables.take(items.type.capacity) for _ in range(3))
        with loop(code, items) as (item, place, _):
            put(mark(item), key)
            code.row(op.STORE, keys, place.register, key)
    else:
        values = [materialize(code, each) for each in elements(c, scope, items, node)]
        marks = [materialize(code, mark(each)) for each in values]
        if not any(isinstance(each, RandomExpr | RandomChoice) for each in marks):
            return NotImplemented
        items = in_registers(code, values)
        keys, order = (code.variables.take(items.type.capacity) for _ in range(2))
        for i, each in enumerate(marks):
            put(each, keys + i)
    code.row(op.SORT, order, keys, items.registers[0])
    return permuted(code, items, order)


def permuted(code: Assembler, items: RegisterList, order: int) -> RegisterList:
    """Return the elements in the order of some indices."""
    ordered = Place(code, items.type, code.variables).load()
    assert isinstance(ordered, RegisterList)
    register_of(code, items.length, ordered.registers[0])
    place, value = code.temporaries.take(), code.temporaries.take()
    with code.rounds(items.registers[0]) as (counter, _):
        code.row(op.LOAD_INDEXED, place, order, counter.register)
        for i in range(0 if items.type.element is None else items.type.element.size):
            first = 1 + i * items.type.capacity
            code.row(op.LOAD_INDEXED, value, items.registers[first], place)
            code.row(op.STORE, ordered.registers[first], counter.register, value)
    return ordered


def rounded(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """Return `round(x, digits)`."""
    digits = arguments[1] if len(arguments) > 1 else keywords.get("ndigits")
    if not isinstance(digits, int) or not isinstance(arguments[0], RandomExpr) or not varies(arguments[0]):
        return NotImplemented
    rounded = c.code.temporaries.take()
    c.code.row(op.ROUND_DIGITS, rounded, register_of(c.code, arguments[0]), c.code.constant(digits))
    return RegisterValue(rounded, lasting=False)


FUNCTIONS: dict[str, Callable[[Compilation, Scope, ast.AST, list, dict[str, Value]], Value]] = {
    "len": length,
    "range": to_range,
    "bool": truth_of,
    "list": to_list,
    "tuple": to_list,
    "any": partial(folded, True),
    "all": partial(folded, False),
    "sum": total,
    "min": partial(extreme, True),
    "max": partial(extreme, False),
    "sorted": in_order,
    "round": rounded,
}
