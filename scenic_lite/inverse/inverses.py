"""How to go back through each operation: from its value, and all inputs but one, to that one.

Operations without a rule (`abs`, `sin`, ...) are left to `solver`. Read next: `inverse.inversion`, which applies the
rules.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from scenic_lite.inverse.knowledge import Knowledge
from scenic_lite.language.distributions import NORMAL_SHARE, Cut, Integers, normal_quantile
from scenic_lite.values.geometry import NORMALISE, TURN
from scenic_lite.values.graph import FLOAT, Table, pick

ROUNDING = 1e-9  # of an angle
Constraint = Callable[[Knowledge, Any, tuple[int, ...], int], None]


def rule_for(operation: Any) -> Constraint | None:
    """How to go back through an operation; None if it has no inverse."""
    return RULES_OF_TYPES.get(type(operation)) or RULES.get(operation)


def back_to(
    compute: Callable[[Any], Any], knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int
) -> None:
    """For operations of one input (what else they take is fixed)."""
    knowledge.solve(inputs[0], (out,), compute)


def back_from_sum(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    left, right = inputs
    if left != right:
        knowledge.solve(left, (out, right), lambda total, other: total - other)
        knowledge.solve(right, (out, left), lambda total, other: total - other)


def back_from_difference(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    left, right = inputs
    if left != right:
        knowledge.solve(left, (out, right), lambda gap, other: gap + other)
        knowledge.solve(right, (left, out), lambda other, gap: other - gap)


def back_from_product(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    left, right = inputs
    if left != right:
        knowledge.solve(left, (out, right), lambda product, other: product / other)
        knowledge.solve(right, (out, left), lambda product, other: product / other)


def back_from_quotient(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    left, right = inputs
    if left != right:
        knowledge.solve(left, (out, right), lambda quotient, other: quotient * other)
        knowledge.solve(right, (left, out), lambda other, quotient: other / quotient)


def back_from_choice(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    """The index from options that are known, or the option that the index names."""
    index, *options = inputs
    where_known = ~knowledge.known[index] & knowledge.known[out]
    for option in options:
        where_known = where_known & knowledge.known[option]
    if where_known.any():
        wanted = knowledge.at(out, where_known)
        match = np.stack([np.broadcast_to(same(knowledge.at(o, where_known), wanted), wanted.shape) for o in options])
        sound = match.any(axis=0)
        where_known[where_known] = sound
        knowledge.learn(index, where_known, match.argmax(axis=0)[sound])
    for k, option in enumerate(options):
        rows = ~knowledge.known[option] & knowledge.known[out] & knowledge.known[index]
        if rows.any():
            rows[rows] = knowledge.at(index, rows) == k
            knowledge.learn(option, rows, knowledge.at(out, rows))
        rows = ~knowledge.known[out] & knowledge.known[option] & knowledge.known[index]
        if rows.any():
            rows[rows] = knowledge.at(index, rows) == k
            knowledge.learn(out, rows, knowledge.at(option, rows))


def back_from_condition(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    """`yes if test else no`, where the test is known."""
    for option, taken in zip(inputs[1:], (True, False), strict=True):
        for target, source in ((option, out), (out, option)):
            rows = ~knowledge.known[target] & knowledge.known[source] & knowledge.known[inputs[0]]
            if rows.any():
                rows[rows] = np.asarray(knowledge.at(inputs[0], rows)).astype(bool) == taken
                knowledge.learn(target, rows, knowledge.at(source, rows))


def back_from_table(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    """The index of an option: the first that is the value."""
    options = operation.options
    rows = ~knowledge.known[inputs[0]] & knowledge.known[out]
    if rows.any():
        match = same(options[:, None], np.asarray(knowledge.at(out, rows))[None])
        sound = match.any(axis=0)
        rows[rows] = sound
        knowledge.learn(inputs[0], rows, match.argmax(axis=0)[sound])


def back_from_cut(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    """The middle of the piece."""
    ends = np.concatenate([[0.0], operation.bounds, [1.0]])
    middles = (ends[:-1] + ends[1:]) / 2
    knowledge.solve(inputs[0], (out,), lambda index: middles[np.asarray(index).astype(int)])


def back_from_integers(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    drawn = operation
    knowledge.solve(inputs[0], (out,), lambda value: (np.rint(value) - drawn.first + 0.5) / drawn.count)


def same(a: Any, b: Any) -> Any:
    """Whether values agree, numbers up to rounding; arrays of any kinds."""
    a, b = np.asarray(a), np.asarray(b)
    if "O" in (a.dtype.kind, b.dtype.kind) or "U" in (a.dtype.kind, b.dtype.kind):
        return np.asarray(a == b, dtype=bool)
    return np.abs(a - b.astype(float)) <= 1e-9 * np.maximum(1.0, np.abs(b))


def back_from_angle(knowledge: Knowledge, operation: Any, inputs: tuple[int, ...], out: int) -> None:
    """With as many whole turns as bring it between the bounds of what was normalised."""
    low, high = knowledge.bounds[inputs[0]]

    def angle(value: Any) -> Any:
        if low - ROUNDING <= -np.inf or high >= np.inf:
            return value
        over_choices = value + TURN * np.ceil((low - ROUNDING - value) / TURN)
        return np.where(
            (over_choices > high + ROUNDING) | ((value >= low) & (value <= high)),
            value,
            over_choices,
        )

    knowledge.solve(inputs[0], (out,), angle)


def unchanged(value: Any) -> Any:
    return value


def square(value: Any) -> Any:
    return value * value


RULES_OF_TYPES: dict[type, Constraint] = {Table: back_from_table, Cut: back_from_cut, Integers: back_from_integers}
RULES: dict[Any, Constraint] = {
    np.add: back_from_sum,
    np.subtract: back_from_difference,
    np.multiply: back_from_product,
    np.true_divide: back_from_quotient,
    np.where: back_from_condition,
    pick: back_from_choice,
    np.negative: partial(back_to, np.negative),
    np.sqrt: partial(back_to, square),
    np.exp: partial(back_to, np.log),
    np.log: partial(back_to, np.exp),
    np.degrees: partial(back_to, np.radians),
    np.radians: partial(back_to, np.degrees),
    np.clip: partial(back_to, unchanged),  # of a truncated normal value, whose ends come out as they are
    NORMALISE.array: back_from_angle,
    FLOAT.array: partial(back_to, unchanged),
    normal_quantile: partial(back_to, NORMAL_SHARE.array),
}
