"""Rows of measurements on a minigame: a policy on a scene, and its training. Stored as CSV in the repository.

Read next: `lab/studies/measuring.py`, where rows come from; `lab/studies/tables.py`, what is made of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

from regista.envs.football.version import UNNUMBERED, simulator_name
from regista.experiments.run import versions
from regista.experiments.run.errors import CommandError, refused
from regista.experiments.run.report import save_rows
from regista.experiments.run.results import Result
from regista.experiments.run.table import read_rows

RESULTS = Path(__file__).parent / "results"  # of studies that the repository holds
MOST = 10**15  # upper bound of any number in a row
SIGNED = ("goal_difference", "mean_return", "value")  # numbers that may be negative
TRAIN = "train"  # the scene of the training distribution


class Row(NamedTuple):
    """A policy on a scene: `agent` is as in `minigames/published.csv`, `scene` is train or the label of a test."""

    game: str
    agent: str
    control: str
    scene: str
    seed: int
    env_steps: int  # of the training, 0 without training
    episodes: int
    goal_difference: float  # per episode
    deviation: float  # between episodes
    scored: int  # episodes
    conceded: int
    mean_length: float  # steps
    seconds: float  # of the training
    commit: str
    simulator: str  # the version that was played, as in `versions.spelled`
    processor: str = ""  # that trained the run; "": nothing was trained, or it is not known

    def key(self) -> tuple[str, str, str, str, int]:
        """Return the key of the row; a later row with the same key replaces it."""
        return self[:5]

    def result(self) -> Result:
        """Return the row as a result for estimating intervals."""
        return Result(
            method=self.agent,
            seed=self.seed,
            scene=self.scene,
            episodes=self.episodes,
            mean_return=self.goal_difference,
            return_std=self.deviation,
            goals=self.scored,
            mean_length=self.mean_length,
            env_steps=self.env_steps,
            updates=0,
        )


class Point(NamedTuple):
    """A point of a learning curve: the mean success over the test scenes of a minigame after some training."""

    game: str
    agent: str
    seed: int
    env_steps: int
    seconds: float
    success: float  # between 0 and 1
    simulator: str  # as in `Row`
    trained_steps: int = 0  # steps that the tested student learned from; 0: unknown

    def key(self) -> tuple[str, str, int, int]:
        """Return the key of the point; a later point with the same key replaces it."""
        return self[:4]


def load(path: Path, kind: Any = Row) -> list[Any]:
    """Return the rows of a file, of class `kind`; none without a file. Raises `CommandError` for a damaged file.

    Rows without a version of the simulator get the unnumbered one.
    """
    read, unnumbered = get_type_hints(kind), {versions.KEY: str(UNNUMBERED)}
    try:
        rows = [unnumbered | row for row in read_rows(path)]
        return [_checked(kind(**{name: read[name](text) for name, text in row.items()})) for row in rows]
    except (ValueError, KeyError, TypeError) as error:
        raise CommandError(f"{path} is damaged: {refused(error)}") from error


def _checked(row: Any) -> Any:
    """Return a row unchanged. Raises ValueError for impossible numbers, and for a missing simulator."""
    if row.simulator != versions.NO_SIMULATOR and not row.simulator.isdecimal():
        raise ValueError(f"simulator is {row.simulator!r}")
    for name, number in row._asdict().items():
        least = 1 if name == "episodes" else -MOST if name in SIGNED else 0
        if not isinstance(number, str) and not (math.isfinite(number) and least <= number < MOST):
            raise ValueError(f"{name} is {number}")
    if isinstance(row, Row) and row.scored + row.conceded > row.episodes:
        raise ValueError(f"{row.scored} scored and {row.conceded} conceded of {row.episodes} episodes")
    return row


def check_present(path: Path, rows: Sequence[Any]) -> None:
    """Raise `CommandError` if rows of a file are of another version of the simulator.

    Such rows are neither extended nor published.
    """
    for version in sorted({row.simulator for row in rows} - {versions.NO_SIMULATOR}, key=int):
        refused = "they can be neither published nor added to; move the file away to measure them again"
        versions.check_present(int(version), f"rows of {path} were measured on", refused)


def played_on(rows: Iterable[Any]) -> str:
    """Return the simulators on which rows were measured, in words."""
    found = dict.fromkeys(row.simulator for row in rows)
    names = ["no simulator of ours" if text == versions.NO_SIMULATOR else simulator_name(int(text)) for text in found]
    return " and ".join(names)


def add(path: Path, rows: Iterable[Any], kind: Any = Row) -> list[Any]:
    """Put rows into a file in place of older rows with equal keys, and return all rows of the file.

    Raises `CommandError` if writing fails.
    """
    by_key = {row.key(): row for row in [*load(path, kind), *rows]}
    kept = [by_key[key] for key in sorted(by_key)]
    save_rows([row._asdict() for row in kept], kind._fields, path)
    return kept


def trained(rows: Sequence[Row], game: str, agent: str, control: str, seed: int) -> int:
    """Return the training steps after which an agent was measured, 0 if it was not measured."""
    key = (game, agent, control, seed)
    return max((row.env_steps for row in rows if (row.game, row.agent, row.control, row.seed) == key), default=0)
