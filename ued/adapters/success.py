"""The success of episodes as environments report it in their infos. Read next: `adapters.gym`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ued.core.level_space import LevelError

SUCCESS = ("success", "is_success")  # names in the info of Meta-World and Gymnasium-Robotics; the first has priority


class SuccessReports:
    """Reads the success of episodes that ended. All episodes report it, or none.

    An episode without a report succeeds if its return is above 0. If only successful episodes had a report, this rule
    would decide about the failures, so mixed reports are an error.

    Args:
        level: `level(env)` describes the level of an environment, for errors.
    """

    def __init__(self, level: Callable[[int], str]) -> None:
        self.level = level
        self.expected: bool | None = None  # whether episodes report their success; None: none has ended

    def read(self, infos: Mapping[str, Any], ended: np.ndarray) -> np.ndarray:
        """Return the success `[N]` of the episodes that ended in a step, bool `[N]`: 1, 0, or NaN if not known.

        `infos` holds arrays `[N]`, with masks as in Gymnasium's vector environments, or scalars if N is 1.

        Raises:
            LevelError: another value or shape, or reports of some episodes only.
        """
        success, reported = np.full(len(ended), np.nan), np.zeros(len(ended), bool)
        for name in reversed(SUCCESS):
            if name in infos:
                mine = ended & np.asarray(infos.get(f"_{name}", True))
                success[mine], reported[mine] = self._numbers(name, infos[name], len(ended))[mine], True
        for env in np.flatnonzero(ended).tolist():
            self._check(env, success[env], bool(reported[env]))
        return success

    def _check(self, env: int, success: float, reported: bool) -> None:
        """Raise `LevelError` unless an episode reports its success as earlier ones did."""
        rule = "True or False, also when it is truncated"
        if self.expected is None:
            self.expected = reported
        if reported != self.expected:
            raise LevelError(
                f"environment {env}: the episode that ended has {'a' if reported else 'no'} report of success in its "
                f"info, unlike earlier ones; report {SUCCESS[0]!r} at the end of every episode: {rule} "
                f"({self.level(env)})"
            )
        if success not in (0, 1) and not np.isnan(success):
            raise LevelError(
                f"environment {env} reported the success {success:g}; it must be True or False ({self.level(env)})"
            )

    def _numbers(self, name: str, values: Any, num_envs: int) -> np.ndarray:
        """Return the values of an info `[N]`."""
        try:
            numbers = np.atleast_1d(np.asarray(values, float))  # None becomes NaN
        except (TypeError, ValueError) as error:
            raise LevelError(f"info[{name!r}] must be numbers, got {values!r}") from error
        if numbers.shape != (num_envs,):
            raise LevelError(f"info[{name!r}] must have shape ({num_envs},), got {numbers.shape}")
        return numbers
