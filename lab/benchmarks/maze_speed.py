"""How fast are mazes? Environment steps per second of processor time, alone and in training.

    python -m lab.benchmarks.maze_speed
    python -m lab.benchmarks.maze_speed --students "GRU 64" --methods dr accel

The first part measures mazes alone, with random actions drawn beforehand: the kernel, which steps and observes, then
the environment. The environment also restarts episodes, on the same maze or on new random mazes. The second part
measures training with rollouts of 256 steps in 32 environments, compiled and step by step in turns. Each number is the
best of several stretches. The share of learning is `time/learn` among the times that the run reports; the steps per
second without learning follow from it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from lab.benchmarks.timing import machine_line
from regista.envs.maze.config import MazeConfig
from regista.envs.maze.dynamics import step_mazes
from regista.envs.maze.env import Mazes
from regista.experiments.run.results import align
from ued import METHODS, PPOConfig
from ued.learning import worker

NUM_ENVS, NUM_STEPS, DRAWN = 32, 256, 64
STUDENTS: dict[str, dict[str, Any]] = {
    "feed-forward 2 x 128": {},
    "GRU 64": {"memory": "gru", "hidden_size": 64},
    "GRU 128": {"memory": "gru", "hidden_size": 128},
}


def best_rate(run: Callable[[], int], stretches: int, seconds: float) -> float:
    """Return steps per second of processor time, the best of the stretches; `run()` returns its number of steps."""
    run()
    best = 0.0
    for _ in range(stretches):
        began, steps = time.process_time(), 0
        while (spent := time.process_time() - began) < seconds:
            steps += run()
        best = max(best, steps / spent)
    return best


def kernel_steps(mazes: Mazes) -> Callable[[], int]:
    """Return a function that steps and observes in the kernel alone; agents walk on after an episode ends."""
    actions = np.random.default_rng(0).integers(0, 3, (DRAWN, mazes.num_envs))
    seen = mazes.observe()

    def run() -> int:
        for chosen in actions:
            step_mazes(mazes._layouts, mazes._agents, mazes._settings, chosen, mazes._outcome, seen)
        return actions.size

    return run


def environment_steps(mazes: Mazes, new: bool) -> Callable[[], int]:
    """Return a function that steps through Gymnasium's interface; `new`: episodes begin on new random mazes."""
    actions = np.random.default_rng(0).integers(0, 3, (DRAWN, mazes.num_envs))

    def run() -> int:
        mazes.level_sampler = mazes.sample_levels if new else None
        for chosen in actions:
            mazes.step(chosen)
        return actions.size

    return run


def alone(stretches: int) -> list[list[str]]:
    """Measure mazes alone."""
    rows = [["mazes alone, random actions", "environments", "steps/s"]]
    for count in (NUM_ENVS, 1024):
        for config, label in ((MazeConfig(), ""), (MazeConfig(see_through=False), ", walls hide")):
            mazes = Mazes(count, config)
            mazes.reset(seed=0)
            for name, run in (
                ("kernel", kernel_steps(mazes)),
                ("environment, the same mazes", environment_steps(mazes, False)),
                ("environment, new mazes", environment_steps(mazes, True)),
            ):
                mazes.reset(seed=0)
                rows.append([name + label, str(count), f"{best_rate(run, stretches, 0.5):,.0f}"])
    return rows


def training(methods: list[str], students: list[str], stretches: int, updates: int) -> list[list[str]]:
    """Measure training, compiled and step by step in turns."""
    rows = [["training, 32 x 256", "student", "rollouts", "env steps/s", "learning", "without learning"]]
    for name in methods:
        for student in students:
            ppo = PPOConfig(num_steps=NUM_STEPS, **STUDENTS[student])
            made = {on: METHODS[name].load()(Mazes(NUM_ENVS), ppo, None, seed=0) for on in (True, False)}
            best = dict.fromkeys(made, (0.0, 0.0))
            for stretch in range(stretches + 1):  # the first stretch warms up
                for on, method in made.items():
                    measured = measure(method, on, updates)
                    best[on] = max(best[on], measured if stretch else best[on])
            for on, (speed, share) in best.items():
                played = f"{speed / (1 - share):,.0f}"
                rows.append(
                    [name, student, "compiled" if on else "single steps", f"{speed:,.0f}", f"{share:.1%}", played]
                )
    return rows


def measure(method: Any, compiled: bool, updates: int) -> tuple[float, float]:
    """Return a method's steps per second of processor time over some updates, and the share spent on learning."""
    worker.COMPILED = compiled
    began, steps, spent, learning = time.process_time(), method.env_steps, 0.0, 0.0
    for _ in range(updates):
        metrics = method.update()
        learning += metrics.get("time/learn", 0.0)
        spent += sum(value for key, value in metrics.items() if key.startswith("time/"))
    return (method.env_steps - steps) / (time.process_time() - began), learning / spent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--methods", nargs="+", choices=list(METHODS), default=["dr"])
    parser.add_argument("--students", nargs="+", choices=list(STUDENTS), default=list(STUDENTS))
    parser.add_argument(
        "--stretches", type=int, default=3, help="stretches of each measurement, of which the best counts"
    )
    parser.add_argument("--updates", type=int, default=2, help="updates in a stretch of training")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    print(machine_line(), "\n")
    print(align(alone(arguments.stretches)), "\n", flush=True)
    print(align(training(arguments.methods, arguments.students, arguments.stretches, arguments.updates)))


if __name__ == "__main__":
    main()
