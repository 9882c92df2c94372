"""Progress of an evaluation: finished episodes and remaining time, shown for long evaluations.

Read next: `run.evaluator`.
"""

from __future__ import annotations

import sys
import time

from regista.experiments.run.progress import Progress, counted, duration

PATIENCE_SECONDS = 3.0  # before progress is shown


class Watch:
    """Counts finished episodes, and shows their number and the remaining time on stderr.

    Args:
        total: maximum number of episodes.
        seconds: time limit after which no new episodes start; None: no limit.
        unit: noun for the counted items.
    """

    def __init__(self, total: int, seconds: float | None = None, unit: str = "episode") -> None:
        self.unit = unit
        self.total, self.most, self.done, self.seconds = total, total, 0, seconds
        self._began = time.monotonic()
        self._progress: Progress | None = None

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._began

    def ended(self, count: int) -> None:
        """Add a number of finished episodes."""
        self.done += count
        if self.seconds is not None:  # the total is the number that fits into the time limit
            self.total = min(self.most, max(self.done, int(self.seconds * self.done / max(self.spent, 1e-9))))
        if self.spent < PATIENCE_SECONDS:
            return
        if self._progress is None:
            self._progress = Progress(self.total, stream=sys.stderr, unit=f"{self.unit}s")
        self._progress.total = self.total
        self._progress.show(self.done)

    def go_on(self, count: int) -> bool:
        """Add a batch of finished episodes; return whether there is time for another batch."""
        self.ended(count)
        if self.seconds is None or self.spent * (1 + count / self.done) <= self.seconds:
            return True
        self.finish()
        return False

    def finish(self) -> None:
        """Print the number of episodes if progress was shown."""
        if self._progress is not None:
            self._progress.finish(f"{counted(self.done, self.unit)}, {duration(self.spent)}")
