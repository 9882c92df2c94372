"""Interface for drawing the levels of a domain. Read next: `core.task`, which holds a painter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

Color = tuple[int, int, int]


class ScenePainter(Protocol):
    """Appearance of a domain's levels. Positions are in meters, +y up.

    Two masks are optional, bool `[K]`, by default all False. `tiles` marks squares that do not move during an episode,
    such as walls; their radius is half a side. `details` marks points that only pictures of single scenes show:
    recordings draw no path of them, and maps of many levels omit them.
    """

    bounds: tuple[float, float, float, float]  # bounds of initial positions: x low, x high, y low, y high
    reach: tuple[float, float, float, float]  # bounds of positions during an episode, in the same order
    background: Color
    line_color: Color
    markers: Sequence[tuple[str, Color, float]]  # by class: name, color, radius (m)
    classes: np.ndarray  # [K] the class of each point of a scene
    focus: int  # index of the point that represents a level on maps

    def lines(self) -> list[np.ndarray]:
        """Return the strips of the ground, each `[n, 2]`."""

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the points of the scenes of θ `[L, D]`: `[L, K, 2]`."""

    def frame(self, env: Any) -> np.ndarray:
        """Return the current points of the first environment of `env`: `[K, 2]`."""


def line_color_of(painter: ScenePainter) -> Color:
    """Return the color of a painter's ground lines; older painters of users call it `line_colour`."""
    return painter.line_color if hasattr(painter, "line_color") else painter.line_colour  # type: ignore[attr-defined]


def tiles_of(painter: ScenePainter) -> np.ndarray:
    """Return which points of a painter are squares: bool `[K]`."""
    return np.asarray(getattr(painter, "tiles", np.zeros(len(painter.classes), bool)))


def details_of(painter: ScenePainter) -> np.ndarray:
    """Return which points of a painter only pictures of single scenes show: bool `[K]`."""
    return np.asarray(getattr(painter, "details", np.zeros(len(painter.classes), bool)))


def trails_of(painter: ScenePainter) -> np.ndarray:
    """Return the points of a painter whose paths are shown: bool `[K]`."""
    return ~(tiles_of(painter) | details_of(painter))
