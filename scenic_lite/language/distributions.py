"""The distributions of the language; each maps one column of θ by its inverse cumulative distribution function.

The tape (`values.graph`) maps a number in [-1, 1] to the value; this module does not sample. Read next:
`values.regions`, for points drawn from a region.
"""

from __future__ import annotations

import ast
import math
from typing import Any

import numpy as np

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EPISODE, LOAD, DrawnPoint, Requirement
from scenic_lite.core.types import RandomChoice, choose, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.values import operations
from scenic_lite.values.geometry import Vector, is_scalar
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, apply, is_number
from scenic_lite.values.regions import Filtered, Region


def draw_range(scope: Scope, node: ast.AST, low: Value, high: Value) -> Value:
    """Return `Range(low, high)`: uniform between two fixed or random ends, in either order."""
    check_numbers("Range", low, high)
    place = scope.place(node)
    if is_number(low) and is_number(high):
        if not math.isfinite(float(high) - float(low)):
            raise ScenicError("value", f"Range({low}, {high}) has no finite length")
        return scope.draw("range", place, float(low), span_between(float(low), float(high)))
    column = scope.draw("range", place)
    return column.show(low + (high - low) * column, math.nan, math.nan)


def span_between(low: float, high: float) -> float:
    """Return a span with `low` + span = `high` in floating point; if there is none, one that stays below `high`."""
    span = high - low
    near = (span, math.nextafter(span, 0.0), math.nextafter(span, 2 * span))
    return next((step for step in near if low + step == high), near[1])


def draw_uniform(scope: Scope, node: ast.AST, *options: Value) -> Value:
    """Return `Uniform(a, b, ...)`: one of the values, with equal probabilities."""
    if len(options) == 1 and isinstance(options[0], list | tuple | set) and scope.mode.phase != EPISODE:
        scope.warn("a choice among a single value, which is a collection", node, "write Uniform(*values)")
    return weighted(scope, node, list(options), [1.0] * len(options))


def draw_element(scope: Scope, node: ast.AST, items: Value) -> Value:
    """Return `random.choice(items)`."""
    if isinstance(items, RandomChoice) and scope.mode.phase == LOAD:
        return draw_present(scope, node, [items])
    return draw_uniform(scope, node, *scope.elements(items, node))


def draw_present(scope: Scope, node: ast.AST, pieces: list[Value]) -> Value:
    """Return `Uniform(*items, other)` for random lists: one of the elements of a scene, with equal probabilities.

    `pieces` are lists or random choices of lists. Scenes in which all lists are empty are rejected.
    """
    column, items = scope.draw("choice", scope.place(node)), list[Value]()
    index = present(joined(scope, node, pieces), column, items)
    if not items:
        raise ScenicError("value", "a choice among no values")
    filled = apply(operations.GREATER_EQUAL, index, 0)
    scope.state.requirements.append(Requirement("a choice among no values", column.place, filled))
    return shown_choice(column, apply(operations.MAXIMUM, index, 0), items)


def joined(scope: Scope, node: ast.AST, pieces: list[Value]) -> Value:
    """Concatenate lists; the result is a random choice of lists if one of the lists is random."""
    at = next((i for i, piece in enumerate(pieces) if isinstance(piece, RandomChoice)), None)
    if at is None:
        return [item for piece in pieces for item in scope.elements(piece, node)]
    before, after = pieces[:at], pieces[at + 1 :]
    options = pieces[at].options
    return RandomChoice(pieces[at].index, tuple(joined(scope, node, [*before, each, *after]) for each in options))


def present(lists: Value, column: ThetaColumn, items: list[Value]) -> Value:
    """Return the index in `items` of the element that a column selects, -1 for an empty list; extend `items`."""
    if isinstance(lists, RandomChoice):
        return choose(lists.index, [present(option, column, items) for option in lists.options])
    items += [item for i, item in enumerate(lists) if not any(other is item for other in (*items, *lists[:i]))]
    numbers = [next(i for i, other in enumerate(items) if other is item) for item in lists]
    cut = Bucketize(np.arange(1, len(lists)) / max(len(lists), 1))
    return choose(RandomExpr(cut, (column,)), numbers) if numbers else -1


def draw_discrete(scope: Scope, node: ast.AST, weights: Value) -> Value:
    """Return `Discrete({value: weight})`: one of the values, with probability proportional to its weight."""
    if isinstance(weights, list | tuple):  # `Options` also accepts a list
        return draw_uniform(scope, node, *weights)
    if not isinstance(weights, dict):
        hint = "write Uniform(*items) for one of the elements of a random list" * isinstance(weights, RandomChoice)
        raise ScenicError("type", f"Discrete takes a dictionary of weights, not {describe_kind(weights)}", hint=hint)
    for option, weight in weights.items():
        if not is_number(weight):
            raise ScenicError("type", f"the weight of {option!r} in Discrete must be a fixed number")
        if not 0 <= weight < math.inf:
            fault = "negative" if weight < 0 else "not finite"
            raise ScenicError("value", f"the weight {weight} of {option!r} in Discrete is {fault}")
    kept = {option: float(weight) for option, weight in weights.items() if weight > 0}
    return weighted(scope, node, list(kept), list(kept.values()))


def weighted(scope: Scope, node: ast.AST, options: list[Value], weights: list[float]) -> Value:
    """Return one of the options with probability proportional to its weight."""
    if not options:
        kind = "value" if scope.mode.phase == LOAD else "rejection"  # an empty choice rejects an episode
        raise ScenicError(kind, "a choice among no values")
    column = scope.draw("choice", scope.place(node))
    scaled = np.array(weights) / max(weights)  # normalized first, since a sum of huge weights may overflow
    shares = np.cumsum(scaled) / scaled.sum()
    column.listed, column.weights = tuple(options), tuple((scaled / scaled.sum()).tolist())
    return shown_choice(column, RandomExpr(Bucketize(shares[:-1]), (column,)), options)


def shown_choice(column: ThetaColumn, index: RandomExpr, options: list[Value]) -> Value:
    """Return options[index], which becomes the readable value of the column."""
    value = choose(index, options)
    column.show(value if isinstance(value, RandomExpr) else index, 0.0, float(len(options) - 1))
    if not isinstance(value, RandomExpr):
        column.options = tuple(options)
    return value


class Bucketize:
    """An operation that maps uniform numbers [N] to bin indices; `bounds` are the inner bounds of the bins."""

    def __init__(self, bounds: Any) -> None:
        self.bounds = bounds

    def __call__(self, uniform: Any) -> Any:
        return np.searchsorted(self.bounds, uniform, side="right")


def draw_integers(scope: Scope, node: ast.AST, low: Value, high: Value, weights: Value = None) -> Value:
    """Return `DiscreteRange(low, high)`: an integer from ceil(low) to floor(high), uniform or weighted.

    If the ends are random, scenes with an empty range are rejected.
    """
    check_numbers("DiscreteRange", low, high)
    first, last = apply(operations.CEILING, low), apply(operations.FLOOR, high)
    fixed = is_number(first) and is_number(last)
    if fixed and last < first:
        raise ScenicError("value", f"DiscreteRange({low}, {high}) contains no integer")
    if weights is not None:
        if not fixed:
            raise ScenicError("type", "the ends of a DiscreteRange with weights must be fixed numbers")
        return weighted_integers(scope, node, range(first, last + 1), weights)
    column = scope.draw("integers", scope.place(node))
    if not fixed:
        filled = apply(operations.LESS_EQUAL, first, last)
        scope.state.requirements.append(Requirement("a DiscreteRange contains an integer", column.place, filled))
    count = apply(operations.MAXIMUM, last - first + 1, 1)
    value = apply(operations.MINIMUM, apply(operations.INTEGER, column * count), count - 1) + first
    return column.show(value, *((float(first), float(last)) if fixed else (math.nan, math.nan)))


def weighted_integers(scope: Scope, node: ast.AST, integers: range, weights: Value) -> Value:
    """Return one of the integers, with the given weights."""
    if not isinstance(weights, list | tuple) or len(weights) != len(integers):
        what = f"one weight for each of its {len(integers)} integers"
        raise ScenicError("value", f"DiscreteRange takes {what}, not {describe_kind(weights)}")
    return draw_discrete(scope, node, dict(zip(integers, weights, strict=True)))


def draw_normal(scope: Scope, node: ast.AST, mean: Value, spread: Value) -> Value:
    """Return `Normal(mean, standard deviation)`, truncated at eight standard deviations."""
    check_numbers("Normal", mean, spread)
    if is_number(spread) and spread < 0:
        raise ScenicError("value", f"the standard deviation {spread} is negative")
    column = scope.draw("normal", scope.place(node))
    return column.show(mean + spread * apply(operations.NORMAL_QUANTILE, column))


def draw_truncated_normal(scope: Scope, node: ast.AST, mean: Value, spread: Value, low: Value, high: Value) -> Value:
    """Return `TruncatedNormal(mean, standard deviation, low, high)`: a normal value conditioned on [low, high]."""
    check_numbers("TruncatedNormal", mean, spread, low, high)
    if not (is_number(low) and is_number(high)):
        raise ScenicError("type", "the ends of TruncatedNormal must be fixed numbers")
    if not low < high:
        raise ScenicError("value", f"the low end {low} of TruncatedNormal must be below the high end {high}")
    column = scope.draw("normal", scope.place(node))
    start, end = (
        apply(operations.NORMAL_CDF, (low - mean) / spread),
        apply(operations.NORMAL_CDF, (high - mean) / spread),
    )
    raw = mean + spread * apply(operations.NORMAL_QUANTILE, start + (end - start) * column)
    return column.show(apply(operations.CLIP, raw, float(low), float(high)), float(low), float(high))


def point_in(scope: Scope, node: ast.AST, region: Value) -> tuple[Vector, Value]:
    """Return a uniform point of a region (one or two columns of θ) and the region's heading at the point, or None."""
    options = region.options if isinstance(region, RandomChoice) else (region,)
    count = max(option.columns for option in options)
    scales = region.scales() if isinstance(region, Region) else [(0.0, 1.0)] * count
    axes = ("point.x", "point.y") if count == 2 else ("point.along",)
    place = scope.place(node)
    columns = [scope.draw(axis, place, *scale) for axis, scale in zip(axes, scales, strict=True)]
    if isinstance(region, RandomChoice):
        points, headings = zip(*(point_for(option, columns) for option in options), strict=True)
        point, heading = region.map_options(list(points)), None
        if all(heading is not None for heading in headings):
            heading = region.map_options(list(headings))
    else:
        point = region.point(columns[0], columns[-1])
        heading = region.heading_of(point, columns[0])
    if isinstance(region, Region):
        scope.state.points.append(DrawnPoint(region, tuple(columns), point))
    if count == 2:
        show_coordinates(columns, point, region.bounds() if isinstance(region, Region) else None)
    if isinstance(region, Filtered):
        label = "a point passes its region's test"
        scope.state.requirements.append(Requirement(label, place, region.test(point)))
    return point, heading


def point_for(region: Region, uniforms: list[ThetaColumn]) -> tuple[Vector, Value]:
    """Return the point of a region for unscaled uniform numbers, and the heading at the point."""
    scaled = [offset + span * u for (offset, span), u in zip(region.scales(), uniforms, strict=False)]
    point = region.point(scaled[0], scaled[-1])
    return point, region.heading_of(point, scaled[0])


def show_coordinates(columns: list[ThetaColumn], point: Vector, bounds: tuple[float, ...] | None) -> None:
    """Make the coordinates of the point the readable values of the columns from which it is computed."""
    low_x, high_x, low_y, high_y = bounds or (math.nan,) * 4
    for column, shown, low, high in zip(columns, (point.x, point.y), (low_x, low_y), (high_x, high_y), strict=True):
        column.show(shown, low, high)


def resample(scope: Scope, node: ast.AST, value: Value) -> Value:
    """Return `resample(d)`: an independent draw from the same distribution; only for direct draws and fixed values."""
    drawn = value.index if isinstance(value, RandomChoice) else value
    if not isinstance(drawn, RandomExpr | Vector):
        return value
    column = next((column for column in scope.state.columns if column.shown is drawn), None)
    if column is None:
        raise ScenicError("type", "only a value drawn directly from a distribution can be resampled")
    fresh = scope.draw(column.draw_kind, scope.place(node), column.offset, column.span)
    fresh.options, fresh.listed, fresh.weights = column.options, column.listed, column.weights
    again = fresh.show(replaced(column.shown, {id(column): fresh}), column.low, column.high)
    return choose(again, value.options) if isinstance(value, RandomChoice) else again


def replaced(value: RandomExpr, known: dict[int, RandomExpr]) -> RandomExpr:
    """Return a copy of a value with substituted inputs; a value without substituted inputs is not copied."""
    if id(value) not in known:
        parts = [replaced(operand, known) if isinstance(operand, RandomExpr) else operand for operand in value.inputs]
        same = all(a is b for a, b in zip(parts, value.inputs, strict=True))
        known[id(value)] = value if same else RandomExpr(value.operation, tuple(parts), value.kind)
    return known[id(value)]


def check_numbers(name: str, *values: Value) -> None:
    for value in values:
        if not is_scalar(value):
            raise ScenicError("type", f"{name} takes numbers, not {describe_kind(value)}")
