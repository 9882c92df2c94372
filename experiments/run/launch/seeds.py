"""Runs of several seeds, each in a folder `NAME-SEED` of one folder: `compare`, `train --seeds`.

Read next: `run.launch.workers`, which trains them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from regista.experiments.run import build, origin
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.variants import Variant
from regista.experiments.run.launch.workers import LaunchConfig, train_unfinished
from regista.experiments.run.progress import counted
from ued.config import FineTuningConfig


def prepare(
    folder: Path, rows: Sequence[Variant], seeds: range, source: Path | None, tuning: FineTuningConfig
) -> list[RunFolder]:
    """Create the missing run folders of each row and seed, and open existing ones, whose settings must match.

    `source` is the run that initializes students, or a folder of one run for each seed; None: random initialization.
    Raises `CommandError` if `folder` itself is a run.
    """
    if (folder / "config.json").exists():
        raise CommandError(f"{folder} is a run folder; several runs need a separate folder, --out")
    runs = [
        RunFolder.create_or_extend(folder / f"{row.name}-{seed}", replace(row.config, seed=seed), row.name)
        for seed in seeds
        for row in rows
    ]
    origin.begin_all(runs, source, tuning)
    return runs


def opened(folder: Path) -> list[RunFolder]:
    """Return the runs in a folder made by `prepare`, by seed; empty without runs, or if it is a run folder itself."""
    if (folder / "config.json").exists():
        return []
    runs = [RunFolder.open(file.parent) for file in sorted(folder.glob("*-*/config.json"))]
    alike = [run for run in runs if run.path.name == f"{run.name}-{run.config.seed}"]
    return sorted(alike, key=lambda run: run.config.seed)


def train_together(runs: Sequence[RunFolder], how: LaunchConfig) -> int:
    """Train the unfinished of these runs in parallel and return the exit code of the command."""
    config = runs[0].config
    # This compiles the kernels and detects errors of the task once, before several processes start.
    build.find_game(config.minigame).task(config)
    with StopRequest() as stop:
        trained = train_unfinished(runs, how, stop)
    if trained:
        names = dict.fromkeys(f"{run.path.parent / run.name}-*" for run in runs)
        print(f"{counted(len(runs), 'run')} finished; evaluate them: regista evaluate {' '.join(names)}")
    return stop.exit_code
