"""How fast something runs: the best of several stretches, for others may use the machine meanwhile.

Read next: `commands.benchmark`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

STRETCHES = 3  # of each measurement; the best counts


class Measurement(NamedTuple):
    """One line of a table: steps of a single environment per second."""

    what: str
    steps_per_second: float
    note: str = ""


def random_steps(env: Any) -> Callable[[int], None]:
    """Return what steps an environment so many times with random actions, drawn beforehand; it has stepped 8 times."""
    actions = np.random.default_rng(0).integers(0, env.single_action_space.n, (64, env.num_envs))

    def step(count: int) -> None:
        for t in range(count):
            env.step(actions[t % 64])

    step(8)
    return step


def rate(
    run: Callable[[int], None], seconds: float, warm_up: int = 4, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return calls per second of `run(count)`: the best of several stretches that take `seconds` together."""
    began = clock()
    run(warm_up)
    count = max(1, int(warm_up * seconds / STRETCHES / max(clock() - began, 1e-6)))
    best = 0.0
    for _ in range(STRETCHES):
        began = clock()
        run(count)
        best = max(best, count / max(clock() - began, 1e-9))
    return best
