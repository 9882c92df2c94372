"""Train and play the runs of chapter 4, except for those with rows. Read next: `lab/thesis/curves.py`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from lab.studies.measuring import about_run, rows_of
from lab.studies.rows import Row, add, check_present, load
from lab.studies.runs import Deadline, StudyRuns, train_and_measure
from lab.thesis.curves import Value, curves_of
from lab.thesis.plan import Arm, base
from regista.experiments.run import build
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.workers import LaunchConfig
from ued.core.baselines import ScriptedPolicy

DUEL = "3v2FourBehaviors"  # the game of the four strategies


class Options(NamedTuple):
    """Options of a study: folder of its runs, preset, episodes on each scene, runs at a time, hours until it stops."""

    runs: Path
    preset: str
    episodes: int
    processes: int
    hours: float


def do(arms: Sequence[Arm], table: Path, curves: Path | None, options: Options) -> int:
    """Train and play the runs that have no rows in `table` yet; return the exit code, 0 if all are done.

    Args:
        arms: the runs, seed by seed; each is played as soon as it is trained.
        table: CSV file of `Row`, one for each scene.
        curves: CSV file of `Value`; None: not stored.
        options: see `Options`.

    Raises `CommandError` for rows of another version of the simulator.
    """
    check_present(table, load(table))
    table.parent.mkdir(parents=True, exist_ok=True)
    done = {(row.game, row.agent, row.seed): row.env_steps for row in load(table)}
    missing = [arm for arm in arms if done.get(arm[:3], 0) < arm.settings["total_env_steps"]]
    print(f"{len(arms)} runs, {len(arms) - len(missing)} measured", flush=True)
    studies = StudyRuns(options.runs / options.preset, base(options.preset), {})
    how = LaunchConfig(processes=options.processes)
    with Deadline(options.hours) as stop:
        for _, group in groupby(missing, key=lambda arm: arm.seed):
            begun = [(studies.open(arm.game, arm.seed, arm.settings, f"{arm.agent}-"), arm.agent) for arm in group]
            agents = {run.path: agent for run, agent in begun}
            keep = partial(measure, agents, table, curves, options.episodes)
            if not train_and_measure([run for run, _ in begun], how, stop, keep):
                break
    print(f"{table}{', continue with the same command' if stop else ''}")
    return stop.exit_code


def measure(agents: Mapping[Path, str], table: Path, curves: Path | None, episodes: int, run: RunFolder) -> None:
    """Play a run's student on the training distribution and each test scene, and write its rows and its curves.

    The curves come first, since a run with rows is not measured again. `agents`: the names of runs in rows, by run
    folder.
    """
    game, agent = build.find_game(run.config.minigame), agents[run.path]
    student, (env_steps, _) = load_student(run, game)
    played = EvalScenes(run.config, game, episodes).play(student)
    if curves is not None:
        add(curves, curves_of(run, agent), Value)
    add(table, rows_of(run.config, played, about_run(run, agent, env_steps)))


def measure_strategies(episodes: int) -> list[Row]:
    """Let the built-in AI attack each of the four strategies of the 3v2 game for `episodes` episodes (Figure 4.4)."""
    found = build.find_game(DUEL)
    config = replace(found.start("fast"), minigame=found.name)
    scenes = EvalScenes(config, found, episodes)
    played = scenes.play(ScriptedPolicy(), [label for label, _ in found.minigame.tests])
    return rows_of(config, played, {"agent": "built-in", "seed": 0, "env_steps": 0, "seconds": 0.0})
