"""What plays the matches of a batch: our own simulator, or another engine behind the same few calls.

An engine begins matches and moves all of them on by a step; what it finds goes into `Batch` and `Outcome`, so that
whoever calls it need not know which one it is. Read next: `batch`; `regista.envs.grf.engine`, the other one.
"""

from __future__ import annotations

from typing import Any, Protocol

import numba
import numpy as np

from regista.envs.football.batch import Batch, BatchSettings, Outcome, begin, step_batch
from regista.envs.football.observation.observe import View
from scenic_lite.dynamics.machine.bytecode import Code


class Engine(Protocol):
    """What a batch of matches needs of whatever plays it."""

    def begin(self, batch: Batch, where: np.ndarray, luck: np.ndarray, settings: BatchSettings) -> None:
        """Put the matches `where` (indices `[k]`) at the start that `batch.starts` holds.

        `luck` `[k]` are their random streams, but where every episode of a match repeats one.
        """

    def step(self, batch: Batch, actions: np.ndarray, outcome: Outcome, seen: View, settings: BatchSettings) -> None:
        """Move all matches on with actions `[N, A]`, as `batch.step_batch`."""

    def get_state(self) -> dict[str, np.ndarray]:
        """Return what changes beside the batch."""

    def set_state(self, state: dict[str, Any], batch: Batch) -> None:
        """Take back what `get_state` gave; the batch is already that of the same moment."""

    def close(self) -> None:
        """Let go of what the matches hold."""


class Simulator:
    """Our own simulator: everything that changes stands in the batch."""

    def __init__(self, code: Code) -> None:
        self._code = code
        self._compiled: Any = None  # `step_batch` for arrays of these types

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_compiled": None}  # machine code cannot be sent to another process

    def begin(self, batch: Batch, where: np.ndarray, luck: np.ndarray, settings: BatchSettings) -> None:
        """Put the matches `where` at their start."""
        begin(batch, where, luck, settings)

    def step(self, batch: Batch, actions: np.ndarray, outcome: Outcome, seen: View, settings: BatchSettings) -> None:
        """Move all matches on.

        Numba finds out the types of all arrays at every call, which takes longer than ten matches do: they stay what
        they are, so it is asked once.
        """
        arguments = batch, actions, outcome, seen, settings, self._code
        if self._compiled is not None:
            self._compiled(*arguments)
            return
        step_batch(*arguments)
        if hasattr(step_batch, "get_overload"):
            self._compiled = step_batch.get_overload(tuple(map(numba.typeof, arguments)))

    def get_state(self) -> dict[str, np.ndarray]:
        """Return nothing."""
        return {}

    def set_state(self, state: dict[str, Any], batch: Batch) -> None:
        """Take nothing."""

    def close(self) -> None:
        """Hold nothing."""
