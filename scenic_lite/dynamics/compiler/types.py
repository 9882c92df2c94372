"""Types: the part of a variable's value that is known before a match, and the number of registers for the rest.

Every variable has one type, which the program's assignments determine. `Const` is one fixed value and needs no
register. `Scalar` is a number, truth value or text. `Struct` is a composite such as a vector, tuple or region.
`ListType` is a list of varying length. `OneOf` is one of several values, such as an object or None.
Read next: `dynamics.compiler.registers`, which stores values by their types.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from scenic_lite.core.types import BehaviorCall, Bound, Function, Instance, RandomChoice, Undecided, describe_kind
from scenic_lite.dynamics.compiler.emit import is_live, is_whole
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Table, Value, kind_of
from scenic_lite.values.operations import SELECT
from scenic_lite.values.regions import Region

MOST_OPTIONS = 256
LONGEST = 64  # maximum number of elements of a list that grows during a match
SIMPLE = frozenset({RegisterValue, int, float, bool, str, type(None), Function})


class Type:
    """The known part of a value; `size`: the number of registers that hold the rest."""

    size = 0


@dataclass(frozen=True)
class Scalar(Type):
    """A number, truth value or text in one register; `whole`: an integer, whose text has no decimal point."""

    kind: str
    whole: bool
    size = 1


@dataclass(frozen=True, eq=False)
class Const(Type):
    """A fixed value, or a value that the scene determines."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return type(other) is Const and (self.value is other.value or alike(self.value, other.value))


@dataclass(frozen=True)
class Struct(Type):
    """A structure whose parts may vary; `head` is the information to rebuild it."""

    head: tuple
    parts: tuple[Type, ...]

    @property
    def size(self) -> int:  # type: ignore[override]
        return sum(part.size for part in self.parts)


@dataclass(frozen=True)
class OneOf(Type):
    """A choice; the first register selects the option. An option None comes last."""

    options: tuple[Type, ...]

    @property
    def size(self) -> int:  # type: ignore[override]
        return 1 + sum(option.size for option in self.options)


@dataclass(frozen=True)
class ListType(Type):
    """A list of at most `capacity` elements of one type: its length, the first register of each element, and so on."""

    element: Type | None  # None if the list is always empty
    capacity: int

    @property
    def size(self) -> int:  # type: ignore[override]
        return 1 + self.capacity * (0 if self.element is None else self.element.size)


@dataclass(frozen=True, eq=False)
class RegisterList(Undecided):
    """A list in registers; the first register holds the length."""

    type: ListType
    registers: tuple[int, ...]

    @property
    def length(self) -> RegisterValue:
        return RegisterValue(self.registers[0], whole=True)

    def at(self, index: int) -> Value:
        """Return the element at a known index."""
        element = self.type.element
        return None if element is None else loaded(element, iter(self.registers[1 + index :: self.type.capacity]))


def alike(a: Value, b: Value) -> bool:
    """Return whether two fixed values are interchangeable."""
    if a is b:
        return True
    if isinstance(a, RandomExpr) or isinstance(b, RandomExpr) or type(a) is not type(b):
        return False
    if isinstance(a, bool | int | float | str):
        return a == b
    if isinstance(a, Function):
        return a.body is b.body
    if isinstance(a, RandomChoice):
        return a.index is b.index and alike(a.options, b.options)
    first, second = flatten(a), flatten(b)
    if first is None or second is None or first[0] != second[0]:
        return False
    return all(map(alike, first[1], second[1]))


# ------------------------------------------------------------ structures
def flatten(value: Value) -> tuple[tuple, list[Value]] | None:
    """Split a structure into its head and its parts; return None for other values."""
    if type(value) in SIMPLE or (type(value) is Instance and value.label):
        return None
    if isinstance(value, Vector):
        return (Vector,), [value.x, value.y]
    if isinstance(value, list | tuple):
        return (type(value), len(value)), list(value)
    if isinstance(value, dict):
        return (dict, tuple(value)), list(value.values())
    if isinstance(value, Region):
        return (type(value), tuple(vars(value))), list(vars(value).values())
    if isinstance(value, Bound):
        return (Bound, value.function), [value.receiver]
    if isinstance(value, BehaviorCall):
        return (BehaviorCall, value.behavior, tuple(value.arguments), value.place), list(value.arguments.values())
    if isinstance(value, Instance) and not value.label:  # an oriented point that an operator returns
        return (Instance, value.cls, value.place, tuple(value.properties)), list(value.properties.values())
    if builds_text(value):
        return (RandomExpr, value.operation, len(value.inputs)), list(value.inputs)
    return None


def unflatten(head: tuple, parts: list[Value]) -> Value:
    """Rebuild a structure from its head and its parts."""
    kind, *rest = head
    if kind is Vector:
        return Vector(*parts)
    if kind in (list, tuple):
        return kind(parts)
    if kind is dict:
        return dict(zip(rest[0], parts, strict=True))
    if kind is Bound:
        return Bound(rest[0], parts[0])
    if kind is BehaviorCall:
        return BehaviorCall(rest[0], dict(zip(rest[1], parts, strict=True)), rest[2])
    if kind is Instance:
        return Instance(rest[0], rest[1], properties=dict(zip(rest[2], parts, strict=True)))
    if kind is RandomExpr:
        return RandomExpr(rest[0], tuple(parts), "text")
    region = object.__new__(kind)
    vars(region).update(zip(rest[0], parts, strict=True))
    return region


def with_parts(value: Value, change: Callable[[Value], Value]) -> Value:
    """Apply `change` to the parts of a choice or structure; return other values unchanged."""
    if isinstance(value, RandomChoice):
        return RandomChoice(change(value.index), tuple(map(change, value.options)))
    apart = flatten(value)
    return value if apart is None else unflatten(apart[0], list(map(change, apart[1])))


def builds_text(value: Value) -> bool:
    """Return whether the match composes a text, which then has no number."""
    if not isinstance(value, RandomExpr) or isinstance(value, RegisterValue) or value.kind != "text":
        return False
    if value.operation is SELECT.array:
        return any(map(builds_text, value.inputs[1:]))
    return bool(value.inputs) and not isinstance(value.operation, Table)


def varies(value: Value) -> bool:
    """Return whether any part of a value depends on the running match."""
    if type(value) in SIMPLE:
        return type(value) is RegisterValue
    if isinstance(value, RandomExpr):
        return is_live(value)
    if isinstance(value, RegisterList):
        return True
    if isinstance(value, RandomChoice):
        return is_live(value.index) or any(map(varies, value.options))
    apart = flatten(value)
    return apart is not None and any(map(varies, apart[1]))


# ------------------------------------------------------------ types of values
def type_of(value: Value) -> Type:
    """Return the narrowest type of a value."""
    if not varies(value):
        return Const(value)
    if isinstance(value, RegisterList):
        return value.type
    if isinstance(value, RandomChoice):
        return one_of([type_of(option) for option in value.options])
    apart = flatten(value)
    if apart is not None:
        return Struct(apart[0], tuple(map(type_of, apart[1])))
    return Scalar(value.kind, is_whole(value))


def common_type(values: list[Value]) -> Type | None:
    """Return the least type that can hold each of the values."""
    common: Type | None = None
    for value in values:
        common = join(common, type_of(value))
    return common


def with_registers(type: Type) -> Type:
    """Return a type with registers for fixed numbers, truth values and texts, since these are likely to vary."""
    own = opened(type)
    if isinstance(own, Struct):
        return Struct(own.head, tuple(map(with_registers, own.parts))) if own.head[0] in (tuple, Vector) else type
    return own


def join(a: Type | None, b: Type | None) -> Type | None:
    """Return the least type that contains the values of both types."""
    if a is None or b is None or a == b:
        return b if a is None else a
    return merge(a, b) or one_of([a, b])


def merge(a: Type, b: Type) -> Type | None:
    """Return a type for both that is not a new choice, or None."""
    if a == b:
        return a
    if isinstance(a, OneOf) or isinstance(b, OneOf):
        return one_of([a, b])
    a, b = opened(a), opened(b)
    if isinstance(a, Scalar) and isinstance(b, Scalar):
        if "text" in (a.kind, b.kind) and a.kind != b.kind:
            return None
        return Scalar(a.kind if a.kind == b.kind else "number", a.whole and b.whole)
    if isinstance(a, Struct) and isinstance(b, Struct) and a.head == b.head:
        return Struct(a.head, tuple(map(join, a.parts, b.parts)))  # type: ignore[arg-type]
    first, second = as_list(a), as_list(b)
    if first is None or second is None:
        return None
    grows = isinstance(a, ListType) or isinstance(b, ListType)
    return ListType(join(first.element, second.element), max(first.capacity, second.capacity) if grows else LONGEST)


def opened(type: Type) -> Type:
    """Convert the type of a fixed value to a scalar or structure type, if possible."""
    if not isinstance(type, Const):
        return type
    if kind_of(type.value) in ("number", "truth", "text") and not builds_text(type.value):
        return Scalar(kind_of(type.value), is_whole(type.value))
    apart = flatten(type.value)
    return type if apart is None else Struct(apart[0], tuple(map(type_of, apart[1])))


def as_list(type: Type) -> ListType | None:
    """Convert the type of a list to a type of varying length; return None for other types."""
    if isinstance(type, Struct) and type.head[0] is list:
        element: Type | None = None
        for part in type.parts:
            element = join(element, part)
        return ListType(element, len(type.parts))
    return type if isinstance(type, ListType) else None


def one_of(types: list[Type]) -> Type:
    """Return a choice of types, after merging compatible types."""
    options: list[Type] = []
    for type in types:
        for option in type.options if isinstance(type, OneOf) else (type,):
            add_option(options, option)
    if len(options) > MOST_OPTIONS:
        raise ScenicError("budget", f"a variable can be more than {MOST_OPTIONS} different things")
    options.sort(key=lambda option: isinstance(option, Const) and option.value is None)
    return options[0] if len(options) == 1 else OneOf(tuple(options))


def add_option(options: list[Type], type: Type) -> None:
    for i, option in enumerate(options):
        together = merge(option, type)
        if together is not None:
            options[i] = together
            return
    options.append(type)


def option_for(type: OneOf, value: Value) -> int:
    """Return the index of the option that can hold a value."""
    own = type_of(value)
    for i, option in enumerate(type.options):
        if option == own or (not isinstance(option, Const) and merge(option, own) == option):
            return i
    raise ScenicError("type", f"{describe_kind(value)} where something else was expected")


def loaded(type: Type, registers: Iterator[int]) -> Value:
    """Return the value of a type in registers."""
    if isinstance(type, Const):
        return type.value
    if isinstance(type, Scalar):
        return RegisterValue(next(registers), type.kind, type.whole)
    if isinstance(type, Struct):
        return unflatten(type.head, [loaded(part, registers) for part in type.parts])
    if isinstance(type, ListType):
        return RegisterList(type, tuple(next(registers) for _ in range(type.size)))
    assert isinstance(type, OneOf)
    tag = RegisterValue(next(registers), whole=True)
    return RandomChoice(tag, tuple(loaded(option, registers) for option in type.options))
