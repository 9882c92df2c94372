"""Warn of observations whose differences disappear in float32, in which students compute.

Seconds since 1970 are an example: float32 rounds them to minutes. Read next: `learning.worker`, which checks the first
rollout, and `adapters.level_env`, which rejects numbers that are too large for float32.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

NOISE = 1e-12  # share of an entry below which its spread is rounding in float64
LOST = 0.01  # share of an entry's standard deviation that rounding may change


class Rounding:
    """Compares the observations at the start and the end of the first rollout with their float32 values."""

    def __init__(self) -> None:
        self.seen: list[np.ndarray] | None = []  # None: already checked

    def note(self, observation: Any) -> None:
        """Keep observations `[N, ...]`; at the second call, warn of an entry that rounding changes."""
        if self.seen is None:
            return
        array = np.asarray(observation)
        if array.dtype.kind not in "iuf" or array.dtype.itemsize < 4 or array.dtype == np.float32:
            self.seen = None
            return
        self.seen.append(array.reshape(-1, array.shape[-1]).astype(np.float64))
        if len(self.seen) == 2:
            self._warn(np.concatenate(self.seen))
            self.seen = None

    def _warn(self, exact: np.ndarray) -> None:
        """Warn of the first entry of observations `[n, size]` that float32 rounds too much."""
        spread = exact.std(0)
        noise = NOISE * np.abs(exact).max(0)  # a norm of 1, computed in float64, is no information
        lost = ((exact - exact.astype(np.float32)).std(0) > LOST * spread) & (spread > noise)
        if lost.any():
            entry = int(np.flatnonzero(lost)[0])
            warnings.warn(
                f"students compute in float32, which rounds entry {entry} of observations, near "
                f"{exact[:, entry].mean():.0e}, by more than {LOST:.0%} of its standard deviation: "
                "subtract an offset in the environment",
                stacklevel=2,
            )
