"""Warnings about a training run, detected in the metrics of its updates: one row of events.csv each.

Read next: `run.reporting`, which reports them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from regista.experiments.run.progress import count, counted

QUIET_UPDATES = 10  # updates in which no episode ends
NARROW_UPDATES, NARROW = 5, 0.25  # bins of θ covered by levels, relative to as many random levels
INVALID_UPDATES, INVALID = 3, 0.25  # share of invalid proposals
FORGOTTEN = 0.5  # lost share of the improvement on a test scene
GAINED = 0.1  # minimum improvement relative to the return
STEPS = "/gradient_steps"
TEACHER = "adversary"
SELDOM = {TEACHER: 0.05}  # minimum share of updates with gradient steps
SELDOM_STUDENT = 0.5
MEMORY = 0.95  # decay of the averages over options, per update
NEGLECT_UPDATES = 30
HIGH, NEGLECTED = 1.5, 0.8  # score relative to the mean of the options; proposals relative to the program's weight


class Event(NamedTuple):
    """A warning: its kind and a sentence."""

    event: str
    text: str


class Estimate(NamedTuple):
    """A mean return on a test scene, with the ends of its 95% interval."""

    value: float
    low: float
    high: float


class Watch:
    """Monitors the rows of metrics.csv and reports each event when it starts; an event can recur after its end.

    Events depend only on these rows, so a resumed run first passes the existing rows to `look`.

    Args:
        total: env_steps of the run; None: unknown.
        limit: maximum length of an episode in steps; None: unknown.
    """

    def __init__(self, total: int | None = None, limit: int | None = None) -> None:
        self.limit, self.learning = limit, Learning(total)
        self._lasts: dict[tuple[str, str], int] = {}  # number of consecutive updates with a sign
        self._first: dict[str, float] = {}  # first return on a test scene
        self._best: dict[str, Estimate] = {}
        self._forgotten: set[str] = set()
        self._options = Averages()

    def look(self, row: Mapping[str, float]) -> list[Event]:
        """Return the events that start with this row."""
        lasts = {}
        events = list(self._forgetting(row))
        for event, about, updates, text in (*_signs(row, self.limit), *self._neglect(row)):
            lasts[event, about] = self._lasts.get((event, about), 0) + 1
            if lasts[event, about] == updates:
                events.append(Event(event, text))
        self._lasts = lasts
        return events + self.learning.look(row)

    def _neglect(self, row: Mapping[str, float]) -> Iterator[tuple[str, str, int, str]]:
        """Yield options with high scores that the adversary proposes less often than the program samples them."""
        options = [name.partition("/")[2] for name in row if name.startswith("choice_ratio/")]
        for name in options:
            self._options.add(name, row[f"choice_ratio/{name}"], row.get(f"choice_score/{name}", float("nan")))
        for name in options:
            column = name.rpartition("/")[0]
            scores = [self._options.score[other] for other in options if other.rpartition("/")[0] == column]
            mean, score, ratio = sum(scores) / len(scores), self._options.score[name], self._options.ratio[name]
            if score > HIGH * mean > 0 and ratio < NEGLECTED:
                text = f"{name} has a score of {score:.2f}, the mean option {mean:.2f}"
                text += f", but is proposed {ratio:.2f} times as often as in random levels"
                yield "neglected option", name, NEGLECT_UPDATES, text

    def _forgetting(self, row: Mapping[str, float]) -> Iterator[Event]:
        """Yield the evaluated test scenes on which most of the improvement is lost.

        The intervals of the two returns must be disjoint.
        """
        for name, value in row.items():
            if not name.startswith("eval/") or value != value:
                continue
            scene = name.removeprefix("eval/")
            now = Estimate(value, *(row.get(f"eval_{end}/{scene}", math.nan) for end in ("low", "high")))
            first = self._first.setdefault(name, value)
            best = self._best[name] = max(now, self._best.get(name, now), key=lambda estimate: estimate.value)
            gained = best.value - first
            fell = gained > GAINED * max(abs(best.value), abs(first)) and best.value - value > FORGOTTEN * gained
            lost = fell and now.high < best.low
            if lost and name not in self._forgotten:
                yield Event("forgetting", f"return on {scene}: {_spelled(now)}, after {_spelled(best)} at best")
            (self._forgotten.add if lost else self._forgotten.discard)(name)


class Learning:
    """Counts the updates in which each student and teacher took gradient steps, and reports low counts."""

    def __init__(self, total: int | None = None) -> None:
        self.total = total
        self.updates: dict[str, int] = {}
        self.learned: dict[str, int] = {}
        self._done = 0.0  # env_steps of the last row

    def look(self, row: Mapping[str, float]) -> list[Event]:
        """Count a row; report networks without gradient steps at half of the run, and with few at its end."""
        for column, steps in row.items():
            if column.endswith(STEPS) and steps == steps:
                name = column.removesuffix(STEPS)
                self.updates[name] = self.updates.get(name, 0) + 1
                self.learned[name] = self.learned.get(name, 0) + (steps > 0)
        before, self._done = self._done, row.get("env_steps", self._done)
        if self.total is None:
            return []
        if before < self.total <= self._done:
            return list(self.seldom())
        if before < self.total / 2 <= self._done:
            return [event for event in self.seldom() if event.event == "no learning"]
        return []

    def seldom(self) -> Iterator[Event]:
        """Yield an event for each network that took gradient steps in few or no updates so far."""
        for name, updates in self.updates.items():
            share, seen = self.learned[name] / updates, counted(updates, "update")
            if not share:
                text = f"{name} has taken no gradient step in {seen} ({count(self._done)} env_steps)"
                yield Event("no learning", text)
            elif share < SELDOM.get(name, SELDOM_STUDENT):
                text = f"{name} has taken gradient steps in only {self.learned[name]} of {seen} ({share:.0%})"
                yield Event("little learning", text)


class Averages:
    """Decaying averages over updates, by option: proposals relative to the program's weight, and scores."""

    def __init__(self) -> None:
        self.ratio: dict[str, float] = {}
        self.score: dict[str, float] = {}

    def add(self, name: str, ratio: float, score: float) -> None:
        """Add an update; nan: no proposals or scores."""
        for averages, value, first in ((self.ratio, ratio, 1.0), (self.score, score, 0.0)):
            before = averages.setdefault(name, value if value == value else first)
            if value == value:
                averages[name] = MEMORY * before + (1 - MEMORY) * value


def _signs(row: Mapping[str, float], limit: int | None) -> Iterator[tuple[str, str, int, str]]:
    """Yield the signs in an update: event, subject, required number of consecutive updates, sentence."""
    for name, value in row.items():
        if name.startswith("episodes/") and value == 0:
            student = name.partition("/")[2]
            text = f"no episode of {student} has ended in {QUIET_UPDATES} updates"
            yield "no episode", student, QUIET_UPDATES, text + _open_episode(row.get(f"open/{student}"), limit)
    coverage = row.get("theta_coverage", 1.0)
    if coverage < NARROW:
        text = f"levels cover {coverage:.0%} of the bins of as many random levels, for {NARROW_UPDATES} updates"
        yield "collapse", "", NARROW_UPDATES, text
    replaced = row.get("levels/replaced", 0.0)
    share = replaced / max(replaced + row.get("levels/proposed", 0.0), 1.0)
    if share > INVALID:
        text = f"{share:.0%} of the proposals are invalid levels; random levels replace them"
        yield "invalid proposals", "", INVALID_UPDATES, text


def _open_episode(steps: float | None, limit: int | None) -> str:
    """Return the length of the longest open episode and the limit, as the end of a sentence."""
    known = f"the limit is {limit:_}" if limit else "the environment declares no limit"
    return (
        f"; {known}"
        if not steps or steps != steps
        else f"; the longest open one has {counted(round(steps), 'step')} so far, {known}"
    )


def _spelled(estimate: Estimate) -> str:
    return f"{estimate.value:.2f} [{estimate.low:.2f}, {estimate.high:.2f}]"
