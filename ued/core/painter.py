"""What a domain supplies so that its levels can be drawn. Read next: `core.task`, which holds one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

Colour = tuple[int, int, int]


class ScenePainter(Protocol):
    """What a domain tells the recorder of its looks. Places are in metres, +y up."""

    bounds: tuple[float, float, float, float]  # of where levels are: x low, x high, y low, y high
    reach: tuple[float, float, float, float]  # of where things get while a level is played, likewise
    background: Colour
    line_colour: Colour
    markers: Sequence[tuple[str, Colour, float]]  # by class: name, colour, radius (m)
    classes: np.ndarray  # [K] the class of each point of a scene
    focus: int  # the point that stands for the whole level on a map

    def lines(self) -> list[np.ndarray]:
        """Return the strips of the ground, each `[n, 2]`."""

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the points of the scenes of θ `[L, D]`: `[L, K, 2]`."""

    def frame(self, env: Any) -> np.ndarray:
        """Return the points of the first environment of `env` as it stands: `[K, 2]`."""
