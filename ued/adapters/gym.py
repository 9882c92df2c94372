"""Any Gymnasium environment as a UPOMDP: the user says what θ means, and how it is put into the environment.

`UPOMDPWrapper` does it for one environment and stays a valid Gymnasium environment; `GymUPOMDP` steps N of those and
is what methods train on. Read next: `learning.rollout`.
"""

from __future__ import annotations

import copy
import math
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.vector import AutoresetMode

from ued.core.episode_limit import episode_limit
from ued.core.level_space import LevelError, LevelSpace, check_theta, level_dtype, luck_seed
from ued.core.parameters import Theta, ThetaMap
from ued.core.processes import START_METHOD, end_with_parent
from ued.core.upomdp import UPOMDP, check_count

# Puts a level's values into an environment. What it returns, if that is a dict, is given to `reset` as its options.
Apply = Callable[[gymnasium.Env, Any], object]
# What an environment's own `reset(seed=)` is given: the seed, nothing, or what a function makes of that seed.
SeedRule = bool | Callable[[int], int | None]
# What of an episode is luck: nothing, all that `reset(seed=)` draws, what a seed under this key of the reset's options
# draws, or what a function does with an environment that has been reset, and a seed.
Luck = bool | str | Callable[[gymnasium.Env, int], object]


class Start(NamedTuple):
    """What an episode starts from: θ `[D]` and the seed of its level, and the seed of its luck."""

    theta: np.ndarray
    seed: int
    luck: int


class _Levelled(gymnasium.Wrapper):
    """One environment that is put on levels; errors in it name the level."""

    def __init__(
        self,
        env: gymnasium.Env,
        apply: Apply | None,
        theta_map: ThetaMap,
        seed_episodes: SeedRule = True,
        luck: Luck = False,
    ) -> None:
        super().__init__(env)
        self.apply, self.theta_map, self.seed_episodes, self.luck = apply, theta_map, seed_episodes, luck
        self.start = Start(np.zeros(len(theta_map.draws)), 0, 0)
        self._shape = env.observation_space.shape  # asked once: a chain of wrappers takes longer than the check

    def begin(self, start: Start, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Start an episode; `options` are the user's own for `reset`."""
        self.start = start
        with self._telling("the function that puts levels into it"):
            values = self.theta_map.values(start.theta)
            returned = None if self.apply is None else self.apply(self.env, values)
        if isinstance(returned, dict):
            options = {**returned, **options}
        if isinstance(self.luck, str):
            options = {**options, self.luck: start.luck}
        rule, seed = self.seed_episodes, start.luck if self.luck is True else start.seed
        given = rule(seed) if callable(rule) else seed if rule else None
        with self._telling("reset"):
            observation, info = self.env.reset(seed=given, options=options or None)
            if callable(self.luck):
                seen = self.luck(self.env, start.luck)
                observation = observation if seen is None else seen
            return self._checked(observation), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        with self._telling("step"):
            observation, reward, terminated, truncated, info = self.env.step(action)
            return self._checked(observation), reward, terminated, truncated, info

    def _checked(self, observation: Any) -> Any:
        """Return an observation that has its space's shape. Raises `ValueError` for another."""
        shape = observation.shape if isinstance(observation, np.ndarray) else np.shape(observation)
        if shape != self._shape and self._shape is not None:
            raise ValueError(f"the observation has shape {shape}, observation_space says {self._shape}")
        return observation

    @contextmanager
    def _telling(self, what: str) -> Iterator[None]:
        """Raise whatever goes wrong meanwhile as a `LevelError`."""
        try:
            yield
        except LevelError:
            raise
        except Exception as error:
            level = level_in_words(self.theta_map, self.start.theta, self.start.seed)
            raise LevelError(f"{self.env} failed in {what}: {type(error).__name__}: {error} ({level})") from error


def level_in_words(theta_map: ThetaMap, theta: np.ndarray, seed: int) -> str:
    """Return θ `[D]`, the values it stands for and the seed, for an error."""
    row = ", ".join(f"{x:.6g}" for x in theta[:32]) + ", …" * (len(theta) > 32)
    values = str(theta_map.values(theta))
    shown = values if len(values) < 1000 else values[:1000] + " …"
    return f"level: theta [{row}], that is {shown}; seed {seed}"


class UPOMDPWrapper(LevelSpace, _Levelled, gymnasium.utils.RecordConstructorArgs):
    """One environment with free parameters θ: `reset(options={"theta": θ})`, or the thesis's names.

    `apply(env, values)` puts `values` (name to value) into the environment; it is called before each reset, and a dict
    that it returns is the reset's options. A reset without θ draws a level at random, so a stock trainer sees domain
    randomization. `theta`, `valid`, `seed_episodes` and `luck` are those of `GymUPOMDP`.
    """

    theta_map: ThetaMap

    def __init__(
        self,
        env: gymnasium.Env,
        apply: Apply | None,
        theta: Theta,
        valid: Callable[[Any], bool] | None = None,
        seed_episodes: SeedRule = True,
        luck: Luck = False,
    ) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(
            self, apply=apply, theta=theta, valid=valid, seed_episodes=seed_episodes, luck=luck
        )
        check_luck(luck, seed_episodes)
        _Levelled.__init__(self, env, apply, ThetaMap(theta, valid), seed_episodes, luck)
        self.draws, self.family, self.seeds = self.theta_map.draws, self.theta_map.family, self.theta_map.seeds
        self.seed_is_luck = luck is True or seed_episodes is False
        self.theta_space = Box(-1.0, 1.0, (self.theta_dim,), np.float64)
        self.level = np.zeros(1, level_dtype(self.theta_dim))
        self.visit = self.episode = 0
        self._streams = np.random.default_rng()

    @property
    def _stream(self) -> np.random.Generator:
        return self._streams

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode on `options["theta"]` `[D]`, on `options["level"]` `[1]`, or on a random level.

        `seed` seeds the stream of levels, and is the seed of this level where none is given. A level, a record of
        `level_dtype(D)`, comes with its own; `options["visit"]` is the number of this visit of it, which its luck
        depends on. `info["theta"]` and `info["level_seed"]` say which level it is.

        Raises `ued.core.upomdp.ThetaError` for a wrong shape, NaN, or an entry outside [-1, 1]; ValueError for a θ that
        describes no valid level.
        """
        if seed is not None:
            self._streams = np.random.default_rng(seed)
        options = dict(options or {})
        self.level = self._level_of(options.pop("level", None), options.pop("theta", None), seed)
        self.visit, self.episode = int(options.pop("visit", 0)), 0
        if not 0 <= self.visit < 2**63:
            raise ValueError(f"visit must be a whole number from 0 on, got {self.visit}")
        return self._play(options)

    def _level_of(self, level: Any, theta: Any, seed: int | None) -> np.ndarray:
        """Return the level `[1]` that a reset is to start; see `reset`."""
        if level is not None:
            level = np.atleast_1d(np.array(level))
            if level.dtype != self.level.dtype or level.shape != (1,):
                raise ValueError(f"a level must be one record of {self.level.dtype}, got {level.dtype} {level.shape}")
            check_theta(level["theta"], self.theta_dim)
        else:
            level = self.sample_levels(1) if theta is None else self.make_levels(check_theta(theta, self.theta_dim, 1))
            if seed is not None and self.seeds is None:
                level["seed"] = seed
        if not self.valid(level["theta"])[0]:
            raise ValueError(f"theta {level['theta'][0].tolist()} describes no valid level")
        return level

    def reset_random(self) -> Any:
        """Draw a level at random and reset; return the observation."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set θ `[D]` and reset."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start the next episode of the same level; return the observation."""
        return self.play_again()[0]

    def play_again(self, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start the next episode of the same level, in the same visit; as `reset`."""
        self.episode += 1
        return self._play(options or {})

    def _play(self, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Start an episode of the present level."""
        (seed,), (theta,) = self.level["seed"].tolist(), self.level["theta"]
        luck = luck_seed(seed, self.visit, self.episode + (0 if self.seed_is_luck else 1))
        observation, info = self.begin(Start(theta.copy(), seed, luck), options)
        return observation, {**info, "theta": theta.copy(), "level_seed": seed}


def check_luck(luck: Luck, seed_episodes: SeedRule) -> None:
    """Raise `ValueError` for what says nothing of an environment's luck, or what cannot be had with these seeds."""
    if not (isinstance(luck, bool | str) or callable(luck)) or luck == "":
        raise ValueError(f"luck must be True, False, a key of reset's options or a function, got {luck!r}")
    if luck is True and seed_episodes is False:
        raise ValueError("luck=True is what reset(seed=) draws, which seed_episodes=False does not seed")


SUCCESS = ("success", "is_success")  # what environments call it in their info: Meta-World, Gymnasium-Robotics


def told_success(info: Mapping[str, Any]) -> Any:
    """Return what an environment says of its success in its info, NaN where it says nothing."""
    return next((info[name] for name in SUCCESS if name in info), math.nan)


ENDS = ("slot_terminated", "slot_truncated")  # in the info of a `_Slot`


class _Slot(_Levelled):
    """One environment of a batch: takes its own row of the batch's starts at each reset.

    At the end of an episode it stands still until the next reset. Its batch would refuse to step the others meanwhile,
    so the end is reported in the info alone.
    """

    index = 0
    _last: Any = None  # observation, of an episode that has ended

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self._last = None
        if options is None:  # a vector environment resets on its own account
            return self.env.reset(seed=seed)[0], {}
        theta, seeds, luck, begins = options["starts"]  # [N, D], [N], [N], [N]
        if not begins[self.index]:  # the first reset of a batch asks all
            self._last = np.zeros(self.observation_space.shape, self.observation_space.dtype)
            return self._last, {}
        start = Start(theta[self.index].copy(), int(seeds[self.index]), int(luck[self.index]))
        return self.begin(start, {})[0], {}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        if self._last is not None:
            return self._last, 0.0, False, False, {}
        observation, reward, terminated, truncated, info = super().step(action)
        if terminated or truncated:
            self._last = observation
            info = {**info, **dict(zip(ENDS, (bool(terminated), bool(truncated)), strict=True))}
        return observation, reward, False, False, info


def as_array(env: gymnasium.Env) -> gymnasium.Env:
    """Return an environment whose observations are vectors or images: others are flattened.

    Grey images get an axis of one channel. Raises `ValueError` for observations of no fixed size.
    """
    space = env.observation_space
    if isinstance(space, Box) and len(space.shape) in (1, 3):
        return env
    if isinstance(space, Box) and len(space.shape) == 2 and space.dtype == np.uint8:
        return gymnasium.wrappers.ReshapeObservation(env, (*space.shape, 1))
    parts = {f"observations[{name!r}]": part for name, part in space.items()} if isinstance(space, Dict) else {}
    for name, part in (parts or {"observations": space}).items():
        if not has_fixed_size(part):
            raise ValueError(f"{name} must have a fixed size, got {part}; wrap the environment so that they have")
    return gymnasium.wrappers.FlattenObservation(env)


def has_fixed_size(space: gymnasium.Space) -> bool:
    """Return whether what is in a space can be written as a vector; spaces of other packages may not say."""
    try:
        return space.is_np_flattenable
    except NotImplementedError:
        return False


class GymUPOMDP(UPOMDP):
    """N copies of any Gymnasium environment, each with its own level.

    Observations that are neither vectors nor images (`Dict`, `Discrete`, `MultiBinary` ...) are flattened into vectors.

    Args:
        make_env: makes one environment; called `num_envs` times.
        apply: `apply(env, values)` puts one level's values into an environment, before each of its resets; a dict that
            it returns is the reset's options. None: there is nothing to put.
        theta: number of dimensions; mapping from name to a `Range`, `LogRange`, `Integer`, `Choice` or a pair (low,
            high); a program; a `LevelFamily`; or `Seeds`. See `parameters.ThetaMap`.
        num_envs: N.
        vectorization: "sync" steps them one after the other in this process, "async" each in a process of its own.
            Those give no state: a checkpoint of a training holds their levels, and open episodes begin anew.
        valid: says of the values of one level whether it can be played; None: all can.
        seed_episodes: what `reset(seed=)` of an environment is given: the seed (True), nothing (False: then levels are
            no more than θ, and what is drawn is in nobody's hand), or what a function makes of the seed, for
            environments whose seed is something else, such as the number of a map.
        luck: what of an episode is luck, which is new in each episode of a level: nothing (False), so that all episodes
            of a level start alike; all that `reset(seed=)` draws (True), for environments whose reset adds a little
            noise to what θ describes; what an environment draws from a second seed, under this key of the reset's
            options; or what `luck(env, seed)` does after each reset: what it returns, if not None, is seen first.

    What goes wrong in an environment is raised as a `LevelError` that tells the level.
    """

    theta_map: ThetaMap

    def __init__(
        self,
        make_env: Callable[[], gymnasium.Env],
        apply: Apply | None,
        theta: Theta,
        num_envs: int = 1,
        vectorization: Literal["sync", "async"] = "sync",
        valid: Callable[[Any], bool] | None = None,
        seed_episodes: SeedRule = True,
        luck: Luck = False,
    ) -> None:
        if vectorization not in ("sync", "async"):
            raise ValueError(f"vectorization must be sync or async, got {vectorization!r}")
        for name, function in {"make_env": make_env, "apply": apply}.items():
            if not callable(function) and (name, function) != ("apply", None):
                raise ValueError(f"{name} must be a function, got {function!r}")
        check_luck(luck, seed_episodes)
        self.make_env, self.apply, self.seed_episodes, self.luck = make_env, apply, seed_episodes, luck
        self.theta_map = ThetaMap(theta, valid)
        self.family, self.seeds = self.theta_map.family, self.theta_map.seeds
        self.seed_is_luck = luck is True or seed_episodes is False
        self.vectorization: Literal["sync", "async"] = vectorization
        self._theta, self._valid = theta, valid
        self.vector = self._vectorize(check_count(num_envs))
        spaces = self.vector.single_observation_space, self.vector.single_action_space
        super().__init__(num_envs, *spaces, self.theta_map.draws)
        self.render_mode = self.vector.render_mode
        self.metadata = {**self.metadata, "render_modes": self.vector.metadata.get("render_modes", [])}
        if "render_fps" in self.vector.metadata:
            self.metadata["render_fps"] = self.vector.metadata["render_fps"]
        self._observations: Any = None  # until the first reset
        self._going_on = np.zeros(num_envs, bool)

    def _vectorize(self, num_envs: int) -> Any:
        owner = os.getpid()

        def slot(index: int) -> Callable[[], gymnasium.Env]:
            def make() -> gymnasium.Env:
                if os.getpid() != owner:  # a worker is ended by SIGTERM, whatever the handler that it was forked with
                    signal.signal(signal.SIGTERM, signal.SIG_DFL)
                    end_with_parent(signal.SIGKILL)  # though a step hangs
                made = self.make_env()
                if not isinstance(made, gymnasium.Env):
                    raise ValueError(f"make_env() must return a gymnasium.Env, got {made!r}")
                self.max_episode_steps = episode_limit(made)
                env = _Slot(as_array(made), self.apply, self.theta_map, self.seed_episodes, self.luck)
                env.index = index
                return env

            return make

        slots = [slot(index) for index in range(num_envs)]
        if self.vectorization == "sync":
            return gymnasium.vector.SyncVectorEnv(slots, autoreset_mode=AutoresetMode.DISABLED)
        return gymnasium.vector.AsyncVectorEnv(slots, context=START_METHOD, autoreset_mode=AutoresetMode.DISABLED)

    def theta_of(self, values: Any) -> np.ndarray:
        """Return the θ `[D]` of values by name, or of a family's level. Raises `ValueError` for other names."""
        return self.theta_map.theta(values)

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        begins, luck = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, np.uint64)
        begins[where], luck[where] = True, self.luck_seeds(where)
        if begins.any():
            starts = self.levels["theta"], self.levels["seed"], luck, begins
            mask = begins if self._observations is not None else np.ones(self.num_envs, bool)
            self._observations, _ = self.vector.reset(options={"reset_mask": mask, "starts": starts})
            self._check_finite("an observation", self._observations)
        return self._observations.copy()

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        self._observations, rewards, _, _, told = self.vector.step(actions)
        terminated, truncated = (np.array(told.get(end, self._going_on), bool) for end in ENDS)
        self._check_finite("a reward", rewards)
        self._check_finite("an observation", self._observations)
        info = {"success": self._success(told)}
        return self._observations.copy(), rewards, terminated, truncated, info

    def _check_finite(self, what: str, numbers: np.ndarray) -> None:
        """Raise `LevelError` where an environment gave NaN or infinity in its part of `[N, ...]`."""
        if numbers.dtype.kind != "f" or np.isfinite(numbers).all():
            return
        index = int(np.flatnonzero(~np.isfinite(numbers).reshape(self.num_envs, -1).all(1))[0])
        level = level_in_words(self.theta_map, self.levels["theta"][index], int(self.levels["seed"][index]))
        raise LevelError(f"environment {index} gave {what} that is not finite: {numbers[index]} ({level})")

    def _success(self, told: Mapping[str, Any]) -> np.ndarray:
        """Return `info["success"]` `[N]` from the infos of the environments, some of which may say nothing."""
        success = np.full(self.num_envs, np.nan)
        for name in reversed(SUCCESS):
            if name in told:
                says = told.get(f"_{name}", np.ones(self.num_envs, bool))
                success[says] = np.asarray(told[name], float)[says]
        return success

    gives_state = False  # Python objects

    def get_state(self) -> dict[str, Any]:
        """Return everything that changes; the environments themselves are Python objects, copied deeply."""
        if self.vectorization == "async":
            raise NotImplementedError('environments in processes of their own give no state; use vectorization="sync"')
        try:
            envs = copy.deepcopy(self.vector)
        except Exception as error:  # whatever the environments hold: windows, clocks, connections
            raise NotImplementedError(f"these environments cannot be copied: {error}") from error
        return {**self.level_state(), "observations": self._observations.copy(), "envs": envs}

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self.set_level_state(state, "envs", "observations")
        self.vector = copy.deepcopy(state["envs"])
        self._observations = state["observations"].copy()
        return self._observations.copy()

    def resized(self, num_envs: int) -> GymUPOMDP:
        """Return a second one of so many environments, with a stream of its own; nothing is reset yet."""
        rules = self._valid, self.seed_episodes, self.luck
        return GymUPOMDP(self.make_env, self.apply, self._theta, num_envs, self.vectorization, *rules)

    def copy(self) -> GymUPOMDP:
        """Return a second one; environments that give no state begin the same levels anew."""
        twin = self.resized(self.num_envs)
        try:
            twin.set_state(self.get_state())
        except NotImplementedError:
            twin.np_random.bit_generator.state = self.np_random.bit_generator.state
            twin.reset_to_levels(self.levels, None, self.visits, self.episodes)
        return twin

    def render(self) -> tuple[Any, ...] | None:
        """Return what each environment shows of itself, if it was made with a `render_mode`."""
        return self.vector.render()

    def close_extras(self, **kwargs: Any) -> None:
        self.vector.close(**kwargs)
