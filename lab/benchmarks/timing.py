"""Timing tools: measurements, random steps, the machine. Read next: `lab.benchmarks.__main__`."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run import build
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.provenance import hardware, versions

STRETCHES = 3  # per measurement; the best counts, since other programs may use the machine meanwhile
WARM_UPDATES = 10  # updates of a method before the measurement


class Measurement(NamedTuple):
    """One line of a table: steps of a single environment per second."""

    what: str
    steps_per_second: float
    note: str = ""


def training_row(label: str, game: str, method: str, threads: int, seconds: float) -> Measurement:
    """Measure a method with default settings on a minigame."""
    config = replace(TrainConfig(), minigame=game, method=method, threads=threads)
    return measure_training(label, make_method(config), seconds)


def make_method(config: TrainConfig) -> Any:
    """Make a method past its start: replay has begun, and the buffer is in use."""
    task = build.find_game(config.minigame).task(config)
    method = build.make_method(config, build.make_upomdp(task.make, config.num_envs, 0))
    for _ in range(WARM_UPDATES):
        method.update()
    return method


def measure_training(label: str, method: Any, seconds: float) -> Measurement:
    """Measure a method's steps per second of wall-clock time; the note gives the shares of that time.

    `levels` means choosing levels and bookkeeping, `teaching` means scoring them and updating the teacher.
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


def random_steps(env: Any) -> Callable[[int], None]:
    """Return a function that steps an environment a given number of times, with random actions drawn beforehand.

    The environment has already made 8 steps.
    """
    actions = np.random.default_rng(0).integers(0, env.single_action_space.n, (64, env.num_envs))

    def step(count: int) -> None:
        for t in range(count):
            env.step(actions[t % 64])

    step(8)
    return step


def rate(
    run: Callable[[int], None], seconds: float, warm_up: int = 4, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return calls per second of `run(count)`: the best of several stretches that take `seconds` in total."""
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
    """Return the hardware and the versions used."""
    return {**hardware(), "python": platform.python_version(), **versions(("numpy", "numba", "torch"))}


def machine_line() -> str:
    """Return `machine` as one line."""
    facts = machine()
    named = ", ".join(f"{name} {facts[name]}" for name in ("python", "numpy", "numba", "torch") if name in facts)
    return f"{facts['processor']}, {facts['cores']} cores; {named}"
