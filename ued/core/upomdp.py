"""The interface of environments and methods: an under-specified POMDP as a Gymnasium vector environment.

A UPOMDP (Dennis et al. 2020, section 3) is a POMDP with free parameters θ that are set from outside. θ is a row of
[-1, 1]^D. A *level* is a record (program, seed, θ). N environments play N levels at a time. The training method
chooses the next level; until it does, an environment repeats its level.

Every episode of a level starts from the same layout, which follows from the level alone. Episodes differ by luck, whose
seed follows from the level's seed, the visit of the level, and the number of the episode in that visit.

Letters: `N` environments, `D` dimensions of θ. Read next: `learning.rollout`, which plays levels, or `adapters.gym`,
which makes a UPOMDP of any Gymnasium environment.
"""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space
from gymnasium.vector import AutoresetMode, VectorEnv

from ued.core.compiled import CompiledRollout
from ued.core.level_space import SEEDS, LevelSpace, check_theta, level_dtype, luck_seed
from ued.core.parameters import Parameter
from ued.core.sparse_image import SparseImage

OPTIONS = ("theta", "reset_mask")  # of `UPOMDP.reset`
PREFETCH = 128  # levels that a trainer announces at a time, at most
STEPPING = "advance", "_advance", "reset_to_levels", "play_again", "_start", "_begin", "observe", "valid", "_playable"
LEVEL_STATE = ("levels", "visits", "episodes", "np_random")


def of_one_agent(space: Space, agents: int) -> Space:
    """Return one agent's space, given the space of all agents of an environment.

    Raises `ValueError` for a space without an axis of this many agents.
    """
    if agents == 1:
        return space
    if isinstance(space, MultiDiscrete) and space.shape == (agents,):
        return Discrete(int(space.nvec[0]), start=int(space.start[0]))
    if isinstance(space, SparseImage) and space.agents == agents:
        return space.of_one_agent()
    if isinstance(space, Box) and space.shape[:1] == (agents,):
        return Box(space.low[0], space.high[0], dtype=space.dtype.type)
    raise ValueError(f"{agents} agents need a Box or a MultiDiscrete with an axis for them, got {space}")


def successes(info: dict[str, Any], ended: np.ndarray, returns: np.ndarray) -> np.ndarray:
    """Return which of the episodes that ended in the environments `ended` `[k]` succeeded: float `[k]`, 0 or 1.

    `info["success"]` `[N]` determines this; if it is missing, or NaN, a return above 0 is a success.
    """
    said = np.asarray(info["success"], float)[ended] if "success" in info else np.full(len(ended), np.nan)
    return np.where(np.isnan(said), returns > 0, said)


def check_count(num_envs: Any) -> int:
    """Validate `num_envs` and return it. Raises ValueError unless it is a positive integer."""
    if isinstance(num_envs, bool) or not isinstance(num_envs, int | np.integer) or num_envs < 1:
        raise ValueError(f"num_envs must be a positive integer, got {num_envs!r}")
    return int(num_envs)


def steps_as_it_plays(upomdp: UPOMDP) -> bool:
    """Return whether single steps of an environment equal the steps of its `_play`.

    They differ if a subclass, or this instance, overrides step methods that its kernel does not call.
    """
    kinds = type(upomdp).__mro__
    depth = next(depth for depth, kind in enumerate(kinds) if "_play" in vars(kind))
    return not any(name in vars(each) for each in (upomdp, *kinds[:depth]) for name in STEPPING)


def set_stream(generator: np.random.Generator, state: Any) -> None:
    """Restore the state of a random stream. Raises ValueError for an invalid state."""
    try:
        generator.bit_generator.state = state
    except (TypeError, KeyError, ValueError, OverflowError) as error:
        raise ValueError(f"np_random is not a valid state of a {type(generator.bit_generator).__name__}") from error


class UPOMDP(LevelSpace, VectorEnv):
    """N environments whose free parameters θ are set from outside. A valid Gymnasium vector environment.

    Subclasses call `__init__` and define `_start` and `_advance`; they may define `valid`, `describe`, `get_state` and
    `set_state`. `step` restarts an ended episode in the same step (`AutoresetMode.SAME_STEP`).
    `info["final_obs"]`, dense `[N, ...]`, then holds the last observations of ended episodes. `info["_final_obs"]`
    `[N]` masks its valid rows; `info["final_info"]` is the info of that step. A trainer that chooses levels calls
    `advance`, which restarts nothing, and then `reset_to_levels` or `play_again`: one reset per episode. An environment
    reports the success of ended episodes in `info["success"]` `[N]`: 1, 0, or NaN if unknown. Without it a return above
    0 is a success; see `successes`.

    Attributes:
        theta_space: `Box(-1, 1, (D,))`.
        levels: the levels being played, `[N]` of `level_dtype(D)`.
        visits: the number of this visit of the level, int `[N]`; another visit of the same level has other luck.
        episodes: the number of the episode in its visit, int `[N]`, starting at 0.
        level_sampler: function that `step` calls with k when k episodes ended; it returns the next k levels of those
            environments, each a new visit. None: environments repeat their levels. Domain randomization per episode is
            `level_sampler = sample_levels`.
        idle: bool `[N]`, environments that need not be stepped; the values that `step` returns for them are
            meaningless. See `mixture`.
        num_agents: A, the agents of each environment, which share one reward. A single agent has no axis of agents;
            with several, observations and actions are `[N, A, ...]`, with the same space for all agents.
        max_episode_steps: maximum length of an episode in steps; None: unknown.
        individual_rewards: whether agents are opponents, each with its own reward in `info["agent_rewards"]` `[N, A]`.
            The rewards `[N]`, from which curricula score levels, are then those of the first side.
        first_side: for opponents, the number of agents on the first side: the first ones, whose critics score levels.
    """

    num_agents = 1
    max_episode_steps: int | None = None
    autoreset_mode = AutoresetMode.SAME_STEP
    individual_rewards = False
    first_side = 1
    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int,
        observation_space: gymnasium.Space,
        action_space: gymnasium.Space,
        parameters: Sequence[Parameter],
    ) -> None:
        for name in ("_start", "_advance"):
            if getattr(type(self), name) is getattr(UPOMDP, name):
                raise TypeError(f"{type(self).__name__} must define {name}: see the class UPOMDP")
        check_count(num_envs)
        self.num_envs = num_envs
        self.single_observation_space = observation_space
        self.single_action_space = action_space
        self.observation_space = gymnasium.vector.utils.batch_space(observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(action_space, num_envs)
        self.parameters = tuple(parameters)
        self.theta_space = Box(-1.0, 1.0, (self.theta_dim,), np.float64)
        self.levels = np.zeros(num_envs, level_dtype(self.theta_dim))
        self.visits = np.zeros(num_envs, np.int64)
        self.episodes = np.zeros(num_envs, np.int64)
        self.level_sampler: Callable[[int], np.ndarray] | None = None
        self.idle = np.zeros(num_envs, bool)

    @property
    def _stream(self) -> np.random.Generator:
        return self.np_random

    @property
    def supports_state(self) -> bool:
        """Whether a checkpoint can hold the result of `get_state`; otherwise a resumed run restarts open episodes."""
        return type(self).get_state is not UPOMDP.get_state

    @property
    def agent_observation_space(self) -> Space:
        """The observation space of one agent."""
        return of_one_agent(self.single_observation_space, self.num_agents)

    @property
    def agent_action_space(self) -> Space:
        """The action space of one agent."""
        return of_one_agent(self.single_action_space, self.num_agents)

    # ------------------------------------------------------------ for subclasses to define

    @property
    def observation_scale(self) -> np.ndarray | None:
        """The size of a large change of each entry of an agent's observation, `[F]`; 0, or None for all: unknown.

        The divisor of a normalized entry is at least a share of this size (`PPOConfig.obs_std_floor`). The size depends
        on the meaning of the entry: a pole 0.05 rad from upright is falling, though an angle might be 1.
        """
        return None

    @abstractmethod
    def _start(self, levels: np.ndarray, where: np.ndarray) -> Any:
        """Start an episode of `levels` `[k]` in the environments `where` (indices `[k]`); return all observations.

        Random numbers of the layout come from the level's seed, random numbers of luck from `luck_seeds(where)`.
        """

    @abstractmethod
    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all; return observations, rewards, terminated, truncated `[N]`, info.

        An environment whose episode ended keeps its last observation until it is restarted.
        """

    def prefetch(self, levels: np.ndarray) -> None:
        """Announce levels `[k]` of the next resets, in this order; no result depends on it.

        Trainers announce up to `PREFETCH` levels at a time, before they reset to the level that comes before them. An
        environment can prepare several levels together if that saves time. By default nothing happens.
        """

    @property
    def plays_rollouts(self) -> bool:
        """Whether `play` plays whole rollouts in one call: its class defines `_prepare` and `_play`."""
        return False

    def _prepare(self, levels: np.ndarray) -> np.ndarray:
        """Prepare levels `[k]` for `_play`; return their rows in the simulator, negative for invalid levels."""
        raise NotImplementedError(f"{type(self).__name__} does not play rollouts")

    def _play(self, rollout: CompiledRollout) -> None:
        """Play steps of a rollout in a kernel, until it is over or a level is needed; see `kernels.rollout.play`."""
        raise NotImplementedError(f"{type(self).__name__} does not play rollouts")

    def play(self, rollout: CompiledRollout, levels: np.ndarray) -> None:
        """Play steps of a rollout; episodes start on these levels `[k]`, which `rollout.levels` describes.

        Steps and episodes equal those of `advance`, `play_again` and `reset_to_levels`. Invalid levels raise the same
        errors, before any level is played.
        """
        self._check_levels(levels, len(levels))
        envs, ended = rollout.envs, rollout.events
        rollout.levels.start[: len(levels)] = self._prepare(levels) if len(levels) else ()
        envs.seed[:], envs.visit[:], envs.episode[:] = self.levels["seed"], self.visits, self.episodes
        self._play(rollout)
        self.visits[:], self.episodes[:] = envs.visit, envs.episode
        taken = np.flatnonzero(ended.taken[: rollout.counters["events"][0]] >= 0)
        for event in taken.tolist():  # in order, since an environment may have taken several levels
            self.levels[ended.env[event]] = levels[ended.taken[event]]

    def report_failure(self) -> None:
        """Raise the error of an environment that failed in `play`."""
        raise NotImplementedError(f"{type(self).__name__} does not play rollouts")

    def _playable(self, levels: np.ndarray) -> np.ndarray:
        """Return which levels `[k]` are valid: bool `[k]`."""
        return self.valid(levels["theta"])

    def get_state(self) -> dict[str, Any]:
        """Return all mutable state, as arrays and plain values; `set_state` on a copy resumes bit for bit."""
        raise NotImplementedError(f"{type(self).__name__} does not support get_state")

    def set_state(self, state: dict[str, Any]) -> Any:
        """Restore a state returned by `get_state`; return its observations `[N, ...]`."""
        raise NotImplementedError(f"{type(self).__name__} does not support set_state")

    def level_state(self) -> dict[str, Any]:
        """Return the state that every UPOMDP has: the levels being played, and the stream of levels."""
        return {
            "levels": self.levels.copy(),
            "visits": self.visits.copy(),
            "episodes": self.episodes.copy(),
            "np_random": self.np_random.bit_generator.state,
        }

    def set_level_state(self, state: Any, *names: str) -> None:
        """Restore a state returned by `level_state`.

        Raises:
            ValueError: unless the state has these entries and `names`, and levels of this dtype for all
                environments; nothing is changed.
        """
        missing = [name for name in (*LEVEL_STATE, *names) if not (isinstance(state, dict) and name in state)]
        if missing:
            raise ValueError(f"a state is what get_state returned, a dict with {missing[0]!r}, got {state!r:.100}")
        levels, expected = state["levels"], (self.levels.shape, self.levels.dtype)
        if not isinstance(levels, np.ndarray) or (levels.shape, levels.dtype) != expected:
            raise ValueError(f"the state must hold {self.num_envs} levels of {self.levels.dtype}, got {levels!r:.100}")
        check_theta(levels["theta"], self.theta_dim)
        numbers = [self._numbers(state[name], levels.shape) for name in ("visits", "episodes")]
        set_stream(self.np_random, state["np_random"])
        self.levels[:], self.visits[:], self.episodes[:] = levels, *numbers

    def luck_seeds(self, where: np.ndarray) -> np.ndarray:
        """Return the luck seeds of the episodes that start in the environments `where` `[k]`: uint64 `[k]`.

        If a level's seed determines its layout, luck seeds differ from it in every episode.
        """
        first = 0 if self.seed_is_luck else 1
        seeds, visits, episodes = self.levels["seed"][where], self.visits[where], self.episodes[where] + first
        rows = zip(seeds.tolist(), visits.tolist(), episodes.tolist(), strict=True)  # ints: faster for few rows
        return np.array([luck_seed(*row) for row in rows], np.uint64)

    def copy(self) -> UPOMDP:
        """Return an independent UPOMDP of the same kind in the same state; it has no `level_sampler`."""
        raise NotImplementedError(f"{type(self).__name__} does not support copy")

    def with_scripted_policy(self) -> UPOMDP:
        """Return a copy that plays a scripted policy in place of the actions passed to it."""
        raise NotImplementedError(f"{type(self).__name__} provides no scripted policy")

    # ------------------------------------------------------------ levels

    def reset_to_levels(
        self, levels: np.ndarray, where: np.ndarray | None = None, visits: Any = 0, episodes: Any = 0
    ) -> tuple[Any, dict[str, Any]]:
        """Start the environments `where` (bool `[N]`; None: all) on `levels` `[k]`, one for each.

        `visits` and `episodes`, numbers or `[k]`, are the number of this visit of the level and of its first episode.
        The same level, visit and episode have the same luck in every environment. An invalid level is replaced by a
        random valid level. `info["replaced"]` `[k]` masks the replaced levels; `info["levels"]` `[k]` were played.

        Returns:
            the observations of all N environments, and infos.

        Raises:
            ThetaError: an invalid θ.
            ValueError: a wrong number of levels or an invalid mask.
        """
        chosen = np.flatnonzero(self._mask(where))
        self._check_levels(levels, len(chosen))
        numbers = [self._numbers(value, chosen.shape) for value in (visits, episodes)]
        levels = levels.copy()
        replaced = ~self._playable(levels)
        if replaced.any():
            levels[replaced] = self.sample_levels(int(replaced.sum()))
        self.levels[chosen], self.visits[chosen], self.episodes[chosen] = levels, *numbers
        return self._start(levels, chosen), {"levels": levels, "replaced": replaced}

    def play_again(self, where: np.ndarray | None = None) -> Any:
        """Start the next episode of their levels in the environments `where` (bool `[N]`; None: all).

        Returns:
            the observations of all N environments.
        """
        chosen = np.flatnonzero(self._mask(where))
        self.episodes[chosen] += 1
        return self._start(self.levels[chosen], chosen)

    def _check_levels(self, levels: Any, count: int) -> None:
        """Raise ValueError unless these are `count` levels of the dtype and programs of this UPOMDP."""
        if not isinstance(levels, np.ndarray) or levels.dtype != self.levels.dtype:
            kind = levels.dtype if isinstance(levels, np.ndarray) else type(levels).__name__
            raise ValueError(f"levels must be records of {self.levels.dtype}, got {kind}; see make_levels")
        if levels.shape != (count,):
            raise ValueError(f"{count} environments need as many levels, got an array of shape {levels.shape}")
        check_theta(levels["theta"], self.theta_dim)
        num_programs = len(self.program_names) or 1
        unknown = levels["program"][(levels["program"] < 0) | (levels["program"] >= num_programs)]
        if unknown.size:
            known = "0 is the only program" if num_programs == 1 else f"programs are 0 to {num_programs - 1}"
            raise ValueError(f"a level has program {unknown[0]}; {known}")

    @staticmethod
    def _numbers(value: Any, shape: tuple[int, ...]) -> np.ndarray:
        """Return visits or episodes as integers. Raises ValueError for another shape or negative numbers."""
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "iu" or numbers.shape not in ((), shape) or min(numbers.ravel().tolist()) < 0:
            raise ValueError(f"visits and episodes must be {list(shape)} integers, 0 or larger, got {value!r:.100}")
        return numbers

    def _mask(self, where: Any) -> np.ndarray:
        """Return the mask of environments, bool `[N]`; None: all. Raises ValueError for another shape or dtype."""
        if where is None:
            return np.ones(self.num_envs, bool)
        mask = np.asarray(where)
        if mask.dtype != bool or mask.shape != (self.num_envs,):
            got = f"shape {list(mask.shape)} of {mask.dtype}"
            raise ValueError(f"a mask must have shape [{self.num_envs}] and dtype bool, got {got}")
        return mask

    # ------------------------------------------------------------ Gymnasium's names

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start new episodes on random valid levels, or on `options["theta"]` `[N, D]`.

        `options["reset_mask"]` (bool `[N]`) selects the environments to reset. `seed` seeds the random stream of levels
        and their seeds.

        Raises:
            ValueError: other options.
            ThetaError: an invalid θ.
        """
        if isinstance(seed, list):
            seeds = [number for number in seed if number is not None]
            if seeds:  # a list of None, like None, sets no seed; default_rng([]) would be a fixed stream
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
        """Step all environments; an environment whose episode ended starts its next episode (see the class).

        Returns:
            observations, rewards, terminated and truncated, `[N]` each, and infos.
        """
        observations, rewards, terminated, truncated, info = self.advance(actions)
        ended = terminated | truncated
        if not ended.any():
            return observations, rewards, terminated, truncated, info
        last = dict(info)
        info |= {
            "final_obs": copy.deepcopy(observations),  # may be the environment's own buffer
            "_final_obs": ended,
            "final_info": last,
            "_final_info": ended,
        }
        return self.start_next(ended), rewards, terminated, truncated, info

    def advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all environments and restart none: an ended episode returns its last observation.

        The caller restarts them by `reset_to_levels`, `play_again` or `start_next`, or marks them `idle`.

        Returns:
            as `step`.
        """
        seen, rewards, terminated, truncated, info = self._advance(actions)
        return seen, rewards, np.asarray(terminated, bool), np.asarray(truncated, bool), info

    def start_next(self, where: np.ndarray) -> Any:
        """Start the next episodes in the environments `where` (bool `[N]`).

        They play the levels that `level_sampler` returns, or without it the same levels. A level that it returns
        is a new visit, whose number is drawn from the random stream of levels.

        Returns:
            the observations of all N environments.
        """
        if self.level_sampler is None:
            return self.play_again(where)
        count = int(np.count_nonzero(where))
        levels, visits = self.level_sampler(count), self.np_random.integers(0, SEEDS, count)
        return self.reset_to_levels(levels, where, visits)[0]

    # ------------------------------------------------------------ PAIRED's and the thesis's names

    def reset_random(self) -> Any:
        """Draw all environment parameters at random and reset (thesis, section 4.2); return the observations."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set the environment parameters to θ `[N, D]` and reset (thesis, section 4.2)."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start a new episode on the same levels: the next episode of their visits."""
        return self.play_again()
