"""One environment that plays levels: each reset applies the values, the seed and the luck of a level.

Read next: `adapters.gym`, which makes UPOMDPs of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from ued.adapters.observations import in_form
from ued.adapters.success import SUCCESS
from ued.core.level_space import LevelError
from ued.core.own_code import FAILURES, line_in
from ued.core.parameters import ThetaMap

# Applies a level's values to an environment. If it returns a dict, this becomes the options of `reset`.
Apply = Callable[[gymnasium.Env, Any], object]
# The argument of an environment's `reset(seed=)`: the seed, nothing, or a function of the seed.
SeedRule = bool | Callable[[int], int | None]
# The luck of an episode: none, all draws of `reset(seed=)`, the draws from a seed under this key of the reset's
# options, or the effect of a function of the reset environment and a seed.
Luck = bool | str | Callable[[gymnasium.Env, int], object]
FLOAT32 = float(np.finfo(np.float32).max)  # the largest number of the students' precision


class Start(NamedTuple):
    """The start of an episode: θ `[D]` and seed of its level, and the seed of its luck."""

    theta: np.ndarray
    seed: int
    luck: int


class LevelEnv(gymnasium.Wrapper):
    """One environment that plays levels; its errors report the level."""

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
        self._shape = env.observation_space.shape  # cached, since a chain of wrappers is slow

    def begin(self, start: Start, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Start an episode; `options` are the user's options for `reset`."""
        self.start = start
        try:
            values = self.theta_map.values(start.theta)
            returned = None if self.apply is None else self.apply(self.env, values)
        except FAILURES as error:
            raise self._failed("the function that applies levels", error, self.apply) from error
        if isinstance(returned, dict):
            options = {**returned, **options}
        if isinstance(self.luck, str):
            options = {**options, self.luck: start.luck}
        rule, seed = self.seed_episodes, start.luck if self.luck is True else start.seed
        given = rule(seed) if callable(rule) else seed if rule else None
        try:
            observation, info = self.env.reset(seed=given, options=options or None)
            if callable(self.luck):
                seen = self.luck(self.env, start.luck)
                observation = observation if seen is None else in_form(self.env, seen)
            return self._checked(observation), info
        except FAILURES as error:
            raise self._failed("reset", error) from error

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        try:
            observation, reward, terminated, truncated, info = self.env.step(action)
            if reward is None:
                raise ValueError("the reward must be a number, got None")
            _check_number("the reward", reward)
            for name in SUCCESS:
                if name in info:
                    _check_number(f"info[{name!r}]", info[name])
            return self._checked(observation), reward, terminated, truncated, info
        except FAILURES as error:
            raise self._failed("step", error) from error

    def _checked(self, observation: Any) -> Any:
        """Return an observation. Raises `ValueError` unless it has the shape of the space."""
        shape = observation.shape if isinstance(observation, np.ndarray) else np.shape(observation)
        if shape != self._shape and self._shape is not None:
            raise ValueError(f"the observation has shape {shape}, observation_space has {self._shape}")
        return observation

    def _failed(self, what: str, error: BaseException, function: Any = None) -> LevelError:
        """Return an error as a `LevelError` with the line in the file of the user's `function`.

        If `function` is None, it is the environment's method named `what`.
        """
        if isinstance(error, LevelError):
            raise error
        level = level_in_words(self.theta_map, self.start.theta, self.start.seed)
        function = function or getattr(self.env.unwrapped, what, None)
        failed = f"{name_of(self.env)} failed in {what}{line_in(function, error)}"
        return LevelError(f"{failed}: {type(error).__name__}: {error} ({level})")


def name_of(env: gymnasium.Env) -> str:
    """Return the id of a registered environment, or the name of its class."""
    inner = env.unwrapped
    return inner.spec.id if inner.spec is not None else type(inner).__name__


def level_in_words(theta_map: ThetaMap, theta: np.ndarray, seed: int) -> str:
    """Return θ `[D]`, its values and the seed as a text for an error."""
    row = ", ".join(f"{x:.6g}" for x in theta[:32]) + ", …" * (len(theta) > 32)
    values = str(theta_map.values(theta))
    shown = values if len(values) < 1000 else values[:1000] + " …"
    return f"level: theta [{row}], that is {shown}; seed {seed}"


def check_numbers(what: str, numbers: np.ndarray, level: Callable[[int], str]) -> None:
    """Raise `LevelError` if an environment returned NaN, infinity or numbers beyond float32 in its part of `[N, ...]`.

    Students compute in float32, where larger numbers would be infinite. `level(env)` describes a level.
    """
    if numbers.dtype.kind != "f":
        return
    fits = np.abs(numbers) <= FLOAT32 if numbers.dtype.itemsize > 4 else np.isfinite(numbers)
    if fits.all():
        return
    env = int(np.flatnonzero(~fits.reshape(len(numbers), -1).all(1))[0])
    large = np.isfinite(numbers[env]).all()
    why = "too large for float32 (scale it in the environment)" if large else "not finite"
    raise LevelError(f"environment {env} returned {what} that is {why}: {numbers[env]} ({level(env)})")


def check_luck(luck: Luck, seed_episodes: SeedRule) -> None:
    """Raise `ValueError` if `luck` is invalid or contradicts `seed_episodes`."""
    if not (isinstance(luck, bool | str) or callable(luck)) or luck == "":
        raise ValueError(f"luck must be True, False, a key of reset's options or a function, got {luck!r}")
    if luck is True and seed_episodes is False:
        raise ValueError("luck=True is what reset(seed=) draws, which seed_episodes=False does not seed")


def check_apply(apply: Any, theta_map: ThetaMap) -> None:
    """Raise `ValueError` if θ has values, but no function applies them."""
    if apply is None and theta_map.draws and theta_map.seeds is None:
        names = ", ".join(draw.name for draw in theta_map.draws[:3]) + ", …" * (len(theta_map.draws) > 3)
        raise ValueError(f"apply must be a function that applies {names} to an environment; None is for ued.Seeds")


def _check_number(what: str, value: Any) -> None:
    """Raise `ValueError` unless a value of an environment is a single number or bool; None means unknown."""
    if isinstance(value, float | int | np.number | np.bool_ | None):
        return
    if np.ndim(value) or np.asarray(value).dtype.kind not in "biuf":
        raise ValueError(f"{what} must be a number, got {value!r}")
