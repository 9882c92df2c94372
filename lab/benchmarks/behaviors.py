"""Speed of matches whose players run behaviors, including the simulation, and compile time of the programs.

Programs are in `lab/benchmarks/programs`. Read next: `scenic_lite.dynamics.machine.vm`, the machine that is measured.
"""

from __future__ import annotations

import time
from pathlib import Path

from lab.benchmarks.timing import Measurement, random_steps, rate
from regista.experiments.run.config import TrainConfig

PROGRAMS = Path(__file__).parent / "programs"
NUM_ENVS = 256
CASES = {
    "figure_2_1": "Figure 2.1 of the thesis, 9 players, 4 behaviors",
    "six_interrupts": "six players, each with a behavior of two interrupts",
}
ORIGINAL = (500, 1500)  # steps per second of Scenic's own interpreter of behaviors, without any simulator


def behaviors_suite(seconds: float) -> list[Measurement]:
    """Measure every program of `CASES` on one core, in processor time, about `seconds` for each number."""
    return [measure(name, seconds) for name in CASES]


def measure(name: str, seconds: float) -> Measurement:
    """Step with random actions; episodes restart as they end."""
    from regista.experiments.run.build import make_matches
    from regista.experiments.run.programs import load_program

    env = make_matches(load_program(PROGRAMS / f"{name}.scenic", None), NUM_ENVS, TrainConfig().env, 0, 1)
    speed = NUM_ENVS * rate(random_steps(env), seconds, clock=time.process_time)
    note = f"code: {len(env.behaviors.code.rows)} rows, compiled in {compile_ms(env, seconds):.0f} ms"
    return Measurement(CASES[name], speed, note)


def compile_ms(env: object, seconds: float) -> float:
    """Return the milliseconds to compile a parsed program."""
    from regista.envs.football.scenic.world import FOOTBALL_WORLD
    from regista.envs.football.vector_env import FootballVectorEnv
    from scenic_lite.dynamics.compiler.compile import compile_program

    assert isinstance(env, FootballVectorEnv)

    def compile_it(count: int) -> None:
        for _ in range(count):
            compile_program(env.program, FOOTBALL_WORLD)

    return 1e3 / rate(compile_it, seconds, warm_up=1, clock=time.process_time)
