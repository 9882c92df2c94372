"""Recordings of environments without a painter: their rendered frames, as a film.

Read next: `recorder.scene_log`, which draws where there is a painter.
"""

from __future__ import annotations

import numpy as np
import rerun

from ued.levels.batch import LevelBatch
from ued.recorder.scene_log import Episodes

MOST_FRAMES = 100  # of an episode; of longer ones every second, third ... is kept
QUALITY = 80  # of JPEG


class FilmLog:
    """Writes `/film/<student>` of a recording in the place of `/scene/...`."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self.stream = stream

    def open(self) -> None:
        """Do nothing: there is nothing that never changes."""

    def note(self, theta: np.ndarray) -> None:
        """Do nothing: without a painter, θ says where levels are."""

    def record(self, batch: LevelBatch) -> None:
        """Do nothing: likewise."""

    def record_path(self, student: str, episodes: Episodes) -> None:
        """Write how episodes began, and what came of them."""
        if len(episodes.positions):
            self.stream.log(f"film/{student}", rerun.Image(episodes.positions[0]).compress(QUALITY))
        self.stream.log(f"film_outcome/{student}", rerun.TextDocument(episodes.outcome))

    def record_movie(self, student: str, began: float, episodes: Episodes) -> None:
        """Write the frames of episodes on `movie` alone, from second `began`."""
        every = -(-len(episodes.positions) // MOST_FRAMES) or 1
        for step in range(0, len(episodes.positions), every):
            self.stream.reset_time()
            self.stream.set_time("movie", duration=began + step * episodes.step_seconds)
            self.stream.log(f"film/{student}", rerun.Image(episodes.positions[step]).compress(QUALITY))
