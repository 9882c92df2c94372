"""What a recording shows of environments that nobody has written a painter for: what they render, as a film.

Read next: `recorder.scene_log`, which draws where there is a painter.
"""

from __future__ import annotations

import numpy as np
import rerun

from ued.levels.batch import LevelBatch
from ued.recorder.scene_log import Episode

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

    def record_path(self, student: str, episode: Episode) -> None:
        """Write how an episode began, and what came of it."""
        if len(episode.positions):
            self.stream.log(f"film/{student}", rerun.Image(episode.positions[0]).compress(QUALITY))
        self.stream.log(f"film_outcome/{student}", rerun.TextDocument(episode.outcome))

    def record_movie(self, student: str, began: float, episode: Episode) -> None:
        """Write the frames of an episode on `movie` alone, from second `began`."""
        every = -(-len(episode.positions) // MOST_FRAMES) or 1
        for step in range(0, len(episode.positions), every):
            self.stream.reset_time()
            self.stream.set_time("movie", duration=began + step * episode.step_seconds)
            self.stream.log(f"film/{student}", rerun.Image(episode.positions[step]).compress(QUALITY))
