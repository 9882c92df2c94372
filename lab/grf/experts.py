"""Semi-expert programs in both engines: their goal rates in our simulator and in GRF, and the published rates.

A single-agent program controls the `active` player, which follows the behavior of the program's player. A team program
moves every player with a behavior: all are agents, as in GRF. The built-in AI moves the other players. Read next:
`minigames/experts`, the programs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.run.config import TEST_ENVS
from regista.experiments.run.report import two_digits
from regista.experiments.run.results import Counted, goal_rate
from regista.experiments.transfer.episodes import Episodes, play
from regista.minigames.published import find_published
from regista.minigames.suites import BENCHMARK, HERE
from ued.statistics import spearman

EPISODES = 50  # in each engine, at effort 1
OURS = FootballConfig(control="active")
SEED = 0
PAIRS = (("ours", "grf"), ("ours", "published"), ("grf", "published"))


@dataclass(frozen=True)
class Expert:
    """A program, and GRF's goal rate over `episodes` episodes (None if the number is unknown)."""

    name: str
    is_team: bool
    published: float
    episodes: int | None


@dataclass(frozen=True)
class Found:
    """A program's episodes in both engines."""

    expert: Expert
    ours: Episodes
    grf: Episodes

    def rates(self) -> dict[str, float]:
        """Return the three goal rates."""
        return {
            "ours": float(self.ours.scored.mean()),
            "grf": float(self.grf.scored.mean()),
            "published": self.expert.published,
        }

    def counted(self) -> dict[str, Counted]:
        """Return goals and episodes; published ones only if the number of episodes is known."""
        counts = {name: Counted(int(episodes.scored.sum()), len(episodes)) for name, episodes in self._both().items()}
        if self.expert.episodes is not None:
            goals = round(self.expert.published * self.expert.episodes)
            counts["published"] = Counted(goals, self.expert.episodes)
        return counts

    def line(self) -> list[str]:
        """Return a row of the table."""
        rates = {name: two_digits(goal_rate([count])) for name, count in self.counted().items()}
        rates.setdefault("published", f"{self.expert.published:.2f}")
        lengths = [f"{np.median(episodes.lengths):g}" for episodes in self._both().values()]
        agents = "a team" if self.expert.is_team else "one"
        return [self.expert.name, agents, rates["ours"], rates["grf"], rates["published"], *lengths]

    def numbers(self) -> dict[str, Any]:
        """Return all numbers in a form that JSON supports."""
        intervals = {name: goal_rate([count])._asdict() for name, count in self.counted().items()}
        lengths = {f"median_length_{name}": float(np.median(side.lengths)) for name, side in self._both().items()}
        return {"program": self.expert.name, "team": self.expert.is_team, **self.rates(), **lengths} | {
            "intervals": intervals
        }

    def _both(self) -> dict[str, Episodes]:
        return {"ours": self.ours, "grf": self.grf}


def experts() -> list[Expert]:
    """Return the programs with their published goal rates, single-agent programs first."""
    return [*_experts_of("expert"), *_experts_of("team_expert")]


def _experts_of(kind: str) -> Iterator[Expert]:
    for game in BENCHMARK.values():
        told = find_published(game.name, kind)
        if told is not None:
            yield Expert(getattr(game, kind).stem, kind == "team_expert", told.goal_difference, told.episodes)


def play_experts(
    chosen: Sequence[Expert], other: FootballConfig, episodes: int, told: Callable[[int], None] = lambda _: None
) -> Iterator[Found]:
    """Play programs in our simulator and in the engine of another configuration.

    Raises `regista.envs.grf.workers.GrfError` if GRF is requested but not installed.
    """
    for number, expert in enumerate(chosen):
        yield Found(expert, *(play_expert(expert, config, episodes) for config in (OURS, other)))
        told(number + 1)


def play_expert(expert: Expert, config: FootballConfig, episodes: int, seed: int = SEED) -> Episodes:
    """Play `episodes` episodes of a program, each on a different level drawn with the seed."""
    count = min(episodes, TEST_ENVS[config.engine])
    if expert.is_team:
        config = replace(config, control="all")
    with closing(FootballVectorEnv(HERE / "experts" / f"{expert.name}.scenic", count, config=config)) as env:
        env.reset(seed=seed)
        levels = env.sample_levels(episodes)
        if not expert.is_team:
            return play(env, lambda _, step: env.program_actions(), levels)
        with closing(env.with_scripted_policy()) as script:
            return play(script, lambda _, step: np.zeros(count, np.int64), levels)


def table(experts: Sequence[Found]) -> list[list[str]]:
    """Return a row for each program."""
    head = ["semi-expert program", "agents", "goals, ours", "goals, grf", "published", "length, ours", "length, grf"]
    return [head, *(expert.line() for expert in experts)]


def correlations(experts: Sequence[Found]) -> dict[str, float]:
    """Return Spearman's rank correlations of the goal rates over the programs; nan for fewer than two programs."""
    rates = [expert.rates() for expert in experts]
    return {
        f"{one}, {other}": spearman([rate[one] for rate in rates], [rate[other] for rate in rates])
        for one, other in PAIRS
    }
