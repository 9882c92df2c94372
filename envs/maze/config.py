"""Settings of the maze environment. Importing it loads neither NumPy nor Numba. Read next: `env`."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

REPRESENTATIONS = ("features", "image")
MOST_SIDE, MOST_STEPS = 255, 1_000_000


@dataclass(frozen=True)
class MazeConfig:
    """Size, random walls, time limit and view of mazes. Raises ValueError for values outside their bounds.

    `MazeConfig()` is DCD's "25 blocks", `MazeConfig(num_walls=60, random_count=True)` its "60 blocks, uniform".
    """

    side: int = field(
        default=13, metadata={"help": "cells per side, without the border", "least": 2, "most": MOST_SIDE}
    )
    num_walls: int = field(
        default=25,
        metadata={"help": "walls placed in random mazes; several may fall on one cell"}
        | {"least": 0, "most": MOST_SIDE**2},
    )
    random_count: bool = field(
        default=False, metadata={"help": "place a random number of walls, 0 to num_walls - 1, in each maze"}
    )
    goal_last: bool = field(
        default=True,
        metadata={"help": "let an adversary that builds mazes in steps place goal and agent after the walls"},
    )
    max_steps: int = field(
        default=250, metadata={"help": "steps after which an episode is truncated", "least": 1, "most": MOST_STEPS}
    )
    see_through: bool = field(default=True, metadata={"help": "let the agent see what lies behind walls"})
    representation: str = field(
        default="features",
        metadata={"help": "observation: features, walls and goal as 0 or 1, or image, MiniGrid's codes divided by 10"},
    )

    def __post_init__(self) -> None:
        for entry in fields(self):
            if "most" not in entry.metadata:
                continue
            value, least, most = getattr(self, entry.name), entry.metadata["least"], entry.metadata["most"]
            if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
                raise ValueError(f"{entry.name} must be an integer from {least} to {most}, got {value!r}")
        for name in ("random_count", "goal_last", "see_through"):
            if not isinstance(getattr(self, name), bool):  # "False" would count as true
                raise ValueError(f"{name} must be True or False, got {getattr(self, name)!r}")
        if self.representation not in REPRESENTATIONS:
            known = ", ".join(map(repr, REPRESENTATIONS))
            raise ValueError(f"representation must be one of {known}, not {self.representation!r}")
