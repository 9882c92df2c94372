"""Results of evaluations as rows, and what can be said of them: means with intervals, tables, CSV.

A row is one policy on one scene. Several runs of a method are several rows; their interval resamples whole runs, since
one trained policy is tested on all scenes. A single run's interval is over its episodes. Read next: `evaluate`.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from experiments.table import cannot_write

if TYPE_CHECKING:
    from ued.evaluation import Evaluation


@dataclass(frozen=True)
class Result:
    """One policy on one scene. A goal is an episode with a positive return."""

    method: str
    seed: int
    scene: str
    episodes: int
    mean_return: float
    return_std: float  # between episodes
    goals: int
    mean_length: float  # steps
    env_steps: int  # of the training, 0 for a baseline
    updates: int

    @property
    def goal_rate(self) -> float:
        return self.goals / self.episodes


class Estimate(NamedTuple):
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


def summarise(found: Evaluation, method: str, seed: int, scene: str, trained: tuple[int, int] = (0, 0)) -> Result:
    """Make a row of an evaluation; `trained` is (env_steps, updates)."""
    returns = found.returns
    return Result(
        method=method,
        seed=seed,
        scene=scene,
        episodes=len(returns),
        mean_return=float(returns.mean()),
        return_std=float(returns.std()),
        goals=int((returns > 0).sum()),
        mean_length=float(found.lengths.mean()),
        env_steps=trained[0],
        updates=trained[1],
    )


def select(results: Sequence[Result], method: str, scene: str) -> list[Result]:
    """Give the rows of one method on one scene."""
    return [row for row in results if row.method == method and row.scene == scene]


def goal_rate(rows: Sequence[Result]) -> Estimate:
    """Estimate the goal rate of a method on a scene: bootstrap over runs, or Wilson's interval for a single one."""
    from ued.statistics import bootstrap_interval, wilson

    if len(rows) == 1:
        return Estimate(rows[0].goal_rate, *wilson(rows[0].goals, rows[0].episodes))
    rates = np.array([row.goal_rate for row in rows])
    return Estimate(float(rates.mean()), *bootstrap_interval(rates))


def mean_return(rows: Sequence[Result]) -> Estimate:
    """Estimate the mean return of a method on a scene: bootstrap over runs, or normal for a single run."""
    from ued.statistics import bootstrap_interval

    if len(rows) == 1:
        reach = 1.96 * rows[0].return_std / np.sqrt(rows[0].episodes)
        return Estimate(rows[0].mean_return, rows[0].mean_return - reach, rows[0].mean_return + reach)
    means = np.array([row.mean_return for row in rows])
    return Estimate(float(means.mean()), *bootstrap_interval(means))


def unique(values: Sequence[str]) -> list[str]:
    """Give each value once, in order."""
    return list(dict.fromkeys(values))


def render_table(results: Sequence[Result]) -> str:
    """Give scenes x methods as text: mean return with its interval, and beneath it the goal rate with its own."""
    scenes, methods = unique([row.scene for row in results]), unique([row.method for row in results])
    head = ["scene", "", *methods]
    body: list[list[str]] = []
    for scene in scenes:
        cells = [select(results, method, scene) for method in methods]
        body.append([scene, "return", *(_signed(mean_return(rows)) if rows else "" for rows in cells)])
        body.append(["", "goals", *(_percent(goal_rate(rows)) if rows else "" for rows in cells)])
    body.append(["runs", "", *(str(len(select(results, method, scenes[0]))) for method in methods)])
    for title, pick in (("env_steps", lambda row: row.env_steps), ("updates", lambda row: row.updates)):
        counts = [[pick(row) for row in select(results, method, scenes[0])] for method in methods]
        body.append([title, "", *(f"{round(np.mean(values)):_}" if any(values) else "–" for values in counts)])
    return align([head, *body], foot=3)


def _signed(estimate: Estimate) -> str:
    return f"{estimate.value:+.2f} [{estimate.low:+.2f}, {estimate.high:+.2f}]"


def _percent(estimate: Estimate) -> str:
    return f"{estimate.value:.0%} [{estimate.low:.0%}, {estimate.high:.0%}]"


def align(rows: list[list[str]], foot: int = 0) -> str:
    """Give rows as columns of text: a rule beneath the first row, and one above the last `foot` rows."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    rule = "─" * max(map(len, lines))
    body = lines[1 : len(lines) - foot]
    return "\n".join([lines[0], rule, *body, *([rule, *lines[-foot:]] if foot else [])])


# ---------------------------------------------------------------- files


def save_csv(results: Sequence[Result], path: Path) -> None:
    """Write the rows as CSV."""
    try:
        with open(path, "w", newline="") as file:
            writer = csv.DictWriter(file, [item.name for item in fields(Result)] + ["goal_rate"])
            writer.writeheader()
            writer.writerows(asdict(row) | {"goal_rate": round(row.goal_rate, 6)} for row in results)
    except OSError as error:
        raise cannot_write(path, error) from error
