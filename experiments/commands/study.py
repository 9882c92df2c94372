"""`regista study transfer`: train games over seeds and representations, and play them all in the real engine.

    regista study transfer                                                       # what `make transfer` does
    regista study transfer --games academy/run_to_score --seeds 1 --total-env-steps 200_000 --out runs/small

Every run is a folder beneath `--out`; a second call skips what is finished, continues what is not, and plays in both
engines what has not been played. Read next: `run.workers`, which trains; `commands.transfer`, which plays.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from envs.football.config import FootballConfig
from experiments.commands import transfer
from experiments.run import arguments, build
from experiments.run.arguments import group, positional
from experiments.run.config import TrainConfig
from experiments.run.errors import UsageError
from experiments.run.folder import RunFolder
from experiments.run.signals import StopRequest
from experiments.run.workers import train_all
from ued.config import Checked, setting

DESCRIPTION = (
    "Train games over seeds and representations, play every run in our simulator and in Google Research Football, and "
    "write the table of what carries over. Can be stopped at any time; called again, it continues."
)
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
OTHERS = 1_000_000  # steps of a game that is not among these
OWN = ("minigame", "seed")  # settings of a run that the study chooses, beside the representation


def training() -> TrainConfig:
    """Return what runs of a study begin with: nothing but training, paid for checkpoints, too."""
    env = FootballConfig(rewards="scoring,checkpoints")
    return TrainConfig(method="dr", total_env_steps=OTHERS, eval_every=0, record=False, env=env)


@dataclass(frozen=True)
class StudyConfig(Checked):
    """What is typed after `regista study`."""

    study: str = positional("what is studied: transfer", default="")
    games: tuple[str, ...] = setting(
        tuple(BUDGETS), "minigames, each with a budget of its own unless --total-env-steps says otherwise"
    )
    representations: tuple[str, ...] = setting(("simple115", "features"), "what agents see, one after the other")
    seeds: int = setting(3, "runs of each game and representation, with seeds 0, 1, ...", ">=1")
    processes: int = setting(0, "runs at a time; 0: one per core", ">=0")
    out: Path = setting(Path("runs/transfer"), "folder of the study")
    episodes: int = setting(200, "whole episodes of each run in our simulator", ">=1")
    grf_episodes: int = setting(50, "whole episodes of each run in the other engine", ">=1")
    policies: tuple[str, ...] = setting(("sampled",), "how actions are chosen: sampled, greedy")
    train: TrainConfig = group(training, "each run", without=OWN)

    def __post_init__(self) -> None:
        super().__post_init__()
        transfer.check_policies(self.policies)


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    typed = arguments.typed_settings(StudyConfig(), argv, "study", DESCRIPTION)
    if "train.env.representation" in typed:
        raise UsageError("a study takes --representations, several of them")
    config = arguments.replace_paths(StudyConfig(), typed)
    if config.study != "transfer":
        raise UsageError(f"there is one study, transfer, not {config.study!r}: regista study transfer")
    settings = {path.removeprefix("train."): value for path, value in typed.items() if path.startswith("train.")}
    runs = prepare(config, settings)
    unfinished = [run for run in runs if not run.finished()]
    with StopRequest() as stop:
        if unfinished:
            processes = min(config.processes or max(1, (os.cpu_count() or 1) // config.train.threads), len(unfinished))
            print(f"{len(runs)} runs, {len(runs) - len(unfinished)} finished; {processes} at a time", flush=True)
            train_all(unfinished, processes, stop)
    if stop:
        print("continue with the same command: finished runs are kept")
        return stop.exit_code
    return transfer.main(words_of_transfer(config, runs))


def prepare(config: StudyConfig, settings: dict[str, Any]) -> list[RunFolder]:
    """Create the run folders that are not there yet, and open the others; one seed of everything after the other."""
    runs = []
    for seed in range(config.seeds):
        for representation in config.representations:
            for game in config.games:
                minigame = build.find_minigame(game)
                env = replace(config.train.env, control=minigame.control)
                base = replace(config.train, total_env_steps=BUDGETS.get(game, OTHERS), env=env)
                run = arguments.replace_paths(base, settings)
                env = replace(run.env, representation=representation)
                run = replace(run, minigame=build.canonical_name(game), seed=seed, env=env)
                name = f"{minigame.name.replace('/', '_')}-{representation}-{seed}"
                runs.append(RunFolder.create_or_extend(config.out / name, run))
    return runs


def words_of_transfer(config: StudyConfig, runs: Sequence[RunFolder]) -> list[str]:
    """Return what would be typed after `regista transfer`."""
    episodes = ["--episodes", str(config.episodes), "--grf-episodes", str(config.grf_episodes)]
    files = ["--csv", str(config.out / "transfer.csv"), "--markdown", str(config.out / "transfer.md")]
    paths = [str(run.path) for run in runs]
    return [*paths, "--kept", "--no-details", "--policies", *config.policies, *episodes, *files]
