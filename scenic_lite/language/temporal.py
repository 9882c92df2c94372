"""Temporal requirements: linear temporal logic over finite episodes, with four truth values.

After each step a formula is true, presumably true, presumably false or false: `False` and `True` say that no further
step can change it, `Presumably` what it would be if the episode ended now. A formula is carried along by progression:
`after(step)` is what remains to be required of the steps to come. So `always p` stays itself while p holds, and
`eventually p` until it does. `next` is strong: it is presumably false at the last step. An `until` whose left side has
failed is false at once (Scenic waits for its right side, and rejects in the end all the same).

The operands of `and`, `or`, `not`, `implies` that contain no temporal operator are one expression, evaluated as
anywhere else, with short circuits. Every such expression that what remains mentions is evaluated once in a step. A
formula without a temporal operator is about the first step. Read next: `language.requirements`, for the scene they
begin with.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from typing import Any

from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value, apply
from scenic_lite.values.operations import AND, NOT, OR

OPERATORS = frozenset({"always", "eventually", "next", "until", "implies"})
Step = Callable[[ast.expr], bool]  # the truth of an expression in the present step


class Truth(Enum):
    """What is known of a formula after a step."""

    TRUE = 4
    PRESUMABLY_TRUE = 3
    PRESUMABLY_FALSE = 2
    FALSE = 1

    @property
    def holds(self) -> bool:
        """Return whether the formula holds if the episode ends now."""
        return self.value > Truth.PRESUMABLY_FALSE.value


class Formula:
    """What is required from some step on."""

    def after(self, step: Step) -> Formula:
        """Return what remains to be required of the later steps once `step` has passed."""
        raise NotImplementedError

    def at_end(self) -> bool:
        """Return whether it holds of an episode that ends before the step it begins with."""
        raise NotImplementedError


@dataclass(frozen=True)
class Settled(Formula):
    """True or false, whatever comes."""

    value: bool

    def after(self, step: Step) -> Formula:
        return self

    def at_end(self) -> bool:
        return self.value


@dataclass(frozen=True)
class Atom(Formula):
    """An expression, true or false in one step."""

    expression: ast.expr

    def after(self, step: Step) -> Formula:
        return Settled(step(self.expression))

    def at_end(self) -> bool:
        return False


@dataclass(frozen=True)
class Not(Formula):
    operand: Formula

    def after(self, step: Step) -> Formula:
        return negation(self.operand.after(step))

    def at_end(self) -> bool:
        return not self.operand.at_end()


@dataclass(frozen=True)
class Both(Formula):
    left: Formula
    right: Formula

    def after(self, step: Step) -> Formula:
        return conjunction(self.left.after(step), self.right.after(step))

    def at_end(self) -> bool:
        return self.left.at_end() and self.right.at_end()


@dataclass(frozen=True)
class Next(Formula):
    operand: Formula

    def after(self, step: Step) -> Formula:
        return Began(self.operand)

    def at_end(self) -> bool:
        return False


@dataclass(frozen=True)
class Began(Formula):
    """The operand of a `next` whose step has passed: it needs one step more."""

    operand: Formula

    def after(self, step: Step) -> Formula:
        return self.operand.after(step)

    def at_end(self) -> bool:
        return False


@dataclass(frozen=True)
class Until(Formula):
    left: Formula
    right: Formula

    def after(self, step: Step) -> Formula:
        left, right = self.left.after(step), self.right.after(step)
        return disjunction(right, conjunction(left, self))

    def at_end(self) -> bool:
        return False


TRUE, FALSE = Settled(True), Settled(False)


def negation(formula: Formula) -> Formula:
    if isinstance(formula, Settled):
        return Settled(not formula.value)
    return formula.operand if isinstance(formula, Not) else Not(formula)


def conjunction(left: Formula, right: Formula) -> Formula:
    """Return both, as simple as can be: what is settled or said twice is left out."""
    if left == FALSE or right == FALSE:
        return FALSE
    if left == TRUE or left in parts_of(right):
        return right
    return left if right == TRUE or right in parts_of(left) else Both(left, right)


def parts_of(formula: Formula) -> list[Formula]:
    return [*parts_of(formula.left), *parts_of(formula.right)] if isinstance(formula, Both) else [formula]


def disjunction(left: Formula, right: Formula) -> Formula:
    return negation(conjunction(negation(left), negation(right)))


def eventually(operand: Formula) -> Formula:
    return Until(TRUE, operand)


def always(operand: Formula) -> Formula:
    return negation(eventually(negation(operand)))


def is_temporal(node: ast.AST) -> bool:
    """Return whether an expression contains a temporal operator."""
    return any(isinstance(part, nodes.Operator) and part.name in OPERATORS for part in ast.walk(node))


def formula_of(node: ast.expr) -> Formula:
    """Return the formula that an expression writes."""
    if not is_temporal(node):
        return Atom(node)
    if isinstance(node, ast.UnaryOp):
        return negation(formula_of(node.operand))
    if isinstance(node, ast.BoolOp):
        join = conjunction if isinstance(node.op, ast.And) else disjunction
        return reduce(join, map(formula_of, node.values))
    assert isinstance(node, nodes.Operator), "the checker lets temporal operators stand nowhere else"
    operands = [formula_of(operand) for operand in node.operands if operand is not None]
    return MEANINGS[node.name](*operands)


MEANINGS: dict[str, Callable[..., Formula]] = {
    "always": always,
    "eventually": eventually,
    "next": Next,
    "until": Until,
    "implies": lambda left, right: disjunction(negation(left), right),
}


class Check:
    """One requirement in one episode."""

    def __init__(self, formula: Formula) -> None:
        self.rest = formula

    def step(self, step: Step) -> Truth:
        """Take in what holds now, and return what is known then."""
        known: dict[int, bool] = {}

        def once(expression: ast.expr) -> bool:
            if id(expression) not in known:
                known[id(expression)] = step(expression)
            return known[id(expression)]

        self.rest = self.rest.after(once)
        if isinstance(self.rest, Settled):
            return Truth.TRUE if self.rest.value else Truth.FALSE
        return Truth.PRESUMABLY_TRUE if self.rest.at_end() else Truth.PRESUMABLY_FALSE

    @property
    def holds(self) -> bool:
        """Return whether the requirement holds if the episode ends now."""
        return self.rest.at_end()


# ------------------------------------------------------------ the first step, over samples


def possible(formula: Formula, value: Callable[[ast.expr], Value]) -> Value:
    """Whether a formula is not yet false after the first step; of many samples if `value` says so."""
    return apply(NOT, known(formula, value, False))


def known(formula: Formula, value: Callable[[ast.expr], Value], truth: bool) -> Value:
    """Return whether a formula is known to be `truth` after the first step; to Scenic an `until` is never false."""
    if isinstance(formula, Settled):
        return formula.value is truth
    if isinstance(formula, Atom):
        holds = value(formula.expression)
        return holds if truth else apply(NOT, holds)
    if isinstance(formula, Not):
        return known(formula.operand, value, not truth)
    if isinstance(formula, Both):
        parts: list[Any] = [known(side, value, truth) for side in (formula.left, formula.right)]
        return apply(AND if truth else OR, *parts)
    return known(formula.right, value, True) if truth and isinstance(formula, Until) else False
