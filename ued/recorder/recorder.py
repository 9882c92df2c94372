"""The curriculum as a Rerun recording: played levels, their outcomes, and the distribution of θ.

The recorder is independent of the domain: a `ScenePainter` draws the levels. Without a painter, the recording has
θ, and a video of rendered frames (`/film/<student>`) instead of `/scene`. It writes these entities:

    /scene/ground                    static lines; coordinates below /scene are in m, y-up
    /scene/heat/map                  density of the painter's focus in recent levels
    /scene/batch                     the focus of each level of this update, colored by score
    /scene/levels/<slot>/...         the levels with the highest score, one per slot
    /scene/rollout/<student>/path    a student's whole path on a level, on timeline `update`, start and ends labeled
    /scene/rollout/<student>/now     the same, animated, on timeline `movie`
    /metrics/<name>                  every metric of the method; returns and score with a band of one std
    /theta/<name>/...                quantiles and histogram of each column of θ
    /theta/over_time/...             update x bin densities of all columns, with a cursor
    /levels/card                     the level with the highest score, as text, with the formula of its score
    /levels/<slot>                   the levels with the highest score, as text
    /rollouts/<student>              outcome and length of each recorded episode, as text
    /teacher/aim                     distribution of the chosen levels, as text
    /buffer/...                      scores, staleness and ancestry of a buffer's levels
    /events                          warnings, as text

Timelines: `update`, `env_steps`, and `movie`, which also animates the recorded episodes.
A resumed run adds a file with the same recording id; the viewer shows the parts as one recording.
Read next: `recorder.theta_log` and `recorder.scene_log`, the content; `recorder.layout`, the view.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rerun

from ued.core.painter import ScenePainter
from ued.core.upomdp import Parameter
from ued.levels.batch import LevelBatch
from ued.levels.buffer import LevelBuffer
from ued.recorder import buffer_log, cards
from ued.recorder.buffer_log import BufferLog
from ued.recorder.film_log import FilmLog
from ued.recorder.layout import TOP_LEVELS, layout, shown
from ued.recorder.rows import MOVIE_SECONDS, Rows
from ued.recorder.scene_log import Episodes, SceneLog
from ued.recorder.shades import SCENE_COLORS, SCORE_COLOR, SOURCE_COLORS, Color, student_color
from ued.recorder.theta_log import ThetaLog
from ued.recorder.writer import Writer, compact

APPLICATION = "regista"
TIMELINES = ("update", "env_steps")  # metrics that serve as timelines of all others


@dataclass(frozen=True)
class Recording:
    """Name and expected length of a recording. Its parts share the `id`, by which a viewer merges them."""

    path: Path
    id: str
    name: str
    total_env_steps: int
    properties: Mapping[str, Any]
    connect: str | None = None  # HOST:PORT of a live viewer; Rerun waits silently if none answers
    score: str = ""  # the rule that scores levels, if any, see `cards.formula`


class CurriculumRecorder:
    """Write one .rrd file. Call `record` after every update, `flush` at every checkpoint, `close` at the end."""

    def __init__(self, recording: Recording, painter: ScenePainter | None, draws: Sequence[Parameter]) -> None:
        self.recording, self.painter = recording, painter
        self.stream = rerun.RecordingStream(
            APPLICATION,
            recording_id=recording.id,
            # Large batches: with the default of 0.2 s every update writes a chunk per entity, six times the bytes.
            batcher_config=rerun.ChunkBatcherConfig(
                flush_tick=1.0 if recording.connect else 60.0, flush_num_bytes=16 << 20
            ),
        )
        self.stream.set_log_time_enabled(False)
        self.writer = Writer(self.stream)
        self.scenes = FilmLog(self.stream) if painter is None else SceneLog(self.stream, painter)
        self.rows = Rows(self.stream, shown)
        self.theta = ThetaLog(self.stream, self.rows, draws)
        self.buffer = BufferLog(self.stream)
        self._opened, self._views = False, None
        self._scenes: set[str] = set()  # test scenes whose curves have a style
        self._sources: set[str] = set()  # sources of levels that have occurred
        self._flushes = 0
        self._last = 0  # the last recorded update

    def recall(self, update: int, env_steps: int, theta: np.ndarray) -> None:
        """Add the levels `[L, D]` of an update that an earlier part of the recording already shows."""
        self._expect(update, env_steps)
        self.theta.note(update, theta)
        self.scenes.note(theta)

    def record(self, update: int, env_steps: int, batch: LevelBatch, metrics: Mapping[str, float]) -> None:
        """Write one update: its levels and all its metrics."""
        self._expect(update, env_steps)
        if not self._opened:
            self._open(list(batch.returns), {name.partition("/")[0] for name in metrics})
        self._at(update, env_steps)
        self._last = update
        for name, value in metrics.items():
            if name not in TIMELINES and np.isfinite(value) and self._occurs(name, value):
                self._look_of_scene(name)
                self.rows.scalars(["metrics", *name.split("/")], [value])
        if not len(batch.theta):
            return
        self.recall(update, env_steps, batch.theta)
        self._bands(batch)
        self.scenes.record(batch)
        self._log_cards(update, batch)
        self.theta.record(update, batch.theta)
        if self.recording.connect:  # a live viewer should not wait for a checkpoint
            self.theta.record_densities(update)
            self.rows.send()

    def level_buffer(self, update: int, buffer: LevelBuffer) -> None:
        """Write the content of a buffer, every few updates, at the last recorded update."""
        if self._opened and update % buffer_log.EVERY == 0:
            self.buffer.record(buffer)

    def episodes(self, student: str, update: int, env_steps: int, episodes: Episodes) -> None:
        """Write episodes of a student: whole paths on `update`, moving points on `movie`."""
        if self._opened:
            self._at(update, env_steps)
            self.scenes.record_path(student, episodes)
            self.scenes.record_movie(student, update * MOVIE_SECONDS, episodes)
            self._at(update, env_steps)

    def event(self, kind: str, text: str) -> None:
        """Log a warning at the last recorded update."""
        if self._opened:
            self.stream.log("events", rerun.TextLog(f"{kind}: {text}", level=rerun.TextLogLevel.WARN))

    def flush(self) -> None:
        """Write pending data, so that a later kill does not lose them.

        Raises Rerun's errors if the disk fails; then recording cannot continue.
        """
        if self._opened:
            self.theta.record_densities(self._last)  # not more often, since every version stays in the file
            self.rows.send()
            self._flushes += 1
            self.writer.wait_for(self.stream.flush)

    def close(self) -> None:
        """Finish the file, and merge what each flush has added. Raises the errors of `flush` and `compact`."""
        if self._opened:
            self.theta.record_densities(self._last, growth=1.0)
            self.flush()
        self.writer.finish()
        if self._flushes > 1:
            compact(self.recording.path, APPLICATION, self.recording.id, self._views)

    # ------------------------------------------------------------ pieces

    def _expect(self, update: int, env_steps: int) -> None:
        self.theta.expect(-(-self.recording.total_env_steps * update // max(env_steps, 1)))

    def _open(self, students: list[str], kinds: Set[str]) -> None:
        """Write the layout, the static content and the styles of curves for these `kinds` of metrics."""
        self._views = layout(self.painter, self.theta.names, students, kinds)
        sinks: list[Any] = [rerun.FileSink(str(self.recording.path))]
        if self.recording.connect:
            sinks.append(rerun.GrpcSink(f"rerun+http://{self.recording.connect}/proxy"))
        self.writer.wait_for(lambda: self.stream.set_sinks(*sinks, default_blueprint=self._views))
        self.stream.send_recording_name(self.recording.name)
        self.stream.send_property("config", rerun.AnyValues(**self.recording.properties))
        self._opened = True
        for index, student in enumerate(students):
            self._look(f"metrics/return_per_level/{student}", student, student_color(index))
        self._look("metrics/score_per_level", "score", SCORE_COLOR)
        for path in ("levels/card", "teacher/aim", *(f"levels/{slot}" for slot in range(TOP_LEVELS))):
            markdown = rerun.TextDocument.from_fields(media_type=rerun.MediaType.MARKDOWN)
            self.stream.log(path, markdown, static=True)
        self.scenes.open(students)
        self.theta.open()

    def _at(self, update: int, env_steps: int) -> None:
        self.rows.at(update, env_steps)
        self.stream.reset_time()
        self.stream.set_time("update", sequence=update)
        self.stream.set_time("env_steps", sequence=env_steps)
        self.stream.set_time("movie", duration=update * MOVIE_SECONDS)

    def _bands(self, batch: LevelBatch) -> None:
        bands = {f"return_per_level/{student}": returns for student, returns in batch.returns.items()}
        for name, values in (bands | {"score_per_level": batch.score}).items():
            known = values[np.isfinite(values)]
            if len(known):
                self.rows.band(["metrics", *name.split("/")], known)

    def _log_cards(self, update: int, batch: LevelBatch) -> None:
        """Write the texts beside the scenes, and the text about the chosen levels."""
        names, values, rule = self.theta.names, self.theta.values, self.recording.score
        texts = {
            "levels/card": cards.level_card(update, batch, names, values, rule),
            "teacher/aim": cards.aim_card(batch, names, values),
        }
        if self.painter is not None:
            best = cards.by_score(batch, TOP_LEVELS).tolist()
            texts |= {f"levels/{slot}": "" for slot in range(len(best), TOP_LEVELS)}  # slots without a level
            texts |= {f"levels/{slot}": cards.slot_card(batch, level, rule) for slot, level in enumerate(best)}
        for path, text in texts.items():
            self.stream.log(path, rerun.TextDocument.from_fields(text=text))

    def _occurs(self, name: str, value: float) -> bool:
        """Return whether a metric is written. The share of a source is written from the first level of the source on.

        Otherwise the legend would list sources that the method never has. The first level sets the style of the curve.
        """
        source = name.removeprefix("levels/")
        if source == name or source not in SOURCE_COLORS or source in self._sources:
            return True
        if value > 0:
            self._sources.add(source)
            looks = rerun.SeriesLines(colors=[SOURCE_COLORS[source]], names=[source], widths=[2.0])
            self.stream.log(f"metrics/levels/{source}", looks, static=True)
        return value > 0

    def _look_of_scene(self, name: str) -> None:
        """Write the style of a test scene's curve, a separate color and a wide line, with the first value."""
        if name.startswith("eval/") and name not in self._scenes:
            shade = SCENE_COLORS[len(self._scenes) % len(SCENE_COLORS)]
            self._scenes.add(name)
            looks = rerun.SeriesLines(colors=[shade], names=[name.removeprefix("eval/")], widths=[2.5])
            self.stream.log(rerun.new_entity_path(["metrics", *name.split("/")]), looks, static=True)

    def _look(self, path: str, name: str, color: Color) -> None:
        """Write the style of a band."""
        style = rerun.Measurements.from_fields(colors=[color], names=[name], widths=[2.0])
        self.stream.log(path, style, static=True)
