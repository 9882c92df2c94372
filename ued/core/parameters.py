"""Parameters of several kinds as columns of θ in [-1, 1].

    {"gravity": Range(5, 15), "mass": LogRange(0.1, 10), "legs": Integer(2, 6), "ground": Choice("grass", "ice")}

A column with finitely many values divides [-1, 1] into cells, whose widths are proportional to the probabilities of the
values. Every θ in a cell is the same value, and levels hold its center, so that equal levels have equal θ. Methods use
these `Cells`: edits and adversaries draw values, entropy counts them. None depends on the order of a choice's options.
Read next: `cells`; `families`, levels that are not vectors; `upomdp`, the interface; `adapters.gym`, which applies
values to environments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import Any, NamedTuple, Protocol

import numpy as np

from ued.core.cells import Cells, bin_center, cut, index_in, names_of
from ued.core.families import LevelFamily
from ued.core.own_code import call

MOST_CATEGORIES = 32  # an `Integer` with more values is treated as a range in steps


class Parameter(Protocol):
    """The interface of one column of θ. `Column` has it, and so does `scenic_lite.Draw`."""

    @property
    def name(self) -> str: ...
    @property
    def low(self) -> float: ...
    @property
    def high(self) -> float: ...


@dataclass(frozen=True)
class Range:
    """A real number between `low` and `high`, uniform: θ = -1 means `low`, θ = 1 means `high`, linearly between."""

    low: float
    high: float
    num_bins = 0

    def __post_init__(self) -> None:
        if not _finite(self.low, self.high):
            raise ValueError(f"the ends of a range must be two finite numbers, got {self.low!r} and {self.high!r}")
        _check_order(self.low, self.high)

    def from_unit(self, x: float) -> float:
        """Return the value of x in [-1, 1]."""
        return self.low + (x + 1) / 2 * (self.high - self.low)

    def to_unit(self, value: float) -> float:
        """Return the x in [-1, 1] of a value."""
        return 2 * (value - self.low) / (self.high - self.low) - 1 if self.high != self.low else 0.0


@dataclass(frozen=True)
class LogRange:
    """A positive number between `low` and `high`, uniform in its logarithm: θ = 0 is the geometric mean."""

    low: float
    high: float
    num_bins = 0

    def __post_init__(self) -> None:
        if not (_finite(self.low, self.high) and self.low > 0 and self.high > 0):
            raise ValueError(f"the ends of a LogRange must be positive and finite, got {self.low!r} and {self.high!r}")
        _check_order(self.low, self.high)

    def from_unit(self, x: float) -> float:
        """Return the value of x in [-1, 1]."""
        return self.low * (self.high / self.low) ** ((x + 1) / 2)

    def to_unit(self, value: float) -> float:
        """Return the x in [-1, 1] of a value."""
        return 2 * math.log(value / self.low) / math.log(self.high / self.low) - 1 if self.high != self.low else 0.0


def _finite(*ends: Any) -> bool:
    return all(isinstance(end, Real) and math.isfinite(end) for end in ends)


def _check_order(low: float, high: float) -> None:
    if low > high:
        raise ValueError(f"the low end of a range must not exceed the high end, got {low} and {high}")


@dataclass(frozen=True)
class Integer:
    """An integer from `low` to `high`, both included."""

    low: int
    high: int

    def __post_init__(self) -> None:
        ends = (self.low, self.high)
        if not _finite(*ends) or any(int(end) != end for end in ends) or self.low > self.high:
            raise ValueError(f"an Integer needs integers low <= high, got {self.low!r} and {self.high!r}")

    @property
    def num_bins(self) -> int:
        return int(self.high) - int(self.low) + 1

    def from_unit(self, x: float) -> int:
        """Return the value of x in [-1, 1]."""
        return int(self.low) + int(index_in(x, self.num_bins))

    def to_unit(self, value: float) -> float:
        """Return the x in [-1, 1] at the center of the cell of a value."""
        return bin_center(value - self.low, self.num_bins)


class Choice:
    """One of several values of any type, without an order.

    Args:
        values: the options, all different.
        weights: relative probabilities of the values in random levels, positive numbers; None: uniform.

    Raises:
        ValueError: without values, for a single list, for equal values, and for weights that do not match them.
    """

    def __init__(self, *values: Any, weights: Sequence[float] | None = None) -> None:
        if not values or (len(values) == 1 and isinstance(values[0], list | tuple | set)):
            raise ValueError("a Choice needs its values one by one, at least one; of a list, Choice(*values)")
        if weights is not None and (len(weights) != len(values) or not _finite(*weights) or min(weights) <= 0):
            raise ValueError(f"a Choice of {len(values)} values needs as many positive weights, got {weights!r}")
        for index, value in enumerate(values):
            if any(_equal(value, other) for other in values[:index]):
                raise ValueError(f"the values of a Choice must differ, got {value!r} twice")
        self.values = values
        self.weights = () if weights is None else tuple(float(weight) for weight in weights)

    def __repr__(self) -> str:
        weighted = f", weights={self.weights}" if self.weights else ""
        return f"Choice({', '.join(map(repr, self.values))}{weighted})"

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return len(self.values) - 1.0

    @property
    def num_bins(self) -> int:
        return len(self.values)

    def from_unit(self, x: float) -> Any:
        """Return the value of x in [-1, 1]."""
        return self.values[int(cut(self.num_bins, self.weights).index(x))]

    def to_unit(self, value: Any) -> float:
        """Return the x in [-1, 1] at the center of the cell of a value."""
        return float(cut(self.num_bins, self.weights).middle(self.values.index(value)))


def _equal(one: Any, other: Any) -> bool:
    try:
        return bool(one == other)
    except ValueError:  # arrays, entry by entry
        return False


Kind = Range | LogRange | Integer | Choice


class Column(NamedTuple):
    """One column of θ: its name and the kind of its values."""

    name: str
    kind: Kind

    @property
    def low(self) -> float:
        return float(self.kind.low)

    @property
    def high(self) -> float:
        return float(self.kind.high)


@dataclass(frozen=True)
class Seeds:
    """Levels that differ only by seed, as in Procgen: `count` seeds `first`, `first + 1`, ... for `reset(seed=)`.

    Raises:
        ValueError: seeds outside [0, 2^31).
    """

    count: int
    first: int = 0

    def __post_init__(self) -> None:
        whole = all(isinstance(x, int) and not isinstance(x, bool) for x in (self.count, self.first))
        if not whole or self.count < 1 or self.first < 0 or self.first + self.count > 2**31:
            raise ValueError(
                f"Seeds(count, first) needs a count of at least 1 and seeds from 0 to 2**31 - 1, got {self.count!r} "
                f"seeds from {self.first!r}"
            )

    @property
    def draws(self) -> tuple[Column, ...]:
        return (Column("seed", Integer(self.first, self.first + self.count - 1)),)

    def of(self, theta: np.ndarray) -> np.ndarray:
        """Return the seeds of θ `[n, 1]`: uint64 `[n]`."""
        return (self.first + index_in(theta[:, 0], self.count)).astype(np.uint64)


class ThetaProgram(Protocol):
    """The part of `scenic_lite.Program` that defines θ: columns, validity `[N]` of θ `[N, D]`, values of θ `[D]`."""

    @property
    def draws(self) -> tuple[Parameter, ...]: ...
    def valid(self, theta: np.ndarray) -> np.ndarray: ...
    def describe(self, theta: np.ndarray) -> dict[str, Any]: ...


Theta = int | Mapping[str, Kind | tuple[float, float]] | ThetaProgram | LevelFamily | Seeds


class ThetaMap:
    """The meaning of θ: D columns, the validity of rows, and their values.

    Args:
        theta: the number of dimensions (values are θ itself, named `theta[0]`, ...); a mapping from name to the kind of
            the parameter, where a pair (low, high) is a `Range`; a program whose random values are the columns; a
            `LevelFamily`, whose levels replace values; or `Seeds`.
        valid: returns whether a level with these values is valid; None: all are.
    """

    def __init__(self, theta: Theta, valid: Callable[[Any], bool] | None = None) -> None:
        self.program: ThetaProgram | None = None
        self.level_family: LevelFamily | None = None
        self.seeds = theta if isinstance(theta, Seeds) else None
        if valid is not None and not callable(valid):
            raise ValueError(f"valid must be a function of a level's values, got {valid!r}")
        self.check = None if valid is None else partial(call, "valid", valid)
        if isinstance(theta, int):
            if theta < 0:
                raise ValueError(f"theta_dim must be 0 or more, got {theta}")
            self.draws: tuple[Parameter, ...] = numbered("theta", theta)
        elif isinstance(theta, Seeds):
            self.draws = theta.draws
        elif isinstance(theta, Mapping):
            self.draws = columns_of(theta)
        elif isinstance(theta, LevelFamily):
            self.level_family, self.draws = theta, numbered("code", theta.size)
        elif hasattr(theta, "draws"):
            self.program, self.draws = theta, theta.draws
        else:
            raise ValueError(
                f"theta must be a number of dimensions, a mapping from name to parameter, a program, a LevelFamily or "
                f"Seeds, got {theta!r}"
            )

    def valid(self, theta: np.ndarray) -> np.ndarray:
        """Return which rows of θ `[n, D]` are valid: bool `[n]`."""
        check = getattr(self.level_family if self.program is None else self.program, "valid", None)
        good = np.ones(len(theta), bool) if check is None else np.array(check(theta), bool)
        if self.check is not None:
            for row in np.flatnonzero(good):
                good[row] = bool(self.check(self.values(theta[row])))
        return good

    def values(self, row: np.ndarray) -> Any:
        """Return one row of θ `[D]` as values by name, in the environment's units; for a family, the level."""
        if self.level_family is not None:
            return self.level_family.decode(row)
        if self.program is not None:
            return self.program.describe(row)
        return {column.name: column.kind.from_unit(x) for column, x in zip(self.draws, row.tolist(), strict=True)}  # type: ignore[attr-defined]

    def describe(self, row: np.ndarray) -> dict[str, Any]:
        """Return one row of θ `[D]` as values by name, for display; for a family, the level."""
        values = self.values(row)
        return {"level": values} if self.level_family is not None else values

    def theta(self, values: Mapping[str, Any]) -> np.ndarray:
        """Return the θ `[D]` of values by name, or of a family's level. Raises `ValueError` for other values."""
        if self.level_family is not None:
            return np.asarray(self.level_family.encode(values), float)
        names = [draw.name for draw in self.draws]
        if self.program is not None or set(values) != set(names):
            raise ValueError(f"a level needs a value for each of {', '.join(names) or 'no name'}, got {dict(values)}")
        return np.array([_placed(draw, values[draw.name]) for draw in self.draws])  # type: ignore[arg-type]


def _placed(column: Column, value: Any) -> float:
    """Return the x in [-1, 1] of a value of a column. Raises `ValueError` if the column does not have the value."""
    try:
        x = column.kind.to_unit(value)
        good = abs(x) <= 1 + 1e-9 and (not column.kind.num_bins or column.kind.from_unit(x) == value)
    except (TypeError, ValueError):  # not a number, or not an option of the choice
        good = False
    if not good:
        raise ValueError(f"{column.name} must be a value of {column.kind}, got {value!r}")
    return min(max(x, -1.0), 1.0)


def numbered(name: str, count: int) -> tuple[Column, ...]:
    """Return columns `name[0]`, `name[1]`, ... from -1 to 1: θ itself."""
    return tuple(Column(f"{name}[{i}]", Range(-1.0, 1.0)) for i in range(count))


def columns_of(kinds: Mapping[str, Any]) -> tuple[Column, ...]:
    """Return columns of these names and kinds. Raises `ValueError` for an invalid name or kind."""
    return tuple(Column(name, _kind(name, about)) for name, about in kinds.items())


def family_columns(family: LevelFamily) -> tuple[Column, ...] | None:
    """Return the columns that a family declares for its codes; None if it declares none.

    Raises `ValueError` if their number is not the length of a code.
    """
    if (declared := getattr(family, "parameters", None)) is None:
        return None
    columns = columns_of(declared)
    if len(columns) != family.size:
        raise ValueError(
            f"the codes of {type(family).__name__} have {family.size} entries, so its `parameters` must have as many, "
            f"got {len(columns)}"
        )
    return columns


def _kind(name: str, about: Any) -> Kind:
    if not (isinstance(name, str) and name.isprintable() and name.strip()):
        raise ValueError(f"the name of a parameter must be a line of text, got {name!r}")
    if isinstance(about, Range | LogRange | Integer | Choice):
        return about
    try:
        low, high = map(float, about)
        return Range(low, high)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{name!r} must be a Range, LogRange, Integer, Choice or a pair of finite numbers, low first, got {about!r}"
        ) from error


def kind_of(draw: Parameter) -> Kind | None:
    """Return the kind of a column, or None if it has none of this module."""
    kind = getattr(draw, "kind", None)
    return kind if isinstance(kind, Range | LogRange | Integer | Choice) else None


class Axis(NamedTuple):
    """An axis on which a column's θ is linear: a format of its label, and the numbers at θ = -1 and 1."""

    note: str
    low: float
    high: float


def axis_of(draw: Parameter) -> Axis:
    """Return the axis of a column: logarithms for a `LogRange`, indices of the options for a choice."""
    kind, cells = kind_of(draw), cells_in(draw)
    if isinstance(kind, LogRange):
        return Axis("log10 {}", math.log10(kind.low), math.log10(kind.high))
    if cells is None:
        return Axis("{}", draw.low, draw.high)
    if not cells.names:  # integers
        return Axis("{}", draw.low - 0.5, draw.high + 0.5)
    listed = ", ".join(f"{index} {name}" for index, name in enumerate(cells.names[:8]))
    return Axis("{} (" + listed.replace("{", "(").replace("}", ")") + ")", -0.5, cells.count - 0.5)


# ---------------------------------------------------------------- columns with finitely many values


def cells_in(draw: Parameter) -> Cells | None:
    """Return the cells of a column; None for a real number.

    A column without a `kind` of this module needs `weights` (and `options`, their names), or the kind "integers".
    """
    kind, weights = getattr(draw, "kind", None), getattr(draw, "weights", ())
    if isinstance(kind, Integer):
        return Cells(kind.num_bins, None, True)
    if isinstance(kind, Choice):
        return cut(kind.num_bins, kind.weights, names=names_of(kind.values))
    if weights:
        return cut(len(weights), weights, names=getattr(draw, "options", ()))
    if isinstance(kind, str) and kind == "integers" and math.isfinite(draw.low) and math.isfinite(draw.high):
        return Cells(int(draw.high) - int(draw.low) + 1, None, True)
    return None


def choice_in(draw: Parameter) -> Cells | None:
    """Return the cells of a column that is treated as categorical; None for reals and for many integers."""
    cells = cells_in(draw)
    return None if cells is None or (cells.ordered and cells.count > MOST_CATEGORIES) else cells


def quantize(theta: np.ndarray, draws: Sequence[Parameter]) -> np.ndarray:
    """Return θ `[n, D]` with each entry of a column of finitely many values moved to the center of its cell."""
    known = [(column, cells) for column, draw in enumerate(draws) if (cells := cells_in(draw)) is not None]
    if not known:
        return theta
    theta = theta.copy()
    even = [(column, cells.count) for column, cells in known if cells.edges is None]
    if even:
        columns, counts = np.array(even).T
        theta[:, columns] = bin_center(index_in(theta[:, columns], counts), counts)
    for column, cells in known:
        if cells.edges is not None:
            theta[:, column] = cells.middle(cells.index(theta[:, column]))
    return theta


def edit(
    theta: np.ndarray, draws: Sequence[Parameter], num_edits: int, edit_size: float, rng: np.random.Generator
) -> np.ndarray:
    """Return copies of θ `[k, D]` with `num_edits` edits each, which depend on the kind of the column.

    A real number changes by up to `edit_size`, within [-1, 1]. An integer of K values changes by at least 1 and at most
    K `edit_size` / 2, rounded. A choice becomes another of its options, drawn by their weights.
    """
    edited, cells = theta.copy(), [cells_in(draw) for draw in draws]
    counts = np.array([0 if known is None else known.count for known in cells])
    rows = np.arange(len(theta))
    for _ in range(num_edits):
        columns = rng.integers(0, theta.shape[1], len(theta))
        moves = rng.uniform(-edit_size, edit_size, len(theta))
        edited[rows, columns] += np.where(counts[columns] > 0, 0.0, moves)
        for row in np.flatnonzero(counts[columns] > 1):
            known = cells[columns[row]]
            assert known is not None
            edited[row, columns[row]] = _other_value(edited[row, columns[row]], known, edit_size / 2, rng)
    return np.clip(edited, -1.0, 1.0)


def _other_value(x: float, cells: Cells, share: float, rng: np.random.Generator) -> float:
    """Return the θ of another value: a nearby value if values are ordered, else any value, drawn by weight."""
    index = int(cells.index(x))
    if not cells.ordered:
        weights = cells.shares.copy()
        weights[index] = 0.0
        return float(cells.middle(int(rng.choice(cells.count, p=weights / weights.sum()))))
    reach = max(1, round(share * cells.count))
    other = int(rng.integers(max(0, index - reach), min(cells.count - 1, index + reach)))
    return float(cells.middle(other + (other >= index)))
