"""How a column of θ with finitely many values shares [-1, 1] among them: a cell for each, as wide as it is likely.

Read next: `parameters`, which says what the columns are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Cells:
    """How the K values of a column share [-1, 1]: the wider a cell, the more of the random levels have its value.

    Attributes:
        count: K.
        edges: `[K + 1]`, from -1 to 1; None: all cells are equally wide.
        ordered: whether neighbors in θ are alike, as integers are and options are not.
        names: of the values, as far as they are known.
    """

    count: int
    edges: np.ndarray | None = None
    ordered: bool = False
    names: tuple[str, ...] = ()

    @property
    def shares(self) -> np.ndarray:
        """Return the probability of each value in random levels: `[K]`."""
        return np.full(self.count, 1 / self.count) if self.edges is None else np.diff(self.edges) / 2

    def index(self, theta: Any) -> Any:
        """Return which value each entry of θ stands for: int, of the same shape."""
        if self.edges is None:
            return index_in(theta, self.count)
        return np.searchsorted(self.edges[1:-1], theta, side="right")

    def middle(self, index: Any) -> Any:
        """Return the middle of the cells with these indices."""
        if self.edges is None:
            return middle_of(index, self.count)
        return (self.edges[index] + self.edges[np.add(index, 1)]) / 2


def cut(count: int, weights: Sequence[float] = (), ordered: bool = False, names: Sequence[str] = ()) -> Cells:
    """Return [-1, 1] cut by these weights, which may have any sum; none: evenly."""
    if not len(weights) or min(weights) == max(weights):
        return Cells(count, None, ordered, tuple(names))
    ends = np.cumsum(np.asarray(weights, float) / np.max(weights))
    return Cells(count, np.concatenate([[-1.0], 2 * ends / ends[-1] - 1]), ordered, tuple(names))


def index_in(theta: np.ndarray | float, cells: np.ndarray | int) -> np.ndarray:
    """Return which value each entry of θ `[..., D]` stands for, of columns cut evenly (none into 0): int `[..., D]`."""
    return np.minimum(np.asarray((theta + 1) / 2 * cells).astype(np.int64), cells - 1)


def middle_of(index: Any, cells: Any) -> Any:
    """Return the middle of equally wide cells with these indices, numbers or arrays `[..., D]`: the θ of a value."""
    return (2 * index + 1) / cells - 1
