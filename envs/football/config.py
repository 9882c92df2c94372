"""Settings of the football environment; those of the match itself are parameters of the program.

Light: importing it loads neither NumPy's nor Numba's machinery. Read next: `vector_env`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

OBSERVATIONS = ("features", "raw")
REWARDS = ("scoring", "scoring,checkpoints")  # Google Research Football's names


@dataclass(frozen=True)
class FootballConfig:
    """What the learner sees and is paid for. Raises ValueError for a name that does not exist."""

    observation: str = field(default="features", metadata={"help": "what the learner sees: features or raw"})
    rewards: str = field(default="scoring", metadata={"help": "what it is paid for: scoring or scoring,checkpoints"})
    dialect: int | None = field(
        default=None, metadata={"help": "version of Scenic that the program is written in, 2 or 3; else found out"}
    )

    def __post_init__(self) -> None:
        known = (("observation", OBSERVATIONS), ("rewards", REWARDS), ("dialect", (None, 2, 3)))
        for name, values in known:
            if getattr(self, name) not in values:
                raise ValueError(f"{name} must be one of {', '.join(map(repr, values))}, not {getattr(self, name)!r}")
