"""`require` and `mutate`: what a scene must satisfy, and the noise that its objects get when all else is computed.

A condition is evaluated where it stands, so that its errors stand there too; if objects
are given noise it is evaluated again after the last statement, since it speaks of the scene with the noise. Read next:
`core.per_sample`, `scene.constraints`.
"""

from __future__ import annotations

import ast
import math

from scenic_lite.core.per_sample import Bindings, per_sample_condition
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState, Requirement, Watched
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import is_object
from scenic_lite.language.temporal import formula_of, is_temporal, possible
from scenic_lite.syntax import nodes
from scenic_lite.values.formulas import normal_quantile
from scenic_lite.values.geometry import Vector, normalised
from scenic_lite.values.graph import RandomExpr, Value, columns_of, is_number


def require(scope: Scope, node: nodes.Require) -> None:
    """`require[p] condition as name`; a temporal one is watched in the episode, too."""
    state = scope.state
    if scope.mode.symbolic:
        raise ScenicError("syntax", "a requirement cannot be made inside a requirement")
    probability = 1.0 if node.probability is None else scope.value(node.probability)
    if not is_number(probability) or not 0 <= probability <= 1:
        raise scope.error("value", "the probability of a requirement must be a number from 0 to 1", node)
    number = len(state.requirements)
    with state.watching.within(number):
        condition = condition_of(scope, node.condition)
    label = node.name or source_text(scope, node)
    requirement = Requirement(label, scope.place(node), condition, float(probability))
    bindings = Bindings(scope)
    if is_temporal(node.condition):
        state.temporal.append(Watched(node, requirement.place, scope, label, bindings))

    def again() -> None:
        with bindings.restored(state), state.watching.within(number):
            requirement.condition = condition_of(scope, node.condition)

    state.requirements.append(requirement)
    state.conditions.append(again)


def condition_of(scope: Scope, node: ast.expr) -> Value:
    """Return a condition over all samples at once; row by row if functions in it decide on random values."""
    if is_temporal(node):
        return possible(formula_of(node), lambda part: condition_of(scope, part))
    try:
        condition = scope.requiring().value(node)
    except ScenicError as error:
        if error.kind != "random-control-flow":
            raise
        condition = per_sample_condition(scope, node)
        scope.watch(condition)
    if isinstance(condition, BehaviorCall):
        hint = f"write require monitor {condition.behavior.name}()"
        raise scope.error("type", "a monitor is no condition", node, hint)
    if isinstance(condition, RandomChoice):
        raise scope.error("type", "the condition of a requirement must be true or false", node)
    return condition if isinstance(condition, RandomExpr) else bool(condition)


def source_text(scope: Scope, node: ast.AST) -> str:
    """Return the first line of a statement as the program writes it."""
    place = scope.place(node)
    line = scope.source.line(place.line)
    end = place.end_column if place.end_line == place.line else len(line)
    return line[place.column : end].strip()


# ------------------------------------------------------------ noise


def mutate(scope: Scope, node: nodes.Mutate) -> None:
    """`mutate [objects] [by scale]`: these, or all made so far, will be given noise."""
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
    """Add the noise of the objects that have any, after the last statement, and tell the requirements."""
    noisy = [instance for instance in state.objects if not is_zero(instance.properties["mutationScale"])]
    for instance in noisy:
        try:
            add_noise(state, instance)
        except ScenicError as error:  # too many draws
            error.place = instance.place
            raise
    if noisy:
        for evaluate_again in state.conditions:
            evaluate_again()


def is_zero(value: Value) -> bool:
    return is_number(value) and value == 0


def add_noise(state: LoadState, instance: Instance) -> None:
    """Add noise to position and heading; what was computed from them keeps the values without noise."""
    properties = instance.properties
    spread = properties["positionStdDev"]
    if not isinstance(spread, Vector):
        spread = Vector(spread, spread)
    name_coordinates(instance)
    shift = Vector(noise(state, instance, "x", spread.x), noise(state, instance, "y", spread.y))
    properties["position"] = properties["position"] + shift
    heading = properties["heading"] + noise(state, instance, "heading", properties["headingStdDev"])
    properties["heading"] = normalised(heading) if state.dialect == 3 else heading


def name_coordinates(instance: Instance) -> None:
    """Name columns that are a coordinate by it, also when the coordinate gets noise on top."""
    position = instance.properties["position"]
    for axis, coordinate in (("x", position.x), ("y", position.y)):
        for column in columns_of(coordinate):
            if column.shown is coordinate and column.owner == (instance, "position"):
                column.owner = (instance, axis)


def noise(state: LoadState, instance: Instance, axis: str, spread: Value) -> Value:
    """Return a normal value with mean 0, one column of θ named like `ego.noise.x`."""
    spread = instance.properties["mutationScale"] * spread
    if is_zero(spread):
        return 0.0
    column = state.column("normal", instance.place)
    column.owner = (instance, f"noise.{axis}")
    column.low, column.high = -math.inf, math.inf
    column.shown = spread * RandomExpr(normal_quantile, (column,))
    return column.shown
