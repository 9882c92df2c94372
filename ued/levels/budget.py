"""The start of replay and of the teacher's updates, which depends on the length of the run.

By default replay starts after 500 levels for a buffer of 1,000, and an adversary learns from 32 levels at a time. A run
of long episodes may never play that many levels, so both also start after a share of the run. Without a known budget
both start after a few levels of each environment. Read next: `levels.buffer`, `levels.teacher`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

FILL = 0.5  # levels offered before replay starts, as a share of the buffer
BATCH = 32  # levels that an adversary waits for
SHARE = 0.1  # share of the budget after which both start
LEAST_BATCH = 4  # levels in an adversary's smallest batch
LEVELS_PER_ENV = 4  # levels offered before replay starts without a known budget
NUM_ENVS = 16  # assumed for a curriculum without environments


@dataclass
class Budget:
    """The length of a run, if known, and the steps so far.

    Attributes:
        num_envs: environments of each student.
        total: env_steps of the run; None: unknown.
        spent: env_steps before the current rollout.
    """

    num_envs: int = NUM_ENVS
    total: int | None = None
    spent: int = 0

    @classmethod
    def of(cls, space: Any) -> Budget:
        """Return the default budget of a curriculum: unknown length, number of environments as in the space."""
        return cls(getattr(space, "num_envs", NUM_ENVS))

    def warm_up(self) -> int:
        """Return the env_steps after which replay and updates start; 0 without a known budget."""
        return 0 if self.total is None else round(SHARE * self.total)

    def allows_replay(self, offered: int, capacity: int) -> bool:
        """Return whether replay may start by default, after `offered` levels."""
        if offered >= FILL * capacity:
            return True
        if self.total is None:
            return offered >= LEVELS_PER_ENV * self.num_envs
        return offered > 0 and self.spent >= self.warm_up()

    def allows_lesson(self, waiting: int, last: int) -> bool:
        """Return whether an adversary may learn by default from `waiting` levels; its last update was at `last`."""
        if waiting >= BATCH:
            return True
        if self.total is None:
            return waiting >= max(LEAST_BATCH, self.num_envs)
        return waiting >= LEAST_BATCH and self.spent - last >= self.warm_up()
