"""Published results on the minigames: the rows of `published.csv`. Read next: `suites`."""

from __future__ import annotations

import csv
from functools import cache
from typing import Any, NamedTuple

from regista.minigames.suites import HERE


class Published(NamedTuple):
    """A mean goal difference per episode; `interval` is half the width of its 95% interval. None: not available."""

    game: str
    agent: str
    control: str
    split: str  # train or test
    goal_difference: float
    interval: float | None
    runs: int | None
    episodes: int | None
    source: str


@cache
def published() -> tuple[Published, ...]:
    """Return all rows; the header of the file explains the names of agents."""
    with open(HERE / "published.csv", newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return tuple(_row(row) for row in rows)


def find_published(game: str, agent: str, split: str = "train", control: str = "") -> Published | None:
    """Return the row of an agent on a game (without `control` the first one), or None if there is none."""
    rows = (row for row in published() if (row.game, row.agent, row.split) == (game, agent, split))
    return next((row for row in rows if control in ("", row.control)), None)


def _row(row: dict[str, str]) -> Published:
    read: dict[str, Any] = {"goal_difference": float, "interval": float, "runs": int, "episodes": int}
    values: dict[str, Any] = {name: read.get(name, str)(text) if text else None for name, text in row.items()}
    return Published(**values)
