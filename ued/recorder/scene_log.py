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
from ued.levels.record import NONE
from ued.recorder.layout import TOP_LEVELS, log_ground, turn_y_up
from ued.recorder.shades import CALM_TO_RED, INFERNO, ramp, smooth, unit

HEAT_CELL = 2.0  # m
HEAT_MEMORY = 0.85  # decay of the heat map per update
NOTE_SHARE = 0.02  # half the line height of a note, relative to the view
END_SIZE = 0.55  # size of end points relative to start points
FILLING_RADIUS = 0.31  # of a line that fills a square from -1 to 1, as Rerun has no filled squares
FILLING = 0.23 * np.array([(-3, -3), (3, -3), (3, -1), (-3, -1), (-3, 1), (3, 1), (3, 3), (-3, 3)])  # its points


class Episodes(NamedTuple):
    """Episodes of a student on a level, in sequence.

    Attributes:
        positions: points `[T, K, 2]`; without a painter images, uint8 `[T, height, width, 3]`, or empty.
        begins: first frame of each episode, beginning with 0.
        step_seconds: time between two frames.
        outcome: a sentence about the outcome.
    """

    positions: np.ndarray
    begins: Sequence[int]
    step_seconds: float
    outcome: str


class SceneLog:
    """Writes `/scene/...` of a recording."""

    def __init__(self, stream: rerun.RecordingStream, painter: ScenePainter) -> None:
        self.stream, self.painter = stream, painter
        self._colours = np.array([colour for _, colour, _ in painter.markers], np.uint8)[painter.classes]  # [K, 3]
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
        notes = [f"{root}/path/outcome" for root in rollouts]
        for slot in range(TOP_LEVELS):
            points.append(f"scene/levels/{slot}/points")
            notes.append(f"scene/levels/{slot}/note")
        for path in points:
            self.stream.log(path, self._looks(), static=True)
        for path in notes:
            note = rerun.Points2D.from_fields(colors=(225, 225, 225), radii=0.01, show_labels=True)
            self.stream.log(path, note, static=True)

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
        """Write the map of an update's levels, and those with the highest scores."""
        places = self.painter.positions(batch.theta)  # [L, K, 2]
        best, labels = by_score(batch), captions(batch)
        for slot in range(TOP_LEVELS):
            path = f"scene/levels/{slot}"
            if slot < len(best):
                shown = places[best[slot]]
                self._log_tiles(path, shown)
                self.stream.log(f"{path}/points", rerun.Points2D.from_fields(positions=self._moving(shown)))
                self.stream.log(f"{path}/note", self._note_above(labels[best[slot]], self.painter.bounds))
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
        """Write the whole paths of a student's episodes, with their start and end points."""
        root, parts = f"scene/rollout/{student}/path", np.split(episodes.positions, episodes.begins[1:])
        strips = [strip for part in parts for strip in part[:, self._trails].transpose(1, 0, 2)]
        colours = np.tile(self._colours[self._trails], (len(parts), 1))
        self.stream.log(f"{root}/lines", rerun.LineStrips2D(strips, colors=colours, radii=0.2))
        self.stream.log(f"{root}/start", rerun.Points2D.from_fields(positions=self._moving(parts[0][0])))
        ends = np.concatenate([part[-1, self._trails] for part in parts])
        radii = np.tile(self._radii[self._trails] * END_SIZE, len(parts))
        self._log_tiles(root, parts[0][0])
        self.stream.log(f"{root}/end", rerun.Points2D(ends, colors=colours, radii=radii, show_labels=False))
        self.stream.log(f"{root}/outcome", self._note_above(episodes.outcome, self.painter.reach))

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
        """Return points `[..., K, 2]` in which tiles are nan, as they are drawn apart."""
        return np.where(self._tiles[:, None], np.nan, places) if self._tiles.any() else places

    def _log_tiles(self, root: str, places: np.ndarray) -> None:
        """Write the tiles among the points `[K, 2]` as squares, each one a line that fills it, see `FILLING`."""
        if not self._tiles.any():
            return
        shown = self._tiles & np.isfinite(places).all(1)
        strips = places[shown, None] + self._radii[shown, None, None] * FILLING  # [n, 8, 2]
        radii = self._radii[shown] * FILLING_RADIUS
        tiles = rerun.LineStrips2D(strips, colors=self._colours[shown], radii=radii, draw_order=-6)
        self.stream.log(f"{root}/tiles", tiles)

    def _looks(self) -> Any:
        """Return the style of the points of a scene."""
        return rerun.Points2D.from_fields(class_ids=self.painter.classes, radii=self._radii, show_labels=False)

    def _note_above(self, text: str, bounds: Sequence[float]) -> Any:
        """Return a note at the upper edge of bounds: x low, x high, y low, y high."""
        x_low, x_high, y_low, y_high = bounds
        place = [[(x_low + x_high) / 2, y_high - NOTE_SHARE * (y_high - y_low) * (1 + text.count("\n"))]]
        return rerun.Points2D.from_fields(positions=place, labels=[text])

    def _heat_image(self) -> Any:
        density = smooth(self._heat)
        density /= density.max() + 1e-9
        alpha = 235 * np.clip(density * 1.35, 0, 1) ** 0.7
        image = np.dstack([ramp(0.15 + 0.85 * density, INFERNO), alpha.astype(np.uint8)])
        height, width, _ = image.shape
        pixels = rerun.components.ImageFormat(width=width, height=height, color_model="RGBA", channel_datatype="U8")
        return rerun.Image.from_fields(buffer=image.tobytes(), format=pixels)


def by_score(batch: LevelBatch) -> np.ndarray:
    """Return the indices of the levels with the highest scores, best first, at most TOP_LEVELS."""
    return np.argsort(-np.nan_to_num(batch.score, nan=-np.inf), kind="stable")[:TOP_LEVELS]


def captions(batch: LevelBatch) -> list[str]:
    """Return a title for each level, with a line for each student with its mean and best returns."""
    best = batch.best
    parts = [titles(batch)]
    for student, returns in batch.returns.items():
        pairs = zip(returns.tolist(), best[student].tolist(), strict=True)
        parts.append([f"{student} {mean:+.2f}, best {most:+.2f}" for mean, most in pairs])
    return ["\n".join(lines) for lines in zip(*parts, strict=True)]


def titles(batch: LevelBatch) -> list[str]:
    """Return a title for each level: its number, source, and score if available."""
    columns = (batch.records["id"], batch.source, batch.records["parent"], batch.score)
    return [_title(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def _title(level: int, source: str, parent: int, score: float) -> str:
    origin = source if parent == NONE else f"{source} from {parent}"
    return f"level {level}, {origin}" + (f", score {score:.2f}" if score == score else "")
