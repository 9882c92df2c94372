"""Lists while a match runs: filters, `len`, the nearest by `min` with a key, one `sorted`, `append`, indices, `in`.

A fixed list is Python's own list of values. What is filtered or grown during a match stands in registers, as long as
its first register says; it is read and looped over, but not cut, added to another or compared. A loop over many
objects has one body, over few things one for each. Read next: `dynamics.compiler.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Instance, RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.choices import jump_on, over_options, related, whole_choice
from scenic_lite.dynamics.compiler.code import Assembler, Label, Row
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import jump, register_of
from scenic_lite.dynamics.compiler.registers import Place, materialize, moves_to, place_for, store
from scenic_lite.dynamics.compiler.types import LONGEST, ListType, RegisterList, common_type, join, loaded, type_of
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import unpack
from scenic_lite.evaluation.expressions import membership
from scenic_lite.values.graph import RandomExpr, Value, apply, as_number
from scenic_lite.values.operations import ADD, EQUAL, LESS, OR
from scenic_lite.values.regions import Region

MANY = 8  # objects: a loop over so many has the same rows for all of them
ADD_HERE = -2  # in place of an opcode: a comprehension adds an element here
DECIDED = "whose length the match decides"


@dataclass(frozen=True, eq=False)
class LiveRange:
    """`range` whose ends may be live; the step is fixed."""

    start: Value
    stop: Value
    step: int


def refused(what: str, hint: str = "write a loop or a comprehension") -> ScenicError:
    return ScenicError("unsupported", what, hint=hint)


def elements(c: Compilation, scope: Scope, value: Value, node: ast.AST) -> list[Value]:
    """Return the elements of what has a fixed number of them."""
    if isinstance(value, RandomChoice):
        value = one_list(c, value)
    if isinstance(value, RegisterList | LiveRange):
        raise scope.placed(refused(f"a list {DECIDED} cannot be taken apart here"), node)
    return scope.elements(value, node)


def one_list(c: Compilation, value: RandomChoice) -> Value:
    """Return a choice among lists as one list."""
    if not all(isinstance(option, list | tuple) for option in value.options):
        raise ScenicError("type", f"{describe_kind(value)} has no elements")
    options = [list(option) for option in value.options]
    place = place_for(c.code, options)
    place.store(RandomChoice(value.index, tuple(options)))
    return place.load()


def in_registers(code: Assembler, items: Value, more: Value = None, capacity: int = 0) -> RegisterList:
    """Return any list in registers, a copy, with room for another element if one is given."""
    own = items.type if isinstance(items, RegisterList) else ListType(common_type(items), len(items))
    element = own.element if more is None else join(own.element, type_of(more))
    place = Place(code, ListType(element, max(own.capacity, capacity, 1)), code.variables)
    place.store(items)
    copy = place.load()
    assert isinstance(copy, RegisterList)
    return copy


def many(items: Value) -> bool:
    """Return whether there are so many objects that a loop over them is worth one body for all."""
    if not isinstance(items, list | tuple) or len(items) < MANY:
        return False
    return all(isinstance(each, Instance) and each.label for each in items)


@contextmanager
def loop(code: Assembler, items: RegisterList | list | tuple) -> Iterator[tuple[Value, RegisterValue, Label]]:
    """Rows written inside are executed for each element; its place, and the label that begins the next round."""
    count = items.registers[0] if isinstance(items, RegisterList) else code.constant(len(items))
    with code.rounds(count, at_least_one=not isinstance(items, RegisterList)) as (counter, following):
        yield element_at(code, items, counter), counter, following


# ------------------------------------------------------------ elements


def element_at(code: Assembler, items: RegisterList | list | tuple, index: Value) -> Value:
    """Return an element that is known to be there."""
    if not isinstance(items, RegisterList):
        return choose(index, items)
    if isinstance(index, int):
        return items.at(index)
    if items.type.element is None:
        return None
    place = register_of(code, index)
    registers = []
    for i in range(items.type.element.size):
        registers.append(code.temporaries.take())
        code.row(op.LOAD_INDEXED, registers[-1], items.registers[1 + i * items.type.capacity], place)
    return loaded(items.type.element, iter(registers))


def item_at(c: Compilation, scope: Scope, container: Value, index: Value) -> Value:
    """Return `container[index]` where one of both is live; a fault if there is no such element."""
    if isinstance(index, slice):
        raise refused(f"a slice of a list {DECIDED}, or up to where it decides")
    if isinstance(container, dict):
        return choose(place_of_key(c, container, index), list(container.values()))
    if not isinstance(index, RandomExpr | int) or isinstance(index, bool):
        raise ScenicError("type", f"the index of a list is an integer, not {describe_kind(index)}")
    items = container if isinstance(container, RegisterList) else scope.elements(container, ast.Pass())
    length = items.length if isinstance(items, RegisterList) else len(items)
    place = from_start(c.code, index, length)
    if isinstance(items, RegisterList) or all(each is items[0] for each in items):  # no choice would tell
        inside = c.code.temporaries.take()
        c.code.row(op.IS_INDEX, inside, register_of(c.code, place), register_of(c.code, length))
        c.code.fault_unless(inside, "list index out of range")
    if not isinstance(items, RegisterList) and not items:
        raise ScenicError("value", "list index out of range")
    return element_at(c.code, items, place)


def from_start(code: Assembler, index: Value, length: Value) -> Value:
    """Return an index counted from the start of the list: a negative one counts from its end."""
    if isinstance(index, int):
        return index if index >= 0 else materialize(code, apply(ADD, length, index))
    index = materialize(code, index)
    negative = apply(LESS, index, 0)
    return materialize(code, choose(as_number(negative), [index, apply(ADD, index, length)]))


def place_of_key(c: Compilation, table: dict, key: Value) -> Value:
    """Return the place of a live key among those of a dictionary; a fault if it is not there."""
    if isinstance(key, RandomChoice):
        keys = list(table)
        known = [next((i for i, each in enumerate(keys) if each is option), len(keys)) for option in key.options]
        place = materialize(c.code, choose(key.index, known))
    else:
        place = len(table)
        for i, each in reversed(list(enumerate(table))):
            same = materialize(c.code, apply(EQUAL, each, key))
            place = choose(as_number(same), [place, i])
        place = materialize(c.code, place)
    inside = apply(LESS, place, len(table))
    c.code.fault_unless(register_of(c.code, inside), "the key is not in the dictionary")
    return place


def with_item(c: Compilation, scope: Scope, container: Value, index: Value, value: Value) -> Value:
    """Return a container with another element."""
    if isinstance(index, RandomExpr | RandomChoice | slice) or not isinstance(container, dict | list):
        what = f"elements of {describe_kind(container)}" if not isinstance(container, RegisterList) else "elements"
        raise refused(f"{what} where the match decides cannot be assigned", "use a variable for each of them")
    if isinstance(container, dict):
        return {**container, index: value}
    changed = list(container)
    changed[index] = value
    return changed


# ------------------------------------------------------------ adding


def appended(c: Compilation, items: Value, item: Value) -> Value:
    """Return a list with one more element."""
    if not isinstance(items, RegisterList):
        return [*items, item]
    longer = in_registers(c.code, items, item, LONGEST)
    put_with_room(c.code, longer, item)
    return longer


def put_with_room(code: Assembler, items: RegisterList, item: Value) -> None:
    """Put an element behind the last, in place; a fault if there is no room."""
    fits = code.temporaries.take()
    code.row(op.LESS, fits, items.registers[0], code.constant(items.type.capacity))
    code.fault_unless(fits, f"a list grows beyond {items.type.capacity} elements")
    put_at_end(code, items, item)


def put_at_end(code: Assembler, items: RegisterList, item: Value) -> None:
    """Put an element behind the last, in place."""
    element, length = items.type.element, items.registers[0]
    assert element is not None
    start = code.temporaries.take(element.size)
    registers = range(start, start + element.size)
    store(code, list(moves_to(element, iter(registers), item)))
    for i, register in enumerate(registers):
        code.row(op.STORE, items.registers[1 + i * items.type.capacity], length, register)
    code.row(op.ADD, length, length, code.constant(1))


class Gathered:
    """The elements of a comprehension in turn, and marks in the rows where they are added.

    If no match has a say in which they are, they are a fixed list; else the marks become rows that add to one in
    registers, whose type is known by then.
    """

    def __init__(self, code: Assembler) -> None:
        self.code = code
        self.values: list[Value] = []
        self.capacity = 0
        self.rounds = 1  # of the loops with one body around the present element
        self.live = False

    def add(self, value: Value) -> None:
        self.values.append(materialize(self.code, value))
        self.capacity += self.rounds
        self.code.rows.append(Row(ADD_HERE, len(self.values) - 1, 0, 0, self.code.place))

    def result(self, rows: list[Row]) -> Value:
        code = self.code
        if self.live and self.values:
            element, capacity = common_type(self.values), min(self.capacity, LONGEST)
            items = Place(code, ListType(element, capacity), code.variables).load()
            assert isinstance(items, RegisterList)
            register_of(code, 0, items.registers[0])
            put = put_at_end if capacity == self.capacity else put_with_room
        for row in rows:
            if row.opcode != ADD_HERE:
                code.rows.append(row)
            elif self.live:
                code.known.clear()
                put(code, items, self.values[row.a])
        code.known.clear()
        return items if self.live and self.values else self.values


def comprehension(c: Compilation, scope: Scope, node: ast.ListComp | ast.GeneratorExp) -> Value:
    """Return a list: fixed if its source and tests are."""
    gathered = Gathered(c.code)
    with c.code.captured() as rows:
        gather(c, scope, node.generators, node.elt, gathered)
    return gathered.result(rows)


def gather(c: Compilation, scope: Scope, generators: list, element: ast.expr, gathered: Gathered) -> None:
    """Write the rounds of the first generator, and in each those of the others."""
    first, *rest = generators

    def one_round(item: Value, following: Label) -> None:
        inner = scope.inner({})
        inner.transparent = True
        unpack(inner, first.target, item)
        for test in first.ifs:
            jump_on(c, inner, test, following, when=False)
        if c.code.reachable and rest:
            gather(c, inner, rest, element, gathered)
        elif c.code.reachable:
            gathered.add(inner.value(element))

    items = scope.value(first.iter)
    items = one_list(c, items) if isinstance(items, RandomChoice) else items
    if isinstance(items, RegisterList):
        one_body(c, items, gathered, one_round)
    else:
        body_for_each(c, elements(c, scope, items, first.iter), first.iter, gathered, one_round)


OneRound = Callable[[Value, Label], None]


def one_body(c: Compilation, items: RegisterList | list, gathered: Gathered, one_round: OneRound) -> None:
    """Write one body for all elements."""
    outer, gathered.live = gathered.rounds, True
    gathered.rounds *= items.type.capacity if isinstance(items, RegisterList) else len(items)
    with loop(c.code, items) as (item, _, following):
        one_round(item, following)
    gathered.rounds = outer


def body_for_each(c: Compilation, items: list, node: ast.AST, gathered: Gathered, one_round: OneRound) -> None:
    """Write a body for each element; from the first on that the match decides about one body for many objects."""
    code = c.code
    for i, item in enumerate(items):
        following, before = Label(), (len(gathered.values), gathered.capacity)
        with c.round(node, i), code.captured() as rows:
            one_round(item, following)
        decided = following.used and code.reachable
        code.reachable = True
        if decided and many(items[i:]):
            del gathered.values[before[0] :]
            gathered.capacity = before[1]
            one_body(c, items[i:], gathered, one_round)
            return
        gathered.live |= decided
        code.rows.extend(rows)
        if following.used:
            code.put(following)


# ------------------------------------------------------------ asking


def contains(c: Compilation, scope: Scope, node: ast.Compare, container: Value, item: Value) -> Value:
    """Return `item in container`."""
    if isinstance(container, Region):
        return membership(scope, node, whole_choice(item, c), container)
    if isinstance(container, RandomChoice):
        return over_options(c, container, lambda each: contains(c, scope, node, each, item))
    equals = partial(related, c, scope, node, ast.Eq(), item)
    if isinstance(container, RegisterList):
        return decided_by(c.code, container, equals, True)
    if isinstance(item, RandomExpr | RandomChoice) and not isinstance(container, str):
        inside: Value = False
        for same in map(equals, scope.elements(container, node)):
            inside = same if inside is False else apply(OR, inside, same)
        return inside
    return membership(scope, node, item, container)


def decided_by(code: Assembler, items: RegisterList, test: Callable[[Value], Value], decisive: bool) -> Value:
    """Return `decisive` if a test gives that for some element of a list, else the contrary."""
    result = code.variables.take()
    register_of(code, not decisive, result)
    with loop(code, items) as (item, _, following):
        jump(code, test(item), following, when=not decisive)
        register_of(code, decisive, result)
    return RegisterValue(result, "truth", lasting=False)
