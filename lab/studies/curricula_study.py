"""The studies of curricula: methods over games, a change of PAIRED, and tuning, with runs played on held-out scenes.

    python -m lab.studies curricula --hours 3                # after three hours call it again
    python -m lab.studies tuning                             # six settings of each method, on validation scenes

Read next: `lab/studies/curricula.py`, what is compared; `lab/studies/measuring.py`, which plays.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from lab.studies import tables
from lab.studies.curricula import COMPARISONS, Settings, Variant
from lab.studies.measuring import measure_variant
from lab.studies.rows import Point, add, check_present, load
from lab.studies.runs import (
    BOOKKEEPING,
    CHOSEN,
    ROOT,
    Deadline,
    Places,
    StudyConfig,
    StudyRuns,
    train_and_measure,
    training,
)
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.folder import RunFolder
from ued.config import LARGEST_SEED, setting

PAGE = "docs/benchmarks/football.md"
TESTS = 10  # evaluations of a student during training


@dataclass(frozen=True)
class CurriculaStudyConfig(StudyConfig):
    """Arguments of `python -m lab.studies curricula` or `tuning`."""

    variants: tuple[str, ...] = setting((), "some of the study's variants; the first is what others are compared with")
    seeds: int | None = setting(None, "runs of each variant on each game; default: the study's", most=10_000, least=1)
    first_seed: int | None = setting(
        None, "seed of the first run; those of final tables are below 1000", most=LARGEST_SEED - 10_000, least=0
    )
    out: Path = setting(Path("runs/curricula"), "folder of the runs and of their rows")
    publish: bool = setting(False, f"keep the rows in lab/studies/results and write their tables into {PAGE}")
    episodes: int = setting(200, "whole episodes of each student on each scene", ">=1", most=1_000_000)
    train: TrainConfig = group(training, "each run", without=(*CHOSEN, "method", "eval_every"))


class PlannedVariant(NamedTuple):
    """A run to be measured: a game, a variant by its name, a seed, and the resulting settings."""

    game: str
    agent: str
    seed: int
    settings: Settings


class CurriculaStudy:
    """One of the studies.

    Args:
        name: curricula or tuning.
        config: its arguments.
        typed: settings of training given on the command line, by dotted path.
    """

    def __init__(self, name: str, config: CurriculaStudyConfig, typed: dict[str, Any]) -> None:
        self.name, self.config, self.typed = name, config, typed
        self.comparison = COMPARISONS[name]
        self.runs = StudyRuns(config.out / name, config.train, {})
        self.places = Places.of(None if config.publish else config.out, PAGE)

    def run(self) -> int:
        """Train seed by seed, play and write each finished run; return the exit code."""
        self.check_published()
        table, curves = (self.places.results / f"{self.name}{end}.csv" for end in ("", "_curves"))
        check_present(table, load(table))
        check_present(curves, load(curves, Point))
        table.parent.mkdir(parents=True, exist_ok=True)
        planned, how = list(self.planned()), self.config.launch
        done = {(row.game, row.agent, row.seed): row.env_steps for row in load(table)}
        missing = [plan for plan in planned if done.get(plan[:3], 0) < plan.settings["total_env_steps"]]
        print(f"{len(planned)} runs, {len(planned) - len(missing)} measured", file=how.messages, flush=True)
        with Deadline(self.config.hours) as stop:
            opened = [(self.open(plan), plan.agent) for plan in missing]
            agents = {run.path: agent for run, agent in opened}
            train_and_measure([run for run, _ in opened], how, stop, partial(self.measure, table, curves, agents))
        if load(table):
            with redirect_stdout(how.messages):
                tables.publish(self.places.results, self.name, self.places.page)
                if self.config.publish and self.name == "curricula":
                    tables.publish_summary(self.places.results, ROOT / "RESULTS.md")
        print(f"{table}{', continue with the same command' if stop else ''}", file=how.messages)
        return stop.exit_code

    def measure(self, table: Path, curves: Path, agents: Mapping[Path, str], run: RunFolder) -> None:
        """Play a finished run and write its curve, then its rows, since a run with rows is not measured again."""
        rows, points = measure_variant(run, agents[run.path], self.config.episodes, self.comparison.held_out)
        add(curves, points, Point)
        add(table, rows)

    def planned(self) -> Iterator[PlannedVariant]:
        """Yield the runs of the study, seed by seed. Raises `UsageError` for unknown names."""
        games = [build.find_game(game).name for game in self.config.games or self.comparison.games]
        variants = {name: self.variant(name) for name in self.config.variants or self.comparison.variants}
        first = self.comparison.first_seed if self.config.first_seed is None else self.config.first_seed
        budget = {"total_env_steps": self.config.train.total_env_steps}  # for games outside of the study
        count = self.comparison.seeds if self.config.seeds is None else self.config.seeds
        for seed in range(first, first + count):
            for game in games:
                for name, variant in variants.items():
                    chosen: Settings = budget | self.comparison.games.get(game, {}) | variant.settings
                    chosen |= self.typed
                    about = {"method": variant.method, "eval_every": max(1, chosen["total_env_steps"] // TESTS)}
                    yield PlannedVariant(game, name, seed, chosen | about)

    def variant(self, name: str) -> Variant:
        """Return the variant of this name. Raises `UsageError` if the study has none."""
        variants = self.comparison.variants
        if name not in variants:
            raise UsageError(f"no variant {name!r}{nearest(name, variants)}; {self.name} has {', '.join(variants)}")
        return variants[name]

    def open(self, plan: PlannedVariant) -> RunFolder:
        """Create the folder of a run, or open it if it was made with the same settings."""
        return self.runs.open(plan.game, plan.seed, plan.settings, f"{plan.agent.replace(' ', '_')}-")

    def check_published(self) -> None:
        """Refuse to publish runs with other settings or seeds than the study's."""
        others = [arguments.flag_name(path.rpartition(".")[2]) for path in sorted(self.typed.keys() - BOOKKEEPING)]
        others += ["--first-seed"] if self.config.first_seed is not None else []
        others += ["--seeds"] if (self.config.seeds or 0) > self.comparison.most_seeds else []
        others += ["--episodes"] if self.config.episodes != CurriculaStudyConfig.episodes else []
        if others and self.config.publish:
            raise UsageError(f"with {', '.join(others)} it is not what {self.name} says; leave out --publish")


def games_of_study(name: str) -> dict[str, list[Any]]:
    """Return the common settings of all runs on a study's own games, for its help; variants have further settings."""
    variants = [variant.settings.items() for variant in COMPARISONS[name].variants.values()]
    common = dict(item for item in variants[0] if all(item in other for other in variants))
    cases: dict[str, list[str]] = {}
    for game, settings in COMPARISONS[name].games.items():
        cases.setdefault(repr(settings), []).append(game)
    first, *others = cases.values()
    but = f" but {', '.join(game for games in others for game in games)}" if others else ""
    named = {f"for the games of the study{but}": first} | {f"for {', '.join(games)}": games for games in others}
    return {case: [_trained(COMPARISONS[name].games[game] | common) for game in games] for case, games in named.items()}


def _trained(settings: Settings) -> CurriculaStudyConfig:
    """Return starting settings of a run, changed by dotted path."""
    return arguments.replace_paths(CurriculaStudyConfig(), {f"train.{path}": v for path, v in settings.items()})


def run_curricula(name: str, config: CurriculaStudyConfig, typed: dict[str, Any]) -> int:
    """Run a study of curricula; return the exit code."""
    return CurriculaStudy(name, config, typed).run()
