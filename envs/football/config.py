"""Settings of the football environment. Settings of the match are parameters of the Scenic program instead.

Importing it loads neither NumPy nor Numba. Read next: `vector_env`.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field

from regista.envs.football.constants import CONTROL_MODES

REPRESENTATIONS = ("features", "simple115", "smm", "smm_stacked", "raw")
REWARDS = ("scoring", "scoring,checkpoints")  # Google Research Football's names
ENGINES = ("regista", "grf")
PIXELS = ("dense", "sparse")
MOST_SPREAD = 0.99


def most_workers() -> int:
    """Return the largest number of processes that may run GRF on this machine."""
    return 4 * (os.cpu_count() or 1)


@dataclass(frozen=True)
class FootballConfig:
    """The settings of the football environment: observations, rewards, controlled players and engine.

    Raises:
        ValueError: an unknown name, or a number outside its range.
    """

    representation: str = field(
        default="features",
        metadata={"help": "observation: features, simple115, smm, smm_stacked or raw", "words": REPRESENTATIONS},
    )
    rewards: str = field(
        default="scoring", metadata={"help": "reward: scoring or scoring,checkpoints", "words": REWARDS}
    )
    control: str = field(
        default="closest1",
        metadata={"help": "left players that agents move: closest1 to closest3, active, a number, all, allNonGK, none"}
        | {"words": CONTROL_MODES},
    )
    right_control: str = field(
        default="none", metadata={"help": "right players that agents move: same values", "words": CONTROL_MODES}
    )
    dialect: int | None = field(
        default=None,
        metadata={"help": "version of Scenic that the program is written in, 2 or 3; default: detected"}
        | {"least": 2, "most": 3},
    )
    engine_spread: float = field(
        default=0.0,
        metadata={"help": "relative spread of keepers, tackles, kicks and reactions between episodes, such as 0.15"}
        | {"least": 0, "most": MOST_SPREAD},
    )
    pixels: str = field(
        default="dense",
        metadata={
            "help": "smm and smm_stacked as images (dense), or as the coordinates of their marked pixels, from which "
            "convolutions compute the same but for rounding, several times faster (sparse)",
            "words": PIXELS,
        },
    )
    engine: str = field(
        default="regista",
        metadata={"help": "simulator: regista, our simulator, or grf, Google Research Football", "words": ENGINES},
    )
    grf_python: str | None = field(default=None, metadata={"help": "the Python that has gfootball; default: detected"})
    grf_workers: int = field(
        default=0,
        metadata={"help": "worker processes for grf; 0: one per core"} | {"least": 0, "most": most_workers},
    )

    def __post_init__(self) -> None:
        known: tuple[tuple[str, tuple], ...] = (
            *(("representation", REPRESENTATIONS), ("rewards", REWARDS), ("dialect", (None, 2, 3))),
            *(("engine", ENGINES), ("pixels", PIXELS)),
        )
        for name, values in known:
            if getattr(self, name) not in values:
                raise ValueError(f"{name} must be one of {', '.join(map(repr, values))}, not {getattr(self, name)!r}")
        for name in ("control", "right_control"):
            check_control(getattr(self, name))
        if not 0 <= self.engine_spread <= MOST_SPREAD:
            raise ValueError(f"engine_spread must be 0 or more and at most {MOST_SPREAD}, got {self.engine_spread}")
        if self.engine_spread and self.engine == "grf":
            raise ValueError("engine_spread needs engine 'regista'; engine 'grf' does not support it")
        if not 0 <= self.grf_workers <= most_workers():
            raise ValueError(
                f"grf_workers must be 0 or more and at most {most_workers()} on this machine, got {self.grf_workers}"
            )
        if self.control == self.right_control == "none":
            raise ValueError("control and right_control are both 'none': at least one agent is needed")


def check_control(mode: str | int) -> str:
    """Return a control mode as text. Raises ValueError for an unknown one."""
    text = str(mode)
    if text not in CONTROL_MODES and not (text.isdecimal() and int(text) > 0):
        known = ", ".join(CONTROL_MODES)
        raise ValueError(f"control must be {known} or a whole number of players from 1, not {mode!r}")
    return text
