"""Any Gymnasium environment as a UPOMDP: the user says what θ means, and how it is put into the environment.

`UPOMDPWrapper` does it for one environment and stays a valid Gymnasium environment; `GymUPOMDP` steps N of those and
is what methods train on. Read next: `learning.rollout`.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, Protocol

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

from ued.upomdp import UPOMDP, Parameter, check_theta, sample_valid_theta, set_stream

Apply = Callable[[gymnasium.Env, dict[str, Any]], object]
Range = tuple[float, float]


class LinearParameter(NamedTuple):
    """One free parameter: θ = -1 means `low`, θ = 1 means `high`, linearly between."""

    name: str
    low: float
    high: float


class ThetaProgram(Protocol):
    """What a `scenic_lite.Program` offers here: columns, validity `[N]` of θ `[N, D]`, and values of θ `[D]`."""

    @property
    def draws(self) -> tuple[Parameter, ...]: ...
    def valid(self, theta: np.ndarray) -> np.ndarray: ...
    def describe(self, theta: np.ndarray) -> dict[str, Any]: ...


class ThetaMap:
    """What θ means: D columns, which rows are valid, and what values they stand for.

    `theta` is the number of dimensions (values are θ itself, named `theta[0]`, ...), a mapping from name to
    (low, high), or a program whose random values are the columns.
    """

    def __init__(self, theta: int | Mapping[str, Range] | ThetaProgram) -> None:
        self.program = None
        if isinstance(theta, int):
            if theta < 0:
                raise ValueError(f"theta_dim must be 0 or more, got {theta}")
            self.draws: tuple[Parameter, ...] = tuple(LinearParameter(f"theta[{i}]", -1.0, 1.0) for i in range(theta))
        elif isinstance(theta, Mapping):
            self.draws = tuple(self._parameter(name, bounds) for name, bounds in theta.items())
        else:
            self.program = theta
            self.draws = theta.draws

    @staticmethod
    def _parameter(name: str, bounds: Range) -> LinearParameter:
        low, high = map(float, bounds)
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ValueError(f"the range of {name!r} must be two finite numbers, got {bounds}")
        return LinearParameter(name, low, high)

    def valid(self, theta: np.ndarray) -> np.ndarray:
        """Return which rows of θ `[n, D]` can be played: bool `[n]`."""
        return np.ones(len(theta), bool) if self.program is None else self.program.valid(theta)

    def values(self, row: np.ndarray) -> dict[str, Any]:
        """Return one row of θ `[D]` in the environment's units."""
        if self.program is not None:
            return self.program.describe(row)
        return {d.name: d.low + (x + 1) / 2 * (d.high - d.low) for d, x in zip(self.draws, row.tolist(), strict=True)}


class UPOMDPWrapper(gymnasium.Wrapper, gymnasium.utils.RecordConstructorArgs):
    """One environment with free parameters θ: `reset(options={"theta": θ})`, or the thesis's names.

    `apply(env, values)` puts `values` (name to value) into the environment; it is called before each reset.
    A reset without θ draws one at random, so a stock trainer sees domain randomisation.
    """

    def __init__(self, env: gymnasium.Env, apply: Apply, theta: int | Mapping[str, Range] | ThetaProgram) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self, apply=apply, theta=theta)
        gymnasium.Wrapper.__init__(self, env)
        self.apply = apply
        self.theta_map = ThetaMap(theta)
        self.draws = self.theta_map.draws
        self.theta_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self.draws),), np.float64)
        self.theta = np.zeros(len(self.draws))
        self._streams = np.random.default_rng()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode on `options["theta"]` `[D]`, or on a random θ. `info["theta"]` says which.

        Raises `ued.upomdp.ThetaError` for a wrong shape, NaN, or an entry outside [-1, 1]; ValueError for a θ that the
        program rejects.
        """
        if seed is not None:
            self._streams = np.random.default_rng(seed)
        options = dict(options or {})
        if "theta" in options:
            theta = check_theta(options.pop("theta"), len(self.draws), rows=1)
            if not self.theta_map.valid(theta)[0]:
                raise ValueError(f"theta {theta[0].tolist()} describes no valid level")
            self.theta = theta[0]
        else:
            self.theta = sample_valid_theta(self._streams, 1, len(self.draws), self.theta_map.valid)[0]
        return self._restart(seed, options)

    def reset_random(self) -> Any:
        """Draw θ at random and reset; return the observation."""
        return self.reset()[0]

    def step_adversary(self, theta: Any) -> tuple[Any, dict[str, Any]]:
        """Set θ `[D]` and reset."""
        return self.reset(options={"theta": theta})

    def reset_agent(self) -> Any:
        """Start a new episode with the same θ; return the observation."""
        return self._restart(None, {})[0]

    def _restart(self, seed: int | None, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        self.apply(self.env, self.theta_map.values(self.theta))
        observation, info = self.env.reset(seed=seed, options=options or None)
        return observation, {**info, "theta": self.theta.copy()}


SUCCESS = ("success", "is_success")  # what environments call it in their info: Meta-World, Gymnasium-Robotics


def told_success(info: Mapping[str, Any]) -> Any:
    """Return what an environment says of its success in its info, NaN where it says nothing."""
    return next((info[name] for name in SUCCESS if name in info), math.nan)


class _Slot(gymnasium.Wrapper):
    """One environment of a batch: takes its own row of `options["theta"]` `[N, D]` at each reset."""

    def __init__(self, env: gymnasium.Env, index: int, apply: Apply, theta_map: ThetaMap) -> None:
        super().__init__(env)
        self.index, self.apply, self.theta_map = index, apply, theta_map

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        if options is not None:  # not so where a vector environment resets on its own account
            self.apply(self.env, self.theta_map.values(options["theta"][self.index]))
        observation, _ = self.env.reset(seed=seed)
        return observation, {}


class GymUPOMDP(UPOMDP):
    """N copies of any Gymnasium environment, each with its own level.

    Args:
        make_env: makes one environment; called `num_envs` times.
        apply: `apply(env, values)` puts one level's values into an environment, before each of its resets.
        theta: number of dimensions, mapping from name to (low, high), or a program.
        num_envs: N.
        vectorization: "sync" steps them one after the other in this process, "async" each in a process of its own.
            Those give no state: a checkpoint of a training holds their levels, and open episodes begin anew.
    """

    def __init__(
        self,
        make_env: Callable[[], gymnasium.Env],
        apply: Apply,
        theta: int | Mapping[str, Range] | ThetaProgram,
        num_envs: int = 1,
        vectorization: Literal["sync", "async"] = "sync",
    ) -> None:
        if vectorization not in ("sync", "async"):
            raise ValueError(f"vectorization must be sync or async, got {vectorization!r}")
        self.make_env, self.apply, self.theta, self.theta_map = make_env, apply, theta, ThetaMap(theta)
        self.vectorization: Literal["sync", "async"] = vectorization
        self.vector = self._vectorize(num_envs)
        space = self.vector.single_observation_space
        super().__init__(num_envs, space, self.vector.single_action_space, self.theta_map.draws)
        if space.shape is None:
            self.vector.close()
            raise ValueError(
                f"observations must be arrays, got the space {space}; "
                "wrap the environment, for example with gymnasium.wrappers.FlattenObservation"
            )
        self._observations: Any = None  # until the first reset

    def _vectorize(self, num_envs: int) -> Any:
        def slot(index: int) -> Callable[[], gymnasium.Env]:
            return lambda: _Slot(self.make_env(), index, self.apply, self.theta_map)

        kind = gymnasium.vector.AsyncVectorEnv if self.vectorization == "async" else gymnasium.vector.SyncVectorEnv
        return kind([slot(index) for index in range(num_envs)], autoreset_mode=AutoresetMode.DISABLED)

    def valid(self, theta: Any) -> np.ndarray:
        return self.theta_map.valid(check_theta(theta, self.theta_dim))

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        return [self.theta_map.values(row) for row in check_theta(theta, self.theta_dim)]

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
        return self._observations.copy()

    def _step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        self._observations, rewards, terminated, truncated, told = self.vector.step(actions)
        ended, final = terminated | truncated, self._observations
        observations = self._restart(np.flatnonzero(ended))
        info = {"final_obs": final.copy(), "_final_obs": ended, "success": self._success(told)}
        return observations, rewards, terminated, truncated, info

    def _success(self, told: Mapping[str, Any]) -> np.ndarray:
        """Return `info["success"]` `[N]` from the infos of the environments, some of which may say nothing."""
        success = np.full(self.num_envs, np.nan)
        for name in reversed(SUCCESS):
            if name in told:
                says = told.get(f"_{name}", np.ones(self.num_envs, bool))
                success[says] = np.asarray(told[name], float)[says]
        return success

    def get_state(self) -> dict[str, Any]:
        """Return everything that changes; the environments themselves are Python objects, copied deeply."""
        if self.vectorization == "async":
            raise NotImplementedError('environments in processes of their own give no state; use vectorization="sync"')
        return {
            "levels": self.levels.copy(),
            "observations": self._observations.copy(),
            "np_random": self.np_random.bit_generator.state,
            "envs": copy.deepcopy(self.vector),
        }

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self.levels[:] = state["levels"]
        set_stream(self.np_random, state["np_random"])
        self.vector = copy.deepcopy(state["envs"])
        self._observations = state["observations"].copy()
        return self._observations.copy()

    def copy(self) -> GymUPOMDP:
        """Return a second one; one in other processes begins the same levels anew."""
        twin = GymUPOMDP(self.make_env, self.apply, self.theta, self.num_envs, self.vectorization)
        if self.vectorization == "sync":
            twin.set_state(self.get_state())
        else:
            twin.np_random.bit_generator.state = self.np_random.bit_generator.state
            twin.reset_to_levels(self.levels)
        return twin

    def close_extras(self, **kwargs: Any) -> None:
        self.vector.close(**kwargs)
