"""What an adversary proposed, column by column of θ, beside what the program draws: from levels.csv of a run.

Read next: `commands.inspect`, which prints it; `pictures.level_plots`, which draws it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.results import align
from regista.experiments.run.table import read_columns, read_rows
from ued.core.cells import Cells
from ued.core.parameters import Parameter, axis_of, choice_in
from ued.recorder.shades import unique_names

PERIODS = {"first tenth": (0.0, 0.1), "middle": (0.45, 0.55), "last tenth": (0.9, 1.0)}  # of the updates of a run
DECILES = 10


class ColumnOfProposals(NamedTuple):
    """One column of θ: its K values, or tenths of its range.

    names: of the values `[K]`; choice: whether they are values; program: their shares in random levels `[K]`;
    proposed: in the adversary's levels of each period `[P, K]`, nan where there are none; score: of all levels with the
    value, the mean of what the adversary is rewarded with (PAIRED: regret) `[K]`, nan likewise.
    """

    title: str
    names: tuple[str, ...]
    choice: bool
    program: np.ndarray
    proposed: np.ndarray
    score: np.ndarray


def read_proposals(run: Path, draws: Sequence[Parameter]) -> list[ColumnOfProposals]:
    """Return the columns of what a run's adversary proposed. Raises `CommandError` for a run without proposals."""
    table, path = read_columns(run / "levels.csv"), run / "levels.csv"
    proposed = np.array([row["source"] == "proposed" for row in read_rows(path)], bool)
    if not proposed.any():
        raise CommandError(f"{run} has no levels proposed by an adversary: {path} has none of the source 'proposed'")
    columns = []
    for name, draw in zip(unique_names(draws), draws, strict=True):
        if f"theta/{name}" not in table:
            raise CommandError(f"{path} has no column theta/{name}: it is of another program")
        columns.append(_column(name, draw, table, proposed))
    return columns


def _column(title: str, draw: Parameter, table: dict[str, np.ndarray], proposed: np.ndarray) -> ColumnOfProposals:
    known = choice_in(draw)
    cells = known or Cells(DECILES)
    index = cells.index(table[f"theta/{title}"])
    names = _tenths(draw) if known is None else known.names or tuple(map(str, range(cells.count)))
    score = table["score"]
    scored = np.isfinite(score)
    count = np.bincount(index[scored], minlength=cells.count)
    total = np.bincount(index[scored], score[scored], cells.count)
    mean = np.divide(total, count, out=np.full(cells.count, np.nan), where=count > 0)
    share = np.array(
        [_shares(index[proposed & within(table["update"], span)], cells.count) for span in PERIODS.values()]
    )
    return ColumnOfProposals(title, names, known is not None, cells.shares, share, mean)


def within(update: np.ndarray, period: tuple[float, float]) -> np.ndarray:
    """Return which of these updates some part of a period of the run falls into: bool, of the same shape."""
    count = update.max(initial=1.0)
    return (update > period[0] * count) & (update - 1 < period[1] * count)


def _shares(index: np.ndarray, count: int) -> np.ndarray:
    return np.bincount(index, minlength=count) / len(index) if len(index) else np.full(count, np.nan)


def _tenths(draw: Parameter) -> tuple[str, ...]:
    """Return the ends of the tenths of a real number's range, of θ where the range is not fixed."""
    axis = axis_of(draw)
    ends = np.linspace(axis.low, axis.high, DECILES + 1)
    if not np.isfinite(ends).all():
        ends = np.linspace(-1.0, 1.0, DECILES + 1)
    return tuple(f"{low:.4g} to {high:.4g}" for low, high in pairwise(ends))


def render_proposals(run: Path, columns: Sequence[ColumnOfProposals]) -> str:
    """Return them as tables: of each value its share in random levels, and in each period in the adversary's."""
    parts = [f"{run}: what the adversary proposed, beside what the program draws"]
    for column in columns:
        rows = [[column.title, "program", *PERIODS, "score"]]
        for k, name in enumerate(column.names):
            numbers = [column.program[k], *column.proposed[:, k]]
            rows.append([name, *(f"{number:.1%}" for number in numbers), f"{column.score[k]:.2f}"])
        parts.append(align(rows))
    return "\n\n".join(parts).replace("nan%", "–").replace("nan", "–")
