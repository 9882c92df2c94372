"""The study of what carries over to Google Research Football: trains games, and plays them in both engines.

Read next: `commands.transfer`, which plays; `studies.runs`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from regista.experiments.commands import transfer
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.workers import train_unfinished
from regista.experiments.studies.runs import CHOSEN, STEPS, Deadline, StudyConfig, StudyRuns, training
from ued.config import setting

BUDGETS = {  # steps after which returns hardly rise any more
    "academy/run_to_score": 500_000,
    "academy/run_to_score_with_keeper": 1_000_000,
    "academy/pass_and_shoot_with_keeper": 500_000,
    "academy/run_pass_and_shoot_with_keeper": 500_000,
    "academy/3_vs_1_with_keeper": 500_000,
    "academy/counterattack_easy": 1_000_000,
    "1v1Restricted": 1_000_000,
    "1v1Free": 1_000_000,
    "3v2FourBehaviors": 1_000_000,
}


@dataclass(frozen=True)
class TransferStudyConfig(StudyConfig):
    """What is typed after `regista study transfer`."""

    games: tuple[str, ...] = setting(
        tuple(BUDGETS), "minigames, each with a budget of its own unless --total-env-steps says otherwise"
    )
    representations: tuple[str, ...] = setting(("simple115", "features"), "what agents see, one after the other")
    out: Path = setting(Path("runs/transfer"), "folder of the study")
    episodes: int = setting(200, "whole episodes of each run in our simulator", ">=1", most=1_000_000)
    grf_episodes: int = setting(50, "whole episodes of each run in the other engine", ">=1", most=1_000_000)
    policies: tuple[str, ...] = setting(("sampled",), "how actions are chosen: sampled, greedy")
    train: TrainConfig = group(lambda: training("scoring,checkpoints"), "each run", without=CHOSEN)

    def __post_init__(self) -> None:
        super().__post_init__()
        transfer.check_policies(self.policies)


def run_transfer(name: str, config: TransferStudyConfig, typed: dict[str, Any]) -> int:
    """Train the runs that are not there yet, and play all in both engines; return the exit code."""
    if "env.representation" in typed:
        raise UsageError("a study takes --representations, several of them")
    runs = prepare(config, typed)
    with Deadline(config.hours) as stop:
        trained = train_unfinished(runs, config.launch, stop)
    if not trained:
        return stop.exit_code
    return transfer.main(words_of(config, runs))


def prepare(config: TransferStudyConfig, typed: dict[str, Any]) -> list[RunFolder]:
    """Create the run folders that are not there yet, and open the others; one seed of everything after the other."""
    runs = []
    study = StudyRuns(config.out, config.train, typed)
    for seed in range(config.seeds):
        for representation in config.representations:
            for game in config.games:
                steps = typed.get("total_env_steps", BUDGETS.get(game, STEPS))
                runs.append(study.open(game, seed, {"total_env_steps": steps, "env.representation": representation}))
    return runs


def words_of(config: TransferStudyConfig, runs: Sequence[RunFolder]) -> list[str]:
    """Return what would be typed after `regista transfer`."""
    episodes = ["--episodes", str(config.episodes), "--grf-episodes", str(config.grf_episodes)]
    files = ["--csv", str(config.out / "transfer.csv"), "--markdown", str(config.out / "transfer.md")]
    paths = [str(run.path) for run in runs]
    return [*paths, "--kept", "--no-details", "--policies", *config.policies, *episodes, *files]
