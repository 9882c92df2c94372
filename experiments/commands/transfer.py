"""`regista transfer`: play trained runs in our simulator and in Google Research Football, and compare the results.

    regista transfer runs/academy/3_vs_1_with_keeper-dr-0
    regista transfer runs/a runs/b --grf-episodes 100 --csv transfer.csv --traces transfer.rrd
    regista transfer runs/transfer/* --policies sampled --kept --no-details --markdown transfer.md

The results of a run are saved in its folder as transfer.json. Read next: `transfer.replaying`, the episodes;
`transfer.report`, the tables.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import arguments, versions
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import as_markdown, save_rows, write_text
from regista.experiments.run.table import cannot_write
from ued.config import Checked, most_threads, setting

if TYPE_CHECKING:
    from regista.experiments.transfer.replaying import Result

DESCRIPTION = "Play runs, sampled and greedy, on the same levels in our simulator and in Google Research Football."
GRF_EPISODES = 200  # default, limited by --minutes
SAVED = "transfer.json"  # in the run folder


@dataclass(frozen=True)
class TransferConfig(Checked):
    """Arguments of `regista transfer`."""

    runs: tuple[Path, ...] = positional("run folders", default=())
    episodes: int = setting(500, "episodes of each policy in our simulator", ">=1", most=1_000_000)
    grf_episodes: int | None = setting(
        None,
        f"episodes of each policy in the other engine (default {GRF_EPISODES}, or as many as --minutes allow)",
        ">=1",
        most=1_000_000,
    )
    minutes: float = setting(
        5.0,
        "without --grf-episodes: time limit of the other engine in minutes, over all runs",
        ">0",
        most=100_000,
    )
    policies: tuple[str, ...] = setting(("sampled", "greedy"), "action selection: sampled, greedy")
    kept: bool = setting(False, "reuse saved results of runs that were played with the same settings")
    details: bool = setting(True, "print for each run how actions, features and goals differ")
    threads: int = setting(1, "threads for the simulator and for the networks", ">=1", most=most_threads)
    csv: Path | None = setting(None, "also write a row for each run, policy and engine to this CSV file")
    markdown: Path | None = setting(None, "also write the table of games to this Markdown file")
    json: bool = setting(False, "print JSON instead of tables")
    traces: Path | None = setting(None, "record the same actions in both engines side by side to this Rerun file")
    trace_episodes: int = setting(3, "episodes of each run in the --traces recording", ">=1", most=1_000)
    playing: EngineConfig = group(EngineConfig, "the other engine (default: grf)")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_policies(self.policies)


def check_policies(policies: Sequence[str]) -> None:
    """Raise `ValueError` unless all policies are "sampled" or "greedy"."""
    if not policies or not {*policies} <= {"sampled", "greedy"}:
        raise ValueError(f"policies must be sampled, greedy or both, got {' '.join(policies) or 'none'}")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    config = arguments.parse(TransferConfig(), argv, "transfer", DESCRIPTION)
    if not config.runs:
        raise UsageError("transfer needs at least one run folder, such as runs/academy/3_vs_1_with_keeper-dr-0")
    from regista.experiments.transfer import report

    results, traces = play(config, [RunFolder.open(path) for path in config.runs])
    print(json.dumps(report.as_json(results), indent=2) if config.json else report.text(results, config.details))
    if config.csv is not None:
        rows = [row for result in results for row in report.csv_rows(result)]
        save_rows(rows, list(rows[0]), config.csv)
    if config.markdown is not None:
        played = f"ours: simulator version {SIMULATOR_VERSION}"
        notes = f"{report.INTERVALS}; {report.verdict(results)}; {played}".replace("\n", "; ")
        write_text(config.markdown, f"{as_markdown(report.by_game(results))}\n\n{notes}.\n")
    if config.traces is not None:
        record(config.traces, traces)
    return 0


def play(config: TransferConfig, runs: Sequence[RunFolder]) -> tuple[list[Result], list[Any]]:
    """Play all runs; return their results and the episodes to record.

    Raises `CommandError` for runs of different versions of the simulator.
    """
    versions.check_alike({run.path: run.simulator for run in runs})
    from regista.experiments.transfer.replaying import Plan, play_run
    from regista.experiments.transfer.report import load_saved, save_results

    traced = config.trace_episodes if config.traces is not None else 0
    episodes = config.episodes, config.grf_episodes or GRF_EPISODES
    share = 60 * config.minutes / (len(runs) * len(config.policies)) if config.grf_episodes is None else None
    plan = Plan(config.playing, episodes, config.policies, traced, config.threads, share)
    results: list[Result] = []
    traces: list[Any] = []
    for number, run in enumerate(runs):
        line, settings = f"{run.path}, {number + 1} of {len(runs)}", plan.settings(run)
        played = load_saved(run.path / SAVED, settings) if config.kept and not traced else []
        print(f"{line}, saved results" if played else line, file=sys.stderr, flush=True)
        if not played:
            played, seen = play_run(run, plan)
            traces += seen
            try:
                save_results(run.path / SAVED, settings, played)
            except OSError as error:
                raise cannot_write(run.path / SAVED, error) from error
        results += played
    return results, traces


def record(path: Path, traces: Sequence[Any]) -> None:
    """Write the recording. Raises CommandError if it cannot be written."""
    from regista.experiments.pictures.side_by_side import record_side_by_side

    try:
        record_side_by_side(path, "transfer", traces)
    except OSError as error:
        raise cannot_write(path, error) from error
