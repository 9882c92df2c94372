"""Layout of a recording in the viewer, as tabs.

*Overview* (map of levels, level with the highest score, returns, regret, test scenes, θ over updates), *Levels* (the
six highest scores), *Rollouts* (each student on one level), *Theta* (histograms against the uniform, θ over updates),
*Teacher* (sources, entropy, chosen levels, events), and *Buffer* for methods with a buffer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
import rerun
import rerun.blueprint as rrb

from ued.core.painter import Color, ScenePainter, line_color_of
from ued.recorder.shades import SOURCE_COLORS
from ued.recorder.writer import Writer

PlayState = Literal["Paused", "Playing", "Following"]
Corner = Literal["LeftTop", "RightTop", "LeftBottom", "RightBottom"]

TOP_LEVELS = 6  # slots of the Levels tab
MAP_WIDTH, MAP_HEIGHT, MAP_GAP = 240.0, 120.0, 3.0  # size of the densities over updates, in view units
MAP_LEFT = 104.0  # room for labels to the left of the densities
SOURCES = tuple(f"/metrics/levels/{source}" for source in SOURCE_COLORS)
ENTROPIES = ("/metrics/adversary/entropy", "/metrics/theta_entropy")
BUFFERED = ("/metrics/buffer/score", "/metrics/buffer/generation")
RETURNS, SCORE, TESTS = "/metrics/return_per_level/", "/metrics/score_per_level", "/metrics/eval/"
PROGRAMS, CHOICES = "/metrics/program/", "/metrics/choice_ratio/"
CURVES = (*SOURCES, *ENTROPIES, *BUFFERED, RETURNS, SCORE, TESTS, PROGRAMS, CHOICES)  # curves that views show
DARK: Color = (12, 12, 14)


def layout(
    painter: ScenePainter | None, names: Sequence[str], students: Sequence[str], kinds: Set[str] = frozenset()
) -> Any:
    """Return the blueprint for a painter, the names of the columns of θ, and the names of the students.

    `kinds` are the prefixes of the available metrics: "program" for levels of several programs, "buffer" for methods
    with a buffer.
    """
    mixed = "program" in kinds
    more = [_teacher(mixed, "choice_ratio" in kinds), *([_buffer()] if "buffer" in kinds else [])]
    if painter is None:
        return blueprint(rrb.Tabs(_plain(students), _theta(names), *more, active_tab=0), "update", 10, "Following")
    tabs = rrb.Tabs(
        _overview(painter, students, mixed, "buffer" in kinds),
        _levels(painter),
        _rollouts(painter, students),
        _theta(names),
        *more,
        active_tab=0,
    )
    return blueprint(tabs, "update", 10, "Following")


def shown(path: str) -> bool:
    """Return whether a view of the layout shows the curve of this entity, such as `metrics/score`."""
    return f"/{path}".startswith(CURVES)


@contextmanager
def recording(path: Path, kind: str, name: str, views: Any) -> Iterator[rerun.RecordingStream]:
    """Open a recording at a path, with y up below /scene. Raises OSError or RuntimeError if it cannot be written."""
    with open(path, "wb"):  # Rerun only warns about an unwritable path
        pass
    stream = rerun.RecordingStream(kind, recording_id=name)
    stream.set_log_time_enabled(False)
    writer = Writer(stream)
    writer.wait_for(lambda: stream.save(path, default_blueprint=views))
    stream.send_recording_name(name)
    turn_y_up(stream)
    yield stream
    writer.finish()


def turn_y_up(stream: rerun.RecordingStream) -> None:
    """Flip the y axis below /scene: Rerun's 2D views are y-down, so one transform at the root allows y-up data."""
    stream.log("scene", rerun.Transform3D(mat3x3=np.diag([1.0, -1.0, 1.0])), static=True)


def log_ground(stream: rerun.RecordingStream, root: str, painter: ScenePainter) -> None:
    """Write a painter's classes and static lines below `root`."""
    infos = [rerun.AnnotationInfo(k, name, color) for k, (name, color, _) in enumerate(painter.markers)]
    stream.log(root, rerun.AnnotationContext(infos), static=True)
    strips = rerun.LineStrips2D(painter.lines(), colors=line_color_of(painter), radii=0.12, draw_order=-8)
    stream.log(f"{root}/ground", strips, static=True)


def blueprint(views: Any, timeline: str, fps: float, play: PlayState = "Paused") -> Any:
    """Return a blueprint of these views, with collapsed panels and a paused timeline.

    `play` "Following" opens the recording at its end and follows it while it grows.
    """
    return rrb.Blueprint(
        views,
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=timeline, fps=fps, play_state=play),
        auto_views=False,
        auto_layout=False,
    )


def plane_view(bounds: Sequence[float], background: Color, name: str, *paths: str) -> Any:
    """Return a view of these paths within bounds: x low, x high, y low, y high."""
    x_low, x_high, y_low, y_high = bounds
    return rrb.Spatial2DView(
        origin="/",
        contents=paths,
        name=name,
        background=background,
        visual_bounds=rrb.VisualBounds2D(x_range=[x_low, x_high], y_range=[-y_high, -y_low]),
    )


def _overview(painter: ScenePainter, students: Sequence[str], mixed: bool, buffered: bool) -> Any:
    """Return the overview: the map, the level with the highest score, and curves."""
    title = "Levels (color: score) and their density"
    card = rrb.TextDocumentView(origin="/levels/card", name="Level")
    level = rrb.Horizontal(
        _scene(painter, "Level with the highest score", "/scene/levels/0/**"), card, column_shares=[1.25, 1]
    )
    left = rrb.Vertical(_scene(painter, title, "/scene/heat/**", "/scene/batch"), level, row_shares=[1.15, 1])
    return rrb.Horizontal(left, _progress(students, mixed, buffered), column_shares=[1.25, 1], name="Overview")


def _plain(students: Sequence[str]) -> Any:
    """Return the overview of environments without a painter: rendered frames, and the best level as text."""
    films = [rrb.Spatial2DView(origin=f"/film/{name}", name=name.capitalize()) for name in students]
    told = [_episodes(name) for name in students]
    cards = rrb.Horizontal(rrb.TextDocumentView(origin="/levels/card", name="Level with the highest score"), *told)
    left = rrb.Vertical(rrb.Horizontal(*films), cards, row_shares=[1.4, 1])
    return rrb.Horizontal(left, _progress(students), name="Overview")


def _progress(students: Sequence[str], mixed: bool = False, buffered: bool = False) -> Any:
    """Return the views of returns, scores of levels, and θ over updates.

    Curves of training are side by side, since low views have too few ticks.
    """
    curves = [_curves("Return per level (mean ± std)", f"{RETURNS}**", "RightBottom")]
    if len(students) > 1:
        curves.append(_curves("Regret per level (mean ± std)", SCORE, "RightTop"))
    elif buffered:
        curves.append(_curves("Score per level (mean ± std)", SCORE, "RightTop"))
    if mixed:
        curves.append(_curves("Share of the levels by program", f"{PROGRAMS}**", "RightTop"))
    tests = _curves("Return on the test scenes", f"{TESTS}**", "LeftTop")
    return rrb.Vertical(rrb.Horizontal(*curves), tests, _over_time(), row_shares=[2.0, 1.5, 1.6])


def _levels(painter: ScenePainter) -> Any:
    """Return the levels of the highest scores, each with its card beside the scene."""
    views = []
    for slot in range(TOP_LEVELS):
        scene = _scene(painter, f"Level {slot + 1} by score", f"/scene/levels/{slot}/**")
        card = rrb.TextDocumentView(origin=f"/levels/{slot}", name=f"{slot + 1}")
        views.append(rrb.Horizontal(scene, card, column_shares=[2.1, 1]))
    return rrb.Grid(*views, grid_columns=3, name="Levels")


def _rollouts(painter: ScenePainter, students: Sequence[str]) -> Any:
    """Return the recorded episodes of each student; outcomes are beside the scene, or below it for several students."""
    views = []
    for name in students:
        paths = "/scene/ground", f"/scene/rollout/{name}/**"
        scene = plane_view(painter.reach, painter.background, name.capitalize(), *paths)
        if len(students) == 1:
            return rrb.Horizontal(scene, _episodes(name), column_shares=[3.4, 1], name="Rollouts")
        views.append(rrb.Vertical(scene, _episodes(name), row_shares=[2, 1]))
    return rrb.Horizontal(*views, name="Rollouts")


def _episodes(student: str) -> Any:
    return rrb.TextDocumentView(origin=f"/rollouts/{student}", name=f"Episodes of the {student}")


def _theta(names: Sequence[str]) -> Any:
    charts = [
        rrb.BarChartView(
            origin=f"/theta/{rerun.escape_entity_path_part(name)}",
            contents=["$origin/histogram", "$origin/uniform"],
            name=name,
            plot_legend=rrb.PlotLegend(visible=False),
        )
        for name in names
    ]
    columns = 2 if len(charts) <= 8 else 3
    grid = rrb.Grid(*charts, grid_columns=columns)
    return rrb.Horizontal(grid, _over_time(), column_shares=[1, 1.35], name="Theta")


def _teacher(mixed: bool, chosen: bool) -> Any:
    """Return the teacher's views: sources of levels, their spread, and the chosen levels."""
    curves = [
        _curves("Levels of an update by source", SOURCES, "LeftTop"),
        _curves("Entropy of θ in nats: of the adversary, and of all levels", ENTROPIES, "RightTop"),
    ]
    if mixed:
        curves.append(_curves("Share of the levels by program", f"{PROGRAMS}**", "RightTop"))
    if chosen:
        name = "Options: frequency in proposals relative to the program"
        curves.append(_curves(name, f"{CHOICES}**", "RightTop"))
    aim = rrb.TextDocumentView(origin="/teacher/aim", name="Chosen levels of this update")
    events = rrb.TextLogView(origin="/events", name="Events")
    return rrb.Horizontal(rrb.Vertical(*curves), rrb.Vertical(aim, events, row_shares=[1.6, 1]), name="Teacher")


def _buffer() -> Any:
    tree = rrb.Spatial2DView(
        origin="/buffer/tree",
        name="Levels by age and score; lines lead from parents to edited copies (color: number of edits)",
        background=DARK,
        visual_bounds=rrb.VisualBounds2D(x_range=[-50, MAP_WIDTH + 20], y_range=[-8, MAP_HEIGHT + 14]),
    )
    scores, staleness = (
        rrb.BarChartView(origin=f"/buffer/{name}", name=title, plot_legend=rrb.PlotLegend(visible=False))
        for name, title in (("scores", "Scores"), ("staleness", "Levels played since the last visit"))
    )
    curves = _curves("Content", BUFFERED, "LeftTop")
    return rrb.Horizontal(tree, rrb.Vertical(scores, staleness, curves), column_shares=[1.6, 1], name="Buffer")


# ---------------------------------------------------------------- single views


def _scene(painter: ScenePainter, name: str, *paths: str) -> Any:
    return plane_view(painter.bounds, painter.background, name, "/scene/ground", *paths)


def _curves(name: str, paths: str | tuple[str, ...], corner: Corner) -> Any:
    return rrb.TimeSeriesView(
        origin="/",
        contents=[paths] if isinstance(paths, str) else list(paths),
        name=name,
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        plot_legend=rrb.PlotLegend(corner=corner),
    )


def _over_time() -> Any:
    return rrb.Spatial2DView(
        origin="/theta/over_time",
        name="θ over updates (brightness: density)",
        background=DARK,
        visual_bounds=rrb.VisualBounds2D(x_range=[-MAP_LEFT, MAP_WIDTH + 8], y_range=[-5, MAP_HEIGHT + 14]),
    )
