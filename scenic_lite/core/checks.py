"""Arithmetic faults that array operations ignore, such as a division by zero: their places and their scenes.

`RuntimeChecks.note` registers every random value whose operation can fail, with its place and the conditions of its
evaluation. `CheckResults` finds the scenes of a batch in which such an operation fails. Read next: `scene.program`.
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

PARTS = 8  # maximum number of checked parts of a result, such as a vector or divmod()


FAULTS = (  # our own errors, and the exceptions of Python's operators and methods
    ScenicError, ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError, MemoryError,
)  # fmt: skip


def as_error(fault: BaseException) -> ScenicError:
    """Convert an exception of Python's operators and methods to a `ScenicError`; return a `ScenicError` unchanged."""
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
    """An operation on arrays [N] that can report the rows in which it fails."""

    def fails(self, result: Any, *inputs: Any) -> Any:
        """Return the rows [N] in which the operation fails."""
        raise NotImplementedError

    def error(self, row: int, *inputs: Any) -> ScenicError:
        """Return the error of a failing row."""
        raise NotImplementedError


class FallibleRow(FallibleOperation):
    """A fallible operation from the table of operations, such as division or the square root."""

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
    """Return the operation as a `FallibleOperation`; None if it cannot fail."""
    if isinstance(operation, FallibleOperation):
        return operation
    row = row_of(operation)
    return None if row is None or row.fails is None else FallibleRow(row)


@dataclass(eq=False)
class Check:
    """A random value whose computation may fail: its place, and the conditions of its evaluation.

    `guards` are conditions and their required values. `requirement` is the index of the requirement that evaluates the
    value; None if every scene computes the value before any rule is tested.
    """

    node: RandomExpr
    guards: tuple[tuple[Value, bool], ...]
    requirement: int | None
    place: SourceSpan | None = None
    line: str = ""


@dataclass
class RuntimeChecks:
    """The checks that a load has registered so far, and the guards and requirement of the code under evaluation."""

    checks: dict[int, Check] = field(default_factory=dict)
    unplaced: list[Check] = field(default_factory=list)  # checks without a place until the enclosing expression ends
    guards: list[tuple[Value, bool]] = field(default_factory=list)
    requirement: int | None = None

    @contextmanager
    def within(self, requirement: int) -> Iterator[None]:
        """Assign checks registered inside the context to a requirement."""
        before, self.requirement = self.requirement, requirement
        try:
            yield
        finally:
            self.requirement = before

    @contextmanager
    def under(self, *guards: tuple[Value, bool]) -> Iterator[None]:
        """Restrict checks registered inside the context to scenes in which the conditions have the given values."""
        self.guards += guards
        try:
            yield
        finally:
            del self.guards[len(self.guards) - len(guards) :]

    def note(self, result: Value, ways: Iterable[tuple[Value, bool]] = ()) -> None:
        """Register a check if the operation of the result, of one of its parts or of one of its inputs can fail."""
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
        """Set the place of all checks that have no place yet."""
        for check in self.unplaced:
            check.place, check.line = place, line
        self.unplaced.clear()


class TapeCheck(NamedTuple):
    """A check that affects the scenes of a program; `rule`: the index of the rule that fails with it, or None."""

    check: Check
    operation: FallibleOperation
    rule: int | None


def checks_on(tape: Tape, checks: Iterable[Check], rules: list[int | None]) -> list[TapeCheck]:
    """Return the checks of the values on a tape; `rules` maps each requirement to its rule, None if it always holds."""
    on_tape = []
    for check in checks:
        operation = fallible(check.node.operation)
        if check.place is not None and operation is not None and reaches(tape, check):
            tape.keep(check.node, *check.node.inputs, *(condition for condition, _ in check.guards))
            on_tape.append(TapeCheck(check, operation, None if check.requirement is None else rules[check.requirement]))
    return on_tape


class CheckResults:
    """The failures in one batch of scenes; a scene violates a rule of `failed` [R, N] whose condition fails in it."""

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
        """[N] bool: the scenes with a value that cannot be computed."""
        own = [mask for check, mask in self._masks if check.check.requirement is None]
        return np.logical_or.reduce(own) if own else np.False_

    def raise_first(self, broken: np.ndarray, drawn: np.ndarray) -> None:
        """Raise the first ScenicError of a scene that is `drawn` [N] and fails before it is rejected.

        `broken` [N, R] are the active rules that the scenes violate. As in Scenic, all values are computed first. A
        requirement is evaluated only if every earlier rule holds.
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
    """Return whether the tape computes the value and its guards."""
    needed = [check.node, *(condition for condition, _ in check.guards if isinstance(condition, RandomExpr))]
    return all(tape.find(value) is not None for value in needed)
