"""`regista evaluate`: evaluate trained runs and baselines on the test scenes of their minigame.

    regista evaluate shipped:maze                                              # a policy installed with Regista
    regista evaluate runs/1v1Restricted-paired-0 --episodes 500
    regista evaluate runs/compare-1v1Restricted                                # all runs in a folder, by method
    regista evaluate runs/1v1Restricted-paired-0 --engine grf                  # five minutes in GRF
    regista evaluate runs/1v1Restricted-paired-0 --engine grf --episodes 100
    regista evaluate runs/1v1Restricted-paired-0 --gallery                     # write its levels as gallery.html

Read next: `run.evaluator`, the episodes; `run.results`, the statistics; `run.report`, the tables.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.errors import CommandError, UsageError, read_from
from regista.experiments.run.evaluator import EvalScenes, Evaluator
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.progress import counted, terminal_width
from regista.experiments.run.report import Report, write_text
from regista.experiments.run.run_folders import by_game, check_comparable, check_one_game, open_runs
from regista.experiments.run.table import check_file
from ued.config import Checked, most_threads, setting

EPISODES, LEVELS = 500, 200  # defaults in our simulator
GRF_MINUTES = 5.0  # default in GRF
ROUND = 8  # episodes per scene and round of a timed evaluation
MOST_PLAYED = 100_000_000  # upper limit of episodes on random levels
GALLERY_ALONE = {"gallery_levels", "gallery_replays"}
OF_GALLERY = {"runs", "gallery", *GALLERY_ALONE}
DESCRIPTION = "Evaluate runs on the test scenes of their minigame and on its training distribution, with 95% intervals."


@dataclass(frozen=True)
class EvaluateConfig(Checked):
    """Arguments of `regista evaluate`."""

    runs: tuple[Path, ...] = positional(
        "run folders, folders of runs, or shipped policies such as shipped:maze", default=()
    )
    episodes: int | None = setting(
        None,
        f"episodes on each scene (default {EPISODES}; with --engine grf as many as --minutes allow)",
        ">=1",
        most=1_000_000,
    )
    minutes: float | None = setting(
        None,
        "instead of --episodes: play as many rounds of episodes as fit into this time "
        f"(default with --engine grf: {GRF_MINUTES:g})",
        ">0",
        most=100_000,
    )
    levels: int | None = setting(
        None,
        "random levels for CVaR10, the success rate on the worst tenth; 0: none "
        f"(default {LEVELS}; 0 with --engine grf)",
        most=1_000_000,
        least=0,
    )
    level_episodes: int = setting(10, "episodes on each, an even number", most=10_000, least=2)
    held_out: bool = setting(False, "evaluate on the held-out scenes, for final results only")
    baselines: bool = setting(True, "also evaluate the baselines 'shoot', 'random' and, in our simulator, 'built-in'")
    threads: int = setting(1, "threads for the simulator and for the networks", ">=1", most=most_threads)
    csv: Path | None = setting(None, "also write the results to this CSV file")
    markdown: Path | None = setting(None, "also write the tables to this Markdown file")
    json: bool = setting(False, "print JSON instead of a table")
    gallery: bool = setting(False, "instead of evaluating: write the levels of each run as an HTML page")
    gallery_levels: int = setting(
        3_000,
        "levels on the map of the page, evenly spaced over updates; levels with replays are added",
        ">=1",
        most=100_000,
    )
    gallery_replays: int = setting(150, "levels with replays on the page, spread over updates", ">=0", most=10_000)
    playing: EngineConfig = group(EngineConfig, "engine (default: the one of training)")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_levels(self.levels or 0, self.level_episodes)
        if self.episodes is not None and self.minutes is not None:
            raise ValueError("give episodes or minutes, not both")


def check_levels(levels: int, episodes: int) -> None:
    """Raise `ValueError` for numbers of levels and episodes from which CVaR10 cannot be estimated."""
    if levels < 0 or 0 < levels < 10:
        raise ValueError(f"levels must be 0 or at least 10, so that the worst tenth has a level, got {levels}")
    if episodes < 2 or episodes % 2:
        raise ValueError(f"level_episodes must be even, as one half selects the worst levels; got {episodes}")
    if levels * episodes > MOST_PLAYED:
        raise ValueError(f"levels x level_episodes must be at most {MOST_PLAYED:_} episodes, got {levels * episodes:_}")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    typed = arguments.typed_settings(EvaluateConfig(), argv, "evaluate", DESCRIPTION)
    config = arguments.replace_paths(EvaluateConfig(), typed)
    if not config.runs:
        raise UsageError("evaluate needs at least one run folder, such as runs/1v1Restricted-paired-0, or shipped:maze")
    runs = open_runs(config.runs)
    for path in sorted(typed.keys() - OF_GALLERY if config.gallery else typed.keys() & GALLERY_ALONE):
        flag = arguments.flag_name(path.removeprefix("playing."))
        raise UsageError(f"{flag} and --gallery exclude each other" if config.gallery else f"{flag} needs --gallery")
    if config.gallery:
        for run in runs:
            write_gallery(run, config)
        return 0
    for file in filter(None, (config.csv, config.markdown)):
        check_file(file)
    games = by_game(runs)
    outputs = [name for name in ("json", "csv", "markdown") if getattr(config, name)]
    if len(games) > 1 and (outputs or not any(_is_folder_of_runs(path) for path in config.runs)):
        check_one_game(runs)
    for number, (name, played) in enumerate(games.items()):
        if len(games) > 1:
            print("\n" * bool(number) + build.find_game(name).short)
        _evaluate(played, config)
    return 0


def _is_folder_of_runs(path: Path) -> bool:
    return not (path / "config.json").exists()


def _evaluate(runs: Sequence[RunFolder], config: EvaluateConfig) -> None:
    """Evaluate the runs of one game; print and write their tables."""
    check_comparable(runs)
    first = replace(runs[0].config, threads=config.threads).on_engine(config.playing)
    report = evaluator(first, config).report(runs, config.baselines)
    print(json.dumps(as_json(report), indent=2) if config.json else report.text(terminal_width()))
    if config.csv is not None:
        report.save_csv(config.csv)
    if config.markdown is not None:
        write_text(config.markdown, report.markdown() + "\n")


def write_gallery(run: RunFolder, config: EvaluateConfig) -> None:
    """Write gallery.html into a run folder: a map of its levels, each with a card, a scene and a replay."""
    from regista.experiments.pictures.gallery import make_page

    if not run.levels.path.exists():
        raise CommandError(f"{run.path} has no table of levels: no update has finished yet")
    path, game = run.path / "gallery.html", build.find_game(run.config.minigame)
    with read_from(f"the tables of {run.path} belong to other environments, or"):
        made = make_page(run, game, path, config.gallery_levels, config.gallery_replays)
    print(f"{path}: {made.levels} of {counted(made.played, 'level')}, {made.replays} with replays")
    if made.otherwise:
        print(f"{counted(made.otherwise, 'replay')} did not repeat the recorded episode: the environment has changed")


def evaluator(first: Any, config: EvaluateConfig) -> Evaluator:
    """Return the evaluator for the scenes of a run's settings; in GRF the default is fewer episodes."""
    real = first.engine == "grf"
    minutes = GRF_MINUTES if real and config.episodes is None and config.minutes is None else config.minutes
    episodes = (config.episodes or EPISODES) if minutes is None else ROUND
    levels = (0 if real else LEVELS) if config.levels is None else config.levels
    scenes = EvalScenes(first, build.find_game(first.minigame), episodes, config.held_out)
    return Evaluator(scenes, levels, config.level_episodes, minutes=minutes, tell=real or minutes is not None)


def as_json(report: Report) -> dict[str, Any]:
    """Return rows by run, the simulator version, and all numbers of the tables; null means not available."""
    entries = [entry._asdict() for entry in report.entries]
    return {
        "results": [asdict(row) for row in report.results],
        "levels": [asdict(row) for row in report.levels],
        "simulator": report.simulator,
        "tables": [{name: None if value != value else value for name, value in entry.items()} for entry in entries],
    }
