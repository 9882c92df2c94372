"""`regista benchmark`: measure environment steps per second of the simulator and of training on this machine.

    regista benchmark
    regista benchmark --threads 2 --json > speed.json

Read next: `regista.envs.football.batch`, the measured loop.
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from regista.experiments.run import arguments, build
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.provenance import hardware, versions
from regista.experiments.run.results import align
from ued.config import Checked, most_threads, setting

DESCRIPTION = "Measure environment steps per second of the simulator and of PAIRED with default settings."
GAMES = {"1v1Free": "simulator, 1v1", "academy/counterattack_easy": "simulator, 22 players"}
WARM_UP = 8  # calls before a measurement


@dataclass(frozen=True)
class BenchmarkConfig(Checked):
    """Arguments of `regista benchmark`."""

    threads: int = setting(1, "threads of the simulator and of the networks", ">=1", most=most_threads)
    num_envs: int = setting(256, "environments of the simulator's batch", ">=1", most=100_000)
    seconds: float = setting(2.0, "duration of each measurement in seconds, about", ">0", most=86_400)
    json: bool = setting(False, "print JSON instead of a table")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    if any(word.partition("=")[0] == "--suite" for word in argv):
        raise UsageError("benchmark --suite has moved: python -m lab.benchmarks --suite, in a checkout")
    config = arguments.parse(BenchmarkConfig(), argv, "benchmark", DESCRIPTION)
    speeds = {label: simulator_speed(game, config) for game, label in GAMES.items()}
    speeds["training, PAIRED, 1v1"] = training_speed(replace(TrainConfig(), threads=config.threads), config.seconds)
    about = {**hardware(), **versions(("numpy", "numba", "torch")), "threads": config.threads}
    if config.json:
        print(json.dumps({"machine": about, "env_steps_per_second": speeds}, indent=2))
    else:
        print(", ".join(f"{name} {value}" for name, value in about.items()), end="\n\n")
        print(align([["measurement", "env steps/s"], *([label, f"{speed:,.0f}"] for label, speed in speeds.items())]))
    return 0


def simulator_speed(game: str, config: BenchmarkConfig) -> float:
    """Return the steps per second of a batch of matches under random actions; episodes restart as they end."""
    run = replace(TrainConfig(), threads=config.threads)
    env = build.make_upomdp(build.find_game(game).task(run).make, config.num_envs, 0)
    env.action_space.seed(0)
    actions = itertools.cycle([env.action_space.sample() for _ in range(64)])
    return config.num_envs * calls_per_second(lambda: env.step(next(actions)), config.seconds)


def training_speed(config: Any, seconds: float) -> float:
    """Return the simulated steps per second of updates with default settings."""
    task = build.find_game(config.minigame).task(config)
    method = build.make_method(config, build.make_upomdp(task.make, config.num_envs, config.seed))
    updates = calls_per_second(method.update, seconds)
    return updates * method.env_steps / method.updates


def calls_per_second(call: Callable[[], object], seconds: float) -> float:
    """Return the calls per second after a warm-up."""
    for _ in range(WARM_UP):
        call()
    began, count = time.perf_counter(), 0
    while time.perf_counter() - began < seconds:
        call()
        count += 1
    return count / (time.perf_counter() - began)
