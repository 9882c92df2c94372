"""Memory checks: settings that cannot fit into memory are rejected before allocation.

Estimates are lower bounds, so settings that fit are never rejected. Read next: `methods.method`, which adds learners.
"""

from __future__ import annotations

import math
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ued.core.own_code import is_name
from ued.core.parts import Parts
from ued.core.sparse_image import dense_space

if TYPE_CHECKING:
    from gymnasium.spaces import Space

    from ued.config import PPOConfig

UNITS = ("B", "kB", "MB", "GB", "TB", "PB")
WEIGHT_BYTES = 16  # per weight: value, gradient, and two moments of Adam, float32 each
ENTRY_BYTES = 20  # per step of one agent: action, log_prob, value, reward, final_value
FEATURES = 32 * 5 * 8  # minimum output size of the convolutions for a large image


class RoomError(ValueError):
    """Settings that need more memory than this machine has; `settings` are their names."""

    def __init__(self, message: str, settings: tuple[str, ...]) -> None:
        super().__init__(message)
        self.settings = settings


@cache
def machine_bytes() -> int:
    """Return the memory of this machine, or of the container."""
    limits = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    for file in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError):  # no such file, or its content is "max"
            limits.append(int(Path(file).read_text()))
    return min(limits)


def check_environments(num_envs: int, each: int) -> None:
    """Raise `RoomError` if `num_envs` environments of `each` bytes do not fit."""
    if num_envs * each > machine_bytes():
        raise RoomError(
            f"{num_envs:_} environments of {size(each)} each need {size(num_envs * each)}; {_has()}", ("num_envs",)
        )


def check_learners(config: PPOConfig, space: Space, num_envs: int, agents: int, learners: int) -> None:
    """Raise `RoomError` if the rollouts or the networks of this number of learners do not fit.

    `space` is the observation space of one agent in one of the `num_envs` environments.
    """
    rollouts = learners * num_envs * config.num_steps * agents * (space_bytes(space) + ENTRY_BYTES)
    if rollouts > machine_bytes():
        raise RoomError(
            f"{learners} rollouts of {num_envs:_} environments x {config.num_steps:_} steps x {agents} observations of "
            f"{size(space_bytes(space))} need {size(rollouts)}; {_has()}",
            ("num_envs", "num_steps"),
        )
    networks = learners * WEIGHT_BYTES * weights(config, space, agents)
    if networks > machine_bytes():
        raise RoomError(
            f"{learners} students with {config.hidden_layers} hidden layers of {config.hidden_size:_} units need "
            f"{size(networks)}; {_has()}",
            ("hidden_size", "hidden_layers"),
        )


def weights(config: PPOConfig, space: Space, agents: int) -> int:
    """Return a lower bound on the weights in a student's hidden layers; 0 for a network of the user."""
    shape, hidden = dense_space(space).shape or (), config.hidden_size
    if is_name(config.network):
        return 0
    image = len(shape) == 3 and config.network != "mlp"
    inputs, layers = (FEATURES, 1) if image else (math.prod(shape), config.hidden_layers)
    if isinstance(space, Parts) and config.network != "mlp":
        inputs = len(space.others)  # convolutions may make fewer features of images than they have entries
    torso = inputs * hidden + (layers - 1) * hidden * hidden if layers else 0
    if config.memory == "gru":
        torso += 3 * hidden * ((hidden if layers else inputs) + hidden)
    return torso * (1 if config.shared_torso else 2) * (1 if config.team == "shared" else agents)


def space_bytes(space: Space) -> int:
    """Return the bytes of one observation in a rollout: uint8 stays, other numbers are float32."""
    return math.prod(space.shape or ()) * (1 if str(space.dtype) == "uint8" else 4)


def size(count: float) -> str:
    """Return a number of bytes with its unit, such as 1.5 GB."""
    power = min(int(math.log(max(count, 1), 1000)), len(UNITS) - 1)
    return f"{count / 1000**power:.3g} {UNITS[power]}"


def _has() -> str:
    return f"this machine has {size(machine_bytes())}"
