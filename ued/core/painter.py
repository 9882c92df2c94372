"""Interface for drawing the levels of a domain. Read next: `core.task`, which holds a painter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

Colour = tuple[int, int, int]


class ScenePainter(Protocol):
    """Look of a domain's levels. Positions are in meters, +y up."""

    bounds: tuple[float, float, float, float]  # of initial positions: x low, x high, y low, y high
    reach: tuple[float, float, float, float]  # of positions during an episode, in the same order
    background: Colour
    line_colour: Colour
    markers: Sequence[tuple[str, Colour, float]]  # by class: name, color, radius (m)
    classes: np.ndarray  # [K] the class of each point of a scene
    focus: int  # index of the point that represents a level on maps

    def lines(self) -> list[np.ndarray]:
        """Return the strips of the ground, each `[n, 2]`."""

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the points of the scenes of θ `[L, D]`: `[L, K, 2]`."""

    def frame(self, env: Any) -> np.ndarray:
        """Return the current points of the first environment of `env`: `[K, 2]`."""
