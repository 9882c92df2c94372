"""Recordings of environments without a painter: their rendered frames, as a video.

Read next: `recorder.scene_log`, for environments with a painter.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun

from ued.levels.batch import LevelBatch
from ued.recorder.scene_log import Episodes

MOST_FRAMES = 100  # per episode; longer episodes are subsampled
QUALITY = 80  # of JPEG


class FilmLog:
    """Writes `/film/<student>` and `/rollouts/<student>` of a recording instead of `/scene/...`."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self.stream = stream

    def open(self, students: Sequence[str]) -> None:
        """Write the static content: the type of texts."""
        for student in students:
            markdown = rerun.TextDocument.from_fields(media_type=rerun.MediaType.MARKDOWN)
            self.stream.log(f"rollouts/{student}", markdown, static=True)

    def note(self, theta: np.ndarray) -> None:
        """Do nothing: without a painter, only θ locates levels."""

    def record(self, batch: LevelBatch) -> None:
        """Do nothing: without a painter, levels have no pictures."""

    def record_path(self, student: str, episodes: Episodes) -> None:
        """Write the first frame of the recorded episodes, and their outcome."""
        if len(episodes.positions):
            self.stream.log(f"film/{student}", rerun.Image(episodes.positions[0]).compress(QUALITY))
        self.stream.log(f"rollouts/{student}", rerun.TextDocument.from_fields(text=episodes.card()))

    def record_movie(self, student: str, began: float, episodes: Episodes) -> None:
        """Write the frames of episodes on timeline `movie` only, starting at second `began`."""
        every = -(-len(episodes.positions) // MOST_FRAMES) or 1
        for step in range(0, len(episodes.positions), every):
            self.stream.reset_time()
            self.stream.set_time("movie", duration=began + step * episodes.step_seconds)
            self.stream.log(f"film/{student}", rerun.Image(episodes.positions[step]).compress(QUALITY))
