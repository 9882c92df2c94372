"""Helpers for plots: names, colors and smoothed grids. They need neither Rerun nor Gymnasium.

Read next: `recorder.scene_log`, which uses them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ued.core.painter import Color

STUDENT_COLORS: tuple[Color, ...] = ((66, 165, 245), (255, 152, 0), (186, 104, 200), (102, 187, 106))
SCORE_COLOR: Color = (255, 82, 82)
SCENE_COLORS: tuple[Color, ...] = (  # for test scenes, on a dark background: Okabe and Ito 2008, lightened
    (86, 180, 233),
    (230, 159, 0),
    (0, 205, 150),
    (240, 228, 66),
    (225, 140, 190),
    (245, 120, 50),
    (235, 235, 235),
    (150, 130, 255),
)
SOURCE_COLORS: dict[str, Color] = {  # colors of levels, by source
    "random": (158, 158, 158),
    "proposed": (66, 165, 245),
    "replaced": (186, 104, 200),
    "replayed": (255, 152, 0),
    "edited": (102, 187, 106),
}
INFERNO: tuple[Color, ...] = (
    (0, 0, 4),
    (40, 11, 84),
    (101, 21, 110),
    (159, 42, 99),
    (212, 72, 66),
    (245, 125, 21),
    (250, 193, 39),
    (252, 255, 164),
)
CALM_TO_RED: tuple[Color, ...] = ((176, 190, 178), (255, 213, 79), (255, 112, 67), (255, 45, 45))


def student_color(index: int) -> Color:
    """Return the color of a student by its number; colors repeat in large populations."""
    return STUDENT_COLORS[index % len(STUDENT_COLORS)]


def unique_names(draws: Sequence[Any]) -> list[str]:
    """Return the names of the columns of θ; duplicates are numbered."""
    names = [parameter.name for parameter in draws]
    return [name if names.count(name) == 1 else f"{name} {names[:k].count(name) + 1}" for k, name in enumerate(names)]


def ramp(share: np.ndarray, table: Sequence[Color]) -> np.ndarray:
    """Return the colors uint8 `[..., 3]` of numbers in [0, 1], by interpolation in a table of equally spaced colors."""
    rows = np.array(table, float)  # [C, 3]
    place = np.clip(np.nan_to_num(share), 0, 1) * (len(rows) - 1)
    below = np.minimum(place.astype(int), len(rows) - 2)
    part = (place - below)[..., None]
    return (rows[below] * (1 - part) + rows[below + 1] * part).astype(np.uint8)


def smooth(grid: np.ndarray, width: float = 1.5) -> np.ndarray:
    """Blur a grid `[rows, columns]` with a Gaussian of this width in cells."""
    reach = np.arange(-int(3 * width), int(3 * width) + 1)
    kernel = np.exp(-(reach**2) / (2 * width**2))
    kernel /= kernel.sum()
    for axis in (0, 1):
        grid = np.apply_along_axis(lambda line: np.convolve(line, kernel)[len(reach) // 2 :][: len(line)], axis, grid)
    return grid


def unit(score: np.ndarray) -> np.ndarray:
    """Scale scores `[L]` to [0, 1], from 0, or the lowest score if negative, to the highest; nan becomes 0."""
    known = np.isfinite(score)
    low, high = min(score[known].min(initial=0.0), 0.0), score[known].max(initial=-np.inf)
    return np.where(known, np.clip((np.nan_to_num(score) - low) / max(high - low, 1e-6), 0, 1), 0.0)
