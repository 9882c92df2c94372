"""Storing values by their shapes, and the slots of variables that keep theirs in registers.

Read next: `dynamics.compiler.compilation`, whose variables these are.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from scenic_lite.core.types import RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.code import Assembler
from scenic_lite.dynamics.compiler.emit import is_whole, register_of
from scenic_lite.dynamics.compiler.types import (
    CAPACITY,
    Items,
    Leaf,
    Parts,
    RegisterList,
    Same,
    Shape,
    Variant,
    flatten,
    join,
    loaded,
    option_for,
    shape_of,
    unflatten,
    varies,
    varying,
)
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value

FEW = 4  # registers: more are copied by one row
Pair = tuple[int, Value]  # a register, and the number, truth value or text that goes there


def pairs(shape: Shape, registers: Iterator[int], value: Value) -> Iterator[Pair]:
    """What must be put where, so that some registers hold a value that fits the shape."""
    if isinstance(shape, Same):
        return
    if isinstance(shape, Leaf):
        yield next(registers), value
    elif isinstance(shape, Parts):
        for part, each in zip(shape.parts, parts_of_value(shape, value), strict=True):
            yield from pairs(part, registers, each)
    elif isinstance(shape, Variant):
        yield from variant_pairs(shape, registers, value)
    elif isinstance(shape, Items):
        yield from list_pairs(shape, list(islice(registers, shape.size)), value)


def parts_of_value(shape: Parts, value: Value) -> list[Value]:
    if isinstance(value, RandomChoice):
        columns = zip(*(parts_of_value(shape, option) for option in value.options), strict=True)
        return [choose(value.index, list(column)) for column in columns]
    apart = flatten(value)
    if apart is None or apart[0] != shape.head:
        raise ScenicError("type", f"{describe_kind(value)} where something else was expected")
    return apart[1]


def variant_pairs(shape: Variant, registers: Iterator[int], value: Value) -> Iterator[Pair]:
    tag = next(registers)
    options = value.options if isinstance(value, RandomChoice) else (value,)
    places = [option_for(shape, option) for option in options]
    if isinstance(value, RandomChoice):
        yield tag, value.index if places == list(range(len(places))) else choose(value.index, places)
    else:
        yield tag, places[0]
    for i, option in enumerate(shape.options):
        own = list(islice(registers, option.size))
        chosen = [each for each, place in zip(options, places, strict=True) if place == i]
        if not chosen or not own:
            continue
        if isinstance(value, RandomChoice) and len(chosen) > 1:
            filled = [each if place == i else chosen[0] for each, place in zip(options, places, strict=True)]
            yield from pairs(option, iter(own), choose(value.index, filled))
        else:
            yield from pairs(option, iter(own), chosen[0])


def list_pairs(shape: Items, registers: list[int], value: Value) -> Iterator[Pair]:
    length, cells = registers[0], registers[1:]
    if isinstance(value, RegisterList):
        if value.element == shape.element:
            yield from zip(registers, (RegisterValue(each) for each in value.registers), strict=True)
            return
        yield length, value.length
        count = CAPACITY if value.element is not None else 0
        elements = [loaded(value.element, iter(value.registers[1 + i :: CAPACITY])) for i in range(count)]  # type: ignore[arg-type]
    else:
        elements = list(value)
        if len(elements) > CAPACITY:
            raise ScenicError("budget", f"a list of more than {CAPACITY} elements whose length varies")
        yield length, len(elements)
    if shape.element is None:
        return
    for i, element in enumerate(elements):
        yield from pairs(shape.element, iter(cells[i::CAPACITY]), element)


def store(code: Assembler, moves: list[Pair]) -> None:
    """Put all values into their registers, as if at once."""
    moves = [(to, value) for to, value in moves if not (isinstance(value, RegisterValue) and value.register == to)]
    targets = {to for to, _ in moves}
    if len(moves) == 1 or not any(targets & registers_in(value) for _, value in moves):
        for to, value, count in runs(moves):
            if count < FEW:
                register_of(code, value, to)
            else:
                code.row(op.COPY_MANY, to, value.register, count)
        return
    found = [register_of(code, value) for _, value in moves]
    for i, register in enumerate(found):
        if register in targets:
            found[i] = code.temporaries.take()
            register_of(code, RegisterValue(register), found[i])
    for (to, _), register in zip(moves, found, strict=True):
        register_of(code, RegisterValue(register), to)


def runs(moves: list[Pair]) -> Iterator[tuple[int, Value, int]]:
    """The moves, those of many neighbours to neighbours as one: target, value, how many."""
    at = 0
    while at < len(moves):
        to, value = moves[at]
        count = 1
        while (
            at + count < len(moves)
            and isinstance(value, RegisterValue)
            and follows(moves[at], moves[at + count], count)
        ):
            count += 1
        if count >= FEW:
            yield to, value, count
        else:
            yield from ((*each, 1) for each in moves[at : at + count])
        at += count


def follows(first: Pair, other: Pair, distance: int) -> bool:
    (to, value), (after, following) = first, other
    return (
        after == to + distance
        and isinstance(following, RegisterValue)
        and following.register == value.register + distance
    )


def registers_in(value: Value) -> set[int]:
    """The registers that computing a value reads."""
    found: set[int] = set()
    pending, seen = [value], set()
    while pending:
        node = pending.pop()
        if isinstance(node, RegisterValue):
            found.add(node.register)
        elif isinstance(node, RandomExpr) and id(node) not in seen:
            seen.add(id(node))
            pending.extend(node.inputs)
    return found


def kept(code: Assembler, value: Value) -> Value:
    """A value with everything in it that varies copied into registers of its own, where it lasts."""
    if not varies(value):
        return value
    shape = shape_of(value)
    start = code.variables.take(shape.size)
    registers = range(start, start + shape.size)
    store(code, list(pairs(shape, iter(registers), value)))
    return loaded(shape, iter(registers))


def copied(code: Assembler, value: Value) -> Value:
    """A value as it is now, whatever is assigned before the statement ends."""
    if not varies(value):
        return value
    shape = shape_of(value)
    start = code.temporaries.take(shape.size)
    store(code, list(pairs(shape, iter(range(start, start + shape.size)), value)))
    return loaded(shape, iter(range(start, start + shape.size)))


def settled(code: Assembler, value: Value) -> Value:
    """A value with everything in it computed now, so that it is not computed again wherever it is read."""
    if isinstance(value, RegisterValue) or not varies(value):
        return value
    if isinstance(value, RegisterList):
        return value
    if isinstance(value, RandomChoice):
        return RandomChoice(settled(code, value.index), tuple(settled(code, each) for each in value.options))
    apart = flatten(value)
    if apart is not None:
        return unflatten(apart[0], [settled(code, each) for each in apart[1]])
    return RegisterValue(register_of(code, value), value.kind, is_whole(value), lasting=False)


class Slot:
    """A variable in registers. Its shape is remembered from one compilation to the next, until nothing widens it.

    `varying`: its numbers will hardly stay the same, so that they are given registers at once.
    """

    def __init__(
        self, code: Assembler, shapes: dict[tuple, Shape], key: tuple, shared: bool = False, varying: bool = False
    ) -> None:
        self.code, self.shapes, self.key, self.varying = code, shapes, key, varying
        self.area = code.fixed if shared else code.variables
        self._place()

    def _place(self) -> None:
        size = 0 if self.shape is None else self.shape.size
        start = self.area.take(size)
        self.registers = range(start, start + size)

    @property
    def shape(self) -> Shape | None:
        return self.shapes.get(self.key)

    @property
    def value(self) -> Value:
        shape = self.shape
        if shape is None:
            return None
        self.code.relied_on.add(self.key)
        return loaded(shape, iter(self.registers))

    def widen(self, value: Value) -> None:
        """Make room for a value."""
        own = shape_of(value)
        shape = join(self.shape, varying(own) if self.varying else own)
        if shape != self.shape:
            assert shape is not None
            self.shapes[self.key] = shape
            if self.key in self.code.relied_on:
                self.code.widened.add(self.key)
            self._place()

    def store(self, value: Value) -> None:
        self.widen(value)
        shape = self.shape
        assert shape is not None
        self.code.relied_on.add(self.key)
        store(self.code, list(pairs(shape, iter(self.registers), value)))
