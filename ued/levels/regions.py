"""Regions of θ: the levels of a lesson, converted from parameters in their own units to columns of θ.

A region is an interval of each column, and the allowed options of some columns. Its levels follow the distribution of
random levels, restricted to the region. Read next: `methods.lessons`.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from ued.core.cells import Cells
from ued.core.level_space import MAX_TRIES, LevelSpace, ThetaError
from ued.core.parameters import Parameter, cells_in
from ued.lesson_config import NUMBER, Lesson

ENDS = re.compile(rf"({NUMBER})(?:\s*\.\.\s*({NUMBER}))?", re.IGNORECASE)
HALVINGS = 60  # bisections of [-1, 1] to find the θ of a value
ELSEWHERE = 0.37  # value of the other columns, to test whether a column's units depend on them


@dataclass(frozen=True)
class Region:
    """A part of [-1, 1]^D.

    Attributes:
        low, high: ends of each column `[D]`.
        options: for columns with restricted options, by index: the probability of each option `[K]`.
    """

    low: np.ndarray
    high: np.ndarray
    options: dict[int, np.ndarray]

    def towards(self, other: Region, share: float) -> Region:
        """Return this region with its ends moved by a share of the way to those of another; options do not change."""
        low, high = (one + share * (two - one) for one, two in ((self.low, other.low), (self.high, other.high)))
        return Region(low, high, self.options)

    def sample(self, space: LevelSpace, count: int, rng: np.random.Generator, where: str) -> np.ndarray:
        """Sample levels of the region, `[count]` of `level_dtype(D)`, by rejection of invalid levels.

        Raises `ThetaError`, which names `where`, if a level is still invalid after MAX_TRIES draws.
        """
        theta = self._draw(space, count, rng)
        wrong = np.flatnonzero(~space.valid(theta)) if count else np.empty(0, int)
        for _ in range(MAX_TRIES):
            if not len(wrong):
                return space.make_levels(theta)
            theta[wrong] = self._draw(space, len(wrong), rng)
            wrong = wrong[~space.valid(theta[wrong])]
        raise ThetaError(f"no valid level found in {MAX_TRIES} draws of {where}")

    def _draw(self, space: LevelSpace, count: int, rng: np.random.Generator) -> np.ndarray:
        """Sample θ `[count, D]` without a validity check."""
        theta = self.low + (self.high - self.low) * rng.random((count, len(self.low)))
        for column, weights in self.options.items():
            cells = cells_in(space.parameters[column])
            assert cells is not None
            theta[:, column] = cells.middle(rng.choice(cells.count, count, p=weights))
        return theta


def region_of(space: LevelSpace, lesson: Lesson) -> Region:
    """Return the region of a lesson. Raises ValueError for unknown parameters and invalid values."""
    region = Region(np.full(space.theta_dim, -1.0), np.full(space.theta_dim, 1.0), {})
    names = [parameter.name for parameter in space.parameters]
    for name, values in lesson.region:
        try:
            if name == "all" and name not in names:
                _narrow(region, np.array([cells_in(one) is None for one in space.parameters]), _theta(values))
            elif name not in names:
                near = get_close_matches(name, names, 1)
                hint = f" (did you mean {near[0]!r}?)" if near else ""
                listed = ", ".join(names[:20]) + ", ..." * (len(names) > 20)
                raise ValueError(f"there is no parameter {name!r}{hint}; parameters are {listed}")
            else:
                _restrict(region, space, names.index(name), values)
        except ValueError as error:
            raise ValueError(f"the lesson {lesson.text!r}: {error}") from error
    return region


def _restrict(region: Region, space: LevelSpace, column: int, values: str) -> None:
    """Restrict one column of a region to the values that a text specifies."""
    cells, parameter = cells_in(space.parameters[column]), space.parameters[column]
    where = np.arange(len(region.low)) == column
    if values.startswith("theta "):
        _narrow(region, where, _theta(values))
    elif cells is None:
        low, high = _ends(parameter, values)
        _narrow(region, where, (_theta_of(space, column, low), _theta_of(space, column, high)))
    elif cells.ordered:
        first, last = (round(end - parameter.low) for end in _ends(parameter, values))
        _narrow(region, where, (2 * first / cells.count - 1, 2 * (last + 1) / cells.count - 1))
    else:
        region.options[column] = _weights(parameter, cells, values)


def _narrow(region: Region, where: np.ndarray, ends: tuple[float, float]) -> None:
    region.low[where], region.high[where] = ends


def _theta(values: str) -> tuple[float, float]:
    """Return the ends of "theta -0.5..0.5". Raises ValueError for another text."""
    found = ENDS.fullmatch(values.removeprefix("theta ").strip()) if values.startswith("theta ") else None
    low, high = (float(end or found[1]) for end in found.groups()) if found else (math.nan, math.nan)
    if not -1 <= low <= high <= 1:
        raise ValueError(f"{values!r} must be a part of the range in theta, as 'theta -0.5..0.5', from -1 to 1")
    return low, high


def _ends(parameter: Parameter, values: str) -> tuple[float, float]:
    """Return the ends of "5..7", or of "5"; both are values of the parameter. Raises ValueError for others."""
    found = ENDS.fullmatch(values)
    whole = cells_in(parameter) is not None
    if found:
        low, high = (float((end or found[1]).replace("_", "")) for end in found.groups())
        inside = not low < parameter.low and not high > parameter.high and low <= high  # limits may be nan
        if inside and (not whole or (low.is_integer() and high.is_integer())):
            return low, high
    limits = f"{parameter.low:g}..{parameter.high:g}"
    kind = "integers" if whole else "a range or a value"
    raise ValueError(f"{parameter.name!r} must be {kind} within {limits}, such as {limits}, got {values!r}")


def _weights(parameter: Parameter, cells: Cells, values: str) -> np.ndarray:
    """Return the probability of each option `[K]`, 0 unless a text such as "grass|ice" names it."""
    named = [word.strip() for word in values.split("|")]
    unknown = next((word for word in named if word not in cells.names), None)
    if unknown is not None:
        listed = " | ".join(cells.names)
        raise ValueError(f"{parameter.name!r} has no option {unknown!r}; options are {listed}")
    weights = np.where([name in named for name in cells.names], cells.shares, 0.0)
    return weights / weights.sum()


def _theta_of(space: LevelSpace, column: int, value: float) -> float:
    """Return the θ of a value of a real column, by bisection of `describe`.

    Raises ValueError for a value outside the column's range, and if the column's units depend on other columns.
    """
    name = space.parameters[column].name

    def at(x: float, others: float = 0.0) -> float:
        row = np.full((1, space.theta_dim), others)
        row[0, column] = x
        return float(space.describe(row)[0][name])

    low, high = -1.0, 1.0
    first, last = at(low), at(high)
    if not first <= value <= last:
        raise ValueError(f"{name!r} must be within {first:g}..{last:g}, got {value:g}")
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if at(middle) <= value else (low, middle)
    x = 1.0 if value == last else low
    size = max(abs(first), abs(last)) if math.isfinite(last - first) else max(1.0, abs(value))
    if abs(at(x, ELSEWHERE) - value) > 1e-6 * max(1.0, size):
        raise ValueError(f"the units of {name!r} depend on other parameters; give its range as {name}=theta -0.5..0.5")
    return x
