"""Random values as nodes of an expression graph, and the tape that evaluates the nodes for N samples at once.

The evaluator walks a program once. If an operand is random, the walk creates a `RandomExpr` node instead of a number.
A `Tape` then holds the nodes in topological order, so that N scenes cost one array operation per node, for every N.
Read next: `language.distributions`, which creates the columns; `scene.program`, which owns the tape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property, reduce
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values import operations
from scenic_lite.values.operations import Operation, quietly, to_integers

MOST_NUMBERS = 1 << 28  # maximum live numbers during a run of a tape: 2 GB
Value = Any  # a fixed or random number, text, container or instance of a class of `values`


def both_ways(operation: Operation) -> tuple[Callable[[Any, Value], Value], Callable[[Any, Value], Value]]:
    """Return two methods for an operator: one for a random left operand, one for a random right operand."""
    return (
        lambda self, other: arithmetic(operation, self, other),
        lambda self, other: arithmetic(operation, other, self),
    )


class RandomExpr:
    """A value that differs between scenes: `operation` applied to `inputs`, elementwise over the N samples.

    `kind` is "number", "truth", "text" or "any"; it reveals type errors while the program is loaded. `drawn` is the
    column that represents this value, if there is one.
    """

    __slots__ = ("drawn", "inputs", "kind", "operation")

    def __init__(self, operation: Callable[..., Any] | None, inputs: tuple, kind: str = "number") -> None:
        self.operation = operation
        self.inputs = inputs
        self.kind = kind
        self.drawn: ThetaColumn | None = None

    def __bool__(self) -> bool:
        raise ScenicError("random-control-flow", "control flow cannot depend on a random value")

    def __add__(self, other: Value) -> Value:
        return self if is_number(other) and other == 0 else arithmetic(operations.ADD, self, other)

    def __radd__(self, other: Value) -> Value:
        return self if is_number(other) and other == 0 else arithmetic(operations.ADD, other, self)

    def __sub__(self, other: Value) -> Value:
        return self if is_number(other) and other == 0 else arithmetic(operations.SUBTRACT, self, other)

    def __rsub__(self, other: Value) -> Value:
        return arithmetic(operations.SUBTRACT, other, self)

    def __mul__(self, other: Value) -> Value:
        return scaled(self, other) if is_number(other) else arithmetic(operations.MULTIPLY, self, other)

    def __rmul__(self, other: Value) -> Value:
        return scaled(self, other) if is_number(other) else arithmetic(operations.MULTIPLY, other, self)

    __truediv__, __rtruediv__ = both_ways(operations.DIVIDE)
    __floordiv__, __rfloordiv__ = both_ways(operations.FLOOR_DIVIDE)
    __mod__, __rmod__ = both_ways(operations.MODULO)
    __pow__, __rpow__ = both_ways(operations.POWER)

    def __neg__(self) -> Value:
        return arithmetic(operations.NEGATE, self)

    def __pos__(self) -> Value:
        return self

    def __abs__(self) -> Value:
        return arithmetic(operations.ABSOLUTE, self)


class ThetaColumn(RandomExpr):
    """One scaled column of θ, `offset + (θ + 1) / 2 · span`: a leaf of the graph.

    `shown` is the readable node (a coordinate or the chosen value); `low` and `high` are its limits in the program's
    units. `owner` names the value until a variable holds it. `pruning` may turn the column into a node of other
    columns, which has an operation. For a choice, `listed` are the options in the order of the program, and `weights`
    their shares of θ.
    """

    __slots__ = (
        "draw_kind", "high", "listed", "low", "name", "offset", "options", "owner", "place", "shown", "span", "weights"
    )  # fmt: skip

    def __init__(self, draw_kind: str, place: SourceSpan, offset: float = 0.0, span: float = 1.0) -> None:
        super().__init__(None, ())
        self.draw_kind = draw_kind
        self.place = place
        self.offset = offset
        self.span = span
        self.low = min(offset, offset + span)
        self.high = max(offset, offset + span)
        self.shown: RandomExpr = self
        self.drawn = self
        self.name = ""
        self.owner: Any = None
        self.options: tuple = ()  # the options of a choice of structured values, which its index represents
        self.listed: tuple = ()
        self.weights: tuple[float, ...] = ()

    def show(self, value: Value, low: float = -math.inf, high: float = math.inf) -> Value:
        """Set the readable value and its limits (nan if the limits are random); return the value."""
        self.shown, self.low, self.high = value, low, high
        value.drawn = self
        return value


def is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def apply(operation: Operation, *operands: Value, kind: str = "") -> Value:
    """Apply `operation` to numbers immediately; create a node if an operand is random.

    `kind` is the kind of the result; the default is the kind in the table of operations.
    """
    if any(isinstance(operand, RandomExpr) for operand in operands):
        return RandomExpr(operation.array, operands, kind or operation.kind)
    return operation.scalar(*operands)


def number_by(function: Callable[..., Any], *operands: Value) -> Value:
    """Return the number that an array function computes from fixed or random operands."""
    return apply(Operation(quietly(function, float), function), *operands)


def truth_by(test: Callable[..., Any], *operands: Value) -> Value:
    """Return the truth value that an array function computes from fixed or random operands."""
    return apply(Operation(quietly(test, bool), test, kind="truth"), *operands)


def all_of(*truths: Value) -> Value:
    return reduce(lambda some, truth: apply(operations.AND, some, truth), truths)


def any_of(*truths: Value) -> Value:
    return reduce(lambda some, truth: apply(operations.OR, some, truth), truths)


def arithmetic(operation: Operation, *operands: Value) -> Value:
    """Apply an arithmetic operation to numbers, or add texts. Raises TypeError for other operands."""
    kinds = {kind_of(operand) for operand in operands}
    if kinds <= {"number", "truth"}:
        return apply(operation, *(as_number(operand) for operand in operands))
    if kinds == {"text"} and operation is operations.ADD:
        return RandomExpr(operation.array, operands, "text")
    raise TypeError("arithmetic needs numbers")


def as_number(value: Value) -> Value:
    """Convert a boolean to 0 or 1, as in Python; a sum of boolean arrays would be boolean."""
    return RandomExpr(to_integers, (value,)) if isinstance(value, RandomExpr) and value.kind == "truth" else value


def kind_of(value: Value) -> str:
    if isinstance(value, RandomExpr):
        return value.kind
    if isinstance(value, bool | np.bool_):
        return "truth"
    if isinstance(value, int | float | np.number):
        return "number"
    return "text" if isinstance(value, str) else "other"


def scaled(value: RandomExpr, factor: float) -> Value:
    if factor == 1:
        return value
    return 0.0 if factor == 0 and value.kind == "number" else arithmetic(operations.MULTIPLY, value, factor)


class Table:
    """The operation that looks up constants by a random index, such as the options of `Uniform(1, 5, 9)`."""

    def __init__(self, options: Iterable[Value]) -> None:
        options = list(options)
        plain = all(is_number(option) for option in options) or all(isinstance(option, bool) for option in options)
        self.options = np.array(options) if plain else np.array(options + [None], dtype=object)[:-1]

    def __call__(self, index: Any) -> Any:
        return self.options[index]


def select(index: RandomExpr, options: tuple) -> RandomExpr:
    """Return a random choice among numbers or texts, which may be fixed or random."""
    kinds = {kind_of(option) for option in options}
    kind = kinds.pop() if len(kinds) == 1 else "any"
    if any(isinstance(option, RandomExpr) for option in options):
        return RandomExpr(operations.SELECT.array, (index, *options), kind)
    return RandomExpr(Table(options), (index,), kind)


def columns_of(*values: Value) -> Iterator[ThetaColumn]:
    """Yield each column on which the values depend, once."""
    seen: set[int] = set()
    stack = list(reversed(values))
    while stack:
        node = stack.pop()
        if not isinstance(node, RandomExpr) or id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, ThetaColumn) and node.operation is None:
            yield node
        stack.extend(reversed(node.inputs))


class Tape:
    """The nodes on which some outputs depend: a flat list in topological order, with common subexpressions merged."""

    def __init__(self, outputs: Iterable[RandomExpr], columns: Iterable[ThetaColumn], limit: int) -> None:
        self.registers: list[Any] = []
        self.steps: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []
        self._slots: dict[Any, int] = {}  # node, constant or (operation, inputs) -> register
        self._limit = limit
        for column in columns:
            self._slots[id(column)] = self._register(None)
        self.dim = len(self.registers)
        self.slots = {id(output): self._place(output) for output in outputs}
        self._kept = set(self.slots.values())

    def slot(self, value: RandomExpr) -> int:
        return self.slots[id(value)]

    def find(self, value: RandomExpr) -> int | None:
        """Return the register of a value; None if the tape does not compute the value."""
        return self._slots.get(id(value))

    def keep(self, *values: Value) -> None:
        """Preserve the registers of some values during a run, although they are not outputs."""
        self._kept.update(self._slots[id(value)] for value in values if isinstance(value, RandomExpr))
        vars(self).pop("_schedule", None)

    def run(self, columns: Any) -> list[Any]:
        """Evaluate every node for scaled columns [D, N]; return the registers, each [N], a constant, or None.

        Only outputs and kept registers are returned; all other registers are freed after their last use.
        """
        steps, most = self._schedule
        if steps and len(columns[0]) * most > MOST_NUMBERS:
            what = f"{len(columns[0]):,} scenes at once, of {most:,} random values each; ask for fewer at a time"
            raise ScenicError("budget", f"evaluation budget exceeded: {what}")
        registers = self.registers.copy()
        registers[: self.dim] = columns
        for operation, inputs, out, read in steps:
            registers[out] = operation(*[registers[i] for i in inputs])
            for i in read:
                registers[i] = None
        return registers

    @cached_property
    def _schedule(self) -> tuple[list[tuple[Callable[..., Any], tuple[int, ...], int, tuple[int, ...]]], int]:
        """Return the steps, each with the registers to free after it, and the maximum number of live registers."""
        last = {slot: at for at, (_, inputs, out) in enumerate(self.steps) for slot in (out, *inputs)}
        dying: dict[int, list[int]] = {}
        for _, _, out in self.steps:
            if out not in self._kept:
                dying.setdefault(last[out], []).append(out)
        alive = most = self.dim
        for at in range(len(self.steps)):
            alive += 1
            most = max(most, alive)
            alive -= len(dying.get(at, ()))
        return [(*step, tuple(dying.get(at, ()))) for at, step in enumerate(self.steps)], most

    def _register(self, value: Any) -> int:
        self.registers.append(value)
        return len(self.registers) - 1

    def _place(self, root: RandomExpr) -> int:
        """Allocate registers for `root` and its inputs, inputs first; without recursion, since graphs may be deep."""
        stack = [root]
        while stack:
            node = stack[-1]
            waiting = [i for i in node.inputs if isinstance(i, RandomExpr) and id(i) not in self._slots]
            if id(node) in self._slots or not waiting:
                stack.pop()
                if id(node) not in self._slots:
                    self._slots[id(node)] = self._step(node)
            else:
                stack.extend(waiting)
        return self._slots[id(root)]

    def _step(self, node: RandomExpr) -> int:
        assert node.operation is not None, "a column that is not among the tape's columns"
        inputs = tuple(self._slots[id(i)] if isinstance(i, RandomExpr) else self._constant(i) for i in node.inputs)
        key = (node.operation, inputs)
        if key not in self._slots:
            if len(self.steps) >= self._limit:
                raise ScenicError("budget", f"evaluation budget exceeded: more than {self._limit:,} random operations")
            self._slots[key] = self._register(None)
            self.steps.append((node.operation, inputs, self._slots[key]))
        return self._slots[key]

    def _constant(self, value: Any) -> int:
        key = ("constant", type(value), value)
        if key not in self._slots:
            self._slots[key] = self._register(value)
        return self._slots[key]
