"""`regista benchmark`: measure environment steps per second of the simulator and of training on this machine.

    regista benchmark
    regista benchmark --threads 2 --json > speed.json

Read next: `regista.envs.football.batch`, the measured loop.
"""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run import arguments, build
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program
from regista.experiments.run.provenance import hardware, versions
from regista.experiments.run.results import align
from ued.config import Checked, most_threads, setting

DESCRIPTION = "Measure environment steps per second of the simulator and of PAIRED with default settings."
GAMES = {"1v1Free": "1v1, 3 players", "academy/counterattack_easy": "eleven a side, 22 players"}
STRETCHES = 3  # repetitions of a measurement; the best one counts, since other programs may slow the others down
WARM_UPDATES = 10  # updates before a method is measured


@dataclass(frozen=True)
class BenchmarkConfig(Checked):
    """Arguments of `regista benchmark`."""

    threads: int = setting(1, "threads for the simulator and for the networks", ">=1", most=most_threads)
    num_envs: int = setting(256, "parallel environments of the simulator", ">=1", most=100_000)
    seconds: float = setting(1.0, "approximate duration of each measurement in seconds", ">0", most=86_400)
    json: bool = setting(False, "print JSON instead of a table")


class Measurement(NamedTuple):
    """One row of the table: environment steps per second, summed over parallel environments."""

    what: str
    steps_per_second: float
    note: str = ""


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    if any(word.partition("=")[0] == "--suite" for word in argv):
        raise UsageError("benchmark --suite has moved: python -m lab.benchmarks --suite, in a checkout")
    config = arguments.parse(BenchmarkConfig(), argv, "benchmark", DESCRIPTION)
    rows = [*simulator_rows(config), training_row("PAIRED, 1v1", "1v1Free", "paired", config.threads, config.seconds)]
    if config.json:
        print(json.dumps({"machine": machine(), "results": [row._asdict() for row in rows]}, indent=2))
    else:
        cells = [[row.what, f"{row.steps_per_second:,.0f}".rjust(11), row.note] for row in rows]
        print(f"{machine_line()}\n\n{align([[f'threads: {config.threads}', 'env steps/s', ''], *cells])}")
    return 0


def simulator_rows(config: BenchmarkConfig) -> list[Measurement]:
    """Measure the vector environment, observations included, under random actions with automatic resets."""
    rows = []
    for game, label in GAMES.items():
        program = load_program(find_minigame(game).program, None)
        env = build.make_matches(program, config.num_envs, TrainConfig().env, 0, config.threads)
        speed = config.num_envs * rate(random_steps(env), config.seconds)
        rows.append(Measurement(f"simulator, {label}", speed, f"{config.num_envs} matches"))
    return rows


def training_row(label: str, game: str, method: str, threads: int, seconds: float) -> Measurement:
    """Measure a method with its default settings on a minigame."""
    config = replace(TrainConfig(), minigame=game, method=method, threads=threads)
    return measure_training(label, make_method(config), seconds)


def make_method(config: TrainConfig) -> Any:
    """Make a method and warm it up, so that its level buffer is filled and levels are replayed."""
    program = load_program(find_minigame(config.minigame).program, None)
    method = build.make_method(config, build.make_matches(program, config.num_envs, config.env, 0, config.threads))
    for _ in range(WARM_UPDATES):
        method.update()
    return method


def measure_training(label: str, method: Any, seconds: float) -> Measurement:
    """Measure a method's environment steps per second of wall-clock time; the note splits that time into parts.

    `levels` covers choosing levels and bookkeeping, `teaching` scoring levels and updating the teacher.
    """
    words = {
        "sim": "simulation",
        "forward": "network forward",
        "learn": "network update",
        "levels": "levels",
        "curriculum": "teaching",
    }
    steps, began, shares = method.env_steps, time.perf_counter(), dict.fromkeys(words, 0.0)
    while time.perf_counter() - began < seconds * STRETCHES:
        metrics = method.update()
        for name in shares:
            shares[name] += metrics.get(f"time/{name}", 0.0)
    elapsed = time.perf_counter() - began
    parts = [f"{words[name]} {share / elapsed:.0%}" for name, share in shares.items()]
    parts.append(f"rest {1 - sum(shares.values()) / elapsed:.0%}")
    return Measurement(label, (method.env_steps - steps) / elapsed, ", ".join(parts))


# ---------------------------------------------------------------- timing


def random_steps(env: Any) -> Callable[[int], None]:
    """Return a function `step(count)` that takes random actions, sampled in advance; the first 8 steps are done."""
    actions = np.random.default_rng(0).integers(0, env.single_action_space.n, (64, env.num_envs))

    def step(count: int) -> None:
        for t in range(count):
            env.step(actions[t % 64])

    step(8)
    return step


def rate(
    run: Callable[[int], None], seconds: float, warm_up: int = 4, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return calls per second of `run(count)`: the best of `STRETCHES` repetitions that take `seconds` in total."""
    began = clock()
    run(warm_up)
    count = max(1, int(warm_up * seconds / STRETCHES / max(clock() - began, 1e-6)))
    best = 0.0
    for _ in range(STRETCHES):
        began = clock()
        run(count)
        best = max(best, count / max(clock() - began, 1e-9))
    return best


def machine() -> dict[str, Any]:
    """Return the hardware and the package versions."""
    return {**hardware(), "python": platform.python_version(), **versions(("numpy", "numba", "torch"))}


def machine_line() -> str:
    """Return `machine()` as one line."""
    facts = machine()
    named = ", ".join(f"{name} {facts[name]}" for name in ("python", "numpy", "numba", "torch") if name in facts)
    return f"{facts['processor']}, {facts['cores']} cores; {named}"
