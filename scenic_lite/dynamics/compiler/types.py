"""Shapes: what is known of a variable while a program is compiled, and which registers hold the rest.

A variable that is assigned under control flow that is decided during a match has one shape throughout: the least that
all its values fit into. `Same` is one fixed value and needs no register, `Leaf` is a number, truth value or text,
`Parts` a vector, tuple, region, ... of such, `Variant` one of several (an object or None), `Items` a list whose
length varies. A program is compiled again until no shape widens. Read next: `dynamics.compiler.registers`, which
stores values by shapes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from scenic_lite.core.types import BehaviorCall, Bound, Function, Instance, RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.emit import is_live, is_whole
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.strings import FormatEach
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Table, Value, kind_of
from scenic_lite.values.operations import SELECT
from scenic_lite.values.regions import Region

MOST_OPTIONS = 256
CAPACITY = 64  # elements of a list whose length is not known before the match


class Shape:
    """What is known of a value."""

    size = 0  # registers


@dataclass(frozen=True)
class Leaf(Shape):
    """One register."""

    kind: str
    whole: bool
    size = 1


@dataclass(frozen=True, eq=False)
class Same(Shape):
    """A fixed value, or one that the scene fixes."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return type(other) is Same and (self.value is other.value or alike(self.value, other.value))


@dataclass(frozen=True)
class Parts(Shape):
    """A structure whose parts may differ; `head` says how to put it together again."""

    head: tuple
    parts: tuple[Shape, ...]

    @property
    def size(self) -> int:  # type: ignore[override]
        return sum(part.size for part in self.parts)


@dataclass(frozen=True)
class Variant(Shape):
    """One of some shapes; the first register says which. None, if it is among them, comes last."""

    options: tuple[Shape, ...]

    @property
    def size(self) -> int:  # type: ignore[override]
        return 1 + sum(option.size for option in self.options)


@dataclass(frozen=True)
class Items(Shape):
    """A list of at most CAPACITY elements of one shape: its length, then each register of the elements in turn."""

    element: Shape | None  # None: no element has ever been seen

    @property
    def size(self) -> int:  # type: ignore[override]
        return 1 + CAPACITY * (0 if self.element is None else self.element.size)


@dataclass(frozen=True, eq=False)
class RegisterList:
    """A list in registers: as long as `registers[0]` says."""

    element: Shape | None
    registers: tuple[int, ...]

    @property
    def length(self) -> RegisterValue:
        return RegisterValue(self.registers[0], whole=True)


def alike(a: Value, b: Value) -> bool:
    """Whether two fixed values are the same for every purpose."""
    if a is b:
        return True
    if isinstance(a, RandomExpr) or isinstance(b, RandomExpr) or type(a) is not type(b):
        return False
    if isinstance(a, bool | int | float | str):
        return a == b
    if isinstance(a, Function):
        return a.body is b.body
    first, second = flatten(a), flatten(b)
    if first is None or second is None or first[0] != second[0]:
        return False
    return all(map(alike, first[1], second[1]))


# ------------------------------------------------------------ taking apart, putting together


def flatten(value: Value) -> tuple[tuple, list[Value]] | None:
    """How a structure is put together, and its parts; None if it is none."""
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
    if isinstance(value, Instance) and not value.label:  # an oriented point of an operator
        return (Instance, value.cls, value.place, tuple(value.properties)), list(value.properties.values())
    if builds_text(value):
        operation = (FormatEach, value.operation.spec) if isinstance(value.operation, FormatEach) else value.operation
        return (RandomExpr, operation, len(value.inputs)), list(value.inputs)
    return None


def builds_text(value: Value) -> bool:
    """Whether a text is made of parts in the match, so that it has no number."""
    if not isinstance(value, RandomExpr) or isinstance(value, RegisterValue) or value.kind != "text":
        return False
    if value.operation is SELECT.array:
        return any(map(builds_text, value.inputs[1:]))
    return bool(value.inputs) and not isinstance(value.operation, Table)


SIMPLE = frozenset({RegisterValue, int, float, bool, str, type(None), Function})


def unflatten(head: tuple, parts: list[Value]) -> Value:
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
        operation = FormatEach(rest[0][1]) if isinstance(rest[0], tuple) else rest[0]
        return RandomExpr(operation, tuple(parts), "text")
    region = object.__new__(kind)
    vars(region).update(zip(rest[0], parts, strict=True))
    return region


def varies(value: Value) -> bool:
    """Whether anything in a value depends on the running match."""
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


# ------------------------------------------------------------ shapes of values


def shape_of(value: Value) -> Shape:
    """The narrowest shape of a value."""
    if not varies(value):
        return Same(value)
    if isinstance(value, RegisterList):
        return Items(value.element)
    if isinstance(value, RandomChoice):
        return variant(None, [shape_of(option) for option in value.options])
    apart = flatten(value)
    if apart is not None:
        return Parts(apart[0], tuple(map(shape_of, apart[1])))
    return Leaf(value.kind, is_whole(value))


def varying(shape: Shape) -> Shape:
    """The same shape with registers for its fixed numbers, truth values and texts."""
    leaf = leaf_of(shape)
    if leaf is not None:
        return leaf
    parts = parts_of(shape)
    if parts is None or parts.head[0] not in (tuple, Vector):
        return shape
    return Parts(parts.head, tuple(map(varying, parts.parts)))


def join(a: Shape | None, b: Shape | None) -> Shape | None:
    """The least shape for the values of both."""
    if a is None or b is None or a == b:
        return b if a is None else a
    united = united_shape(a, b)
    return united if united is not None else variant(None, [a, b])


def united_shape(a: Shape, b: Shape) -> Shape | None:
    """One shape for both that is no choice between them, if there is one."""
    if a == b:
        return a
    if isinstance(a, Variant) or isinstance(b, Variant):
        options = [*(a.options if isinstance(a, Variant) else [a]), *(b.options if isinstance(b, Variant) else [b])]
        return variant(None, options)
    left, right = leaf_of(a), leaf_of(b)
    if left is not None and right is not None:
        return united_leaf(left, right)
    if is_list(a) and is_list(b):
        return united_list(a, b)
    first, second = parts_of(a), parts_of(b)
    if first is not None and second is not None and first.head == second.head:
        joined = [join(x, y) for x, y in zip(first.parts, second.parts, strict=True)]
        return Parts(first.head, tuple(each for each in joined if each is not None))
    return None


def leaf_of(shape: Shape) -> Leaf | None:
    """The shape of a register that can hold it, if one can."""
    if isinstance(shape, Leaf):
        return shape
    if isinstance(shape, Same) and kind_of(shape.value) in ("number", "truth", "text"):
        if builds_text(shape.value):
            return None
        return Leaf(kind_of(shape.value), is_whole(shape.value))
    return None


def united_leaf(a: Leaf, b: Leaf) -> Leaf | None:
    if "text" in (a.kind, b.kind) and a.kind != b.kind:
        return None
    return Leaf(a.kind if a.kind == b.kind else "number", a.whole and b.whole)


def parts_of(shape: Shape) -> Parts | None:
    if isinstance(shape, Same):
        apart = flatten(shape.value)
        return None if apart is None else Parts(apart[0], tuple(map(shape_of, apart[1])))
    return shape if isinstance(shape, Parts) else None


def is_list(shape: Shape) -> bool:
    if isinstance(shape, Parts):
        return shape.head[0] is list
    return isinstance(shape, Items) or (isinstance(shape, Same) and isinstance(shape.value, list))


def united_list(a: Shape, b: Shape) -> Shape:
    """Of lists of one length each element has its own shape, otherwise they have one in common."""
    first, second = parts_of(a), parts_of(b)
    if first is not None and second is not None and len(first.parts) == len(second.parts):
        joined = [join(x, y) for x, y in zip(first.parts, second.parts, strict=True)]
        return Parts(first.head, tuple(each for each in joined if each is not None))
    return Items(join(element_of(a), element_of(b)))


def element_of(shape: Shape) -> Shape | None:
    """One shape for all elements of a list."""
    if isinstance(shape, Items):
        return shape.element
    parts = parts_of(shape)
    found: Shape | None = None
    for each in parts.parts if parts is not None else ():
        found = join(found, each)
    return found


def variant(first: Shape | None, shapes: list[Shape]) -> Shape:
    """A choice among shapes; those that go well together become one."""
    options: list[Shape] = [] if first is None else [first]
    for shape in shapes:
        for each in shape.options if isinstance(shape, Variant) else (shape,):
            add_option(options, each)
    if len(options) > MOST_OPTIONS:
        raise ScenicError("budget", f"a variable can be more than {MOST_OPTIONS} different things")
    options.sort(key=lambda each: isinstance(each, Same) and each.value is None)
    return options[0] if len(options) == 1 else Variant(tuple(options))


def add_option(options: list[Shape], shape: Shape) -> None:
    for i, each in enumerate(options):
        if each == shape:
            return
        united = united_shape(each, shape)
        if united is not None:
            options[i] = united
            return
    options.append(shape)


def option_for(shape: Variant, value: Value) -> int:
    """Which option of a variant holds a value."""
    own = shape_of(value)
    for i, option in enumerate(shape.options):
        if option == own or (not isinstance(option, Same) and united_shape(option, own) == option):
            return i
    raise ScenicError("type", f"{describe_kind(value)} where something else was expected")


def loaded(shape: Shape, registers: Iterator[int]) -> Value:
    """The value that stands in some registers."""
    if isinstance(shape, Same):
        return shape.value
    if isinstance(shape, Leaf):
        return RegisterValue(next(registers), shape.kind, shape.whole)
    if isinstance(shape, Parts):
        return unflatten(shape.head, [loaded(part, registers) for part in shape.parts])
    if isinstance(shape, Items):
        return RegisterList(shape.element, tuple(next(registers) for _ in range(shape.size)))
    assert isinstance(shape, Variant)
    tag = RegisterValue(next(registers), whole=True)
    return RandomChoice(tag, tuple(loaded(option, registers) for option in shape.options))
