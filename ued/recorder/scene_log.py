"""Scenes in a recording: the ground, the map of levels, the best levels, and recorded episodes.

Read next: `recorder.layout`, their arrangement in the viewer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import rerun

from ued.core.painter import ScenePainter, tiles_of, trails_of
from ued.levels.batch import LevelBatch
from ued.recorder.cards import BEST, by_score, episodes_card, origin
from ued.recorder.labels import spread
from ued.recorder.layout import TOP_LEVELS, log_ground, turn_y_up
from ued.recorder.shades import CALM_TO_RED, INFERNO, ramp, smooth, unit

HEAT_CELL = 2.0  # m
HEAT_MEMORY = 0.85  # decay of the heat map per update
MARK_COLOR = (235, 235, 235)  # color of starts and ends
END_SIZE = 0.55  # size of end points relative to start points
FILLING_RADIUS = 0.31  # radius of a line that fills a square from -1 to 1, since Rerun has no filled squares
FILLING = 0.23 * np.array([(-3, -3), (3, -3), (3, -1), (-3, -1), (-3, 1), (3, 1), (3, 3), (-3, 3)])  # the line


class Episodes(NamedTuple):
    """Episodes of a student on a level, in sequence.

    Attributes:
        positions: points `[T, K, 2]`; without a painter images, uint8 `[T, height, width, 3]`, or empty.
        begins: first frame of each episode, beginning with 0.
        step_seconds: time between two frames.
        outcome: a text about all of them.
        ends: outcome of each episode in a few words; by default all are unknown.
    """

    positions: np.ndarray
    begins: Sequence[int]
    step_seconds: float
    outcome: str
    ends: Sequence[str] = ()

    def parts(self) -> list[np.ndarray]:
        """Return the frames of each episode."""
        return np.split(self.positions, self.begins[1:]) if len(self.positions) else []

    def card(self) -> str:
        """Return a description in Markdown, a row for each episode."""
        lengths = [max(len(part) - 1, 0) for part in self.parts()]
        return episodes_card(self.outcome, self.ended(), lengths)

    def ended(self) -> list[str]:
        """Return the outcome of each episode, "unknown" if not available."""
        return [*self.ends, *["unknown"] * len(self.begins)][: len(self.parts())]


class SceneLog:
    """Writes `/scene/...` of a recording."""

    def __init__(self, stream: rerun.RecordingStream, painter: ScenePainter) -> None:
        self.stream, self.painter = stream, painter
        self._colors = np.array([color for _, color, _ in painter.markers], np.uint8)[painter.classes]  # [K, 3]
        self._radii = np.array([radius for _, _, radius in painter.markers])[painter.classes]  # [K]
        self._tiles, self._trails = tiles_of(painter), trails_of(painter)  # [K]
        x_low, x_high, y_low, y_high = painter.bounds
        cells = int(np.ceil((y_high - y_low) / HEAT_CELL)), int(np.ceil((x_high - x_low) / HEAT_CELL))
        self._heat = np.zeros(cells)  # [rows, columns], y from low to high

    def open(self, students: Sequence[str]) -> None:
        """Write the static content: the ground, and the style of points, lines and notes."""
        turn_y_up(self.stream)
        log_ground(self.stream, "scene", self.painter)
        x_low, _, y_low, _ = self.painter.bounds
        heat = rerun.Transform3D(translation=[x_low, y_low, 0], scale=[HEAT_CELL, HEAT_CELL, 1])
        self.stream.log("scene/heat", heat, static=True)
        style = rerun.Image.from_fields(opacity=0.9, draw_order=-9)  # below 1, otherwise Rerun ignores alpha
        self.stream.log("scene/heat/map", style, static=True)
        self.stream.log("scene/batch", rerun.Points2D.from_fields(show_labels=False), static=True)
        rollouts = [f"scene/rollout/{student}" for student in students]
        points = [*(f"{root}/{part}" for root in rollouts for part in ("now", "path/start"))]
        points += [f"scene/levels/{slot}/points" for slot in range(TOP_LEVELS)]
        for path in points:
            self.stream.log(path, self._looks(), static=True)
        for student in students:
            markdown = rerun.TextDocument.from_fields(media_type=rerun.MediaType.MARKDOWN)
            self.stream.log(f"rollouts/{student}", markdown, static=True)

    def note(self, theta: np.ndarray) -> None:
        """Add the levels `[L, D]` of an update to the heat map."""
        x_low, _, y_low, _ = self.painter.bounds
        focus = self.painter.positions(theta)[:, self.painter.focus]  # [L, 2]
        cells = ((focus - (x_low, y_low)) / HEAT_CELL).astype(int)
        rows, columns = self._heat.shape
        inside = ((cells >= 0) & (cells < (columns, rows))).all(1)
        self._heat *= HEAT_MEMORY
        np.add.at(self._heat, (cells[inside, 1], cells[inside, 0]), 1.0)

    def record(self, batch: LevelBatch) -> None:
        """Write the map of an update's levels, and the levels with the highest scores."""
        places = self.painter.positions(batch.theta)  # [L, K, 2]
        best, labels = by_score(batch, TOP_LEVELS), captions(batch)
        for slot in range(TOP_LEVELS):
            path = f"scene/levels/{slot}"
            if slot < len(best):
                shown = places[best[slot]]
                self._log_tiles(path, shown)
                self.stream.log(f"{path}/points", rerun.Points2D.from_fields(positions=self._moving(shown)))
            else:  # a smaller batch: clear the slot
                self.stream.log(path, rerun.Clear(recursive=True))
        share = unit(batch.score)
        known = np.isfinite(batch.score).any()
        dots = rerun.Points2D.from_fields(
            positions=places[:, self.painter.focus],
            colors=ramp(share, CALM_TO_RED) if known else np.full((len(share), 3), 225, np.uint8),
            radii=0.5 + 0.6 * share,
            labels=labels,
        )
        self.stream.log("scene/batch", dots)
        self.stream.log("scene/heat/map", self._heat_image())

    def record_path(self, student: str, episodes: Episodes) -> None:
        """Write the whole paths of a student's episodes, with the start and the labeled end of each."""
        root, parts = f"scene/rollout/{student}/path", episodes.parts()
        strips = [strip for part in parts for strip in part[:, self._trails].transpose(1, 0, 2)]
        colors = np.tile(self._colors[self._trails], (len(parts), 1))
        self.stream.log(f"{root}/lines", rerun.LineStrips2D(strips, colors=colors, radii=0.2))
        self.stream.log(f"{root}/start", rerun.Points2D.from_fields(positions=self._moving(parts[0][0])))
        ends = np.concatenate([part[-1, self._trails] for part in parts])
        radii = np.tile(self._radii[self._trails] * END_SIZE, len(parts))
        self._log_tiles(root, parts[0][0])
        self.stream.log(f"{root}/end", rerun.Points2D(ends, colors=colors, radii=radii, show_labels=False))
        self._log_marks(root, parts, episodes.ended())
        self.stream.log(f"rollouts/{student}", rerun.TextDocument.from_fields(text=episodes.card()))

    def _log_marks(self, root: str, parts: Sequence[np.ndarray], ended: Sequence[str]) -> None:
        """Write marks and labels at one point: where each episode starts, and its outcome where it ends."""
        focus, many = self._marked(parts), len(parts) > 1
        starts: dict[tuple[float, float], list[str]] = {}
        for number, part in enumerate(parts, start=1):
            x, y = part[0, focus].tolist()
            starts.setdefault((round(x, 1), round(y, 1)), []).append(str(number))
        texts = [f"start {', '.join(numbers)}" if len(starts) > 1 else "start" for numbers in starts.values()]
        texts += [f"end {k}: {end}" if many else f"end: {end}" for k, end in enumerate(ended, start=1)]
        places = np.array([*starts, *(part[-1, focus] for part in parts)])
        marks = rerun.Points2D(places, colors=MARK_COLOR, radii=0.35, draw_order=40)
        self.stream.log(f"{root}/marks", marks)
        below = spread(places, texts, self.painter.reach)
        labels = rerun.Points2D(below, labels=texts, colors=MARK_COLOR, radii=0.001, show_labels=True, draw_order=41)
        self.stream.log(f"{root}/labels", labels)
        leaders = np.stack([places, below], 1)[np.abs(places - below).max(1) > 0]  # [m, 2, 2], for labels that moved
        lines = rerun.LineStrips2D(leaders, colors=(*MARK_COLOR, 150), radii=0.1, draw_order=39)
        self.stream.log(f"{root}/leaders", lines)

    def _marked(self, parts: Sequence[np.ndarray]) -> int:
        """Return the index of the point that marks episodes: the focus if it moves, else the point that moves most."""
        moved = np.sum([np.nan_to_num(np.abs(np.diff(part, axis=0))).sum((0, 2)) for part in parts], 0)  # [K]
        moved *= self._trails
        return int(moved.argmax()) if moved.any() and not moved[self.painter.focus] else self.painter.focus

    def record_movie(self, student: str, began: float, episodes: Episodes) -> None:
        """Write the moving points on timeline `movie` only, starting at second `began`."""
        root, places = f"scene/rollout/{student}/now", self._moving(episodes.positions)
        steps, points = places.shape[:2]
        seconds = began + np.arange(steps) * episodes.step_seconds  # [T]
        lengths = np.full(steps, points)
        self.stream.send_columns(
            root,
            [rerun.TimeColumn("movie", duration=seconds)],
            rerun.Points2D.columns(positions=places.reshape(-1, 2)).partition(lengths),
        )
        self.stream.reset_time()
        self.stream.set_time("movie", duration=float(seconds[-1] + episodes.step_seconds))
        self.stream.log(root, rerun.Clear(recursive=True))

    def _moving(self, places: np.ndarray) -> np.ndarray:
        """Return points `[..., K, 2]` in which tiles are nan, since tiles are drawn separately."""
        return np.where(self._tiles[:, None], np.nan, places) if self._tiles.any() else places

    def _log_tiles(self, root: str, places: np.ndarray) -> None:
        """Write the tiles among the points `[K, 2]` as squares, each filled by one line, see `FILLING`."""
        if not self._tiles.any():
            return
        shown = self._tiles & np.isfinite(places).all(1)
        strips = places[shown, None] + self._radii[shown, None, None] * FILLING  # [n, 8, 2]
        radii = self._radii[shown] * FILLING_RADIUS
        tiles = rerun.LineStrips2D(strips, colors=self._colors[shown], radii=radii, draw_order=-6)
        self.stream.log(f"{root}/tiles", tiles)

    def _looks(self) -> Any:
        """Return the style of the points of a scene."""
        return rerun.Points2D.from_fields(class_ids=self.painter.classes, radii=self._radii, show_labels=False)

    def _heat_image(self) -> Any:
        density = smooth(self._heat)
        density /= density.max() + 1e-9
        alpha = 235 * np.clip(density * 1.35, 0, 1) ** 0.7
        image = np.dstack([ramp(0.15 + 0.85 * density, INFERNO), alpha.astype(np.uint8)])
        height, width, _ = image.shape
        pixels = rerun.components.ImageFormat(width=width, height=height, color_model="RGBA", channel_datatype="U8")
        return rerun.Image.from_fields(buffer=image.tobytes(), format=pixels)


def captions(batch: LevelBatch) -> list[str]:
    """Return a title for each level, followed by each student's mean and best returns on this visit, one per line."""
    best = batch.best
    parts = [titles(batch)]
    for student, returns in batch.returns.items():
        pairs = zip(returns.tolist(), best[student].tolist(), strict=True)
        parts.append([f"{student} {mean:+.2f}, {BEST} {most:+.2f}" for mean, most in pairs])
    return ["\n".join(lines) for lines in zip(*parts, strict=True)]


def titles(batch: LevelBatch) -> list[str]:
    """Return a title for each level: its number, source, and score if available."""
    scores = [f", score {score:.2f}" if np.isfinite(score) else "" for score in batch.score.tolist()]
    return [origin(batch, level) + score for level, score in enumerate(scores)]
