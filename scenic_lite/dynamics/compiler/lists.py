"""Lists in a running match: filters, loops, indices, `in`, `append`, and the built-in functions of lists.

A fixed list is a Python list of values. A list that a match filters or extends is in registers, with its length in the
first register. Such a list can be read and iterated, but not sliced, concatenated or compared. All iteration uses
`rounds`: one shared body for many objects or for a list in registers, otherwise one body for each element. Read next:
`dynamics.compiler.expressions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial, reduce

from scenic_lite.core.checks import FAULTS, as_error
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Instance, RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.choices import jump_on, over_options, truth
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import jump, register_of
from scenic_lite.dynamics.compiler.registers import Place, materialize, moves_to, parts_of_list, place_for, store
from scenic_lite.dynamics.compiler.types import LONGEST, ListType, RegisterList, common_type, join, loaded, type_of
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import unpack
from scenic_lite.values.graph import RandomExpr, Value, apply, kind_of
from scenic_lite.values.operations import AND, LESS, NEGATE, OR

MANY = 8  # minimum number of objects for which a loop shares one body
DECIDED = "whose length the match decides"


@dataclass(frozen=True, eq=False)
class LiveRange:
    """A `range` with a fixed step whose ends may be live."""

    start: Value
    stop: Value
    step: int


def refused(what: str, hint: str = "write a loop or a comprehension") -> ScenicError:
    return ScenicError("unsupported", what, hint=hint)


def elements(c: Compilation, scope: Scope, value: Value, node: ast.AST) -> list[Value]:
    """Return the elements of a list of fixed length."""
    value = one_list(c, value)
    if isinstance(value, RegisterList | LiveRange):
        raise scope.placed(refused(f"a list {DECIDED} cannot be taken apart here"), node)
    return scope.elements(value, node)


def is_list(value: Value, of: Callable[[Iterable], bool] = all) -> bool:
    """Return whether a value is a list or tuple; for a choice, whether `all` or `any` of its options are."""
    if isinstance(value, RandomChoice):
        return of(is_list(option, of) for option in value.options)
    return isinstance(value, list | tuple | RegisterList)


def one_list(c: Compilation, value: Value) -> Value:
    """Convert a choice of lists to one list, in registers if the lengths differ; return other values unchanged."""
    if not isinstance(value, RandomChoice) or not is_list(value):
        return value
    length, items = parts_of_list(value)
    return items if isinstance(length, int) else in_registers(c.code, value)


def by_length(items: RegisterList) -> Value:
    """Convert a list to a choice of lists of fixed lengths, one for each possible length."""
    return choose(items.length, [[*map(items.at, range(length))] for length in range(items.type.capacity + 1)])


def over_lengths(c: Compilation, items: Value, of_one: Callable[[Value], Value]) -> Value:
    """Return `of_one` of a list of the actual length. Raises ScenicError if it fails for the maximum length."""
    choice = by_length(items)
    with c.code.captured():
        try:
            of_one(choice.options[-1])
        except FAULTS as fault:
            error = as_error(fault)
            raise refused(error.message, error.hint or f"it is a list {DECIDED}") from None
    return over_options(c, choice, of_one)


def in_registers(code: Assembler, items: Value, more: Value = None, capacity: int = 0) -> RegisterList:
    """Copy any list to registers; `more` is a further element that the list must be able to hold."""
    parts = parts_of_list(items)[1]
    own = items.type if isinstance(items, RegisterList) else ListType(common_type(parts), len(parts))
    element = own.element if more is None else join(own.element, type_of(more))
    place = Place(code, ListType(element, max(own.capacity, capacity, 1)), code.variables)
    place.store(items)
    return place.load()


# ------------------------------------------------------------ iteration
def are_objects(items: Value) -> bool:
    return isinstance(items, list | tuple) and all(isinstance(item, Instance) and item.label for item in items)


def many(items: Value) -> bool:
    """Return whether a loop over these objects should share one body."""
    return are_objects(items) and len(items) >= MANY


@contextmanager
def loop(
    code: Assembler, items: LiveRange | RegisterList | list | tuple
) -> Iterator[tuple[Value, RegisterValue, Label]]:
    """Repeat the rows inside the context for each element; yield it, its index and the next iteration's label."""
    if isinstance(items, LiveRange):
        stop = register_of(code, items.stop, code.variables.take())
        with code.rounds(stop, register_of(code, items.start), items.step) as (counter, following):
            yield counter, counter, following
        return
    count = items.registers[0] if isinstance(items, RegisterList) else code.constant(len(items))
    with code.rounds(count) as (counter, following):
        yield element_at(code, items, counter), counter, following


def rounds(code: Assembler, items: RegisterList | list) -> Iterator[tuple[Value, Value, Label]]:
    """Yield each element, its index and the next iteration's label; the caller writes the rows of the element."""
    if isinstance(items, RegisterList) or many(items):
        with loop(code, items) as whole:
            yield whole
        return
    for i, item in enumerate(items):
        following = Label()
        yield item, i, following
        code.put(following)


# ------------------------------------------------------------ comprehensions
def comprehension(c: Compilation, scope: Scope, node: ast.ListComp | ast.GeneratorExp) -> Value:
    """Return a list, fixed if the sources and tests are fixed, otherwise in registers."""
    with c.code.captured() as rows:
        fixed = fixed_elements(c, scope, node.generators, node.elt)
    if fixed is not None:
        c.code.rows.extend(rows)
        return fixed
    if len(node.generators) > 1:
        raise refused("a comprehension over several lists whose lengths the match decides", "write a loop")
    return filtered(c, scope, node.generators[0], node.elt)


def fixed_elements(c: Compilation, scope: Scope, generators: list, element: ast.expr) -> list[Value] | None:
    """Return the elements of a comprehension; None if they depend on the match."""
    first, *rest = generators
    items = one_list(c, scope.value(first.iter))
    if isinstance(items, RegisterList):
        return None
    result: list[Value] = []
    for i, item in enumerate(elements(c, scope, items, first.iter)):
        following = Label()
        with c.round(first, i):
            inner = tested(c, scope, first, item, following)
            if following.used and c.code.reachable:
                return None
            if c.code.reachable:
                more = fixed_elements(c, inner, rest, element) if rest else [materialize(c.code, inner.value(element))]
                if more is None:
                    return None
                result += more
        c.code.put(following)
    return result


def tested(c: Compilation, scope: Scope, generator: ast.comprehension, item: Value, following: Label) -> Scope:
    """Return the scope of one iteration; rows after the tests run only if all tests hold."""
    inner = scope.inner({})
    unpack(inner, generator.target, item)
    for test in generator.ifs:
        jump_on(c, inner, test, following, when=False)
    return inner


def filtered(c: Compilation, scope: Scope, generator: ast.comprehension, element: ast.expr) -> Value:
    """Return the list of a comprehension whose elements depend on the match."""
    code, items = c.code, one_list(c, scope.value(generator.iter))
    if not isinstance(items, RegisterList):
        items = elements(c, scope, items, generator.iter)
        items = items if are_objects(items) else in_registers(code, items)
    most = items.type.capacity if isinstance(items, RegisterList) else len(items)
    place = None
    with code.captured() as rows, loop(code, items) as (item, _, following):
        inner = tested(c, scope, generator, item, following)
        if code.reachable:
            value = inner.value(element)
            place = Place(code, ListType(type_of(value), min(most, LONGEST)), code.variables)
            put_item(code, place.load(), value, checked=most > LONGEST)
    if place is None:
        return []
    register_of(code, 0, place.registers[0])
    code.rows.extend(rows)
    return place.load()


# ------------------------------------------------------------ elements
def element_at(code: Assembler, items: RegisterList | list | tuple, index: Value) -> Value:
    """Return an element at an index within the list."""
    if not isinstance(items, RegisterList):
        return items[index] if isinstance(index, int) else choose(index, items)
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


# ------------------------------------------------------------ append
def appended(c: Compilation, items: Value, item: Value) -> Value:
    """Return a list with one more element."""
    if not isinstance(items, RegisterList):
        return [*items, item]
    longer = in_registers(c.code, items, item, LONGEST)
    put_item(c.code, longer, item)
    return longer


def put_item(code: Assembler, items: RegisterList, item: Value, checked: bool = True) -> None:
    """Append an element in place; with `checked`, a match in which the list is full faults."""
    (element, capacity), length = (items.type.element, items.type.capacity), items.registers[0]
    assert element is not None
    if checked:
        fits = code.temporaries.take()
        code.row(op.LESS, fits, length, code.constant(capacity))
        code.fault_unless(fits, f"a list grows beyond {capacity} elements")
    start = code.temporaries.take(element.size)
    registers = range(start, start + element.size)
    store(code, list(moves_to(element, iter(registers), item)))
    for i, register in enumerate(registers):
        code.row(op.STORE, items.registers[1 + i * capacity], length, register)
    code.row(op.ADD, length, length, code.constant(1))


# ------------------------------------------------------------ functions
def to_range(c: Compilation, scope: Scope, node: ast.AST, *ends: Value) -> Value:
    """Return `range` with live ends."""
    if not any(isinstance(end, RandomExpr) for end in ends):
        return NotImplemented
    start, stop, step = [0, *ends, 1] if len(ends) == 1 else [*ends, 1][:3]
    if not isinstance(step, int) or step == 0:
        raise refused("the step of a range must be a fixed integer in a match", "")
    return LiveRange(materialize(c.code, start), materialize(c.code, stop), step)


def folded(decisive: bool, c: Compilation, scope: Scope, node: ast.AST, values: Value) -> Value:
    """Return `any` or `all` of truth values that may be live."""
    if not isinstance(values, list | tuple):
        return NotImplemented
    return reduce(partial(apply, OR if decisive else AND), map(truth, values), not decisive)


def extreme(
    least: bool, c: Compilation, scope: Scope, node: ast.AST, *values: Value, key: Value = None, default: Value = ...
) -> Value:
    """Return `min` or `max` with a key, or of a list in registers; the first of equal elements."""
    code, number = c.code, partial(number_of, c, scope, node, key)
    items = one_list(c, values[0]) if len(values) == 1 else values
    if not isinstance(items, RegisterList):
        if key is None or not (items := [materialize(code, item) for item in elements(c, scope, items, node)]):
            return NotImplemented
    elif default is not ...:
        place = place_for(code, [default, items.at(0)])
        place.store(default)
        with code.when(items.registers[0]):
            place.store(element_at(code, items, place_of_extreme(code, items, number, least)))
        return place.load()
    else:
        code.fault_unless(items.registers[0], "the least or greatest of no values")
    return element_at(code, items, place_of_extreme(code, items, number, least))


def place_of_extreme(code: Assembler, items: Value, number: Callable[[Value], Value], least: bool) -> RegisterValue:
    """Return the index of the first element with the least, or the greatest, number."""
    best = RegisterValue(code.variables.take())
    chosen = RegisterValue(code.variables.take(), whole=True)
    for item, place, following in rounds(code, items):
        mark, better = materialize(code, number(item)), Label()
        if isinstance(place, RegisterValue):
            code.row(op.JUMP_EQUAL, place.register, code.constant(0), better)
        if isinstance(place, RegisterValue) or place > 0:
            jump(code, apply(LESS, *((mark, best) if least else (best, mark))), following, when=False)
        code.put(better)
        register_of(code, mark, best.register)
        register_of(code, place, chosen.register)
    return chosen


def number_of(c: Compilation, scope: Scope, node: ast.AST, key: Value, item: Value) -> Value:
    """Return the number that represents an element in comparisons."""
    number = item if key is None else scope.call(key, [item], {}, node)
    if isinstance(number, RegisterList) or kind_of(number) not in ("number", "truth"):
        what = f"in a match elements are compared by numbers, not by {describe_kind(number)}"
        raise refused(what, "give a key that is a number")
    return number


def in_order(
    c: Compilation, scope: Scope, node: ast.AST, values: Value, key: Value = None, reverse: Value = False
) -> Value:
    """Return `sorted` with live keys, as a list in registers."""
    code = c.code
    if isinstance(reverse, RandomExpr):
        raise refused("whether a list is sorted in reverse must be fixed in a match", "")
    values = one_list(c, values)
    if not isinstance(values, RegisterList):
        values = [materialize(code, item) for item in elements(c, scope, values, node)]
        with code.captured():
            keys = values if key is None else [scope.call(key, [item], {}, node) for item in values]
        if not any(isinstance(mark, RandomExpr | RandomChoice) for mark in keys):
            return NotImplemented
    items = values if isinstance(values, RegisterList) else in_registers(code, values)
    numbers, order = (code.variables.take(items.type.capacity) for _ in range(2))
    for item, place, _ in rounds(code, values):
        number = number_of(c, scope, node, key, item)
        number = register_of(code, apply(NEGATE, number) if reverse else number)
        code.row(op.STORE, numbers, register_of(code, place), number)
    code.row(op.SORT, order, numbers, items.registers[0])
    return permuted(code, items, order)


def permuted(code: Assembler, items: RegisterList, order: int) -> RegisterList:
    """Return the elements in the order of the indices in registers from `order` on."""
    ordered = Place(code, items.type, code.variables).load()
    register_of(code, items.length, ordered.registers[0])
    place, value = code.temporaries.take(), code.temporaries.take()
    with code.rounds(items.registers[0]) as (counter, _):
        code.row(op.LOAD_INDEXED, place, order, counter.register)
        for first in range(1, items.type.size, items.type.capacity):
            code.row(op.LOAD_INDEXED, value, items.registers[first], place)
            code.row(op.STORE, ordered.registers[first], counter.register, value)
    return ordered


# The arguments are those of the evaluator's functions; after NotImplemented, the evaluator's function is called.
FUNCTIONS: dict[str, Callable[..., Value]] = {
    "len": lambda c, scope, node, value: value.length if isinstance(value, RegisterList) else NotImplemented,
    "range": to_range,
    "bool": lambda c, scope, node, value=False: truth(value),
    "list": lambda c, scope, node, values=(): values if isinstance(values, RegisterList) else NotImplemented,
    "any": partial(folded, True),
    "all": partial(folded, False),
    "min": partial(extreme, True),
    "max": partial(extreme, False),
    "sorted": in_order,
}
