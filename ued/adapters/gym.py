"""Any Gymnasium environment as a UPOMDP: you specify the parameters θ and a function that applies them.

`UPOMDPWrapper` wraps one environment and is a valid Gymnasium environment; `GymUPOMDP` steps N environments, on which
methods train. Read next: `learning.rollout`.
"""

from __future__ import annotations

import copy
import math
import os
import signal
from collections.abc import Callable
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode

from ued.adapters.level_env import (
    Apply,
    LevelEnv,
    Luck,
    SeedRule,
    Start,
    check_apply,
    check_luck,
    check_numbers,
    level_in_words,
    name_of,
)
from ued.adapters.observations import as_array
from ued.adapters.success import SUCCESS, SuccessReports
from ued.core.episode_limit import episode_limit
from ued.core.level_space import LevelSpace, check_theta, level_dtype, luck_seed
from ued.core.parameters import Theta, ThetaMap
from ued.core.processes import START_METHOD, end_with_parent
from ued.core.upomdp import UPOMDP, check_count


class UPOMDPWrapper(LevelSpace, LevelEnv, gymnasium.utils.RecordConstructorArgs):
    """One environment with free parameters θ: `reset(options={"theta": θ})`, or the thesis's names.

    `apply(env, values)` applies `values` (name to value) to the environment before each reset; a dict that it returns
    becomes the reset's options. A reset without θ samples a random level, so a stock trainer trains by domain
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
        LevelEnv.__init__(self, env, apply, ThetaMap(theta, valid), seed_episodes, luck)
        check_apply(apply, self.theta_map)
        self.parameters, self.level_family, self.seeds = (
            self.theta_map.draws,
            self.theta_map.level_family,
            self.theta_map.seeds,
        )
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

        `seed` seeds the stream of levels, and is the seed of this level unless a level is given. A level, a record of
        `level_dtype(D)`, has its own seed; `options["visit"]` is the number of this visit, which determines its luck.
        `info["theta"]` and `info["level_seed"]` identify the level.

        Raises:
            ued.core.upomdp.ThetaError: a wrong shape, NaN, or an entry outside [-1, 1].
            ValueError: a θ that is not a valid level.
        """
        if seed is not None:
            self._streams = np.random.default_rng(seed)
        options = dict(options or {})
        self.level = self._level_of(options.pop("level", None), options.pop("theta", None), seed)
        self.visit, self.episode = int(options.pop("visit", 0)), 0
        if not 0 <= self.visit < 2**63:
            raise ValueError(f"visit must be an integer, 0 or larger, got {self.visit}")
        return self._play(options)

    def _level_of(self, level: Any, theta: Any, seed: int | None) -> np.ndarray:
        """Return the level `[1]` of a reset; see `reset`."""
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
            raise ValueError(f"theta {level['theta'][0].tolist()} is not a valid level")
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
        """Start an episode of the current level."""
        (seed,), (theta,) = self.level["seed"].tolist(), self.level["theta"]
        luck = luck_seed(seed, self.visit, self.episode + (0 if self.seed_is_luck else 1))
        observation, info = self.begin(Start(theta.copy(), seed, luck), options)
        return observation, {**info, "theta": theta.copy(), "level_seed": seed}


ENDS = ("slot_terminated", "slot_truncated")  # in the info of a `_Slot`


class _Slot(LevelEnv):
    """One environment of a batch; each reset uses its own row of the batch's starts.

    After the end of an episode it does not step until the next reset. Meanwhile, Gymnasium's vector environment would
    refuse to step the others, so the end is reported only in the info.
    """

    index = 0
    _last: Any = None  # observation, of an episode that has ended

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self._last = None
        if options is None:  # a reset by the vector environment itself
            return self.env.reset(seed=seed)[0], {}
        theta, seeds, luck, begins = options["starts"]  # [N, D], [N], [N], [N]
        if not begins[self.index]:  # the first reset of a batch resets all
            self._last = np.zeros(self.observation_space.shape, self.observation_space.dtype)
            return self._last, {}
        start = Start(theta[self.index].copy(), int(seeds[self.index]), int(luck[self.index]))
        return self.begin(start, {})[0], {}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        if self._last is not None:
            return self._last, 0.0, False, False, {}
        observation, reward, terminated, truncated, info = super().step(action)
        # A batch cannot join arrays of varying length, and would store an unknown success (None) as False
        info = {name: math.nan if info[name] is None else float(info[name]) for name in SUCCESS if name in info}
        if terminated or truncated:
            self._last = observation
            info |= zip(ENDS, (bool(terminated), bool(truncated)), strict=True)
        return observation, reward, False, False, info


class GymUPOMDP(UPOMDP):
    """N copies of any Gymnasium environment, each with its own level.

    Observations that are neither vectors nor images (`Dict`, `Discrete`, `MultiBinary` ...) are flattened into vectors,
    in which convolutions find the images of a `Dict` or `Tuple`.

    Args:
        make_env: makes one environment; called `num_envs` times.
        apply: `apply(env, values)` applies one level's values to an environment before each reset; a dict that it
            returns becomes the reset's options. None, for `Seeds`: levels have no values to apply.
        theta: number of dimensions; mapping from name to a `Range`, `LogRange`, `Integer`, `Choice` or a pair (low,
            high); a program; a `LevelFamily`; or `Seeds`. See `parameters.ThetaMap`.
        num_envs: N.
        vectorization: "sync" steps them one after the other in this process, "async" each in its own process. Async
            environments have no state: a checkpoint holds their levels, and a resumed run restarts open episodes.
        valid: returns whether a level with these values is valid; None: all levels are valid.
        seed_episodes: the argument of an environment's `reset(seed=)`. True: the seed. False: none, so
            levels are θ alone, and random numbers are not reproducible. A function: its value for the seed, for
            environments where the seed has another meaning, such as the number of a map.
        luck: the random part of an episode, new in each episode of a level. False: none, so all episodes of a level
            start alike. True: all draws of `reset(seed=)`, for environments whose reset adds a little noise to θ. A
            text: the draws from a second seed, which the reset's options hold under this key. A function
            `luck(env, seed)`: it is called after each reset, and its result, if any, is the first observation.

    Raises:
        LevelError: an exception in an environment; it reports the level.
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
        check_apply(apply, self.theta_map)
        self.level_family, self.seeds = self.theta_map.level_family, self.theta_map.seeds
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
        self._observations: Any = None  # None until the first reset
        self._going_on = np.zeros(num_envs, bool)
        self._reports = SuccessReports(self._level)

    def _vectorize(self, num_envs: int) -> Any:
        owner = os.getpid()

        def slot(index: int) -> Callable[[], gymnasium.Env]:
            def make() -> gymnasium.Env:
                if os.getpid() != owner:  # SIGTERM ends a worker, even if it inherited a handler
                    signal.signal(signal.SIGTERM, signal.SIG_DFL)
                    end_with_parent(signal.SIGKILL)  # even if a step hangs
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
        """Return the θ `[D]` of values by name, or of a family's level.

        Raises:
            ValueError: for other names.
        """
        return self.theta_map.theta(values)

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        begins, luck = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, np.uint64)
        begins[where], luck[where] = True, self.luck_seeds(where)
        if begins.any():
            starts = self.levels["theta"], self.levels["seed"], luck, begins
            mask = begins if self._observations is not None else np.ones(self.num_envs, bool)
            self._observations, _ = self.vector.reset(options={"reset_mask": mask, "starts": starts})
            check_numbers("an observation", self._observations, self._level)
        return self._observations.copy()

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        self._observations, rewards, _, _, infos = self.vector.step(actions)
        terminated, truncated = (np.array(infos.get(end, self._going_on), bool) for end in ENDS)
        check_numbers("a reward", rewards, self._level)
        check_numbers("an observation", self._observations, self._level)
        info = {"success": self._reports.read(infos, terminated | truncated)}
        return self._observations.copy(), rewards, terminated, truncated, info

    def _level(self, env: int) -> str:
        return level_in_words(self.theta_map, self.levels["theta"][env], int(self.levels["seed"][env]))

    supports_state = False  # Python objects

    def get_state(self) -> dict[str, Any]:
        """Return the whole state; the environments are Python objects, copied deeply."""
        if self.vectorization == "async":
            raise NotImplementedError('environments in other processes support no state; use vectorization="sync"')
        for env in self.vector.envs:
            if isinstance(
                env.unwrapped, gymnasium.utils.EzPickle
            ):  # Box2D, MuJoCo: the copy is a new environment without the level
                raise NotImplementedError(f"{name_of(env)} cannot be copied: it is a gymnasium.utils.EzPickle")
        try:
            envs = copy.deepcopy(self.vector)
        except Exception as error:  # environments may hold windows, clocks, connections
            raise NotImplementedError(f"these environments cannot be copied: {error}") from error
        return {**self.level_state(), "observations": self._observations.copy(), "envs": envs}

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self.set_level_state(state, "envs", "observations")
        self.vector = copy.deepcopy(state["envs"])
        self._observations = state["observations"].copy()
        return self._observations.copy()

    def resized(self, num_envs: int) -> GymUPOMDP:
        """Return a UPOMDP with `num_envs` environments of the same kind, not yet reset, with its own stream."""
        rules = self._valid, self.seed_episodes, self.luck
        return GymUPOMDP(self.make_env, self.apply, self._theta, num_envs, self.vectorization, *rules)

    def copy(self) -> GymUPOMDP:
        """Return a copy; environments without a state restart their levels."""
        twin = self.resized(self.num_envs)
        if self._observations is None:  # never reset
            return twin
        try:
            twin.set_state(self.get_state())
        except NotImplementedError:
            twin.np_random.bit_generator.state = self.np_random.bit_generator.state
            twin.reset_to_levels(self.levels, None, self.visits, self.episodes)
        return twin

    def render(self) -> tuple[Any, ...] | None:
        """Return the rendered frame of each environment, if it was made with a `render_mode`."""
        return self.vector.render()

    def close_extras(self, **kwargs: Any) -> None:
        self.vector.close(**kwargs)
