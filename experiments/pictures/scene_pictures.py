"""Scenes of any program as a picture: one panel each, ground lines, and objects as boxes with a heading.

Read next: `pictures.scene_view`, the content of a picture.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.pictures.scene_view import LABELED, SceneView, arrows, corners

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from scenic_lite import Scenes

CHALK, AREA = "#aab6ac", "#d7dfd8"
TITLE_GAP = 2.2  # in font sizes, between rows of panels; separates titles from the panels above


def draw_pictures(view: SceneView, scenes: Scenes, path: Path) -> None:
    """Draw each scene on its own panel and save the picture. Raises `CommandError` if it cannot be written."""
    import matplotlib.pyplot as plt

    from regista.experiments.pictures import plots

    count = len(scenes.positions)
    columns = min(3, count)
    rows = -(-count // columns)
    share = (view.bounds[3] - view.bounds[2]) / (view.bounds[1] - view.bounds[0])
    size = (3.6 * columns, 3.6 * rows * min(max(share, 0.3), 2.0) + 0.5)
    boxes = view.boxes(scenes)
    with plots.style():
        figure, grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
        for axes in grid.flat[count:]:
            axes.set_visible(False)
        for index, axes in enumerate(grid.flat[:count]):
            draw_ground(axes, view)
            draw_objects(axes, view, boxes[index])
            validity = "" if scenes.ok[index] else " (not valid)"
            axes.set_title(f"scene {index}{validity}", fontweight="normal", color=plots.FAINT)
        legend(figure, view)
        figure.tight_layout(rect=(0, 0.03, 1, 1), h_pad=TITLE_GAP)
        plots.save(figure, path)


def draw_matches(painter: Any, theta: np.ndarray, path: Path) -> None:
    """Draw the initial states of matches at θ `[N, D]`. Raises `CommandError` if the file cannot be written."""
    import matplotlib.pyplot as plt

    from regista.experiments.pictures import plots

    columns = min(3, len(theta))
    rows = -(-len(theta) // columns)
    width, height = painter.bounds[1] - painter.bounds[0], painter.bounds[3] - painter.bounds[2]
    size = (3.4 * columns, 3.4 * rows * height / width + 0.5)
    with plots.style():
        figure, grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
        for axes in grid.flat[len(theta) :]:
            axes.set_visible(False)
        for index, (axes, row) in enumerate(zip(grid.flat, theta, strict=False)):
            painter.draw(axes, row[None])
            axes.set_title(f"scene {index}", fontweight="normal", color=plots.FAINT)
        plots.marker_legend(figure, painter, painter.positions(theta))
        figure.tight_layout(rect=(0, 0.03, 1, 1), h_pad=TITLE_GAP)
        plots.save(figure, path)


def draw_ground(axes: Axes, view: SceneView) -> None:
    for strips, color, width in ((view.areas, AREA, 0.8), (view.ground, CHALK, 1.1)):
        for strip in strips:
            axes.plot(strip[:, 0], strip[:, 1], color=color, linewidth=width, zorder=1)
    axes.set_xlim(view.bounds[0], view.bounds[1])
    axes.set_ylim(view.bounds[2], view.bounds[3])
    axes.set_aspect("equal")
    axes.tick_params(labelsize=6)


def draw_objects(axes: Axes, view: SceneView, boxes: np.ndarray) -> None:
    """Draw the objects of one scene as boxes `[O, 5]`."""
    from matplotlib.collections import LineCollection, PolyCollection

    colors: Any = np.array(view.colors)[view.kinds] / 255
    known = np.isfinite(boxes).all(1)
    axes.add_collection(
        PolyCollection(corners(boxes)[known], facecolors=colors[known], edgecolors="white", linewidths=0.6, zorder=3)
    )
    axes.add_collection(LineCollection(arrows(boxes)[known], colors=colors[known], linewidths=1.0, zorder=2))
    if len(boxes) <= LABELED:
        for box, label in zip(boxes, view.labels, strict=True):
            axes.annotate(label, box[:2], (4, 4), textcoords="offset points", fontsize=6, zorder=4)


def legend(figure: Any, view: SceneView) -> None:
    """Add a legend of the class colors below the panels."""
    from matplotlib.patches import Patch

    handles = [
        Patch(color=(red / 255, green / 255, blue / 255), label=name)
        for name, (red, green, blue) in zip(view.classes, view.colors, strict=True)
    ]
    figure.legend(handles=handles, loc="lower center", ncols=min(6, len(handles) or 1), bbox_to_anchor=(0.5, 0.0))
