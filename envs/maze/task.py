"""Mazes as a task: random mazes for training, the benchmark's test mazes, pictures, baseline policies, settings.

    regista train maze --method accel
    regista compare maze --methods dr plr accel
    regista compare maze60 --methods dr accel      # with 0 to 59 walls instead of 25

Read next: `named_mazes`, the test mazes; `ued.core.task`.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.named_mazes import LARGE_MAZES, TEST_MAZES
from regista.envs.maze.painter import MazePainter
from regista.envs.maze.shortest_path import ShortestPath
from ued.core.baselines import UniformPolicy
from ued.core.task import Task

# 32 environments x 256 steps, discount 0.995, lambda 0.95, clipping 0.2, Adam's epsilon 1e-5 and the buffers' capacity
# and staleness are DCD's. The others were selected for 5M steps instead of its 250M (docs/benchmarks/maze.md): a GRU of
# 64 units instead of a convolution and an LSTM of 256, a learning rate of 1e-3 instead of 1e-4, one epoch of 8
# minibatches instead of 5 epochs of one minibatch, which take five times as long, and a temperature of 1 instead of
# 0.1, at which most replays are of a single level.
BUFFERS = ("plr", "accel", "cenie", "repaired")
DEFAULTS: dict[str, Any] = {
    "total_env_steps": 25_000_000,
    "num_envs": 32,
    "eval_every": 2_500_000,
    "eval_episodes": 10,
    "record_rollouts": 100,
    "ppo.num_steps": 256,
    "ppo.gamma": 0.995,
    "ppo.gae_lambda": 0.95,
    "ppo.update_epochs": 1,
    "ppo.num_minibatches": 8,
    "ppo.clip_coef": 0.2,
    "ppo.learning_rate": 1e-3,
    "ppo.adam_eps": 1e-5,
    "ppo.ent_coef": 0.01,
    "ppo.memory": "gru",
    "ppo.hidden_size": 64,
    "ppo.shared_torso": True,
    **{f"{method}.buffer.capacity": 4000 for method in BUFFERS},
    **{f"{method}.buffer.temperature": 1.0 for method in BUFFERS},
    **{f"{method}.buffer.staleness_coef": 0.3 for method in BUFFERS},
    **{f"{method}.adversary.steps.ent_coef": 0.05 for method in ("paired", "repaired", "minimax")},
    "paired.dr_fraction": 0.0,
    "sfl.candidates": 1024,
    "sfl.chosen": 256,
    "sfl.choose_every": 50,
}


def maze_task(config: MazeConfig = MazeConfig()) -> Task:  # noqa: B008 (frozen)
    """Return the task of random mazes and the benchmark's test mazes, with the observations of `config`.

    `PerfectMazeLarge`, whose episodes last up to 5,202 steps, is for final tables only: `--held-out`.
    """
    return Task(
        partial(make_mazes, config=config),
        tests={name: partial(test.make, config=config) for name, test in TEST_MAZES.items()},
        held_out={name: partial(test.make, config=config) for name, test in LARGE_MAZES.items()},
        painter=MazePainter,  # type: ignore[arg-type]
        baselines={"shortest path": ShortestPath, "random": _random},  # type: ignore[dict-item]
        defaults=DEFAULTS,
        success_word="solved",
        about={name: test.about for name, test in {**TEST_MAZES, **LARGE_MAZES}.items()},
    )


def make_mazes(num_envs: int, config: MazeConfig = MazeConfig()) -> Mazes:  # noqa: B008 (frozen)
    """Make N random mazes that can be rendered."""
    return Mazes(num_envs, config, render_mode="rgb_array")


def _random(upomdp: Any) -> UniformPolicy:
    return UniformPolicy(upomdp.single_action_space)


maze = maze_task()
maze60 = maze_task(MazeConfig(num_walls=60, random_count=True))
