"""Ranks of scores that are updated when a few scores change, since sorting all scores of a large buffer is slow.

Read next: `levels.buffer`, whose priorities follow ranks.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

FEW = 64  # minimum ratio of unchanged to changed scores for updating the order instead of sorting


class Ranking:
    """Rows in descending order of scores; ties are in the order of rows."""

    def __init__(self) -> None:
        self.order = np.zeros(0, np.int64)  # [n] rows, the highest score first
        self._keys = np.zeros(0)  # [n] their negated scores, in ascending order

    def update(self, scores: np.ndarray, changed: Collection[int]) -> np.ndarray:
        """Return the order `[n]` of these scores `[n]`.

        Only the scores of the rows `changed`, which include new rows, differ from the scores of the last call.
        """
        if len(scores) < FEW * len(changed) or not len(self.order):
            self.order = np.argsort(-scores, kind="stable")
            self._keys = -scores[self.order]
        elif changed:
            self._mend(scores, np.sort(np.fromiter(changed, np.int64, len(changed))))
        return self.order

    def _mend(self, scores: np.ndarray, rows: np.ndarray) -> None:
        """Move these sorted rows `[k]` to the places of their new scores."""
        keys = -scores[rows]
        by_key = np.argsort(keys, kind="stable")
        rows, keys = rows[by_key], keys[by_key]
        stays = np.ones(len(scores), bool)
        stays[rows] = False
        kept = stays[self.order]
        order, others = self.order[kept], self._keys[kept]
        first, last = (np.searchsorted(others, keys, side) for side in ("left", "right"))
        spans = zip(first, last, rows, strict=True)  # rows of the same score, ordered by row
        places = [low + np.searchsorted(order[low:high], row) for low, high, row in spans]
        self.order, self._keys = np.insert(order, places, rows), np.insert(others, places, keys)
