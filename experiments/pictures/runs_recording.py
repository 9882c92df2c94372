"""Several runs in one Rerun recording: every column of their metrics.csv, side by side.

Read next: `ued.recorder.recorder`, the recording of one run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun
import rerun.blueprint as rrb
from matplotlib.colors import to_rgb

from regista.experiments.pictures.plots import color
from regista.experiments.run.table import read_columns
from ued.recorder import layout

SHOWN = ("return_100", "success", "score", "regret", "theta_entropy", "theta_coverage")  # besides test scenes


def record_runs(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Write `/metrics/<metric>/<method>-<k>` of all runs to a recording, with one color per method."""
    tables = {
        (method, f"{method}-{k}"): read_columns(run / "metrics.csv")
        for method, paths in runs.items()
        for k, run in enumerate(paths)
    }
    names = list(dict.fromkeys(name for table in tables.values() for name in table))
    shown = [name for name in names if name.startswith("eval/") or name.partition("/")[0] in SHOWN]
    views = rrb.Grid(*(_view(name) for name in shown), name="All runs")
    with layout.recording(
        path, "regista_runs", str(path.resolve()), layout.blueprint(views, "env_steps", 30)
    ) as stream:
        for (method, label), table in tables.items():
            shade = np.array([255 * part for part in to_rgb(color(method))], np.uint8)
            for name in [name for name in table if name not in ("update", "env_steps")]:
                place = rerun.new_entity_path(["metrics", *name.split("/"), label])
                stream.log(place, rerun.SeriesLines(colors=[shade], names=[label], widths=[1.5]), static=True)
                _send(stream, place, table, name)


def _send(stream: rerun.RecordingStream, place: str, table: Mapping[str, np.ndarray], name: str) -> None:
    known = np.isfinite(table[name])
    times = [rerun.TimeColumn(axis, sequence=table[axis][known].astype(np.int64)) for axis in ("env_steps", "update")]
    stream.send_columns(place, times, rerun.Scalars.columns(scalars=table[name][known]))


def _view(name: str) -> Any:
    origin = rerun.new_entity_path(["metrics", *name.split("/")])
    return rrb.TimeSeriesView(origin=origin, contents=["$origin/**"], name=name)
