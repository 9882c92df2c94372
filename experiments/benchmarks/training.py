"""How fast students learn: every method, and teams of several sizes, each with its default settings.

Read next: `commands.benchmark`.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace
from typing import Any

from regista.experiments.benchmarks.timing import STRETCHES, Measurement
from regista.experiments.run import build
from regista.experiments.run.config import TrainConfig

WARM_UPDATES = 10  # of a method before it is measured
ELEVEN = "academy/counterattack_easy"  # eleven a side: teams of every size play it
TEAMS = ("closest1", "2", "4", "all")


def training_suite(minigame: str, seconds: float) -> list[Measurement]:
    """Measure every method on one thread, domain randomisation on all cores, too, and teams.

    What a curriculum costs beside simulation and networks is `levels`, choosing them and keeping book, and `teaching`:
    scoring them and letting the teacher learn. Speeds are of the clock on the wall, shares of all time that was taken.
    """
    runs = [(method, 1) for method in build.METHODS] + [("dr", cores) for cores in [os.cpu_count() or 1] if cores > 1]
    rows = []
    for name, threads in runs:
        method = _method(replace(TrainConfig(), minigame=minigame, method=name, threads=threads))
        rows.append(_measured(f"{name}, {threads} thread{'s' * (threads > 1)}", method, seconds))
    return rows + team_rows(seconds)


def team_rows(seconds: float) -> list[Measurement]:
    """Measure one agent and teams in the same game, with a policy for each agent."""
    rows: list[Measurement] = []
    for control in TEAMS:
        config = replace(TrainConfig(), minigame=ELEVEN, method="dr")
        method = _method(replace(config, env=replace(config.env, control=control)))
        agents = method.upomdp.num_agents
        label = f"dr, eleven a side, {agents} agent{'s' * (agents > 1)}"
        row = _measured(label, method, seconds)
        cost = (rows or [row])[0].steps_per_second / row.steps_per_second
        note = f"{agents * row.steps_per_second:,.0f} agent-steps/s, {cost:.1f} x the time of one; {row.note}"
        rows.append(row._replace(note=note))
    return rows


def _method(config: TrainConfig) -> Any:
    """Make a method that has begun: replay is under way, and the buffer is in use."""
    program = build.load_program(build.find_minigame(config.minigame).program, None)
    upomdp = build.make_upomdp(program, config.num_envs, config.env, 0, config.threads)
    method = build.make_method(config, upomdp)
    for _ in range(WARM_UPDATES):
        method.update()
    return method


def _measured(label: str, method: Any, seconds: float) -> Measurement:
    """Measure one row of the table; all shares are of the time that it took."""
    names = ("sim", "forward", "learn", "levels", "curriculum")
    steps, began, shares = method.env_steps, time.perf_counter(), dict.fromkeys(names, 0.0)
    while time.perf_counter() - began < seconds * STRETCHES:
        metrics = method.update()
        for name in shares:
            shares[name] += metrics.get(f"time/{name}", 0.0)
    elapsed = time.perf_counter() - began
    words = ("simulation", "network forward", "network update", "levels", "teaching")
    parts = [f"{word} {share / elapsed:.0%}" for word, share in zip(words, shares.values(), strict=True)]
    parts.append(f"rest {1 - sum(shares.values()) / elapsed:.0%}")
    return Measurement(label, (method.env_steps - steps) / elapsed, ", ".join(parts))
