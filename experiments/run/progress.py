"""Progress of a run: a line that is updated on a terminal, and occasional lines otherwise.

Read next: `commands.train`.
"""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Mapping
from typing import TextIO

PLAIN_SECONDS = 15.0  # between lines if the output is not a terminal
REDRAW_SECONDS = 0.1
BAR = 24  # characters


class Progress:
    """Shows the completed share, the speed, the remaining time and a few metrics.

    `begun` steps were done in earlier calls. The clock starts with the first new steps, so one-time work such as
    compilation does not count.
    """

    def __init__(self, total: int, begun: int = 0, stream: TextIO | None = None, unit: str = "steps") -> None:
        self.total, self.unit = total, unit
        self.stream = sys.stdout if stream is None else stream
        self.tty = self.stream.isatty()
        self._begun = begun
        self._start: float | None = None  # None before the first new steps
        self._shown = -PLAIN_SECONDS

    def show(self, steps: int, facts: dict[str, float] | None = None) -> None:
        """Show `steps` of the total with named metrics. Most calls are cheap and draw nothing."""
        now = time.monotonic()
        if self._start is None and steps > self._begun:
            self._start, self._begun = now, steps
        if now - self._shown < (REDRAW_SECONDS if self.tty else PLAIN_SECONDS):
            return
        self._shown = now
        self._write(self._line(steps, facts or {}, now))

    def say(self, text: str) -> None:
        """Print a line in place of the progress line, which is redrawn below it."""
        if self.tty:
            self.stream.write("\r\x1b[K")
        self._shown = -PLAIN_SECONDS if self.tty else self._shown
        print(text, file=self.stream, flush=True)

    finish = say  # the last line

    def _line(self, steps: int, facts: dict[str, float], now: float) -> str:
        speed = 0.0 if self._start is None else (steps - self._begun) / max(now - self._start, 1e-9)
        share = min(steps / self.total, 1.0)
        unit = self.unit if steps != 1 else self.unit.removesuffix("s")
        parts = [f"{share:4.0%}  {count(steps)} {unit}", *([f"{count(speed)}/s"] if speed else [])]
        parts += [f"{name} {value:+.2f}" for name, value in facts.items() if value == value]
        if speed > 0 and (left := (self.total - steps) / speed) >= 1:
            parts.append(f"{duration(left)} left")
        done = round(share * BAR)
        bar = "━" * done + "╌" * (BAR - done) + " " if self.tty else ""
        return bar + "  ".join(parts)

    def _write(self, line: str) -> None:
        if self.tty:
            width = shutil.get_terminal_size().columns
            self.stream.write(f"\r\x1b[K{line[: width - 1]}")
        else:
            self.stream.write(line + "\n")
        self.stream.flush()


def headline(metrics: Mapping[str, float]) -> dict[str, float]:
    """Return the metrics of an update for the progress line."""
    return {
        name.partition("/")[2] or name: value
        for name, value in metrics.items()
        if name.startswith("return_100/") or name == "regret"
    }


def count(number: float) -> str:
    """Format a number briefly: 950, 12.3k, 4.56M."""
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= size:
            return f"{number / size:.3g}{letter}"
    return f"{number:.0f}"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: 1 level, 1_000 levels."""
    return f"{number:_} {noun}{'s' * (number != 1)}"


def terminal_width() -> int | None:
    """Return the columns of the terminal; None if stdout is a file or a pipe."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def duration(seconds: float) -> str:
    """Format a duration briefly: 42 s, 3 min, 1 h 05."""
    seconds = max(seconds, 0.0)
    if seconds < 100:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds // 3600:.0f} h {seconds % 3600 // 60:02.0f}"
