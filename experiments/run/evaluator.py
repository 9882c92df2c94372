"""Evaluation of policies on the test scenes of a minigame, during and after training.

Read next: `run.results`, the statistics; `run.report`, the tables.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from regista.experiments.run import build, trust, versions
from regista.experiments.run.errors import DAMAGE, CommandError, UsageError, refused
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.workers import apart
from regista.experiments.run.progress import counted
from regista.experiments.run.report import Report
from regista.experiments.run.results import BASELINE, LevelResult, Result, summarize, summarize_levels
from regista.experiments.run.watch import Watch
from ued.config import own_names
from ued.core.own_code import is_name
from ued.core.task import TRAINING_SCENE, Task, theta_of_scene

if TYPE_CHECKING:
    from regista.experiments.run.config import TrainConfig
    from regista.experiments.run.games import Game
    from ued.evaluation import Evaluation, Schedule

    Played = dict[str, Evaluation]  # by scene

SEED = 20_000  # of every evaluation, so all policies get the same levels and random numbers
LEVELS_SEED = 20_001  # of random levels
MOST_EPISODES = 10**9  # upper limit of a timed evaluation
SHARED_SECONDS = 30.0  # minimum duration for parallel evaluation, since processes take some seconds to start
MOST_NUMBERS = 2**22  # in the observations of one forward pass: convolutions need many times their memory
ROUNDS_APART = 1_000_003  # difference between the seeds of two rounds


class EvalScenes:
    """The test scenes of one game, with `episodes` on each and the reward of `config.scored()`.

    `held_out`: use the held-out scenes instead. Raises `UsageError` if the game has none, `CommandError` for test
    levels that do not belong to these environments.
    """

    def __init__(self, config: TrainConfig, game: Game, episodes: int, held_out: bool = False) -> None:
        self.episodes, self.every, self.game = episodes, config.eval_every, game
        self.config, self.held_out = config, held_out
        self.simulator = versions.present_version(config)
        self.task: Task = game.task(config.scored())
        if held_out and not self.task.held_out:
            raise UsageError(f"{game.short} has no held-out scenes")
        most, found = min(config.test_envs, episodes), self.task.scenes(held_out)
        self.scenes = {
            name: build.make_upomdp(self.task.make_scene(scene), most, SEED) for name, scene in found.items()
        }
        self.theta = {name: theta_of_test(name, scene, self.scenes[name], game.name) for name, scene in found.items()}
        self._check_sizes(config)

    def play(self, policy: Any, labels: Iterable[str] | None = None, round: int = 0, on_end: Any = None) -> Played:
        """Play `episodes` complete episodes on each scene, or only on `labels`; `policy.play` chooses the actions.

        Each `round` has its own levels and random numbers. `on_end` is called with the number of ended episodes.
        """
        from ued.evaluation import play_together

        labels = list(self.scenes if labels is None else labels)
        played: list[Evaluation] = []
        together = self._together(policy, labels)
        for first in range(0, len(labels), together):
            schedules = [self._schedule(label, round) for label in labels[first : first + together]]
            if together > 1:
                played += play_together(schedules, policy, on_end=on_end)
            else:
                played += [one.play(policy, on_end=on_end) for one in schedules]
        return dict(zip(labels, played, strict=True))

    def _together(self, policy: Any, labels: Sequence[str]) -> int:
        """Return how many scenes a policy plays side by side: as many as the memory for one forward pass allows."""
        from ued.learning.student import Student

        scenes = [self.scenes[label] for label in labels]
        bound = not isinstance(policy, Student)  # other policies may read the state of their environments
        if bound or self.config.engine == "grf" or len({id(scene) for scene in scenes}) < len(scenes):
            return 1  # a match in GRF occupies memory while it is played
        space = scenes[0].single_observation_space  # a `SparseImage` is expanded by convolutions
        return max(1, MOST_NUMBERS // (scenes[0].num_envs * math.prod(getattr(space, "image", space).shape)))

    def _schedule(self, label: str, round: int) -> Schedule:
        from ued.evaluation import Schedule

        scene, theta, seed = self.scenes[label], self.theta.get(label), SEED + round * ROUNDS_APART
        levels = None
        if theta is not None:
            scene.np_random = np.random.default_rng(seed)
            rows = (round * self.episodes + np.arange(self.episodes)) % len(theta)  # continue the previous round
            levels = scene.make_levels(theta[rows])  # each with its own layout seed
        return Schedule(scene, self.episodes, seed, levels)

    def play_random_levels(
        self, policy: Any, levels: int, episodes: int, seed: int = LEVELS_SEED, on_end: Any = None
    ) -> Evaluation:
        """Play random levels of the training distribution, the same for every policy, `episodes` times each."""
        from ued.evaluation import Schedule

        scene = self.scenes[TRAINING_SCENE]
        scene.reset(seed=seed)
        return Schedule(scene, levels * episodes, seed, scene.sample_levels(levels)).play(policy, on_end=on_end)

    def metrics(self, policy: Any) -> dict[str, float]:
        """Return the mean return on each scene as `eval/<scene>`, with the environment steps and seconds used.

        `eval_low/<scene>` and `eval_high/<scene>` are the ends of its 95% interval, nan below five episodes.
        `eval_success/<scene>` is the share of successful episodes.

        The steps are reported as `eval_env_steps` and do not count as `env_steps`.
        """
        from ued.statistics import of_episodes

        began, evaluations = time.perf_counter(), self.play(policy)
        means = {label: of_episodes(result.returns) for label, result in evaluations.items()}
        metrics = {f"eval/{label}": mean.estimate for label, mean in means.items()}
        metrics |= {f"eval_low/{label}": mean.low for label, mean in means.items()}
        metrics |= {f"eval_high/{label}": mean.high for label, mean in means.items()}
        metrics |= {f"eval_success/{label}": float(result.success.mean()) for label, result in evaluations.items()}
        metrics["eval_env_steps"] = float(sum(result.env_steps for result in evaluations.values()))
        return {**metrics, "time/eval": time.perf_counter() - began}

    def due(self, before: int, after: int, last: bool) -> bool:
        """Return whether to evaluate after an update: the first or last, or one that crosses a multiple of `every`."""
        return before == 0 or last or before // self.every < after // self.every

    def _check_sizes(self, config: TrainConfig) -> None:
        shape = self.scenes[TRAINING_SCENE].single_observation_space.shape
        for label, scene in self.scenes.items():
            other = scene.single_observation_space.shape
            if other != shape:
                raise CommandError(
                    f"the test scene '{label}' of {config.minigame} has observations {other}, the training program "
                    f"{shape}: both need the same players and number of agents"
                )


def theta_of_test(label: str, scene: Any, upomdp: Any, game: str) -> np.ndarray | None:
    """Return θ `[L, D]` of a test of a game; None: random levels. Raises `CommandError` for levels of another game."""
    from regista.experiments.run.tasks import typed

    try:
        return theta_of_scene(scene, upomdp)
    except ValueError as error:
        raise CommandError(f"the levels of the test '{label}' do not match {typed(game)}: {error}") from error


def check_tests(task: Task, upomdp: Any, game: str) -> None:
    """Raise `CommandError` for test or held-out levels that do not belong to `upomdp`, the environments of training."""
    for label, scene in [*task.scenes().items(), *(task.scenes(True).items() if task.held_out else ())]:
        theta_of_test(label, scene, upomdp, game)


def joined(rounds: Sequence[Evaluation]) -> Evaluation:
    """Concatenate several evaluations of one policy on one scene."""
    from ued.evaluation import Evaluation

    if len(rounds) == 1:
        return rounds[0]
    first_level = np.cumsum([0, *(len(one.levels) for one in rounds[:-1])])
    parts = {name: np.concatenate([getattr(one, name) for one in rounds]) for name in ("returns", "success", "lengths")}
    level = np.concatenate([one.level + first for one, first in zip(rounds, first_level, strict=True)])
    levels = np.concatenate([one.levels for one in rounds])
    return Evaluation(**parts, level=level, levels=levels, env_steps=sum(one.env_steps for one in rounds))


class Policy(NamedTuple):
    """A policy to evaluate: its name in tables, seed, env_steps and updates of training, and the policy itself.

    `source` is its run folder, or the name of a baseline.
    """

    method: str
    seed: int
    trained: tuple[int, int]
    policy: Any
    source: Path | str


class Plan(NamedTuple):
    """The evaluation of every policy, for other processes: arguments of `EvalScenes` and of the random levels."""

    config: Any
    episodes: int
    held_out: bool
    levels: int
    level_episodes: int
    trusted: tuple[str, ...]  # code that other processes may run


class Plays(NamedTuple):
    """The episodes of one policy: on each scene, and on the random levels (None: not evaluated)."""

    scenes: Played
    levels: Evaluation | None

    @property
    def episodes(self) -> int:
        """Number of episodes."""
        return sum(len(one.returns) for one in (*self.scenes.values(), self.levels) if one is not None)


def _play_source(plan: Plan, source: Path | str) -> Plays:
    """Play a plan, in a separate process, with the policy of a run folder (a path) or a baseline (a name).

    Its code is trusted: the process that made the plan has checked it.
    """
    for name in plan.trusted:
        trust.allow(name)
    scenes = _scenes_of(plan)
    if isinstance(source, Path):
        policy, _ = load_student(RunFolder.open(source), scenes.game)
    else:
        policy = scenes.task.make_baselines(scenes.scenes[TRAINING_SCENE])[source]
    played = scenes.play(policy)  # before random levels, as in one process, since a policy may have a state
    levels = scenes.play_random_levels(policy, plan.levels, plan.level_episodes) if plan.levels else None
    return Plays(played, levels)


@cache
def _scenes_of(plan: Plan) -> EvalScenes:
    """Return the scenes of a plan, cached since a process evaluates several policies on them."""
    return EvalScenes(plan.config, build.find_game(plan.config.minigame), plan.episodes, plan.held_out)


@dataclass(frozen=True)
class Evaluator:
    """Evaluates every policy on the test scenes, and on `levels` random levels, `episodes` times each.

    `alike`: all runs have the same kind of initial student, so the method alone labels them.
    `minutes`: repeat the scenes in rounds over all policies as long as another round fits into this time.
    `tell`: print the number of episodes to stderr.
    `processes`: maximum number of processes for a long evaluation; results do not depend on it.
    """

    scenes: EvalScenes
    levels: int
    episodes: int
    alike: bool = False
    minutes: float | None = None
    tell: bool = False
    processes: int = 1

    def report(self, runs: Sequence[RunFolder], baselines: bool = True) -> Report:
        """Evaluate the students of all runs, and the baselines.

        Raises `CommandError` if a run has no checkpoint, and for runs of different simulator versions.
        """
        versions.check_alike({run.path: run.simulator for run in runs})
        policies = [self._trained(run) for run in runs]
        if baselines:
            made = self.scenes.task.make_baselines(self.scenes.scenes[TRAINING_SCENE])
            taken = {one.method for one in policies}
            policies += [
                Policy(name + BASELINE if name in taken else name, 0, (0, 0), policy, name)
                for name, policy in made.items()
            ]
        planned = len(policies) * (len(self.scenes.scenes) * self.scenes.episodes + self.levels * self.episodes)
        watch = Watch(planned) if self.minutes is None else Watch(MOST_EPISODES, 60 * self.minutes)
        if self.tell:
            print(self._plan(len(policies)), file=sys.stderr, flush=True)
        results: list[Result] = []
        levels: list[LevelResult] = []
        for one, played in zip(policies, self._play_all(policies, watch), strict=True):
            scenes = played.scenes
            results += [summarize(scenes[label], one.method, one.seed, label, one.trained) for label in scenes]
            if played.levels is not None:
                levels.append(summarize_levels(played.levels, one.method, one.seed))
        watch.finish()
        return Report(results, levels, self.scenes.task.success_word, self.scenes.simulator)

    def _plan(self, policies: int) -> str:
        """Return the number of episodes as text."""
        scenes = len(self.scenes.scenes)
        on = f"on each of {scenes} scenes" if scenes > 1 else "on the test scene"
        by = f" by each of {policies} policies" if policies > 1 else ""
        each = f"{counted(self.scenes.episodes, 'episode')} {on}{by}"
        if self.minutes is not None:
            return f"playing rounds of {each} for at most {self.minutes:g} minutes; --episodes N sets their number"
        levels = f", and {counted(self.levels, 'random level')} {self.episodes} times each" if self.levels else ""
        total = policies * (scenes * self.scenes.episodes + self.levels * self.episodes)
        return f"playing {counted(total, 'episode')}: {each}{levels}"

    def _trained(self, run: RunFolder) -> Policy:
        student, trained = load_student(run, self.scenes.game)
        name = run.name if self.alike else run.label
        return Policy(name, run.config.seed, trained, student, run.path)

    def _play_all(self, policies: Sequence[Policy], watch: Watch) -> list[Plays]:
        """Play the scenes and random levels with every policy; in other processes if that is faster."""
        if self.processes > 1 and self.minutes is None and self._seconds(policies) > SHARED_SECONDS:
            scenes = self.scenes
            configs = [RunFolder.open(one.source).config for one in policies if isinstance(one.source, Path)]
            names = [name for config in configs for name in own_names(config) if trust.allows(name)]
            trusted = (scenes.config.minigame, *names)
            plan = Plan(scenes.config, scenes.episodes, scenes.held_out, self.levels, self.episodes, trusted)

            def count(played: list[Plays]) -> None:
                watch.ended(sum(one.episodes for one in played))

            return apart(partial(_play_source, plan), [one.source for one in policies], self.processes, count)
        played = self._play_scenes(policies, watch)
        return [
            Plays(scenes, self._play_levels(one, watch) if self.levels else None)
            for one, scenes in zip(policies, played, strict=True)
        ]

    def _seconds(self, policies: Sequence[Policy]) -> float:
        """Estimate the duration of a sequential evaluation from the first policy on the training distribution."""
        began = time.monotonic()
        self.scenes.play(policies[0].policy, [TRAINING_SCENE])
        each = len(self.scenes.scenes) + self.levels * self.episodes / self.scenes.episodes
        return (time.monotonic() - began) * each * len(policies)

    def _play_scenes(self, policies: Sequence[Policy], watch: Watch) -> list[Played]:
        """Evaluate each policy on the scenes; with `minutes`, in as many rounds as fit."""
        began = time.monotonic()
        rounds: list[list[Played]] = []
        while True:
            rounds.append([self.scenes.play(one.policy, None, len(rounds), watch.ended) for one in policies])
            spent = time.monotonic() - began
            if self.minutes is None or spent * (1 + 1 / len(rounds)) > 60 * self.minutes:
                break
        return [
            {label: joined([played[k][label] for played in rounds]) for label in self.scenes.scenes}
            for k in range(len(policies))
        ]

    def _play_levels(self, one: Policy, watch: Watch) -> Evaluation:
        return self.scenes.play_random_levels(one.policy, self.levels, self.episodes, on_end=watch.ended)


def load_student(run: RunFolder, game: Game) -> tuple[Any, tuple[int, int]]:
    """Return the student of a run's checkpoint, and the env_steps and updates of its training; see `load_method`."""
    method, trained = load_method(run, game)
    return method.student, trained


def load_method(run: RunFolder, game: Game) -> tuple[Any, tuple[int, int]]:
    """Return the method of a run with the students of its checkpoint, and the env_steps and updates of its training.

    Only their weights, normalizers and settings are read, not the saved matches. Raises `CommandError` if the run has
    no checkpoint, or a student with other observations. Warns if the run was trained on another simulator version.
    """
    from regista.experiments.run.config import EngineConfig

    if not run.checkpoint.exists():
        raise CommandError(f"{run.path} has no checkpoint yet; train it first: regista train --resume {run.path}")
    config, state = run.config, run.load()
    assert state is not None
    versions.warn_of_age(run.path, run.simulator)
    on_host = replace(config, device="cpu")  # evaluation needs no GPU
    on_host = on_host.on_engine(EngineConfig(engine="regista"))  # observations are the same in both engines
    upomdp = build.make_upomdp(game.task(on_host).make, config.num_envs, config.seed)
    method = build.make_method(on_host, upomdp)
    load_students(run, method, state["method"])
    return method, (state["env_steps"], state["update"])


def load_students(run: RunFolder, method: Any, state: Any) -> None:
    """Load the students of a run's checkpoint into its method. Raises `CommandError` for students of another kind."""
    network = run.config.ppo.network
    try:
        method.load_students(state)
    except RuntimeError as error:
        seen = method.upomdp.single_observation_space
        if is_name(network):
            raise CommandError(
                f"{run.path}: {network} or the observations, {seen}, have changed since training; restore them: "
                f"{refused(error)}"
            ) from error
        raise CommandError(f"{run.path} holds a student with observations other than {seen}; train it again") from error
    except DAMAGE as error:  # another number of agents, or damaged
        raise CommandError(f"{run.path}: {refused(error)}") from error
