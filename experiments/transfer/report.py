"""Results of transfers as tables: by game, by run, and differences within a run; and rows for files.

Read next: `transfer.replaying`, which computes the results; `run.results`, the intervals.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import versions
from regista.experiments.run.report import two_digits
from regista.experiments.run.results import Counted, align, goal_rate, goal_rates
from regista.experiments.transfer import goals
from regista.experiments.transfer.episodes import ENDINGS, ENGINES
from regista.experiments.transfer.replaying import SEED, Leaving, Result
from ued import statistics
from ued.statistics import Interval, bootstrap, student_t

ACTIONS = (
    *("idle", "left", "top left", "top", "top right", "right", "bottom right", "bottom", "bottom left"),
    *("long pass", "high pass", "short pass", "shot", "sprint", "release direction", "release sprint", "slide"),
    *("dribble", "release dribble"),
)
SHOWN_ACTIONS = 6  # number of actions in the report, by difference between engines
SAMPLES = 4000  # random samples for an interval
WANTED, LEAST = 0.8, 0.5  # thresholds of the ratio: good and poor transfer
INTERVALS = (
    "95% intervals: bootstrap over runs and their episodes, wide for few runs; for a single run, over its episodes "
    "only, Wilson's for rates, Jeffreys' for ratios, Student's t for returns; none below 5 runs, or 5 episodes"
)


class Group(NamedTuple):
    """The runs of one game, representation and method, with one policy (sampled or greedy)."""

    game: str
    representation: str
    method: str
    policy: str
    results: Sequence[Result]

    def rate(self, engine: str) -> Interval:
        """Estimate the goal rate on an engine."""
        return goal_rate(counts(self.results, engine))

    def ratio(self) -> Interval:
        """Estimate the goal rate in the other engine divided by ours."""
        return rate_ratio(self.results)

    def numbers(self) -> dict[str, Any]:
        """Return the estimates in a form that JSON supports."""
        intervals = {"ours": self.rate("ours"), "grf": self.rate("grf"), "ratio": self.ratio()}
        plain = {name: [None if value != value else value for value in ends] for name, ends in intervals.items()}
        return {name: getattr(self, name) for name in self._fields[:4]} | {"runs": len(self.results)} | plain


def groups(results: Sequence[Result]) -> list[Group]:
    """Group the results by game, representation, method and policy."""
    by_key: dict[tuple[str, str, str, str], list[Result]] = {}
    for result in results:
        by_key.setdefault((result.game, result.representation, result.method, result.policy), []).append(result)
    return [Group(*key, results=alike) for key, alike in by_key.items()]


def counts(results: Sequence[Result], engine: str) -> list[Counted]:
    """Return the goals and episodes of each run on an engine."""
    return [Counted(result.engines[engine]["goals"], result.engines[engine]["episodes"]) for result in results]


def rate_ratio(results: Sequence[Result]) -> Interval:
    """Estimate the goal rate in the other engine divided by ours; nan if no goal was scored in ours.

    For one run, each rate is sampled from Jeffreys' posterior over its episodes. For several runs, the ratio of the
    means is bootstrapped over runs and episodes. There is no interval for fewer than five runs, or fewer than five
    episodes of one run.
    """
    rng = np.random.default_rng(SEED)
    grf, ours = (counts(results, engine) for engine in ("grf", "ours"))
    if not any(group.goals for group in ours):
        return Interval(np.nan, np.nan, np.nan)
    if len(results) == 1:
        estimate = grf[0].goals / grf[0].episodes / (ours[0].goals / ours[0].episodes)
        if min(grf[0].episodes, ours[0].episodes) < statistics.LEAST:
            return Interval(estimate, np.nan, np.nan)
        grf_rate, our_rate = (
            rng.beta(count[0].goals + 0.5, count[0].episodes - count[0].goals + 0.5, SAMPLES) for count in (grf, ours)
        )
        low, high = np.quantile(grf_rate / our_rate, [0.025, 0.975])
        return Interval(estimate, float(low), float(high))
    rates, errors = (np.stack(rate, 1) for rate in zip(goal_rates(grf), goal_rates(ours), strict=True))  # [R, 2]
    interval = bootstrap(rates, rng, _ratio, errors, SAMPLES).interval()
    return interval._replace(low=max(interval.low, 0.0), high=max(interval.high, 0.0))


def _ratio(rates: np.ndarray) -> float:
    count = len(rates)  # sums are faster than means, which matters for thousands of calls
    return float(rates[:, 0].sum() / count / max(rates[:, 1].sum() / count, 1e-3))


# ---------------------------------------------------------------- tables


def by_game(results: Sequence[Result]) -> list[list[str]]:
    """Return a row for each game, representation, method and policy."""
    lines = [["game", "observations", "method", "policy", "runs", "goals, ours", "goals, grf", "grf / ours"]]
    for group in groups(results):
        rates = [two_digits(group.rate(engine)) for engine in ENGINES]
        lines.append([*group[:4], str(len(group.results)), *rates, spelled(group.ratio())])
    return lines


def verdict(results: Sequence[Result]) -> str:
    """Return one line for each policy: the number of games with good and with poor transfer."""
    lines = []
    for policy in dict.fromkeys(result.policy for result in results):
        ratios = [group.ratio().estimate for group in groups(results) if group.policy == policy]
        good, bad = sum(ratio >= WANTED for ratio in ratios), sum(ratio < LEAST for ratio in ratios)
        lines.append(f"{policy}: {good} of {len(ratios)} ratios at {WANTED:g} or more, {bad} below {LEAST:g}")
    return "\n".join(lines)


def by_run(results: Sequence[Result]) -> list[list[str]]:
    """Return a row for each run, policy and engine."""
    lines = [["run", "policy", "engine", "goals", "return", "length", " / ".join(ENDINGS[:-1]), "ratio"]]
    for result in results:
        for engine, numbers in result.engines.items():
            rate = two_digits(goal_rate(counts([result], engine)))
            ends = " / ".join(f"{share:.2f}" for share in numbers["endings"].values())
            returns = student_t(numbers["mean_return"], numbers["return_error"], numbers["episodes"])
            score = f"{returns.estimate:+z.2f}" + (f" ± {returns.high - returns.estimate:.2f}" if returns.known else "")
            first = [result.run, result.policy] if engine == "ours" else ["", ""]
            ratio = "" if engine == "ours" else spelled(rate_ratio([result]))
            lines.append([*first, engine, rate, score, f"{numbers['median_length']:g}", ends, ratio])
    return lines


def details(result: Result) -> str:
    """Return the differences between the engines in the episodes of one policy, as lines."""
    ours, grf = (numbers["actions"] for numbers in result.engines.values())
    most = sorted(range(len(ACTIONS)), key=lambda a: -abs(ours[a] - grf[a]))[:SHOWN_ACTIONS]
    actions = ", ".join(f"{ACTIONS[a]} {ours[a]:.0%} ({grf[a]:.0%})" for a in most)
    return "\n".join(
        [
            f"{result.run}, {result.policy}",
            f"  actions, ours (grf): {actions}",
            f"  features outside the range of our episodes: {Leaving(**result.leaves_ours).line()}",
            f"  and outside the range of training: {Leaving(**result.leaves_training).line()}",
            *(f"  goals, {engine}: {goals.line(numbers['goals_from'])}" for engine, numbers in result.engines.items()),
        ]
    )


def text(results: Sequence[Result], with_details: bool) -> str:
    """Return all tables for a terminal: by game if there are several runs, by run, and details of each run."""
    parts = [align(by_run(results))]
    if len(results) > len({result.policy for result in results}):
        parts.insert(0, f"{align(by_game(results))}\n[{INTERVALS}]\n{verdict(results)}")
    return "\n\n".join([*parts, *(map(details, results) if with_details else ())])


def spelled(ratio: Interval) -> str:
    """Return a ratio with its interval."""
    return "no goal in ours" if ratio.estimate != ratio.estimate else two_digits(ratio)


# ---------------------------------------------------------------- files


def as_json(results: Sequence[Result]) -> dict[str, Any]:
    """Return all results and groups in a form that JSON supports."""
    return {"runs": [asdict(result) for result in results], "groups": [result.numbers() for result in groups(results)]}


def csv_rows(result: Result) -> list[dict[str, Any]]:
    """Return a CSV row for each engine."""
    ratio = dict(zip(("ratio", "ratio_low", "ratio_high"), rate_ratio([result]), strict=True))
    of_run = {name: getattr(result, name) for name in ("run", "game", "representation", "method", "policy")}
    rows = []
    for engine, numbers in result.engines.items():
        rate = goal_rate(counts([result], engine))
        version = versions.spelled(SIMULATOR_VERSION if engine == "ours" else None)
        row = (
            of_run | {"engine": engine, versions.KEY: version} | {name: numbers[name] for name in ("episodes", "goals")}
        )
        row |= dict(zip(("goal_rate", "goal_rate_low", "goal_rate_high"), rate, strict=True)) | ratio
        row |= {name: numbers[name] for name in ("mean_return", "return_error", "median_length")}
        row |= {f"ended/{word}": share for word, share in numbers["endings"].items()}
        row |= {f"action/{key}": share for key, share in zip(ACTIONS, numbers["actions"], strict=True)}
        rows.append(row | {name: numbers["goals_from"].get(name) for name in ("median_distance", "median_keeper_out")})
    return rows


def save_results(path: Path, settings: dict[str, Any], results: Sequence[Result]) -> None:
    """Save the results of a run with the settings of the plan. Raises OSError if the file cannot be written."""
    path.write_text(json.dumps({"asked": settings, "results": [asdict(result) for result in results]}, indent=1))


def load_saved(path: Path, settings: dict[str, Any]) -> list[Result]:
    """Return the saved results of a run; empty unless they were played with these settings."""
    try:
        stored = json.loads(path.read_text())
        return [Result(**result) for result in stored["results"]] if stored["asked"] == settings else []
    except (OSError, ValueError, KeyError, TypeError):
        return []
