"""Values to registers and back: simultaneous moves, registers of values, and typed variables.

Read next: `dynamics.compiler.compilation`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice

from scenic_lite.core.types import RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler.code import TEMPORARIES, Area, Assembler
from scenic_lite.dynamics.compiler.emit import is_whole, register_of
from scenic_lite.dynamics.compiler.types import (
    ListType,
    OneOf,
    RegisterList,
    Scalar,
    Struct,
    Type,
    common_type,
    flatten,
    join,
    loaded,
    option_for,
    type_of,
    varies,
    with_parts,
    with_registers,
)
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue, leaves
from scenic_lite.errors import ScenicError
from scenic_lite.values.graph import RandomExpr, Value, apply, select
from scenic_lite.values.operations import ADD

Move = tuple[int, Value]  # (register, the number, truth value or text to store)


def moves_to(type: Type, registers: Iterator[int], value: Value) -> Iterator[Move]:
    """Yield the moves that store a value of the type in the registers."""
    if isinstance(type, Scalar):
        yield next(registers), value
    elif isinstance(type, Struct):
        for part, own in zip(type.parts, parts_of_value(type, value), strict=True):
            yield from moves_to(part, registers, own)
    elif isinstance(type, OneOf):
        yield from option_moves(type, registers, value)
    elif isinstance(type, ListType):
        yield from list_moves(type, list(islice(registers, type.size)), value)


def parts_of_value(type: Struct, value: Value) -> list[Value]:
    if isinstance(value, RandomChoice):
        columns = zip(*(parts_of_value(type, option) for option in value.options), strict=True)
        return [choose(value.index, list(column)) for column in columns]
    apart = flatten(value)
    if apart is None or apart[0] != type.head:
        raise ScenicError("type", f"{describe_kind(value)} where something else was expected")
    return apart[1]


def option_moves(type: OneOf, registers: Iterator[int], value: Value) -> Iterator[Move]:
    tag = next(registers)
    several = isinstance(value, RandomChoice) and type_of(value) not in type.options  # those of a scene may be one
    value = unnested(value) if several else value
    options = value.options if several else (value,)
    places = [option_for(type, option) for option in options]
    yield tag, renumbered(value.index, places) if several else places[0]
    for i, option in enumerate(type.options):
        own = list(islice(registers, option.size))
        held = [part for part, place in zip(options, places, strict=True) if place == i]
        if held and own:
            filled = [part if place == i else held[0] for part, place in zip(options, places, strict=True)]
            yield from moves_to(option, iter(own), held[0] if len(held) == 1 else choose(value.index, filled))


def unnested(choice: RandomChoice) -> RandomChoice:
    """Flatten a choice, so that no option is a choice."""
    if not any(isinstance(option, RandomChoice) for option in choice.options):
        return choice
    options: list[Value] = []
    places: list[Value] = []
    for option in choice.options:
        inner = unnested(option) if isinstance(option, RandomChoice) else None
        places.append(len(options) if inner is None else apply(ADD, inner.index, len(options)))
        options += (option,) if inner is None else inner.options
    return RandomChoice(select(choice.index, tuple(places)), tuple(options))


def renumbered(index: RandomExpr, numbers: list[int]) -> Value:
    """Return numbers[index]: the index itself if they are 0, 1, 2, ..."""
    return index if numbers == list(range(len(numbers))) else choose(index, numbers)


def list_moves(type: ListType, registers: list[int], value: Value) -> Iterator[Move]:
    cells = registers[1:]
    if isinstance(value, RegisterList) and value.type == type:
        yield from zip(registers, map(RegisterValue, value.registers), strict=True)
        return
    length, elements = parts_of_list(value)
    yield registers[0], length
    if len(elements) > type.capacity:
        raise ScenicError("budget", f"a list of more than {type.capacity} elements whose length varies")
    if type.element is not None:
        for i, element in enumerate(elements):
            yield from moves_to(type.element, iter(cells[i :: type.capacity]), element)


def parts_of_list(value: Value) -> tuple[Value, list[Value]]:
    """Return the length and all possible elements of a list, or of the actual list of a choice of lists."""
    if isinstance(value, RegisterList):
        return value.length, [value.at(i) for i in range(value.type.capacity if value.type.element is not None else 0)]
    if not isinstance(value, RandomChoice):
        return len(value), list(value)
    lengths, lists = zip(*map(parts_of_list, value.options), strict=True)
    places = range(max(map(len, lists)))
    there = [next(own[i] for own in lists if i < len(own)) for i in places]  # never read after a list's end
    elements = [choose(value.index, [own[i] if i < len(own) else there[i] for own in lists]) for i in places]
    return lengths[0] if all(length is lengths[0] for length in lengths) else choose(value.index, lengths), elements


# ------------------------------------------------------------ moving
def store(code: Assembler, moves: list[Move]) -> None:
    """Move all values into their registers, with the effect of simultaneous moves."""
    moves = [(to, value) for to, value in moves if not (isinstance(value, RegisterValue) and value.register == to)]
    targets = {to for to, _ in moves}
    if len(moves) == 1 or targets.isdisjoint(leaf.register for _, value in moves for leaf in leaves(value)):
        for to, value in moves:
            register_of(code, value, to)
        return
    sources = [register_of(code, value) for _, value in moves]
    for i, register in enumerate(sources):
        if register in targets:
            sources[i] = code.temporaries.take()
            register_of(code, RegisterValue(register), sources[i])
    for (to, _), register in zip(moves, sources, strict=True):
        register_of(code, RegisterValue(register), to)


# ------------------------------------------------------------ registers of values
class Place:
    """Registers that hold a value of a type."""

    def __init__(self, code: Assembler, type: Type, area: Area) -> None:
        self.code, self.type = code, type
        start = area.take(type.size)
        self.registers = range(start, start + type.size)

    def load(self) -> Value:
        return loaded(self.type, iter(self.registers))

    def store(self, value: Value) -> None:
        if isinstance(value, RegisterList) and value.type == self.type:
            self.code.row(op.COPY_MANY, self.registers[0], value.registers[0], self.type.size)
        else:
            store(self.code, list(moves_to(self.type, iter(self.registers), value)))


def place_for(code: Assembler, values: list[Value]) -> Place:
    """Return registers that can hold any of the values."""
    common = common_type(values)
    assert common is not None
    return Place(code, common, code.variables)


def store_in_register(code: Assembler, value: Value) -> Value:
    """Copy the varying parts of a value into permanent registers."""
    if not varies(value):
        return value
    place = Place(code, type_of(value), code.variables)
    place.store(value)
    return place.load()


def materialize(code: Assembler, value: Value, area: Area | None = None) -> Value:
    """Compute the parts of a value now, so that later reads do not compute them again.

    The results are valid until the end of the statement, or with `area` for the lifetime of that area.
    """
    if isinstance(value, RegisterValue | RegisterList):
        read = value.registers if isinstance(value, RegisterList) else (value.register,)
        return store_in_register(code, value) if area is not None and max(read) >= TEMPORARIES else value
    if not varies(value):
        return value
    if isinstance(value, RandomChoice) or flatten(value) is not None:
        return with_parts(value, lambda part: materialize(code, part, area))
    return RegisterValue(register_of(code, value, None if area is None else area.take()), value.kind, is_whole(value))


# ------------------------------------------------------------ variables
@dataclass
class TypeTable:
    """The types of all variables by key, as found in the passes so far."""

    types: dict[tuple, Type] = field(default_factory=dict)
    read: set[tuple] = field(default_factory=set)  # keys read in this pass
    changed_types: set[tuple] = field(default_factory=set)  # keys read in this pass whose types changed afterwards
    marked: set[tuple] = field(default_factory=set)  # keys with a register that records the assignment

    def declare(self, key: tuple, type: Type) -> bool:
        """Extend the type of a variable by `type`; return whether its type has changed."""
        before = self.types.get(key)
        after = join(before, type)
        if after == before:
            return False
        assert after is not None
        self.types[key] = after
        if key in self.read:
            self.changed_types.add(key)
        return True

    def settle(self, path: tuple) -> bool:
        """Return whether the inlined body must be compiled again; if so, forget its reads and type changes."""
        own = {key for key in self.changed_types if key[: len(path)] == path}
        if own:
            self.changed_types -= own
            self.read = {key for key in self.read if key[: len(path)] != path}
        return bool(own)


class Variable:
    """A variable in registers."""

    def __init__(self, code: Assembler, table: TypeTable, key: tuple, shared: bool = False) -> None:
        self.code, self.table, self.key = code, table, key
        self.area = code.fixed if shared else code.variables
        type = table.types.get(key)
        self.place = None if type is None else Place(code, type, self.area)
        self.mark = self.area.take() if key in table.marked else None

    def load(self) -> Value:
        if self.place is None:
            return None
        self.table.read.add(self.key)
        return self.place.load()

    def declare(self, value: Value) -> Place:
        """Allocate registers for a value."""
        if self.table.declare(self.key, with_registers(type_of(value))) or self.place is None:
            self.place = Place(self.code, self.table.types[self.key], self.area)
        return self.place

    def store(self, value: Value) -> None:
        place = self.declare(value)
        self.table.read.add(self.key)
        place.store(value)
        if self.mark is not None:
            self.code.row(op.COPY, self.mark, self.code.constant(1))
