"""Built-in functions whose arguments are lists of varying length or live keys: the nearest, the sorted, the filtered.

Each returns NotImplemented where the evaluator's own function will do. Read next: `dynamics.compiler.comprehensions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import is_whole, jump, register_of
from scenic_lite.dynamics.compiler.lists import (
    LiveRange,
    among_objects,
    as_live_list,
    each_number,
    each_object,
    each_of,
    element_at,
    elements,
    item_at,
    one_list,
    rebuilt,
)
from scenic_lite.dynamics.compiler.registers import Slot, settled
from scenic_lite.dynamics.compiler.types import CAPACITY, RegisterList, loaded, varies
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import ADD, AND, LESS, MINIMUM, NEGATE, OR, SUBTRACT

Own = Callable[[Compilation, Scope, ast.AST, list, dict[str, Value]], Value]


def length(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return arguments[0].length if arguments and isinstance(arguments[0], RegisterList) else NotImplemented


def to_range(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`range` with live ends."""
    if not any(isinstance(each, RandomExpr) for each in arguments):
        return NotImplemented
    start, stop, step = [0, *arguments, 1] if len(arguments) == 1 else [*arguments, 1][:3]
    if not isinstance(step, int) or step == 0:
        raise ScenicError("unsupported", "the step of a range must be a fixed integer in a match")
    return LiveRange(settled(c.code, start), settled(c.code, stop), step)


def truth_of(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    from scenic_lite.dynamics.compiler.conditions import truth

    return truth(arguments[0]) if arguments else False


def to_list(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    if arguments and isinstance(arguments[0], RegisterList):
        return arguments[0]
    if arguments and isinstance(arguments[0], RandomChoice):
        return one_list(c, arguments[0], node)
    return NotImplemented


def any_of(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return folded(c, arguments, True)


def all_of(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return folded(c, arguments, False)


def folded(c: Compilation, arguments: list, decisive: bool) -> Value:
    """`any`, `all` of truths that may be live."""
    from scenic_lite.dynamics.compiler.conditions import truth

    if not arguments or not isinstance(arguments[0], RegisterList | list | tuple):
        return NotImplemented
    if not isinstance(arguments[0], RegisterList):
        result: Value = not decisive
        for each in map(truth, arguments[0]):
            result = apply(OR if decisive else AND, result, each, kind="truth")
        return result
    found = c.code.variables.take()
    register_of(c.code, not decisive, found)
    for item, after in each_of(c, arguments[0]):
        jump(c.code, truth(item), after, when=not decisive)
        register_of(c.code, decisive, found)
    return RegisterValue(found, "truth", lasting=False)


def total(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    if not arguments or not isinstance(arguments[0], RegisterList):
        return NotImplemented
    items = arguments[0]
    out = c.code.variables.take()
    register_of(c.code, arguments[1] if len(arguments) > 1 else 0, out)
    for item, _ in each_of(c, items):
        register_of(c.code, apply(ADD, RegisterValue(out), item), out)
    whole = items.element is None or is_whole(loaded(items.element, iter(range(items.element.size))))
    return RegisterValue(out, whole=whole, lasting=False)


def least(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return extreme(c, scope, node, arguments, keywords, least=True)


def greatest(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    return extreme(c, scope, node, arguments, keywords, least=False)


def extreme(
    c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value], least: bool
) -> Value:
    """`min`, `max` with a key, of a list of varying length, or of a choice: the first of those that are equal."""
    items = arguments[0] if len(arguments) == 1 else arguments
    key = keywords.get("key")
    if isinstance(items, RandomChoice):
        items = one_list(c, items, node)
    if key is None and not isinstance(items, RegisterList):
        return NotImplemented
    if isinstance(items, RegisterList):
        return extreme_of_live(c, scope, node, items, keywords, least)
    values = [settled(c.code, each) for each in elements(c, scope, items, node)]
    if not values:
        return default_of(keywords)
    if among_objects(values, 0) is not None:
        return extreme_of_objects(c, scope, node, values, key, least)
    slot = Slot(c.code, c.shapes, (*c.path, "extreme", id(node)))
    for each in values:
        slot.widen(each)
    best = c.code.variables.take()
    for i, each in enumerate(values):
        mark = key_of(c, scope, key, each, node)
        after = Label()
        if i:
            jump(c.code, better(mark, RegisterValue(best), least), after, when=False)
        register_of(c.code, mark, best)
        slot.store(each)
        c.code.put(after)
    return slot.value


def extreme_of_objects(
    c: Compilation, scope: Scope, node: ast.AST, items: list[Value], key: Value, least: bool
) -> Value:
    """As `extreme`, of many objects."""
    code = c.code
    best = code.variables.take(3)
    chosen, counter = best + 1, best + 2
    for item, after in each_object(c, items, counter):
        mark = settled(code, key_of(c, scope, key, item, node))
        first = Label()
        code.row(op.JUMP_EQUAL, counter, code.constant(0), first)
        jump(code, better(mark, RegisterValue(best), least), after, when=False)
        code.put(first)
        register_of(code, mark, best)
        register_of(code, RegisterValue(counter), chosen)
    return RandomChoice(RegisterValue(chosen, whole=True, lasting=False), tuple(items))


def extreme_of_live(
    c: Compilation, scope: Scope, node: ast.AST, items: RegisterList, keywords: dict[str, Value], least: bool
) -> Value:
    slot = Slot(c.code, c.shapes, (*c.path, "extreme", id(node)))
    best, found = c.code.variables.take(), c.code.variables.take()
    register_of(c.code, 0, found)
    if "default" in keywords:
        slot.store(keywords["default"])
    for item, after in each_of(c, items):
        item = settled(c.code, item)
        mark = settled(c.code, key_of(c, scope, keywords.get("key"), item, node))
        first = Label()
        jump(c.code, RegisterValue(found, "truth"), first, when=False)
        jump(c.code, better(mark, RegisterValue(best), least), after, when=False)
        c.code.put(first)
        register_of(c.code, 1, found)
        register_of(c.code, mark, best)
        slot.store(item)
    if "default" not in keywords:
        c.code.fault_unless(found, "the least or greatest of no values")
    return slot.value


def default_of(keywords: dict[str, Value]) -> Value:
    if "default" not in keywords:
        raise ScenicError("value", "the least or greatest of no values")
    return keywords["default"]


def better(mark: Value, best: Value, least: bool) -> Value:
    return apply(LESS, mark, best, kind="truth") if least else apply(LESS, best, mark, kind="truth")


def key_of(c: Compilation, scope: Scope, key: Value, item: Value, node: ast.AST) -> Value:
    """What an element is compared by: a number."""
    mark = item if key is None else scope.call(key, [item], {}, node)
    if kind_of(mark) not in ("number", "truth"):
        message = f"in a match elements are compared by numbers, not by {describe_kind(mark)}"
        raise ScenicError("unsupported", message, hint="give a key that is a number")
    return mark


def in_order(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`sorted` by live keys: a list in registers."""
    items = one_list(c, arguments[0], node) if isinstance(arguments[0], RandomChoice) else arguments[0]
    key, reverse = keywords.get("key"), keywords.get("reverse", False)
    if isinstance(reverse, RandomExpr):
        raise ScenicError("unsupported", "whether a list is sorted in reverse must be fixed in a match")
    code = c.code
    if not isinstance(items, RegisterList):
        values = [settled(code, each) for each in elements(c, scope, items, node)]
        marks = [key_of_fixed(c, scope, key, each, node) for each in values]
        if not any(isinstance(each, RandomExpr | RandomChoice) for each in marks):
            return NotImplemented
    start = code.variables.take(2 * CAPACITY)
    keys, order = start, start + CAPACITY
    if isinstance(items, RegisterList):
        place = RegisterValue(code.variables.take(), whole=True)
        register_of(code, 0, place.register)
        for item, _ in each_of(c, items):
            mark = key_of(c, scope, key, item, node)
            code.row(op.STORE, keys, place.register, register_of(code, signed_key(mark, reverse)))
            code.row(op.ADD, place.register, place.register, code.constant(1))
    else:
        items = as_live_list(c, values)
        for i, mark in enumerate(marks):
            register_of(code, signed_key(mark, reverse), keys + i)
    code.row(op.SORT, order, keys, items.registers[0])
    return permuted(c, items, order)


def key_of_fixed(c: Compilation, scope: Scope, key: Value, item: Value, node: ast.AST) -> Value:
    mark = settled(c.code, item if key is None else scope.call(key, [item], {}, node))
    if isinstance(mark, RandomExpr | RandomChoice) and kind_of(mark) not in ("number", "truth"):
        raise ScenicError("unsupported", f"in a match lists are sorted by numbers, not by {describe_kind(mark)}")
    return mark


def signed_key(mark: Value, reverse: bool) -> Value:
    return apply(NEGATE, mark) if reverse else mark


def permuted(c: Compilation, items: RegisterList, order: int) -> RegisterList:
    """The elements in the order of some indices."""

    def source(at: RegisterValue) -> RegisterValue:
        found = c.code.temporaries.take()
        c.code.row(op.LOAD_INDEXED, found, order, at.register)
        return RegisterValue(found, lasting=False)

    return rebuilt(c, items, items.length, source)


def reversed_list(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    if not arguments or not isinstance(arguments[0], RegisterList):
        return NotImplemented
    items = arguments[0]
    return rebuilt(c, items, items.length, lambda at: apply(SUBTRACT, apply(SUBTRACT, items.length, 1), at))


def numbered(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`enumerate` of a list of varying length: a list of pairs."""
    from scenic_lite.dynamics.compiler.comprehensions import Gathered

    if not arguments or not isinstance(arguments[0], RegisterList):
        return NotImplemented
    start = arguments[1] if len(arguments) > 1 else keywords.get("start", 0)
    found = Gathered(c, (*c.path, "enumerated", id(node)))
    found.become_live()
    counter = RegisterValue(c.code.variables.take(), whole=True)
    register_of(c.code, start, counter.register)
    for item, _ in each_of(c, arguments[0]):
        found.add((counter, item))
        c.code.row(op.ADD, counter.register, counter.register, c.code.constant(1))
    return found.value


def side_by_side(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`zip` of lists of which at least one varies in length."""
    from scenic_lite.dynamics.compiler.comprehensions import Gathered

    if not any(isinstance(each, RegisterList) for each in arguments):
        return NotImplemented
    parts = [as_live_list(c, each) if isinstance(each, RegisterList | list | tuple) else None for each in arguments]
    if None in parts or keywords:
        raise ScenicError("unsupported", "zip() in a match takes lists")
    shortest: Value = parts[0].length  # type: ignore[union-attr]
    for each in parts[1:]:
        shortest = apply(MINIMUM, shortest, each.length)  # type: ignore[union-attr]
    found = Gathered(c, (*c.path, "zipped", id(node)))
    found.become_live()
    for place, _ in each_number(c, LiveRange(0, settled(c.code, shortest), 1)):
        found.add(tuple(element_at(c, each, place) for each in parts))  # type: ignore[arg-type]
    return found.value


def first_of(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`next` of a comprehension in brackets, with or without a default; what stands behind it is evaluated too."""
    if not arguments or not isinstance(arguments[0], RegisterList):
        return NotImplemented
    items = arguments[0]
    if len(arguments) == 1:
        return item_at(c, scope, items, 0)
    slot = Slot(c.code, c.shapes, (*c.path, "first", id(node)))
    slot.store(arguments[1])
    none = Label()
    jump(c.code, apply(LESS, 0, items.length, kind="truth"), none, when=False)
    if items.element is not None:
        slot.store(element_at(c, items, 0))
    c.code.put(none)
    return slot.value


def kept_by(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`filter(function, items)`."""
    from scenic_lite.dynamics.compiler.comprehensions import gathered

    function, items = arguments
    return gathered(c, scope, items, node, lambda each: scope.call(function, [each], {}, node), lambda each: each)


def made_by(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`map(function, items)` over a list of varying length."""
    from scenic_lite.dynamics.compiler.comprehensions import gathered

    if len(arguments) != 2 or not isinstance(arguments[1], RegisterList):
        return NotImplemented
    function, items = arguments
    return gathered(c, scope, items, node, lambda each: True, lambda each: scope.call(function, [each], {}, node))


def rounded(c: Compilation, scope: Scope, node: ast.AST, arguments: list, keywords: dict[str, Value]) -> Value:
    """`round(x, digits)`."""
    digits = arguments[1] if len(arguments) > 1 else keywords.get("ndigits")
    if (
        not isinstance(digits, int)
        or not arguments
        or not isinstance(arguments[0], RandomExpr)
        or not varies(arguments[0])
    ):
        return NotImplemented
    out = c.code.temporaries.take()
    c.code.row(op.ROUND_DIGITS, out, register_of(c.code, arguments[0]), c.code.constant(digits))
    return RegisterValue(out, lasting=False)


FUNCTIONS: dict[str, Own] = {
    "len": length,
    "range": to_range,
    "bool": truth_of,
    "list": to_list,
    "tuple": to_list,
    "any": any_of,
    "all": all_of,
    "sum": total,
    "min": least,
    "max": greatest,
    "sorted": in_order,
    "reversed": reversed_list,
    "enumerate": numbered,
    "zip": side_by_side,
    "next": first_of,
    "filter": kept_by,
    "map": made_by,
    "round": rounded,
}
