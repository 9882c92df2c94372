"""Cells of the tables of studies: estimates with their intervals, and numbers of runs.

Read next: `lab/studies/tables.py` and `lab/studies/goals.py`, which make tables of them.
"""

from __future__ import annotations

from collections.abc import Sequence

from lab.studies.rows import Row
from regista.experiments.run.progress import count
from regista.experiments.run.results import unique
from ued.statistics import Interval


def runs_and_steps(rows: Sequence[Row]) -> list[str]:
    """Return the number of runs among the rows of an agent, and their numbers of training steps."""
    steps = unique([count(env_steps) for env_steps in sorted({row.env_steps for row in rows})])
    return [str(len({row.seed for row in rows})), " to ".join(steps)]


def percent(interval: Interval) -> str:
    """Return a share with its interval, in percent."""
    return spell(Interval(*(100 * value for value in interval)), "{:.0f}", "%")


def spell(interval: Interval, form: str, unit: str = "") -> str:
    """Return an estimate with its interval, if it has one."""
    middle, low, high = (form.format(value) for value in interval)
    return f"{middle}{unit} [{low}, {high}]" if interval.known else f"{middle}{unit}"
