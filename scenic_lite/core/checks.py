"""Arithmetic faults that array operations ignore: places where a program may divide by zero, and in which scenes.

The walk over the tree registers every random value whose operation can fail (`note`), with its place and the conditions
under which it is evaluated; `CheckResults` finds the scenes of a batch in which one fails. Read next: `scene.program`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values.graph import RandomExpr, Tape, Value
from scenic_lite.values.operations import Operation, row_of

PARTS = 8  # of a result that are checked: those of a vector, of divmod()


FAULTS = (  # our own errors, and those of Python's operators and methods
    ScenicError, ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError, MemoryError,
)  # fmt: skip


def as_error(fault: BaseException) -> ScenicError:
    """Return a `ScenicError` for a fault of Python's operators and methods; a `ScenicError` is returned unchanged."""
    if isinstance(fault, ScenicError):
        return fault
    if isinstance(fault, RecursionError):
        return exceeded("expressions and functions are nested too deeply")
    if isinstance(fault, MemoryError):
        return exceeded("more memory is needed than is available")
    if "not supported between instances" in str(fault):
        return ScenicError("type", "these values have no order", hint="compare numbers: a key is one, or an element")
    message = f"key {fault} is not in the dictionary" if isinstance(fault, KeyError) else str(fault)
    return ScenicError("type" if isinstance(fault, TypeError) else "value", message or type(fault).__name__)


class FallibleOperation:
    """An operation on arrays [N] that can report in which rows it fails."""

    def fails(self, result: Any, *inputs: Any) -> Any:
        """Return the rows [N] in which it fails."""
        raise NotImplementedError

    def error(self, row: int, *inputs: Any) -> ScenicError:
        """Return the error of a row that fails."""
        raise NotImplementedError


class FallibleRow(FallibleOperation):
    """A row of the table of operations that can fail: division, the root of a negative number."""

    def __init__(self, operation: Operation) -> None:
        assert operation.fails is not None
        self.fails, self.scalar = operation.fails, operation.scalar  # type: ignore[method-assign]

    def error(self, row: int, *inputs: Any) -> ScenicError:
        """Return Python's error for the operation on these numbers."""
        columns = [np.atleast_1d(column) for column in inputs]
        numbers = [column[min(row, len(column) - 1)].item() for column in columns]
        try:
            result = self.scalar(*numbers)
        except (ArithmeticError, ValueError, TypeError) as fault:
            error = as_error(fault)
        else:
            what = "no real number" if isinstance(result, complex) or math.isnan(result) else "infinite"
            error = ScenicError("value", f"the result is {what}")
        operands = " and ".join(f"{number:g}" for number in numbers)
        error.hint = f"the random values allow scenes in which this is computed of {operands}"
        return error


def fallible(operation: Callable[..., Any] | None) -> FallibleOperation | None:
    """Return the description of an operation's failures, if it can fail."""
    if isinstance(operation, FallibleOperation):
        return operation
    row = row_of(operation)
    return None if row is None or row.fails is None else FallibleRow(row)


@dataclass(eq=False)
class Check:
    """A random value that may fail: its place, and when the program evaluates it.

    `guards` are conditions and their required values; `requirement` is the number of the requirement that evaluates it,
    or None for a value that every scene computes before any rule is tested.
    """

    node: RandomExpr
    guards: tuple[tuple[Value, bool], ...]
    requirement: int | None
    place: SourceSpan | None = None
    line: str = ""


@dataclass
class RuntimeChecks:
    """The checks that a load has registered so far, and its current place."""

    checks: dict[int, Check] = field(default_factory=dict)
    unplaced: list[Check] = field(default_factory=list)  # until the enclosing expression ends
    guards: list[tuple[Value, bool]] = field(default_factory=list)
    requirement: int | None = None

    @contextmanager
    def within(self, requirement: int) -> Iterator[None]:
        """Register checks inside the context as those of a requirement."""
        before, self.requirement = self.requirement, requirement
        try:
            yield
        finally:
            self.requirement = before

    @contextmanager
    def under(self, *guards: tuple[Value, bool]) -> Iterator[None]:
        """Restrict checks inside the context to scenes in which these conditions have the given values."""
        self.guards += guards
        try:
            yield
        finally:
            del self.guards[len(self.guards) - len(guards) :]

    def note(self, result: Value, ways: Iterable[tuple[Value, bool]] = ()) -> None:
        """Register a result, if its operation, or that of a part or an input, can fail."""
        if isinstance(result, RandomExpr):
            nodes = [result, *result.inputs]
        else:
            pair = (result.x, result.y) if hasattr(result, "rotated") else result
            nodes = list(pair[:PARTS]) if isinstance(pair, tuple) else []
        for node in nodes:
            if isinstance(node, RandomExpr) and fallible(node.operation) and id(node) not in self.checks:
                check = Check(node, (*self.guards, *ways), self.requirement)
                self.checks[id(node)] = check
                self.unplaced.append(check)

    def place(self, place: SourceSpan, line: str) -> None:
        """Give the checks registered since then a place."""
        for check in self.unplaced:
            check.place, check.line = place, line
        self.unplaced.clear()


class TapeCheck(NamedTuple):
    """A check that the scenes of a program depend on; `rule`: the rule that fails with it, None for none."""

    check: Check
    operation: FallibleOperation
    rule: int | None


def checks_on(tape: Tape, checks: Iterable[Check], rules: list[int | None]) -> list[TapeCheck]:
    """Return the checks of values on a tape; `rules` gives the rule of each requirement, None if it always holds."""
    on_tape = []
    for check in checks:
        operation = fallible(check.node.operation)
        if check.place is not None and operation is not None and reaches(tape, check):
            tape.keep(check.node, *check.node.inputs, *(condition for condition, _ in check.guards))
            on_tape.append(TapeCheck(check, operation, None if check.requirement is None else rules[check.requirement]))
    return on_tape


class CheckResults:
    """The failures in one batch of scenes; a rule [R, N] whose condition fails is violated there."""

    def __init__(self, checks: list[TapeCheck], tape: Tape, registers: list[Any], failed: np.ndarray) -> None:
        self._tape, self._registers = tape, registers
        self._masks = [(check, np.broadcast_to(self._mask(*check[:2]), failed.shape[1:])) for check in checks]
        self.any = any(mask.any() for _, mask in self._masks)
        for check, mask in self._masks if self.any else ():
            if check.rule is not None:
                failed[check.rule] |= mask

    def _mask(self, check: Check, operation: FallibleOperation) -> Any:
        mask = operation.fails(self._of(check.node), *map(self._of, check.node.inputs))
        for condition, truth in check.guards if np.any(mask) else ():
            mask = mask & (np.asarray(self._of(condition), dtype=bool) == truth)
        return mask

    def _of(self, value: Value) -> Any:
        slot = self._tape.find(value) if isinstance(value, RandomExpr) else None
        return value if slot is None else self._registers[slot]

    @property
    def in_values(self) -> np.ndarray | np.bool_:
        """[N]: the scenes with a value that cannot be computed."""
        own = [mask for check, mask in self._masks if check.check.requirement is None]
        return np.logical_or.reduce(own) if own else np.False_

    def raise_first(self, broken: np.ndarray, drawn: np.ndarray) -> None:
        """Raise the ScenicError of a scene that was `drawn` [N] and in which the program fails before a rejection.

        `broken` [N, R] are the active rules that the scenes violate. As in Scenic, all values are computed first; a
        requirement is evaluated if every rule before it holds.
        """
        for (check, operation, rule), mask in self._masks:
            rows = mask & drawn
            if rule is not None:
                rows &= broken[:, rule] & ~broken[:, :rule].any(axis=1)
            if rows.any():
                error = operation.error(int(rows.argmax()), *map(self._of, check.node.inputs))
                if error.place is None:
                    error.place, error.source_line = check.place, check.line
                raise error


def reaches(tape: Tape, check: Check) -> bool:
    """Return whether the tape computes the value and the conditions of its evaluation."""
    needed = [check.node, *(condition for condition, _ in check.guards if isinstance(condition, RandomExpr))]
    return all(tape.find(value) is not None for value in needed)
