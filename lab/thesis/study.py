"""Training and playing the runs of chapter 4; what has rows is not done again. Read next: `lab/thesis/curves.py`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from lab.studies.measuring import rows_of
from lab.studies.rows import Row, add, check_present, load
from lab.studies.runs import Deadline, StudyRuns
from lab.thesis.curves import Value, curves_of
from lab.thesis.plan import Arm, base
from regista.experiments.run import build
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.workers import LaunchConfig, apart, train_unfinished
from ued.core.baselines import ScriptedPolicy

DUEL = "3v2FourBehaviors"  # the game of the four strategies


class Options(NamedTuple):
    """How a study is done: folder of its runs, preset, episodes on each scene, runs at a time, hours until it stops."""

    runs: Path
    preset: str
    episodes: int
    processes: int
    hours: float


def do(arms: Sequence[Arm], table: Path, curves: Path | None, options: Options) -> int:
    """Train and play the runs that have no rows in `table` yet; return the exit code, 0 where all is done.

    Args:
        arms: the runs; those of one seed, which come together, are trained and then played.
        table: CSV file of `Row`, one for each scene.
        curves: CSV file of `Value`; None: not kept.
        options: see there.

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
            arms = list(group)
            runs = [studies.open(arm.game, arm.seed, arm.settings, f"{arm.agent}-") for arm in arms]
            if not train_unfinished(runs, how, stop):
                break
            tasks = [(run.path, arm.agent, options.episodes) for arm, run in zip(arms, runs, strict=True)]
            print(f"playing {len(tasks)} runs, {options.episodes} episodes on each scene", flush=True)
            apart(measure, tasks, how.at_a_time(1, len(tasks)), lambda played: keep(played, table, curves))
    print(f"{table}{', continue with the same command' if stop else ''}")
    return stop.exit_code


def keep(measured: Sequence[tuple[list[Row], list[Value]]], table: Path, curves: Path | None) -> None:
    """Write rows and curves of some runs; the curves first, since a run with rows is not measured again."""
    if curves is not None:
        add(curves, [value for _, values in measured for value in values], Value)
    add(table, [row for rows, _ in measured for row in rows])


def measure(task: tuple[Path, str, int]) -> tuple[list[Row], list[Value]]:
    """Play a run's student on the training distribution and each test scene; return the rows, and its curves.

    `task`: the run's folder, what rows call it, and the number of episodes on each scene.
    """
    path, agent, episodes = task
    run = RunFolder.open(path)
    game = build.find_game(run.config.minigame)
    student, (env_steps, _) = load_student(run, game)
    played = EvalScenes(run.config, game, episodes).play(student)
    about = {"seed": run.config.seed, "env_steps": env_steps, "seconds": round(run.seconds(), 3), "agent": agent}
    return rows_of(run.config, played, about), curves_of(run, agent)


def measure_strategies(episodes: int) -> list[Row]:
    """Let the built-in AI attack each of the four strategies of the 3v2 game for so many episodes (Figure 4.4)."""
    found = build.find_game(DUEL)
    config = replace(found.start("fast"), minigame=found.name)
    scenes = EvalScenes(config, found, episodes)
    played = scenes.play(ScriptedPolicy(), [label for label, _ in found.minigame.tests])
    return rows_of(config, played, {"agent": "built-in", "seed": 0, "env_steps": 0, "seconds": 0.0})
