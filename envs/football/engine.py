"""The interface of engines: our own simulator, or GRF, behind the same few methods.

An engine begins and steps all matches, and writes results into `Batch` and `Outcome`, so its callers do not depend on
the engine. Read next: `batch`; `regista.envs.grf.engine`, the other engine.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from regista.envs.football.batch import Batch, BatchSettings, Outcome, Pool, begin, step_batch
from regista.envs.football.observation.observe import View
from regista.envs.football.rollout import Matches, play_matches
from regista.kernels.calls import overload_of
from scenic_lite.dynamics.machine.bytecode import Code
from ued.core.compiled import CompiledRollout


class Engine(Protocol):
    """The interface of an engine for a batch of matches."""

    def begin(self, batch: Batch, where: np.ndarray, luck: np.ndarray, settings: BatchSettings) -> None:
        """Reset the matches `where` (indices `[k]`) to the initial states in `batch.starts`.

        `luck` `[k]` are their random streams; deterministic matches ignore them.
        """

    def step(self, batch: Batch, actions: np.ndarray, outcome: Outcome, seen: View, settings: BatchSettings) -> None:
        """Step all matches with actions `[N, A]`, as `batch.step_batch`."""

    def get_state(self) -> dict[str, np.ndarray]:
        """Return the part of the state that is not in the batch."""

    def check_state(self, state: dict[str, Any], count: int) -> None:
        """Raise `limits.StateError` unless the state fits this engine and `count` matches."""

    def set_state(self, state: dict[str, Any], batch: Batch) -> None:
        """Restore the state from `get_state` after `check_state` has accepted it and the batch has been restored."""

    def close(self) -> None:
        """Free the engine's resources."""


class Simulator:
    """Our own simulator, whose entire state is in the batch."""

    def __init__(self, code: Code) -> None:
        self._code = code
        self._compiled: Any = None  # `step_batch`, compiled for arrays of these types
        self._rollouts: Any = None  # `play_matches`, likewise

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_compiled": None, "_rollouts": None}  # machine code cannot be sent to another process

    def begin(self, batch: Batch, where: np.ndarray, luck: np.ndarray, settings: BatchSettings) -> None:
        """Reset the matches `where` to their initial states."""
        begin(batch, where, luck, settings)

    def step(self, batch: Batch, actions: np.ndarray, outcome: Outcome, seen: View, settings: BatchSettings) -> None:
        """Step all matches.

        Numba infers the types of all arrays at every call, which takes longer than stepping ten matches. The types
        never change, so we infer them once.
        """
        arguments = batch, actions, outcome, seen, settings, self._code
        if self._compiled is None:
            self._compiled = overload_of(step_batch, arguments)
        self._compiled(*arguments)

    def play(
        self, rollout: CompiledRollout, batch: Batch, pool: Pool, outcome: Outcome, seen: View, settings: BatchSettings
    ) -> None:
        """Play steps of a rollout."""
        arguments = rollout, Matches(batch, pool, settings, self._code), outcome, seen
        if self._rollouts is None:
            self._rollouts = overload_of(play_matches, arguments)
        self._rollouts(*arguments)

    def get_state(self) -> dict[str, np.ndarray]:
        """Return an empty state."""
        return {}

    def check_state(self, state: dict[str, Any], count: int) -> None:
        """Do nothing: the state is in the batch."""

    def set_state(self, state: dict[str, Any], batch: Batch) -> None:
        """Do nothing: the state is in the batch."""

    def close(self) -> None:
        """Do nothing: there are no resources."""
