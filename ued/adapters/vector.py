"""Any Gymnasium vector environment as a UPOMDP.

    upomdp = VectorUPOMDP(lambda n: gymnasium.make_vec("CartPole-v1", n), put, {"length": (0.2, 2.0)}, num_envs=64)

Levels can be chosen in every `AutoresetMode`. At the end of an episode, `options["reset_mask"]` resets the environment
on its next level before any other step. So a pending automatic reset (NEXT_STEP) takes no step, and the episode that
an automatic reset has started (SAME_STEP) is not played. Read next: `adapters.gym`, for single environments.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, VectorEnv

from ued.adapters.level_env import check_apply, check_numbers, level_in_words
from ued.adapters.success import SuccessReports
from ued.core.level_space import LevelError
from ued.core.own_code import FAILURES, line_in
from ued.core.parameters import Theta, ThetaMap
from ued.core.upomdp import UPOMDP, check_count

# Applies the values of k levels to the environments `where`, indices `[k]`. If it returns a dict, this becomes options
# of the reset that follows.
ApplyAll = Callable[[VectorEnv, np.ndarray, Sequence[Any]], object]
EACH, ARRAYS = "each", "arrays"  # ways to pass values without a function, see `VectorUPOMDP`


class VectorUPOMDP(UPOMDP):
    """N environments of a vector environment, each with its own level.

    Args:
        make_vector: `make_vector(num_envs)` makes a vector environment of `num_envs` environments.
        apply: `apply(vector, where, values)` applies levels before each reset. Its arguments are the indices `[k]` of
            the environments to be reset and the values of their levels, k dicts; a dict that it returns becomes the
            options of the reset. "each": every environment is reset alone, with its values as its options, for
            environments of `SyncVectorEnv` and `AsyncVectorEnv`. "arrays": one reset, whose options hold an array
            `[N]` for each parameter, for batches that are simulated together. None: levels have no values to apply.
        theta: as for `GymUPOMDP`.
        num_envs: N.
        valid: returns whether a level with these values is valid; None: all levels are valid.
        seed_episodes: whether `reset(seed=)` receives a seed for each environment; otherwise levels are θ alone.
        luck: whether the draws of `reset(seed=)` are luck, new in each episode, instead of a part of the level.

    Raises:
        ValueError: a vector environment of another size, with observations that are neither vectors nor images, or
            without partial resets.
    """

    theta_map: ThetaMap
    supports_state = False

    def __init__(
        self,
        make_vector: Callable[[int], VectorEnv],
        apply: ApplyAll | str | None,
        theta: Theta,
        num_envs: int = 1,
        valid: Callable[[Any], bool] | None = None,
        seed_episodes: bool = True,
        luck: bool = False,
    ) -> None:
        if not callable(apply) and apply not in (EACH, ARRAYS, None):
            raise ValueError(f"apply must be a function, 'each', 'arrays' or None, got {apply!r}")
        if luck and not seed_episodes:
            raise ValueError("luck=True is what reset(seed=) draws, which seed_episodes=False does not seed")
        self.make_vector, self.apply, self.seed_episodes, self.luck = make_vector, apply, seed_episodes, luck
        self.theta_map = ThetaMap(theta, valid)
        check_apply(apply, self.theta_map)
        self.level_family, self.seeds = self.theta_map.level_family, self.theta_map.seeds
        self.seed_is_luck = luck or not seed_episodes
        self._theta, self._valid = theta, valid
        self.vector = make_vector(check_count(num_envs))
        self.mode = _mode_of(self.vector, num_envs)
        super().__init__(
            num_envs, self.vector.single_observation_space, self.vector.single_action_space, self.theta_map.draws
        )
        self.render_mode = self.vector.render_mode
        spec = getattr(self.vector, "spec", None)
        self.max_episode_steps = getattr(spec, "max_episode_steps", None)
        self._observations: Any = None  # None until the first reset; includes the last ones of episodes that ended
        self._its_own: Any = None  # observations of the vector environment, which may have started other episodes
        self._over = np.zeros(num_envs, bool)  # episodes that ended and were not restarted
        self._reports = SuccessReports(self._level)

    def theta_of(self, values: Any) -> np.ndarray:
        """Return the θ `[D]` of values by name, or of a family's level.

        Raises:
            ValueError: for other names.
        """
        return self.theta_map.theta(values)

    # ------------------------------------------------------------ the environments

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        begins = where if self._observations is not None else np.arange(self.num_envs)  # the first reset resets all
        if len(begins):
            self._begin(begins)
            check_numbers("an observation", self._observations, self._level)
        return self._observations.copy()

    def _begin(self, where: np.ndarray) -> None:
        """Start episodes in the environments `where` `[k]` on their levels."""
        luck = np.zeros(self.num_envs, np.uint64)
        luck[where] = self.luck_seeds(where)
        seeds = luck if self.luck else self.levels["seed"]
        values = [self.theta_map.values(theta.copy()) for theta in self.levels["theta"][where]]
        try:
            self._reset(where, values, seeds)
        except LevelError:
            raise
        except FAILURES as error:
            raise self._failed(f"a reset{line_in(self.apply, error)}", where, error) from error
        self._over[where] = False

    def _reset(self, where: np.ndarray, values: Sequence[Any], seeds: np.ndarray) -> None:
        """Reset the environments `where` `[k]` to levels with these values `[k]` and seeds `[N]`."""
        if self.apply == EACH:
            if self._its_own is None:  # a batch needs all observations before a partial reset
                self._its_own = np.array(self.vector.reset(options=dict(values[0]))[0])
                self._observations = self._its_own.copy()
            for env, own in zip(where.tolist(), values, strict=True):
                self._reset_masked(np.array([env]), dict(own), seeds)
            return
        if callable(self.apply):
            options = self.apply(self.vector, where, values)
        elif self.apply == ARRAYS:
            options = {name: self._array(name, where, values) for name in values[0]}
        else:
            options = None
        self._reset_masked(where, dict(options) if isinstance(options, Mapping) else {}, seeds)

    def _array(self, name: str, where: np.ndarray, values: Sequence[Any]) -> np.ndarray:
        """Return the values of a parameter `[N]`; environments that are not reset get the first value."""
        column = [values[0][name]] * self.num_envs
        for env, own in zip(where.tolist(), values, strict=True):
            column[env] = own[name]
        return np.asarray(column)

    def _reset_masked(self, where: np.ndarray, options: dict[str, Any], seeds: np.ndarray) -> None:
        mask = np.zeros(self.num_envs, bool)
        mask[where] = True
        given: Any = [
            int(seed) if chosen and self.seed_episodes else None for seed, chosen in zip(seeds, mask, strict=True)
        ]
        seen = np.array(self.vector.reset(seed=given, options={**options, "reset_mask": mask})[0])
        self._check_shape("observations", seen.shape, self.observation_space.shape)
        if self._its_own is None:
            self._observations = seen.copy()
        else:
            changed = (seen != self._its_own).reshape(self.num_envs, -1).any(1) & ~mask
            if changed.any():
                other = int(np.flatnonzero(changed)[0])
                raise ValueError(
                    f"environment {other} was reset, too: reset(options={{'reset_mask': mask}}) must leave "
                    "environments outside the mask as they are"
                )
            self._observations[mask] = seen[mask]
        self._its_own = seen

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        if self.mode == AutoresetMode.DISABLED and self._over.any():  # a step after the end is invalid
            self._begin(np.flatnonzero(self._over))
        try:
            seen, rewards, terminated, truncated, infos = self.vector.step(actions)
        except FAILURES as error:
            raise self._failed("a step", np.arange(self.num_envs), error) from error
        terminated, truncated = np.array(terminated, bool), np.array(truncated, bool)
        for name, column in {"rewards": rewards, "terminated": terminated, "truncated": truncated}.items():
            self._check_shape(name, np.shape(column), (self.num_envs,))
        self._check_shape("observations", np.shape(seen), self.observation_space.shape)
        ended, observations = terminated | truncated, np.array(seen)
        self._over = ended
        self._its_own = observations.copy()
        if not isinstance(infos, Mapping):
            raise LevelError(f"{self.vector}: info must be a dict of arrays, got {infos!r}; leave out DictInfoToList")
        # An environment that does not state its mode resets in the same step if it has last observations
        if ended.any() and (self.mode == AutoresetMode.SAME_STEP or "final_obs" in infos):
            observations[ended] = self._final_observations(infos, ended)
            infos = infos.get("final_info", infos)
        self._observations = observations
        if (rows := np.asarray(rewards)).dtype == object and None in rows.tolist():  # would become NaN
            index = rows.tolist().index(None)
            raise LevelError(f"environment {index} returned None as its reward, not a number ({self._level(index)})")
        check_numbers("a reward", rows.astype(np.float64), self._level)
        check_numbers("an observation", observations, self._level)
        info = {"success": self._reports.read(infos, ended)}
        return observations.copy(), np.array(rewards, np.float64), terminated, truncated, info

    def _final_observations(self, infos: Mapping[str, Any], ended: np.ndarray) -> np.ndarray:
        """Return the last observations of the episodes that ended, `[k, ...]`, which a reset has replaced."""
        last = infos.get("final_obs")
        if last is None:
            raise LevelError(
                f"{self.vector} resets in the same step, so its info must have 'final_obs', got {[*infos]}"
            )
        return np.stack([np.asarray(last[env]) for env in np.flatnonzero(ended)])

    def _check_shape(self, what: str, shape: tuple[int, ...], expected: tuple[int, ...] | None) -> None:
        """Raise `LevelError` if a result of a step or a reset has another shape."""
        if shape != expected:
            raise LevelError(f"{self.vector}: {what} must have shape {expected}, got {shape}")

    def _failed(self, what: str, where: np.ndarray, error: BaseException) -> LevelError:
        several = f", the first of {len(where)}" if len(where) > 1 else ""
        return LevelError(
            f"{self.vector} failed in {what}: {type(error).__name__}: {error} "
            f"(environment {where[0]}{several}; {self._level(int(where[0]))})"
        )

    def _level(self, env: int) -> str:
        return level_in_words(self.theta_map, self.levels["theta"][env], int(self.levels["seed"][env]))

    # ------------------------------------------------------------ copies

    def resized(self, num_envs: int) -> VectorUPOMDP:
        """Return a UPOMDP with `num_envs` environments of the same kind, not yet reset, with its own stream."""
        rules = self._valid, self.seed_episodes, self.luck
        return VectorUPOMDP(self.make_vector, self.apply, self._theta, num_envs, *rules)

    def copy(self) -> VectorUPOMDP:
        """Return a copy that restarts the episodes of its levels, since vector environments have no common state."""
        twin = self.resized(self.num_envs)
        twin.np_random.bit_generator.state = self.np_random.bit_generator.state
        twin.reset_to_levels(self.levels, None, self.visits, self.episodes)
        return twin

    def render(self) -> tuple[Any, ...] | None:
        """Return the rendered frame of each environment, if it was made with a `render_mode`."""
        return self.vector.render()

    def close_extras(self, **kwargs: Any) -> None:
        self.vector.close(**kwargs)


def _mode_of(vector: Any, num_envs: int) -> AutoresetMode:
    """Return the autoreset mode of a vector environment. Raises `ValueError` if the environment cannot play levels."""
    if not isinstance(vector, VectorEnv):
        raise ValueError(f"make_vector({num_envs}) must return a gymnasium.vector.VectorEnv, got {vector!r}")
    if vector.num_envs != num_envs:
        raise ValueError(f"make_vector({num_envs}) must make {num_envs} environments, got {vector.num_envs}")
    space = vector.single_observation_space
    if not isinstance(space, Box) or len(space.shape) not in (1, 3):
        raise ValueError(
            f"observations must be vectors or images of three axes, got {space}; flatten them by a wrapper of each "
            "environment, gymnasium.wrappers.FlattenObservation, or of the batch, "
            "gymnasium.wrappers.vector.FlattenObservation"
        )
    mode = vector.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP)  # Gymnasium's default
    base = vector.unwrapped
    if isinstance(base, AsyncVectorEnv) and mode == AutoresetMode.NEXT_STEP and not base.shared_memory:
        raise ValueError(
            "an AsyncVectorEnv with shared_memory=False resets once more after a partial reset; give it "
            "shared_memory=True or autoreset_mode=AutoresetMode.DISABLED"
        )
    return AutoresetMode(mode)
