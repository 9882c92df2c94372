"""The seam between environments and methods: an under-specified POMDP as a Gymnasium vector environment.

A UPOMDP (Dennis et al. 2020, section 3) is a POMDP with free parameters θ that somebody else sets. Here θ is a row of
[-1, 1]^D, a *level* is a row (program, seed, θ), and N environments play N levels at a time. Which level comes next is
the business of the method that trains on it, so an environment repeats its level until told otherwise.

Letters: `N` environments, `D` dimensions of θ. Read next: `learning.rollout`, which plays levels, or `gym_upomdp`,
which makes a UPOMDP of any Gymnasium environment.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space
from gymnasium.vector import AutoresetMode, VectorEnv

from ued import parameters
from ued.parameters import LevelFamily, Parameter, ThetaProgram

OPTIONS = ("theta", "reset_mask")  # of `UPOMDP.reset`
MAX_TRIES = 4096  # draws of one valid row before `sample_theta` gives up


class ThetaError(ValueError):
    """A θ that is no θ: wrong shape, not a number, or outside [-1, 1]. The message says which row and column."""


def of_one_agent(space: Space, agents: int) -> Space:
    """Return one agent's space, given that of all agents of an environment.

    Raises `ValueError` for one that is no array with an axis of so many agents.
    """
    if agents == 1:
        return space
    if isinstance(space, MultiDiscrete) and space.shape == (agents,):
        return Discrete(int(space.nvec[0]), start=int(space.start[0]))
    if isinstance(space, Box) and space.shape[:1] == (agents,):
        return Box(space.low[0], space.high[0], dtype=space.dtype.type)
    raise ValueError(f"{agents} agents need a Box or a MultiDiscrete with an axis for them, got {space}")


def successes(info: dict[str, Any], ended: np.ndarray, returns: np.ndarray) -> np.ndarray:
    """Return which of the episodes that ended in the environments `ended` `[k]` succeeded: float `[k]`, 0 or 1.

    What the environment says in `info["success"]` `[N]` counts; where it says nothing, or NaN, a return above 0 does.
    """
    said = np.asarray(info["success"], float)[ended] if "success" in info else np.full(len(ended), np.nan)
    return np.where(np.isnan(said), returns > 0, said)


def level_dtype(dim: int) -> np.dtype:
    """Return the record of one level: `program` (its index), `seed` (of the episode's stream), `theta` [D]."""
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


def check_count(num_envs: Any) -> int:
    """Return a number of environments. Raises ValueError for what is none."""
    if isinstance(num_envs, bool) or not isinstance(num_envs, int | np.integer) or num_envs < 1:
        raise ValueError(f"num_envs must be a whole number from 1 on, got {num_envs!r}")
    return int(num_envs)


def set_stream(generator: np.random.Generator, state: Any) -> None:
    """Put a stream back into a state that it has had. Raises ValueError for what is no such state."""
    try:
        generator.bit_generator.state = state
    except (TypeError, KeyError, ValueError, OverflowError) as error:
        raise ValueError(f"np_random is no state of a {type(generator.bit_generator).__name__}") from error


class LevelSpace:
    """The levels that there are: all that a curriculum needs to know of environments. Every `UPOMDP` is one.

    Subclasses set `draws` and give `_stream`, and where they can `valid` and `describe`.

    Attributes:
        draws: what the D columns of θ are: name, low, high, and for a program the place in its text; see `parameters`.
        family: where levels are no vector of parameters, what draws and mutates them; θ are their codes then.
        program_names: names of the K programs of which its levels may be, program k of a level being the k-th; empty
            where there is one only; see `mixture`.
        program_draws: the columns of θ of each of them, behind column 0, which chooses; empty likewise.
        theta_map: what `valid` and `describe` go by, such as a program or a `parameters.ThetaMap`; None: all levels are
            valid, and a column's values lie evenly between its low and its high.
    """

    draws: tuple[Parameter, ...]
    family: LevelFamily | None = None
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
        """Return levels with these θ `[n, D]` and fresh seeds: `[n]` of `level_dtype(D)`.

        Where a column has finitely many values, θ becomes the middle of its cell: equal levels are equal.
        """
        theta = parameters.snap(check_theta(theta, self.theta_dim), self.draws)
        levels = np.zeros(len(theta), level_dtype(self.theta_dim))
        levels["theta"] = theta
        levels["seed"] = self._stream.integers(0, 2**63, len(theta), dtype=np.uint64)
        return levels

    def sample_levels(self, count: int) -> np.ndarray:
        """Draw valid levels uniformly (domain randomisation): `[count]` of `level_dtype(D)`."""
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


class UPOMDP(LevelSpace, VectorEnv):
    """N environments whose free parameters θ are set from outside. A valid Gymnasium vector environment.

    Subclasses call `__init__` and give `_start`, `_step`, and where they can `valid`, `describe`, `get_state`,
    `set_state`. Episodes that end start again in the same step (`AutoresetMode.SAME_STEP`): `info["final_obs"]` holds
    the last observations of those that ended, dense `[N, ...]`, and `info["_final_obs"]` `[N]` says which rows count;
    `info["final_info"]` is what else was told of them.
    Whether an ended episode succeeded is for the environment to say, in `info["success"]` `[N]`: 1, 0, or NaN where it
    does not know. Whoever says nothing succeeds by a return above 0; see `successes`.

    Attributes:
        theta_space: `Box(-1, 1, (D,))`.
        levels: the levels being played, `[N]` of `level_dtype(D)`.
        next_levels: called with k when k episodes ended in a step; gives the k levels that those environments play
            next. None: each repeats its own. Domain randomisation per episode is `next_levels = sample_levels`.
        upcoming: gives levels that are likely to be started soon, in this order: where starting many takes hardly
            longer than starting one, they may be made ready in one go. No number depends on it. None: not known.
        idle: bool `[N]`, environments that nobody plays. Their steps may be left out, and what `step` gives for them
            means nothing; see `mixture`.
        num_agents: A, who play together in each environment and are paid together. One of them has no axis of agents;
            of several, observations and actions are `[N, A, ...]`, alike for all.
        paid_apart: they are opponents, each of whom learns from a reward of its own, `info["agent_rewards"]` `[N, A]`;
            the rewards `[N]`, by which levels are judged, are those of the first side.
    """

    num_agents = 1
    autoreset_mode = AutoresetMode.SAME_STEP
    paid_apart = False
    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int,
        observation_space: gymnasium.Space,
        action_space: gymnasium.Space,
        draws: Sequence[Parameter],
    ) -> None:
        check_count(num_envs)
        self.num_envs = num_envs
        self.single_observation_space = observation_space
        self.single_action_space = action_space
        self.observation_space = gymnasium.vector.utils.batch_space(observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(action_space, num_envs)
        self.draws = tuple(draws)
        self.theta_space = Box(-1.0, 1.0, (self.theta_dim,), np.float64)
        self.levels = np.zeros(num_envs, level_dtype(self.theta_dim))
        self.next_levels: Callable[[int], np.ndarray] | None = None
        self.upcoming: Callable[[], np.ndarray] | None = None
        self.idle = np.zeros(num_envs, bool)

    @property
    def _stream(self) -> np.random.Generator:
        return self.np_random

    @property
    def gives_state(self) -> bool:
        """Whether `get_state` is data that a checkpoint can hold; else open episodes begin anew after a kill."""
        return type(self).get_state is not UPOMDP.get_state

    @property
    def agent_observation_space(self) -> Space:
        """What one agent sees."""
        return of_one_agent(self.single_observation_space, self.num_agents)

    @property
    def agent_action_space(self) -> Space:
        """What one agent does."""
        return of_one_agent(self.single_action_space, self.num_agents)

    # ------------------------------------------------------------ what a subclass gives

    @property
    def observation_unit(self) -> np.ndarray | None:
        """What counts as a large change of each entry of an agent's observation `[F]`; 0, or None for all: unknown.

        Students do not look closer than at a share of it (`PPOConfig.obs_std_floor`). Only who knows what an entry
        means can tell: a pole 0.05 rad off the plumb is falling, though an angle might be 1.
        """
        return None

    @abstractmethod
    def _start(self, levels: np.ndarray, where: np.ndarray) -> Any:
        """Put the environments `where` (indices `[k]`) at the start of `levels` `[k]`; return all observations."""

    @abstractmethod
    def _step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all, restart ended ones on their own level; return obs, reward, terminated, truncated `[N]`, info."""

    def _playable(self, levels: np.ndarray) -> np.ndarray:
        """Return which levels `[k]` can be started: bool `[k]`."""
        return self.valid(levels["theta"])

    def get_state(self) -> dict[str, Any]:
        """Return everything that changes, as arrays and plain values; `set_state` on a copy resumes bit for bit."""
        raise NotImplementedError(f"{type(self).__name__} cannot give its state")

    def set_state(self, state: dict[str, Any]) -> Any:
        """Take back what `get_state` returned; return the observations `[N, ...]` of that moment."""
        raise NotImplementedError(f"{type(self).__name__} cannot take a state")

    def _check_state(self, state: Any, *names: str) -> None:
        """Raise ValueError unless a state has these entries, and levels of this kind for all environments."""
        missing = [name for name in ("levels", "np_random", *names) if not (isinstance(state, dict) and name in state)]
        if missing:
            raise ValueError(f"a state is what get_state returned, a dict with {missing[0]!r}, got {state!r:.100}")
        levels, expected = state["levels"], (self.levels.shape, self.levels.dtype)
        if not isinstance(levels, np.ndarray) or (levels.shape, levels.dtype) != expected:
            raise ValueError(f"this state is one of other levels, or of another number of them than {self.num_envs}")
        check_theta(levels["theta"], self.theta_dim)

    def copy(self) -> UPOMDP:
        """Return a second, independent UPOMDP of the same kind in the same state."""
        raise NotImplementedError(f"{type(self).__name__} cannot be copied")

    def with_scripted_policy(self) -> UPOMDP:
        """Return a copy in which the learner's part is played by the environment itself; actions are ignored there."""
        raise NotImplementedError(f"{type(self).__name__} has no script that could play the learner's part")

    # ------------------------------------------------------------ levels

    def reset_to_levels(self, levels: np.ndarray, where: np.ndarray | None = None) -> tuple[Any, dict[str, Any]]:
        """Start the environments `where` (bool `[N]`; None: all) on `levels` `[k]`, one for each.

        An invalid level is replaced by a random valid one, never silently: `info["replaced"]` `[k]` says which,
        `info["levels"]` `[k]` what is played instead. Returns the observations of all N environments.
        Raises `ThetaError` for a θ that is none, `ValueError` for a wrong number of levels or another mask.
        """
        chosen = np.flatnonzero(self._mask(where))
        if not isinstance(levels, np.ndarray) or levels.dtype != self.levels.dtype:
            kind = levels.dtype if isinstance(levels, np.ndarray) else type(levels).__name__
            raise ValueError(f"levels must be records of {self.levels.dtype}, got {kind}; see make_levels")
        if levels.shape != chosen.shape:
            raise ValueError(f"{len(chosen)} environments need as many levels, got an array of shape {levels.shape}")
        check_theta(levels["theta"], self.theta_dim)
        num_programs = len(self.program_names) or 1
        unknown = levels["program"][(levels["program"] < 0) | (levels["program"] >= num_programs)]
        if unknown.size:
            known = "0 is the only program" if num_programs == 1 else f"programs are 0 to {num_programs - 1}"
            raise ValueError(f"a level is of program {unknown[0]}; {known}")
        levels = levels.copy()
        replaced = ~self._playable(levels)
        if replaced.any():
            levels[replaced] = self.sample_levels(int(replaced.sum()))
        self.levels[chosen] = levels
        return self._start(levels, chosen), {"levels": levels, "replaced": replaced}

    def _mask(self, where: Any) -> np.ndarray:
        """Return which environments are meant: bool `[N]`, all for None. Raises ValueError for what is no mask."""
        if where is None:
            return np.ones(self.num_envs, bool)
        mask = np.asarray(where)
        if mask.dtype != bool or mask.shape != (self.num_envs,):
            got = f"shape {list(mask.shape)} of {mask.dtype}"
            raise ValueError(f"a mask must be [{self.num_envs}] truth values, one for each environment, got {got}")
        return mask

    # ------------------------------------------------------------ Gymnasium's names

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start new episodes on random valid levels, or on `options["theta"]` `[N, D]`.

        `options["reset_mask"]` (bool `[N]`) restricts it to some environments. `seed` seeds the stream from which
        levels and their seeds are drawn. Raises ValueError for other options, `ThetaError` for a θ that is none.
        """
        if isinstance(seed, list):
            seeds = [number for number in seed if number is not None]
            if seeds:  # a list of None, as of one None, asks for no seed; default_rng([]) would be a fixed stream
                self._np_random = np.random.default_rng(seeds)  # one stream for all environments: the list is hashed
        elif seed is not None:
            super().reset(seed=seed)
        options = {} if options is None else options
        if not isinstance(options, dict):
            raise ValueError(f"reset takes a dict of options, or None, got {options!r:.100}")
        unknown = [name for name in options if name not in OPTIONS]
        if unknown:
            raise ValueError(f"reset has no option {unknown[0]!r}; its options are {' and '.join(map(repr, OPTIONS))}")
        where = options.get("reset_mask")
        count = int(self._mask(where).sum())
        if "theta" in options:
            levels = self.make_levels(check_theta(options["theta"], self.theta_dim, rows=count))
        else:
            levels = self.sample_levels(count)
        return self.reset_to_levels(levels, where)

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all environments; an ended one is already at the start of its next episode (see the class)."""
        observations, rewards, terminated, truncated, info = self._step(actions)
        ended = terminated | truncated
        if ended.any():
            last = {name: value for name, value in info.items() if name not in ("final_obs", "_final_obs")}
            info |= {"final_info": last, "_final_info": ended}
        if self.next_levels is not None:
            count = int(np.count_nonzero(ended))
            if count:
                observations, _ = self.reset_to_levels(self.next_levels(count), ended)
        return observations, rewards, terminated, truncated, info

    # ------------------------------------------------------------ PAIRED's and the thesis's names

    def reset_random(self) -> Any:
        """Draw all environment parameters at random and reset (thesis, section 4.2); return the observations."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set the environment parameters to θ `[N, D]` and reset (thesis, section 4.2)."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start a new episode on the same levels: same θ, the next stretch of the random stream."""
        levels = self.levels.copy()
        levels["seed"] = self.np_random.integers(0, 2**63, self.num_envs, dtype=np.uint64)
        return self.reset_to_levels(levels)[0]
