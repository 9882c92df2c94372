"""`regista transfer`: play trained runs in our simulator and in Google Research Football, and tell what carries over.

    regista transfer runs/academy/3_vs_1_with_keeper-dr-0
    regista transfer runs/a runs/b --grf-episodes 100 --csv transfer.csv --traces transfer.rrd

Read next: `grf.transfer`, which plays; `grf.goals`, where goals come from.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.run import arguments
from experiments.run.arguments import group, positional
from experiments.run.config import EngineConfig
from experiments.run.errors import UsageError
from experiments.run.folder import RunFolder
from experiments.run.report import save_rows
from experiments.run.results import align
from experiments.run.table import cannot_write
from ued.config import Checked, setting

if TYPE_CHECKING:
    from experiments.grf.transfer import Transfer

DESCRIPTION = "Play runs, sampled and greedy, on the same levels in our simulator and in Google Research Football."
KEYS = (
    *("idle", "left", "top left", "top", "top right", "right", "bottom right", "bottom", "bottom left"),
    *("long pass", "high pass", "short pass", "shot", "sprint", "release direction", "release sprint", "slide"),
    *("dribble", "release dribble"),
)
SHOWN_KEYS = 6  # of the actions, those that differ most


@dataclass(frozen=True)
class TransferConfig(Checked):
    """What is typed after `regista transfer`."""

    runs: tuple[Path, ...] = positional("run folders", default=())
    episodes: int = setting(500, "whole episodes of each policy in our simulator", ">=1")
    grf_episodes: int = setting(200, "whole episodes of each policy in the other engine", ">=1")
    threads: int = setting(1, "threads for the simulator and for the networks", ">=1")
    csv: Path | None = setting(None, "also write a row for each run, policy and engine to this CSV file")
    json: bool = setting(False, "print JSON instead of tables")
    traces: Path | None = setting(None, "play our keys in both, and record it side by side: rerun TRACES.rrd")
    trace_episodes: int = setting(3, "episodes of each run in that recording", ">=1")
    playing: EngineConfig = group(EngineConfig, "the other engine; without, grf")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(TransferConfig(), argv, "transfer", DESCRIPTION)
    if not config.runs:
        raise UsageError("transfer needs at least one run folder, such as runs/academy/3_vs_1_with_keeper-dr-0")
    found, traces = play(config, [RunFolder.open(path) for path in config.runs])
    if config.json:
        print(json.dumps([as_json(each) for each in found], indent=2))
    else:
        print("\n\n".join([align(table(found)), *map(details, found)]))
    if config.csv is not None:
        rows = [row for each in found for row in csv_rows(each)]
        save_rows(rows, list(rows[0]), config.csv)
    if config.traces is not None:
        record(config.traces, traces)
    return 0


def play(config: TransferConfig, runs: Sequence[RunFolder]) -> tuple[list[Transfer], list[Any]]:
    """Play all runs; return what became of it, and the episodes to be recorded."""
    from dataclasses import replace

    from experiments.grf.transfer import BothEngines, Plan

    found: list[Transfer] = []
    traces: list[Any] = []
    for number, run in enumerate(runs):
        print(f"{run.path}, {number + 1} of {len(runs)}", file=sys.stderr, flush=True)
        other = config.playing.instead_of(replace(run.config.env, engine="grf"))
        wanted = config.trace_episodes if config.traces is not None else 0
        with BothEngines(run, Plan(other, (config.episodes, config.grf_episodes), wanted, config.threads)) as engines:
            played = list(engines.transfers())
            found += played
            if wanted:
                traces += engines.recorded(played[0])
    return found, traces


def record(path: Path, traces: Sequence[Any]) -> None:
    """Write the recording. Raises CommandError if it cannot be written."""
    from ued.recorder.side_by_side import record_side_by_side

    try:
        record_side_by_side(path, "transfer", traces)
    except OSError as error:
        raise cannot_write(path, error) from error


# ---------------------------------------------------------------- what is shown


def table(found: Sequence[Transfer]) -> list[list[str]]:
    """Return a row for each run, policy and engine, and the ratio; then one for each game of several runs."""
    from experiments.grf.transfer import rate_ratio, summary

    head = ["run", "policy", "engine", "goals", "return", "length", "scored/conceded/out/lost/time/program", "ratio"]
    lines = [head]
    for each in found:
        for engine, episodes in each.episodes().items():
            numbers = summary(episodes)
            goals = f"{numbers['goal_rate']:.2f} [{numbers['goal_rate_low']:.2f}, {numbers['goal_rate_high']:.2f}]"
            ends = " / ".join(f"{share:.2f}" for share in list(numbers["endings"].values()))
            score = f"{numbers['mean_return']:+.2f} ± {1.96 * numbers['return_error']:.2f}"
            first = [each.run, each.policy] if engine == "ours" else ["", ""]
            ratio = "" if engine == "ours" else spelled(each.ratio)
            lines.append([*first, engine, goals, score, f"{numbers['median_length']:g}", ends, ratio])
    for game, policy in dict.fromkeys((each.game, each.policy) for each in found):
        alike = [each for each in found if (each.game, each.policy) == (game, policy)]
        if len(alike) > 1:
            ratio = spelled(rate_ratio(alike))
            lines.append([f"{len(alike)} runs of {game}", policy, "grf / ours", "", "", "", "", ratio])
    return lines


def details(each: Transfer) -> str:
    """Return what differs in one policy's episodes, in lines."""
    from experiments.grf.transfer import summary

    ours, grf = (summary(episodes)["actions"] for episodes in each.episodes().values())
    most = sorted(range(len(KEYS)), key=lambda key: -abs(ours[key] - grf[key]))[:SHOWN_KEYS]
    keys = ", ".join(f"{KEYS[key]} {ours[key]:.0%} ({grf[key]:.0%})" for key in most)
    goals = [f"  goals, {engine}: {found.line()}" for engine, found in each.goals().items()]
    return "\n".join(
        [
            f"{each.run}, {each.policy}",
            f"  keys, ours (grf): {keys}",
            f"  features leave what ours shows: {each.leaves_ours().line()}",
            f"  features leave what training showed: {each.leaves_training().line()}",
            *goals,
        ]
    )


def spelled(ratio: Any) -> str:
    """Return a ratio with its interval."""
    return "no goal in ours" if ratio.estimate != ratio.estimate else "{:.2f} [{:.2f}, {:.2f}]".format(*ratio)


def as_json(each: Transfer) -> dict[str, Any]:
    """Return everything of one policy."""
    from experiments.grf.transfer import summary

    goals = each.goals()
    return {
        "run": each.run,
        "game": each.game,
        "policy": each.policy,
        "ratio": [None if value != value else value for value in each.ratio],
        "engines": {
            engine: summary(episodes) | {"goals_from": goals[engine].summary()}
            for engine, episodes in each.episodes().items()
        },
        "leaves_ours": each.leaves_ours().plain(),
        "leaves_training": {engine: each.leaves_training(engine).plain() for engine in each.episodes()},
    }


def csv_rows(each: Transfer) -> list[dict[str, Any]]:
    """Return a row for each engine."""
    from experiments.grf.transfer import summary

    rows = []
    for engine, episodes in each.episodes().items():
        numbers = summary(episodes)
        endings, actions = numbers.pop("endings"), numbers.pop("actions")
        row = {"run": each.run, "game": each.game, "policy": each.policy, "engine": engine, **numbers}
        row |= {f"ended/{word}": share for word, share in endings.items()}
        row |= {f"action/{key}": share for key, share in zip(KEYS, actions, strict=True)}
        ratio = dict(zip(("ratio", "ratio_low", "ratio_high"), each.ratio, strict=True))
        goals = each.goals()[engine].summary()
        rows.append(row | ratio | {name: goals.get(name) for name in ("median_distance", "median_keeper_out")})
    return rows
