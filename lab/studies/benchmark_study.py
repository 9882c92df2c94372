"""The studies of the thesis's benchmark: train games over seeds, play them on all scenes, keep a row for each.

Read next: `lab/studies/runs.py`; `lab/studies/measuring.py`, which plays; `lab/studies/tables.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

from lab.studies import measuring, tables
from lab.studies.rows import Row, add, check_present, load, trained
from lab.studies.runs import BOOKKEEPING, CHOSEN, ROOT, Deadline, Places, StudyConfig, StudyRuns, training
from regista.experiments.commands import clone, demonstrate
from regista.experiments.run import arguments, origin
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig, presets
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import find_minigame
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.workers import train_unfinished
from regista.minigames.published import published
from regista.minigames.suites import BENCHMARK
from ued.config import FineTuningConfig, setting

TEAMS_PAGE = "docs/benchmarks/teams.md"
TEAMS = ("multi", "teams")  # studies of teams only
AGENTS = {  # of studies that train several agents on each game, as in the tables
    "teams": ("ppo", "shared_ppo", "shared_mappo"),
    "demonstrations": ("ppo", "pretrained"),
}
FIGURE_2_7 = tuple(row.game for row in published() if row.source == "Fig. 2.7")
# The games of each study, and the players that agents move in each.
PAIRS: dict[str, tuple[tuple[str, str], ...]] = {
    "single": tuple((game, BENCHMARK[game].control) for game in FIGURE_2_7),
    "generalization": tuple((game.name, game.control) for game in BENCHMARK.values()),
    "multi": tuple((row.game, row.control) for row in published() if row.source == "Table 3.1"),
    "teams": (  # an attack that the thesis's teams do not learn, one that they do, and a defense
        ("offense/hard_crossing", "allNonGK"),
        ("grf/pass_and_shoot_with_keeper", "allNonGK"),
        ("defense/2vs2", "all"),
    ),
    "demonstrations": tuple((row.game, row.control) for row in published() if row.agent.endswith("pretrained")),
}


@dataclass(frozen=True)
class BenchmarkStudyConfig(StudyConfig):
    """Arguments of `python -m lab.studies single`, `generalization`, `multi`, `teams` or `demonstrations`."""

    seeds: int = setting(3, "runs of each game, with seeds 0, 1, ...", ">=1", most=10_000)
    preset: Literal["fast", "thesis"] = setting(
        "fast", "fast: features and a small network, 1M steps; thesis: stacked SMM and its network, 5M steps"
    )
    out: Path = setting(Path("runs/benchmark"), "folder of the runs and of their rows")
    publish: bool = setting(False, "keep the rows in lab/studies/results and write their tables into BENCHMARK.md")
    episodes: int = setting(400, "whole episodes of each policy on each scene", ">=1", most=1_000_000)
    demonstrations: int = setting(
        1000, "successful episodes of a semi-expert program that are cloned", ">=1", most=1_000_000
    )
    train: TrainConfig = group(training, "each run", without=(*CHOSEN, "method"))  # PPO on levels without a curriculum
    fine_tuning: FineTuningConfig = group(FineTuningConfig, "of demonstrations: training on from a clone", prefix="")


class PlannedRun(NamedTuple):
    """A run to be measured; `agent` is as in the tables."""

    game: str
    agent: str
    control: str
    seed: int

    @property
    def cloned(self) -> bool:
        """Whether the run begins with a clone."""
        return self.agent.endswith("pretrained")

    @property
    def kind(self) -> str:
        """The part of the folder's name after the game; empty for separate policies trained from scratch."""
        name = self.agent.removeprefix(measuring.TEAM)
        return "" if name == "ppo" else f"{name}-"

    @property
    def chosen(self) -> dict[str, Any]:
        """The run's own settings, by dotted path."""
        kind = self.agent.removeprefix(measuring.TEAM)
        return {"env.control": self.control} | measuring.TEAM_SETTINGS.get(kind, {})


class BenchmarkStudy:
    """One of the studies.

    Args:
        name: single, generalization, multi, teams or demonstrations.
        config: its arguments.
        typed: settings of training given on the command line, by dotted path.
    """

    def __init__(self, name: str, config: BenchmarkStudyConfig, typed: dict[str, Any]) -> None:
        self.name, self.config, self.typed = name, config, typed
        self.runs = StudyRuns(config.out / config.preset, starting_point(config), typed)
        self.places = places_of(config)

    def run(self) -> int:
        """Train, play and write, a few runs at a time; a stopped study keeps the results of finished runs.

        Returns the exit code.
        """
        self.check_published()
        table = self.places.results / f"{self.config.preset}.csv"
        rows = load(table)
        check_present(table, rows)
        steps = arguments.replace_paths(self.runs.base, self.typed).total_env_steps
        table.parent.mkdir(parents=True, exist_ok=True)
        planned = list(self.planned())
        missing = [plan for plan in planned if trained(rows, *plan) < steps]
        self.check_same(planned)
        how = self.config.launch
        print(f"{len(planned)} runs, {len(planned) - len(missing)} measured", file=how.messages, flush=True)
        most = max(1, how.at_a_time(self.runs.base.threads, len(missing)))
        with Deadline(self.config.hours) as stop:
            for first in range(0, len(missing), most):
                clones, runs = self.open(missing[first:][:most], stop)
                if stop or not train_unfinished(runs, how, stop):
                    break
                rows = add(table, measure([*clones, *runs], rows, self.config.episodes))
        if rows:
            with redirect_stdout(how.messages):
                tables.publish(self.places.results, self.config.preset, self.places.page)
                tables.publish_teams(self.places.results, self.config.preset, self.places.page and ROOT / TEAMS_PAGE)
        go_on = ", continue with the same command" if stop else ""
        print(f"{table}: {len(rows)} rows{go_on}", file=how.messages)
        return stop.exit_code

    # ------------------------------------------------------------ planned runs

    def planned(self) -> Iterator[PlannedRun]:
        """Yield the runs of the study, seed by seed."""
        typed = arguments.replace_paths(self.runs.base, self.typed).ppo
        agents = AGENTS.get(self.name)
        for seed in range(self.config.seeds):
            for game, control in self.games():
                single = control == find_minigame(game).control
                team, kind = ("", "ppo") if single else (measuring.TEAM, measuring.team_kind(typed))
                yield from (PlannedRun(game, team + agent, control, seed) for agent in agents or (kind,))

    def games(self) -> list[tuple[str, str]]:
        """Return the games, each with the players that its agents move: a team of each kind, or one agent."""
        known = PAIRS[self.name]
        games = [find_minigame(game) for game in self.config.games or dict.fromkeys(game for game, _ in known)]
        pairs = []
        for game in games:
            controls = [control for other, control in known if other == game.name]
            if "env.control" in self.typed:
                controls = [self.typed["env.control"]]
            elif self.name in TEAMS:
                controls = controls or [*game.team_control]
            elif self.name != "demonstrations":
                controls = [game.control]
            if not controls:
                what = "team" if self.name in TEAMS else "semi-expert program"
                raise UsageError(f"no {what} is known for {game.name}; say whom its agents move with --control")
            pairs += [(game.name, control) for control in controls]
        return pairs

    # ------------------------------------------------------------ their folders

    def open(self, planned: Sequence[PlannedRun], stop: StopRequest) -> tuple[list[RunFolder], list[RunFolder]]:
        """Create or open the folders of runs; the clones with which some of them begin are made first."""
        clones: list[RunFolder] = []
        runs: list[RunFolder] = []
        for plan in planned:
            made = self.make_clone(plan, stop) if plan.cloned else None
            if plan.cloned and made is None:
                break
            runs.append(self.runs.open(plan.game, plan.seed, plan.chosen, plan.kind))
            if made is not None:
                clones.append(RunFolder.open(made))
                if not runs[-1].begun():
                    origin.save(runs[-1], origin.load(made), self.config.fine_tuning)
        return clones, runs

    def make_clone(self, planned: PlannedRun, stop: StopRequest) -> Path | None:
        """Let the semi-expert program play, and clone it; return the clone's folder, None after a request to stop."""
        config = self.config
        seen = arguments.replace_paths(self.runs.base, self.typed).env.representation
        name = f"{planned.game.replace('/', '_')}-{planned.control}-{seen}"
        demos, out = config.out / "demonstrations" / name, self.runs.folder / f"{name}-clone-{planned.seed}"
        if (out / "checkpoint.pt").exists():
            return out
        game = [planned.game, "--representation", seen, "--control", planned.control]
        played = [*game, "--episodes", str(config.demonstrations), "--out", str(demos)]
        cloned = [str(demos), "--preset", config.preset, "--seed", str(planned.seed), "--out", str(out)]
        student = {path: value for path, value in self.typed.items() if path.startswith("ppo.")}
        cloned += [word for path, value in student.items() for word in (arguments.flag_name(path), str(value))]
        for command, words in ((demonstrate, played), (clone, cloned)):
            with redirect_stdout(config.launch.messages):
                code = command.main(words)
            if code:
                stop.signal = code - 128  # a signal that the command has caught
                return None
        return out

    # ------------------------------------------------------------ refused settings

    def check_published(self) -> None:
        """Refuse to mix runs that deviate from a preset with the preset's published runs."""
        others = sorted(self.typed.keys() - BOOKKEEPING)
        others += [] if self.config.fine_tuning == FineTuningConfig() else ["kl_to_clone"]
        if others and self.config.publish:
            flags = ", ".join(arguments.flag_name(path.rpartition(".")[2]) for path in others)
            raise UsageError(f"with {flags} it is no run of preset {self.config.preset}; leave out --publish")

    def check_same(self, planned: Sequence[PlannedRun]) -> None:
        """Refuse to continue with runs of other settings, including measured runs, which are not opened again.

        Raises `ConfigError` that names the run, the setting and both values.
        """
        for plan in planned:
            path, config = self.runs.plan(plan.game, plan.seed, plan.chosen, plan.kind)
            if (path / "config.json").exists():
                RunFolder.create_or_extend(path, config)


def run_benchmark(name: str, config: BenchmarkStudyConfig, typed: dict[str, Any]) -> int:
    """Run a study of the benchmark; return the exit code."""
    return BenchmarkStudy(name, config, typed).run()


def places_of(config: BenchmarkStudyConfig) -> Places:
    """Return the output locations of a study: beneath its folder, or in the repository with `publish`."""
    return Places.of(None if config.publish else config.out, "BENCHMARK.md")


def starting_point(config: BenchmarkStudyConfig) -> TrainConfig:
    """Return the starting settings of a preset's runs: `fast` has the budget of the study, `thesis` its own."""
    if config.preset == "fast":
        return config.train
    chosen = presets()[config.preset]
    names = ("env", "ppo", "paired", "num_envs", "total_env_steps")
    return replace(config.train, **{name: getattr(chosen, name) for name in names})


def presets_of_benchmark(name: str) -> dict[str, list[Any]]:
    """Return the starting settings of a study's runs with the other preset, for its help."""
    config = BenchmarkStudyConfig(preset="thesis")
    return {"with --preset thesis": [replace(config, train=starting_point(config))]}


def measure(runs: Sequence[RunFolder], known: Sequence[Row], episodes: int) -> list[Row]:
    """Play runs on all scenes of their games, and also random actions and semi-expert programs without known rows."""
    rows: list[Row] = []
    for run in runs:
        game = run.config.minigame
        print(f"playing {game}, seed {run.config.seed}", flush=True)
        rows += measuring.measure_run(run, episodes)
        about = (game, "random", run.config.env.control)
        if not any(row[:3] == about for row in [*known, *rows]):
            rows += measuring.measure_random(run.config, episodes)
            rows += measuring.measure_experts(find_minigame(game), episodes)
    return rows
