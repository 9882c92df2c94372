"""Level buffer in a recording: scores, staleness, and ancestry of levels.

Read next: `levels.buffer`, the buffer itself.
"""

from __future__ import annotations

import numpy as np
import rerun

from ued.levels.buffer import LevelBuffer
from ued.recorder.layout import MAP_HEIGHT, MAP_WIDTH
from ued.recorder.shades import CALM_TO_RED, ramp
from ued.recorder.theta_log import bars_between

BINS = 24
EVERY = 10  # updates between two records
MOST_LEVELS = 2_000  # maximum number of levels in the tree; those with the highest scores are shown


class BufferLog:
    """Writes `/buffer/...` of a recording."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self.stream = stream

    def record(self, buffer: LevelBuffer) -> None:
        """Write the current content of a buffer."""
        slots = buffer.slots
        if not len(slots):
            return
        self._histogram("scores", slots["score"], (255, 112, 67))
        self._histogram("staleness", (buffer.now - slots["last_played"]).astype(float), (130, 200, 255))
        slots = slots[np.argsort(-slots["score"], kind="stable")[:MOST_LEVELS]]
        low, high = float(slots["score"].min()), float(slots["score"].max())
        x = slots["created"] / max(buffer.now, 1) * MAP_WIDTH
        y = MAP_HEIGHT * (1 - (slots["score"] - low) / max(high - low, 1e-9))
        places, generation = np.stack([x, y], 1), slots["generation"]
        labels = [
            f"level {row['id']}, score {row['score']:.2f}, {row['generation']} edits, {row['num_replays']} replays"
            for row in slots
        ]
        shades = ramp(generation / max(generation.max(), 1), CALM_TO_RED)
        points = rerun.Points2D(places, colors=shades, radii=1.0, labels=labels, show_labels=False)
        self.stream.log("buffer/tree/levels", points)
        order = np.argsort(slots["id"])
        parent = order[np.minimum(np.searchsorted(slots["id"], slots["parent"], sorter=order), len(slots) - 1)]
        child = np.flatnonzero(slots["id"][parent] == slots["parent"])
        lines = rerun.LineStrips2D(
            np.stack([places[parent[child]], places[child]], 1), colors=(150, 150, 150, 120), radii=0.15, draw_order=-1
        )
        self.stream.log("buffer/tree/descent", lines)
        texts = [f"score {high:.2f}", f"score {low:.2f}", "in the buffer since level 0", f"level {buffer.now}"]
        ends = np.array([[-26, 0], [-26, MAP_HEIGHT], [30, MAP_HEIGHT + 8], [MAP_WIDTH - 8, MAP_HEIGHT + 8]])
        axis = rerun.Points2D(ends, labels=texts, radii=0.001, colors=(205, 210, 215), show_labels=True)
        self.stream.log("buffer/tree/axis", axis)

    def _histogram(self, name: str, values: np.ndarray, color: tuple[int, int, int]) -> None:
        counts, edges = np.histogram(values, bins=BINS)
        chart = rerun.BarChart(counts.astype(float), color=color, **bars_between(edges, 0.92))
        self.stream.log(f"buffer/{name}", chart)
