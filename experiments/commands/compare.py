"""`regista compare`: train several methods over several seeds, evaluate them, write tables and pictures.

    regista compare 1v1Restricted --methods dr paired --seeds 4 --total-env-steps 3_000_000 --out demo

Every run has a folder in `--out`; a second call skips finished runs and continues the others. Read next:
`run.launch.workers`, training; `commands.evaluate`, evaluation; `run.report`, the tables; `pictures.overview`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from regista.experiments.commands.evaluate import check_levels
from regista.experiments.pictures import curves, level_plots, plots, theta_plots
from regista.experiments.pictures.overview import Comparison, overview
from regista.experiments.run import arguments, build, origin, starting
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import GAME, TrainConfig
from regista.experiments.run.errors import read_from
from regista.experiments.run.evaluator import EvalScenes, Evaluator
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import Game
from regista.experiments.run.launch.seeds import prepare
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.variants import rows_of
from regista.experiments.run.launch.workers import LaunchConfig, train_unfinished
from regista.experiments.run.progress import counted, terminal_width
from regista.experiments.run.report import Report
from regista.experiments.run.run_folders import warn_of_changed_tasks
from ued.config import LARGEST_SEED, Checked, FineTuningConfig, setting
from ued.core.task import TRAINING_SCENE
from ued.methods import METHODS

DESCRIPTION = (
    "Train methods on one minigame over several seeds, evaluate every run and the baselines on its test scenes, and "
    "write tables and pictures. You can stop it at any time; the same command continues."
)
CHOSEN = ("minigame", "method", "seed")  # settings that the comparison sets for each run


@dataclass(frozen=True)
class CompareConfig(Checked):
    """Arguments of `regista compare`."""

    minigame: str = positional(GAME, default="1v1Restricted")
    methods: tuple[str, ...] = setting(("dr", "paired"), "methods to compare; differences are relative to the first")
    variants: tuple[str, ...] = setting(
        (), 'more rows, "NAME: FLAGS": the first method, or that of --method, with other settings'
    )
    seeds: int = setting(5, "runs of each method", ">=1", most=10_000)
    first_seed: int = setting(
        0,
        "first seed (use >= 1000 for tuning; lower seeds are for reported results)",
        ">=0",
        most=LARGEST_SEED - 10_000,
    )
    held_out: bool = setting(False, "evaluate on held-out scenes, for final results only")
    episodes: int = setting(500, "episodes on each test scene after training", ">=1", most=1_000_000)
    levels: int = setting(
        200, "random levels for CVaR10, the success rate on the worst tenth; 0: none", most=1_000_000, least=0
    )
    level_episodes: int = setting(10, "episodes on each, an even number", most=10_000, least=2)
    from_: Path | None = setting(None, "initialize students from this run; from a comparison of one method, by seed")
    out: Path | None = setting(None, "output folder (default runs/compare-MINIGAME)")
    rrd: Path | None = setting(None, "Rerun file for the curves of all runs")
    format: plots.PictureFormat = setting("png", plots.FORMAT_HELP)
    config_: Path | None = setting(None, "settings from a config.json or run folder")
    preset: Literal["fast", "thesis"] = setting("fast", "preset of settings: fast, or thesis (images; takes a day)")
    launch: LaunchConfig = group(LaunchConfig, "launching runs", prefix="")
    train: Any = group(TrainConfig, "each run", without=CHOSEN)
    fine_tuning: FineTuningConfig = group(FineTuningConfig, "with --from", prefix="")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_levels(self.levels, self.level_episodes)
        if len(set(self.methods)) < len(self.methods) or not (self.methods or self.variants):
            raise ValueError(f"methods must be one or more, without repetition, got {' '.join(self.methods) or 'none'}")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    config, game = _read(argv)
    return run(config, game)


def folder_of(config: CompareConfig, game: Game) -> Path:
    """Return the folder of a comparison."""
    return config.out or Path("runs") / f"compare-{game.short}"


def run(config: CompareConfig, game: Game, most: int | None = None) -> int:
    """Train and evaluate all runs, and write tables and pictures; return the exit code.

    `most` is the maximum number of processes for evaluation; None: as many as for training.
    """
    folder, seeds = folder_of(config, game), range(config.first_seed, config.first_seed + config.seeds)
    rows = rows_of(config.methods, config.variants, replace(config.train, minigame=game.name))
    runs = prepare(folder, rows, seeds, config.from_, config.fine_tuning)
    # This compiles the kernels once, before several processes start.
    scenes = EvalScenes(runs[0].config, game, config.episodes, config.held_out)
    with StopRequest() as stop:
        trained = train_unfinished(runs, config.launch, stop)
    if not trained:
        return stop.exit_code
    warn_of_changed_tasks(runs)
    amount = f"{counted(len(runs), 'run')} and baselines on {counted(len(scenes.scenes), 'scene')}"
    print(f"evaluating {amount}, {counted(config.episodes, 'episode')} each")
    alone = config.launch.launcher != "local" or config.train.engine == "grf"  # Ray and GRF have their own processes
    parallel = 1 if alone else config.launch.at_a_time(config.train.threads, len(runs))
    parallel = min(parallel, most or parallel)
    report = Evaluator(scenes, config.levels, config.level_episodes, alike=True, processes=parallel).report(runs)
    show(report, runs, scenes, folder, config.rrd, config.format)
    return 0


def show(
    report: Report,
    runs: Sequence[RunFolder],
    scenes: EvalScenes,
    folder: Path,
    rrd: Path | None = None,
    kind: plots.PictureFormat = "png",
) -> None:
    """Print and write tables and pictures of this `kind`; record the curves of all runs at `rrd`."""
    upomdp, task = scenes.scenes[TRAINING_SCENE], scenes.task
    painter = task.painter(upomdp) if task.painter else None
    by_method: dict[str, list[Path]] = {}
    for run in runs:
        by_method.setdefault(run.name, []).append(run.path)
    plots.distinguish({run.name: run.config.method for run in runs if run.name not in METHODS})
    with read_from(f"the tables of a run in {folder} are"):
        comparison = Comparison(scenes.game.short, by_method, report.results, painter, report.word, upomdp.parameters)
        draw(comparison, folder, kind)
    report.save(folder)
    print(f"\n{report.text(terminal_width())}\n")
    print(f"tables: {folder}/table.md, table.csv; by run: results.csv, levels.csv")
    drawn = ["overview"] * (painter is not None) + ["learning_curves", "levels"]
    print(f"pictures: {folder}/{', '.join(f'{name}.{kind}' for name in drawn)}")
    if runs[-1].recordings():
        print(f"curriculum: rerun {runs[-1].path}/curriculum*.rrd")
    if rrd is not None:
        from regista.experiments.pictures.runs_recording import record_runs

        record_runs(by_method, rrd)
        print(f"all runs: rerun {rrd}")


def draw(comparison: Comparison, folder: Path, kind: plots.PictureFormat = "png") -> None:
    """Draw the pictures of a comparison: three, or two for a task without a painter."""
    curves.learning_curves(comparison.runs, folder / f"learning_curves.{kind}")
    levels = folder / f"levels.{kind}"
    if comparison.painter is None:
        return theta_plots.levels(comparison.runs, levels, comparison.draws)
    level_plots.levels(comparison.runs, comparison.painter, levels, comparison.draws)
    overview(comparison, folder / f"overview.{kind}")


def _read(argv: Sequence[str]) -> tuple[CompareConfig, Game]:
    """Return the parsed arguments and the game."""
    known = CompareConfig(train=starting.settings_for(argv))
    others = {case: [CompareConfig(train=t) for t in trains] for case, trains in starting.other_settings(argv).items()}
    typed = arguments.typed_settings(known, argv, "compare", DESCRIPTION, others)
    game, start = starting.start_of(typed, typed.get("minigame"), CompareConfig().minigame)
    starting.warn_of_origin(typed)
    if "from_" in typed:
        seed = typed.get("first_seed", CompareConfig().first_seed)
        start = origin.like(origin.load(origin.of_seed(typed["from_"], seed)), start)
    if "variants" in typed:
        typed.setdefault("methods", ())
    config = arguments.replace_paths(CompareConfig(train=start), typed)
    origin.check_needed(config.from_, config.fine_tuning)
    for method in config.methods:
        build.find_method(method)
    rows = rows_of(config.methods, config.variants, config.train)
    build.check_used((name.removeprefix("train.") for name in typed), [row.config.method for row in rows])
    build.find_device(config.train.device)
    return config, game
