"""Speed of matches with observations, by number of players, representation and threads, side by side.

Read next: `lab.benchmarks.timing`, which prints the rows.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from lab.benchmarks.timing import Measurement, random_steps, rate
from regista.experiments.run import build
from regista.experiments.run.programs import load_program

PROGRAMS = Path(__file__).parent / "programs"
SCENES = (("6 players", PROGRAMS / "football_6.scenic"), ("22 players", PROGRAMS / "football_22.scenic"))
SEEN = ("features", "simple115", "smm", "smm_stacked")
MATCHES = 256


def observation_rows(seconds: float) -> list[Measurement]:
    """Measure each scene with each representation on one thread, `features` also on two, and drawing planes alone."""
    rows = []
    for name, program in SCENES:
        for representation in SEEN:
            speed = _speed(program, representation, 1, seconds)
            rows.append(Measurement(f"{name}, {representation}, 1 thread", speed))
            if representation == "features" and (os.cpu_count() or 1) > 1:
                twice = _speed(program, representation, 2, seconds)
                rows.append(Measurement(f"{name}, features, 2 threads", twice, f"{twice / speed:.2f} x 1 thread"))
        rows.append(Measurement(f"{name}, smm_stacked drawn alone", _frames(program, seconds), "frames, not steps"))
    return rows


def _speed(program: Path, representation: str, threads: int, seconds: float) -> float:
    """Return env steps per second with random actions."""
    return MATCHES * rate(random_steps(_make_env(program, representation, threads)), seconds)


def _frames(program: Path, seconds: float) -> float:
    """Return stacked planes drawn per second on one thread, for matches in progress."""
    env = _make_env(program, "smm_stacked", 1)
    for _ in range(20):
        env.step(np.full(MATCHES, 5))

    def draw(count: int) -> None:
        for _ in range(count):
            env.observe()

    draw(1)
    return MATCHES * rate(draw, seconds)


def _make_env(program: Path, representation: str, threads: int) -> Any:
    from regista.envs.football.config import FootballConfig

    return build.make_matches(load_program(program, None), MATCHES, FootballConfig(representation), 0, threads)
