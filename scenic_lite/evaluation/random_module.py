"""Python's module `random`, where a program imports it: each call draws from θ, like the distributions of Scenic.

Read next: `language.distributions`.
"""

from __future__ import annotations

import ast
import math
from typing import Any

import numpy as np

from scenic_lite.core.budget import exceeded
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, choose, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language import distributions as draw
from scenic_lite.values.graph import RandomExpr, Value, is_number

MOST_SHUFFLED = 60  # elements; each costs a column of θ


def unit(scope: Scope, node: ast.AST) -> Value:
    """`random()`."""
    return draw.draw_range(scope, node, 0, 1)


def among(scope: Scope, node: ast.AST, seq: Value) -> Value:
    """`choice(seq)`."""
    return draw.draw_uniform(scope, node, *scope.elements(seq, node))


def normal(scope: Scope, node: ast.AST, mu: Value = 0.0, sigma: Value = 1.0) -> Value:
    """`gauss(mu, sigma)`, `normalvariate(mu, sigma)`."""
    return draw.draw_normal(scope, node, mu, sigma)


def integer(scope: Scope, node: ast.AST, a: Value, b: Value) -> Value:
    """`randint(a, b)`, both included."""
    return draw.draw_integers(scope, node, a, b)


def of_range(scope: Scope, node: ast.AST, *ends: Value) -> Value:
    """`randrange(start, stop, step)`."""
    for end in ends:
        scope.refuse_random(end, node, "a range cannot have random ends")
    numbers = range(*ends)
    if not numbers:
        raise ScenicError("value", "a choice among no values")
    index = draw.draw_integers(scope, node, 0, len(numbers) - 1)
    return numbers.start + numbers.step * index


def triangular(scope: Scope, node: ast.AST, low: Value = 0.0, high: Value = 1.0, mode: Value = None) -> Value:
    """`triangular(low, high, mode)`, by its inverse cumulative distribution."""
    mode = (low + high) / 2 if mode is None else mode
    fixed_numbers("triangular", low, high, mode)
    if not low <= mode <= high or low == high:
        raise ScenicError("value", "triangular() needs low <= mode <= high")
    peak = (mode - low) / (high - low)
    rise, fall = math.sqrt(peak), math.sqrt(1 - peak)

    def quantile(uniform: Any) -> Any:
        up = np.sqrt(uniform) * rise
        return low + (high - low) * np.where(uniform < peak, up, 1 - np.sqrt(1 - uniform) * fall)

    return RandomExpr(quantile, (unit(scope, node),))


def exponential(scope: Scope, node: ast.AST, lambd: Value = 1.0) -> Value:
    """`expovariate(lambd)`."""
    fixed_numbers("expovariate", lambd)
    if lambd == 0:
        raise ScenicError("value", "expovariate() needs a rate that is not 0")
    return RandomExpr(lambda uniform: -np.log1p(-np.minimum(uniform, 1 - 2.0**-53)) / lambd, (unit(scope, node),))


def several(scope: Scope, node: ast.AST, population: Value, weights: Value = None, *, k: Value = 1) -> list:
    """`choices(population, weights, k=...)`, with replacement."""
    items = scope.elements(population, node)
    shares = [1.0] * len(items) if weights is None else scope.elements(weights, node)
    fixed_numbers("choices", k, *shares)
    if len(shares) != len(items) or not all(share >= 0 for share in shares) or not sum(shares) > 0:
        raise ScenicError("value", "choices() needs one weight for each value, none negative and not all 0")
    return [draw.weighted(scope, node, items, shares) for _ in range(k)]


def sample(scope: Scope, node: ast.AST, population: Value, k: Value) -> list:
    """`sample(population, k)`, without replacement."""
    items = scope.elements(population, node)
    fixed_numbers("sample", k)
    if not 0 <= k <= len(items):
        raise ScenicError("value", f"a sample of {k} from {len(items)} values")
    if k > MOST_SHUFFLED:
        raise exceeded(f"a random order of more than {MOST_SHUFFLED} values")
    picks = [draw.draw_integers(scope, node, 0, len(items) - i - 1) for i in range(k)]
    return [choose(RandomExpr(Pick(len(items)), tuple(picks[: i + 1])), items) for i in range(k)]


class Pick:
    """The index of the last of several picks [N] from `count` values of which each is taken once."""

    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self, *picks: Any) -> Any:
        index = np.asarray(picks[-1])
        for earlier in range(len(picks) - 2, -1, -1):  # from the places among those left to the places among all
            index = index + (index >= picks[earlier])
        return index


def shuffle(scope: Scope, node: ast.AST, x: Value) -> None:
    """`shuffle(x)`, in place."""
    if not isinstance(x, list):
        raise ScenicError("type", f"shuffle() needs a list, not {describe_kind(x)}")
    x[:] = sample(scope, node, x, len(x))


def seeded(scope: Scope, node: ast.AST, *seed: Value) -> None:
    """`seed(...)`: whoever draws θ decides that."""


def fixed_numbers(name: str, *numbers: Value) -> None:
    for number in numbers:
        if not is_number(number):
            raise ScenicError("type", f"{name}() takes fixed numbers, not {describe_kind(number)}")


RANDOM: dict[str, Value] = {
    name: Builtin(name, function, needs_context=True, over_choices=False)
    for name, function in (
        ("uniform", draw.draw_range),
        ("random", unit),
        ("randint", integer),
        ("randrange", of_range),
        ("choice", among),
        ("choices", several),
        ("sample", sample),
        ("shuffle", shuffle),
        ("gauss", normal),
        ("normalvariate", normal),
        ("triangular", triangular),
        ("expovariate", exponential),
        ("seed", seeded),
    )
}
