"""A task whose environments may be told to block in a call of C that no signal interrupts.

In the folder `REGISTA_TEST_STUCK`, a file `make` or `step` says where; whoever blocks leaves a file `stuck`. A process
writes there into `played` how many steps it has made.
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

    played = 0  # steps of all environments of this process

    def advance(self, actions: Any) -> Any:
        block("step")
        outcome = super().advance(actions)
        SlowFrontier.played += 1
        if "REGISTA_TEST_STUCK" in os.environ:
            (Path(os.environ["REGISTA_TEST_STUCK"]) / "played").write_text(str(SlowFrontier.played))
        return outcome


def make(num_envs: int) -> SlowFrontier:
    """Make environments to train on."""
    block("make")
    return SlowFrontier(num_envs, longest=3)


walk = ued.Task(make, tests={"short": [[-1, -1, -1, -1]]})
