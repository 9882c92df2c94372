"""One episode in two engines under the same actions, side by side in a Rerun recording, with the distance between both.

    /scene/<n>/ground                static lines; coordinates below /scene are in m, y-up
    /scene/<n>/<side>/now            current positions, on timeline `step`
    /scene/<n>/<side>/path           the whole path of the painter's last point
    /gap/<n>/last, others            distance between both sides in m
    /card/<n>                        actions, endings, and the step of divergence

Read next: `ued.recorder.scene_log`, whose conventions these are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rerun
import rerun.blueprint as rrb

from ued.core.painter import ScenePainter, line_color_of
from ued.recorder.layout import blueprint, log_ground, plane_view, recording

PARTED = 1.5  # m between the balls, or between the positions of one player


@dataclass(frozen=True)
class SideBySide:
    """One episode in two engines.

    `sides` are their names; `points` of each `[T + 1, K, 2]` m, in the painter's order; `actions` `[T]`; `ends`: how it
    ended in each, as a word.
    """

    name: str
    painter: ScenePainter
    sides: tuple[str, str]
    points: tuple[np.ndarray, np.ndarray]
    actions: np.ndarray
    ends: tuple[str, str]

    def gaps(self) -> np.ndarray:
        """Return the distance of each point between both sides while both continue: `[T + 1, P + 1]` m."""
        steps = min(map(len, self.points))
        one, other = (points[:steps] for points in self.points)
        return np.linalg.norm(one - other, axis=-1)

    def parted(self) -> int | None:
        """Return the first step at which the distance of a point exceeds PARTED; None: never."""
        apart = np.flatnonzero((self.gaps() > PARTED).any(1))
        return int(apart[0]) if len(apart) else None

    def card(self) -> str:
        """Return a summary in Markdown."""
        step, gaps, kinds = self.parted(), self.gaps(), self.painter.classes
        if step is None:
            parting = f"No distance ever exceeds {PARTED} m."
        else:
            first = int(gaps[step].argmax())
            who = f"{self.painter.markers[kinds[first]][0]} (point {first})"
            parting = f"The episodes diverge at **step {step}**: {who} differs by {gaps[step, first]:.1f} m."
        actions = " ".join(map(str, self.actions))
        ends = "".join(
            f"| {side} | {end} | {len(points) - 1} |\n"
            for side, end, points in zip(self.sides, self.ends, self.points, strict=True)
        )
        return f"### {self.name}\n\n{parting}\n\n| | ended | steps |\n|---|---|---|\n{ends}\n`{actions}`\n"


def record_side_by_side(path: Path, name: str, pairs: Sequence[SideBySide]) -> None:
    """Write a recording, one tab for each pair. Raises OSError if the file cannot be written."""
    with recording(path, "regista_side_by_side", name, _layout(pairs)) as stream:
        for number, pair in enumerate(pairs):
            _log(stream, number, pair)


def _log(stream: rerun.RecordingStream, number: int, pair: SideBySide) -> None:
    painter = pair.painter
    root = f"scene/{number}"
    log_ground(stream, root, painter)
    for side, points in zip(pair.sides, pair.points, strict=True):
        way = rerun.LineStrips2D([points[:, -1]], colors=line_color_of(painter), radii=0.15, draw_order=-4)
        stream.log(f"{root}/{side}/path", way, static=True)
        _log_points(stream, f"{root}/{side}/now", painter, points)
    gaps = pair.gaps()
    times = [rerun.TimeColumn("step", sequence=np.arange(len(gaps)))]
    for what, values in (("last", gaps[:, -1]), ("others", gaps[:, :-1].mean(1))):
        stream.send_columns(f"gap/{number}/{what}", times, rerun.Scalars.columns(scalars=values))
    stream.log(f"card/{number}", rerun.TextDocument(pair.card(), media_type="text/markdown"), static=True)


def _log_points(stream: rerun.RecordingStream, path: str, painter: ScenePainter, points: np.ndarray) -> None:
    """Write all points at every step; after the end, the viewer keeps the last ones."""
    steps, count = points.shape[:2]
    lengths = np.full(steps, count)
    radii = np.array([radius for _, _, radius in painter.markers])[painter.classes]
    stream.send_columns(
        path,
        [rerun.TimeColumn("step", sequence=np.arange(steps))],
        [
            *rerun.Points2D.columns(positions=points.reshape(-1, 2)).partition(lengths),
            *rerun.Points2D.columns(class_ids=np.tile(painter.classes, steps)).partition(lengths),
            *rerun.Points2D.columns(radii=np.tile(radii, steps)).partition(lengths),
            *rerun.Points2D.columns(show_labels=[False] * steps),
        ],
    )


def _layout(pairs: Sequence[SideBySide]) -> Any:
    tabs = []
    for number, pair in enumerate(pairs):
        views = [_view(number, pair, side) for side in pair.sides]
        gap = rrb.TimeSeriesView(origin=f"/gap/{number}", name="Distance (m)")
        card = rrb.TextDocumentView(origin=f"/card/{number}", name="Card")
        below = rrb.Horizontal(gap, card, column_shares=[2, 1])
        tabs.append(rrb.Vertical(rrb.Horizontal(*views), below, row_shares=[2, 1], name=pair.name))
    return blueprint(rrb.Tabs(*tabs, active_tab=0), "step", fps=10)


def _view(number: int, pair: SideBySide, side: str) -> Any:
    paths = f"/scene/{number}/ground", f"/scene/{number}/{side}/**"
    return plane_view(pair.painter.reach, pair.painter.background, side.capitalize(), *paths)
