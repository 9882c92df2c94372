"""What a level is, and the levels that there are: all that a curriculum needs to know of environments.

A level is a row (program, seed, θ). θ `[D]` in [-1, 1] are the free parameters. The seed is the level's own: whatever
an environment draws when it lays out its world comes from it, so a level that is played again is the level that was
scored. What differs from episode to episode is luck; `luck_seed` says where it comes from.

Letters: `D` dimensions of θ, `n` levels. Read next: `parameters`, the columns of θ; `upomdp`, which plays levels.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.core import parameters
from ued.core.parameters import LevelFamily, Parameter, Seeds, ThetaProgram

MAX_TRIES = 4096  # draws of one valid row before `sample_theta` gives up
BITS = 2**64 - 1
SEEDS = 2**31  # seeds of levels and of luck are below: every `reset` takes them, and a table of float64 holds them


class ThetaError(ValueError):
    """Invalid theta: wrong shape, non-numeric, or outside [-1, 1]. The message reports the row and the column."""


class LevelError(RuntimeError):
    """An environment failed. The message reports the operation and the level."""


def level_dtype(dim: int) -> np.dtype:
    """Return the record of one level: `program` (its index), `seed`, `theta` [D]."""
    return np.dtype([("program", np.int32), ("seed", np.uint64), ("theta", np.float64, (dim,))])


def whole(records: np.ndarray) -> np.ndarray:
    """Return records as pieces of memory: a view, of which numpy copies rows in one go instead of field by field."""
    array = np.asarray(records)  # of a recarray, which is slow to look at
    return array.view(np.dtype((np.void, array.itemsize)))


def check_theta(theta: Any, dim: int, rows: int | None = None) -> np.ndarray:
    """Return θ as float64 `[N, D]`, or raise `ThetaError`. One row `[D]` counts as `[1, D]`; `rows` demands N."""
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
    """Return the seed of an episode's luck, a fixed function of level seed, visit and number of the episode.

    Whoever plays a visit of a level has the same luck in its k-th episode; another visit brings other luck. The first
    episode of visit 0 has the seed of the level itself. It is the seed xor 31 bits of a hash of the two numbers
    (SplitMix64's finalizer: Steele, Lea and Flood, OOPSLA 2014).
    """
    state = (visit * 0x9E3779B97F4A7C15 + episode * 0xD1342543DE82EF95) & BITS
    state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & BITS
    state = (state ^ state >> 27) * 0x94D049BB133111EB & BITS
    return seed ^ (state ^ state >> 31) & SEEDS - 1


class LevelSpace:
    """The levels that there are: all that a curriculum needs to know of environments. Every `UPOMDP` is one.

    Subclasses set `draws` and give `_stream`, and where they can `valid` and `describe`.

    Attributes:
        draws: what the D columns of θ are: name, low, high, and for a program the place in its text; see `parameters`.
        family: where levels are no vector of parameters, what draws and mutates them; θ are their codes then.
        program_names: names of the K programs of which its levels may be, program k of a level being the k-th; empty
            where there is one only; see `mixture`.
        program_draws: the columns of θ of each of them, behind column 0, which chooses; empty likewise.
        seeds: where levels are nothing but seeds, which ones; a level's seed follows from its θ then.
        seed_is_luck: θ alone fixes how an episode starts, and a level's seed is of its luck; else the seed is of its
            layout, and two levels of the same θ differ.
        theta_map: what `valid` and `describe` go by, such as a program or a `parameters.ThetaMap`; None: all levels are
            valid, and a column's values lie evenly between its low and its high.
    """

    draws: tuple[Parameter, ...]
    family: LevelFamily | None = None
    seeds: Seeds | None = None
    seed_is_luck: bool = False
    program_names: tuple[str, ...] = ()
    program_draws: tuple[tuple[Parameter, ...], ...] = ()
    theta_map: ThetaProgram | None = None

    @property
    def theta_dim(self) -> int:
        """D, the number of columns of θ."""
        return len(self.draws)

    @property
    def _stream(self) -> np.random.Generator:
        """The stream from which levels and their seeds are drawn."""
        raise NotImplementedError(f"{type(self).__name__} has no stream")

    def valid(self, theta: Any) -> np.ndarray:
        """Return for each row of θ `[N, D]` whether it describes a level that can be played: bool `[N]`."""
        rows = check_theta(theta, self.theta_dim)
        return np.ones(len(rows), bool) if self.theta_map is None else np.asarray(self.theta_map.valid(rows), bool)

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        """Return each row of θ `[N, D]` in the units of the program: a list of N dicts, name to value."""
        rows = check_theta(theta, self.theta_dim)
        if self.theta_map is not None:
            return [self.theta_map.describe(row) for row in rows]
        low = np.array([parameter.low for parameter in self.draws])  # [D]
        high = np.array([parameter.high for parameter in self.draws])  # [D]
        values = low + (rows + 1) / 2 * (high - low)  # [N, D]
        names = [parameter.name for parameter in self.draws]
        return [dict(zip(names, map(float, row), strict=True)) for row in values]

    def make_levels(self, theta: Any) -> np.ndarray:
        """Return levels with these θ `[n, D]` and fresh seeds below `SEEDS`: `[n]` of `level_dtype(D)`.

        Where a column has finitely many values, θ becomes the middle of its cell: equal levels are equal.
        """
        theta = parameters.snap(check_theta(theta, self.theta_dim), self.draws)
        levels = np.zeros(len(theta), level_dtype(self.theta_dim))
        levels["theta"] = theta
        if self.seeds is not None:
            levels["seed"] = self.seeds.of(theta)
        else:
            levels["seed"] = self._stream.integers(0, SEEDS, len(theta), dtype=np.uint64)
        return levels

    def keep_seeds(self, levels: np.ndarray, seeds: np.ndarray) -> None:
        """Give levels `[n]` these seeds `[n]`, but where a seed follows from θ."""
        if self.seeds is None:
            levels["seed"] = seeds

    def key_of(self, level: np.void) -> bytes:
        """Return what tells a level from all others: its program and θ, and its seed.

        Not the seed where it is luck, nor of a family, whose code says all of a level.
        """
        key = level["program"].tobytes() + level["theta"].tobytes()
        return key if self.seed_is_luck or self.family is not None else key + level["seed"].tobytes()

    def sample_levels(self, count: int) -> np.ndarray:
        """Draw valid levels uniformly (domain randomization): `[count]` of `level_dtype(D)`."""
        return self.make_levels(self.sample_theta(count))

    def sample_theta(self, count: int) -> np.ndarray:
        """Draw valid θ uniformly, by rejection: `[count, D]`; of a family, codes of its levels.

        Raises `ThetaError` where a row is still invalid after MAX_TRIES draws.
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
        """Draw θ `[count, D]`, valid or not."""
        if self.family is None:
            return self._stream.uniform(-1.0, 1.0, (count, self.theta_dim))
        levels = (self.family.sample(self._stream) for _ in range(count))
        return check_theta([self.family.encode(level) for level in levels], self.theta_dim)

    def edit_theta(self, theta: np.ndarray, num_edits: int, edit_size: float, rng: np.random.Generator) -> np.ndarray:
        """Return edited copies of θ `[k, D]`, valid or not: see `parameters.edit`.

        A level of a family is mutated `num_edits` times; `edit_size` means nothing to it.
        """
        if self.family is None:
            return parameters.edit(theta, self.draws, num_edits, edit_size, rng)
        edited = theta.copy()
        for row, code in enumerate(theta):
            level = self.family.decode(code)
            for _ in range(num_edits):
                level = self.family.mutate(level, rng)
            edited[row] = self.family.encode(level)
        return check_theta(edited, theta.shape[1])
