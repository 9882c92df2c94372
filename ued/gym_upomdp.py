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
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.vector import AutoresetMode

from ued.episode_limit import episode_limit
from ued.parameters import Theta, ThetaMap
from ued.upomdp import UPOMDP, LevelSpace, check_count, check_theta, set_stream

# Puts a level's values into an environment. What it returns, if that is a dict, is given to `reset` as its options.
Apply = Callable[[gymnasium.Env, Any], object]
# What an environment's own `reset(seed=)` is given: the level's seed, nothing, or what a function makes of that seed.
SeedRule = bool | Callable[[int | None], int | None]


class LevelError(RuntimeError):
    """Something went wrong in an environment; the message says in what, and on which level."""


class _Levelled(gymnasium.Wrapper):
    """One environment that is put on levels; errors in it tell on which."""

    def __init__(self, env: gymnasium.Env, apply: Apply, theta_map: ThetaMap, seed_episodes: SeedRule = True) -> None:
        super().__init__(env)
        self.apply, self.theta_map, self.seed_episodes = apply, theta_map, seed_episodes
        self.theta = np.zeros(len(theta_map.draws))
        self.seed: int | None = None
        self._shape = env.observation_space.shape  # asked once: a chain of wrappers takes longer than the check

    def begin(self, theta: np.ndarray, seed: int | None, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Start an episode on θ `[D]`; `seed` is the level's, None where an episode is played again."""
        self.theta, self.seed = theta.copy(), seed if seed is not None else self.seed
        with self._telling("the function that puts levels into it"):
            returned = self.apply(self.env, self.theta_map.values(self.theta))
        if isinstance(returned, dict):
            options = {**returned, **options}
        rule = self.seed_episodes
        seed = rule(seed) if callable(rule) else seed if rule else None
        with self._telling("reset"):
            observation, info = self.env.reset(seed=seed, options=options or None)
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
            level = level_in_words(self.theta_map, self.theta, self.seed)
            raise LevelError(f"{self.env} failed in {what}: {type(error).__name__}: {error} ({level})") from error


def level_in_words(theta_map: ThetaMap, theta: np.ndarray, seed: int | None) -> str:
    """Return θ `[D]`, the values it stands for and the seed, for an error."""
    row = ", ".join(f"{x:.6g}" for x in theta[:32]) + ", …" * (len(theta) > 32)
    values = str(theta_map.values(theta))
    shown = values if len(values) < 1000 else values[:1000] + " …"
    return f"level: theta [{row}], that is {shown}; seed {seed}"


class UPOMDPWrapper(LevelSpace, _Levelled, gymnasium.utils.RecordConstructorArgs):
    """One environment with free parameters θ: `reset(options={"theta": θ})`, or the thesis's names.

    `apply(env, values)` puts `values` (name to value) into the environment; it is called before each reset, and a dict
    that it returns is the reset's options. A reset without θ draws one at random, so a stock trainer sees domain
    randomisation. `theta` and `valid` are those of `GymUPOMDP`.
    """

    theta_map: ThetaMap

    def __init__(
        self, env: gymnasium.Env, apply: Apply, theta: Theta, valid: Callable[[Any], bool] | None = None
    ) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self, apply=apply, theta=theta, valid=valid)
        _Levelled.__init__(self, env, apply, ThetaMap(theta, valid))
        self.draws, self.family = self.theta_map.draws, self.theta_map.family
        self.theta_space = Box(-1.0, 1.0, (self.theta_dim,), np.float64)
        self._streams = np.random.default_rng()

    @property
    def _stream(self) -> np.random.Generator:
        return self._streams

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode on `options["theta"]` `[D]`, or on a random θ. `info["theta"]` says which.

        Raises `ued.upomdp.ThetaError` for a wrong shape, NaN, or an entry outside [-1, 1]; ValueError for a θ that
        describes no valid level.
        """
        if seed is not None:
            self._streams = np.random.default_rng(seed)
        options = dict(options or {})
        if "theta" in options:
            theta = check_theta(options.pop("theta"), self.theta_dim, rows=1)
            if not self.valid(theta)[0]:
                raise ValueError(f"theta {theta[0].tolist()} describes no valid level")
        else:
            theta = self.sample_theta(1)
        return self._restart(theta[0], seed, options)

    def reset_random(self) -> Any:
        """Draw θ at random and reset; return the observation."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set θ `[D]` and reset."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start a new episode with the same θ; return the observation."""
        return self._restart(self.theta, None, {})[0]

    def _restart(self, theta: np.ndarray, seed: int | None, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        observation, info = self.begin(theta, seed, options)
        return observation, {**info, "theta": self.theta.copy()}


SUCCESS = ("success", "is_success")  # what environments call it in their info: Meta-World, Gymnasium-Robotics


def told_success(info: Mapping[str, Any]) -> Any:
    """Return what an environment says of its success in its info, NaN where it says nothing."""
    return next((info[name] for name in SUCCESS if name in info), math.nan)


class _Slot(_Levelled):
    """One environment of a batch: takes its own row of `options["theta"]` `[N, D]` at each reset."""

    index = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        if options is None:  # a vector environment resets on its own account
            return self.env.reset(seed=seed)[0], {}
        return self.begin(options["theta"][self.index], seed, {})[0], {}


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
            it returns is the reset's options.
        theta: number of dimensions; mapping from name to a `Range`, `LogRange`, `Integer`, `Choice` or a pair (low,
            high); a program; or a `LevelFamily`. See `parameters.ThetaMap`.
        num_envs: N.
        vectorization: "sync" steps them one after the other in this process, "async" each in a process of its own.
            Those give no state: a checkpoint of a training holds their levels, and open episodes begin anew.
        valid: says of the values of one level whether it can be played; None: all can.
        seed_episodes: what `reset(seed=)` of an environment is given: the level's seed (True), nothing (False), or what
            a function makes of that seed, which is None where a level is played again; for environments whose seed is
            something else, such as the number of a map.

    What goes wrong in an environment is raised as a `LevelError` that tells the level.
    """

    theta_map: ThetaMap

    def __init__(
        self,
        make_env: Callable[[], gymnasium.Env],
        apply: Apply,
        theta: Theta,
        num_envs: int = 1,
        vectorization: Literal["sync", "async"] = "sync",
        valid: Callable[[Any], bool] | None = None,
        seed_episodes: SeedRule = True,
    ) -> None:
        if vectorization not in ("sync", "async"):
            raise ValueError(f"vectorization must be sync or async, got {vectorization!r}")
        for name, function in {"make_env": make_env, "apply": apply}.items():
            if not callable(function):
                raise ValueError(f"{name} must be a function, got {function!r}")
        self.make_env, self.apply, self.seed_episodes = make_env, apply, seed_episodes
        self.theta_map = ThetaMap(theta, valid)
        self.family = self.theta_map.family
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

    def _vectorize(self, num_envs: int) -> Any:
        owner = os.getpid()

        def slot(index: int) -> Callable[[], gymnasium.Env]:
            def make() -> gymnasium.Env:
                if os.getpid() != owner:  # a worker is ended by SIGTERM, whatever the handler that it was forked with
                    signal.signal(signal.SIGTERM, signal.SIG_DFL)
                made = self.make_env()
                if not isinstance(made, gymnasium.Env):
                    raise ValueError(f"make_env() must return a gymnasium.Env, got {made!r}")
                self.max_episode_steps = episode_limit(made)
                env = _Slot(as_array(made), self.apply, self.theta_map, self.seed_episodes)
                env.index = index
                return env

            return make

        kind = gymnasium.vector.AsyncVectorEnv if self.vectorization == "async" else gymnasium.vector.SyncVectorEnv
        return kind([slot(index) for index in range(num_envs)], autoreset_mode=AutoresetMode.DISABLED)

    def theta_of(self, values: Any) -> np.ndarray:
        """Return the θ `[D]` of values by name, or of a family's level. Raises `ValueError` for other names."""
        return self.theta_map.theta(values)

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        seeds: list[int | None] = [None] * self.num_envs
        for level, index in zip(levels, where.tolist(), strict=True):
            seeds[index] = int(level["seed"] % 2**31)
        return self._restart(where, seeds)

    def _restart(self, where: np.ndarray, seeds: list[int | None] | None = None) -> np.ndarray:
        mask = np.zeros(self.num_envs, bool)
        mask[where] = True
        if mask.any():
            options = {"reset_mask": mask, "theta": self.levels["theta"]}
            self._observations, _ = self.vector.reset(seed=seeds, options=options)
            self._check_finite("an observation", self._observations)
        return self._observations.copy()

    def _step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        self._observations, rewards, terminated, truncated, told = self.vector.step(actions)
        self._check_finite("a reward", rewards)
        self._check_finite("an observation", self._observations)
        ended, final = terminated | truncated, self._observations
        observations = self._restart(np.flatnonzero(ended))
        info = {"final_obs": final.copy(), "_final_obs": ended, "success": self._success(told)}
        return observations, rewards, terminated, truncated, info

    def _check_finite(self, what: str, numbers: np.ndarray) -> None:
        """Raise `LevelError` where an environment gave NaN or infinity in its part of `[N, ...]`."""
        if numbers.dtype.kind != "f" or np.isfinite(numbers).all():
            return
        index = int(np.flatnonzero(~np.isfinite(numbers).reshape(self.num_envs, -1).all(1))[0])
        level = level_in_words(self.theta_map, self.levels["theta"][index], int(self.levels["seed"][index] % 2**31))
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
        return {
            "levels": self.levels.copy(),
            "observations": self._observations.copy(),
            "np_random": self.np_random.bit_generator.state,
            "envs": envs,
        }

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self._check_state(state, "envs", "observations")
        self.levels[:] = state["levels"]
        set_stream(self.np_random, state["np_random"])
        self.vector = copy.deepcopy(state["envs"])
        self._observations = state["observations"].copy()
        return self._observations.copy()

    def resized(self, num_envs: int) -> GymUPOMDP:
        """Return a second one of so many environments, with a stream of its own; nothing is reset yet."""
        return GymUPOMDP(
            self.make_env, self.apply, self._theta, num_envs, self.vectorization, self._valid, self.seed_episodes
        )

    def copy(self) -> GymUPOMDP:
        """Return a second one; environments that give no state begin the same levels anew."""
        twin = self.resized(self.num_envs)
        try:
            twin.set_state(self.get_state())
        except NotImplementedError:
            twin.np_random.bit_generator.state = self.np_random.bit_generator.state
            twin.reset_to_levels(self.levels)
        return twin

    def render(self) -> tuple[Any, ...] | None:
        """Return what each environment shows of itself, if it was made with a `render_mode`."""
        return self.vector.render()

    def close_extras(self, **kwargs: Any) -> None:
        self.vector.close(**kwargs)
