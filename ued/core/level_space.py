"""Levels and the space of levels: all that a curriculum needs from environments.

A level is a record (program, seed, θ). θ `[D]` in [-1, 1] are the free parameters. All random numbers of the level's
layout come from its seed, so a replayed level equals the scored level. Luck differs between episodes; its seeds come
from `luck_seed`.

Letters: `D` dimensions of θ, `n` levels. Read next: `parameters`, the columns of θ; `upomdp`, which plays levels.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.core import parameters
from ued.core.own_code import call
from ued.core.parameters import LevelFamily, Parameter, Seeds, ThetaProgram

MAX_TRIES = 4096  # draws per valid row before `sample_theta` fails
BITS = 2**64 - 1
SEEDS = 2**31  # bound of seeds of levels and luck: every `reset` accepts them, and float64 represents them


class ThetaError(ValueError):
    """Invalid theta: wrong shape, non-numeric, or outside [-1, 1]. The message reports the row and the column."""


class LevelError(RuntimeError):
    """An environment failed. The message reports the operation and the level."""


def level_dtype(dim: int) -> np.dtype:
    """Return the record of one level: `program` (its index), `seed`, `theta` [D]."""
    return np.dtype([("program", np.int32), ("seed", np.uint64), ("theta", np.float64, (dim,))])


def as_void_view(records: np.ndarray) -> np.ndarray:
    """Return a view of records as raw memory: numpy then copies whole rows instead of single fields."""
    array = np.asarray(records)  # drops the slow class of a recarray
    return array.view(np.dtype((np.void, array.itemsize)))


def check_theta(theta: Any, dim: int, rows: int | None = None) -> np.ndarray:
    """Return θ as float64 `[N, D]`, or raise `ThetaError`. One row `[D]` counts as `[1, D]`; `rows`: the required N."""
    try:
        if np.iscomplexobj(theta):
            raise TypeError("complex numbers")
        array = np.asarray(theta, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ThetaError(f"theta must be an array of numbers of shape [N, {dim}], got {theta!r}") from error
    if array.ndim == 1:
        array = array[None]
    if array.ndim != 2 or array.shape[1] != dim or (rows is not None and array.shape[0] != rows):
        shape = f"[{'N' if rows is None else rows}, {dim}]"
        raise ThetaError(f"theta must have shape {shape}, got {list(np.shape(theta))}")
    outside = ~((array >= -1.0) & (array <= 1.0))  # catches NaN too
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise ThetaError(f"theta[{row}, {column}] is {array[row, column]:g}; every entry must be a number in [-1, 1]")
    return array


def luck_seed(seed: int, visit: int = 0, episode: int = 0) -> int:
    """Return the seed of an episode's luck, a fixed function of level seed, visit number and episode number.

    All students that play a visit of a level have the same luck in its k-th episode; another visit has other luck. The
    first episode of visit 0 has the seed of the level itself. The level seed is xor-ed with 31 bits of a hash of the
    other two numbers (SplitMix64's finalizer: Steele, Lea and Flood, OOPSLA 2014).
    """
    state = (visit * 0x9E3779B97F4A7C15 + episode * 0xD1342543DE82EF95) & BITS
    state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & BITS
    state = (state ^ state >> 27) * 0x94D049BB133111EB & BITS
    return seed ^ (state ^ state >> 31) & SEEDS - 1


class LevelSpace:
    """The space of levels: all that a curriculum needs from environments. Every `UPOMDP` is one.

    Subclasses set `parameters` and define `_stream`; they may define `valid` and `describe`.

    Attributes:
        parameters: the D columns of θ: name, low, high, and for a program the position in its text; see `parameters`.
        level_family: samples and mutates levels that are not vectors of parameters; θ are then their codes.
        program_names: names of the K programs of a `mixture`; a level's `program` is an index into them. Empty for a
            single program.
        program_parameters: the columns of θ of each of these programs, which follow column 0, the program.
        seeds: the available seeds, if levels differ only by seed; a level's seed then follows from its θ.
        seed_is_luck: whether θ alone determines the layout, and the level's seed only its luck. Otherwise the seed also
            determines the layout, and two levels with the same θ differ.
        theta_map: defines `valid` and `describe`, such as a program or a `parameters.ThetaMap`; None: all levels are
            valid, and values are linear between low and high.
    """

    parameters: tuple[Parameter, ...]
    level_family: LevelFamily | None = None
    seeds: Seeds | None = None
    seed_is_luck: bool = False
    program_names: tuple[str, ...] = ()
    program_parameters: tuple[tuple[Parameter, ...], ...] = ()
    theta_map: ThetaProgram | None = None

    @property
    def theta_dim(self) -> int:
        """D, the number of columns of θ."""
        return len(self.parameters)

    @property
    def _stream(self) -> np.random.Generator:
        """The random stream of levels and their seeds."""
        raise NotImplementedError(f"{type(self).__name__} must define _stream")

    def valid(self, theta: Any) -> np.ndarray:
        """Return which rows of θ `[N, D]` describe valid levels: bool `[N]`."""
        rows = check_theta(theta, self.theta_dim)
        return np.ones(len(rows), bool) if self.theta_map is None else np.asarray(self.theta_map.valid(rows), bool)

    @property
    def may_reject(self) -> bool:
        """Whether some θ may be invalid: a program, a family, `valid` or a subclass checks them."""
        if type(self).valid is not LevelSpace.valid:
            return True
        rows = self.theta_map
        if not isinstance(rows, parameters.ThetaMap):
            return rows is not None
        return rows.check is not None or hasattr(rows.level_family or rows.program, "valid")

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        """Return each row of θ `[N, D]` in the units of the program: N dicts from name to value."""
        rows = check_theta(theta, self.theta_dim)
        if self.theta_map is not None:
            return [self.theta_map.describe(row) for row in rows]
        names = [parameter.name for parameter in self.parameters]
        return [dict(zip(names, map(_value, self.parameters, row.tolist()), strict=True)) for row in rows]

    def make_levels(self, theta: Any) -> np.ndarray:
        """Return levels with these θ `[n, D]` and new seeds below `SEEDS`: `[n]` of `level_dtype(D)`.

        A column with finitely many values is quantized to the center of its cell, so that equal levels have equal θ.
        """
        theta = parameters.quantize(check_theta(theta, self.theta_dim), self.parameters)
        levels = np.zeros(len(theta), level_dtype(self.theta_dim))
        levels["theta"] = theta
        if self.seeds is not None:
            levels["seed"] = self.seeds.of(theta)
        else:
            levels["seed"] = self._stream.integers(0, SEEDS, len(theta), dtype=np.uint64)
        return levels

    def keep_seeds(self, levels: np.ndarray, seeds: np.ndarray) -> None:
        """Set the seeds `[n]` of levels `[n]`, unless seeds follow from θ."""
        if self.seeds is None:
            levels["seed"] = seeds

    def key_of(self, level: np.void) -> bytes:
        """Return a key that is unique to a level: its program and θ, and its seed.

        The seed is left out if it only determines luck, and for a family, whose codes identify levels.
        """
        key = level["program"].tobytes() + level["theta"].tobytes()
        return key if self.seed_is_luck or self.level_family is not None else key + level["seed"].tobytes()

    def sample_levels(self, count: int) -> np.ndarray:
        """Sample valid levels uniformly (domain randomization): `[count]` of `level_dtype(D)`."""
        return self.make_levels(self.sample_theta(count))

    def simplest_levels(self, count: int) -> np.ndarray:
        """Sample levels from which edits may begin, `[count]` of `level_dtype(D)`.

        Raises ValueError if no level family defines such levels; see `families`.
        """
        family, simplest = self.level_family, getattr(self.level_family, "simplest", None)
        if family is None or simplest is None:
            kind = "these are vectors θ" if family is None else f"{type(family).__name__} has none"
            raise ValueError(f"the simplest levels need a level family with a method `simplest(rng)`; {kind}")
        codes = [family.encode(simplest(self._stream)) for _ in range(count)]
        return self.make_levels(np.reshape(codes, (count, self.theta_dim)))

    def sample_theta(self, count: int) -> np.ndarray:
        """Sample valid θ uniformly, by rejection: `[count, D]`; for a family, codes of its levels.

        Raises `ThetaError` if a row is still invalid after MAX_TRIES draws.
        """
        theta = self._draw(count) if count else np.zeros((0, self.theta_dim))
        wrong = np.flatnonzero(~self.valid(theta)) if count else np.empty(0, int)
        for _ in range(MAX_TRIES):
            if not len(wrong):
                return theta
            theta[wrong] = self._draw(len(wrong))
            wrong = wrong[~self.valid(theta[wrong])]
        raise ThetaError(f"no valid theta found in {MAX_TRIES} draws for {len(wrong)} of {count} rows")

    def _draw(self, count: int) -> np.ndarray:
        """Sample θ `[count, D]`, quantized where columns have finitely many values, without a validity check."""
        if self.level_family is None:
            return parameters.quantize(self._stream.uniform(-1.0, 1.0, (count, self.theta_dim)), self.parameters)
        family = self.level_family
        levels = (call("sample", family.sample, self._stream) for _ in range(count))
        return check_theta([call("encode", family.encode, level) for level in levels], self.theta_dim)

    def edit_theta(self, theta: np.ndarray, num_edits: int, edit_size: float, rng: np.random.Generator) -> np.ndarray:
        """Return edited copies of θ `[k, D]`, which may be invalid; see `parameters.edit`.

        A level of a family is mutated `num_edits` times; `edit_size` is ignored.
        """
        if self.level_family is None:
            return parameters.edit(theta, self.parameters, num_edits, edit_size, rng)
        edited, family = theta.copy(), self.level_family
        for row, code in enumerate(theta):
            level = call("decode", family.decode, code)
            for _ in range(num_edits):
                level = call("mutate", family.mutate, level, rng)
            edited[row] = call("encode", family.encode, level)
        return check_theta(edited, theta.shape[1])


def _value(parameter: Parameter, x: float) -> Any:
    """Return the value of x in [-1, 1] in a column of θ: by its kind, else linearly between its ends."""
    if isinstance(parameter, parameters.Column):
        return parameter.kind.from_unit(x)
    return float(parameter.low + (x + 1) / 2 * (parameter.high - parameter.low))
