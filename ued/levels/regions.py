"""Regions of θ: the levels of a lesson, converted from parameters in their own units to columns of θ.

A region is an interval of each column, and the allowed options of some columns. Its levels follow the distribution of
random levels, restricted to the region. Read next: `methods.lessons`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from ued.core.cells import Cells
from ued.core.level_space import MAX_TRIES, LevelSpace, ThetaError
from ued.core.parameters import Parameter, cells_in
from ued.lesson_config import NUMBER, Lesson, split

ENDS = re.compile(rf"({NUMBER})(?:\s*\.\.\s*({NUMBER}))?", re.IGNORECASE)
HALVINGS = 60  # bisections of [-1, 1] to find the θ of a value
ROUNDING = 1e-11  # a value may exceed its limits by this share of them: those of a normal are computed
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
    for name, values in sorted(lesson.region, key=lambda entry: entry[0] != "all"):  # what follows `all` is narrower
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
        _narrow(region, where, _thetas_of(space, column, values))
    elif cells.ordered:
        ends = _ends(parameter.name, values, parameter.low, parameter.high, whole=True)
        first, last = (round(end - parameter.low) for end in ends)
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


def _ends(name: str, values: str, first: float, last: float, whole: bool = False) -> tuple[float, float]:
    """Return the ends of "5..7", or of "5", in ascending order; both are within the limits `first` and `last`.

    A descending parameter, with `first` > `last`, takes its ends in either order. Raises ValueError for others.
    """
    found, bottom, top = ENDS.fullmatch(values), min(first, last), max(first, last)
    if found:
        low, high = (float((end or found[1]).replace("_", "")) for end in found.groups())
        low, high = (min(low, high), max(low, high)) if first > last else (low, high)
        slack = 0 if whole else ROUNDING * max(abs(first), abs(last))
        inside = bottom - slack <= low <= high <= top + slack
        if inside and (not whole or (low.is_integer() and high.is_integer())):
            return max(low, bottom), min(high, top)
    limits = f"{first:.12g}..{last:.12g}"  # so exact that the text is within the slack
    kind = "integers" if whole else "a range or a value"
    raise ValueError(f"{name!r} must be {kind} within {limits}, such as {limits}, got {values!r}")


def _weights(parameter: Parameter, cells: Cells, values: str) -> np.ndarray:
    """Return the probability of each option `[K]`, 0 unless a text such as "grass|'wet, cold'" names it."""
    words = [word.strip() for word in split(r"\|", values)]
    named = [word[1:-1] if word not in cells.names and re.fullmatch(r"'.*'|\".*\"", word) else word for word in words]
    unknown = next((word for word in named if word not in cells.names), None)
    if unknown is not None:
        quoted = (f'"{name}"' if "'" in name else f"'{name}'" for name in cells.names)
        listed = " | ".join(
            sign if re.search(r"[,|]|\buntil\b", name) else name for name, sign in zip(cells.names, quoted, strict=True)
        )
        raise ValueError(f"{parameter.name!r} has no option {unknown!r}; options are {listed}")
    weights = np.where([name in named for name in cells.names], cells.shares, 0.0)
    return weights / weights.sum()


def _thetas_of(space: LevelSpace, column: int, values: str) -> tuple[float, float]:
    """Return the ends in θ of the values of a real column, by bisection of `describe`.

    Raises ValueError for values outside the column's range, and if the column's units depend on other columns.
    """
    name = space.parameters[column].name

    def at(x: float, others: float = 0.0) -> float:
        row = np.full((1, space.theta_dim), others)
        row[0, column] = x
        return float(space.describe(row)[0][name])

    first, last = at(-1.0), at(1.0)
    size = max(1.0, abs(first), abs(last))

    def check(x: float) -> float:
        if abs(at(x, ELSEWHERE) - at(x)) > 1e-6 * size:
            raise ValueError(
                f"the units of {name!r} depend on other parameters; give its range as {name}=theta -0.5..0.5"
            )
        return x

    check(-1.0), check(1.0)
    low, high = sorted(check(_solved(at, value)) for value in _ends(name, values, first, last))
    return low, high


def _solved(at: Callable[[float], float], value: float) -> float:
    """Return the x in [-1, 1] with `at(x)` = `value`, for a monotonic function that has this value."""
    low, high, last = -1.0, 1.0, at(1.0)
    sign = 1 if at(low) <= last else -1
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if sign * at(middle) <= sign * value else (low, middle)
    return 1.0 if value == last else low
