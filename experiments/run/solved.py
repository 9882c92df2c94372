"""`regista list --solved`: shares of a game's random levels that are never, sometimes and always solved.

    regista list --solved 1v1Free Gauntlet Buildup --total-env-steps 2_000_000

A random policy and a student at several points of its training play the same random levels. A curriculum can help if
most but not all levels are unsolved, and if this changes as the student learns.
Read next: `regista.minigames.suites`; `commands.compare`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run import arguments, build, versions
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.games import Game, football_game
from regista.experiments.run.progress import count
from regista.experiments.run.report import save_rows
from regista.experiments.run.results import align
from ued.config import Checked, setting

SEED = 30_000  # of the levels and of the episodes
ENVIRONMENTS = 64
CHOSEN = ("minigame",)  # settings of a run without a training flag
HEAD = ["game", "D", "policy", "env_steps", "solved", "levels never", "sometimes", "always"]


@dataclass(frozen=True)
class SolvedConfig(Checked):
    """Arguments of `regista list --solved GAMES`."""

    levels: int = setting(150, "number of random levels", ">=1", most=1_000_000)
    episodes: int = setting(4, "episodes on each level", ">=1", most=10_000)
    tests: int = setting(4, "evaluations during training, evenly spaced", ">=1", most=10_000)
    csv: Path | None = setting(None, "also write the rows to this CSV file")
    train: TrainConfig = group(lambda: TrainConfig(method="dr", seed=1000), "training of the students", without=CHOSEN)


@dataclass(frozen=True)
class Row:
    """Shares of a game's levels by outcome."""

    game: str
    dim: int
    who: str
    env_steps: int
    solved: float
    never: float
    sometimes: float
    always: float
    simulator: str  # the simulator version, formatted by `versions.spelled`

    def cells(self) -> list[str]:
        """Return the row of the table."""
        shares = [f"{share:.1%}" for share in (self.solved, self.never, self.sometimes, self.always)]
        return [self.game, str(self.dim), self.who, count(self.env_steps), *shares]


def report(names: Sequence[str], config: SolvedConfig, typed: Mapping[str, Any]) -> None:
    """Measure games and print a row for each evaluation; `typed` holds the given training settings.

    Raises `UsageError` without a game and for unknown ones.
    """
    if not names:
        raise UsageError("list --solved needs at least one game, such as 1v1Free")
    build.find_method(config.train.method)
    rows = []
    for game in [football_game(name) for name in names]:
        train = replace(SolvedConfig().train, minigame=game.name, env=game.start("fast").env)
        for row in measure(config, game, arguments.replace_paths(train, dict(typed))):
            rows.append(row)
            print("  ".join(row.cells()), flush=True)
    print(f"\n{align([HEAD, *(row.cells() for row in rows)])}")
    if config.csv is not None:
        save_rows([vars(row) for row in rows], list(vars(rows[0])), config.csv)


def measure(config: SolvedConfig, game: Game, train: TrainConfig) -> Iterator[Row]:
    """Train a student on a game; yield a row for a random policy, then rows for the student."""
    task, version = game.task(train), versions.present_version(train)
    test = build.make_upomdp(task.make, min(ENVIRONMENTS, config.levels), SEED)
    levels = test.sample_levels(config.levels)

    def play(policy: Any, who: str, env_steps: int) -> Row:
        shares = solved_shares(policy, test, levels, config.episodes)
        return Row(game.short, test.theta_dim, who, env_steps, *shares, versions.spelled(version))

    yield play(task.make_baselines(test)["random"], "random policy", 0)
    upomdp = build.make_upomdp(task.make, train.num_envs, train.seed)
    method, tested = build.make_method(train, upomdp), 0
    while method.env_steps < train.total_env_steps:
        method.update()
        if method.env_steps >= (tested + 1) * train.total_env_steps / config.tests:
            tested += 1
            yield play(method.student, train.method, method.env_steps)


def solved_shares(policy: Any, upomdp: Any, levels: np.ndarray, episodes: int) -> tuple[float, float, float, float]:
    """Return the share of successful episodes, and of levels `[L]` that are never, sometimes and always solved."""
    from ued.evaluation import evaluate

    success = evaluate(policy, upomdp, len(levels) * episodes, SEED, levels).success
    rate = success.reshape(episodes, len(levels)).mean(0)  # episode e plays level e mod L
    never, always = float(np.mean(rate == 0)), float(np.mean(rate == 1))
    return float(rate.mean()), never, 1 - never - always, always
