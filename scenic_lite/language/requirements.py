"""`require` and `mutate`: conditions on scenes and episodes, and noise added to objects after the last statement.

A condition is evaluated at its statement, so its errors have the place of the statement. If objects have noise, every
condition is evaluated again after the last statement, since it applies to the scene with the noise.

Temporal requirements use linear temporal logic over finite episodes. A formula is evaluated by progression:
`after(step)` is the remaining requirement on later steps. For example, `always p` stays unchanged while p holds, and
`eventually p` until p holds. The remaining formula is decided if no further step can change it. Otherwise `at_end`
returns whether the formula would hold if the episode ended now. `next` is strong: it does not hold at the last step. An
`until` is false as soon as its left side fails (Scenic waits for the right side, but finally rejects the same scenes).

An operand of `and`, `or`, `not` or `implies` without temporal operators is one ordinary expression, with short
circuits. Every such expression in the remaining formula is evaluated once per step. A formula without a temporal
operator applies to the first step. Read next: `core.per_sample`, `scene.constraints`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

from scenic_lite.core.per_sample import Bindings, per_sample_condition
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EpisodeStatement, LoadState, Requirement
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import is_object
from scenic_lite.syntax import nodes
from scenic_lite.syntax.nodes import is_temporal
from scenic_lite.values.formulas import normal_quantile
from scenic_lite.values.geometry import Vector, normalized
from scenic_lite.values.graph import RandomExpr, Value, apply, columns_of, is_number
from scenic_lite.values.operations import AND, NOT, OR

Step = Callable[[ast.expr], bool]  # the truth of an expression in the present step


def require(scope: Scope, node: nodes.Require) -> None:
    """Execute `require[p] condition as name`; episodes also monitor a temporal condition."""
    state = scope.state
    if scope.mode.symbolic:
        raise ScenicError("syntax", "a requirement cannot be made inside a requirement")
    probability = probability_of(scope, node)
    number = len(state.requirements)
    with state.watching.within(number):
        condition = condition_of(scope, node.condition)
    label = node.name or source_text(scope, node)
    requirement = Requirement(label, scope.place(node), condition, probability)
    bindings = Bindings(scope)
    if is_temporal(node.condition):
        state.temporal.append(EpisodeStatement(node, requirement.place, scope, label, bindings))

    def again() -> None:
        with bindings.restored(state), state.watching.within(number):
            requirement.condition = condition_of(scope, node.condition)

    state.requirements.append(requirement)
    state.conditions.append(again)


def condition_of(scope: Scope, node: ast.expr) -> Value:
    """Return a condition as a node over all samples, evaluated row by row if its functions branch on random values."""
    if is_temporal(node):
        false = formula_of(node).known(lambda part: condition_of(scope, part), False)
        return apply(NOT, false)
    try:
        condition = scope.requiring().value(node)
    except ScenicError as error:
        if error.kind != "random-control-flow":
            raise
        condition = per_sample_condition(scope, node)
        scope.watch(condition)
    if isinstance(condition, RandomChoice | BehaviorCall):
        raise scope.error("type", "the condition of a requirement must be true or false", node)
    return condition if isinstance(condition, RandomExpr) else bool(condition)


def probability_of(scope: Scope, node: nodes.Require) -> float:
    """Return the probability p of `require[p]`; the default is 1."""
    probability = 1.0 if node.probability is None else scope.value(node.probability)
    if not is_number(probability) or not 0 <= probability <= 1:
        raise scope.error("value", "the probability of a requirement must be a number from 0 to 1", node)
    return float(probability)


def source_text(scope: Scope, node: ast.AST) -> str:
    """Return the first line of the statement's source text."""
    place = scope.place(node)
    line = scope.source.line(place.line)
    end = place.end_column if place.end_line == place.line else len(line)
    return line[place.column : end].strip()


# ------------------------------------------------------------ noise
def mutate(scope: Scope, node: nodes.Mutate) -> None:
    """Execute `mutate [objects] [by scale]`: request noise for these objects, or for all objects created so far."""
    state = scope.state
    if scope.mode.symbolic:
        raise ScenicError("syntax", "`mutate` does not belong into a requirement")
    scale = 1.0 if node.scale is None else scope.value(node.scale)
    if not is_number(scale):
        hint = "the property mutationScale may be random"
        raise scope.error("type", f"`mutate by` needs a fixed number, not {describe_kind(scale)}", node, hint)
    targets = [scope.value(target) for target in node.targets] if node.targets else list(state.objects)
    for target in targets:
        if not is_object(target):
            raise scope.error("type", f"`mutate` needs objects, not {describe_kind(target)}", node)
        target.properties["mutationScale"] = scale


def apply_mutations(state: LoadState) -> None:
    """Add the requested noise to all objects after the last statement, and evaluate the requirements again."""
    noisy = [instance for instance in state.objects if not is_zero(instance.properties["mutationScale"])]
    for instance in noisy:
        try:
            add_noise(state, instance)
        except ScenicError as error:  # the noise exceeds the limit of draws
            error.place = instance.place
            raise
    if noisy:
        for evaluate_again in state.conditions:
            evaluate_again()


def is_zero(value: Value) -> bool:
    return is_number(value) and value == 0


def add_noise(state: LoadState, instance: Instance) -> None:
    """Add noise to position and heading; values computed earlier from them exclude the noise."""
    properties = instance.properties
    spread = properties["positionStdDev"]
    if not isinstance(spread, Vector):
        spread = Vector(spread, spread)
    name_coordinates(instance)
    shift = Vector(noise(state, instance, "x", spread.x), noise(state, instance, "y", spread.y))
    properties["position"] = properties["position"] + shift
    heading = properties["heading"] + noise(state, instance, "heading", properties["headingStdDev"])
    properties["heading"] = normalized(heading) if state.dialect == 3 else heading


def name_coordinates(instance: Instance) -> None:
    """Name the columns of the coordinates `x` and `y`, since adding noise would hide the coordinates."""
    position = instance.properties["position"]
    for axis, coordinate in (("x", position.x), ("y", position.y)):
        for column in columns_of(coordinate):
            if column.shown is coordinate and column.owner == (instance, "position"):
                column.owner = (instance, axis)


def noise(state: LoadState, instance: Instance, axis: str, spread: Value) -> Value:
    """Return normal noise with mean 0: one column of θ with a name such as `ego.noise.x`."""
    spread = instance.properties["mutationScale"] * spread
    if is_zero(spread):
        return 0.0
    column = state.column("normal", instance.place)
    column.owner = (instance, f"noise.{axis}")
    return column.show(spread * RandomExpr(normal_quantile, (column,)))


# ------------------------------------------------------------ temporal logic
class Formula:
    """A requirement on the steps from some step on; each subclass is one form of formula."""

    def after(self, step: Step) -> Formula:
        """Return the remaining requirement on later steps, given the truths of `step`."""
        match self:
            case Atom(expression):
                return Settled(step(expression))
            case Not(operand):
                return negation(operand.after(step))
            case Both(left, right):
                return conjunction(left.after(step), right.after(step))
            case Next(operand, begun):
                return operand.after(step) if begun else Next(operand, begun=True)
            case Until(left, right):
                kept, reached = left.after(step), right.after(step)
                return disjunction(reached, conjunction(kept, self))
        return self

    def at_end(self) -> bool:
        """Return whether the formula holds in an episode that ends before the formula's first step."""
        match self:
            case Settled(value):
                return value
            case Not(operand):
                return not operand.at_end()
            case Both(left, right):
                return left.at_end() and right.at_end()
        return False

    def known(self, value: Callable[[ast.expr], Value], truth: bool) -> Value:
        """Return whether the formula is decided as `truth` after one step; as in Scenic, an `until` is never false."""
        match self:
            case Settled(settled):
                return settled is truth
            case Atom(expression):
                return value(expression) if truth else apply(NOT, value(expression))
            case Not(operand):
                return operand.known(value, not truth)
            case Both(left, right):
                return apply(AND if truth else OR, left.known(value, truth), right.known(value, truth))
            case Until(_, right) if truth:
                return right.known(value, True)
        return False


@dataclass(frozen=True)
class Settled(Formula):
    """A decided formula, true or false for all further steps."""

    value: bool


@dataclass(frozen=True)
class Atom(Formula):
    """An expression that is true or false in one step."""

    expression: ast.expr


@dataclass(frozen=True)
class Not(Formula):
    operand: Formula


@dataclass(frozen=True)
class Both(Formula):
    left: Formula
    right: Formula


@dataclass(frozen=True)
class Next(Formula):
    """The formula `next operand`; `begun`: the step of the `next` itself has passed."""

    operand: Formula
    begun: bool = False


@dataclass(frozen=True)
class Until(Formula):
    left: Formula
    right: Formula


TRUE, FALSE = Settled(True), Settled(False)


def negation(formula: Formula) -> Formula:
    if isinstance(formula, Settled):
        return Settled(not formula.value)
    return formula.operand if isinstance(formula, Not) else Not(formula)


def conjunction(left: Formula, right: Formula) -> Formula:
    """Return the conjunction, simplified by removing decided and repeated parts."""
    if left == FALSE or right == FALSE:
        return FALSE
    if left == TRUE or left in parts_of(right):
        return right
    return left if right == TRUE or right in parts_of(left) else Both(left, right)


def parts_of(formula: Formula) -> list[Formula]:
    return [*parts_of(formula.left), *parts_of(formula.right)] if isinstance(formula, Both) else [formula]


def disjunction(left: Formula, right: Formula) -> Formula:
    return negation(conjunction(negation(left), negation(right)))


def formula_of(node: ast.expr) -> Formula:
    """Return the formula of an expression."""
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
    "always": lambda operand: negation(Until(TRUE, negation(operand))),
    "eventually": lambda operand: Until(TRUE, operand),
    "next": Next,
    "until": Until,
    "implies": lambda left, right: disjunction(negation(left), right),
}


class Check:
    """One requirement in one episode."""

    def __init__(self, formula: Formula) -> None:
        self.rest = formula

    def step(self, step: Step) -> None:
        """Update the remaining requirement with the present step."""
        known: dict[int, bool] = {}

        def once(expression: ast.expr) -> bool:
            if id(expression) not in known:
                known[id(expression)] = step(expression)
            return known[id(expression)]

        self.rest = self.rest.after(once)

    @property
    def holds(self) -> bool:
        """Return whether the requirement holds if the episode ends now."""
        return self.rest.at_end()
