"""Lists whose length is known only in the match, live indices, live ranges: filters, sorting, the nearest player.

A fixed list is Python's own list of values; what grows or is filtered during a match is a `RegisterList` in
registers. Read next: `compiler_functions`, the built-in functions over lists.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Instance, RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import jump, register_of
from scenic_lite.dynamics.compiler.registers import Slot, pairs, settled, store
from scenic_lite.dynamics.compiler.types import CAPACITY, Items, RegisterList, element_of, join, loaded, shape_of
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.comparisons import membership
from scenic_lite.evaluation.expressions import item_of
from scenic_lite.values.graph import RandomExpr, Value, apply, as_number
from scenic_lite.values.operations import ADD, EQUAL, LESS, OR
from scenic_lite.values.regions import Region

MANY = 8  # objects: a loop over so many has the same rows for all of them


@dataclass(frozen=True, eq=False)
class LiveRange:
    """`range` whose ends may be live; the step is fixed."""

    start: Value
    stop: Value
    step: int

    @property
    def whole(self) -> bool:
        return True


def elements(c: Compilation, scope: Scope, value: Value, node: ast.AST) -> list[Value]:
    """The elements of what has a fixed number of them."""
    if isinstance(value, RandomChoice):
        return scope.elements(one_list(c, value, node), node)
    if isinstance(value, RegisterList | LiveRange):
        raise scope.error("unsupported", "a list whose length varies in a match cannot be taken apart here", node)
    return scope.elements(value, node)


def one_list(c: Compilation, value: RandomChoice, node: ast.AST) -> Value:
    """A choice among lists as one list in registers."""
    if not all(isinstance(option, list | tuple) for option in value.options):
        raise ScenicError("type", f"{describe_kind(value)} has no elements")
    slot = Slot(c.code, c.shapes, (*c.path, "lists", id(node)))
    for option in value.options:
        slot.widen(list(option))
    slot.store(RandomChoice(value.index, tuple(list(option) for option in value.options)))
    return slot.value


def as_live_list(c: Compilation, value: Value) -> RegisterList:
    """Any list, in registers."""
    if isinstance(value, RegisterList):
        return value
    shape = Items(element_of(shape_of(list(value))))
    slot = Slot(c.code, {("list",): shape}, ("list",))
    slot.store(list(value))
    found = slot.value
    assert isinstance(found, RegisterList)
    return found


def element_at(c: Compilation, items: RegisterList, index: Value) -> Value:
    """An element that is known to be there."""
    if items.element is None:
        return None
    if isinstance(index, int):
        return loaded(items.element, iter(items.registers[1 + index :: CAPACITY]))
    place = register_of(c.code, index)
    registers = []
    for leaf in range(items.element.size):
        registers.append(c.code.temporaries.take())
        c.code.row(op.LOAD_INDEXED, registers[-1], items.registers[1 + leaf * CAPACITY], place)
    return loaded(items.element, iter(registers))


def item_at(c: Compilation, scope: Scope, container: Value, index: Value) -> Value:
    """`container[index]` where one of both is live; a fault if there is no such element."""
    if not isinstance(index, RandomExpr | int) or isinstance(index, bool):
        raise ScenicError("type", f"the index of a list is an integer, not {describe_kind(index)}")
    if isinstance(container, dict):
        return dictionary_item(c, container, index)
    if isinstance(container, RegisterList):
        place = from_start(c, index, container.length)
        inside = c.code.temporaries.take()
        c.code.row(op.IS_INDEX, inside, register_of(c.code, place), container.registers[0])
        c.code.fault_unless(inside, "list index out of range")
        return element_at(c, container, place)
    items = scope.elements(container, ast.Pass())
    if not items:
        raise ScenicError("value", "list index out of range")
    place = settled(c.code, from_start(c, index, len(items)))
    return choose(place, items) if not all(each is items[0] for each in items) else checked_first(c, place, items)


def checked_first(c: Compilation, place: Value, items: list[Value]) -> Value:
    """All elements are the same thing, but the index may still be out of range."""
    register_of(c.code, choose(place, list(range(len(items) + 1))[:-1] if len(items) > 1 else [0]))
    return items[0]


def from_start(c: Compilation, index: Value, length: Value) -> Value:
    """An index counted from the start of the list: a negative one counts from its end."""
    if isinstance(index, int):
        return index if index >= 0 else apply(ADD, length, index)
    index = settled(c.code, index)
    negative = apply(LESS, index, 0, kind="truth")
    return settled(c.code, choose(as_number(negative), [index, apply(ADD, index, length)]))


def dictionary_item(c: Compilation, table: dict, key: Value) -> Value:
    """`table[key]` with a live key: a fault if there is none."""
    return choose(entry(c, table, key, "the key is not in the dictionary"), list(table.values()))


def entry(c: Compilation, table: dict, key: Value, otherwise: str) -> Value:
    """The place of a live key among those of a dictionary; a fault if it is not there."""
    places = list(table)
    if isinstance(key, RandomChoice):
        known = [next((i for i, each in enumerate(places) if each is option), len(places)) for option in key.options]
        found = settled(c.code, choose(key.index, known))
    else:
        found = place_among(c, places, key)
    inside = apply(LESS, found, len(places), kind="truth")
    c.code.fault_unless(register_of(c.code, inside), otherwise)
    return found


def place_among(c: Compilation, places: list[Value], key: Value) -> Value:
    """The place of a number or text among some, their number if it is not there."""
    found: Value = len(places)
    for i, each in reversed(list(enumerate(places))):
        same = compared_keys(each, key)
        found = (
            choose(as_number(settled(c.code, same)), [found, i])
            if isinstance(same, RandomExpr)
            else (i if same else found)
        )
    return settled(c.code, found)


def compared_keys(a: Value, b: Value) -> Value:
    return apply(EQUAL, a, b, kind="truth") if isinstance(b, RandomExpr) else a == b


# ------------------------------------------------------------ building


def appended(c: Compilation, items: Value, item: Value) -> Value:
    """A list with one more element."""
    if not isinstance(items, RegisterList):
        return [*items, item]
    found = as_live_list_of(c, items, item)
    put_with_room(c, found, item)
    return found


def put_with_room(c: Compilation, items: RegisterList, item: Value) -> None:
    """Put an element behind the last, in place; a fault if there is no room."""
    fits = c.code.temporaries.take()
    c.code.row(op.LESS, fits, items.registers[0], c.code.constant(CAPACITY))
    c.code.fault_unless(fits, f"a list grows beyond {CAPACITY} elements")
    put_at_end(c, items, item)


def as_live_list_of(c: Compilation, items: RegisterList, item: Value) -> RegisterList:
    """A copy of a list with room for elements like `item`."""
    shape = Items(join(items.element, shape_of(item)))
    slot = Slot(c.code, {("list",): shape}, ("list",))
    slot.store(items)
    found = slot.value
    assert isinstance(found, RegisterList)
    return found


def put_at_end(c: Compilation, items: RegisterList, item: Value) -> None:
    """Put an element behind the last, in place."""
    put_at(c, items, items.registers[0], item)
    c.code.row(op.ADD, items.registers[0], items.registers[0], c.code.constant(1))


def put_at(c: Compilation, items: RegisterList, place: int, item: Value) -> None:
    """Put an element where a register says, in place."""
    assert items.element is not None
    start = c.code.temporaries.take(items.element.size)
    registers = range(start, start + items.element.size)
    store(c.code, list(pairs(items.element, iter(registers), item)))
    for leaf, register in enumerate(registers):
        c.code.row(op.STORE, items.registers[1 + leaf * CAPACITY], place, register)


def rebuilt(
    c: Compilation, items: RegisterList, length: Value, source: Callable[[RegisterValue], Value]
) -> RegisterList:
    """A list of some length, each element that of `items` at the place that `source` says of its own."""
    code = c.code
    start = code.variables.take(len(items.registers))
    out = RegisterList(items.element, tuple(range(start, start + len(items.registers))))
    at, value = RegisterValue(code.variables.take(), whole=True), code.variables.take()
    register_of(code, length, start)
    register_of(code, 0, at.register)
    again, over = Label(), Label()
    code.put_loop(again)
    code.row(op.JUMP_NOT_LESS, at.register, start, over)
    place = register_of(code, source(at))
    for leaf in range(0 if items.element is None else items.element.size):
        code.row(op.LOAD_INDEXED, value, items.registers[1 + leaf * CAPACITY], place)
        code.row(op.STORE, out.registers[1 + leaf * CAPACITY], at.register, value)
    code.row(op.ADD, at.register, at.register, code.constant(1))
    code.row(op.JUMP, c=again)
    code.put(over)
    return out


def concatenated(c: Compilation, node: ast.AST, left: Value, right: Value) -> Value:
    """`left + right` of lists, at least one of which varies in length."""
    if (
        not isinstance(node, ast.BinOp | ast.AugAssign)
        or not isinstance(node.op, ast.Add)
        or not all(isinstance(each, RegisterList | list) for each in (left, right))
    ):
        raise ScenicError("unsupported", "lists whose length varies can only be added to each other")
    shape = Items(join(element_of(shape_of(left)), element_of(shape_of(right))))
    slot = Slot(c.code, {("list",): shape}, ("list",))
    slot.store(left)
    found = slot.value
    assert isinstance(found, RegisterList)
    if isinstance(right, RegisterList):
        for item, _ in each_of(c, right):
            put_with_room(c, found, item)
    else:
        for item in right:
            put_with_room(c, found, item)
    return found


def changed_item(c: Compilation, scope: Scope, container: Value, index: Value, value: Value) -> Value:
    """The container with another element."""
    if isinstance(container, RegisterList):
        return with_item(c, scope, container, index, value)
    if isinstance(container, dict) and not isinstance(index, RandomExpr | RandomChoice):
        return {**container, index: value}
    if isinstance(container, dict) and container:
        return with_entry(c, container, index, value)
    if isinstance(container, list) and isinstance(index, int):
        item_of(scope, container, index)
        changed = list(container)
        changed[index] = value
        return changed
    if isinstance(container, list) and isinstance(index, RandomExpr):
        place = settled(c.code, from_start(c, index, len(container)))
        register_of(c.code, choose(place, list(range(len(container)))))
        same = [apply(EQUAL, place, i, kind="truth") for i in range(len(container))]
        return [
            choose(as_number(settled(c.code, is_it)), [old, value]) for is_it, old in zip(same, container, strict=True)
        ]
    raise ScenicError("unsupported", f"elements of {describe_kind(container)} cannot be assigned in a match")


def with_item(c: Compilation, scope: Scope, items: RegisterList, index: Value, value: Value) -> RegisterList:
    """A list of varying length with another element."""
    item_at(c, scope, items, index)
    found = as_live_list_of(c, items, value)
    place = register_of(c.code, from_start(c, index, items.length))
    put_at(c, found, place, value)
    return found


def with_entry(c: Compilation, table: dict, key: Value, value: Value) -> dict:
    """A dictionary with another value for one of its keys, whichever the match finds; a fault for a new key."""
    found = entry(c, table, key, "a dictionary cannot grow by a key that the match decides; give it its keys before")
    same = [apply(EQUAL, found, i, kind="truth") for i in range(len(table))]
    pairs_of = zip(same, table.items(), strict=True)
    return {key: choose(as_number(settled(c.code, is_it)), [old, value]) for is_it, (key, old) in pairs_of}


# ------------------------------------------------------------ asking


def contains(c: Compilation, scope: Scope, node: ast.Compare, container: Value, item: Value) -> Value:
    """`item in container`."""
    from scenic_lite.dynamics.compiler.choices import over_options

    if isinstance(container, Region):
        from scenic_lite.dynamics.compiler.choices import whole_choice

        return membership(scope, node, whole_choice(item, c), container)
    if isinstance(container, RandomChoice):
        return over_options(c, container, lambda each: contains(c, scope, node, each, item), (id(node), "in"))
    if isinstance(container, RegisterList):
        return some(c, container, lambda each: same_value(c, scope, node, each, item), node)
    if isinstance(item, RandomExpr | RandomChoice) and not isinstance(container, str):
        found: Value = False
        for each in scope.elements(container, node):
            same = same_value(c, scope, node, each, item)
            found = same if found is False else apply(OR, found, same, kind="truth")
        return found
    return membership(scope, node, item, container)


def same_value(c: Compilation, scope: Scope, node: ast.Compare, a: Value, b: Value) -> Value:
    from scenic_lite.dynamics.compiler.conditions import link

    return link(c, scope, node, ast.Eq(), a, b)


def some(c: Compilation, items: RegisterList, test: Callable[[Value], Value], key: object) -> Value:
    """Whether a test holds for some element of a list."""
    found = c.code.variables.take()
    register_of(c.code, 0, found)
    for item, after in each_of(c, items):
        jump(c.code, test(item), after, when=False)
        register_of(c.code, 1, found)
    return RegisterValue(found, "truth", lasting=False)


def each_number(c: Compilation, numbers: LiveRange) -> Iterator[tuple[Value, Label]]:
    """As `each_of`, of a range."""
    counter = c.code.variables.take()
    register_of(c.code, numbers.start, counter)
    stop = register_of(c.code, numbers.stop)
    first, second = (counter, stop) if numbers.step > 0 else (stop, counter)
    again, over, after = Label(), Label(), Label()
    c.code.put_loop(again)
    c.code.row(op.JUMP_NOT_LESS, first, second, over)
    yield RegisterValue(counter, whole=True), after
    c.code.put(after)
    c.code.row(op.ADD, counter, counter, c.code.constant(numbers.step))
    c.code.row(op.JUMP, c=again)
    c.code.put(over)


def among_objects(items: Value, counter: int) -> RandomChoice | None:
    """One of many objects, as long a list as is worth a loop, by the index in a register; None for other lists."""
    if not isinstance(items, list | tuple) or len(items) < MANY:
        return None
    if not all(isinstance(each, Instance) and each.label for each in items):
        return None
    return RandomChoice(RegisterValue(counter, whole=True), tuple(items))


def each_object(c: Compilation, items: list[Value], counter: int) -> Iterator[tuple[RandomChoice, Label]]:
    """As `each_of`, over many objects; the register `counter` says which one it is."""
    found = among_objects(items, counter)
    assert found is not None
    register_of(c.code, 0, counter)
    again, after = Label(), Label()
    c.code.put_loop(again)
    yield found, after
    c.code.put(after)
    c.code.row(op.ADD, counter, counter, c.code.constant(1))
    c.code.row(op.JUMP_LESS, counter, c.code.constant(len(items)), again)


def each_of(c: Compilation, items: RegisterList) -> Iterator[tuple[Value, Label]]:
    """Rows of a loop over a list, once; the label is where the next round begins."""
    counter = c.code.variables.take()
    register_of(c.code, 0, counter)
    again, over, after = Label(), Label(), Label()
    c.code.put_loop(again)
    c.code.row(op.JUMP_NOT_LESS, counter, items.registers[0], over)
    yield element_at(c, items, RegisterValue(counter, whole=True)), after
    c.code.put(after)
    c.code.row(op.ADD, counter, counter, c.code.constant(1))
    c.code.row(op.JUMP, c=again)
    c.code.put(over)
