"""An adversary's proposals by column of θ, compared with the program's distribution; read from a run's levels.

Read next: `commands.inspect`, which prints it; `pictures.level_plots`, which draws it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.results import align
from ued.core.cells import Cells
from ued.core.parameters import Parameter, axis_of, choice_in
from ued.levels.table import table_of
from ued.recorder.shades import unique_names

PERIODS = {"first tenth": (0.0, 0.1), "middle": (0.45, 0.55), "last tenth": (0.9, 1.0)}  # shares of a run's updates
DECILES = 10
AT_ONCE = 32  # columns of θ in memory, since a long run has millions of levels with hundreds of columns


class ColumnOfProposals(NamedTuple):
    """One column of θ, with K values or tenths of its range.

    Attributes:
        title: name of the column.
        names: names of the values `[K]`.
        choice: False for tenths of a range.
        program: shares in random levels `[K]`.
        proposed: shares in the adversary's levels of each period `[P, K]`; nan without levels.
        score: mean reward of the adversary (PAIRED: regret) over all levels with the value `[K]`; nan without levels.
    """

    title: str
    names: tuple[str, ...]
    choice: bool
    program: np.ndarray
    proposed: np.ndarray
    score: np.ndarray


def read_proposals(run: Path, draws: Sequence[Parameter]) -> list[ColumnOfProposals]:
    """Return a run's proposals by column. Raises `CommandError` for a run without proposals."""
    table, path = read_levels(run, "update", "source", "score"), table_of(run)
    proposed = table.get("source", np.zeros(0, str)) == "proposed"
    if not proposed.any():
        raise CommandError(f"{run} has no levels proposed by an adversary: {path} has no row with source 'proposed'")
    columns, names = [], unique_names(draws)
    for begin in range(0, len(names), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        values = read_levels(run, *(f"theta/{name}" for name in names[some]))
        for name, draw in zip(names[some], draws[some], strict=True):
            if f"theta/{name}" not in values:
                raise CommandError(f"{path} has no column theta/{name}: it belongs to another program")
            columns.append(_column(name, draw, table | values, proposed))
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
    """Return which updates overlap with a period of the run: bool, same shape."""
    count = update.max(initial=1.0)
    return (update > period[0] * count) & (update - 1 < period[1] * count)


def _shares(index: np.ndarray, count: int) -> np.ndarray:
    return np.bincount(index, minlength=count) / len(index) if len(index) else np.full(count, np.nan)


def _tenths(draw: Parameter) -> tuple[str, ...]:
    """Return the ends of the tenths of a real parameter's range, or of θ if the range is not finite."""
    axis = axis_of(draw)
    ends = np.linspace(axis.low, axis.high, DECILES + 1)
    if not np.isfinite(ends).all():
        ends = np.linspace(-1.0, 1.0, DECILES + 1)
    return tuple(f"{low:.4g} to {high:.4g}" for low, high in pairwise(ends))


def render_proposals(run: Path, columns: Sequence[ColumnOfProposals]) -> str:
    """Return the columns as tables: shares of each value in random levels, and in proposals by period."""
    parts = [f"{run}: proposals of the adversary, and the program's distribution"]
    for column in columns:
        rows = [[column.title, "program", *PERIODS, "score"]]
        for k, name in enumerate(column.names):
            numbers = [column.program[k], *column.proposed[:, k]]
            rows.append([name, *(f"{number:.1%}" for number in numbers), f"{column.score[k]:.2f}"])
        parts.append(align(rows))
    return "\n\n".join(parts).replace("nan%", "–").replace("nan", "–")
