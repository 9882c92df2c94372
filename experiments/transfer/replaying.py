"""Replays of a trained policy in our simulator and in GRF, on the same levels.

Read next: `transfer.goals`, the origin of goals; `transfer.report`, the tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.constants import NUM_ACTIONS
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import build
from regista.experiments.run.config import TEST_ENVS, EngineConfig
from regista.experiments.run.errors import CommandError
from regista.experiments.run.evaluator import load_student
from regista.experiments.run.games import single_game
from regista.experiments.run.watch import Watch
from regista.experiments.transfer.episodes import ENDINGS, Choose, Episodes, play, play_keys, side_by_side
from regista.experiments.transfer.goals import goals_of

if TYPE_CHECKING:
    from regista.envs.football.config import FootballConfig
    from regista.envs.football.kick_off import Roster
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.experiments.pictures.side_by_side import SideBySide
    from regista.experiments.run.folder import RunFolder

SEED = 20_100  # of levels and actions, equal for all runs of a game
SLACK = 0.1  # tolerance around the observed range, in a feature's unit
FAR = 5.0  # standard deviations from the training mean that count as outside of training
NAMED = 3  # number of features in the report
POLICIES = ("sampled", "greedy")
EPISODES = 500, 200  # in our simulator and in the other engine


@dataclass(frozen=True)
class Leaving:
    """Features outside a range: share of episodes, median first step, and the first features outside."""

    share: float
    step: float | None  # None: never
    first: tuple[str, ...]

    def line(self) -> str:
        """Return this as text."""
        if self.step is None:
            return "never"
        return f"in {self.share:.0%} of the episodes, at step {self.step:g}: {', '.join(self.first)}"


@dataclass(frozen=True)
class Result:
    """Results of one run's policy in both engines, as plain numbers; `ours` and `grf` come from `summary`.

    `game`, `representation` and `method` are those of the run; the report groups runs by them.
    """

    run: str
    game: str
    representation: str
    method: str
    policy: str
    ours: dict[str, Any]
    grf: dict[str, Any]
    leaves_ours: dict[str, Any]  # a `Leaving`, as is leaves_training
    leaves_training: dict[str, Any]

    @property
    def engines(self) -> dict[str, dict[str, Any]]:
        return {"ours": self.ours, "grf": self.grf}


@dataclass(frozen=True)
class Played:
    """Episodes of one run's policy in both engines.

    `unit` and `names` describe the features `[F]`; `mean` and `deviation` come from the observation normalizer.
    """

    ours: Episodes
    grf: Episodes
    roster: Roster
    names: tuple[str, ...]
    unit: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray

    def numbers(self) -> dict[str, Any]:
        """Return the Result of these episodes."""
        return {
            "ours": summary(self.ours, self.roster),
            "grf": summary(self.grf, self.roster),
            "leaves_ours": asdict(self.leaves_ours()),
            "leaves_training": asdict(self.leaves_training()),
        }

    def leaves_ours(self) -> Leaving:
        """Return when the other engine's features leave their range in our episodes."""
        return leaving(self._outside_ours(), self.names)

    def leaves_training(self) -> Leaving:
        """Return when features leave our range and are over FAR standard deviations from their training mean."""
        far = np.abs(self.grf.observations - self.mean) > FAR * self.deviation
        return leaving(far & self._outside_ours(), self.names)

    def _outside_ours(self) -> np.ndarray:
        """Return whether the other engine's features are outside of their range in our episodes: bool, same shape."""
        seen = self.ours.observations.reshape(-1, len(self.unit))
        low, high = np.nanmin(seen, 0) - SLACK * self.unit, np.nanmax(seen, 0) + SLACK * self.unit
        return (self.grf.observations < low) | (self.grf.observations > high)


def leaving(outside: Any, names: Sequence[str]) -> Leaving:
    """Return when features are first outside in each episode: bool `[E, T, F]`, for a team `[E, T, A, F]`."""
    outside = outside.reshape(*outside.shape[:2], -1, outside.shape[-1]).any(2)
    at = np.asarray(outside.any(2))
    rows = np.flatnonzero(at.any(1))
    if not len(rows):
        return Leaving(0.0, None, ())
    steps = at[rows].argmax(1)
    counts = outside[rows, steps].sum(0)
    chosen = [index for index in np.argsort(-counts, kind="stable")[:NAMED] if counts[index]]
    return Leaving(len(rows) / len(at), float(np.median(steps)), tuple(names[index] for index in chosen))


def summary(episodes: Episodes, roster: Roster) -> dict[str, Any]:
    """Summarize episodes as plain numbers."""
    actions = episodes.actions[episodes.actions >= 0]
    endings = episodes.endings()
    return {
        "episodes": len(episodes),
        "goals": int(episodes.scored.sum()),
        "mean_return": float(episodes.returns.mean()),
        "return_error": float(episodes.returns.std() / np.sqrt(len(episodes))),
        "median_length": float(np.median(episodes.lengths)),
        "endings": {word: float((endings == word).mean()) for word in ENDINGS[:-1]},
        "actions": (np.bincount(actions, minlength=NUM_ACTIONS) / max(len(actions), 1)).tolist(),
        "goals_from": goals_of(episodes, roster).summary(),
    }


# ---------------------------------------------------------------- playing


@dataclass(frozen=True)
class Plan:
    """A plan: episodes in our simulator and in the other engine, policies, and number of recorded episodes.

    `seconds`: time limit of each policy in the other engine; None: no limit.
    """

    other: EngineConfig
    episodes: tuple[int, int]
    policies: tuple[str, ...] = POLICIES
    traces: int = 0
    threads: int = 1
    seconds: float | None = None

    def settings(self, run: RunFolder) -> dict[str, Any]:
        """Return the settings that identify saved results of a run, in the form that JSON returns."""
        trained = run.env_steps()
        return {
            "trained": trained,
            "engine": self.other.engine,
            "episodes": [*self.episodes],
            "seconds": self.seconds,
            "policies": [*self.policies],
            "simulator": SIMULATOR_VERSION,
        }


def play_run(run: RunFolder, plan: Plan) -> tuple[list[Result], list[SideBySide]]:
    """Play a run's policies in both engines; return the results and the episodes to record."""
    with BothEngines(run, plan) as engines:
        return engines.results()


class BothEngines:
    """A run's policy and its game in both engines. Close it after use."""

    def __init__(self, run: RunFolder, plan: Plan) -> None:
        config, self.run, self.plan = run.config, run, plan
        self.game = single_game(config.minigame)
        program = self.game.program(config)
        self.student, _ = load_student(run, self.game)
        self._stack = ExitStack()
        engines = (
            EngineConfig(engine="regista").instead_of(config.env),
            replace(plan.other, engine=plan.other.engine or "grf").instead_of(config.env),
        )
        self.envs = [self._make(program, env, count) for env, count in zip(engines, plan.episodes, strict=True)]
        space = self.envs[0].agent_observation_space
        if space.shape is None or len(space.shape) != 1:
            raise CommandError(f"{run.path}: transfer supports feature vectors as observations, got {space}")
        self.levels = self.envs[0].sample_levels(max(plan.episodes))

    def _make(self, program: Any, config: FootballConfig, count: int) -> FootballVectorEnv:
        most = min(TEST_ENVS[config.engine], count)
        return self._stack.enter_context(closing(build.make_matches(program, most, config, SEED, self.plan.threads)))

    def __enter__(self) -> BothEngines:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def results(self) -> tuple[list[Result], list[SideBySide]]:
        """Play the policies; return the results and the episodes to record."""
        config = self.run.config
        of_run = (self.run.path.name, self.game.short, config.env.representation, config.method)
        results: list[Result] = []
        recorded: list[SideBySide] = []
        for policy in self.plan.policies:
            played = self._play(policy == "greedy")
            results.append(Result(*of_run, policy, **played.numbers()))
            if self.plan.traces and not recorded:
                recorded = self._recorded(played.ours)
        return results, recorded

    def _play(self, greedy: bool) -> Played:
        normaliser, env = self.student.normaliser, self.envs[0]
        deviation = np.maximum(np.sqrt(normaliser.variance.numpy() + 1e-8), normaliser.floor.numpy())
        unit = env.observation_scale
        assert unit is not None
        watches = Watch(self.plan.episodes[0]), Watch(self.plan.episodes[1], self.plan.seconds)
        ours, grf = (
            play(engine, self._choose(greedy), self.levels[:count], None, True, watch.go_on)
            for engine, count, watch in zip(self.envs, self.plan.episodes, watches, strict=True)
        )
        names = feature_names(env, len(unit))
        return Played(ours, grf, env.lineup.roster, names, unit, normaliser.mean.numpy(), deviation)

    def _recorded(self, ours: Episodes) -> list[SideBySide]:
        """Replay the actions of some of our episodes in the other engine."""
        from regista.envs.football.view.render import FootballPainter

        painter = FootballPainter(self.envs[0].lineup)
        count = min(self.plan.traces, *self.plan.episodes)
        actions = np.maximum(ours.actions[:count], 0)
        grf = play_keys(self.envs[1], actions, self.levels[:count])
        return [side_by_side(f"{self.run.path.name} {row}", painter, ours, grf, row) for row in range(count)]

    def _choose(self, greedy: bool) -> Choose:
        from ued.core.seeding import torch_generator
        from ued.learning.student import Player

        player = Player(self.student, torch_generator(SEED), greedy)

        def choose(observation: np.ndarray, step: int) -> np.ndarray:
            if step == 0:
                player.begin()
            return player(observation)

        return choose


def feature_names(env: FootballVectorEnv, count: int) -> tuple[str, ...]:
    """Return the names of an environment's features."""
    from regista.envs.football.observation.features import features_names
    from regista.envs.football.observation.simple115 import SIZE, simple115_names

    if env.config.representation == "simple115" and count == SIZE:
        return simple115_names()
    return features_names(env.num_players)
