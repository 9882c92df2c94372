"""Scenes as a Rerun recording: in sequence on the timeline `scene`, each with a description of its θ.

Entities: `/scene/ground`, the static lines; `/scene/objects`, boxes; `/scene/headings`, arrows; `/card`, the
description of θ. Read next: `ued.recorder.recorder`, the recording of a whole curriculum.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
import rerun
import rerun.blueprint as rrb

from regista.experiments.pictures.scene_view import LABELED
from ued.recorder.layout import blueprint, plane_view, recording

BACKGROUND = (24, 27, 31)
CHALK, AREA = (190, 200, 192), (84, 94, 88)


class SceneStage(Protocol):
    """Static content of all scenes, see `pictures.scene_view`."""

    @property
    def bounds(self) -> tuple[float, float, float, float]: ...
    @property
    def ground(self) -> list[np.ndarray]: ...
    @property
    def areas(self) -> list[np.ndarray]: ...
    @property
    def classes(self) -> tuple[str, ...]: ...
    @property
    def kinds(self) -> np.ndarray: ...
    @property
    def labels(self) -> tuple[str, ...]: ...
    @property
    def colors(self) -> list[tuple[int, int, int]]:
        """Return one color for each class."""


class SceneRecord(NamedTuple):
    """One scene: outlines of its objects [O, 4, 2], arrows along their headings [O, 2, 2], a card in Markdown."""

    outlines: np.ndarray
    arrows: np.ndarray
    card: str


def record_scenes(path: Path, name: str, stage: SceneStage, scenes: Iterable[SceneRecord]) -> None:
    """Write a recording of scenes. Raises OSError if the file cannot be written."""
    with recording(path, "regista_scenes", name, scenes_layout(stage)) as stream:
        log_ground(stream, stage)
        for index, scene in enumerate(scenes):
            stream.set_time("scene", sequence=index)
            log_scene(stream, stage, scene)


def log_ground(stream: rerun.RecordingStream, stage: SceneStage) -> None:
    """Write the static lines."""
    infos = [(k, name, color) for k, (name, color) in enumerate(zip(stage.classes, stage.colors, strict=True))]
    stream.log("scene", rerun.AnnotationContext(infos), static=True)
    width = stage.bounds[1] - stage.bounds[0]
    areas = rerun.LineStrips2D(stage.areas, colors=AREA, radii=width / 900, draw_order=-9)
    stream.log("scene/ground/areas", areas, static=True)
    ground = rerun.LineStrips2D(stage.ground, colors=CHALK, radii=width / 700, draw_order=-8)
    stream.log("scene/ground/lines", ground, static=True)


def log_scene(stream: rerun.RecordingStream, stage: SceneStage, scene: SceneRecord) -> None:
    """Write one scene at the stream's current time; objects without a position are skipped."""
    known = np.isfinite(scene.outlines).all((1, 2))
    kinds = stage.kinds[known]
    colors = np.array(stage.colors, np.uint8).reshape(-1, 3)[kinds]
    labels = [label for label, there in zip(stage.labels, known, strict=True) if there]
    closed = [np.vstack([outline, outline[:1]]) for outline in scene.outlines[known]]
    width = stage.bounds[1] - stage.bounds[0]
    boxes = rerun.LineStrips2D(
        closed, colors=colors, radii=width / 500, class_ids=kinds, labels=labels, show_labels=len(labels) <= LABELED
    )
    stream.log("scene/objects", boxes)
    heads = scene.arrows[known]
    arrows = rerun.Arrows2D(
        origins=heads[:, 0], vectors=heads[:, 1] - heads[:, 0], colors=colors, radii=width / 600, show_labels=False
    )
    stream.log("scene/headings", arrows)
    stream.log("card", rerun.TextDocument(scene.card, media_type="text/markdown"))


def scenes_layout(stage: SceneStage) -> Any:
    """Return the blueprint: the scene, with its card next to it."""
    view = plane_view(stage.bounds, BACKGROUND, "Scene", "/scene/**")
    card = rrb.TextDocumentView(origin="/card", name="Parameters θ")
    return blueprint(rrb.Horizontal(view, card, column_shares=[2.2, 1]), "scene", fps=2)


def card_of(title: str, rows: Sequence[tuple[str, str, str]], notes: Sequence[str]) -> str:
    """Return a card in Markdown: a title, a table of name, θ and value, and notes below."""
    lines = [f"## {title}", "", "| parameter | θ | value |", "|---|---|---|"]
    lines += [f"| {name} | {theta} | {value} |" for name, theta, value in rows]
    return "\n".join([*lines, "", *notes])
