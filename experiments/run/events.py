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
MEMORY = 0.95  # of the averages of options, per update
NEGLECT_UPDATES, HIGH, SELDOM = 30, 1.5, 0.8  # score over the mean of the options; proposals over the program's weight


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
        self._options = Averages()

    def look(self, row: Mapping[str, float]) -> list[Event]:
        """Return what begins with this row."""
        lasts = {}
        events = list(self._forgetting(row))
        for event, about, updates, text in (*_signs(row), *self._neglect(row)):
            lasts[event, about] = self._lasts.get((event, about), 0) + 1
            if lasts[event, about] == updates:
                events.append(Event(event, text))
        self._lasts = lasts
        return events

    def _neglect(self, row: Mapping[str, float]) -> Iterator[tuple[str, str, int, str]]:
        """Yield the options that score high, and that the adversary proposes less often than the program draws them."""
        options = [name.partition("/")[2] for name in row if name.startswith("choice_ratio/")]
        for name in options:
            self._options.add(name, row[f"choice_ratio/{name}"], row.get(f"choice_score/{name}", float("nan")))
        for name in options:
            column = name.rpartition("/")[0]
            scores = [self._options.score[other] for other in options if other.rpartition("/")[0] == column]
            mean, score, ratio = sum(scores) / len(scores), self._options.score[name], self._options.ratio[name]
            if score > HIGH * mean > 0 and ratio < SELDOM:
                text = f"{name} scores {score:.2f}, the mean option {mean:.2f}"
                text += f", but is proposed {ratio:.2f} times as often as random levels have it"
                yield "neglected option", name, NEGLECT_UPDATES, text

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


class Averages:
    """Decaying averages over updates, by option: how often it is proposed for its weight, and what it scores."""

    def __init__(self) -> None:
        self.ratio: dict[str, float] = {}
        self.score: dict[str, float] = {}

    def add(self, name: str, ratio: float, score: float) -> None:
        """Take in an update; nan: nothing was proposed, or nothing scored."""
        for averages, value, first in ((self.ratio, ratio, 1.0), (self.score, score, 0.0)):
            before = averages.setdefault(name, value if value == value else first)
            if value == value:
                averages[name] = MEMORY * before + (1 - MEMORY) * value


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
