"""Runs of chapter 4 of the thesis: four games with their figures, five methods, and the six games of Table 4.1.

Where the thesis does not specify a setting, it is that of the repository's studies of curricula. Read next:
`lab/thesis/study.py`, which trains and plays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from lab.studies.curricula import LONG, PPO, Settings
from lab.studies.rows import TRAIN, Row
from lab.studies.runs import training
from regista.experiments.run.config import TrainConfig, presets
from regista.experiments.run.games import find_minigame
from regista.minigames.published import published

SEEDS = range(10)  # of final tables; nothing is tuned on them
STEPS = 5_000_000  # simulated, of all students together
EPISODES = 500  # on each scene
LONGER = {"offense/avoid_pass_shoot": 10_000_000}  # Table 4.1: "(10M)"
TABLE = "Table 4.1"


class Figure(NamedTuple):
    """A figure of results: its number in the thesis, and the thesis's name of the game."""

    number: str
    title: str


FIGURES = {
    "1v1Restricted": Figure("4.5", "1v1 Restricted"),
    "1v1Free": Figure("4.6", "1v1 Free"),
    "ChoosePassing": Figure("4.7", "Choose Pass"),
    "3v2FourBehaviors": Figure("4.8", "3v2 4 behaviors"),
}


class Method(NamedTuple):
    """A method of `regista train`, settings by dotted path, its name in figures, and its share of the steps."""

    method: str
    settings: Settings
    title: str
    share: float = 1.0


OWN_REGRET = {"paired.roles": "population", "paired.dr_fraction": 0.25}  # defaults, also with --preset thesis
METHODS = {  # the first is the reference
    "dr": Method("dr", {}, "DR"),
    "dr_half": Method("dr", {}, "DR, half of the steps", 0.5),  # the steps of PAIRED's protagonist
    "paired_literal": Method("paired_literal", {}, "PAIRED, Algorithm 1"),
    "paired_dennis2020": Method("paired", OWN_REGRET | {"paired.roles": "dennis2020"}, "PAIRED (Dennis et al.)"),
    "paired": Method("paired", OWN_REGRET, "PAIRED (default)"),
}


class Budget(NamedTuple):
    """The runs of an experiment: their seeds, the preset of their settings, and the steps of each run."""

    seeds: Sequence[int] = SEEDS
    preset: str = "fast"
    env_steps: int = STEPS

    def settings(self, more: Settings, share: float = 1.0) -> Settings:
        """Return the settings of a run with this share of the steps, by dotted path."""
        return {"total_env_steps": int(self.env_steps * share)} | (LONG | PPO if self.preset == "fast" else {}) | more


class Arm(NamedTuple):
    """A run: a game, a name of `METHODS`, a seed, and all resulting settings."""

    game: str
    agent: str
    seed: int
    settings: Settings


def base(preset: str) -> TrainConfig:
    """Return the starting settings of a preset's runs.

    `fast`: features and a small network; `thesis`: stacked SMM images, the network of Figure 4.10 and Table 4.2.
    """
    start = training()
    if preset == "fast":
        return start
    chosen = presets()[preset]
    return replace(start, env=chosen.env, ppo=chosen.ppo, paired=chosen.paired, num_envs=chosen.num_envs)


def paired_arms(games: Sequence[str], methods: Sequence[str], budget: Budget) -> Iterator[Arm]:
    """Yield the runs of Figures 4.5 to 4.9, seed by seed."""
    for seed in budget.seeds:
        for game in games:
            for agent in methods:
                chosen = METHODS[agent]
                settings = budget.settings(chosen.settings | {"method": chosen.method}, chosen.share)
                yield Arm(game, agent, seed, settings)


def in_order(rows: Sequence[Row]) -> list[Row]:
    """Return rows by method and scene in the order of figures: the training distribution, then the game's tests."""
    agents = [*METHODS]

    def place(row: Row) -> tuple[int, int]:
        scenes = [TRAIN, *(label for label, _ in find_minigame(row.game).tests)]
        return agents.index(row.agent) if row.agent in agents else len(agents), scenes.index(row.scene)

    return sorted(rows, key=place)


def table_games() -> list[str]:
    """Return the games of Table 4.1."""
    return list(dict.fromkeys(row.game for row in published() if row.source == TABLE))


def table_arms(games: Sequence[str], budget: Budget) -> Iterator[Arm]:
    """Yield the runs of Table 4.1: DR, twice as long in games for which the thesis trains for 10M steps."""
    for seed in budget.seeds:
        for game in games:
            steps = budget.env_steps * LONGER.get(game, STEPS) // STEPS
            yield Arm(game, "dr", seed, budget.settings({"total_env_steps": steps, "method": "dr"}))
