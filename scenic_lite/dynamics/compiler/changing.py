"""Slices and methods of lists whose length the match decides: each makes a new list from the elements of the old.

Read next: `dynamics.compiler.calls`, which assigns the changed list to its variable.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import choose
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import jump, register_of
from scenic_lite.dynamics.compiler.functions import in_order
from scenic_lite.dynamics.compiler.lists import (
    appended,
    as_live_list,
    each_of,
    elements,
    from_start,
    item_at,
    rebuilt,
    same_value,
)
from scenic_lite.dynamics.compiler.registers import kept, settled
from scenic_lite.dynamics.compiler.types import RegisterList, varies
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import Value, apply, as_number
from scenic_lite.values.operations import ADD, GREATER, GREATER_EQUAL, MAXIMUM, MINIMUM, SUBTRACT

Changed = tuple[Value, Value]  # the list as it is now, what the method returns


def mutated(
    c: Compilation, scope: Scope, node: ast.AST, items: Value, name: str, arguments: list, keywords: dict[str, Value]
) -> Changed:
    """A list after one of its methods has changed it, and what the method returns."""
    if not isinstance(items, RegisterList) and not keywords and not any(map(varies, arguments)) and name in PLAIN:
        changed = list(items)
        return changed, PLAIN[name](changed, *arguments)
    method = METHODS.get(name)
    if method is None:
        raise ScenicError("unsupported", f"{name}() of a list cannot be done in a match")
    return method(c, scope, node, items, arguments, keywords)


def append(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    return appended(c, items, arguments[0]), None


def extend(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    from scenic_lite.dynamics.compiler.lists import concatenated

    more = arguments[0]
    if isinstance(more, RegisterList):
        return concatenated(c, ast.BinOp(node, ast.Add(), node), as_live_list(c, items), more), None  # type: ignore[arg-type]
    for each in elements(c, scope, more, node):
        items = appended(c, items, each)
    return items, None


def clear(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    return [], None


def pop(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    index = arguments[0] if arguments else -1
    items = as_live_list(c, items)
    place = settled(c.code, from_start(c, index, items.length))
    gone = settled(c.code, kept(c.code, item_at(c, scope, items, place)))
    return without(c, items, place), gone


def remove(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    items = as_live_list(c, items)
    return without(c, items, place_of(c, scope, node, items, arguments[0], "list.remove(x): x not in list")), None


def insert(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    index, item = arguments
    before = as_live_list(c, items)
    place = within(c, index, before.length)
    longer = appended(c, before, item)
    last = settled(c.code, apply(SUBTRACT, longer.length, 1))

    def source(at: RegisterValue) -> Value:
        after = apply(ADD, truth_number(GREATER_EQUAL, at, place), truth_number(GREATER, at, place))
        return choose(settled(c.code, after), [at, last, apply(SUBTRACT, at, 1)])

    return rebuilt(c, longer, longer.length, source), None


def reverse(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    items = as_live_list(c, items)
    return rebuilt(c, items, items.length, lambda at: apply(SUBTRACT, apply(SUBTRACT, items.length, 1), at)), None


def sort(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, keywords: dict) -> Changed:
    found = in_order(c, scope, node, [items], keywords)
    return (
        scope.call(scope.handlers.builtins["sorted"], [items], keywords, node) if found is NotImplemented else found
    ), None


def index_of(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    live = as_live_list(c, items)
    return items, place_of(c, scope, node, live, arguments[0], "the value is not in the list")


def count_of(c: Compilation, scope: Scope, node: ast.AST, items: Value, arguments: list, _: dict) -> Changed:
    found = c.code.variables.take()
    register_of(c.code, 0, found)
    for item, after in each_of(c, as_live_list(c, items)):
        jump(c.code, same_value(c, scope, equality(node), item, arguments[0]), after, when=False)
        c.code.row(op.ADD, found, found, c.code.constant(1))
    return items, RegisterValue(found, whole=True, lasting=False)


Method = Callable[[Compilation, Scope, ast.AST, Value, list, dict], Changed]
METHODS: dict[str, Method] = {
    "append": append,
    "extend": extend,
    "clear": clear,
    "pop": pop,
    "remove": remove,
    "insert": insert,
    "reverse": reverse,
    "sort": sort,
    "index": index_of,
    "count": count_of,
}
PLAIN: dict[str, Callable[..., Value]] = {
    "pop": list.pop,
    "insert": list.insert,
    "remove": list.remove,
    "reverse": list.reverse,
    "clear": list.clear,
    "index": list.index,
    "count": list.count,
}


# ------------------------------------------------------------ parts of a list


def slice_of(c: Compilation, items: RegisterList, part: slice) -> RegisterList:
    """`items[start:stop:step]`; the step is fixed."""
    step = 1 if part.step is None else part.step
    if not isinstance(step, int) or step == 0:
        raise ScenicError("unsupported", "the step of a slice must be a fixed integer in a match, and not 0")
    length = items.length
    if step > 0:
        start = 0 if part.start is None else within(c, part.start, length)
        stop = length if part.stop is None else within(c, part.stop, length)
        span = apply(SUBTRACT, stop, start)
    else:
        last = settled(c.code, apply(SUBTRACT, length, 1))
        start = last if part.start is None else within(c, part.start, length, -1)
        stop = -1 if part.stop is None else within(c, part.stop, length, -1)
        span = apply(SUBTRACT, start, stop)
    start = settled(c.code, start)
    count = apply(MAXIMUM, (span + (abs(step) - 1)) // abs(step), 0)
    return rebuilt(c, items, settled(c.code, count), lambda at: start + at * step)


def within(c: Compilation, index: Value, length: RegisterValue, low: int = 0) -> Value:
    """An end of a slice, counted from the start and cut to what there is; `low` is -1 for one that goes backwards."""
    place = from_start(c, index, length)
    most = length if low == 0 else apply(SUBTRACT, length, 1)
    return settled(c.code, apply(MAXIMUM, apply(MINIMUM, place, most), low))


def without(c: Compilation, items: RegisterList, place: Value) -> RegisterList:
    """All elements but one."""
    fewer = settled(c.code, apply(SUBTRACT, items.length, 1))
    return rebuilt(c, items, fewer, lambda at: apply(ADD, at, truth_number(GREATER_EQUAL, at, place)))


def truth_number(sign, left: Value, right: Value) -> Value:
    return as_number(apply(sign, left, right, kind="truth"))


def place_of(
    c: Compilation, scope: Scope, node: ast.AST, items: RegisterList, item: Value, otherwise: str
) -> RegisterValue:
    """The place of the first element that is equal; a fault if there is none."""
    code = c.code
    found, counter = code.variables.take(), code.variables.take()
    register_of(code, -1, found)
    register_of(code, 0, counter)
    over = Label()
    for each, after in each_of(c, items):
        jump(code, same_value(c, scope, equality(node), each, item), after, when=False)
        register_of(code, RegisterValue(counter), found)
        code.row(op.JUMP, c=over)
        code.reachable = True
        code.put(after)
        code.row(op.ADD, counter, counter, code.constant(1))
    code.put(over)
    there = apply(GREATER_EQUAL, RegisterValue(found), 0, kind="truth")
    code.fault_unless(register_of(code, there), otherwise)
    return RegisterValue(found, whole=True)


def equality(node: ast.AST) -> ast.Compare:
    """A comparison in the place of a call, for its messages."""
    assert isinstance(node, ast.expr)
    return ast.copy_location(ast.Compare(node, [ast.Eq()], [node]), node)
