"""The levels of a run as one offline HTML page: a map, and for each point a card, a scene and a replay.

The template is gallery.html next to this file; the run's data are inserted. Read next: `run.replays`.
"""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run import build
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import Game
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.replays import Replay, Stage, came_out_alike
from regista.experiments.run.table import cannot_write, read_rows
from regista.experiments.run.watch import Watch
from ued.core.files import write_whole
from ued.core.painter import ScenePainter, line_color_of, tiles_of, trails_of
from ued.core.parameters import axis_of, cells_in
from ued.recorder.shades import SOURCE_COLORS, student_color, unique_names

PAGE = Path(__file__).with_name("gallery.html")
PLACE = "/*DATA*/null"  # placeholder of the data in the template
MOST_COLUMNS = 40  # of θ on the page
NOWHERE = -(2**15)  # marks a missing position
MOST_IMAGES = 40  # rendered images per episode
IMAGE_WIDTH = 240  # maximum, in pixels
PLAIN = ("update", "id", "visit", "parent", "seed", "episodes")


@dataclass(frozen=True)
class Made:
    """Counts of a page: `levels` shown, levels `played`, levels with `replays`; `otherwise`: replays that differ."""

    levels: int
    played: int
    replays: int
    otherwise: int


def make_page(run: RunFolder, game: Game, path: Path, most_levels: int, most_replays: int) -> Made:
    """Write the page of a run. Raises `CommandError` for damaged or old tables, or if it cannot be written."""
    config, task = run.config, game.task(run.config)
    env = build.make_upomdp(task.make, 1, config.seed)
    stage = Stage(env, task.painter(env) if task.painter else None)
    rows = read_rows(run.replays.path)
    shown = _spread(list(dict.fromkeys(row["visit"] for row in rows)), most_replays)
    replays, otherwise = _replays(stage, rows, set(shown))
    columns = read_levels(run.path)
    sources = columns.get("source", np.zeros(0, str)).tolist()
    played = len(sources)
    if not played:
        raise CommandError(f"{run.path} has no level on which every student finished an episode; train it longer")
    if not {*PLAIN, "score"} <= columns.keys():
        raise CommandError(f"{run.levels.path} has missing columns: it is damaged or of an older version")
    with_replay = [index for index, visit in enumerate(columns["visit"].astype(int)) if str(visit) in replays]
    chosen = sorted({*_spread(range(played), most_levels), *with_replay})
    data = {
        "title": f"{game.short}, {config.method}, seed {config.seed}",
        "levels": _levels(stage, columns, [sources[index] for index in chosen], np.array(chosen, int)),
        "axes": {name: _axis(draw, name) for draw, name in _drawn(stage)},
        "sources": SOURCE_COLORS,
        "students": {name: student_color(index) for index, name in enumerate(_students(columns))},
        "scene": _scene(stage),
        "replays": replays,
        "seconds": stage.step_seconds,
    }
    text = PAGE.read_text().replace(PLACE, json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"))
    try:
        write_whole(path, text)
    except OSError as error:
        raise cannot_write(path, error) from error
    return Made(len(chosen), played, len(replays), otherwise)


def _spread(items: Sequence[Any], most: int) -> list[Any]:
    """Return at most this many elements, evenly spaced, including the first and the last."""
    if len(items) <= most:
        return list(items)
    return [items[index] for index in np.linspace(0, len(items) - 1, most).round().astype(int)] if most else []


def _drawn(stage: Stage) -> list[tuple[Any, str]]:
    return list(zip(stage.env.parameters, unique_names(stage.env.parameters), strict=True))[:MOST_COLUMNS]


def _axis(draw: Any, name: str) -> dict[str, Any]:
    """Return the label of a column, its values at θ = -1 and 1, and its cells if it has finitely many values."""
    axis, cells = axis_of(draw), cells_in(draw)
    finite = bool(np.isfinite((axis.low, axis.high)).all())
    low, high = (float(axis.low), float(axis.high)) if finite else (-1.0, 1.0)
    told = {"name": axis.note.format(name), "low": low, "high": high}
    if cells is not None and finite:
        told |= {"count": cells.count, "edges": [] if cells.edges is None else cells.edges[1:-1].tolist()}
    return told


def _students(columns: Mapping[str, Any]) -> list[str]:
    return [name.partition("/")[2] for name in columns if name.startswith("return/")]


def _levels(stage: Stage, columns: Mapping[str, np.ndarray], sources: list[str], chosen: np.ndarray) -> dict[str, Any]:
    """Return the columns of the table of levels for the `chosen` levels, and the positions in their scenes."""
    names = [name for _, name in _drawn(stage)]
    told: dict[str, Any] = {name: _plain(columns[name][chosen]) for name in PLAIN if name in columns}
    told |= {"score": _plain(columns["score"][chosen]), "source": sources}
    for kind in ("return", "best", "success"):
        told[kind] = {name: _plain(columns[f"{kind}/{name}"][chosen]) for name in _students(columns)}
    every = [name for name in columns if name.startswith("theta/")]
    theta = np.stack([columns[name][chosen] for name in every], 1) if every else np.zeros((len(chosen), 0))
    whole = [cells_in(draw) is not None for draw, _ in _drawn(stage)]  # rounding could change the value
    told["theta"] = {name: theta[:, d].tolist() if whole[d] else _plain(theta[:, d]) for d, name in enumerate(names)}
    if stage.painter is not None:
        told["places"] = _pack(stage.painter.positions(np.clip(theta, -1, 1)), _unit(stage.painter))
    return told


def _plain(values: np.ndarray) -> list[float | None]:
    return [None if value != value else round(value, 4) for value in values.tolist()]


def _scene(stage: Stage) -> dict[str, Any] | None:
    """Return the static parts of the scenes, None without a painter."""
    painter = stage.painter
    if painter is None:
        return None
    return {
        "bounds": painter.bounds,
        "reach": painter.reach,
        "unit": _unit(painter),
        "background": painter.background,
        "line": line_color_of(painter),
        "lines": [np.round(strip, 4).tolist() for strip in painter.lines()],
        "markers": [painter.markers[index] for index in painter.classes],
        "tiles": tiles_of(painter).tolist(),
        "trails": trails_of(painter).tolist(),
        "focus": painter.focus,
    }


def _replays(stage: Stage, rows: list[dict[str, str]], shown: set[str]) -> tuple[dict[str, Any], int]:
    """Replay levels; return their frames by visit and student, and the number of replays that differ."""
    told: dict[str, Any] = {}
    otherwise = 0
    chosen = [row for row in rows if row["visit"] in shown]
    watch = Watch(len(chosen), unit="replay")
    for row in chosen:
        replay = Replay.of_row(row, stage.env)
        played = stage.play(replay)
        frames, alike = played.frames, came_out_alike(replay, played.returns)
        otherwise += not alike
        if stage.painter is not None:
            film: Any = _pack(np.array(frames), _unit(stage.painter))
        else:
            film = [_image(frame) for frame in _spread(frames, MOST_IMAGES)]
        said = {"returns": _plain(replay.returns), "alike": alike, "film": film, "frames": len(frames)}
        said["begins"] = played.begins
        told.setdefault(str(replay.visit), {})[replay.student] = said
        watch.ended(1)
    watch.finish()
    return told, otherwise


def _unit(painter: ScenePainter) -> float:
    """Return the resolution of positions in meters; int16 multiples of it cover twice the size of the scene."""
    return float(f"{2 * np.abs([*painter.bounds, *painter.reach]).max() / -NOWHERE:.3g}") or 1.0


def _pack(places: np.ndarray, unit: float) -> str:
    """Return positions in meters, or nan, as base64 of int16 multiples of `unit`."""
    whole = np.round(np.nan_to_num(places / unit, nan=NOWHERE))
    return base64.b64encode(np.clip(whole, NOWHERE, -NOWHERE - 1).astype("<i2").tobytes()).decode()


def _image(pixels: np.ndarray) -> str:
    """Return an image uint8 `[height, width, 3]` as a data URL."""
    from PIL import Image

    image = Image.fromarray(pixels)
    image.thumbnail((IMAGE_WIDTH, IMAGE_WIDTH))
    with io.BytesIO() as file:
        image.save(file, "JPEG", quality=75)
        return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()
