"""The runs of a study: their folders and settings, the number trained at a time, and the time limit.

Read next: `regista.experiments.run.launch.workers`, which trains; `lab/studies/measuring.py`, which plays.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from lab.studies.rows import RESULTS
from regista.envs.football.config import FootballConfig
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.workers import LaunchConfig, train_unfinished
from ued.config import Checked, setting

STEPS = 1_000_000  # of a run, for studies without their own budget
CHOSEN = ("minigame", "seed")  # settings of a run that the study chooses
# Settings that may be changed on the command line without leaving the study's own
BOOKKEEPING = {"total_env_steps", "threads", "checkpoint_seconds", "record", "record_rollouts", "record_limit"}
ROOT = Path(__file__).resolve().parents[2]  # of the checkout
LONGEST = 24 * 365.0  # hours, the default limit


def training(rewards: str = "scoring") -> TrainConfig:
    """Return the starting settings of a study's runs: training only, without evaluation or recording."""
    env = FootballConfig(rewards=rewards)
    return TrainConfig(method="dr", total_env_steps=STEPS, eval_every=0, record=False, env=env)


class Places(NamedTuple):
    """Output locations of a study: a folder of CSV files, and a page of its tables; None: the tables are printed."""

    results: Path
    page: Path | None

    @classmethod
    def of(cls, out: Path | None, page: str) -> Places:
        """Return the places beneath a folder, or those of the repository if `out` is None."""
        return cls(RESULTS, ROOT / page) if out is None else cls(out / "results", None)


@dataclass(frozen=True)
class StudyConfig(Checked):
    """Arguments that all studies share."""

    games: tuple[str, ...] = setting((), "minigames instead of the study's own")
    hours: float = setting(LONGEST, "stop after so long; called again, it goes on", ">0", most=1_000_000)
    launch: LaunchConfig = group(LaunchConfig, "who trains the runs", prefix="")


@dataclass(frozen=True)
class StudyRuns:
    """Folders and settings of a study's runs.

    Attributes:
        folder: parent of all run folders.
        base: starting settings.
        typed: settings given on the command line, by dotted path.
    """

    folder: Path
    base: TrainConfig
    typed: dict[str, Any]

    def plan(
        self, game: str, seed: int, chosen: Mapping[str, Any] | None = None, kind: str = ""
    ) -> tuple[Path, TrainConfig]:
        """Return a run's folder and settings: the base, changed by the minigame, by `typed` and by `chosen`.

        `kind` is the part of the folder's name after the game. Raises `UsageError` for an unknown game.
        """
        found = build.find_game(game)
        control = found.start("fast").env.control
        base = replace(self.base, env=replace(self.base.env, control=control))
        settings = {**self.typed, **(chosen or {})}
        config = replace(arguments.replace_paths(base, settings), minigame=found.name, seed=seed)
        team = "" if config.env.control == control else f"{config.env.control}-"
        name = f"{found.short.replace('/', '_')}-{team}{kind}{config.env.representation}-{seed}"
        return self.folder / name, config

    def open(self, game: str, seed: int, chosen: Mapping[str, Any] | None = None, kind: str = "") -> RunFolder:
        """Create the folder of a run, or open it if it was made with the same settings; see `plan`."""
        return RunFolder.create_or_extend(*self.plan(game, seed, chosen, kind))


class Deadline(StopRequest):
    """A request to stop after `hours` hours; unlike a signal, it leaves the exit code at 0."""

    def __init__(self, hours: float) -> None:
        super().__init__()
        self._end = time.monotonic() + 3600 * hours

    def __bool__(self) -> bool:
        return super().__bool__() or time.monotonic() >= self._end


def train_and_measure(
    runs: Sequence[RunFolder], how: LaunchConfig, stop: StopRequest, measure: Callable[[RunFolder], None]
) -> bool:
    """Train the unfinished runs, and `measure` each run as soon as it is finished; return whether all are measured.

    A study that is stopped or killed thus loses only the measurement of runs that have just ended.
    """
    for run in runs:
        if run.finished() and not stop:
            measure(run)
    return train_unfinished(runs, how, stop, measure)
