"""Results of evaluations as rows, and their statistics: means with intervals, differences, robustness.

A `Result` is one policy on one scene, a `LevelResult` one policy on random levels. Each run of a method is a row.
Intervals over runs resample whole runs, since each trained policy plays all scenes, and episodes within runs. The
interval of a single run is over its episodes only and does not cover variation between runs. There is no interval for
fewer than five runs, or fewer than five episodes of a single run.
Read next: `run.report`, the tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ued.evaluation import Evaluation
    from ued.statistics import Difference, Interval

BOOTSTRAP_SEED = 0  # fixed, so equal results give equal tables
BASELINE = " (baseline)"  # after the name of a baseline if runs have this name
WORST = 0.1  # share of the random levels in CVaR10


@dataclass(frozen=True)
class Result:
    """One policy on one scene. `goals` counts successful episodes: in a defense, those without a goal."""

    method: str
    seed: int
    scene: str
    episodes: int
    mean_return: float
    return_std: float  # between episodes
    goals: int
    mean_length: float  # steps
    env_steps: int  # of training, 0 for a baseline
    updates: int

    @property
    def goal_rate(self) -> float:
        return self.goals / self.episodes


@dataclass(frozen=True)
class LevelResult:
    """One policy on random levels of the training distribution, the same levels for every policy."""

    method: str
    seed: int
    levels: int
    episodes: int  # on each level
    goal_rate: float
    cvar10: float  # goal rate on the worst tenth of the levels
    cvar10_error: float  # its standard error, over episodes and sampled levels


def summarize(evaluation: Evaluation, method: str, seed: int, scene: str, trained: tuple[int, int] = (0, 0)) -> Result:
    """Make a row of an evaluation; `trained` is (env_steps, updates)."""
    returns = evaluation.returns
    return Result(
        method=method,
        seed=seed,
        scene=scene,
        episodes=len(returns),
        mean_return=float(returns.mean()),
        return_std=float(returns.std()),
        goals=int(evaluation.success.sum()),
        mean_length=float(evaluation.lengths.mean()),
        env_steps=trained[0],
        updates=trained[1],
    )


def summarize_levels(evaluation: Evaluation, method: str, seed: int) -> LevelResult:
    """Make a row of an evaluation that played each of its L levels k times, k even.

    One half of the episodes selects the worst levels, the other half rates them; then the halves swap roles, and the
    mean of both is reported. Selecting and rating with the same episodes would bias the rate downward.
    """
    from ued.statistics import cvar

    count = len(evaluation.levels)
    goals = (evaluation.success > 0).reshape(-1, count).T  # [L, k]
    halves = goals[:, ::2].mean(1), goals[:, 1::2].mean(1)
    one, other = (cvar(halves[i], WORST, by=halves[1 - i]) for i in (0, 1))
    spread = [cvar((halves[i] - rate) ** 2, WORST, by=halves[1 - i]) for i, rate in enumerate((one, other))]
    return LevelResult(
        method=method,
        seed=seed,
        levels=count,
        episodes=goals.shape[1],
        goal_rate=float(goals.mean()),
        cvar10=(one + other) / 2,
        cvar10_error=float(np.sqrt(np.mean(spread) / (WORST * count))),
    )


def select(results: Sequence[Result], method: str, scene: str) -> list[Result]:
    """Return the rows of one method on one scene."""
    return [row for row in results if row.method == method and row.scene == scene]


def unique(values: Sequence[str]) -> list[str]:
    """Return each value once, in order."""
    return list(dict.fromkeys(values))


# ---------------------------------------------------------------- one method on one scene


class Counted(NamedTuple):
    """A run's goals, at most one per episode."""

    goals: int
    episodes: int


def goal_rate(rows: Sequence[Result] | Sequence[Counted]) -> Interval:
    """Estimate the goal rate of a method on a scene: bootstrap over runs, or Wilson's interval for a single one."""
    from ued.statistics import bootstrap, wilson

    if len(rows) == 1:
        return wilson(rows[0].goals, rows[0].episodes)
    rates, errors = goal_rates(rows)
    return _as_share(bootstrap(rates, _rng(), errors=errors).interval())


def mean_return(rows: Sequence[Result]) -> Interval:
    """Estimate the mean return of a method on a scene: bootstrap over runs, or Student's t for a single run."""
    from ued.statistics import bootstrap, student_t

    values, errors = _returns(rows)
    if len(rows) == 1:
        if _is_rate(rows[0]):
            return goal_rate(rows)
        return student_t(values[0], errors[0], rows[0].episodes)
    return bootstrap(values, _rng(), errors=errors).interval()


def _is_rate(row: Result) -> bool:
    """Return whether the row is consistent with returns of 0 or 1, so that the mean return is a goal rate."""
    rate = row.goals / row.episodes
    return abs(row.mean_return - rate) < 1e-9 and abs(row.return_std**2 - rate * (1 - rate)) < 1e-9


def advantage(rows: Sequence[Result], reference: Sequence[Result]) -> Difference:
    """Estimate the difference of two methods' mean returns on a scene, resampling whole runs of both."""
    return _difference(_returns(rows), _returns(reference))


def detectable_return(methods: Sequence[Sequence[Result]]) -> float:
    """Return the smallest difference of mean returns on a scene that the runs of these methods can detect."""
    from ued.statistics import detectable

    found = list(map(_returns, methods))
    return detectable([values for values, _ in found], [errors for _, errors in found])


# ---------------------------------------------------------------- one method on all scenes


class Scores(NamedTuple):
    """Goal rates of R runs on S scenes `[R, S]`, and their standard errors `[R, S]`."""

    rates: np.ndarray
    errors: np.ndarray


def scores(results: Sequence[Result], method: str) -> Scores:
    """Return the goal rates of a method's runs on all scenes."""
    scenes = unique([row.scene for row in results])
    by_scene = [goal_rates(select(results, method, scene)) for scene in scenes]
    return Scores(np.stack([rates for rates, _ in by_scene], 1), np.stack([errors for _, errors in by_scene], 1))


def mean_score(mine: Scores) -> Interval:
    """Estimate the mean over the scenes, resampling whole runs."""
    from ued.statistics import bootstrap, mean

    return _as_share(bootstrap(mine.rates, _rng(), mean, mine.errors).interval())


def iqm_score(mine: Scores) -> Interval:
    """Estimate the interquartile mean over runs and scenes, resampling whole runs."""
    from ued.statistics import bootstrap, iqm

    return _as_share(bootstrap(mine.rates, _rng(), iqm, mine.errors).interval())


def iqm_stratified(mine: Scores) -> Interval:
    """Estimate the IQM with rliable's stratified interval, which assumes that a run's scenes are independent."""
    from ued.statistics import stratified

    return stratified(mine.rates, _rng())


def score_advantage(mine: Scores, reference: Scores) -> Difference:
    """Estimate the difference of two methods' means over the scenes, resampling whole runs of both."""
    return _difference(mine, reference)


def detectable_score(methods: Sequence[Scores]) -> float:
    """Return the smallest difference of means over the scenes that the runs of these methods can detect."""
    from ued.statistics import detectable

    errors = [np.sqrt((mine.errors**2).sum(1)) / mine.errors.shape[1] for mine in methods]  # [R], of each run's mean
    return detectable([mine.rates.mean(1) for mine in methods], errors)


def chance_of_better(mine: Scores, reference: Scores) -> Interval:
    """Estimate the probability that a run's mean over the scenes exceeds that of a run of the other method."""
    from ued.statistics import probability_of_improvement

    return probability_of_improvement(mine.rates.mean(1), reference.rates.mean(1))


# ---------------------------------------------------------------- random levels


def level_rate(rows: Sequence[LevelResult]) -> Interval:
    """Estimate the goal rate on random levels, resampling runs; all runs play the same levels."""
    from ued.statistics import bootstrap, wilson

    if len(rows) == 1:
        count = rows[0].levels * rows[0].episodes
        return wilson(round(rows[0].goal_rate * count), count)
    return _as_share(bootstrap(np.array([row.goal_rate for row in rows]), _rng()).interval())


def level_cvar(rows: Sequence[LevelResult]) -> Interval:
    """Estimate the goal rate on the worst tenth of random levels, resampling runs.

    For a single run, use Student's t over the levels of that tenth.
    """
    from ued.statistics import bootstrap, student_t

    values, errors = _cvars(rows)
    if len(rows) == 1:
        return _as_share(student_t(values[0], errors[0], int(WORST * rows[0].levels)))
    return _as_share(bootstrap(values, _rng(), errors=errors).interval())


def level_advantage(rows: Sequence[LevelResult], reference: Sequence[LevelResult]) -> Difference:
    """Estimate the difference of two methods on the worst tenth of random levels, resampling whole runs of both."""
    return _difference(_cvars(rows), _cvars(reference))


def detectable_level(methods: Sequence[Sequence[LevelResult]]) -> float:
    """Return the smallest difference on the worst tenth of random levels that the runs of these methods can detect."""
    from ued.statistics import detectable

    found = list(map(_cvars, methods))
    return detectable([values for values, _ in found], [errors for _, errors in found])


def _cvars(rows: Sequence[LevelResult]) -> tuple[np.ndarray, np.ndarray]:
    """Return the goal rates of runs on the worst tenth of the levels `[R]` and their standard errors `[R]`."""
    values, errors = np.array([[row.cvar10, row.cvar10_error] for row in rows]).T
    return values, errors


# ---------------------------------------------------------------- shared


def goal_rates(rows: Sequence[Result] | Sequence[Counted]) -> tuple[np.ndarray, np.ndarray]:
    """Return each run's goal rate `[R]` and its standard error `[R]`."""
    episodes = np.array([row.episodes for row in rows])
    rates = np.array([row.goals for row in rows]) / episodes
    likely = (rates * episodes + 2) / (episodes + 4)  # Agresti and Coull (1998): nonzero error for zero goals
    return rates, np.sqrt(likely * (1 - likely) / (episodes + 4))


def _returns(rows: Sequence[Result]) -> tuple[np.ndarray, np.ndarray]:
    """Return each run's mean return `[R]` and its standard error `[R]`."""
    values, (_, of_rates) = np.array([row.mean_return for row in rows]), goal_rates(rows)
    errors = np.array([row.return_std / np.sqrt(max(row.episodes - 1, 1)) for row in rows])
    return values, np.where([_is_rate(row) for row in rows], of_rates, errors)  # nonzero error for equal returns


def _difference(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> Difference:
    """Estimate the difference of the means of two sets of runs, each (values, standard errors)."""
    from ued.statistics import bootstrap

    rng = _rng()
    mine, theirs = (bootstrap(values, rng, errors=errors) for values, errors in (one, other))
    return (mine - theirs).difference()


def _as_share(interval: Interval) -> Interval:
    """Clip an interval to [0, 1]; nan is unchanged."""
    low, high = np.clip((interval.low, interval.high), 0.0, 1.0)
    return interval._replace(low=float(low), high=float(high))


def _rng() -> np.random.Generator:
    return np.random.default_rng(BOOTSTRAP_SEED)


def align_within(rows: list[list[str]], width: int | None, kept: int = 2) -> str:
    """Return rows as aligned text in blocks of columns that fit a width in characters, one below the other.

    Each block begins with the first `kept` columns, and has at least one more. None: one block.
    """
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    blocks: list[list[int]] = [[]]
    for column in range(kept, len(widths)):
        taken = sum(widths[other] + 2 for other in (*range(kept), *blocks[-1])) + widths[column]
        if width is not None and blocks[-1] and taken > width:
            blocks.append([])
        blocks[-1].append(column)
    return "\n\n".join(align([[*row[:kept], *(row[k] for k in block)] for row in rows]) for block in blocks)


def align(rows: list[list[str]]) -> str:
    """Return rows as aligned text columns, with a line below the first row."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([lines[0], "─" * max(map(len, lines)), *lines[1:]])
