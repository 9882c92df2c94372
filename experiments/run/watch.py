"""How far an evaluation is: episodes that have ended and the time that is left, once that is worth a line.

Read next: `run.evaluator`.
"""

from __future__ import annotations

import sys
import time

from regista.experiments.run.progress import Progress, duration

PATIENCE_SECONDS = 3.0  # after which progress is shown


class Watch:
    """Counts the episodes that end, and shows on stderr how many they are and what remains.

    Args:
        total: how many there will be, at most.
        seconds: after which no more should begin, so that fewer may be played; None: all are.
    """

    def __init__(self, total: int, seconds: float | None = None) -> None:
        self.total, self.most, self.done, self.seconds = total, total, 0, seconds
        self._began = time.monotonic()
        self._progress: Progress | None = None

    @property
    def spent(self) -> float:
        """Seconds since it began."""
        return time.monotonic() - self._began

    def ended(self, count: int) -> None:
        """Note that so many episodes have ended."""
        self.done += count
        if self.seconds is not None:  # as many as fit, at this pace
            self.total = min(self.most, max(self.done, int(self.seconds * self.done / max(self.spent, 1e-9))))
        if self.spent < PATIENCE_SECONDS:
            return
        if self._progress is None:
            self._progress = Progress(self.total, stream=sys.stderr, unit="episodes")
        self._progress.total = self.total
        self._progress.show(self.done)

    def go_on(self, count: int) -> bool:
        """Note that a batch of so many episodes has ended; return whether there is time for another."""
        self.ended(count)
        if self.seconds is None or self.spent * (1 + count / self.done) <= self.seconds:
            return True
        self.finish()
        return False

    def finish(self) -> None:
        """Leave the number of episodes, where a line was shown."""
        if self._progress is not None:
            self._progress.finish(f"{self.done:_} episodes, {duration(self.spent)}")
