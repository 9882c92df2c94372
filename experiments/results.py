"""Results of evaluations as rows, and what can be said of them: means with intervals, tables, CSV.

A row is one policy on one scene. Several runs of a method are several rows; their interval resamples whole runs, since
one trained policy is tested on all scenes, and within them the luck of their episodes. A single run's interval is over
its episodes alone: it says nothing of the next run. Read next: `evaluate`.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from experiments.table import cannot_write

if TYPE_CHECKING:
    from ued.evaluation import Evaluation
    from ued.statistics import Interval

FOOTNOTE = (
    "[95 % intervals: over runs and their episodes, wide where runs are few; "
    "for a single run or a baseline, over its episodes alone]"
)
BOOTSTRAP_SEED = 0  # a table of the same results is the same table


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


def goal_rate(rows: Sequence[Result]) -> Interval:
    """Estimate the goal rate of a method on a scene: bootstrap over runs, or Wilson's interval for a single one."""
    from ued.statistics import bootstrap, wilson

    if len(rows) == 1:
        return wilson(rows[0].goals, rows[0].episodes)
    episodes = np.array([row.episodes for row in rows])
    rates = np.array([row.goals for row in rows]) / episodes
    likely = (rates * episodes + 2) / (episodes + 4)  # Agresti and Coull (1998): no goal at all is not certainty
    errors = np.sqrt(likely * (1 - likely) / (episodes + 4))
    found = bootstrap(rates, _rng(), errors=errors).interval()
    return found._replace(low=max(found.low, 0.0), high=min(found.high, 1.0))


def mean_return(rows: Sequence[Result]) -> Interval:
    """Estimate the mean return of a method on a scene: bootstrap over runs, or normal for a single run."""
    from ued.statistics import Interval, bootstrap

    values, errors = _returns(rows)
    if len(rows) == 1:
        return Interval(values[0], values[0] - 1.96 * errors[0], values[0] + 1.96 * errors[0])
    return bootstrap(values, _rng(), errors=errors).interval()


def advantage(rows: Sequence[Result], reference: Sequence[Result]) -> Interval:
    """Estimate by how much one method's mean return on a scene exceeds another's, resampling whole runs of both."""
    from ued.statistics import bootstrap

    rng = _rng()
    one, other = (bootstrap(values, rng, errors=errors) for values, errors in map(_returns, (rows, reference)))
    return (one - other).interval()


def _returns(rows: Sequence[Result]) -> tuple[np.ndarray, np.ndarray]:
    """Give each run's mean return `[R]` and its standard error `[R]`."""
    values = np.array([row.mean_return for row in rows])
    return values, np.array([row.return_std / np.sqrt(row.episodes) for row in rows])


def _rng() -> np.random.Generator:
    return np.random.default_rng(BOOTSTRAP_SEED)


def unique(values: Sequence[str]) -> list[str]:
    """Give each value once, in order."""
    return list(dict.fromkeys(values))


def render_table(results: Sequence[Result]) -> str:
    """Give scenes x methods as text: mean return with its interval, and beneath it the goal rate with its own.

    A last column compares the trained methods with the first of them, where each has several runs.
    """
    scenes, methods = unique([row.scene for row in results]), unique([row.method for row in results])
    several = [method for method in methods if len(select(results, method, scenes[0])) > 1]
    pairs = [(method, several[0]) for method in several[1:]]
    body: list[list[str]] = []
    for scene in scenes:
        rows = {method: select(results, method, scene) for method in methods}
        gains = [_signed(advantage(rows[one], rows[other])) for one, other in pairs]
        body.append([scene, "return", *(_signed(mean_return(rows[method])) for method in methods), *gains])
        body.append(["", "goals", *(_percent(goal_rate(rows[method])) for method in methods), *([""] * len(pairs))])
    foot = [["runs", "", *(str(len(select(results, method, scenes[0]))) for method in methods)]]
    for title in ("env_steps", "updates"):
        counts = [[getattr(row, title) for row in select(results, method, scenes[0])] for method in methods]
        foot.append([title, "", *(f"{round(np.mean(values)):_}" if any(values) else "–" for values in counts)])
    head = ["scene", "", *methods, *(f"{one} − {other}" for one, other in pairs)]
    return align([head, *body, *(line + [""] * len(pairs) for line in foot)], foot=len(foot)) + "\n" + FOOTNOTE


def _signed(interval: Interval) -> str:
    return f"{interval.estimate:+.2f} [{interval.low:+.2f}, {interval.high:+.2f}]"


def _percent(interval: Interval) -> str:
    return f"{interval.estimate:.0%} [{interval.low:.0%}, {interval.high:.0%}]"


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
