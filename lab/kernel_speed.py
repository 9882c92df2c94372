"""How much of a core's float32 peak do compiled forward passes reach at 16 rows, and how long does a step take?

    python -m lab.kernel_speed

The peak is the speed of a large matrix product in torch. A policy step is its whole part of a compiled rollout:
normalization, forward pass, sampling. The simulator step uses random actions. Each number is processor time, the best
of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from lab.benchmarks.timing import make_method
from regista.experiments.run import build
from regista.experiments.run.results import align
from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES
from regista.kernels.rollout.network import linear
from regista.kernels.rollout.policy import sample_actions
from ued.core.compiled import LAYER

LAYERS = ((55, 64), (64, 64), (64, 20), (115, 64), (128, 384))  # inputs, outputs
GAME = "1v1Rare"
CALLS = 2_000


@kernel
def repeat_linear(weights, layers, x, y):
    """Compute a layer repeatedly."""
    for _ in range(CALLS):
        linear(weights, layers[0], x, y)


@kernel
def repeat_steps(policy, steps, envs):
    """Sample the actions of all steps of a rollout."""
    for t in range(len(steps.action)):
        sample_actions(policy, steps, envs, t)


def best(call: Callable[[], Any], times: int = 30) -> float:
    """Return the least processor time of a call in seconds, without the first call, which may compile."""
    call()
    found = float("inf")
    for _ in range(times):
        began = time.process_time()
        call()
        found = min(found, time.process_time() - began)
    return found


def peak() -> float:
    """Return the speed of a large product, in flop/s."""
    a, b, c = (torch.randn(1024, 1024) for _ in range(3))
    return 2 * 1024**3 / best(lambda: torch.mm(a, b, out=c))


def layer_rows(most: float) -> list[list[str]]:
    """Measure layers of several sizes on 16 rows."""
    rows = []
    for inputs, outputs in LAYERS:
        weights, x = (
            np.random.default_rng(0).normal(size=size).astype(np.float32)
            for size in ((inputs + 1) * outputs, inputs * LANES)
        )
        layer = np.array([(False, False, 0, inputs * outputs, inputs, outputs)], LAYER).view(np.recarray)
        y = np.zeros(outputs * LANES, np.float32)
        speed = 2 * inputs * outputs * LANES * CALLS / best(lambda: repeat_linear(weights, layer, x, y))  # noqa: B023
        rows.append([f"layer {inputs} -> {outputs}", f"{speed / 1e9:.0f} GFLOP/s", f"{speed / most:.0%} of the peak"])
    return rows


def step_rows(most: float) -> list[list[str]]:
    """Measure a step of the policy and of the simulator in a football game."""
    found = build.find_game(GAME)
    config = found.start("fast")
    method = make_method(config)
    record = method.learners[0].worker.record
    count = record.steps.action[..., 0].size
    seconds = best(lambda: repeat_steps(record.policy, record.steps, record.envs)) / count
    layers = record.policy.actor.layers
    flops = 2 * int((layers.inputs * layers.outputs).sum())
    share = f"{flops / seconds / most:.0%} of the peak"
    env, rng = method.upomdp, np.random.default_rng(0)
    actions = rng.integers(0, 19, (64, env.num_envs))

    def simulate() -> None:
        for row in actions:
            env.step(row)

    simulated = best(simulate) / actions.size
    return [
        [f"policy of {GAME}, {flops:,} flop", f"{seconds * 1e6:.2f} us per step", share],
        [f"env.step of {GAME}, {env.num_envs} environments", f"{simulated * 1e6:.2f} us per step", ""],
    ]


def main() -> None:
    """Print the table."""
    torch.set_num_threads(1)
    most = peak()
    print(align([["what", "speed", f"peak {most / 1e9:.0f} GFLOP/s"], *layer_rows(most), *step_rows(most)]))


if __name__ == "__main__":
    main()
