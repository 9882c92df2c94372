"""View of a program's scenes: the ground, and every object as a box with a heading, a class and a label.

Coordinates are in the program's units; a football program gets the lines of its pitch. Read next:
`pictures.scene_pictures` and `pictures.scene_recording`, which draw it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenic_lite.errors import ScenicError

if TYPE_CHECKING:
    from scenic_lite import Program, Scenes
    from scenic_lite.values.regions import Region

Color = tuple[int, int, int]

MARGIN = 0.06  # around all points, relative to width and height
PROBES = 256  # random scenes for estimating the extent of the objects
LABELED = 12  # maximum number of labeled objects; more labels would hide the scene
SMALLEST = 0.018  # minimum size of drawn objects, relative to the width
PALETTE: tuple[Color, ...] = (
    (31, 119, 208),
    (217, 65, 61),
    (42, 157, 143),
    (229, 165, 10),
    (142, 107, 191),
    (120, 129, 137),
    (181, 68, 110),
    (96, 140, 40),
)


@dataclass(frozen=True, eq=False)
class SceneView:
    """Static content of all scenes.

    Attributes:
        bounds: x low, x high, y low, y high.
        ground: strips [n, 2] of the workspace, or of the pitch.
        areas: strips of the regions from which points are sampled.
        classes: names of the objects' classes; `kinds` [O] index them, `colors` has one for each.
        labels: label of each of the O objects.
    """

    bounds: tuple[float, float, float, float]
    ground: list[np.ndarray]
    areas: list[np.ndarray]
    classes: tuple[str, ...]
    kinds: np.ndarray
    labels: tuple[str, ...]

    @property
    def colors(self) -> list[Color]:
        return [PALETTE[k % len(PALETTE)] for k in range(len(self.classes))]

    def boxes(self, scenes: Scenes) -> np.ndarray:
        """Return the drawn boxes of objects `[N, O, 5]`: x, y, heading, width, length; small ones are enlarged."""
        least = SMALLEST * (self.bounds[1] - self.bounds[0])
        sizes = [np.maximum(sizes_of(scenes, name), least) for name in ("width", "length")]
        return np.stack([scenes.positions[..., 0], scenes.positions[..., 1], scenes.headings, *sizes], axis=2)


def outlines_of(region: Region | None) -> list[np.ndarray]:
    """Return the boundary of a region, strips `[n, 2]`; empty without a region or for a random or unbounded one."""
    try:
        return [] if region is None else region.outlines()
    except ScenicError:
        return []


def view_of(program: Program, theta: np.ndarray, football: bool) -> SceneView:
    """Make the view of a program; it covers all of its areas, and all objects in the scenes of θ `[N, D]`."""
    ground = outlines_of(program.workspace)
    drawn = [region for region in program.drawn_regions if region is not program.workspace]
    areas = [strip for region in drawn for strip in outlines_of(region)]
    classes = tuple(dict.fromkeys(info.class_name for info in program.objects))
    kinds = np.array([classes.index(info.class_name) for info in program.objects], int)
    labels = tuple(info.name or ("ego" if k == 0 else info.class_name) for k, info in enumerate(program.objects))
    places = program.instantiate(theta).positions.reshape(-1, 2)
    if football:
        from regista.envs.football.scenic.lineup import METRES
        from regista.envs.football.view.render import pitch_lines

        ground = [strip / METRES for strip in pitch_lines()]
    return SceneView(bounds_of([*ground, *areas, places]), ground, areas, classes, kinds, labels)


def bounds_of(parts: list[np.ndarray]) -> tuple[float, float, float, float]:
    """Return bounds of all points with a margin, at least one unit wide: x low, x high, y low, y high."""
    points = np.concatenate([part.reshape(-1, 2) for part in parts])
    points = points[np.isfinite(points).all(1)]
    low, high = (points.min(0), points.max(0)) if len(points) else (np.zeros(2), np.zeros(2))
    margin = MARGIN * max(1.0, *(high - low)) + 0.5
    return float(low[0] - margin), float(high[0] + margin), float(low[1] - margin), float(high[1] + margin)


def sizes_of(scenes: Scenes, name: str) -> np.ndarray:
    """Return a numeric property of all objects `[N, O]`."""
    count = len(scenes.positions)
    if not scenes.positions.shape[1]:
        return np.zeros((count, 0))
    return np.stack([np.broadcast_to(np.asarray(values, float), count) for values in scenes.properties[name]], axis=1)


def corners(boxes: np.ndarray) -> np.ndarray:
    """Return the corners `[..., 4, 2]` of boxes `[..., 5]`, counterclockwise from the front right."""
    x, y, heading, width, length = np.moveaxis(boxes, -1, 0)
    c, s = np.cos(heading), np.sin(heading)
    signs = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    points = [(x + a * width * c - b * length * s, y + a * width * s + b * length * c) for a, b in signs]
    return np.stack([np.stack(point, -1) for point in points], axis=-2)


def arrows(boxes: np.ndarray) -> np.ndarray:
    """Return lines `[..., 2, 2]` from the center of each box to slightly beyond its front."""
    x, y, heading, _, length = np.moveaxis(boxes, -1, 0)
    center = np.stack([x, y], -1)
    return np.stack([center, center + 0.9 * length[..., None] * np.stack([-np.sin(heading), np.cos(heading)], -1)], -2)
