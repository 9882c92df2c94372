"""A trained policy in our simulator and in the real engine: the same weights on the same levels, and what became of it.

Read next: `grf.goals`, where goals come from; `commands.transfer`, which shows all this.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from envs.football.constants import NUM_ACTIONS
from experiments.grf.episodes import ENDINGS, Choose, Episodes, play, play_keys, side_by_side
from experiments.grf.goals import Goals, goals_of
from experiments.run import build
from experiments.run.errors import CommandError
from experiments.run.evaluator import ENVIRONMENTS, load_student
from ued.statistics import Interval, bootstrap, wilson

if TYPE_CHECKING:
    from envs.football.config import FootballConfig
    from envs.football.kick_off import Roster
    from envs.football.vector_env import FootballVectorEnv
    from experiments.run.folder import RunFolder
    from ued.recorder.side_by_side import SideBySide

SEED = 20_100  # of levels and actions: all runs of a game meet the same
SLACK = 0.1  # of a feature's unit, by which it may leave what was seen
FAR = 5.0  # standard deviations, beyond which training has not shown it
NAMED = 3  # features that are named
SAMPLES = 4000  # of an interval


@dataclass(frozen=True)
class Leaving:
    """When features leave a range: in which share of the episodes, at which step (median), which ones first."""

    share: float
    step: float  # nan: never
    first: tuple[str, ...]

    def plain(self) -> dict[str, Any]:
        """Return the same as JSON can hold it."""
        return {"share": self.share, "step": self.step if self.share else None, "first": list(self.first)}

    def line(self) -> str:
        """Return the same in words."""
        if not self.share:
            return "never"
        return f"in {self.share:.0%} of the episodes, at step {self.step:g}: {', '.join(self.first)}"


@dataclass(frozen=True)
class Transfer:
    """One run's policy, sampled or greedy, in both engines; `unit` and `names` are those of the features `[F]`."""

    run: str
    game: str  # runs of one game, representation and method are told of together
    policy: str
    ours: Episodes
    grf: Episodes
    roster: Roster
    names: tuple[str, ...]
    unit: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray

    @cached_property
    def ratio(self) -> Interval:
        """The goal rate there as a multiple of that here."""
        return rate_ratio([self])

    def episodes(self) -> dict[str, Episodes]:
        """Return both by engine."""
        return {"ours": self.ours, "grf": self.grf}

    def goals(self) -> dict[str, Goals]:
        """Return where the goals come from, by engine."""
        return {engine: goals_of(episodes, self.roster) for engine, episodes in self.episodes().items()}

    def leaves_ours(self) -> Leaving:
        """When features leave what they are in our episodes."""
        seen = self.ours.observations.reshape(-1, len(self.unit))
        low, high = np.nanmin(seen, 0) - SLACK * self.unit, np.nanmax(seen, 0) + SLACK * self.unit
        return leaving((self.grf.observations < low) | (self.grf.observations > high), self.names)

    def leaves_training(self, engine: str = "grf") -> Leaving:
        """When features are FAR standard deviations from their mean in training."""
        seen = self.episodes()[engine].observations
        return leaving(np.abs(seen - self.mean) > FAR * self.deviation, self.names)


def leaving(outside: Any, names: Sequence[str]) -> Leaving:
    """Return when features `[E, T, F]` are outside: the first step of each episode counts."""
    at = np.asarray(outside.any(2))
    rows = np.flatnonzero(at.any(1))
    if not len(rows):
        return Leaving(0.0, np.nan, ())
    steps = at[rows].argmax(1)
    counts = outside[rows, steps].sum(0)
    chosen = [index for index in np.argsort(-counts, kind="stable")[:NAMED] if counts[index]]
    return Leaving(len(rows) / len(at), float(np.median(steps)), tuple(names[index] for index in chosen))


def summary(episodes: Episodes) -> dict[str, Any]:
    """Return what became of some episodes, as plain numbers."""
    rate = wilson(int(episodes.scored.sum()), len(episodes))
    pressed = episodes.actions[episodes.actions >= 0]
    endings = episodes.endings()
    return {
        "episodes": len(episodes),
        "goals": int(episodes.scored.sum()),
        "goal_rate": rate.estimate,
        "goal_rate_low": rate.low,
        "goal_rate_high": rate.high,
        "mean_return": float(episodes.returns.mean()),
        "return_error": float(episodes.returns.std() / np.sqrt(len(episodes))),
        "median_length": float(np.median(episodes.lengths)),
        "endings": {word: float((endings == word).mean()) for word in ENDINGS[:-1]},
        "actions": (np.bincount(pressed, minlength=NUM_ACTIONS) / max(len(pressed), 1)).tolist(),
    }


def rate_ratio(transfers: Sequence[Transfer]) -> Interval:
    """Estimate the ratio of the goal rates, the engine's by ours; nan where nothing is scored here.

    One run: over its episodes, each rate drawn from Jeffreys' posterior. Several: of their means, resampling whole runs
    and the luck of their episodes.
    """
    rng = np.random.default_rng(SEED)
    counts = np.array([[[each.scored.sum(), len(each)] for each in (t.grf, t.ours)] for t in transfers])  # [R, 2, 2]
    goals, played = counts[..., 0], counts[..., 1]
    rates = goals / played
    if not rates[:, 1].any():
        return Interval(np.nan, np.nan, np.nan)
    if len(transfers) == 1:
        grf, ours = rng.beta(goals[0, :, None] + 0.5, (played - goals)[0, :, None] + 0.5, (2, SAMPLES))
        low, high = np.quantile(grf / ours, [0.025, 0.975])
        return Interval(float(rates[0, 0] / rates[0, 1]), float(low), float(high))
    likely = (goals + 2) / (played + 4)  # Agresti and Coull (1998): no goal at all is not certainty
    errors = np.sqrt(likely * (1 - likely) / (played + 4))
    found = bootstrap(rates, rng, _ratio, errors, SAMPLES).interval()
    return found._replace(low=max(found.low, 0.0), high=max(found.high, 0.0))


def _ratio(rates: np.ndarray) -> float:
    return float(rates[:, 0].mean() / max(rates[:, 1].mean(), 1e-3))


# ---------------------------------------------------------------- playing


@dataclass(frozen=True)
class Plan:
    """How much is played: episodes in ours and in the other engine, and how many are recorded side by side."""

    other: FootballConfig
    episodes: tuple[int, int]
    traces: int
    threads: int


class BothEngines:
    """A run's policy and its game in both engines. Close it when it is no longer needed."""

    def __init__(self, run: RunFolder, plan: Plan) -> None:
        from experiments.run.config import EngineConfig

        config, self.run, self.plan = run.config, run, plan
        program = build.load_scenes(config)[build.TRAINING_SCENE]
        self.student, _ = load_student(run, program)
        self._stack = ExitStack()
        ours = EngineConfig(engine="regista").instead_of(config.env)
        self.envs = [
            self._make(program, each, count) for each, count in zip((ours, plan.other), plan.episodes, strict=True)
        ]
        space = self.envs[0].single_observation_space
        if space.shape is None or len(space.shape) != 1 or self.envs[0].num_agents != 1:
            raise CommandError(f"{run.path}: transfer tells of one agent that sees features, not of {space}")
        self.levels = self.envs[0].sample_levels(max(plan.episodes))

    def _make(self, program: Any, config: FootballConfig, count: int) -> FootballVectorEnv:
        most = min(ENVIRONMENTS[config.engine], count)
        return self._stack.enter_context(closing(build.make_upomdp(program, most, config, SEED, self.plan.threads)))

    def __enter__(self) -> BothEngines:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def transfers(self) -> Iterator[Transfer]:
        """Play the policy sampled, then greedy."""
        config, env = self.run.config, self.envs[0]
        normaliser = self.student.normaliser
        deviation = np.maximum(np.sqrt(normaliser.variance.numpy() + 1e-8), normaliser.floor.numpy())
        unit = env.observation_unit
        assert unit is not None
        for policy in ("sampled", "greedy"):
            ours, grf = (
                play(each, self._choose(policy == "greedy"), self.levels[:count], observed=True)
                for each, count in zip(self.envs, self.plan.episodes, strict=True)
            )
            game = f"{build.find_minigame(config.minigame).name}, {config.env.representation}, {config.method}"
            features = (feature_names(env, len(unit)), unit, normaliser.mean.numpy(), deviation)
            yield Transfer(self.run.path.name, game, policy, ours, grf, env.lineup.roster, *features)

    def recorded(self, sampled: Transfer) -> list[SideBySide]:
        """Play the keys of some of our sampled episodes in the other engine."""
        painter = build.make_painter(self.envs[0].program, self.envs[0].lineup)
        count = min(self.plan.traces, *self.plan.episodes)
        keys = np.maximum(sampled.ours.actions[:count], 0)
        grf = play_keys(self.envs[1], keys, self.levels[:count])
        return [side_by_side(f"{sampled.run} {row}", painter, sampled.ours, grf, row) for row in range(count)]

    def _choose(self, greedy: bool) -> Choose:
        from ued.seeding import torch_generator

        generator = torch_generator(SEED)
        return lambda observation, step: self.student.play(observation, generator, greedy)


def feature_names(env: FootballVectorEnv, count: int) -> tuple[str, ...]:
    """Return the names of an environment's features."""
    from envs.football.observation.features import features_names
    from envs.football.observation.simple115 import SIZE, simple115_names

    if env.config.representation == "simple115" and count == SIZE:
        return simple115_names()
    return features_names(env.num_players)
