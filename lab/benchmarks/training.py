"""Training speed of every method, and of teams of several sizes, each with default settings.

Read next: `lab.benchmarks.timing`.
"""

from __future__ import annotations

import os
from dataclasses import replace

from lab.benchmarks.timing import Measurement, make_method, measure_training, training_row
from regista.experiments.run import build
from regista.experiments.run.config import TrainConfig

ELEVEN = "academy/counterattack_easy"  # eleven a side: teams of every size play it
TEAMS = ("closest1", "2", "4", "all")


def training_suite(minigame: str, seconds: float) -> list[Measurement]:
    """Measure every method on one thread, domain randomization on all cores too, and teams.

    The costs of a curriculum beyond simulation and networks are `levels` (choosing levels and bookkeeping) and
    `teaching` (scoring levels and updating the teacher). Speeds are in wall-clock time; shares are of the total time.
    """
    runs = [(method, 1) for method in build.METHODS] + [("dr", cores) for cores in [os.cpu_count() or 1] if cores > 1]
    rows = [
        training_row(f"{name}, {threads} thread{'s' * (threads > 1)}", minigame, name, threads, seconds)
        for name, threads in runs
    ]
    return rows + team_rows(seconds)


def team_rows(seconds: float) -> list[Measurement]:
    """Measure one agent and teams in the same game, with a separate policy for each agent."""
    rows: list[Measurement] = []
    for control in TEAMS:
        config = replace(TrainConfig(), minigame=ELEVEN, method="dr")
        method = make_method(replace(config, env=replace(config.env, control=control)))
        agents = method.upomdp.num_agents
        label = f"dr, eleven a side, {agents} agent{'s' * (agents > 1)}"
        row = measure_training(label, method, seconds)
        cost = (rows or [row])[0].steps_per_second / row.steps_per_second
        note = f"{agents * row.steps_per_second:,.0f} agent-steps/s, {cost:.1f} x the time of one; {row.note}"
        rows.append(row._replace(note=note))
    return rows
