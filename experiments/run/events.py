"""What somebody who watches a run should know, found in the numbers of its updates: a row of events.csv each.

Read next: `run.reporting`, which tells them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

QUIET_UPDATES = 10  # without the end of an episode
NARROW_UPDATES, NARROW = 5, 0.25  # share of the bins of θ that as many random levels would reach
INVALID_UPDATES, INVALID = 3, 0.25  # share of proposals that describe no level
FORGOTTEN = 0.5  # share of what had been gained on a test scene
GAINED = 0.1  # share of a return, of which a gain is more than chance


class Event(NamedTuple):
    """Something that happened: what kind of thing, and a sentence."""

    event: str
    text: str


class Watch:
    """Follows the rows of metrics.csv; an event is told when it begins, and again when it has been over meanwhile.

    It depends on nothing but these rows, so a run that is continued shows it those that are there already.
    """

    def __init__(self) -> None:
        self._lasts: dict[tuple[str, str], int] = {}  # updates for which this has been so
        self._first: dict[str, float] = {}  # return on a test scene, at first and at best
        self._best: dict[str, float] = {}
        self._forgotten: set[str] = set()

    def look(self, row: Mapping[str, float]) -> list[Event]:
        """Return what begins with this row."""
        lasts = {}
        events = list(self._forgetting(row))
        for event, about, updates, text in _signs(row):
            lasts[event, about] = self._lasts.get((event, about), 0) + 1
            if lasts[event, about] == updates:
                events.append(Event(event, text))
        self._lasts = lasts
        return events

    def _forgetting(self, row: Mapping[str, float]) -> Iterator[Event]:
        """Yield the test scenes, if they were played, on which most of what had been gained is lost."""
        for name, value in row.items():
            if not name.startswith("eval/") or value != value:
                continue
            first = self._first.setdefault(name, value)
            best = self._best[name] = max(value, self._best.get(name, value))
            gained = best - first
            lost = gained > GAINED * max(abs(best), abs(first)) and best - value > FORGOTTEN * gained
            if lost and name not in self._forgotten:
                yield Event("forgetting", f"return on {name[5:]}: {value:.2f}, after {best:.2f} at best")
            (self._forgotten.add if lost else self._forgotten.discard)(name)


def _signs(row: Mapping[str, float]) -> Iterator[tuple[str, str, int, str]]:
    """Yield what is so in an update: event, what it is about, for how many updates it must be so, a sentence."""
    for name, value in row.items():
        if name.startswith("episodes/") and value == 0:
            student = name.partition("/")[2]
            text = f"no episode of {student} has ended in {QUIET_UPDATES} updates: is there a limit of steps?"
            yield "no episode", student, QUIET_UPDATES, text
    coverage = row.get("theta_coverage", 1.0)
    if coverage < NARROW:
        text = f"levels cover {coverage:.0%} of what as many random ones would, for {NARROW_UPDATES} updates"
        yield "collapse", "", NARROW_UPDATES, text
    replaced = row.get("levels/replaced", 0.0)
    share = replaced / max(replaced + row.get("levels/proposed", 0.0), 1.0)
    if share > INVALID:
        text = f"{share:.0%} of the proposals describe no valid level; random ones were played in their place"
        yield "invalid proposals", "", INVALID_UPDATES, text
