"""Cells of a column of θ with finitely many values: parts of [-1, 1] whose widths follow the values' probabilities.

Read next: `parameters`, the kinds of columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Cells:
    """The cells of the K values of a column in [-1, 1]; wider cells have more probable values in random levels.

    Attributes:
        count: K.
        edges: `[K + 1]`, from -1 to 1; None: cells of equal width.
        ordered: whether neighboring values are similar, as those of integers are and options are not.
        names: names of the values, if known.
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
        """Return the index of the value of each entry of θ: int, of the same shape."""
        if self.edges is None:
            return index_in(theta, self.count)
        return np.searchsorted(self.edges[1:-1], theta, side="right")

    def middle(self, index: Any) -> Any:
        """Return the centers of the cells with these indices."""
        if self.edges is None:
            return bin_center(index, self.count)
        return (self.edges[index] + self.edges[np.add(index, 1)]) / 2


def cut(count: int, weights: Sequence[float] = (), ordered: bool = False, names: Sequence[str] = ()) -> Cells:
    """Return the cells of [-1, 1] for these weights, which may have any sum; without weights, of equal width."""
    if not len(weights) or min(weights) == max(weights):
        return Cells(count, None, ordered, tuple(names))
    ends = np.cumsum(np.asarray(weights, float) / np.max(weights))
    return Cells(count, np.concatenate([[-1.0], 2 * ends / ends[-1] - 1]), ordered, tuple(names))


def names_of(values: Sequence[Any]) -> list[str]:
    """Return a name on one line for each option; options with the same text also have their index."""
    names = [" ".join(str(value).split()) for value in values]
    return [f"{name} [{index}]" if names.count(name) > 1 else name for index, name in enumerate(names)]


def index_in(theta: np.ndarray | float, num_bins: np.ndarray | int) -> np.ndarray:
    """Return the index of the value of each entry of θ `[..., D]`, for cells of equal width: int `[..., D]`."""
    return np.minimum(np.asarray((theta + 1) / 2 * num_bins).astype(np.int64), num_bins - 1)


def bin_center(index: Any, num_bins: Any) -> Any:
    """Return the centers of cells of equal width with these indices, numbers or arrays `[..., D]`."""
    return (2 * index + 1) / num_bins - 1
