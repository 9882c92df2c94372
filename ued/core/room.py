"""How much memory settings need, and how much this machine has: what cannot fit is refused before it is allocated.

Needs are estimated from below, so settings that fit are never refused. Read next: `methods.method`, which adds
learners.
"""

from __future__ import annotations

import math
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gymnasium.spaces import Space

    from ued.config import PPOConfig

UNITS = ("B", "kB", "MB", "GB", "TB", "PB")
WEIGHT_BYTES = 16  # of a weight: itself, its gradient, and two moments of Adam, float32 each
ENTRY_BYTES = 20  # of a step of one agent: action, log_prob, value, reward, final_value
FEATURES = 32 * 5 * 8  # at least what convolutions leave of a large image


class RoomError(ValueError):
    """Settings that need more memory than this machine has; `settings` are their names."""

    def __init__(self, message: str, settings: tuple[str, ...]) -> None:
        super().__init__(message)
        self.settings = settings


@cache
def machine_bytes() -> int:
    """Return the memory of this machine, or of the container that we are in."""
    limits = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    for file in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError):  # there is none, or it says "max"
            limits.append(int(Path(file).read_text()))
    return min(limits)


def check_environments(num_envs: int, each: int) -> None:
    """Raise `RoomError` where so many environments of `each` bytes do not fit."""
    if num_envs * each > machine_bytes():
        raise RoomError(
            f"{num_envs:_} environments of {size(each)} each need {size(num_envs * each)}; {_has()}", ("num_envs",)
        )


def check_learners(config: PPOConfig, space: Space, num_envs: int, agents: int, learners: int) -> None:
    """Raise `RoomError` where the rollouts or the networks of so many learners do not fit.

    `space` is of what one agent observes in one of the `num_envs` environments.
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
    """Return how many weights the hidden layers of a student have at least."""
    shape, hidden = space.shape or (), config.hidden_size
    image = len(shape) == 3
    inputs = FEATURES if image else math.prod(shape)
    torso = inputs * hidden + (0 if image else (config.hidden_layers - 1) * hidden * hidden)
    if config.memory == "gru":
        torso += 6 * hidden * hidden
    return torso * (1 if config.shared_torso else 2) * (1 if config.team == "shared" else agents)


def space_bytes(space: Space) -> int:
    """Return the bytes of one observation as rollouts keep it: bytes as bytes, other numbers as float32."""
    return math.prod(space.shape or ()) * (1 if str(space.dtype) == "uint8" else 4)


def size(count: float) -> str:
    """Return a number of bytes with its unit, such as 1.5 GB."""
    power = min(int(math.log(max(count, 1), 1000)), len(UNITS) - 1)
    return f"{count / 1000**power:.3g} {UNITS[power]}"


def _has() -> str:
    return f"this machine has {size(machine_bytes())}"
