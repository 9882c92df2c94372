"""When replay and teachers begin, by the length of the run: sooner in a short one, so that something is learned.

A buffer of 1,000 levels wants 500 before anything is replayed, and an adversary waits for 32 levels. A run of long
episodes may never play so many. So the defaults also begin once a share of the run is spent, and a method that does
not know how long it will run begins after a few levels of each environment. Read next: `levels.buffer`,
`levels.teacher`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

FILL = 0.5  # of the buffer: levels offered before replay where the run is long enough for them
BATCH = 32  # levels that an adversary waits for in such a run
SHARE = 0.1  # of the budget, after which neither waits longer
LEAST_BATCH = 4  # levels of an adversary's smallest batch: fewer cannot be told apart
LEVELS_PER_ENV = 4  # offered before replay where no budget is known
NUM_ENVS = 16  # where a curriculum is used without environments


@dataclass
class Budget:
    """How long a run is, as far as known, and how much of it is spent.

    Attributes:
        num_envs: environments of each student.
        total: env_steps of the run; None: not known.
        spent: env_steps before the rollout that is being filled.
    """

    num_envs: int = NUM_ENVS
    total: int | None = None
    spent: int = 0

    @classmethod
    def of(cls, space: Any) -> Budget:
        """Return the budget of a curriculum that nobody gave one: all that is known is its number of environments."""
        return cls(getattr(space, "num_envs", NUM_ENVS))

    def warm_up(self) -> int:
        """Return the env_steps after which nobody waits longer; 0 where no budget is known."""
        return 0 if self.total is None else round(SHARE * self.total)

    def allows_replay(self, offered: int, capacity: int) -> bool:
        """Return whether a buffer to which so many levels were offered may be replayed, by default."""
        if offered >= FILL * capacity:
            return True
        if self.total is None:
            return offered >= LEVELS_PER_ENV * self.num_envs
        return offered > 0 and self.spent >= self.warm_up()

    def allows_lesson(self, waiting: int, last: int) -> bool:
        """Return whether an adversary may learn from so many levels, by default, having learned at env_step `last`."""
        if waiting >= BATCH:
            return True
        if self.total is None:
            return waiting >= max(LEAST_BATCH, self.num_envs)
        return waiting >= LEAST_BATCH and self.spent - last >= self.warm_up()
