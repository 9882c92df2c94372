"""The curriculum as a Rerun recording: which levels were played, what came of them, how θ moved.

All Rerun imports are in this module and in `recorder_layout`, inside functions, so that `import ued` works without
Rerun. The recorder knows no domain: a `ScenePainter` says what a level looks like. What it writes, by entity:

    /scene/ground                    lines that never change; below /scene metres are y-up
    /scene/heat/map                  where the recent levels put the painter's focus
    /scene/batch                     the focus of each level of this update, coloured by score
    /scene/levels/<slot>/...         the levels with the highest score, one per slot
    /scene/rollout/<student>/path    a recorded episode, whole, on timeline `update`
    /scene/rollout/<student>/now     the same, moving, on timeline `movie`
    /metrics/<name>                  every metric of the method; returns and score with a band of one deviation
    /theta/<draw>/...                quantiles and histogram of each column of θ
    /theta/over_time/...             update x bin densities of all columns, with a cursor
    /levels/card                     the level of the highest score, in words

Timelines: `update`, `env_steps`, and `movie`, on which pressing play animates the recorded episodes too.
A recording that is continued gets another file with the same recording id; the viewer shows the parts as one.
Read next: `recorder.layout`, what the viewer shows; `envs.football.view.render`, a painter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ued.recorder.layout import MAP_GAP, MAP_HEIGHT, MAP_WIDTH, TOP_LEVELS, Colour, ScenePainter, layout

BINS = 24  # of a histogram of θ
MAP_COLUMNS = 400  # of the densities over updates, at most
MAP_BLUR = 1.2  # of those densities, in columns and bins
HEAT_CELL = 2.0  # m
HEAT_MEMORY = 0.85  # share of the heat map that is left after an update
MOVIE_SECONDS = 1.0  # of the `movie` timeline per update
HISTOGRAM_EVERY = 5  # updates; bar charts cost a millisecond each

STUDENT_COLOURS: tuple[Colour, ...] = ((66, 165, 245), (255, 152, 0), (186, 104, 200), (102, 187, 106))
SCORE_COLOUR: Colour = (255, 82, 82)
INFERNO: tuple[Colour, ...] = (
    (0, 0, 4),
    (40, 11, 84),
    (101, 21, 110),
    (159, 42, 99),
    (212, 72, 66),
    (245, 125, 21),
    (250, 193, 39),
    (252, 255, 164),
)
CALM_TO_RED: tuple[Colour, ...] = ((176, 190, 178), (255, 213, 79), (255, 112, 67), (255, 45, 45))


class Episode(NamedTuple):
    """One recorded episode: points `[T, K, 2]`, seconds between them, and what came of it in a word."""

    positions: np.ndarray
    step_seconds: float
    outcome: str


@dataclass(frozen=True)
class Recording:
    """What a recording is called and how long it will be. `name` is the recording's id; parts share it."""

    path: Path
    name: str
    total_env_steps: int
    properties: Mapping[str, Any]


class CurriculumRecorder:
    """Write one .rrd file. Call `record` after every update, `flush` at every checkpoint, `close` at the end."""

    def __init__(self, recording: Recording, painter: ScenePainter, draws: Sequence[Any]) -> None:
        import rerun

        self.recording = recording
        self.painter = painter
        self.names = unique_names(draws)
        self._colours = np.array([colour for _, colour, _ in painter.markers], np.uint8)[painter.classes]  # [K, 3]
        self._radii = np.array([radius for _, _, radius in painter.markers])[painter.classes]  # [K]
        low, high = np.array([(draw.low, draw.high) for draw in draws], float).reshape(-1, 2).T
        finite = np.isfinite(low) & np.isfinite(high)
        self.low, self.high = np.where(finite, low, -1.0), np.where(finite, high, 1.0)  # else θ itself is shown
        self.stream = rerun.RecordingStream(
            "regista",
            recording_id=recording.name,
            # Big batches: with the default of 0.2 s every update would write a chunk per entity, six times the bytes.
            batcher_config=rerun.ChunkBatcherConfig(flush_tick=60.0, flush_num_bytes=16 << 20),
        )
        self.stream.set_log_time_enabled(False)
        self._opened = False
        self._horizon = 1  # updates that the run will take, as far as is known
        self._density = np.zeros((len(self.names), 1, BINS))  # [D, columns, bins]
        self._heat = np.zeros(self._heat_shape())  # [rows, columns], y from low to high
        self._mapped = 0  # the last update at which the densities were written
        self._pending: list[tuple[int, int, dict[str, float]]] = []

    # ------------------------------------------------------------ what a trainer calls

    def recall(self, update: int, env_steps: int, theta: np.ndarray) -> None:
        """Take note of the levels of an update that is already in an earlier part of the recording."""
        self._open_horizon(update, env_steps)
        self._note(update, theta)

    def record(self, update: int, env_steps: int, batch: Any, metrics: Mapping[str, float]) -> None:
        """Write one update: `batch` is a `LevelBatch` (levels, returns, score), `metrics` all its numbers."""
        self._open_horizon(update, env_steps)
        if not self._opened:
            self._open(list(batch.returns))
        self._at(update, env_steps)
        self._pending.append((update, env_steps, dict(metrics)))
        if not len(batch.theta):
            return
        self._note(update, batch.theta)
        self._curves(batch)
        self._scenes(update, batch)
        self._theta(update, batch.theta)
        if update >= 1.25 * self._mapped:  # seldom enough that the file grows by a constant factor only
            self._over_time(update)

    def episode(self, student: str, update: int, env_steps: int, episode: Episode) -> None:
        """Write an episode of a student: its whole path on `update`, its points moving on `movie`."""
        import rerun

        if not self._opened:
            return
        self._at(update, env_steps)
        root, places = f"scene/rollout/{student}", episode.positions
        paths = rerun.LineStrips2D(list(places.transpose(1, 0, 2)), colors=self._colours, radii=0.2)
        self.stream.log(f"{root}/path/lines", paths)
        self.stream.log(f"{root}/path/start", self._points(places[0]))
        note = f"{student}: {episode.outcome}"
        self.stream.log(f"{root}/path/outcome", self._note_above(note))
        self._animate(root, update, env_steps, episode)

    def flush(self) -> None:
        """Write out what is pending, so that a kill from here on loses nothing earlier."""
        if not self._opened:
            return
        self._send_metrics()
        self.stream.flush()

    def close(self) -> None:
        """Finish the file."""
        if self._opened:
            if self._pending:
                self._over_time(self._pending[-1][0])
            self.flush()
        self.stream.disconnect()

    # ------------------------------------------------------------ beginning

    def _open_horizon(self, update: int, env_steps: int) -> None:
        if self._horizon > 1:
            return
        self._horizon = max(2, -(-self.recording.total_env_steps * update // max(env_steps, 1)))
        self._density = np.zeros((len(self.names), min(self._horizon, MAP_COLUMNS), BINS))

    def _open(self, students: list[str]) -> None:
        """Begin the file: the layout, what never changes, the looks of the curves."""
        self.stream.save(self.recording.path, default_blueprint=layout(self.painter, self.names, students))
        self.stream.send_recording_name(self.recording.name)
        import rerun

        self.stream.send_property("config", rerun.AnyValues(**self.recording.properties))
        self._opened = True
        self._ground()
        self._styles()

    def _ground(self) -> None:
        import rerun

        painter = self.painter
        infos = [rerun.AnnotationInfo(k, name, colour) for k, (name, colour, _) in enumerate(painter.markers)]
        log = self.stream.log
        log("scene", rerun.AnnotationContext(infos), static=True)
        # Rerun's 2D views are y-down: one transform at the root keeps everything else in metres, y up.
        log("scene", rerun.Transform3D(mat3x3=np.diag([1.0, -1.0, 1.0])), static=True)
        strips = rerun.LineStrips2D(painter.lines(), colors=painter.line_colour, radii=0.12, draw_order=-8)
        log("scene/ground", strips, static=True)
        x_low, _, y_low, _ = painter.bounds
        log(
            "scene/heat", rerun.Transform3D(translation=[x_low, y_low, 0], scale=[HEAT_CELL, HEAT_CELL, 1]), static=True
        )

    def _styles(self) -> None:
        import rerun

        for name in self.names:
            shades = [(90, 130, 170), (130, 200, 255), (90, 130, 170)]
            quantiles = rerun.SeriesLines(colors=shades, names=["10 %", name, "90 %"], widths=[1, 2.5, 1])
            self.stream.log(["theta", name, "quantiles"], quantiles, static=True)
            edges = np.linspace(*self._range(name), BINS + 1)
            prior = rerun.BarChart(
                np.full(BINS, 1 / BINS),
                abscissa=(edges[1:] + edges[:-1]) / 2,
                widths=np.diff(edges).astype(np.float32),
                color=(120, 120, 120, 60),
            )
            self.stream.log(["theta", name, "uniform"], prior, static=True)

    # ------------------------------------------------------------ one update

    def _at(self, update: int, env_steps: int) -> None:
        self.stream.reset_time()
        self.stream.set_time("update", sequence=update)
        self.stream.set_time("env_steps", sequence=env_steps)
        self.stream.set_time("movie", duration=update * MOVIE_SECONDS)

    def _note(self, update: int, theta: np.ndarray) -> None:
        """Add the levels of an update to the densities over updates and to the heat map."""
        last = self._density.shape[1] - 1
        column = min(update * (last + 1) // self._horizon, last)
        bins = np.clip(((theta + 1) / 2 * BINS).astype(int), 0, BINS - 1)  # [L, D]
        for d in range(len(self.names)):
            self._density[d, column] += np.bincount(bins[:, d], minlength=BINS)
        x_low, _, y_low, _ = self.painter.bounds
        focus = self.painter.positions(theta)[:, self.painter.focus]
        cells = ((focus - (x_low, y_low)) / HEAT_CELL).astype(int)
        rows, columns = self._heat.shape
        inside = ((cells >= 0) & (cells < (columns, rows))).all(1)
        self._heat *= HEAT_MEMORY
        np.add.at(self._heat, (cells[inside, 1], cells[inside, 0]), 1.0)

    def _curves(self, batch: Any) -> None:
        for index, (student, returns) in enumerate(batch.returns.items()):
            self._band(f"metrics/return_per_level/{student}", student, returns, STUDENT_COLOURS[index])
        self._band("metrics/score_per_level", "score", batch.score, SCORE_COLOUR)

    def _band(self, path: str, name: str, values: np.ndarray, colour: Colour) -> None:
        import rerun

        known = values[np.isfinite(values)]
        if len(known):
            band = rerun.Measurements(known.mean(), variances=known.var(), colors=[colour], names=[name], widths=[2.0])
            self.stream.log(path, band)

    def _scenes(self, update: int, batch: Any) -> None:
        import rerun

        score = batch.score  # [L]
        places = self.painter.positions(batch.theta)  # [L, K, 2]
        rank = np.nan_to_num(score, nan=-np.inf)
        order = np.argsort(-rank, kind="stable")[:TOP_LEVELS]
        for slot in range(TOP_LEVELS):
            path = f"scene/levels/{slot}"
            if slot < len(order):
                level = order[slot]
                self.stream.log(f"{path}/points", self._points(places[level]))
                self.stream.log(f"{path}/note", self._note_above(self._caption(batch, level)))
            else:  # a smaller batch than before: nothing stale may stay in the slot
                self.stream.log(path, rerun.Clear(recursive=True))
        share = _unit(score)
        colours = ramp(share, CALM_TO_RED) if np.isfinite(score).any() else np.full((len(score), 3), 225, np.uint8)
        labels = [self._caption(batch, level) for level in range(len(score))]
        dots = rerun.Points2D(
            places[:, self.painter.focus], colors=colours, radii=0.5 + 0.6 * share, labels=labels, show_labels=False
        )
        self.stream.log("scene/batch", dots)
        self.stream.log("scene/heat/map", self._heat_image())
        self.stream.log("levels/card", self._card(update, batch, order[0]))

    def _theta(self, update: int, theta: np.ndarray) -> None:
        import rerun

        values = self.low + (theta + 1) / 2 * (self.high - self.low)  # [L, D]
        for d, name in enumerate(self.names):
            self.stream.log(["theta", name, "quantiles"], rerun.Scalars(np.quantile(values[:, d], [0.1, 0.5, 0.9])))
            if update % HISTOGRAM_EVERY == 0 or update == 1:
                counts, edges = np.histogram(values[:, d], bins=BINS, range=self._range(name))
                chart = rerun.BarChart(
                    counts / len(values),
                    abscissa=(edges[1:] + edges[:-1]) / 2,
                    widths=(np.diff(edges) * 0.92).astype(np.float32),
                    color=(130, 200, 255),
                )
                self.stream.log(["theta", name, "histogram"], chart)
        x = (update + 0.5) / self._horizon * MAP_WIDTH
        cursor = rerun.LineStrips2D([[[x, -2.0], [x, MAP_HEIGHT]]], colors=(255, 255, 255), radii=-0.8)
        self.stream.log("theta/over_time/cursor", cursor)

    def _send_metrics(self) -> None:
        """Send the pending metrics in columns: a hundred times cheaper than a row at a time."""
        import rerun

        for name in dict.fromkeys(name for _, _, metrics in self._pending for name in metrics):
            rows = [(u, s, m[name]) for u, s, m in self._pending if np.isfinite(m.get(name, np.nan))]
            if not rows:
                continue
            updates, steps, values = (np.array(column) for column in zip(*rows, strict=True))
            times = self._time_columns(updates, steps)
            path = rerun.new_entity_path(["metrics", *name.split("/")])  # a name may hold blanks
            self.stream.send_columns(path, times, rerun.Scalars.columns(scalars=values.astype(float)))
        self._pending.clear()

    def _time_columns(self, updates: np.ndarray, steps: np.ndarray) -> list[Any]:
        import rerun

        return [
            rerun.TimeColumn("update", sequence=updates),
            rerun.TimeColumn("env_steps", sequence=steps),
            rerun.TimeColumn("movie", duration=updates * MOVIE_SECONDS),
        ]

    def _over_time(self, update: int) -> None:
        """Write the densities of all columns of θ over updates, stacked in one view."""
        import rerun

        columns, ticks, texts = self._density.shape[1], [], []
        band = MAP_HEIGHT / max(len(self.names), 1)
        for d, name in enumerate(self.names):
            density = smooth(self._density[d], MAP_BLUR)  # [columns, bins]: an update alone has too few levels
            density /= np.maximum(density.max(1, keepdims=True), 1e-9)
            scale = [MAP_WIDTH / columns, (band - MAP_GAP) / BINS, 1.0]
            place = rerun.Transform3D(translation=[0, d * band, 0], scale=scale)
            self.stream.log(f"theta/over_time/{d}", place, static=True)
            pixels = np.ascontiguousarray(density.T[::-1], np.float32)
            image = rerun.DepthImage(pixels, colormap="inferno", depth_range=[0.0, 1.0], draw_order=-5)
            self.stream.log(f"theta/over_time/{d}/map", image, static=True)
            ticks.append([-32, (d + 0.5) * band])
            texts.append(f"{name}: {self.low[d]:g} to {self.high[d]:g}")
        for mark in np.linspace(0, self._horizon, 5):
            ticks.append([mark / self._horizon * MAP_WIDTH, MAP_HEIGHT])
            texts.append(f"#{mark:.0f}")
        axis = rerun.Points2D(ticks, labels=texts, radii=0.001, colors=(205, 210, 215), show_labels=True)
        self.stream.log("theta/over_time/axis", axis, static=True)
        self._mapped = update

    def _animate(self, root: str, update: int, env_steps: int, episode: Episode) -> None:
        """Write the moving points on `movie` only: on `update` they would hide all but their last step."""
        import rerun

        steps, points = episode.positions.shape[:2]
        seconds = update * MOVIE_SECONDS + np.arange(steps) * episode.step_seconds
        each = np.full(steps, points)
        self.stream.send_columns(
            f"{root}/now",
            [rerun.TimeColumn("movie", duration=seconds)],
            [
                *rerun.Points2D.columns(positions=episode.positions.reshape(-1, 2)).partition(each),
                *rerun.Points2D.columns(class_ids=np.tile(self.painter.classes, steps)).partition(each),
                *rerun.Points2D.columns(radii=np.tile(self._radii, steps)).partition(each),
                *rerun.Points2D.columns(show_labels=[False] * steps),
            ],
        )
        self.stream.reset_time()
        self.stream.set_time("movie", duration=float(seconds[-1] + episode.step_seconds))
        self.stream.log(f"{root}/now", rerun.Clear(recursive=True))
        self._at(update, env_steps)

    # ------------------------------------------------------------ pieces

    def _points(self, places: np.ndarray) -> Any:
        """Give the points of one scene `[K, 2]`; all fields are set, so that no old colour or radius stays."""
        import rerun

        return rerun.Points2D(places, class_ids=self.painter.classes, radii=self._radii, show_labels=False)

    def _note_above(self, text: str) -> Any:
        import rerun

        x_low, x_high, _, y_high = self.painter.bounds
        place = [[(x_low + x_high) / 2, y_high - 1.0]]
        return rerun.Points2D(place, labels=[text], colors=[(225, 225, 225)], radii=0.01, show_labels=True)

    def _caption(self, batch: Any, level: int) -> str:
        parts = [f"{student} {returns[level]:+.2f}" for student, returns in batch.returns.items()]
        if np.isfinite(batch.score[level]):
            parts.insert(0, f"score {batch.score[level]:.2f}")
        return "   ".join(parts)

    def _card(self, update: int, batch: Any, level: int) -> Any:
        import rerun

        score = batch.score  # [L]
        low, value, high = (
            self.low + (row + 1) / 2 * (self.high - self.low)
            for row in (np.quantile(batch.theta, 0.1, 0), batch.theta[level], np.quantile(batch.theta, 0.9, 0))
        )
        returns = "\n".join(
            f"| {name} | {values[level]:+.2f} | {batch.episodes[name][level]} |"
            for name, values in batch.returns.items()
        )
        rows = "\n".join(
            f"| {name} | {value[d]:.2f} | {low[d]:.2f} to {high[d]:.2f} |" for d, name in enumerate(self.names)
        )
        title = f"score {score[level]:.3f}, the highest of {len(score)}" if np.isfinite(score[level]) else "one level"
        text = (
            f"### Update {update}: {title}\n\n| student | return | episodes |\n|---|---|---|\n{returns}\n\n"
            f"| θ | value | batch, 10 % to 90 % |\n|---|---|---|\n{rows}\n"
        )
        return rerun.TextDocument(text, media_type=rerun.MediaType.MARKDOWN)

    def _heat_shape(self) -> tuple[int, int]:
        x_low, x_high, y_low, y_high = self.painter.bounds
        return int(np.ceil((y_high - y_low) / HEAT_CELL)), int(np.ceil((x_high - x_low) / HEAT_CELL))

    def _heat_image(self) -> Any:
        import rerun

        density = smooth(self._heat)
        density /= density.max() + 1e-9
        alpha = 235 * np.clip(density * 1.35, 0, 1) ** 0.7
        image = np.dstack([ramp(0.15 + 0.85 * density, INFERNO), alpha.astype(np.uint8)])
        return rerun.Image(image, opacity=0.9, draw_order=-9)  # below 1, or alpha would be ignored

    def _range(self, name: str) -> tuple[float, float]:
        d = self.names.index(name)
        return self.low[d], max(self.high[d], self.low[d] + 1e-9)


def unique_names(draws: Sequence[Any]) -> list[str]:
    """Give the names of the columns of θ, numbered where two are alike."""
    names = [draw.name for draw in draws]
    return [name if names.count(name) == 1 else f"{name} {names[:k].count(name) + 1}" for k, name in enumerate(names)]


def ramp(share: np.ndarray, table: Sequence[Colour]) -> np.ndarray:
    """Give the colours uint8 `[..., 3]` of numbers in [0, 1] on a table of equally spaced colours."""
    rows = np.array(table, float)
    place = np.clip(np.nan_to_num(share), 0, 1) * (len(rows) - 1)
    below = np.minimum(place.astype(int), len(rows) - 2)
    part = (place - below)[..., None]
    return (rows[below] * (1 - part) + rows[below + 1] * part).astype(np.uint8)


def smooth(grid: np.ndarray, width: float = 1.5) -> np.ndarray:
    """Blur a grid with a Gaussian of this width in cells."""
    reach = np.arange(-int(3 * width), int(3 * width) + 1)
    kernel = np.exp(-(reach**2) / (2 * width**2))
    kernel /= kernel.sum()
    for axis in (0, 1):
        grid = np.apply_along_axis(lambda line: np.convolve(line, kernel)[len(reach) // 2 :][: len(line)], axis, grid)
    return grid


def _unit(score: np.ndarray) -> np.ndarray:
    """Scale scores to [0, 1] by their highest; unknown ones are 0."""
    known = np.nan_to_num(score)
    return np.clip(known / max(known.max(initial=0.0), 1e-6), 0, 1)
