"""A task whose environments may be told to block in a call of C that no signal interrupts.

In the folder `REGISTA_TEST_STUCK`, a file `make` or `step` says where; whoever blocks leaves a file `stuck`.
"""

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any

import ued
from ued.probes import Frontier


def block(place: str) -> None:
    """Lock a mutex twice if we are to block here: the thread is in C for good, and needs no processor time."""
    folder = Path(os.environ.get("REGISTA_TEST_STUCK", "/nowhere"))
    if (folder / place).exists():
        (folder / "stuck").touch()
        mutex = ctypes.create_string_buffer(256)
        for _ in range(2):
            ctypes.CDLL(None).pthread_mutex_lock(mutex)


class SlowFrontier(Frontier):
    """The probe, which may block in a step."""

    def advance(self, actions: Any) -> Any:
        block("step")
        return super().advance(actions)


def make(num_envs: int) -> SlowFrontier:
    """Make environments to train on."""
    block("make")
    return SlowFrontier(num_envs, longest=3)


walk = ued.Task(make, tests={"short": [[-1, -1, -1, -1]]})
